//! `inhand demo`.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use inhand_model::Shape;
use inhand_session::{DEMO_SESSION, TakeFormat, simulate_session};
use inhand_simulation::SessionSettings;

use crate::commands::run::{ResultOptions, SessionOptions, run_shown};
use crate::console::Console;
use crate::exit::Exit;
use crate::options::{FailOn, Format};

/// Simulate a session (five takes of 120 s for training, one for testing) and run every step on it.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Folder for the session and the results.
    #[arg(short, long, value_name = "DIR", default_value = "demo")]
    output: PathBuf,
    /// Object: cube:EDGE or cylinder:DIAMETERxHEIGHT, metres.
    #[arg(long, default_value = "cube:0.05", value_name = "SHAPE")]
    object: Shape,
    /// Seed of the simulation.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    writing: ResultOptions,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let shape = args.object;
    let session = args.output.join(DEMO_SESSION);
    let simulated = SessionSettings::new(shape);
    let begin = Instant::now();
    let line = format!(
        "simulating a session: {shape}, {} takes of {} s for training, {} for testing",
        simulated.train_takes, simulated.take.duration_s, simulated.test_takes
    );
    let task = console.step(&line);
    // A session of an earlier demo may be replaced.
    let again = args.writing.output.force || session.join(inhand_session::SETTINGS_FILE).is_file();
    simulate_session(&session, &simulated, args.seed, TakeFormat::Mcap, again)?;
    drop(task);
    console.step_done(&line, begin.elapsed());

    let options =
        SessionOptions::default().run_options(console, &session, &args.output, &args.writing)?;
    run_shown(console, &options, Format::Text, FailOn::default())
}
