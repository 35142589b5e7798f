//! `inhand simulate -o DIR`.

use std::path::PathBuf;

use anyhow::Result;
use inhand_model::Shape;
use inhand_session::{TakeFormat, simulate_session};
use inhand_simulation::{FaultSettings, GapSettings, SessionSettings};

use crate::console::{Console, data};
use crate::exit::Exit;
use crate::interrupt;
use crate::options::one_of;

/// Simulate a session of a hand that turns a cube or cylinder, as Motive CSV or MCAP takes.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Folder for the session.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Object: cube:EDGE or cylinder:DIAMETERxHEIGHT, metres.
    #[arg(long, default_value = "cube:0.05", value_name = "SHAPE")]
    object: Shape,
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
    /// Add the faults of real captures, listed in TAKE.truth.json.
    ///
    /// 2 % gaps, and in each minute 10 swapped labels, 5 flipped bodies, 20 spikes and 3 lost labels.
    #[arg(long, conflicts_with = "gaps")]
    faults: bool,
    /// Track the object in the training takes too.
    #[arg(long)]
    track_object: bool,
    /// Format of the takes: csv (Motive CSV 1.23), or mcap with lengths to a micrometre.
    #[arg(long, value_parser = one_of(&FORMATS), default_value = "csv")]
    format: TakeFormat,
    /// Replace takes that exist.
    #[arg(long)]
    force: bool,
}

const FORMATS: [(&str, TakeFormat); 2] =
    [("csv", TakeFormat::MotiveCsv), ("mcap", TakeFormat::Mcap)];

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let shape = args.object;
    let mut settings = SessionSettings::new(shape);
    settings.train_takes = args.takes;
    settings.test_takes = args.test_takes;
    settings.track_object_in_training = args.track_object;
    settings.take.duration_s = args.duration;
    settings.take.rate_hz = args.rate;
    settings.take.gaps = (args.gaps != 0.0).then(|| GapSettings::with_share(args.gaps));
    settings.faults = args.faults.then(FaultSettings::bad_session);
    interrupt::keeps("the takes written so far are kept; --force writes them again");
    let files = simulate_session(&args.output, &settings, args.seed, args.format, args.force)?;
    let lines = files.iter().map(|file| format!("{}\n", file.display()));
    data(&lines.collect::<String>())?;
    console.say(&format!(
        "inhand run {} -o results    runs it",
        args.output.display()
    ));
    Ok(Exit::Done)
}
