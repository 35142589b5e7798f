//! `inhand cut FILE --from TIME --to TIME -o OUT`.

use std::path::PathBuf;

use anyhow::Result;
use inhand_pipeline::check_target;
use inhand_pipeline::containers::{self, Cut, Instant};
use serde_json::json;

use crate::console::{Console, data};
use crate::exit::{Exit, UsageError};
use crate::options::Format;

/// Writes a stretch of time of an MCAP file of any origin; what stays is byte for byte as it was.
///
/// Static transforms and other messages that still hold are moved to the start of the stretch. A
/// stretch of a take is a take: the samples nearest to the two times count.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// An MCAP file.
    input: PathBuf,
    /// Where it starts: seconds since the file's first message, or a UTC time such as
    /// 2024-05-06T12:00:00Z [default: the start].
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    from: Option<String>,
    /// Where it ends, which is not part of it: a time as --from [default: the end].
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    to: Option<String>,
    /// Output file.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Print the outcome as text or JSON.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Replace an output that is there.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    check_target(&args.output, &[&args.input], || args.force)?;
    let from = args.from.as_deref().map(|text| instant("--from", text));
    let to = args.to.as_deref().map(|text| instant("--to", text));
    let keep = containers::interval(&args.input, from.transpose()?, to.transpose()?)?;
    let cut = containers::cut(&args.input, &args.output, &[keep])?;
    data(&match args.format {
        Format::Text => text(&cut),
        Format::Json => format!("{:#}\n", as_json(&cut)),
    })?;
    if cut.selected.written.messages == 0 {
        console.say("warning  no message lies in that stretch");
    }
    console.say(&format!("wrote {}", args.output.display()));
    Ok(Exit::Done)
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
