//! `inhand annotate VERB FILE`.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use inhand_export::events::{self, parse_instant, seconds_after};
use inhand_model::{Annotations, Event, Label};
use inhand_session::annotate::{self, Annotated, Vocabulary};
use serde_json::{Value, json};

use crate::console::{Console, print};
use crate::exit::{Exit, UsageError, usage};
use crate::options::{Format, pair};
use crate::output::{OutputFile, TextOutput};

/// Edit the events of an MCAP file of any origin.
///
/// Events are `foxglove.Event` messages, which viewers show, and in a ROS 2 bag the same as JSON in std_msgs/msg/String;
/// everything else in the file stays byte for byte.
/// Other commands select data by events (--event, --without).
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct Args {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, clap::Subcommand)]
enum Verb {
    /// Add an event
    Add(AddArgs),
    /// Add the events of a CSV file
    Import(ImportArgs),
    /// Change one event
    Edit(EditArgs),
    /// Remove events
    Remove(RemoveArgs),
    /// State facts about the whole take: subject, object, task, ...
    About(AboutArgs),
    /// Print events and facts
    List(ListArgs),
    /// Write events as CSV
    Export(ExportArgs),
}

/// The file to change, and the output.
#[derive(Debug, clap::Args)]
struct Target {
    /// An MCAP file.
    file: PathBuf,
    #[command(flatten)]
    output: OutputFile,
    /// Refuse labels that are not in this vocabulary: a TOML file with a line for each key, such as
    /// task = ["rotate", "lift"], or note = "any".
    #[arg(long, value_name = "FILE")]
    vocabulary: Option<PathBuf>,
}

/// Add an event: `--at 63.4..63.6 --label slip --label finger=index`.
#[derive(Debug, clap::Args)]
struct AddArgs {
    #[command(flatten)]
    target: Target,
    /// Start and end, both included, or one instant: seconds after the file's start, or times
    /// such as 2026-11-03T10:12:00Z; repeat for several events with the same labels.
    #[arg(
        long,
        value_name = "FROM..TO",
        required = true,
        allow_hyphen_values = true
    )]
    at: Vec<String>,
    /// A label as KEY=VALUE, or a word (short for label=WORD); repeat for more.
    #[arg(long, value_name = "LABEL", required = true)]
    label: Vec<Label>,
}

/// Add the events of a CSV file. Its first columns are start_s and end_s, seconds after the file's
/// start (or start_time and end_time, or BIDS's onset and duration); every other column is a label.
#[derive(Debug, clap::Args)]
struct ImportArgs {
    #[command(flatten)]
    target: Target,
    /// Events.
    csv: PathBuf,
    /// Remove the existing events first.
    #[arg(long)]
    replace: bool,
}

/// Change one event.
#[derive(Debug, clap::Args)]
struct EditArgs {
    #[command(flatten)]
    target: Target,
    /// Number of the event, as `annotate list` prints it.
    #[arg(long, value_name = "N")]
    event: usize,
    /// Its new times, as for `add`.
    #[arg(long, value_name = "FROM..TO", allow_hyphen_values = true)]
    at: Option<String>,
    /// A label to set; repeat for more.
    #[arg(long, value_name = "LABEL")]
    label: Vec<Label>,
    /// Key of a label to remove; repeat for more.
    #[arg(long, value_name = "KEY")]
    remove_label: Vec<String>,
}

/// Remove events, by number or by label.
#[derive(Debug, clap::Args)]
struct RemoveArgs {
    #[command(flatten)]
    target: Target,
    /// Number of an event, as `annotate list` prints it; repeat for more.
    #[arg(long, value_name = "N", required_unless_present = "label")]
    event: Vec<usize>,
    /// Every event with this label; repeat for any of several.
    #[arg(long, value_name = "LABEL")]
    label: Vec<Label>,
}

