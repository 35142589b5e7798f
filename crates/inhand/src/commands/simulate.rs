//! `inhand simulate -o DIR`.

use std::path::PathBuf;

use anyhow::Result;
use clap::ValueEnum;
use inhand_model::Shape;
use inhand_session::{TakeFormat, simulate_session};
use inhand_simulation::{FaultSettings, GapSettings, SessionSettings};

use crate::console::{Console, data};
use crate::exit::Exit;

/// Simulate a session: a hand that turns a cube or cylinder, as Motive CSV or MCAP takes.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Folder for the session.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Object: cube:EDGE or cylinder:DIAMETERxHEIGHT, metres.
    #[arg(long, default_value = "cube:0.05", value_name = "SHAPE")]
    object: String,
    /// Training takes.
    #[arg(long, default_value_t = 5, value_name = "N")]
    takes: usize,
    /// Test takes.
    #[arg(long, default_value_t = 1, value_name = "N")]
    test_takes: usize,
    /// Length of each take, seconds.
    #[arg(long, default_value_t = 120.0, value_name = "SECONDS")]
    duration: f64,
    /// Sample rate, Hz.
    #[arg(long, default_value_t = 100.0, value_name = "HZ")]
    rate: f64,
    /// Seed; the same seed gives the same session.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Share of fingertip samples lost in gaps.
    #[arg(long, default_value_t = 0.0, value_name = "SHARE")]
    gaps: f64,
    /// Plant what goes wrong in captures: 2 % gaps, and a minute 10 swapped labels, 5 flipped bodies,
    /// 20 spikes, 3 lost labels; where is written beside each take as TAKE.truth.json.
    #[arg(long, conflicts_with = "gaps")]
    faults: bool,
    /// Track the object in the training takes too.
    #[arg(long)]
    track_object: bool,
    /// Format of the takes.
    #[arg(long, value_enum, default_value_t = Format::Csv)]
    format: Format,
    /// Replace takes that are there.
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Motive CSV 1.23.
    Csv,
    /// MCAP recordings.
    Mcap,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let shape: Shape = args.object.parse()?;
    let mut settings = SessionSettings::new(shape);
    settings.train_takes = args.takes;
    settings.test_takes = args.test_takes;
    settings.track_object_in_training = args.track_object;
    settings.duration_s = args.duration;
    settings.rate_hz = args.rate;
    settings.gaps = (args.gaps != 0.0).then(|| GapSettings::with_share(args.gaps));
    settings.faults = args.faults.then(FaultSettings::bad_session);
    let format = match args.format {
        Format::Csv => TakeFormat::MotiveCsv,
        Format::Mcap => TakeFormat::Mcap,
    };
    let files = simulate_session(&args.output, &settings, args.seed, format, args.force)?;
    let listed: String = files
        .iter()
        .map(|file| format!("{}\n", file.display()))
        .collect();
    data(&listed)?;
    console.say(&format!(
        "inhand run {} -o results    runs it",
        args.output.display()
    ));
    Ok(Exit::Done)
}
