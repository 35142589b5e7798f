//! `inhand convert INPUT... -o OUTPUT`.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use inhand_channels::TakeFile;
use inhand_model::{BodySource, Finger, InputHash, PerFinger, Recording, Roles};
use inhand_session::{
    Coverage, Located, LongTake, LongTakeFacts, Settings, Take, check_target, describe_source,
    provenance, write_atomic, write_take_parts,
};

use crate::commands::{check_take_target, say_findings, targets};
use crate::console::Console;
use crate::exit::{Exit, UsageError};
use crate::options::{OutputOptions, SourceOptions};

/// Convert takes (Motive CSV, Qualisys TSV, TRC, C3D, ROS 2 bags and other MCAP recordings) to MCAP
/// recordings; with an output that ends in .csv, .trc or .c3d, a recording to Motive CSV 1.23, TRC or
/// C3D. Any take converts, whether or not it has a hand in it.
///
/// TRC and C3D hold markers alone: a take without any is refused, and where rigid bodies are left out
/// the exit code is 3. TRC is written with Y up, turned where Z is.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Takes.
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// Output file; a folder for several inputs.
    #[arg(short, long, value_name = "PATH")]
    output: PathBuf,
    #[command(flatten)]
    source: SourceOptions,
    #[command(flatten)]
    writing: OutputOptions,
}

/// A take as far as its length allows.
enum Input {
    /// On disk; its samples are read again to be written.
    Long(Box<LongTake>),
    /// In memory.
    Whole(Box<Take>),
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let settings = args.source.effective(None)?;
    let vendor = VendorFormat::of(&args.output);
    if vendor.is_some() && args.inputs.len() > 1 {
        let message = "-o names one file: expected one input, or a folder for several";
        return Err(UsageError(message.to_owned()).into());
    }
    let targets = targets(&args.inputs, &args.output, "mcap")?;
    let inputs: Vec<_> = args.inputs.iter().map(PathBuf::as_path).collect();
    let mut takes = Vec::with_capacity(inputs.len());
    for path in &inputs {
        let take = Input::read(path, &settings, vendor.is_some())?;
        say_findings(console, take.hash(), take.header());
        takes.push(take);
    }
    for (take, target) in takes.iter().zip(&targets) {
        if vendor.is_some() {
            check_target(target, &inputs, || args.writing.force)?;
        } else {
            check_take_target(target, &inputs, take.hash(), args.writing.force)?;
        }
    }
    if let Some(format) = vendor {
        for (take, path) in takes.iter().zip(&inputs) {
            format.check(path, take.header())?;
        }
    }
    let mut exit = Exit::Done;
    for (take, target) in takes.iter().zip(&targets) {
        take.describe(console);
        match (take, vendor) {
            (Input::Whole(take), Some(format)) => {
                if write_vendor(console, target, format, take)? > 0 {
                    exit = Exit::Lossy;
                }
            }
            _ => take.write(target, &settings, !args.writing.no_view)?,
        }
        let megabytes = std::fs::metadata(target)?.len() as f64 / 1e6;
        console.say(&format!("wrote {} ({megabytes:.1} MB)", target.display()));
    }
    Ok(exit)
}

impl Input {
    fn read(path: &Path, settings: &Settings, whole: bool) -> Result<Self> {
        if !whole && let Some(take) = LongTake::open(path, settings)? {
            return Ok(Input::Long(Box::new(take)));
        }
        let take = inhand_session::read(path, settings)?;
        Ok(Input::Whole(Box::new(take)))
    }

    fn hash(&self) -> &InputHash {
        match self {
            Input::Long(take) => &take.hash,
            Input::Whole(take) => &take.hash,
        }
    }

    /// What holds for the whole take.
    fn header(&self) -> &Recording {
        match self {
            Input::Long(take) => &take.header,
            Input::Whole(take) => &take.recording,
        }
    }

    fn write(&self, target: &Path, settings: &Settings, view: bool) -> Result<()> {
        let made = provenance("convert", settings, [self.hash().clone()]);
        let object_shape = settings.shape()?;
        match self {
            Input::Long(take) => take.write(
                target,
                LongTakeFacts {
                    provenance: &[made],
                    object_shape,
                    view,
                },
            )?,
            Input::Whole(take) => {
                let mut chain = take.provenance.clone();
                chain.push(made);
                let file = TakeFile {
                    roles: take.roles.as_ref().ok(),
                    object_shape,
                    annotations: Some(&take.annotations),
                    provenance: &chain,
                    cleaned: take.cleaned(),
                    ..TakeFile::new(take.measured())
                };
                write_take_parts(target, &file, view)?;
            }
        }
        Ok(())
    }