/// State facts about the whole take.
#[derive(Debug, clap::Args)]
struct AboutArgs {
    #[command(flatten)]
    target: Target,
    /// A fact, such as subject=s01; repeat for more.
    #[arg(long, value_name = "KEY=VALUE", required_unless_present = "unset", value_parser = pair)]
    set: Vec<(String, String)>,
    /// Key of a fact to remove; repeat for more.
    #[arg(long, value_name = "KEY")]
    unset: Vec<String>,
}

/// Print events and facts.
#[derive(Debug, clap::Args)]
struct ListArgs {
    /// An MCAP file.
    file: PathBuf,
    /// Print as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Write events as CSV that `annotate import` reads again.
#[derive(Debug, clap::Args)]
struct ExportArgs {
    /// An MCAP file.
    file: PathBuf,
    #[command(flatten)]
    output: TextOutput,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    match &args.verb {
        Verb::Add(args) => add(console, args),
        Verb::Import(args) => import(console, args),
        Verb::Edit(args) => edit(console, args),
        Verb::Remove(args) => remove(console, args),
        Verb::About(args) => about(console, args),
        Verb::List(args) => list(args),
        Verb::Export(args) => export(console, args),
    }
}

fn add(console: &Console, args: &AddArgs) -> Result<Exit> {
    args.target.change(console, None, |annotated, annotations| {
        note_keys(annotations, args.label.iter().map(|label| &label.key));
        let events = args.at.iter().map(|at| {
            let (start_unix_nanos, end_unix_nanos) = interval(at, annotated.start_unix_nanos)?;
            Ok(Event {
                start_unix_nanos,
                end_unix_nanos,
                labels: pairs(&args.label).collect(),
            })
        });
        let events = events.collect::<Result<Vec<_>>>()?;
        annotations.events.extend(events.iter().cloned());
        Ok((counted(events.len(), "event added", "events added"), events))
    })
}

fn import(console: &Console, args: &ImportArgs) -> Result<Exit> {
    args.target
        .change(console, Some(&args.csv), |annotated, annotations| {
            let given = annotate::read_csv(&args.csv, annotated)?;
            let events = given.events.clone();
            if args.replace || annotations.events.is_empty() {
                annotations.keys = given.keys;
                annotations.events = given.events;
            } else {
                note_keys(annotations, &given.keys);
                annotations.events.extend(given.events);
            }
            Ok((counted(events.len(), "event added", "events added"), events))
        })
}

fn edit(console: &Console, args: &EditArgs) -> Result<Exit> {
    if args.at.is_none() && args.label.is_empty() && args.remove_label.is_empty() {
        return usage("expected --at, --label or --remove-label: what to change");
    }
    args.target.change(console, None, |annotated, annotations| {
        check_number(args.event, annotations)?;
        note_keys(annotations, args.label.iter().map(|label| &label.key));
        let event = &mut annotations.events[args.event - 1];
        if let Some(at) = &args.at {
            let (start, end) = interval(at, annotated.start_unix_nanos)?;
            (event.start_unix_nanos, event.end_unix_nanos) = (start, end);
        }
        for key in &args.remove_label {
            if event.labels.remove(key).is_none() {
                return usage(format!(
                    "--remove-label {key}: event {} has none",
                    args.event
                ));
            }
        }
        event.labels.extend(pairs(&args.label));
        let given = Event {
            labels: pairs(&args.label).collect(),
            ..event.clone()
        };
        Ok((format!("event {} changed", args.event), vec![given]))
    })
}

fn remove(console: &Console, args: &RemoveArgs) -> Result<Exit> {
    args.target.change(console, None, |_, annotations| {
        for &number in &args.event {
            check_number(number, annotations)?;
        }
        for label in &args.label {
            if !annotations.events.iter().any(|event| event.has(label)) {
                return usage(format!(
                    "--label {label}: no event has it; `inhand annotate list` prints them"
                ));
            }
        }
        let before = annotations.events.len();
        let mut number = 0;
        annotations.events.retain(|event| {
            number += 1;
            !args.event.contains(&number) && !args.label.iter().any(|label| event.has(label))
        });
        let removed = before - annotations.events.len();
        Ok((
            counted(removed, "event removed", "events removed"),
            Vec::new(),
        ))
    })
}

fn about(console: &Console, args: &AboutArgs) -> Result<Exit> {
    args.target.change(console, None, |_, annotations| {
        annotations.about.extend(args.set.iter().cloned());
        for key in &args.unset {
            if annotations.about.remove(key).is_none() {
                return usage(format!("--unset {key}: the file states no such fact"));
            }
        }
        let stated = annotations.about.len();
        Ok((counted(stated, "fact stated", "facts stated"), Vec::new()))
    })
}

impl Target {
    /// Reads the file's events, changes them and writes the file with them. `change` says what it did and gives the
    /// events with the labels that were typed, which a vocabulary is for.
    fn change(
        &self,
        console: &Console,
        also_read: Option<&PathBuf>,
        change: impl FnOnce(&Annotated, &mut Annotations) -> Result<(String, Vec<Event>)>,
    ) -> Result<Exit> {
        let read = [&self.file]
            .into_iter()
            .chain(also_read)
            .chain(&self.vocabulary);
        self.output.check_mcap(&read.collect::<Vec<_>>())?;
        let (file, output) = (&self.file, &self.output.output);
        let annotated = annotate::read(file)?;
        let mut annotations = annotated.own.clone();
        let (mut done, given) = change(&annotated, &mut annotations)?;
        if let Some(vocabulary) = &self.vocabulary {
            Vocabulary::read(vocabulary)?.check(file, &given)?;
        }
        let write = |path: &Path| annotate::write(file, path, &annotated, &annotations);
        self.output.write(write)?;
        for event in &annotations.events {
            if let Some(odd) = annotated.odd_times(event) {
                let start = seconds_after(event.start_unix_nanos, annotated.start_unix_nanos);
                console.say(&format!("warning  the event at {start} s {odd}"));
            }
        }
        if annotated.ros2 && !annotations.events.is_empty() {
            done += "; events as std_msgs/msg/String on /annotations, which ROS tools read";
        }
        console.wrote_with(output, &done);
        Ok(Exit::Done)
    }
}

/// `FROM..TO` or one instant, as nanoseconds since 1970.
fn interval(text: &str, origin: u64) -> Result<(u64, u64), UsageError> {
    let wrong = |what: &str| {
        UsageError(format!(
            "--at {text}: expected {what}, such as 63.4..63.6 (seconds after the start) or 12.5"
        ))
    };
    let (from, to) = text.split_once("..").unwrap_or((text, text));
    let instant = |text: &str| parse_instant(text.trim(), origin);
    let (Some(from), Some(to)) = (instant(from), instant(to)) else {
        return Err(wrong("FROM..TO or one instant"));
    };
    if to < from {
        return Err(wrong("an end that is not before the start"));
    }
    Ok((from, to))
}

/// Keys and values of labels.
fn pairs(labels: &[Label]) -> impl Iterator<Item = (String, String)> {
    (labels.iter().cloned()).map(|label| (label.key, label.value))
}

/// Adds keys to those of the table, which shows them in the order of their first use.
fn note_keys<'a>(annotations: &mut Annotations, keys: impl IntoIterator<Item = &'a String>) {
    for key in keys {
        if !annotations.keys.contains(key) {
            annotations.keys.push(key.clone());
        }
    }
}

fn check_number(number: usize, annotations: &Annotations) -> Result<(), UsageError> {
    let count = annotations.events.len();
    if (1..=count).contains(&number) {
        return Ok(());
    }
    Err(UsageError(match count {
        0 => format!("--event {number}: the file has no event on /annotations"),
        _ => format!("--event {number}: expected 1 to {count}, as `annotate list` numbers them"),
    }))
}

fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

fn list(args: &ListArgs) -> Result<Exit> {
    let annotated = annotate::read(&args.file)?;
    print(args.format, || text(&annotated), || to_json(&annotated))?;
    Ok(Exit::Done)
}

fn export(console: &Console, args: &ExportArgs) -> Result<Exit> {
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
            seconds_after(event.start_unix_nanos, start),
            seconds_after(event.end_unix_nanos, start),
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
