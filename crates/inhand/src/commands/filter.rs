//! `inhand filter FILE -o OUT`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use inhand_container::{ChannelFacts, Packing, Selection};
use inhand_session::containers;
use regex_lite::Regex;
use serde_json::json;

use crate::console::{Console, print};
use crate::exit::{Exit, UsageError};
use crate::options::{Format, one_of};
use crate::output::OutputFile;

/// Select some topics of an MCAP file of any origin, or change its compression; what stays is
/// byte for byte as it was. The exit code is 3 where no topic matches.
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
    /// Compression of chunks [default: as in the input].
    ///
    /// zstd gives smaller files, lz4 is faster.
    #[arg(long, value_parser = one_of(&PACKINGS))]
    compression: Option<Packing>,
    #[command(flatten)]
    output: OutputFile,
    /// Print the outcome as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

const PACKINGS: [(&str, Packing); 3] = [
    ("zstd", Packing::Zstd),
    ("lz4", Packing::Lz4),
    ("none", Packing::None),
];

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let included = patterns("--include-topic-regex", &args.include_topic_regex)?;
    let excluded = patterns("--exclude-topic-regex", &args.exclude_topic_regex)?;
    args.output.check_mcap(&[&args.input])?;
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
        packing: args.compression,
        ..Selection::default()
    };
    let write = |path: &Path| containers::filter(&args.input, path, &selection);
    let filtered = args.output.write(write)?;
    let written = &filtered.written;
    let text = || {
        format!(
            "messages  {} of {} channels kept, {} left out\nsize      {:.2} MB\n",
            written.messages,
            written.channels,
            filtered.left_out,
            written.bytes as f64 / 1e6,
        )
    };
    let json = || {
        json!({
            "messages": written.messages,
            "left_out": filtered.left_out,
            "channels": written.channels,
            "metadata": written.metadata,
            "attachments": written.attachments,
            "bytes": written.bytes,
        })
    };
    print(args.format, text, json)?;
    let nothing = written.channels == 0 && !all;
    if nothing {
        console.say("warning  no topic matches; `inhand info` prints the topics of a file");
    }
    console.wrote(&args.output.output);
    Ok(Exit::done_unless(nothing))
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
