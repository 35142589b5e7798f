//! `inhand run SESSION -o OUT`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::ArgAction;
use inhand_inspection::CUT_SHORT;
use inhand_model::{Inspection, Level, SessionFinding};
use inhand_session::{
    Event, OutputScope, RunOptions, Settings, TakeEntry, is_take, list_takes, locate, take_name,
};

use crate::console::{Console, data, wrapped};
use crate::exit::Exit;
use crate::interrupt;
use crate::options::{
    EvaluateOptions, FailOn, Format, LearnOptions, LookOptions, MethodOptions, OutputOptions,
    PlanOptions, TakeOptions, check_accepted, one_of,
};

/// Files that are no takes that are named at most.
const SKIPPED_SHOWN: usize = 3;

/// Steps of a run and their shares of its time: six takes of a minute, two threads.
const SHARES: [(&str, f64); 14] = [
    ("read", 0.05),
    ("hand_frame", 0.01),
    ("look", 0.05),
    ("filter", 0.02),
    ("learn", 0.22),
    (DICTIONARY_USED, 0.09),
    ("contacts", 0.01),
    ("evaluate", 0.05),
    ("motion", 0.08),
    ("held_out", 0.09),
    ("intervals", 0.04),
    ("write", 0.09),
    ("illustrate", 0.04),
    ("report", 0.16),
];

/// The first step after the dictionary is written.
const DICTIONARY_USED: &str = "generate";

/// Run every step on a session.
///
/// Reads its takes; writes an MCAP file for each, dictionary, evaluation.json and report.html.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Folder with train/ and test/ takes, an inhand.toml, or one take, which is split by time.
    session: PathBuf,
    /// Folder for the results.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Print the evaluation as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    #[command(flatten)]
    overrides: SessionOptions,
    /// Write planned and recorded positions into rows.parquet too (2.7 times its size).
    #[arg(long, help_heading = "Evaluation")]
    row_positions: bool,
    #[command(flatten)]
    writing: ResultOptions,
}

/// Writing of the results of a session.
#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct ResultOptions {
    #[command(flatten)]
    pub(crate) output: OutputOptions,
    /// Takes that are written: test or all (training takes too: 8 MB for 120 s at 100 Hz).
    #[arg(
        long = "takes",
        value_name = "WORD",
        hide_possible_values = true,
        default_value = "test",
        action = ArgAction::Set,
        value_parser = one_of(&[("test", false), ("all", true)])
    )]
    train_takes: bool,
    /// Methods in test takes: compared (default and best baseline) or all (3.4 MB each, for 120 s).
    #[arg(
        long = "take-methods",
        value_name = "WORD",
        hide_possible_values = true,
        default_value = "compared",
        action = ArgAction::Set,
        value_parser = one_of(&[("compared", false), ("all", true)])
    )]
    all_methods: bool,
}

/// Every setting of a session as an option.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct SessionOptions {
    /// Participant, for tables over sessions.
    #[arg(long, value_name = "NAME", help_heading = "Session")]
    participant: Option<String>,
    /// Task, for tables over sessions.
    #[arg(long, value_name = "NAME", help_heading = "Session")]
    task: Option<String>,
    /// Share of one recording, at its end, that is for testing [default: 0.2].
    #[arg(long, value_name = "SHARE", help_heading = "Session")]
    test_share: Option<f64>,
    #[command(flatten)]
    takes: TakeOptions,
    #[command(flatten, next_help_heading = "Inspection")]
    pub(crate) look: LookOptions,
    #[command(flatten, next_help_heading = "Learning")]
    learn: LearnOptions,
    #[command(flatten, next_help_heading = "Generation")]
    method: MethodOptions,
    #[command(flatten)]
    plan: PlanOptions,
    #[command(flatten, next_help_heading = "Evaluation")]
    evaluate: EvaluateOptions,
}

