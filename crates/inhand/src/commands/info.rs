//! `inhand info FILE`.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use inhand_channels::{FileInfo, info_of_source, view_topics};
use inhand_container::Source;
use inhand_model::{Dictionary, Provenance};
use inhand_session::containers::FileSource;
use inhand_session::{open_take, take_files};
use serde_json::{Value, json};

use crate::console::{Console, by_finger, print};
use crate::exit::Exit;
use crate::options::Format;
use crate::visible::one_line;

/// Topic of a dictionary's own message.
const DICTIONARY: &str = "/dictionary/model";

/// Print the content of an MCAP file of any origin.
///
/// Lists channels with schema, counts and rates, frames, gaps of each finger, metadata, attachments. Every
/// checksum is compared on the way.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// An MCAP file, or the folder of a ROS 2 bag.
    file: PathBuf,
    /// Print as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let (mut texts, mut exit) = (String::new(), Exit::Done);
    let mut documents = Vec::new();
    for file in take_files(&args.file)? {
        let mut source = opened(&file)?;
        let info = info_of_source(&mut source)?;
        let has_dictionary = (info.channels.iter()).any(|c| c.topic == DICTIONARY);
        let dictionary = has_dictionary
            .then(|| inhand_channels::dictionary_of_source(&mut source))
            .and_then(Result::ok);
        texts += &text(&info);
        let mut document = to_json(&info);
        if let Some((dictionary, made)) = &dictionary {
            texts += &dictionary_text(dictionary, made);
            document["dictionary"] = dictionary_json(dictionary, made);
        }
        documents.push(document);
        for warning in &info.warnings {
            console.say(&format!("warning  {warning}"));
        }
        if info.messages_without_channel > 0 {
            console.say(&format!(
                "warning  {} messages are of channels that the file does not define",
                info.messages_without_channel
            ));
            exit = Exit::Lossy;
        }
        if let Some(problem) = &info.problem {
            console.say(&format!("warning  {problem}; the list ends before it"));
            exit = Exit::Lossy;
        }
    }
    let json = || match documents.len() {
        1 => documents.remove(0),
        // The files of a bag.
        _ => Value::Array(documents),
    };
    print(args.format, || texts, json)?;
    Ok(exit)
}

/// Opens a file of any size, unpacked as it is read where zstd packed it.
fn opened(file: &Path) -> Result<FileSource> {
    let shown = file.display().to_string();
    if let Some(source) = open_take(file, &shown)? {
        return Ok(source);
    }
    let opened = File::open(file).with_context(|| format!("cannot read {shown}"))?;
    Source::open(&shown, opened).map_err(|error| {
        anyhow!(
            "{error}; `inhand check` looks at takes of other formats, `inhand convert` makes MCAP \
             files of them"
        )
    })
}

fn text(info: &FileInfo) -> String {
    let mut text = header(info);
    let width = info.channels.iter().map(|c| c.topic.len()).max();
    let width = width.unwrap_or(0);
    for channel in &info.channels {
        let rate = (channel.rate_hz()).map_or_else(String::new, |rate| format!("{rate:.2} Hz"));
        text += &format!(
            "  {:<width$}  {:<28} {:<9} {:>8}  {rate:>10}  {:>8.2} MB\n",
            one_line(&channel.topic),
            channel.schema.as_deref().unwrap_or("-"),
            or_none(&channel.message_encoding),
            channel.messages,
            channel.packed_bytes as f64 / 1e6,
        );
    }
    if let Some(views) = views_bytes(info) {
        let (views, all) = (views as f64, info.bytes as f64);
        text += &format!(
            "views {:.1} MB of {:.1} MB ({:.0} %)\n",
            views / 1e6,
            all / 1e6,
            100.0 * views / all,
        );
    }
    for frame in &info.frames {
        text += &format!(
            "frame     {} -> {} ({})\n",
            frame.parent, frame.child, frame.topic
        );
    }
    for fingertips in &info.fingertips {
        text += &format!("{}\n", fingertips.topic);
        let lines = fingertips.fingers.each_ref().map(|facts| {
            let counts = facts.counts;
            format!(
                "{} measured, {} filled, {} missing in {} gaps, longest {:.2} s\n",
                counts.measured, counts.filled, counts.missing, facts.gaps, facts.longest_gap_s,
            )
        });
        let [first, others @ ..] = lines.as_array();
        if others.iter().all(|line| line == first) {
            text += &format!("  each finger: {first}");
            continue;
        }
        for (finger, line) in lines.iter() {
            text += &format!("  {finger:<7} {line}");
        }
    }
    for record in &info.metadata_records {
        text += &format!("metadata  {}\n", one_line(&record.name));
    }
    for attachment in &info.attachments {
        let (name, kind) = (one_line(&attachment.name), or_none(&attachment.media_type));
        text += &format!("attached  {name} ({kind}, {} bytes)\n", attachment.bytes);
    }
    text
}

