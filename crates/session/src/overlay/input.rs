//! Input of an overlay: takes, their names, their time lines.

use std::path::Path;

use inhand_channels::ReadMethod;
use inhand_evaluation::overlay::{moved, offsets_nanos};
use inhand_model::{Clock, Event, Label, Protocol, Shape, StartTime};

use super::{Align, OverlayMethods, OverlayOptions};
use crate::error::{Located, SessionError, invalid};
use crate::files::{open_take, take_name};
use crate::output::same_file;
use crate::settings::Settings;
use crate::take::{Take, same_motion, same_source};

/// Topic of a dictionary's own message.
const DICTIONARY: &str = "/dictionary/model";

/// A take and what else is shown of its file.
pub(super) struct Input {
    pub(super) name: String,
    pub(super) take: Take,
    pub(super) methods: Vec<ReadMethod>,
    pub(super) shape: Option<Shape>,
    /// Its time line among those of the others.
    pub(super) clock: Clock,
    /// By how much that is moved.
    pub(super) offset_nanos: i128,
}

pub(super) fn read(
    options: &OverlayOptions,
    settings: &[Settings],
) -> Result<Vec<Input>, SessionError> {
    let paths = &options.inputs;
    if paths.is_empty() || paths.len() == 1 && options.methods == OverlayMethods::None {
        let expected = "two or more, or one with --methods";
        return Err(invalid("takes", expected, &paths.len()));
    }
    for (n, path) in paths.iter().enumerate() {
        if paths[..n].iter().any(|other| same_file(other, path)) {
            let found = format!("{} twice", path.display());
            return Err(invalid("takes", "each file once", &found));
        }
    }
    if options.names.len() > paths.len() {
        let expected = format!("at most one for each of {} takes", paths.len());
        return Err(invalid("name", &expected, &options.names.len()));
    }
    let names = names(paths.iter().map(AsRef::as_ref), &options.names);
    for (n, name) in names.iter().enumerate() {
        let fits = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if name.is_empty() || !name.chars().all(fits) || names[..n].contains(name) {
            let expected = "letters, digits, '_' and '-', another for each take";
            return Err(invalid("name", expected, &format!("\"{name}\"")));
        }
    }
    (paths.iter().zip(names).zip(settings))
        .map(|((path, name), settings)| read_one(path, name, options, settings))
        .collect()
}

fn read_one(
    path: &Path,
    name: String,
    options: &OverlayOptions,
    settings: &Settings,
) -> Result<Input, SessionError> {
    let refuse = |message: &str| SessionError::data(path, message);
    let mut methods = Vec::new();
    if let Some(mut source) = open_take(path, &path.display().to_string())? {
        let channels = inhand_container::channels(&mut source).in_file(path)?;
        if channels.iter().any(|c| c.topic == DICTIONARY) {
            return Err(refuse("a dictionary: takes are put over each other"));
        }
        let generated = channels.iter().any(|c| c.topic.starts_with("/generated/"));
        if generated && options.methods != OverlayMethods::None {
            methods = inhand_channels::generated_of_source(&mut source, Protocol::Published)
                .in_file(path)?;
        }
    }
    let take = crate::take::read(path, settings)?;
    if take.recording.is_empty() {
        return Err(refuse("no samples: there is nothing to compare"));
    }
    Ok(Input {
        name,
        clock: take.recording.clock,
        offset_nanos: 0,
        take,
        methods,
        shape: settings.shape()?,
    })
}

/// Names from files that fit into topics, each another: with the folder in front where files have the
/// same name, and a number behind where that does not help.
fn names<'a>(paths: impl Iterator<Item = &'a Path>, given: &[String]) -> Vec<String> {
    let paths: Vec<&Path> = paths.collect();
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let safe = |text: String| text.replace(|c| !fits(c), "_");
    let stems: Vec<String> = paths.iter().map(|path| safe(take_name(path))).collect();
    let mut names: Vec<String> = Vec::with_capacity(paths.len());
    for (n, path) in paths.iter().enumerate() {
        if let Some(name) = given.get(n) {
            names.push(name.clone());
            continue;
        }
        let shared = stems.iter().filter(|&stem| *stem == stems[n]).count() > 1;
        let folder = path.parent().and_then(Path::file_name).filter(|_| shared);
        let name = match folder {
            Some(folder) => format!("{}_{}", safe(folder.to_string_lossy().into()), stems[n]),
            None => stems[n].clone(),
        };
        let numbered = (2..).map(|number| format!("{name}_{number}"));
        let free = std::iter::once(name.clone())
            .chain(numbered)
            .find(|name| !names.contains(name));
        names.push(free.unwrap_or(name));
    }
    names
}