impl SessionOptions {
    /// Settings file, if any, with these options on top.
    fn settings(&self, beside: Option<&Path>) -> Result<Settings> {
        let mut settings = self.takes.settings(beside)?;
        settings.participant = self.participant.clone().or(settings.participant);
        settings.task = self.task.clone().or(settings.task);
        settings.segments.test_share = self.test_share.unwrap_or(settings.segments.test_share);
        self.look.apply(&mut settings);
        self.learn.check_one_rank()?;
        self.learn.apply(&mut settings);
        self.method.apply(&mut settings);
        self.plan.apply(&mut settings);
        self.evaluate.apply(&mut settings);
        settings.validate()?;
        Ok(settings)
    }

    /// A run of a session, or of one take by the settings of the session that it is in, with these options.
    pub(crate) fn run_options(
        &self,
        console: &Console,
        session: &Path,
        output: &Path,
        writing: &ResultOptions,
    ) -> Result<RunOptions> {
        let place = locate(session)?;
        let beside = match place.take {
            Some(_) => self.takes.source.file(console, &[session])?,
            None => place.settings.clone(),
        };
        let mut settings = self.settings(beside.as_deref())?;
        if let Some(path) = place.take {
            // The name of a session that the take is one of several of is not that of the take.
            if self.takes.source.settings.is_none() && place.settings.is_none() {
                settings.name = None;
            }
            settings.name = settings.name.or(Some(take_name(session)));
            let (role, from_s, to_s) = (None, None, None);
            settings.takes = vec![TakeEntry {
                path,
                role,
                from_s,
                to_s,
            }];
        }
        Ok(RunOptions {
            folder: place.folder,
            settings,
            output: output.to_owned(),
            force: writing.output.force,
            scope: OutputScope {
                views: writing.output.views,
                train_takes: writing.train_takes,
                all_methods: writing.all_methods,
                row_positions: false,
            },
            command: std::env::args().collect(),
        })
    }
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let mut options =
        (args.overrides).run_options(console, &args.session, &args.output, &args.writing)?;
    options.scope.row_positions = args.row_positions;
    // Entries of a session's file may be for other takes than the one that is run.
    if args.overrides.look.is_typed() || !is_take(&args.session) {
        let takes = list_takes(&options.folder, &options.settings)?.takes;
        let names: Vec<_> = takes.into_iter().map(|take| take.name).collect();
        check_accepted(&options.settings.look.accept, &names)?;
    }
    run_shown(console, &options, args.format, args.overrides.look.fail_on)
}

/// Runs a session, shows its steps and prints the results.
pub(crate) fn run_shown(
    console: &Console,
    options: &RunOptions,
    format: Format,
    fail_on: FailOn,
) -> Result<Exit> {
    let mut printed = Ok(());
    let task = console.task("run", 1.0);
    let mut watch = |event: Event<'_>| match event {
        Event::Started(name) => {
            task.part(name, share(name));
            if name == DICTIONARY_USED {
                interrupt::keeps(format!(
                    "{} is unfinished; its dictionary is kept, and the same command goes on from there",
                    options.output.display()
                ));
            }
        }
        Event::Finished(line, elapsed) => console.step_done(line, elapsed),
        Event::Took(session) if format == Format::Text => {
            printed = data(&inhand_report::session_text(session));
        }
        Event::Took(_) => {}
        Event::Found(finding) => console.say(&finding_line(finding)),
        Event::Skipped(files) => console.say(&skipped_line(files)),
        Event::Removed(files) => console.say(&removed_line(files)),
    };
    if let Some(line) = split_line(&options.settings) {
        console.say(&line);
    }
    let result = inhand_session::run(options, &mut watch)?;
    drop(task);
    printed?;
    let (files, evaluation) = (&result.files, &result.evaluation);
    let inspection = evaluation.inspection.as_ref();
    if let Some(line) = inspection.and_then(inhand_report::inspection_sentence) {
        console.say(&line);
    }
    if result.up_to_date {
        console.say("up to date: inputs, settings and version have not changed");
    }
    data(&match format {
        Format::Text => format!("\n{}\n", wrapped(&inhand_report::text_summary(evaluation))),
        Format::Json => std::fs::read_to_string(&files.evaluation)?,
    })?;
    console.say(&format!("{:<36} open in a browser", files.report.display()));
    if let Some(take) = files.takes.last() {
        let viewers = "open in Foxglove, Lichtblick or Rerun";
        console.say(&format!("{:<36} {viewers}", take.display()));
    }
    if result.failed_plans > 0 {
        console.say(&format!(
            "{} plans have no trajectory: see the report",
            result.failed_plans
        ));
    }
    Ok(Exit::done_unless(
        result.failed_plans > 0 || inspection.is_some_and(|found| fails(found, fail_on)),
    ))
}

