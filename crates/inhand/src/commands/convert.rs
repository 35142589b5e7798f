//! `inhand convert INPUT... -o OUTPUT`.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use inhand_channels::Views;
use inhand_export::Ros2Bag;
use inhand_model::Recording;
use inhand_session::{
    BAG_FACTS, Located, Settings, TakeInput, is_stream, take_name, write_atomic, write_ros2,
    write_text,
};
use serde_json::{Value, json};

use crate::commands::{WRITING, file_part, files_task, say_findings, targets};
use crate::console::{Console, print};
use crate::exit::{Exit, usage};
use crate::options::{Format, OutputOptions, SourceOptions};
use crate::output::{check_output, check_outputs, write_output};

/// Convert takes to MCAP recordings, or a recording to Motive CSV 1.23, TRC or C3D.
///
/// Inputs are Motive CSV, Qualisys TSV, TRC, C3D, ROS 2 bags and other MCAP recordings, with or without a hand.
/// An output that ends in .csv, .trc or .c3d is written in that format.
///
/// TRC and C3D hold only markers: a take without any is refused, and the exit code is 3 where rigid bodies are left
/// out. TRC is written with Y up; takes with Z up are rotated.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Takes.
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// Output file; a folder for several inputs.
    #[arg(short, long, value_name = "PATH")]
    output: PathBuf,
    #[command(flatten, next_help_heading = "Source")]
    source: SourceOptions,
    /// Print the outcome as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Write ROS 2 bags: poses, points, /tf, /markers, trajectories of generated motion.
    ///
    /// An output without .mcap is a folder with metadata.yaml, for several inputs one with a bag each.
    #[arg(long)]
    ros2: bool,
    #[command(flatten)]
    writing: OutputOptions,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let settings = args.source.for_each(console, &args.inputs, &|_| ())?;
    if args.ros2 {
        return to_ros2(console, args, &settings);
    }
    let vendor = VendorFormat::from_path(&args.output);
    if vendor.is_some() && args.inputs.len() > 1 {
        return usage("-o names one file: expected one input, or a folder for several");
    }
    let inputs = &args.inputs;
    let targets = targets(inputs, &args.output, &["mcap", "csv", "trc", "c3d"])?;
    check_outputs(&targets, inputs)?;
    let mut takes = Vec::with_capacity(inputs.len());
    let task = files_task(console, "convert", inputs, 1.0 + WRITING);
    for (path, settings) in inputs.iter().zip(&settings) {
        file_part(&task, path, 1.0);
        let take = match vendor {
            None => TakeInput::open(path, settings)?,
            Some(_) => TakeInput::Whole(Box::new(inhand_session::read(path, settings)?)),
        };
        say_findings(console, take.hash(), take.header());
        takes.push(take);
    }
    if let Some(format) = vendor {
        (inputs.iter().zip(&takes))
            .try_for_each(|(path, take)| format.check(path, take.header()))?;
    }
    let (mut exit, mut files) = (Exit::Done, Vec::with_capacity(targets.len()));
    for (((input, take), target), settings) in
        inputs.iter().zip(&takes).zip(&targets).zip(&settings)
    {
        file_part(&task, input, WRITING);
        describe(console, take, settings.object.shape.as_deref());
        match (take, vendor) {
            (TakeInput::Whole(take), Some(format)) => {
                write_output(target, args.writing.force, |path| {
                    format.write(path, &take.recording)
                })?;
                let left_out = take.recording.bodies.len();
                if left_out > 0 && !format.holds_bodies() {
                    let bodies = bodies(left_out);
                    console.say(&format!(
                        "left out: {bodies}; the format holds only markers"
                    ));
                    exit = Exit::Lossy;
                }
            }
            _ => write_output(target, args.writing.force, |path| {
                take.convert(path, settings, args.writing.views)
            })?,
        }
        let bytes = std::fs::metadata(target)?.len();
        console.wrote_with(target, &format!("{:.1} MB", bytes as f64 / 1e6));
        files.push(as_json(take, (input, target), bytes));
    }
    print(args.format, String::new, || json!({ "files": files }))?;
    Ok(exit)
}

/// The facts of a take, for programs.
fn as_json(take: &TakeInput, (input, target): (&Path, &Path), bytes: u64) -> Value {
    let (header, roles) = (take.header(), take.roles());
    let facts = take.coverage().take_facts(header, roles.ok());
    json!({
        "input": input.display().to_string(),
        "output": target.display().to_string(),
        "bytes": bytes,
        "samples": facts.samples,
        "duration_s": facts.duration_s,
        "source": facts.source,
        "roles_error": roles.err(),
        "findings": header.findings,
    })
}

