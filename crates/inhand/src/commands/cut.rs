//! `inhand cut FILE --from TIME --to TIME -o OUT`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use inhand_container::Interval;
use inhand_model::{Label, Selection};
use inhand_session::containers::{self, Cut, Instant};
use inhand_session::{annotate, check_target};
use serde_json::json;

use crate::console::{Console, data};
use crate::exit::{Exit, UsageError};
use crate::options::Format;

/// Cut a time range from an MCAP file of any origin; what stays is byte for byte as it was.
///
/// Static transforms and other messages that still hold are moved to the start of the range. A
/// range of a take is a take: the samples nearest to the two times count.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// An MCAP file.
    input: PathBuf,
    /// Where it starts: seconds since the take's first sample (of another file: its first message), or
    /// a UTC time such as
    /// 2024-05-06T12:00:00Z [default: the start].
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    from: Option<String>,
    /// Where it ends, which is not part of it: a time as --from [default: the end].
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    to: Option<String>,
    /// Keep only stretches of events with this label, such as task=rotate, or slip (short for
    /// label=slip); repeat for any of several.
    #[arg(long, value_name = "LABEL")]
    event: Vec<String>,
    /// Leave out stretches of events with this label; repeat for several.
    #[arg(long, value_name = "LABEL")]
    without: Vec<String>,
    /// Output file; with --event or --without a name that does not end in .mcap is a folder, for a
    /// file of each stretch.
    #[arg(short, long, value_name = "PATH")]
    output: PathBuf,
    /// Print the outcome as text or JSON.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Replace an output that is there.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let from = args.from.as_deref().map(|text| instant("--from", text));
    let to = args.to.as_deref().map(|text| instant("--to", text));
    let keep = containers::interval(&args.input, from.transpose()?, to.transpose()?)?;
    let stretches = match args.event.is_empty() && args.without.is_empty() {
        true => vec![keep],
        false => by_events(args, keep)?,
    };
    let outputs = outputs(args, stretches)?;
    for (output, _) in &outputs {
        check_target(output, &[&args.input], || args.force)?;
    }
    let mut cuts = Vec::with_capacity(outputs.len());
    for (output, stretches) in &outputs {
        cuts.push(containers::cut(&args.input, output, stretches)?);
    }
    match args.format {
        Format::Text => data(&cuts.iter().map(text).collect::<String>())?,
        Format::Json => {
            let cuts: Vec<_> = cuts.iter().map(as_json).collect();
            match &cuts[..] {
                [cut] => data(&format!("{cut:#}\n"))?,
                _ => data(&format!("{:#}\n", json!(cuts)))?,
            }
        }
    }
    for ((output, _), cut) in outputs.iter().zip(&cuts) {
        if cut.selected.written.messages == 0 {
            console.say("warning  no message lies in that stretch");
        }
        console.say(&format!("wrote {}", output.display()));
    }
    Ok(Exit::Done)
}

/// The stretches of events, as far as they lie in `keep`.
fn by_events(args: &Args, keep: Interval) -> Result<Vec<Interval>> {
    let labels = |flag: &str, texts: &[String]| {
        let parse = |text: &String| text.parse().map_err(|e| UsageError(format!("{flag}: {e}")));
        texts.iter().map(parse).collect::<Result<Vec<Label>, _>>()
    };
    let selection = Selection {
        with: labels("--event", &args.event)?,
        without: labels("--without", &args.without)?,
    };
    let annotated = annotate::read(&args.input)?;
    let to = keep.to_unix_nanos().unwrap_or(u64::MAX);
    let stretches: Vec<_> = (annotated.stretches(&selection).into_iter())
        .map(|time| time.start.max(keep.from_unix_nanos())..time.end.min(to))
        .filter(|time| !time.is_empty())
        .map(|time| Interval::new(time.start, (time.end < u64::MAX).then_some(time.end)))
        .collect();
    if stretches.is_empty() {
        let message = format!(
            "no stretch is left: {} has {} events, which `inhand annotate list` prints",
            args.input.display(),
            annotated.own.events.len() + annotated.others.len()
        );
        return Err(UsageError(message).into());
    }
    Ok(stretches)
}

/// What goes into which file: everything into a file, or each stretch into one of its own in a folder.
fn outputs(args: &Args, stretches: Vec<Interval>) -> Result<Vec<(PathBuf, Vec<Interval>)>> {
    let by_event = !(args.event.is_empty() && args.without.is_empty());
    let is_file = |path: &Path| {
        path.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("mcap"))
    };
    if !by_event || is_file(&args.output) && !args.output.is_dir() {
        return Ok(vec![(args.output.clone(), stretches)]);
    }
    let stem = args.input.file_stem().unwrap_or(args.input.as_os_str());
    let stem = stem.to_string_lossy();
    let digits = stretches.len().to_string().len().max(2);
    Ok((1..)
        .zip(stretches)
        .map(|(n, stretch)| {
            let name = format!("{stem}_{n:0digits$}.mcap");
            (args.output.join(name), vec![stretch])
        })
        .collect())
}

/// Seconds, or a time with its zone.
pub(super) fn instant(flag: &str, text: &str) -> Result<Instant, UsageError> {
    let trimmed = text.trim();
    let seconds = trimmed.strip_suffix('s').unwrap_or(trimmed).parse::<f64>();
    if let Ok(seconds) = seconds
        && seconds.is_finite()
    {
        return Ok(Instant::SinceStart(seconds));
    }
    let time = trimmed.parse::<jiff::Timestamp>().ok();
    time.and_then(|time| u64::try_from(time.as_nanosecond()).ok())
        .map(Instant::Utc)
        .ok_or_else(|| {
            UsageError(format!(
                "{flag} {text}: expected seconds since the start, or a time with its zone from 1970 on, \
                 such as 2024-05-06T12:00:00.5Z"
            ))
        })
}

fn text(cut: &Cut) -> String {
    let written = &cut.selected.written;
    let mut lines = format!(
        "messages  {} kept over {:.3} s, {} left out\n",
        written.messages,
        seconds(written.span),
        cut.selected.left_out,
    );
    if cut.selected.chunks_skipped > 0 {
        let skipped = cut.selected.chunks_skipped;
        lines.push_str(&format!(
            "chunks    {skipped} outside the stretch not read\n"
        ));
    }
    if cut.selected.moved > 0 {
        let moved = cut.selected.moved;
        lines.push_str(&format!(
            "moved     {moved} earlier messages to the start\n"
        ));
    }
    if let Some(samples) = &cut.samples {
        let (start, end) = (samples.start, samples.end);
        lines.push_str(&format!("take      samples {start}..{end}\n"));
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
