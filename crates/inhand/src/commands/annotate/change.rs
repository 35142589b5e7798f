//! Commands that change a file's events.

use std::path::PathBuf;

use anyhow::Result;
use inhand_export::events::{parse_instant, seconds_after};
use inhand_model::{Annotations, Event};
use inhand_session::annotate::{self, Annotated, Vocabulary};

use super::{AboutArgs, AddArgs, EditArgs, ImportArgs, RemoveArgs, Target};
use crate::console::Console;
use crate::exit::{Exit, UsageError, usage};
use crate::options::labels;

pub(super) fn add(console: &Console, args: &AddArgs) -> Result<Exit> {
    args.target.change(console, None, |annotated, annotations| {
        let (start_unix_nanos, end_unix_nanos) = interval(&args.at, annotated.start_unix_nanos)?;
        let labels = labels("--label", &args.label)?;
        (labels.iter()).for_each(|label| note_key(annotations, &label.key));
        annotations.events.push(Event {
            start_unix_nanos,
            end_unix_nanos,
            labels: labels.into_iter().map(|l| (l.key, l.value)).collect(),
        });
        Ok("1 event added".to_owned())
    })
}

pub(super) fn import(console: &Console, args: &ImportArgs) -> Result<Exit> {
    args.target
        .change(console, Some(&args.csv), |annotated, annotations| {
            let given = annotate::read_csv(&args.csv, annotated)?;
            let count = given.events.len();
            if args.replace || annotations.events.is_empty() {
                annotations.keys = given.keys;
                annotations.events = given.events;
            } else {
                for key in given.keys {
                    note_key(annotations, &key);
                }
                annotations.events.extend(given.events);
            }
            Ok(counted(count, "event added", "events added"))
        })
}

pub(super) fn edit(console: &Console, args: &EditArgs) -> Result<Exit> {
    if args.at.is_none() && args.label.is_empty() && args.remove_label.is_empty() {
        return usage("expected --at, --label or --remove-label: what to change");
    }
    args.target.change(console, None, |annotated, annotations| {
        check_number(args.event, annotations)?;
        let labels = labels("--label", &args.label)?;
        (labels.iter()).for_each(|label| note_key(annotations, &label.key));
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
        event
            .labels
            .extend(labels.into_iter().map(|l| (l.key, l.value)));
        Ok(format!("event {} changed", args.event))
    })
}

pub(super) fn remove(console: &Console, args: &RemoveArgs) -> Result<Exit> {
    args.target.change(console, None, |_, annotations| {
        for &number in &args.event {
            check_number(number, annotations)?;
        }
        let labels = labels("--label", &args.label)?;
        let before = annotations.events.len();
        let mut number = 0;
        annotations.events.retain(|event| {
            number += 1;
            !args.event.contains(&number) && !labels.iter().any(|label| event.has(label))
        });
        let removed = before - annotations.events.len();
        Ok(counted(removed, "event removed", "events removed"))
    })
}

pub(super) fn about(console: &Console, args: &AboutArgs) -> Result<Exit> {
    args.target.change(console, None, |_, annotations| {
        for fact in &args.set {
            let (key, value) = fact.split_once('=').unwrap_or((fact, ""));
            let (key, value) = (key.trim(), value.trim());
            if key.is_empty() || value.is_empty() {
                return usage(format!(
                    "--set {fact}: expected KEY=VALUE, such as subject=s01"
                ));
            }
            annotations.about.insert(key.to_owned(), value.to_owned());
        }
        for key in &args.unset {
            if annotations.about.remove(key).is_none() {
                return usage(format!("--unset {key}: the file states no such fact"));
            }
        }
        let stated = annotations.about.len();
        Ok(counted(stated, "fact stated", "facts stated"))
    })
}

impl Target {
    /// Reads the file's events, changes them and writes the file with them.
    fn change(
        &self,
        console: &Console,
        also_read: Option<&PathBuf>,
        change: impl FnOnce(&Annotated, &mut Annotations) -> Result<String>,
    ) -> Result<Exit> {
        let read = [&self.file]
            .into_iter()
            .chain(also_read)
            .chain(&self.vocabulary);
        self.output.check(&read.collect::<Vec<_>>())?;
        let (file, output) = (&self.file, &self.output.output);
        let annotated = annotate::read(file)?;
        let mut annotations = annotated.own.clone();
        let done = change(&annotated, &mut annotations)?;
        if let Some(vocabulary) = &self.vocabulary {
            Vocabulary::read(vocabulary)?.check(file, &annotations.events)?;
        }
        annotate::write(file, output, &annotated, &annotations)?;
        for event in annotations
            .events
            .iter()
            .filter(|event| annotated.is_outside(event))
        {
            let start = seconds_after(event.start_unix_nanos, annotated.start_unix_nanos);
            console.say(&format!(
                "warning  the event at {start} s is outside the take"
            ));
        }
        console.say(&format!("wrote {} ({done})", output.display()));
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

/// Adds a key to those of the table, which shows them in the order of their first use.
fn note_key(annotations: &mut Annotations, key: &str) {
    if !annotations.keys.iter().any(|known| known == key) {
        annotations.keys.push(key.to_owned());
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
