//! Command line of inhand: parses arguments, runs a command, sets the exit code.

mod commands;
mod console;
mod examples;
mod exit;
mod options;
mod output;

use clap::{CommandFactory, FromArgMatches, Parser};

use crate::commands::Command;
use crate::console::Console;
use crate::exit::Exit;

/// Turn motion capture of a hand into evaluated, reproducible in-hand manipulation trajectories.
///
/// A session is a folder with train/ and test/ takes: Motive CSV, Qualisys TSV, TRC, C3D or MCAP.
/// `inhand run SESSION -o OUT` does everything; `inhand demo` shows it on a simulated session.
#[derive(Debug, Parser)]
#[command(name = "inhand", version, max_term_width = 100, after_help = exit::HELP)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Number of threads; 0 for all cores.
    ///
    /// At most 256. Results do not depend on it.
    #[arg(long, global = true, default_value_t = 0, value_name = "N",
          value_parser = clap::value_parser!(u16).range(0..=256))]
    threads: u16,
    /// Print only results and errors.
    #[arg(long, short, global = true)]
    quiet: bool,
}

fn main() -> std::process::ExitCode {
    let matches = examples::with_examples(Cli::command()).get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let console = Console { quiet: cli.quiet };
    // The pool is built once, here; it can only fail where the system refuses threads.
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(usize::from(cli.threads))
        .build_global();
    let result = match pool {
        Ok(()) => cli.command.run(&console),
        Err(error) => Err(anyhow::Error::new(error).context("cannot start threads")),
    };
    let exit = result.unwrap_or_else(|error| {
        let exit = Exit::from_error(&error);
        if exit != Exit::Done {
            console.error(&error);
        }
        exit
    });
    exit.into()
}