/// Moves time lines so that each meets that of the first; gives by what, in a word.
pub(super) fn align(
    inputs: &mut [Input],
    align: &Align,
    notes: &mut Vec<String>,
) -> Result<String, SessionError> {
    let starts: Vec<u64> = (inputs.iter())
        .map(|input| input.take.recording.clock.start_unix_nanos())
        .collect();
    let (word, anchors) = match align {
        Align::Start => ("start".to_owned(), starts.clone()),
        Align::Clock => ("clock".to_owned(), vec![0; inputs.len()]),
        Align::Event(label) => {
            let anchors = inputs.iter().map(|input| anchor(input, label));
            (format!("event {label}"), anchors.collect::<Result<_, _>>()?)
        }
        Align::Auto if of_one_time(inputs) => ("clock".to_owned(), vec![0; inputs.len()]),
        Align::Auto => ("start".to_owned(), starts.clone()),
    };
    for (input, offset) in inputs.iter_mut().zip(offsets_nanos(&starts, &anchors)) {
        input.offset_nanos = offset;
    }
    check_overlap(inputs, &word)?;
    notes.push(match (align, &*word) {
        (Align::Auto, "clock") if inputs.len() == 1 => "by the clock: one take".to_owned(),
        (Align::Auto, "clock") => "by the clock: one take, or takes of one time".to_owned(),
        (Align::Auto, _) => "by the start: takes of different times".to_owned(),
        _ => format!("by the {word}"),
    });
    for input in inputs {
        let offset = input.offset_nanos;
        if offset != 0 {
            let seconds = offset as f64 * 1e-9;
            notes.push(format!("{} is moved by {seconds:+.6} s", input.name));
        }
        input.clock = moved(input.clock, offset).ok_or_else(|| {
            let message = "its times, moved to those of the others, lie outside those that files \
                           can state; --align start";
            input.take.error(message.to_owned())
        })?;
    }
    Ok(word)
}

/// Whether times of all files tell where they lie to each other.
fn of_one_time(inputs: &[Input]) -> bool {
    let Some((first, others)) = inputs.split_first() else {
        return true;
    };
    let stated = |input: &Input| input.take.recording.clock.start_time() != StartTime::Unknown;
    others.iter().all(|other| {
        let overlap = stated(first) && stated(other) && meets(first, other);
        overlap || same_source(&first.take, &other.take) || same_motion(&first.take, &other.take)
    })
}

/// Whether two moved time lines have a time in common.
fn meets(a: &Input, b: &Input) -> bool {
    let span = |input: &Input| {
        let clock = input.take.recording.clock;
        let last = input.take.recording.len().saturating_sub(1);
        [0, last].map(|k| i128::from(clock.unix_nanos(k)) + input.offset_nanos)
    };
    let ([a_start, a_end], [b_start, b_end]) = (span(a), span(b));
    a_start <= b_end && b_start <= a_end
}

fn check_overlap(inputs: &[Input], word: &str) -> Result<(), SessionError> {
    let first = &inputs[0];
    let apart = inputs.iter().find(|input| !meets(first, input));
    let Some(input) = apart else {
        return Ok(());
    };
    Err(input.take.error(format!(
        "by the {word} no part of it lies at the time of {}: --align start lets both begin together",
        first.take.path.display()
    )))
}

/// When the first event with this label starts.
fn anchor(input: &Input, label: &Label) -> Result<u64, SessionError> {
    let events = &input.take.annotations.events;
    let with = events.iter().filter(|event| event.has(label));
    let start = with.map(|event| event.start_unix_nanos).min();
    start.ok_or_else(|| {
        let labels = |event: &Event| -> Vec<String> {
            let labels = event.labels.iter();
            labels
                .map(|(key, value)| Label::new(key, value).to_string())
                .collect()
        };
        let mut known: Vec<String> = events.iter().flat_map(labels).collect();
        known.sort();
        known.dedup();
        let known = match known.len() {
            0 => "it has no events (`inhand annotate` adds them)".to_owned(),
            _ => format!("its events are {}", known.join(", ")),
        };
        input
            .take
            .error(format!("no event {label} to align by: {known}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_files_and_each_another() {
        let paths = [
            "run1/take.mcap",
            "run2/take.mcap",
            "b/grasp 3.mcap",
            "run1/take.tsv",
        ];
        let given = |names: &[&str]| names.iter().map(|&n| n.to_owned()).collect::<Vec<_>>();
        let of = |given: &[String]| names(paths.iter().map(Path::new), given);
        assert_eq!(
            of(&[]),
            ["run1_take", "run2_take", "grasp_3", "run1_take_2"]
        );
        assert_eq!(
            of(&given(&["fast", "slow"])),
            ["fast", "slow", "grasp_3", "run1_take"]
        );
    }
}