    /// Says what a take holds: the lines a person checks before going on.
    fn describe(&self, console: &Console) {
        match self {
            Input::Long(take) => describe(console, &take.header, &take.coverage, &take.roles),
            Input::Whole(take) => {
                let coverage = Coverage::of(&take.recording);
                describe(console, &take.recording, &coverage, &take.roles);
            }
        }
    }
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
    fn of(path: &Path) -> Option<Self> {
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

    /// Refuses a take of which nothing would be left.
    fn check(self, input: &Path, recording: &Recording) -> Result<()> {
        if self.holds_bodies() || !recording.markers.is_empty() {
            return Ok(());
        }
        bail!(
            "{}: expected markers, which are all that TRC and C3D hold, found none beside {}: \
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

/// Writes a take and says how many bodies are left out of it.
fn write_vendor(
    console: &Console,
    target: &Path,
    format: VendorFormat,
    take: &Take,
) -> Result<usize> {
    format.write(target, &take.recording)?;
    let left_out = if format.holds_bodies() {
        0
    } else {
        take.recording.bodies.len()
    };
    if left_out > 0 {
        let is = if left_out == 1 { "is" } else { "are" };
        console.say(&format!(
            "{} {is} left out: the format holds markers alone",
            bodies(left_out)
        ));
    }
    Ok(left_out)
}

fn bodies(count: usize) -> String {
    match count {
        1 => "1 body".to_owned(),
        _ => format!("{count} bodies"),
    }
}

fn describe(
    console: &Console,
    header: &Recording,
    coverage: &Coverage,
    roles: &Result<Roles, String>,
) {
    let source = &header.source;
    let rotation = source
        .rotation
        .map_or_else(|| "no rotations".to_owned(), |order| order.to_string());
    console.say(&format!(
        "{}, {} Hz, {} frames, {}, {rotation}, {} up",
        source.format,
        header.clock.rate_hz(),
        coverage.samples,
        source.length_unit.name(),
        source.up_axis.name().to_uppercase(),
    ));
    match roles {
        Ok(roles) => describe_roles(console, header, coverage, roles),
        Err(message) => {
            console
                .say("the roles of hand, object and fingers cannot all be told; the recording is");
            console.say("kept whole, and later steps need to be told:");
            console.say(&format!("  {}", message.replace('\n', "\n  ")));
        }
    }
}

fn describe_roles(console: &Console, header: &Recording, coverage: &Coverage, roles: &Roles) {
    let samples = coverage.samples.max(1) as f64;
    let body = |role: &str, source: &BodySource| {
        let tracked = match source {
            BodySource::RigidBody(name) => {
                let bodies = header.bodies.iter().zip(&coverage.bodies);
                let mut named = bodies.filter(|(body, _)| body.name == *name);
                (named.next()).map(|(_, presence)| presence.measured as f64 / samples)
            }
            BodySource::Markers(_) => None,
        };
        let share = tracked.map_or_else(String::new, |t| format!("  {:.1} % tracked", t * 100.0));
        console.say(&format!("{role:<8} {}{share}", describe_source(source)));
    };
    body("hand", &roles.hand);
    match &roles.object {
        Some(object) => body("object", object),
        None => console.say("object   none"),
    }
    let names: Vec<_> = roles
        .fingers
        .iter()
        .map(|(finger, marker)| format!("{finger} \"{marker}\""))
        .collect();
    console.say(&format!("fingers  {}", names.join(" · ")));
    let gaps = gaps(header, coverage, &roles.fingers);
    console.say(&format!(
        "gaps     {}",
        if gaps.is_empty() { "none" } else { &gaps }
    ));
}

fn gaps(header: &Recording, coverage: &Coverage, fingers: &PerFinger<String>) -> String {
    let of_finger = |finger: Finger| {
        let named = header.marker(&fingers[finger])?;
        let mut markers = header.markers.iter().zip(&coverage.markers);
        let (_, presence) = markers.find(|(marker, _)| std::ptr::eq(*marker, named))?;
        (presence.missing > 0).then(|| {
            format!(
                "{finger} {:.1} % (longest {:.2} s)",
                100.0 * presence.missing as f64 / coverage.samples as f64,
                header.clock.time_s(presence.longest_gap)
            )
        })
    };
    Finger::ALL
        .into_iter()
        .filter_map(of_finger)
        .collect::<Vec<_>>()
        .join(", ")
}