/// Bytes in the file of the channels that only viewers need; `None` without any.
fn views_bytes(info: &FileInfo) -> Option<u64> {
    let dictionary = info.channels.iter().any(|c| c.topic == DICTIONARY);
    let is_view = view_topics(&info.metadata, dictionary);
    let views = info.channels.iter().filter(|c| {
        let schema = c.schema.as_deref().unwrap_or_default();
        is_view(&c.topic, &c.message_encoding, schema)
    });
    let bytes: u64 = views.map(|channel| channel.packed_bytes).sum();
    (bytes > 0).then_some(bytes)
}

/// The lines about the file as a whole and the recording in it.
fn header(info: &FileInfo) -> String {
    let mut text = format!("{}  {:.2} MB\n", info.file, info.bytes as f64 / 1e6);
    text += &format!("library   {}\n", or_none(&info.library));
    if !info.profile.is_empty() {
        text += &format!("profile   {}\n", info.profile);
    }
    text += &format!(
        "messages  {} over {:.3} s\n",
        info.messages,
        info.duration_s()
    );
    if let (Some(first), Some(last)) = (info.first_unix_nanos(), info.last_unix_nanos()) {
        text += &format!("from      {}\nto        {}\n", utc(first), utc(last));
    }
    let compression = info.chunks.compression.iter();
    let compression: Vec<_> = compression
        .map(|(name, count)| format!("{count} {name}"))
        .collect();
    let compression = match compression.is_empty() {
        true => "none".to_owned(),
        false => compression.join(", "),
    };
    text += &format!(
        "chunks    {} ({compression}), {:.2} MB unpacked{}\n",
        info.chunks.count,
        info.chunks.unpacked_bytes as f64 / 1e6,
        match info.has_summary {
            true => "",
            false => "; no summary: viewers may refuse the file",
        },
    );
    if let Some(facts) = info.metadata.0.get("inhand.recording") {
        text += "recording\n";
        for (key, value) in facts.iter().filter(|(_, value)| value.len() <= 120) {
            text += &format!("  {key:<24} {value}\n");
        }
    }
    text + "channels\n"
}

/// A time as `cut --from` reads it.
fn utc(unix_nanos: u64) -> String {
    let time = jiff::Timestamp::from_nanosecond(i128::from(unix_nanos));
    time.map_or_else(|_| format!("{unix_nanos} ns"), |time| time.to_string())
}

fn or_none(text: &str) -> &str {
    if text.is_empty() { "-" } else { text }
}

