//! `inhand recover FILE -o OUT`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use inhand_container::{Loss, Recovered};
use inhand_session::containers;
use serde_json::{Value, json};

use crate::console::{Console, print};
use crate::exit::Exit;
use crate::options::Format;
use crate::output::OutputFile;

/// Losses that are printed; the rest are counted.
const MOST_PRINTED: usize = 20;

/// Recover intact data from an MCAP file that is cut off, damaged or was never finished.
///
/// Losses are reported. The output is read back, with every checksum, before it is kept. The exit code is 3
/// when something is lost, 0 when nothing is.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// A damaged MCAP file.
    input: PathBuf,
    #[command(flatten)]
    output: OutputFile,
    /// Keep the messages of chunks whose checksum differs, under topics that start with /unverified.
    ///
    /// Any of these messages may be wrong.
    #[arg(long)]
    keep_unverified: bool,
    /// Print the outcome as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    args.output.check_mcap(&[&args.input])?;
    let output = &args.output.output;
    let write = |path: &Path| containers::recover(&args.input, path, args.keep_unverified);
    let recovered = args.output.write(write)?;
    print(args.format, || text(&recovered), || as_json(&recovered))?;
    console.say(&format!("wrote {}, and read it back", output.display()));
    Ok(Exit::done_unless(recovered.is_lossy()))
}

fn text(recovered: &Recovered) -> String {
    let written = &recovered.written;
    let of = (recovered.stated_messages).map_or_else(String::new, |stated| format!(" of {stated}"));
    let mut text = format!(
        "saved     {}{of} messages in {} channels, {} metadata records, {} attachments\n",
        written.messages, written.channels, written.metadata, written.attachments,
    );
    let mut lost = |what: String| text += &format!("lost      {what}\n");
    for loss in recovered.losses.iter().take(MOST_PRINTED) {
        lost(in_words(loss));
    }
    let unlisted =
        recovered.losses.len().saturating_sub(MOST_PRINTED) as u64 + recovered.losses_unlisted;
    if unlisted > 0 {
        lost(format!("{unlisted} more ranges"));
    }
    if recovered.lost_bytes > 0 {
        lost(format!("{} bytes in all", recovered.lost_bytes));
    }
    for (channel, messages) in &recovered.without_channel {
        lost(format!(
            "{messages} messages of channel {channel}, whose topic is lost"
        ));
    }
    for topic in &recovered.without_schema {
        lost(format!("the schema of {topic}; its messages are kept"));
    }
    if recovered.contradictions > 0 {
        let count = recovered.contradictions;
        lost(format!(
            "{count} schemas or channels without a checksum that contradict others"
        ));
    }
    if recovered.unfinished {
        lost("all data after that: the file has no end".to_owned());
    }
    if recovered.unverified > 0 {
        text += &format!(
            "warning   {} messages under /unverified come from chunks whose checksum differs\n",
            recovered.unverified
        );
    }
    for name in &recovered.doubtful {
        text += &format!("warning   the only definition of {name} is in bytes that are damaged\n");
    }
    if recovered.unchecked {
        text += "warning   no checksum covers the records outside chunks\n";
    }
    for (offset, what) in recovered.mended.iter().take(MOST_PRINTED) {
        text += &format!("mended    byte {offset}: {what}\n");
    }
    if recovered.mended.len() > MOST_PRINTED {
        let more = recovered.mended.len() - MOST_PRINTED;
        text += &format!("mended    {more} more places\n");
    }
    for part in &recovered.repaired {
        text += &format!("repaired  {part}\n");
    }
    if !recovered.is_lossy() {
        text += "nothing is lost\n";
    }
    text
}

fn in_words(loss: &Loss) -> String {
    let span = loss.span.map_or_else(String::new, |(start, end)| {
        let s = |unix_nanos: u64| unix_nanos as f64 / 1e9;
        format!(", log times {:.3} to {:.3} s", s(start), s(end))
    });
    format!(
        "byte {}: {}, {} bytes{span}",
        loss.offset, loss.what, loss.bytes
    )
}

fn as_json(recovered: &Recovered) -> Value {
    let losses: Vec<_> = (recovered.losses.iter())
        .map(|loss| {
            json!({
                "offset": loss.offset,
                "bytes": loss.bytes,
                "what": loss.what,
                "first_unix_nanos": loss.span.map(|(start, _)| start),
                "last_unix_nanos": loss.span.map(|(_, end)| end),
            })
        })
        .collect();
    let written = &recovered.written;
    json!({
        "lossy": recovered.is_lossy(),
        "messages": written.messages,
        "stated_messages": recovered.stated_messages,
        "channels": written.channels,
        "metadata": written.metadata,
        "attachments": written.attachments,
        "lost_bytes": recovered.lost_bytes,
        "losses": losses,
        "losses_unlisted": recovered.losses_unlisted,
        "messages_without_channel": recovered.without_channel.values().sum::<u64>(),
        "topics_without_schema": recovered.without_schema,
        "contradictions": recovered.contradictions,
        "doubtful_definitions": recovered.doubtful,
        "unverified_messages": recovered.unverified,
        "mended": recovered.mended,
        "unfinished": recovered.unfinished,
        "unchecked_records": recovered.unchecked,
        "repaired": recovered.repaired,
    })
}
