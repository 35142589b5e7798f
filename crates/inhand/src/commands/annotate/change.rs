//! Commands that change a file's events.

use std::path::Path;

use anyhow::Result;
use inhand_export::events::{parse_instant, seconds_after};
use inhand_model::{Annotations, Event, Label};
use inhand_session::annotate::{self, Annotated, Vocabulary};
use inhand_session::check_target;

use super::{AboutArgs, AddArgs, EditArgs, ImportArgs, RemoveArgs, Target};
use crate::console::Console;
use crate::exit::{Exit, UsageError};

pub(super) fn add(console: &Console, args: &AddArgs) -> Result<Exit> {
    change(
        console,
        &args.file,
        &[],
        &args.target,
        |annotated, annotations| {
            let (start_unix_nanos, end_unix_nanos) = stretch(&args.at, annotated.start_unix_nanos)?;
            let labels = labels("--label", &args.label)?;
            note_keys(annotations, &labels);
            annotations.events.push(Event {
                start_unix_nanos,
                end_unix_nanos,
                labels: labels.into_iter().map(|l| (l.key, l.value)).collect(),
            });
            Ok("1 event added".to_owned())
        },
    )
}

pub(super) fn import(console: &Console, args: &ImportArgs) -> Result<Exit> {
    change(
        console,
        &args.file,
        &[&args.csv],
        &args.target,
        |annotated, annotations| {
            let given = annotate::read_csv(&args.csv, annotated)?;
            let count = given.events.len();
            if args.replace || annotations.events.is_empty() {
                annotations.keys = given.keys;
                annotations.events = given.events;
            } else {
                let new = given
                    .keys
                    .into_iter()
                    .filter(|key| !annotations.keys.contains(key));
                let new: Vec<String> = new.collect();
                annotations.keys.extend(new);
                annotations.events.extend(given.events);
            }
            Ok(counted(count, "event added", "events added"))
        },
    )
}

pub(super) fn edit(console: &Console, args: &EditArgs) -> Result<Exit> {
    if args.at.is_none() && args.label.is_empty() && args.remove_label.is_empty() {
        let message = "expected --at, --label or --remove-label: what to change";
        return Err(UsageError(message.to_owned()).into());
    }
    change(
        console,
        &args.file,
        &[],
        &args.target,
        |annotated, annotations| {
            check_number(args.event, annotations)?;
            let labels = labels("--label", &args.label)?;
            note_keys(annotations, &labels);
            let event = &mut annotations.events[args.event - 1];
            if let Some(at) = &args.at {
                let (start, end) = stretch(at, annotated.start_unix_nanos)?;
                (event.start_unix_nanos, event.end_unix_nanos) = (start, end);
            }
            for key in &args.remove_label {
                if event.labels.remove(key).is_none() {
                    let message = format!("--remove-label {key}: event {} has none", args.event);
                    return Err(UsageError(message).into());
                }
            }
            event
                .labels
                .extend(labels.into_iter().map(|l| (l.key, l.value)));
            Ok(format!("event {} changed", args.event))
        },
    )
}

pub(super) fn remove(console: &Console, args: &RemoveArgs) -> Result<Exit> {
    change(console, &args.file, &[], &args.target, |_, annotations| {
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
        let taken = before - annotations.events.len();
        Ok(counted(taken, "event taken out", "events taken out"))
    })
}

pub(super) fn about(console: &Console, args: &AboutArgs) -> Result<Exit> {
    change(console, &args.file, &[], &args.target, |_, annotations| {
        for fact in &args.set {
            let (key, value) = fact.split_once('=').unwrap_or((fact, ""));
            let (key, value) = (key.trim(), value.trim());
            if key.is_empty() || value.is_empty() {
                let message = format!("--set {fact}: expected KEY=VALUE, such as subject=s01");
                return Err(UsageError(message).into());
            }
            annotations.about.insert(key.to_owned(), value.to_owned());
        }
        for key in &args.unset {
            if annotations.about.remove(key).is_none() {
                let message = format!("--unset {key}: the file states no such fact");
                return Err(UsageError(message).into());
            }
        }
        let stated = annotations.about.len();
        Ok(counted(stated, "fact stated", "facts stated"))
    })
}

/// Reads a file's events, changes them and writes the file with them.
fn change(
    console: &Console,
    file: &Path,
    also_read: &[&Path],
    target: &Target,
    change: impl FnOnce(&Annotated, &mut Annotations) -> Result<String>,
) -> Result<Exit> {
    let inputs: Vec<&Path> = (also_read.iter().copied())
        .chain(target.vocabulary.as_deref())
        .chain([file])
        .collect();
    check_target(&target.output, &inputs, || target.force)?;
    let annotated = annotate::read(file)?;
    let mut annotations = annotated.own.clone();
    let done = change(&annotated, &mut annotations)?;
    if let Some(vocabulary) = &target.vocabulary {
        Vocabulary::read(vocabulary)?.check(file, &annotations.events)?;
    }
    annotate::write(file, &target.output, &annotated, &annotations)?;
    for event in annotations
        .events
        .iter()
        .filter(|event| annotated.is_outside(event))
    {
        let start = seconds_after(event.start_unix_nanos, annotated.start_unix_nanos);
        console.say(&format!(
            "warning  the event at {start} s lies outside the take"
        ));
    }
    console.say(&format!("wrote {} ({done})", target.output.display()));
    Ok(Exit::Done)
}

/// `FROM..TO` or one instant, as nanoseconds since 1970.
fn stretch(text: &str, origin: u64) -> Result<(u64, u64), UsageError> {
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

fn labels(flag: &str, texts: &[String]) -> Result<Vec<Label>, UsageError> {
    let parse = |text: &String| text.parse().map_err(|e| UsageError(format!("{flag}: {e}")));
    texts.iter().map(parse).collect()
}

/// Tables show keys in the order in which they were first used.
fn note_keys(annotations: &mut Annotations, labels: &[Label]) {
    for label in labels {
        if !annotations.keys.contains(&label.key) {
            annotations.keys.push(label.key.clone());
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