fn to_json(info: &FileInfo) -> Value {
    let channels: Vec<_> = (info.channels.iter())
        .map(|channel| {
            let mut json = json!(channel);
            json["rate_hz"] = json!(channel.rate_hz());
            json
        })
        .collect();
    let fingertips: BTreeMap<_, _> = (info.fingertips.iter())
        .map(|fingertips| {
            let fingers = by_finger(&fingertips.fingers, |facts| {
                json!({
                    "measured": facts.counts.measured,
                    "filled": facts.counts.filled,
                    "missing": facts.counts.missing,
                    "gaps": facts.gaps,
                    "longest_gap_s": facts.longest_gap_s,
                })
            });
            (&fingertips.topic, fingers)
        })
        .collect();
    let metadata_records: Vec<_> = (info.metadata_records.iter())
        .map(|record| json!({ "name": record.name, "facts": record.facts }))
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
        "chunks": info.chunks,
        "views_bytes": views_bytes(info).unwrap_or_default(),
        "channels": channels,
        "frames": info.frames,
        "fingertips": fingertips,
        "metadata": info.metadata.0,
        "metadata_records": metadata_records,
        "messages_without_channel": info.messages_without_channel,
        "warnings": info.warnings,
        "attachments": info.attachments,
    })
}

/// Learning, reconstruction error and inputs of a dictionary as lines.
fn dictionary_text(dictionary: &Dictionary, made: &[Provenance]) -> String {
    let learning = &dictionary.learning;
    let mm = |metres: f64| format!("{:.4} mm rms", metres * 1000.0);
    let mut text = format!(
        "dictionary\n  {} primitives ({}) from {} segments of {} samples at {} Hz{}\n",
        dictionary.rank(),
        dictionary.kind.name(),
        learning.segments,
        dictionary.layout.samples,
        dictionary.layout.rate_hz,
        ["", ", with the object"][usize::from(dictionary.layout.object)],
    );
    text += &format!(
        "  {} after {} iterations ({}), seed {}\n",
        mm(learning.rms_m),
        learning.iterations,
        learning.stop_reason.name().replace('_', " "),
        learning.seed,
    );
    for restart in &learning.restarts {
        let (seed, rms, cosine) = (restart.seed, mm(restart.rms_m), restart.matched_cosine);
        text += &format!("  start with seed {seed}: {rms}, mean matched cosine {cosine:.4}\n");
    }
    if let Some(residual) = &dictionary.residual {
        text += &format!(
            "  deviations from the cubic baseline: {} primitives, {} demonstrations\n",
            residual.primitives.ncols(),
            residual.expectation.demonstrations(),
        );
    }
    if let Some(choice) = &dictionary.choice {
        text += &format!("  best method on left-out takes: {}\n", choice.method);
    }
    for input in made.iter().flat_map(|step| &step.inputs) {
        let short = input.sha256.get(..12).unwrap_or(&input.sha256);
        text += &format!("  from {} (sha256 {short}...)\n", input.name);
    }
    text
}

/// The same as JSON.
fn dictionary_json(dictionary: &Dictionary, made: &[Provenance]) -> Value {
    let learning = &dictionary.learning;
    let restarts: Vec<_> = (learning.restarts.iter())
        .map(|restart| {
            json!({
                "seed": restart.seed,
                "rms_mm": restart.rms_m * 1000.0,
                "objective_m2": restart.objective_m2,
                "matched_cosine": restart.matched_cosine,
            })
        })
        .collect();
    let inputs: Vec<_> = (made.iter().flat_map(|step| &step.inputs))
        .map(|input| json!({ "name": input.name, "sha256": input.sha256 }))
        .collect();
    json!({
        "kind": dictionary.kind.name(),
        "rank": dictionary.rank(),
        "samples": dictionary.layout.samples,
        "rate_hz": dictionary.layout.rate_hz,
        "object": dictionary.layout.object,
        "segments": learning.segments,
        "rms_mm": learning.rms_m * 1000.0,
        "relative_error": learning.relative_error,
        "iterations": learning.iterations,
        "stop_reason": learning.stop_reason.name(),
        "objective_history_m2": learning.objective_history_m2,
        "seed": learning.seed,
        "restarts": restarts,
        "demonstrations": dictionary.residual.as_ref().map(|r| r.expectation.demonstrations()),
        "method": dictionary.choice.as_ref().map(|choice| &choice.method),
        "inputs": inputs,
    })
}