/// Share of a step of the time of a run; a step that is not known takes little.
pub(crate) fn share(step: &str) -> f64 {
    let known = SHARES.iter().find(|(name, _)| *name == step);
    known.map_or(0.01, |(_, share)| *share)
}

/// A finding with its level, for a terminal.
pub(crate) fn finding_line(finding: &SessionFinding) -> String {
    format!("{:<8} {finding}", finding.level.name())
}

/// Takes of an earlier run that are gone, for a terminal.
pub(crate) fn removed_line(files: &[PathBuf]) -> String {
    let names = files
        .iter()
        .map(|file| file.file_name().unwrap_or_default().to_string_lossy());
    let names: Vec<_> = names.collect();
    format!(
        "removed, not written by this run (--takes all writes training takes): {}",
        names.join(", ")
    )
}

/// Files that are no takes, for a terminal.
pub(crate) fn skipped_line(files: &[PathBuf]) -> String {
    let (shown, rest) = files.split_at(files.len().min(SKIPPED_SHOWN));
    let shown: Vec<_> = shown
        .iter()
        .map(|file| file.display().to_string())
        .collect();
    let more = match rest.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("not takes, left out: {}{more}", shown.join(", "))
}

/// The roles of recordings that are split by time, for a terminal.
fn split_line(settings: &Settings) -> Option<String> {
    let split: Vec<_> = (settings.takes.iter())
        .filter(|take| take.role.is_none())
        .map(|take| take.path.display().to_string())
        .collect();
    let share = (1e5 * settings.segments.test_share).round() / 1e3;
    (!split.is_empty()).then(|| {
        format!(
            "{}: the first {} % is for training, the last {share} % for testing (--test-share)",
            split.join(", "),
            100.0 - share
        )
    })
}

/// Whether findings that are not accepted are of the level from which a command exits with 3.
pub(crate) fn fails(inspection: &Inspection, fail_on: FailOn) -> bool {
    let mut cut = inspection.counted(Level::Info);
    let counted = inspection.counted(Level::Info);
    cut.any(|finding| finding.id == CUT_SHORT)
        || fail_on.is_met(counted.map(|finding| finding.level).max())
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, FromArgMatches};

    use super::*;

    #[derive(Debug, clap::Parser)]
    struct Call {
        #[command(flatten)]
        options: SessionOptions,
    }

    #[test]
    fn defaults_in_the_help_are_those_of_the_settings() {
        let mut count = 0;
        for arg in Call::command().get_arguments() {
            let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
            let stated = help.split_once("[default: ").map(|(_, rest)| rest);
            let Some(value) = stated.and_then(|rest| rest.strip_suffix(']')) else {
                continue;
            };
            // Other defaults depend on the takes.
            if value.contains(' ') {
                continue;
            }
            let flag = format!("--{}", arg.get_long().expect("every setting has a flag"));
            let call = ["inhand", flag.as_str(), value];
            let matches = Call::command()
                .try_get_matches_from(call)
                .expect("it parses");
            let call = Call::from_arg_matches(&matches).expect("it parses");
            let settings = call.options.settings(None).expect("it is valid");
            assert_eq!(settings, Settings::default(), "{flag} {value}");
            count += 1;
        }
        assert!(count > 25, "{count}");
    }
}
