//! `inhand layout [FILE...]`.

use std::path::PathBuf;

use anyhow::{Context, Result};
use inhand_channels::{preview, take_topics};
use inhand_session::{Settings, containers};
use inhand_viewing::{Content, layout};

use crate::console::Console;
use crate::exit::Exit;
use crate::output::TextOutput;

/// Write a layout for Foxglove and Lichtblick: the hand, the object, plots
///
/// The layout shows the hand and the object, errors, distances and contacts as plots below them, findings and
/// events beside them. It fits the content of the files: recordings, takes, dictionaries, plans, overlays.
/// Without files it fits any take of `inhand run`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// MCAP files that will be shown together.
    #[arg(value_name = "FILE")]
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    output: TextOutput,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let inputs = &args.inputs;
    args.output.check(inputs)?;
    let content = if inputs.is_empty() {
        let methods = Settings::default().plan.methods;
        let names: Vec<_> = methods.iter().map(|method| method.name()).collect();
        Content::of_topics(take_topics(&names)?)
    } else {
        let mut content = Content::default();
        for path in inputs {
            let mut source = containers::open(path)?;
            let found = preview(&mut source);
            content.add(found.with_context(|| format!("cannot look into {}", path.display()))?);
        }
        content
    };
    let layout = layout(&content).with_context(|| {
        let names: Vec<_> = inputs.iter().map(|p| p.display().to_string()).collect();
        format!("no layout for {}", names.join(", "))
    })?;
    if !content.is_ours() {
        console.say(
            "warning  no channel of inhand: visualisations of other programs are shown as they are",
        );
    }
    args.output.write(console, &format!("{layout:#}\n"))?;
    if args.output.output.is_some() {
        console.say("import it in Foxglove or Lichtblick: Layouts, Import from file");
    }
    Ok(Exit::Done)
}
