//! `inhand merge FILE FILE... -o OUT`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::Result;
use inhand_session::containers;
use serde_json::json;

use crate::commands::cut::seconds;
use crate::console::{Console, print};
use crate::exit::{Exit, usage};
use crate::options::Format;
use crate::output::OutputFile;

/// Merge MCAP files of any origin into one, by the log time of their messages.
///
/// Channels with equal topic, schema, encoding and metadata become one. Metadata records that
/// several files share word for word are written once.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Two or more MCAP files.
    #[arg(required = true, num_args = 2..)]
    inputs: Vec<PathBuf>,
    /// Keep the channels of both files where schemas of a topic differ.
    ///
    /// Also where both files hold a take; the result is then no take.
    #[arg(long)]
    keep_both: bool,
    #[command(flatten)]
    output: OutputFile,
    /// Print the outcome as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Files of one recording have no such pause, nanoseconds.
const LONG_PAUSE: u64 = 3_600_000_000_000;

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let inputs: Vec<&Path> = args.inputs.iter().map(PathBuf::as_path).collect();
    let mut files = BTreeSet::new();
    for &input in &inputs {
        if !files.insert(input.canonicalize().unwrap_or_else(|_| input.to_owned())) {
            return usage(format!("{} is named twice", input.display()));
        }
    }
    args.output.check_mcap(&inputs)?;
    let write = |path: &Path| containers::merge(&inputs, path, args.keep_both);
    let merged = args.output.write(write)?;
    let written = &merged.written;
    let text = || {
        let mut lines = format!(
            "messages  {} in {} channels over {:.3} s\n",
            written.messages,
            written.channels,
            seconds(written.span),
        );
        for topic in &merged.joined {
            lines += &format!("joined    {topic}\n");
        }
        for topic in &merged.side_by_side {
            lines += &format!("two kinds {topic}\n");
        }
        lines
    };
    let json = || {
        json!({
            "messages": written.messages,
            "channels": written.channels,
            "joined": merged.joined,
            "side_by_side": merged.side_by_side,
            "metadata_once": merged.metadata_once,
            "longest_pause_s": merged.longest_pause as f64 / 1e9,
            "bytes": written.bytes,
        })
    };
    print(args.format, text, json)?;
    if merged.longest_pause > LONG_PAUSE {
        let hours = merged.longest_pause as f64 / 3600e9;
        console.say(&format!(
            "warning  no file has a message for {hours:.1} h: were their clocks the same, and do they belong together?"
        ));
    }
    console.wrote(&args.output.output);
    Ok(Exit::Done)
}
