//! `inhand convert INPUT... -o OUTPUT`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use inhand_channels::TakeFile;
use inhand_model::{BodySource, Finger, PerFinger, Recording, Roles};
use inhand_pipeline::check_target;
use inhand_pipeline::{
    PipelineError, Take, describe_source, provenance, write_atomic, write_take_parts,
};

use crate::commands::{check_take_target, read_takes, targets};
use crate::console::Console;
use crate::exit::{Exit, UsageError};
use crate::options::{OutputOptions, SourceOptions};

/// Converts takes (Motive CSV, Qualisys TSV, TRC) to MCAP recordings; with an output that ends in
/// .csv, a recording to Motive CSV 1.23. Any take converts, whether or not it has a hand in it.
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

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let settings = args.source.effective(None)?;
    let to_csv = args
        .output
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("csv"));
    if to_csv && args.inputs.len() > 1 {
        let message = "-o names one .csv file: expected one input, or a folder for several";
        return Err(UsageError(message.to_owned()).into());
    }
    let targets = targets(&args.inputs, &args.output, "mcap")?;
    let inputs: Vec<_> = args.inputs.iter().map(PathBuf::as_path).collect();
    let takes = read_takes(console, &args.inputs, &settings)?;
    for (take, target) in takes.iter().zip(&targets) {
        if to_csv {
            check_target(target, &inputs, || args.writing.force)?;
        } else {
            check_take_target(target, &inputs, take, args.writing.force)?;
        }
    }
    for (take, target) in takes.iter().zip(&targets) {
        describe(console, take);
        if to_csv {
            write_csv(target, &take.recording)?;
        } else {
            let mut chain = take.provenance.clone();
            chain.push(provenance("convert", &settings, [take.hash.clone()]));
            let file = TakeFile {
                roles: take.roles.as_ref().ok(),
                object_shape: settings.shape()?,
                annotations: Some(&take.annotations),
                provenance: &chain,
                ..TakeFile::new(&take.recording)
            };
            write_take_parts(target, &file, !args.writing.no_view)?;
        }
        let megabytes = std::fs::metadata(target)?.len() as f64 / 1e6;
        console.say(&format!("wrote {} ({megabytes:.1} MB)", target.display()));
    }
    Ok(Exit::Done)
}

fn write_csv(target: &Path, recording: &Recording) -> Result<()> {
    Ok(write_atomic(target, |out| {
        inhand_capture::motive::write(recording, out).map_err(|source| PipelineError::Capture {
            path: target.to_owned(),
            source: source.into(),
        })
    })?)
}

/// Says what a take holds: the lines a person checks before going on.
fn describe(console: &Console, take: &Take) {
    let recording = &take.recording;
    let source = &recording.source;
    let rotation = source
        .rotation
        .map_or_else(|| "no rotations".to_owned(), |order| order.to_string());
    console.say(&format!(
        "{}, {} Hz, {} frames, {}, {rotation}, {} up",
        source.format,
        recording.clock.rate_hz(),
        recording.len(),
        source.length_unit.name(),
        source.up_axis.name().to_uppercase(),
    ));
    match &take.roles {
        Ok(roles) => describe_roles(console, recording, roles),
        Err(message) => {
            console
                .say("the roles of hand, object and fingers cannot all be told; the recording is");
            console.say("kept whole, and later steps need to be told:");
            console.say(&format!("  {}", message.replace('\n', "\n  ")));
        }
    }
}

fn describe_roles(console: &Console, recording: &Recording, roles: &Roles) {
    let body = |name: &str, source: &BodySource| {
        let tracked = match source {
            BodySource::RigidBody(body) => recording.body(body).map(|body| {
                let counts = body.track.counts();
                counts.measured as f64 / recording.len().max(1) as f64
            }),
            BodySource::Markers(_) => None,
        };
        let share = tracked.map_or_else(String::new, |t| format!("  {:.1} % tracked", t * 100.0));
        console.say(&format!("{name:<8} {}{share}", describe_source(source)));
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
    let gaps = gaps(recording, &roles.fingers);
    console.say(&format!(
        "gaps     {}",
        if gaps.is_empty() { "none" } else { &gaps }
    ));
}

fn gaps(recording: &Recording, fingers: &PerFinger<String>) -> String {
    let of_finger = |finger: Finger| {
        let marker = recording.marker(&fingers[finger])?;
        let gaps = marker.track.gaps();
        let missing: usize = gaps.iter().map(ExactSizeIterator::len).sum();
        let longest = gaps.iter().map(ExactSizeIterator::len).max()?;
        Some(format!(
            "{finger} {:.1} % (longest {:.2} s)",
            100.0 * missing as f64 / recording.len() as f64,
            recording.clock.time_s(longest)
        ))
    };
    Finger::ALL
        .into_iter()
        .filter_map(of_finger)
        .collect::<Vec<_>>()
        .join(", ")
}
