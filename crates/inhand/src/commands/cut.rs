//! `inhand cut FILE --from TIME --to TIME -o OUT`.

use std::path::PathBuf;

use anyhow::Result;
use inhand_container::Interval;
use inhand_model::{Label, Selection};
use inhand_session::annotate;
use inhand_session::containers::{self, Cut, Instant};
use inhand_session::is_stream;
use serde_json::json;

use crate::console::{Console, print};
use crate::exit::{Exit, usage};
use crate::options::Format;
use crate::output::{check_outputs, ending, write_output};

/// Cut a time range from an MCAP file of any origin; what stays is byte for byte as it was.
///
/// Static transforms and other messages that still hold are moved to the start of the range. A
/// range of a take is a take: the samples nearest to the two times count.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// An MCAP file.
    input: PathBuf,
    /// Start of the range, seconds [default: the start].
    ///
    /// Seconds since the take's first sample (of another file: its first message), a UTC time such as
    /// 2024-05-06T12:00:00Z, or nanoseconds since 1970 (16 digits or more).
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = instant)]
    from: Option<Instant>,
    /// End of the range, as --from; it is not part of the range [default: the end].
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = instant)]
    to: Option<Instant>,
    /// Keep only the times of events with this label, such as task=rotate.
    ///
    /// A word such as slip is short for label=slip. Repeat for any of several.
    #[arg(long, value_name = "LABEL")]
    event: Vec<Label>,
    /// Leave out the times of events with this label; repeat for several.
    #[arg(long, value_name = "LABEL")]
    without: Vec<Label>,
    /// Output file; or a folder for a file of each event.
    ///
    /// With --event or --without, a name that does not end in .mcap is a folder.
    #[arg(short, long, value_name = "PATH")]
    output: PathBuf,
    /// Print the outcome as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Replace an output that exists.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let one_file = args.event.is_empty() && args.without.is_empty();
    if one_file {
        ending(&args.output, &["mcap"])?;
    }
    let keep = containers::interval(&args.input, args.from, args.to)?;
    let outputs = match one_file {
        true => vec![(args.output.clone(), vec![keep])],
        false => outputs(args, by_events(args, keep)?),
    };
    check_outputs(outputs.iter().map(|(output, _)| output), &[&args.input])?;
    let cuts = (outputs.iter())
        .map(|(output, intervals)| {
            write_output(output, args.force, |path| {
                containers::cut(&args.input, path, intervals)
            })
        })
        .collect::<Result<Vec<_>, _>>()?;
    let json = || match &cuts[..] {
        [cut] => as_json(cut),
        _ => cuts.iter().map(as_json).collect(),
    };
    print(args.format, || cuts.iter().map(text).collect(), json)?;
    for (output, _) in &outputs {
        console.wrote(output);
    }
    Ok(Exit::Done)
}

/// The intervals of events inside `keep`.
fn by_events(args: &Args, keep: Interval) -> Result<Vec<Interval>> {
    let selection = Selection {
        with: args.event.clone(),
        without: args.without.clone(),
    };
    let annotated = annotate::read(&args.input)?;
    let to = keep.to_unix_nanos().unwrap_or(u64::MAX);
    let intervals: Vec<_> = (annotated.stretches(&selection).into_iter())
        .map(|time| time.start.max(keep.from_unix_nanos())..time.end.min(to))
        .filter(|time| !time.is_empty())
        .map(|time| Interval::new(time.start, (time.end < u64::MAX).then_some(time.end)))
        .collect();
    if intervals.is_empty() {
        return usage(format!(
            "no interval is left: {} has {} events, which `inhand annotate list` prints",
            args.input.display(),
            annotated.own.events.len() + annotated.others.len()
        ));
    }
    Ok(intervals)
}

/// The output files of intervals: one for all, or one each in a folder.
fn outputs(args: &Args, intervals: Vec<Interval>) -> Vec<(PathBuf, Vec<Interval>)> {
    let extension = args.output.extension();
    let is_mcap = extension.is_some_and(|e| e.eq_ignore_ascii_case("mcap"));
    if is_stream(&args.output) || is_mcap && !args.output.is_dir() {
        return vec![(args.output.clone(), intervals)];
    }
    let stem = args.input.file_stem().unwrap_or(args.input.as_os_str());
    let stem = stem.to_string_lossy();
    let digits = intervals.len().to_string().len().max(2);
    let file = |n: usize| args.output.join(format!("{stem}_{n:0digits$}.mcap"));
    let intervals = (1..).zip(intervals);
    intervals
        .map(|(n, interval)| (file(n), vec![interval]))
        .collect()
}

/// Seconds, or a time with its zone.
pub(super) fn instant(text: &str) -> Result<Instant, &'static str> {
    let trimmed = text.trim();
    // As many seconds are 30 million years.
    if trimmed.len() > 15
        && let Ok(unix_nanos) = trimmed.parse::<u64>()
    {
        return Ok(Instant::Utc(unix_nanos));
    }
    let seconds = trimmed.strip_suffix('s').unwrap_or(trimmed).parse::<f64>();
    if let Ok(seconds) = seconds
        && seconds.is_finite()
    {
        return Ok(Instant::SinceStart(seconds));
    }
    let time = trimmed.parse::<jiff::Timestamp>().ok();
    let nanos = time.and_then(|time| u64::try_from(time.as_nanosecond()).ok());
    nanos.map(Instant::Utc).ok_or(
        "expected seconds since the start, a time with its zone from 1970 on, such as \
         2024-05-06T12:00:00.5Z, or nanoseconds since 1970",
    )
}

fn text(cut: &Cut) -> String {
    let (selected, written) = (&cut.selected, &cut.selected.written);
    let (messages, left_out) = (written.messages, selected.left_out);
    let seconds = seconds(written.span);
    let mut lines = format!("messages  {messages} kept over {seconds:.3} s, {left_out} left out\n");
    if selected.chunks_skipped > 0 {
        let skipped = selected.chunks_skipped;
        lines += &format!("chunks    {skipped} outside the range not read\n");
    }
    if selected.moved > 0 {
        let moved = selected.moved;
        lines += &format!("moved     {moved} earlier messages to the start\n");
    }
    if let Some(samples) = &cut.samples {
        lines += &format!("take      samples {samples:?}\n");
    }
    lines
}

/// Seconds from the first to the last of two times.
pub(super) fn seconds(span: Option<(u64, u64)>) -> f64 {
    span.map_or(0.0, |(start, end)| end.saturating_sub(start) as f64 / 1e9)
}

fn as_json(cut: &Cut) -> serde_json::Value {
    let written = &cut.selected.written;
    json!({
        "messages": written.messages,
        "left_out": cut.selected.left_out,
        "chunks_not_read": cut.selected.chunks_skipped,
        "moved_to_start": cut.selected.moved,
        "first_unix_nanos": written.span.map(|(start, _)| start),
        "last_unix_nanos": written.span.map(|(_, end)| end),
        "samples": cut.samples.as_ref().map(|samples| [samples.start, samples.end]),
        "bytes": written.bytes,
    })
}
