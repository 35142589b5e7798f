//! MCAP files of any origin, cut, filtered, merged and recovered, with files at both ends.
//!
//! A file that holds a take stays one where that is possible: see [`cut`] and [`merge`].

use std::fs::File;
use std::io::BufReader;
use std::ops::Range;
use std::path::Path;

use inhand_channels::{Metadata, cut_take, metadata_of_source};
use inhand_container::{
    ChannelFacts, Interval, Merge, Merged, MetadataRecord, Packing, Recovered, Reopened, Selected,
    Selection, Source,
};
use inhand_model::{Annotations, Event, Provenance};
use serde_json::json;

use crate::TOOL;
use crate::annotate::{self, Exchange};
use crate::error::{Located, SessionError};
pub use crate::files::{FileSource, filter, hash_file, open};
use crate::files::{RECORDING, name_of, take_start};
use crate::output::write_atomic;

/// An instant as a person says it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Instant {
    /// Seconds since the file's first message, or a take's first sample.
    SinceStart(f64),
    /// Nanoseconds since 1970-01-01 UTC.
    Utc(u64),
}

/// A file that was cut.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cut {
    /// What the output holds and what was left out.
    pub selected: Selected,
    /// Samples of the take that the output is a take of; `None` where the file holds no take.
    pub samples: Option<Range<usize>>,
}

/// The interval of a file between two instants, each of which may be open.
///
/// # Errors
///
/// [`SessionError::Settings`] for an instant that is no time, [`SessionError::At`].
pub fn interval(
    path: &Path,
    from: Option<Instant>,
    to: Option<Instant>,
) -> Result<Interval, SessionError> {
    let mut source = open(path)?;
    let start = match take_start(&metadata_of_source(&mut source).in_file(path)?) {
        Some(start) => start,
        None => {
            let span = inhand_container::span(&mut source).in_file(path)?;
            span.map_or(0, |(start, _)| start)
        }
    };
    let unix_nanos = |key: &str, instant: Instant| match instant {
        Instant::Utc(unix_nanos) => Ok(unix_nanos),
        // Beyond any time there is it is the end of time.
        Instant::SinceStart(s) if s.is_finite() => {
            let nanos = (s.abs() * 1e9).round() as u64;
            Ok(match s < 0.0 {
                true => start.saturating_sub(nanos),
                false => start.saturating_add(nanos),
            })
        }
        Instant::SinceStart(s) => Err(SessionError::Settings {
            key: key.to_owned(),
            expected: "a number of seconds".to_owned(),
            found: s.to_string(),
        }),
    };
    let from = from.map_or(Ok(0), |instant| unix_nanos("from", instant))?;
    let to = to.map(|instant| unix_nanos("to", instant)).transpose()?;
    if to.is_some_and(|to| to <= from) {
        return Err(SessionError::Settings {
            key: "--to".to_owned(),
            expected: "a time after --from".to_owned(),
            found: "an earlier one".to_owned(),
        });
    }
    Ok(Interval::new(from, to))
}

const NOTHING_KEPT: &str = "no message is in that range; a time is given in seconds since the start, as UTC or in \
                            nanoseconds since 1970, and `inhand info` prints start and end";

/// Writes intervals of a file.
///
/// What stays is byte for byte as it was, but for messages that still hold at the start of an interval
/// and were sent before it (static transforms): these get the time of its first message. Of a take the
/// samples nearest to the ends count, its metadata state what is left, with the cut as a step of its
/// making, and what counts samples of the whole take (generated trajectories, their evaluation) is
/// left out; so the output is the take that [`inhand_model::Recording::slice`] gives.
///
/// # Errors
///
/// [`SessionError::At`] with the byte at which a file is wrong, [`SessionError::At`]
/// where the intervals are not one interval of a take, [`SessionError::Io`].
pub fn cut(input: &Path, output: &Path, intervals: &[Interval]) -> Result<Cut, SessionError> {
    let mut source = open(input)?;
    let metadata = metadata_of_source(&mut source).in_file(input)?;
    let take = match metadata.is_take() {
        true => {
            let made = cut_provenance(input, intervals)?;
            cut_take(&metadata, &name_of(input), intervals, &made).in_file(input)?
        }
        false => None,
    };
    let keep = (take.as_ref()).map_or_else(|| intervals.to_vec(), |take| vec![take.keep]);
    // Messages of events that begin before what is kept are outside of it.
    let events = events_into(input, &metadata, &keep)?;
    let exchange = |(events, ros2): (Annotations, bool)| {
        Exchange::new(&metadata, true, (&events, ros2), None).in_file(input)
    };
    let events = events.map(exchange).transpose()?;
    let of_part = take.as_ref().is_some_and(|take| !take.whole);
    let stays = |channel: &ChannelFacts| {
        !(of_part && inhand_channels::is_of_whole_take(channel))
            && events.as_ref().is_none_or(|events| events.keeps(channel))
    };
    let mut selection = Selection {
        keep,
        channels: (of_part || events.is_some()).then_some(&stays),
        // Overlays and bags that were given views have what is sent once as takes do.
        latch: &inhand_channels::latch,
        append: events.as_ref().and_then(|events| events.append.as_deref()),
        ..Selection::default()
    };
    if let Some(events) = &events {
        selection.replace.extend(events.replace.clone());
        selection.add.extend(events.add.clone());
    }
    if let Some(take) = &take {
        selection.replace.extend(take.replace.clone());
        selection.add.extend(take.add.clone());
    }
    let mut selected = Selected::default();
    write_atomic(output, |out| {
        selected = inhand_container::select(&mut source, out, &selection).in_file(input)?;
        let has_others = selected.left_out > 0 || selected.chunks_skipped > 0;
        match selected.written.messages == 0 && has_others {
            true => Err(SessionError::usage(input, NOTHING_KEPT)),
            false => Ok(()),
        }
    })?;
    // Events that were written anew are not lost.
    selected.left_out = selected.left_out.saturating_sub(selected.appended);
    Ok(Cut {
        selected,
        samples: take.map(|take| take.samples),
    })
}

