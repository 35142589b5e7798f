//! Commands that show a file's events.

use anyhow::{Context, Result};
use inhand_export::events;
use inhand_model::Event;
use inhand_session::annotate::{self, Annotated};
use serde_json::{Value, json};

use super::{ExportArgs, ListArgs};
use crate::console::{Console, print};
use crate::exit::Exit;

pub(super) fn list(args: &ListArgs) -> Result<Exit> {
    let annotated = annotate::read(&args.file)?;
    print(args.format, || text(&annotated), || to_json(&annotated))?;
    Ok(Exit::Done)
}

pub(super) fn export(console: &Console, args: &ExportArgs) -> Result<Exit> {
    args.output.check(&[&args.file])?;
    let annotated = annotate::read(&args.file)?;
    let mut csv = Vec::new();
    events::write(&annotated.own, annotated.start_unix_nanos, &mut csv)?;
    let csv = String::from_utf8(csv).context("labels are text")?;
    args.output.write(console, &csv)?;
    Ok(Exit::Done)
}

/// All events with their numbers; those of other topics have none, since they are not ours to change.
fn numbered(annotated: &Annotated) -> impl Iterator<Item = (Option<usize>, &Event)> {
    let own = annotated.own.events.iter().enumerate();
    let own = own.map(|(index, event)| (Some(index + 1), event));
    own.chain(annotated.others.iter().map(|event| (None, event)))
}

fn text(annotated: &Annotated) -> String {
    let mut text = String::new();
    for (key, value) in &annotated.own.about {
        text += &format!("{key:<10} {value}\n");
    }
    let start = annotated.start_unix_nanos;
    for (number, event) in numbered(annotated) {
        let number = number.map_or_else(|| "-".to_owned(), |n| n.to_string());
        let labels: Vec<String> = (event.labels.iter())
            .map(|(key, value)| format!("{key}={value}"))
            .collect();
        text += &format!(
            "{number:>4}  {:>12} .. {:<12}  {}\n",
            events::seconds_after(event.start_unix_nanos, start),
            events::seconds_after(event.end_unix_nanos, start),
            labels.join("  "),
        );
    }
    if text.is_empty() {
        text += "no events\n";
    }
    text
}

fn to_json(annotated: &Annotated) -> Value {
    let seconds = |unix_nanos: u64| {
        (i128::from(unix_nanos) - i128::from(annotated.start_unix_nanos)) as f64 / 1e9
    };
    let events = numbered(annotated).map(|(number, event)| {
        json!({
            "number": number,
            "start_s": seconds(event.start_unix_nanos),
            "end_s": seconds(event.end_unix_nanos),
            "start_unix_nanos": event.start_unix_nanos,
            "end_unix_nanos": event.end_unix_nanos,
            "labels": event.labels,
        })
    });
    json!({
        "start_unix_nanos": annotated.start_unix_nanos,
        "about": annotated.own.about,
        "events": events.collect::<Vec<_>>(),
    })
}
