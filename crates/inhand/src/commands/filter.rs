//! `inhand filter FILE -o OUT`.

use std::path::PathBuf;

use anyhow::Result;
use clap::ValueEnum;
use inhand_container::{ChannelFacts, Packing, Selection};
use inhand_session::{check_target, containers};
use regex_lite::Regex;
use serde_json::json;

use crate::console::{Console, data};
use crate::exit::{Exit, UsageError};
use crate::options::Format;

/// Select some topics of an MCAP file of any origin, or change its compression; what stays is
/// byte for byte as it was.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// An MCAP file.
    input: PathBuf,
    /// Keep topics that match as a whole, such as "/tf.*"; repeat for more [default: all].
    #[arg(short = 'y', long, alias = "topic", value_name = "REGEX")]
    include_topic_regex: Vec<String>,
    /// Leave out topics that match as a whole; repeat for more.
    #[arg(short = 'n', long, alias = "exclude-topic", value_name = "REGEX")]
    exclude_topic_regex: Vec<String>,
    /// Leave out metadata records.
    #[arg(long)]
    no_metadata: bool,
    /// Leave out attachments.
    #[arg(long)]
    no_attachments: bool,
    /// How chunks are packed [default: as they are].
    #[arg(long, value_enum)]
    compression: Option<Compression>,
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

/// How chunks are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Compression {
    /// Small and quick.
    Zstd,
    /// Quicker, not as small.
    Lz4,
    /// Not at all.
    None,
}

impl From<Compression> for Packing {
    fn from(compression: Compression) -> Self {
        match compression {
            Compression::Zstd => Packing::Zstd,
            Compression::Lz4 => Packing::Lz4,
            Compression::None => Packing::None,
        }
    }
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let included = patterns("--include-topic-regex", &args.include_topic_regex)?;
    let excluded = patterns("--exclude-topic-regex", &args.exclude_topic_regex)?;
    check_target(&args.output, &[&args.input], || args.force)?;
    let matches = |patterns: &[Regex], topic: &str| patterns.iter().any(|p| p.is_match(topic));
    let keep = |channel: &ChannelFacts| {
        (included.is_empty() || matches(&included, &channel.topic))
            && !matches(&excluded, &channel.topic)
    };
    let all = included.is_empty() && excluded.is_empty();
    let selection = Selection {
        channels: (!all).then_some(&keep),
        metadata: !args.no_metadata,
        attachments: !args.no_attachments,
        packing: args.compression.map(Packing::from),
        ..Selection::default()
    };
    let filtered = containers::filter(&args.input, &args.output, &selection)?;
    let written = &filtered.written;
    data(&match args.format {
        Format::Text => format!(
            "messages  {} of {} channels kept, {} left out\nsize      {:.2} MB\n",
            written.messages,
            written.channels,
            filtered.left_out,
            written.bytes as f64 / 1e6,
        ),
        Format::Json => format!(
            "{:#}\n",
            json!({
                "messages": written.messages,
                "left_out": filtered.left_out,
                "channels": written.channels,
                "metadata": written.metadata,
                "attachments": written.attachments,
                "bytes": written.bytes,
            })
        ),
    })?;
    if written.channels == 0 && !all {
        console.say("warning  no topic matches");
    }
    console.say(&format!("wrote {}", args.output.display()));
    Ok(Exit::Done)
}

/// Patterns for whole topics.
fn patterns(flag: &str, texts: &[String]) -> Result<Vec<Regex>, UsageError> {
    (texts.iter())
        .map(|text| {
            Regex::new(&format!("^(?:{text})$"))
                .map_err(|error| UsageError(format!("{flag} {text}: {error}")))
        })
        .collect()
}