fn cut_provenance(input: &Path, intervals: &[Interval]) -> Result<Provenance, SessionError> {
    let settings: Vec<_> = (intervals.iter())
        .map(|interval| {
            json!({
                "from_unix_nanos": interval.from_unix_nanos(),
                "to_unix_nanos": interval.to_unix_nanos(),
            })
        })
        .collect();
    Ok(Provenance {
        tool: TOOL.to_owned(),
        step: "cut".to_owned(),
        settings_json: json!({ "keep": settings }).to_string(),
        inputs: vec![hash_file(input)?],
    })
}

/// The events that lie in any of the intervals, if some of them begin before: their messages then lie
/// outside. `None` where messages tell it all.
fn events_into(
    input: &Path,
    metadata: &Metadata,
    intervals: &[Interval],
) -> Result<Option<(Annotations, bool)>, SessionError> {
    if !metadata.0.contains_key("inhand.annotations") {
        return Ok(None);
    }
    let read = annotate::read(input)?;
    let mut annotations = read.own;
    let meets = |event: &Event, interval: &Interval| {
        event.end_unix_nanos >= interval.from_unix_nanos()
            && (interval.to_unix_nanos()).is_none_or(|to| event.start_unix_nanos < to)
    };
    (annotations.events).retain(|event| intervals.iter().any(|interval| meets(event, interval)));
    let begins_inside = |event: &Event| {
        let start = event.start_unix_nanos;
        intervals.iter().any(|interval| interval.contains(start))
    };
    let all_inside = annotations.events.iter().all(begins_inside);
    Ok((!all_inside).then_some((annotations, read.ros2)))
}

/// Writes files as one, by time.
///
/// Of takes a file can hold one. With `keep_both`, the metadata of several are kept under names with
/// the name of their file behind them, so that the result does not pass for a take.
///
/// # Errors
///
/// [`SessionError::Data`] for several takes, [`SessionError::At`] for topics with different
/// schemas, both only without `keep_both`; what reading and writing can find.
pub fn merge(inputs: &[&Path], output: &Path, keep_both: bool) -> Result<Merged, SessionError> {
    let mut sources = Vec::with_capacity(inputs.len());
    let mut takes = Vec::new();
    for &input in inputs {
        let mut source = open(input)?;
        if metadata_of_source(&mut source).in_file(input)?.is_take() {
            takes.push(input);
        }
        if inputs.len() > Reopened::MOST_OPEN {
            let reader = BufReader::with_capacity(1 << 16, Reopened::new(input));
            source = Source::open(&name_of(input), reader).in_file(input)?;
        }
        sources.push(source);
    }
    if let [first, second, ..] = takes[..]
        && !keep_both
    {
        return Err(SessionError::data(
            second,
            format!(
                "a take, as is {}: a file can hold one take; --keep-both writes the channels of \
                 both into a file that is none",
                first.display()
            ),
        ));
    }
    let rename = |n: usize, record: MetadataRecord| match inputs.get(n) {
        Some(input) if takes.len() > 1 && record.name.starts_with("inhand.") => MetadataRecord {
            name: format!("{}@{}", record.name, name_of(input)),
            ..record
        },
        _ => record,
    };
    let settings = Merge {
        library: TOOL,
        keep_both,
        metadata: &rename,
        packing: Packing::Zstd,
    };
    let mut merged = Merged::default();
    write_atomic(output, |out| {
        merged = inhand_container::merge(sources, out, &settings).in_file(output)?;
        Ok(())
    })?;
    Ok(merged)
}

/// What a take of which something was lost has to say, so that samples without messages count as
/// missing when it is read.
fn recovered_take(recovered: &Recovered) -> Option<MetadataRecord> {
    let is_take = recovered.metadata.contains(RECORDING);
    let tells = (is_take && recovered.is_lossy()) || recovered.unverified > 0;
    tells.then(|| MetadataRecord {
        name: "inhand.recovered".to_owned(),
        facts: [
            ("lost_bytes".to_owned(), recovered.lost_bytes.to_string()),
            (
                "unverified_messages".to_owned(),
                recovered.unverified.to_string(),
            ),
            (
                "messages".to_owned(),
                recovered.written.messages.to_string(),
            ),
        ]
        .into(),
    })
}

/// Writes what can be saved of a damaged file, and reads it back before it is an output. What is left of
/// a take is a take: it ends with its last message, and samples whose messages are lost are missing.
///
/// # Errors
///
/// [`SessionError::At`] for a file of another kind, or an output that does not read back;
/// [`SessionError::Io`].
pub fn recover(
    input: &Path,
    output: &Path,
    keep_unverified: bool,
) -> Result<Recovered, SessionError> {
    let file = File::open(input).map_err(SessionError::io("read", input))?;
    let reader = BufReader::with_capacity(1 << 16, file);
    let mut recovered = Recovered::default();
    write_atomic(output, |out| {
        recovered = inhand_container::recover(
            &name_of(input),
            reader,
            &mut *out,
            keep_unverified,
            recovered_take,
        )
        .in_file(input)?;
        let written = out.get_ref().try_clone();
        let written = written.map_err(SessionError::io("read", output))?;
        let mut written =
            Source::open(&name_of(output), BufReader::new(written)).in_file(output)?;
        inhand_container::verify(&mut written, &recovered.written).in_file(output)
    })?;
    Ok(recovered)
}
