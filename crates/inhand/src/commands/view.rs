//! `inhand view FILE... -o OUTPUT`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use inhand_session::{ViewedKind, add_views};
use serde_json::json;

use crate::commands::{file_part, files_task, targets};
use crate::console::{Console, print};
use crate::exit::Exit;
use crate::options::{Format, OutputOptions, SourceOptions};
use crate::output::{check_outputs, write_output};

/// Add visualisation channels to files
///
/// Takes, dictionaries and third-party recordings of motion capture get the channels that viewers draw without
/// set-up: a tree of frames, fingertips with trails, the object, generated motion. Earlier views are replaced;
/// everything else stays byte for byte. A ROS 2 bag gets markers (visualization_msgs/msg/MarkerArray) and stays one.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// MCAP files.
    #[arg(required = true, value_name = "FILE")]
    inputs: Vec<PathBuf>,
    /// Output file; a folder for several inputs.
    #[arg(short, long, value_name = "PATH")]
    output: PathBuf,
    /// Shape of the object [default: as the settings or the file state it], such as cube:0.05.
    ///
    /// In metres: cube:0.05, box:0.04x0.05x0.06 or cylinder:0.05x0.07.
    #[arg(long, value_name = "SHAPE")]
    object: Option<String>,
    /// Dictionary of the generated motion, whose training hulls are drawn [default: those of the file].
    #[arg(long, value_name = "FILE")]
    dictionary: Option<PathBuf>,
    #[command(flatten, next_help_heading = "Source")]
    source: SourceOptions,
    /// Print the outcome as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    #[command(flatten)]
    writing: OutputOptions,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let settings = (args.source).for_each(console, &args.inputs, &|settings| {
        settings.object.shape = args.object.clone().or(settings.object.shape.take());
    })?;
    let targets = targets(&args.inputs, &args.output, &["mcap"])?;
    let read: Vec<_> = args.inputs.iter().chain(&args.dictionary).collect();
    check_outputs(&targets, &read)?;
    let dictionary = (args.dictionary.as_deref()).map(inhand_session::read_dictionary);
    let dictionary = dictionary.transpose()?;
    let mut files = Vec::with_capacity(targets.len());
    let task = files_task(console, "adding views", &args.inputs, 1.0);
    for ((input, target), settings) in args.inputs.iter().zip(&targets).zip(&settings) {
        file_part(&task, input, 1.0);
        let write = |path: &Path| {
            add_views(
                input,
                path,
                dictionary.as_ref(),
                args.writing.views,
                settings,
            )
        };
        let viewed = write_output(target, args.writing.force, write)?;
        for finding in &viewed.findings {
            console.finding(&input.display().to_string(), finding);
        }
        let had = match (viewed.kind, viewed.replaced) {
            (_, 0) => String::new(),
            (ViewedKind::Dictionary, _) if viewed.messages > 0 => {
                ", which dictionaries always have".to_owned()
            }
            (_, replaced) => format!(" in place of {replaced}"),
        };
        let as_ros2 = (viewed.ros2_topic).map_or_else(String::new, |topic| {
            format!(" on {topic} as visualization_msgs/msg/MarkerArray, which ROS tools read")
        });
        let content = format!("{} messages for viewers{as_ros2}{had}", viewed.messages);
        console.wrote_with(target, &content);
        files.push(json!({
            "input": input.display().to_string(),
            "output": target.display().to_string(),
            "kind": match viewed.kind {
                ViewedKind::Take => "take",
                ViewedKind::Foreign => "third_party",
                ViewedKind::Dictionary => "dictionary",
            },
            "messages": viewed.messages,
            "replaced": viewed.replaced,
            "findings": viewed.findings,
        }));
    }
    print(args.format, String::new, || json!({ "files": files }))?;
    Ok(Exit::Done)
}
