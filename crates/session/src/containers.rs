//! MCAP files of any origin, cut, filtered, merged and recovered, with files at both ends.
//!
//! A file that holds a take stays one where that is possible: see [`cut`] and [`merge`].

mod take;

pub(crate) use take::sha256;

use std::fs::File;
use std::io::{BufReader, BufWriter, Write as _};
use std::ops::Range;
use std::path::Path;

use inhand_channels::Metadata;
use inhand_container::{
    ChannelFacts, ContainerError, Interval, Merge, Merged, MetadataRecord, Packing, Recovered,
    Selected, Selection, Source,
};
use inhand_model::{Annotations, Event};

use crate::annotate;
use crate::error::SessionError;
use crate::output::write_atomic;
use crate::run::TOOL;

/// The metadata record that makes a file a take.
pub(crate) const RECORDING: &str = "inhand.recording";

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

/// A file that is read record by record.
pub type FileSource = Source<BufReader<File>>;

/// Opens an MCAP file for reading record by record.
///
/// # Errors
///
/// [`SessionError::Io`], and [`SessionError::At`] for a file of another kind.
pub fn open(path: &Path) -> Result<FileSource, SessionError> {
    let file = File::open(path).map_err(SessionError::io("read", path))?;
    let reader = BufReader::with_capacity(1 << 16, file);
    Source::open(&name_of(path), reader).map_err(container(path))
}

pub(crate) fn name_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

pub(crate) fn container(path: &Path) -> impl Fn(ContainerError) -> SessionError {
    let path = path.to_owned();
    move |source| SessionError::at(path.display(), source)
}

/// The metadata of a file by name; nothing else of it is read.
fn metadata(source: &mut FileSource, path: &Path) -> Result<Metadata, SessionError> {
    let records = inhand_container::metadata(source).map_err(container(path))?;
    let facts = records
        .into_iter()
        .map(|record| (record.name, record.facts));
    Ok(Metadata(facts.collect()))
}

