//! Command line of inhand: parses arguments, runs a command, sets the exit code.

mod commands;
mod console;
mod describe;
mod examples;
mod exit;
mod input_settings;
mod interrupt;
mod options;
mod output;
mod progress;
#[cfg(test)]
mod tests;
mod visible;

use std::cell::{Cell, RefCell};
use std::ffi::OsString;
use std::io;

use clap::{ArgAction, CommandFactory, FromArgMatches, Parser};

use crate::commands::Command;
use crate::console::{Console, error_json};
use crate::exit::Exit;

/// Turn motion capture of a hand into evaluated, reproducible in-hand manipulation trajectories.
///
/// A session is a folder with train/ and test/ takes: Motive CSV, Qualisys TSV, TRC, C3D or MCAP.
/// `inhand run SESSION -o OUT` does everything; `inhand demo` shows it on a simulated session.
#[derive(Debug, Parser)]
#[command(name = "inhand", version, max_term_width = 100, after_help = exit::HELP,
          disable_help_flag = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Number of threads; 0 for all cores.
    ///
    /// At most 256. Results do not depend on it.
    #[arg(long, global = true, default_value_t = 0, value_name = "N",
          value_parser = clap::value_parser!(u16).range(0..=256))]
    threads: u16,
    /// Memory that a record, or all matrices of a file, may take unpacked, MiB.
    ///
    /// Protects against files of a few bytes that unpack to gigabytes. Raise it for a file to be trusted.
    #[arg(long, global = true, default_value_t = 512, value_name = "MIB",
          value_parser = clap::value_parser!(u64).range(1..=1 << 20))]
    memory_limit: u64,
    /// Print only results and errors.
    #[arg(long, short, global = true)]
    quiet: bool,
    /// Print help: the common options by -h, all by --help.
    #[arg(long, short, global = true, action = ArgAction::HelpShort)]
    help: Option<bool>,
}

fn main() -> std::process::ExitCode {
    // Of a command; the overview has the commands alone.
    let all_options = std::env::args_os().skip(2).any(|word| word == "--help");
    let matches = examples::with_examples(Cli::command(), all_options).try_get_matches();
    let cli = matches.and_then(|matches| {
        let verb = matches.subcommand_name().unwrap_or_default().to_owned();
        Ok((verb, Cli::from_arg_matches(&matches)?))
    });
    let (verb, cli) = cli.unwrap_or_else(|error| {
        if error.use_stderr() {
            print_json(&wrong_call(&error), Exit::Usage);
        }
        error.exit()
    });
    inhand_container::set_memory_limit(cli.memory_limit << 20);
    let console = Console {
        quiet: cli.quiet,
        once: RefCell::default(),
        lost: Cell::default(),
    };
    // The pool is built once, here; it can only fail where the system refuses threads.
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(usize::from(cli.threads))
        .build_global();
    let result = match pool
        .map_err(io::Error::other)
        .and_then(|()| interrupt::attend())
    {
        Ok(()) => {
            // Until the command knows more of its work.
            let _task = console.step(verb);
            cli.command.run(&console)
        }
        Err(error) => Err(anyhow::Error::new(error).context("cannot start threads")),
    };
    progress::wait_if_ending();
    let result = result.map(|exit| match exit {
        Exit::Done => Exit::done_unless(console.lost.get()),
        other => other,
    });
    let exit = result.unwrap_or_else(|error| {
        let exit = Exit::from_error(&error);
        if exit != Exit::Done {
            print_json(&error, exit);
            console.error(&error);
        }
        exit
    });
    exit.into()
}

/// Prints an error as JSON where results are wanted as JSON.
fn print_json(error: &anyhow::Error, exit: Exit) {
    let words: Vec<_> = std::env::args_os().collect();
    let is_json = |pair: &[OsString]| pair[0] == "--format" && pair[1] == "json";
    if words.iter().any(|word| word == "--format=json") || words.windows(2).any(is_json) {
        // There is no place to report a lost stdout but stderr, which names the error anyway.
        let _ = console::data(&format!("{:#}\n", error_json(error, exit)));
    }
}

/// A call that the parser refused, without its usage lines.
fn wrong_call(error: &clap::Error) -> anyhow::Error {
    let text = error.to_string();
    let message = text.split("\n\n").next().unwrap_or_default();
    anyhow::Error::msg(message.trim_start_matches("error: ").to_owned())
}