/// Writes each take as a ROS 2 bag.
fn to_ros2(console: &Console, args: &Args, settings: &[Settings]) -> Result<Exit> {
    if VendorFormat::from_path(&args.output).is_some() {
        return usage("--ros2: expected an output that ends in .mcap, or a folder");
    }
    let in_folder = in_folder(&args.output)?;
    let targets = match &args.inputs[..] {
        [input] if in_folder => vec![bag_file(&args.output, &take_name(input))],
        inputs => {
            let files = targets(inputs, &args.output, &["mcap"])?.into_iter();
            let bag = |file: PathBuf| match in_folder {
                true => bag_file(&file.with_extension(""), &take_name(&file)),
                false => file,
            };
            files.map(bag).collect()
        }
    };
    check_outputs(&targets, &args.inputs)?;
    if in_folder {
        for target in &targets {
            // Facts of another bag: those of this one are compared with it.
            let may_replace = || args.writing.force || target.exists();
            check_output(&target.with_file_name(BAG_FACTS), may_replace)?;
        }
    }
    let mut files = Vec::with_capacity(targets.len());
    let task = files_task(console, "convert", &args.inputs, 1.0);
    for ((input, target), settings) in args.inputs.iter().zip(&targets).zip(settings) {
        file_part(&task, input, 1.0);
        let take = Box::new(inhand_session::read(input, settings)?);
        say_findings(console, &take.hash, &take.recording);
        let write = |path: &Path| -> Result<Ros2Bag> {
            let bag = write_ros2(path, &take, settings, args.writing.views != Views::None)?;
            if in_folder {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                write_text(&path.with_file_name(BAG_FACTS), &bag.metadata_yaml(&name))?;
            }
            Ok(bag)
        };
        let bag = write_output(target, args.writing.force, write)?;
        let content = format!(
            "ROS 2 bag, {} topics, {} messages",
            bag.topics(),
            bag.messages
        );
        console.wrote_with(target, &content);
        let bytes = std::fs::metadata(target)?.len();
        files.push(as_json(&TakeInput::Whole(take), (input, target), bytes));
    }
    print(args.format, String::new, || json!({ "files": files }))?;
    Ok(Exit::Done)
}

/// Whether an output of bags is a folder: one that is there, or a path without an ending.
fn in_folder(output: &Path) -> Result<bool> {
    if is_stream(output) {
        return Ok(false);
    }
    match output.extension() {
        _ if output.is_dir() => Ok(true),
        None => Ok(true),
        Some(ending) if ending.eq_ignore_ascii_case("mcap") => Ok(false),
        Some(_) => usage(format!(
            "-o {}: expected an output that ends in .mcap, or a folder: one without an ending or one that exists",
            output.display()
        )),
    }
}

/// The file of a bag's folder, named as `ros2 bag record` does.
fn bag_file(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{name}_0.mcap"))
}

/// Formats of capture software that are written.
#[derive(Clone, Copy, PartialEq, Eq)]
enum VendorFormat {
    Csv,
    Trc,
    C3d,
}

impl VendorFormat {
    /// The format that a file's extension asks for.
    fn from_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        Some(match extension.as_str() {
            "csv" => VendorFormat::Csv,
            "trc" => VendorFormat::Trc,
            "c3d" => VendorFormat::C3d,
            _ => return None,
        })
    }

    /// Whether it holds rigid bodies; all hold markers.
    fn holds_bodies(self) -> bool {
        self == VendorFormat::Csv
    }

    /// Refuses a take without any data that the format holds.
    fn check(self, input: &Path, recording: &Recording) -> Result<()> {
        if self.holds_bodies() || !recording.markers.is_empty() {
            return Ok(());
        }
        bail!(
            "{}: expected markers, the only data that TRC and C3D hold, found none beside {}: \
             nothing is written; -o x.csv or -o x.mcap keeps bodies",
            input.display(),
            bodies(recording.bodies.len()),
        )
    }

    fn write(self, target: &Path, recording: &Recording) -> Result<()> {
        Ok(write_atomic(target, |out| {
            let written = match self {
                VendorFormat::Csv => inhand_capture::motive::write(recording, out),
                VendorFormat::Trc => inhand_capture::trc::write(recording, out),
                VendorFormat::C3d => inhand_capture::c3d::write(recording, out),
            };
            written.in_file(target)
        })?)
    }
}

fn bodies(count: usize) -> String {
    match count {
        1 => "1 body".to_owned(),
        _ => format!("{count} bodies"),
    }
}

/// Prints the facts of a take that a user checks before going on.
fn describe(console: &Console, take: &TakeInput, shape: Option<&str>) {
    let roles = take.roles();
    let facts = take.coverage().take_facts(take.header(), roles.ok());
    let text = inhand_report::takes_text(&[facts], shape);
    text.lines().for_each(|line| console.say(line));
    if let Err(message) = roles {
        console.say("could not identify every role of hand, object and fingers; the recording is");
        console.say("complete, but later steps need the roles:");
        console.say(&format!("  {}", message.replace('\n', "\n  ")));
    }
}
