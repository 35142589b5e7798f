//! `inhand layout [FILE...]`.

use std::path::PathBuf;

use anyhow::{Context, Result};
use inhand_channels::{opening, take_topics};
use inhand_session::{Settings, check_target, containers, write_text};
use inhand_viewing::{Content, layout};

use crate::console::{Console, data};
use crate::exit::Exit;

/// Write a layout for Foxglove and Lichtblick: the hand, the object, plots
///
/// Writes a layout that Foxglove and Lichtblick import: the hand and the object from close by, errors,
/// distances and contacts as plots under them, findings and events beside them.
///
/// With files it suits what they have: recordings, takes, dictionaries, plans, overlays. Without, it
/// suits any take of `inhand run`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// MCAP files that will be looked at together.
    #[arg(value_name = "FILE")]
    inputs: Vec<PathBuf>,
    /// Output file [default: printed].
    #[arg(short, long, value_name = "JSON")]
    output: Option<PathBuf>,
    /// Replace an output that is there.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let inputs: Vec<_> = args.inputs.iter().map(PathBuf::as_path).collect();
    if let Some(output) = &args.output {
        check_target(output, &inputs, || args.force)?;
    }
    let content = if inputs.is_empty() {
        let methods = Settings::default().plan.methods;
        let names: Vec<_> = methods.iter().map(|method| method.name()).collect();
        Content::of_topics(take_topics(&names)?)
    } else {
        let mut content = Content::default();
        for path in &inputs {
            let mut source = containers::open(path)?;
            let found = opening(&mut source);
            content.add(found.with_context(|| format!("cannot look into {}", path.display()))?);
        }
        content
    };
    let layout = layout(&content).with_context(|| {
        let names: Vec<_> = inputs.iter().map(|p| p.display().to_string()).collect();
        format!("no layout for {}", names.join(", "))
    })?;
    if !content.is_ours() {
        console.say("warning  no channel of inhand: what others drew is shown as it is");
    }
    let text = format!("{layout:#}\n");
    match &args.output {
        Some(output) => {
            write_text(output, &text)?;
            console.say(&format!(
                "wrote {}: import it in Foxglove or Lichtblick (Layouts, Import from file)",
                output.display()
            ));
        }
        None => data(&text)?,
    }
    Ok(Exit::Done)
}
