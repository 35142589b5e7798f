//! `inhand info FILE`.

use std::fmt::Write as _;
use std::path::PathBuf;

use anyhow::{Context, Result};
use inhand_channels::{FileInfo, info};
use inhand_model::{Dictionary, Finger, Provenance};
use serde_json::{Value, json};

use crate::commands::info_dictionary;
use crate::console::{Console, data};
use crate::exit::Exit;
use crate::options::Format;

/// Print what is in an MCAP file of any origin: channels with schema, counts and rates, frames,
/// gaps of each finger, metadata, attachments. Every checksum is compared on the way.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// An MCAP file.
    file: PathBuf,
    /// Print as text or JSON.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let shown = args.file.display().to_string();
    let bytes = std::fs::read(&args.file).with_context(|| format!("cannot read {shown}"))?;
    let info = info(&bytes, &shown)?;
    let has_dictionary = (info.channels.iter()).any(|c| c.topic == "/dictionary/model");
    let dictionary = has_dictionary
        .then(|| inhand_channels::read_dictionary(&bytes, &shown))
        .and_then(Result::ok);
    data(&match args.format {
        Format::Text => text(&info, dictionary.as_ref()),
        Format::Json => {
            let mut json = to_json(&info);
            if let Some((dictionary, made)) = &dictionary {
                json["dictionary"] = info_dictionary::to_json(dictionary, made);
            }
            format!("{json:#}\n")
        }
    })?;
    if let Some(problem) = &info.problem {
        console.say(&format!(
            "warning  {problem}; what is listed comes from before it"
        ));
        return Ok(Exit::Lossy);
    }
    Ok(Exit::Done)
}

fn text(info: &FileInfo, dictionary: Option<&(Dictionary, Vec<Provenance>)>) -> String {
    let mut out = String::new();
    lines(info, &mut out).expect("writing to a string cannot fail");
    if let Some((dictionary, made)) = dictionary {
        info_dictionary::lines(dictionary, made, &mut out)
            .expect("writing to a string cannot fail");
    }
    out
}

fn lines(info: &FileInfo, out: &mut String) -> std::fmt::Result {
    writeln!(out, "{}  {:.2} MB", info.file, info.bytes as f64 / 1e6)?;
    writeln!(out, "library   {}", or_none(&info.library))?;
    if !info.profile.is_empty() {
        writeln!(out, "profile   {}", info.profile)?;
    }
    writeln!(
        out,
        "messages  {} over {:.3} s",
        info.messages,
        info.duration_s()
    )?;
    let compression: Vec<_> = info
        .chunks
        .compression
        .iter()
        .map(|(name, count)| format!("{count} {name}"))
        .collect();
    writeln!(
        out,
        "chunks    {} ({}), {:.2} MB unpacked{}",
        info.chunks.count,
        if compression.is_empty() {
            "none".to_owned()
        } else {
            compression.join(", ")
        },
        info.chunks.unpacked_bytes as f64 / 1e6,
        if info.has_summary {
            ""
        } else {
            "; no summary: viewers may refuse the file"
        },
    )?;
    if let Some(facts) = info.metadata.0.get("inhand.recording") {
        writeln!(out, "recording")?;
        for (key, value) in facts.iter().filter(|(_, value)| value.len() <= 120) {
            writeln!(out, "  {key:<24} {value}")?;
        }
    }
    writeln!(out, "channels")?;
    let width = info
        .channels
        .iter()
        .map(|c| c.topic.len())
        .max()
        .unwrap_or(0);
    for channel in &info.channels {
        let rate = channel
            .rate_hz()
            .map_or_else(String::new, |rate| format!("{rate:.2} Hz"));
        writeln!(
            out,
            "  {:<width$}  {:<28} {:<9} {:>8}  {rate:>10}",
            channel.topic,
            channel.schema.as_deref().unwrap_or("-"),
            or_none(&channel.message_encoding),
            channel.messages,
        )?;
    }
    for frame in &info.frames {
        writeln!(
            out,
            "frame     {} -> {} ({})",
            frame.parent, frame.child, frame.topic
        )?;
    }
    for fingertips in &info.fingertips {
        writeln!(out, "{}", fingertips.topic)?;
        for (finger, facts) in fingertips.fingers.iter() {
            let counts = facts.counts;
            writeln!(
                out,
                "  {finger:<7} {} measured, {} filled, {} missing in {} gaps, longest {:.2} s",
                counts.measured, counts.filled, counts.missing, facts.gaps, facts.longest_gap_s,
            )?;
        }
    }
    for name in info.metadata.0.keys() {
        writeln!(out, "metadata  {name}")?;
    }
    for attachment in &info.attachments {
        let (name, kind) = (&attachment.name, or_none(&attachment.media_type));
        writeln!(out, "attached  {name} ({kind}, {} bytes)", attachment.bytes)?;
    }
    Ok(())
}

fn or_none(text: &str) -> &str {
    if text.is_empty() { "-" } else { text }
}

fn to_json(info: &FileInfo) -> Value {
    let channels: Vec<_> = (info.channels.iter())
        .map(|channel| {
            json!({
                "id": channel.id,
                "topic": channel.topic,
                "schema": channel.schema,
                "schema_encoding": channel.schema_encoding,
                "message_encoding": channel.message_encoding,
                "metadata": channel.metadata,
                "messages": channel.messages,
                "bytes": channel.bytes,
                "first_unix_nanos": channel.first_unix_nanos,
                "last_unix_nanos": channel.last_unix_nanos,
                "rate_hz": channel.rate_hz(),
            })
        })
        .collect();
    let frames: Vec<_> = (info.frames.iter())
        .map(|f| json!({ "parent": f.parent, "child": f.child, "topic": f.topic, "transforms": f.transforms }))
        .collect();
    let fingertips: serde_json::Map<_, _> = (info.fingertips.iter())
        .map(|fingertips| {
            let fingers = Finger::ALL.into_iter().map(|finger| {
                let facts = fingertips.fingers[finger];
                let value = json!({
                    "measured": facts.counts.measured,
                    "filled": facts.counts.filled,
                    "missing": facts.counts.missing,
                    "gaps": facts.gaps,
                    "longest_gap_s": facts.longest_gap_s,
                });
                (finger.name().to_owned(), value)
            });
            (fingertips.topic.clone(), Value::Object(fingers.collect()))
        })
        .collect();
    let attachments: Vec<_> = (info.attachments.iter())
        .map(|a| json!({ "name": a.name, "media_type": a.media_type, "bytes": a.bytes }))
        .collect();
    json!({
        "file": info.file,
        "bytes": info.bytes,
        "profile": info.profile,
        "library": info.library,
        "messages": info.messages,
        "duration_s": info.duration_s(),
        "first_unix_nanos": info.first_unix_nanos(),
        "last_unix_nanos": info.last_unix_nanos(),
        "has_summary": info.has_summary,
        "problem": info.problem.as_ref().map(ToString::to_string),
        "chunks": {
            "count": info.chunks.count,
            "packed_bytes": info.chunks.packed_bytes,
            "unpacked_bytes": info.chunks.unpacked_bytes,
            "compression": info.chunks.compression,
        },
        "channels": channels,
        "frames": frames,
        "fingertips": fingertips,
        "metadata": info.metadata.0,
        "attachments": attachments,
    })
}