/// The stretch of a file between two instants, each of which may be open.
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
    let start = match metadata(&mut source, path)?.0.get(RECORDING) {
        Some(facts) => facts
            .get("start_unix_nanos")
            .and_then(|text| text.parse().ok()),
        None => None,
    };
    let start: u64 = match start {
        Some(start) => start,
        None => {
            let span = inhand_container::span(&mut source).map_err(container(path))?;
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

/// Writes stretches of a file.
///
/// What stays is byte for byte as it was, but for messages that still hold at the start of a stretch
/// and were sent before it (static transforms): these get the time of its first message. Of a take the
/// samples nearest to the ends count, its metadata state what is left, with the cut as a step of its
/// making, and what counts samples of the whole take (generated trajectories, their evaluation) is
/// left out; so the output is the take that [`inhand_model::Recording::slice`] gives.
///
/// # Errors
///
/// [`SessionError::At`] with the byte at which a file is wrong, [`SessionError::At`]
/// where the stretches are not one stretch of a take, [`SessionError::Io`].
pub fn cut(input: &Path, output: &Path, stretches: &[Interval]) -> Result<Cut, SessionError> {
    let mut source = open(input)?;
    let metadata = metadata(&mut source, input)?;
    let take = take::cut(input, &metadata, stretches)?;
    let of_stretch = |channel: &ChannelFacts| !inhand_channels::is_of_whole_take(channel);
    let selection = match &take {
        None => Selection {
            keep: stretches.to_vec(),
            // Overlays and bags that were given views have what is sent once as takes do.
            latch: &inhand_channels::latch,
            ..Selection::default()
        },
        Some(take) => Selection {
            keep: vec![take.keep],
            channels: (!take.whole).then_some(&of_stretch),
            latch: &inhand_channels::latch,
            replace: take.replace.clone(),
            add: take.add.clone(),
            ..Selection::default()
        },
    };
    let kept = &selection.keep;
    let reaching = events_into(input, &metadata, kept)?;
    let selected = match reaching {
        None => select(&mut source, input, output, &selection)?,
        Some(events) => {
            let folder = output
                .parent()
                .filter(|folder| !folder.as_os_str().is_empty());
            let scratch = tempfile::Builder::new()
                .prefix(".inhand-unfinished-")
                .tempdir_in(folder.unwrap_or(Path::new(".")))
                .map_err(SessionError::io("write", output))?;
            let cut = scratch.path().join("cut.mcap");
            let selected = select(&mut source, input, &cut, &selection)?;
            annotate::put(&cut, output, &annotate::read(&cut)?, &events, None)?;
            selected
        }
    };
    Ok(Cut {
        selected,
        samples: take.map(|take| take.samples),
    })
}

/// The events that lie in any of the stretches, if some of them begin before: their messages then lie
/// outside. `None` where messages tell it all.
fn events_into(
    input: &Path,
    metadata: &Metadata,
    stretches: &[Interval],
) -> Result<Option<Annotations>, SessionError> {
    if !metadata.0.contains_key("inhand.annotations") {
        return Ok(None);
    }
    let mut annotations = annotate::read(input)?.own;
    let meets = |event: &Event, stretch: &Interval| {
        event.end_unix_nanos >= stretch.from_unix_nanos()
            && (stretch.to_unix_nanos()).is_none_or(|to| event.start_unix_nanos < to)
    };
    (annotations.events).retain(|event| stretches.iter().any(|stretch| meets(event, stretch)));
    let begins_inside = |event: &Event| {
        let start = event.start_unix_nanos;
        stretches.iter().any(|stretch| stretch.contains(start))
    };
    let all_inside = annotations.events.iter().all(begins_inside);
    Ok((!all_inside).then_some(annotations))
}

/// Writes what `selection` keeps of a file, byte for byte.
///
/// # Errors
///
/// [`SessionError::At`] with the byte at which the file is wrong, [`SessionError::Io`].
pub fn filter(
    input: &Path,
    output: &Path,
    selection: &Selection<'_>,
) -> Result<Selected, SessionError> {
    select(&mut open(input)?, input, output, selection)
}

fn select(
    source: &mut FileSource,
    input: &Path,
    output: &Path,
    selection: &Selection<'_>,
) -> Result<Selected, SessionError> {
    let mut selected = Selected::default();
    write_atomic(output, |out| {
        selected = inhand_container::select(source, out, selection).map_err(container(input))?;
        Ok(())
    })?;
    Ok(selected)
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
    merge_as(TOOL, inputs, output, keep_both)
}

/// As [`merge`], with what the output says wrote it.
pub(crate) fn merge_as(
    library: &str,
    inputs: &[&Path],
    output: &Path,
    keep_both: bool,
) -> Result<Merged, SessionError> {
    let mut sources = Vec::with_capacity(inputs.len());
    let mut takes = Vec::new();
    for &input in inputs {
        let mut source = open(input)?;
        if metadata(&mut source, input)?.0.contains_key(RECORDING) {
            takes.push(input);
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
        library,
        keep_both,
        metadata: &rename,
        packing: Packing::Zstd,
    };
    let mut merged = Merged::default();
    write_atomic(output, |out| {
        merged = inhand_container::merge(sources, out, &settings).map_err(container(output))?;
        Ok(())
    })?;
    Ok(merged)
}

/// What a take of which something was lost has to say, so that samples without messages count as
/// missing when it is read.
fn recovered_take(metadata: &Metadata, recovered: &Recovered) -> Option<MetadataRecord> {
    let is_take = metadata.0.contains_key(RECORDING);
    (is_take && recovered.is_lossy()).then(|| MetadataRecord {
        name: "inhand.recovered".to_owned(),
        facts: [
            ("lost_bytes".to_owned(), recovered.lost_bytes.to_string()),
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
pub fn recover(input: &Path, output: &Path) -> Result<Recovered, SessionError> {
    let file = File::open(input).map_err(SessionError::io("read", input))?;
    let reader = BufReader::with_capacity(1 << 16, file);
    let folder = output
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let scratch = tempfile::Builder::new()
        .prefix(".inhand-unfinished-")
        .tempfile_in(folder.unwrap_or(Path::new(".")))
        .map_err(SessionError::io("write", output))?;
    let mut saved = BufWriter::with_capacity(1 << 20, scratch.as_file());
    let mut recovered = inhand_container::recover(&name_of(input), reader, &mut saved, |_| None)
        .map_err(container(input))?;
    saved.flush().map_err(SessionError::io("write", output))?;
    drop(saved);
    let mut saved = open(scratch.path())?;
    let add = recovered_take(&metadata(&mut saved, output)?, &recovered);
    let with_record = Selection {
        add: add.into_iter().collect(),
        ..Selection::default()
    };
    write_atomic(output, |out| {
        let selected = inhand_container::select(&mut saved, &mut *out, &with_record)
            .map_err(container(output))?;
        recovered.written = selected.written;
        out.flush().map_err(SessionError::io("write", output))?;
        let written = out.get_ref().try_clone();
        let written = written.map_err(SessionError::io("read", output))?;
        let mut written =
            Source::open(&name_of(output), BufReader::new(written)).map_err(container(output))?;
        inhand_container::verify(&mut written, &recovered.written).map_err(container(output))
    })?;
    Ok(recovered)
}
