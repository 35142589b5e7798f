//! `inhand learn TAKE... -o DICTIONARY`, and the steps of a run that is spread over processes.

mod steps;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Result;
use clap::Subcommand;
use inhand_model::{DictionaryKind, Inspection, Level, StopReason};
use inhand_session::containers::hash_file;
use inhand_session::{
    Settings, Take, already_exists, claim_folder, hash_take, look_at_training, matrices,
    provenance, read_dictionary, scratch_folder, take_name, write_dictionary,
};
use inhand_training::{Learned, LearningFolder, Progress, learn_given, learn_in};
use serde_json::json;

use crate::commands::learn_rank::{self, RankChoice};
use crate::commands::run::{fails, finding_line};
use crate::commands::say_findings;
use crate::console::{Console, print};
use crate::exit::{Exit, UsageError, usage};
use crate::interrupt;
use crate::options::{
    Format, LearnOptions, LookOptions, MethodOptions, TakeOptions, check_accepted,
};
use crate::output::{check_outputs, ending, reads, write_output};
use crate::progress::Task;

/// Learn a dictionary of motion primitives from takes.
///
/// Takes with processed channels are used as they are, others are processed first. Memory does not grow with the
/// number of segments, except for ranges of ranks.
///
/// A run can also use several processes or machines that share a folder: `learn init` once, then
/// `learn stats` for every shard and `learn update` until it prints that learning has stopped, then
/// `learn finish`. The result has the same bits.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct Args {
    #[command(subcommand)]
    step: Option<Step>,
    /// Training takes.
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// Dictionary file.
    #[arg(short, long, value_name = "FILE", required = true)]
    output: Option<PathBuf>,
    /// Keep rounds in this folder; an interrupted run continues from it.
    #[arg(long, value_name = "FOLDER")]
    work: Option<PathBuf>,
    /// Use the primitives of a .npz or .mat file, and learn the rest.
    ///
    /// They are `primitives` or `W`, or scikit-learn's `components_`; with `offset_m`, the offset of the data.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["work", "rank", "restarts"], hide_short_help = true)]
    primitives: Option<PathBuf>,
    /// Print the outcome as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    #[command(flatten)]
    options: RunOptions,
    /// Replace an output that exists.
    #[arg(long)]
    force: bool,
}

#[derive(Debug, Subcommand)]
enum Step {
    /// Begin a run in a folder: read the takes, write where the primitives start
    Init(Box<steps::InitArgs>),
    /// Do a shard's part of a round
    Stats(steps::StatsArgs),
    /// Add up what the shards found, and go on to the next round
    Update(steps::UpdateArgs),
    /// Write the dictionary of a run that has stopped
    Finish(steps::FinishArgs),
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    match &args.step {
        Some(Step::Init(args)) => steps::init(console, args),
        Some(Step::Stats(args)) => steps::stats(console, args),
        Some(Step::Update(args)) => steps::update(args),
        Some(Step::Finish(args)) => steps::finish(console, args),
        None => run_whole(console, args),
    }
}

/// Settings of a run of learning.
#[derive(Debug, clap::Args)]
struct RunOptions {
    #[command(flatten)]
    takes: TakeOptions,
    #[command(flatten, next_help_heading = "Inspection")]
    look: LookOptions,
    #[command(flatten, next_help_heading = "Learning")]
    learn: LearnOptions,
    #[command(flatten)]
    method: MethodOptions,
}

impl RunOptions {
    fn settings(&self, console: &Console, takes: &[PathBuf]) -> Result<Settings> {
        // Takes of several objects and runs may teach one dictionary.
        let unused = ["object.shape", "plan", "evaluate"];
        self.takes.for_all(console, takes, &unused, &|settings| {
            self.look.apply(settings);
            self.learn.apply(settings);
            self.method.apply(settings);
        })
    }

    /// Looks at the takes, prints what may affect numbers and refuses what makes results wrong.
    fn look(
        &self,
        console: &Console,
        takes: &[PathBuf],
        settings: &Settings,
    ) -> Result<Inspection> {
        // Entries of a session's file may be for its other takes.
        if self.look.is_typed() {
            let names: Vec<_> = takes.iter().map(|take| take_name(take)).collect();
            check_accepted(&settings.look.accept, &names)?;
        }
        let task = console.step("inspecting takes");
        let inspection = look_at_training(takes, settings)?;
        drop(task);
        for finding in inspection.findings.iter().filter(|f| f.level > Level::Info) {
            console.say(&finding_line(finding));
        }
        if let Some(line) = inhand_report::inspection_sentence(&inspection) {
            console.say(&line);
        }
        Ok(inspection)
    }

    /// Begins a run in a folder and prints the findings of each take.
    fn init(
        &self,
        console: &Console,
        folder: &Path,
        takes: &[PathBuf],
        settings: &Settings,
    ) -> Result<LearningFolder> {
        let task = console.task("reading", takes.len() as f64);
        let mut say = |take: &Take| {
            task.part(&take.hash.name, 1.0);
            say_findings(console, &take.hash, &take.recording);
        };
        Ok(inhand_training::init(folder, takes, settings, &mut say)?)
    }
}

/// Learns in one process.
fn run_whole(console: &Console, args: &Args) -> Result<Exit> {
    // Clap asks for it; an option it has to be for the steps of a run, which have their own.
    let Some(output) = args.output.as_deref() else {
        return usage("expected -o DICTIONARY");
    };
    let mut settings = args.options.settings(console, &args.inputs)?;
    ending(output, &["mcap"])?;
    reads(args.primitives.as_slice());
    check_outputs(&args.output, &args.inputs)?;
    check_together(args, &mut settings)?;
    check_repeats(args, output, &settings)?;
    let _claim = args.work.as_deref().map(claim_folder).transpose()?;
    // A run that is continued was looked at when it began.
    let is_begun = args.work.as_deref().is_some_and(LearningFolder::exists);
    let inspection = match is_begun {
        true => Inspection::default(),
        false => args.options.look(console, &args.inputs, &settings)?,
    };
    let choice = match args.options.learn.ranks() {
        None => None,
        Some(ranks) => {
            check_outputs(&learn_rank::figure_path(output), &args.inputs)?;
            let segments = learn_rank::segments(&args.inputs, &settings)?;
            let choice = learn_rank::choose(console, &segments, ranks, &mut settings);
            Some(choice?)
        }
    };

    let begin = Instant::now();
    let scratch;
    let folder = match &args.work {
        Some(work) if is_begun => {
            let folder = LearningFolder::open(work)?;
            folder.check_same(&args.inputs, &settings)?;
            console.say(&format!("going on with the run in {}", work.display()));
            folder
        }
        Some(work) => args.options.init(console, work, &args.inputs, &settings)?,
        None => {
            scratch = scratch_folder(output)?;
            let root = scratch.path();
            args.options.init(console, root, &args.inputs, &settings)?
        }
    };
    let read_s = begin.elapsed().as_secs_f64();
    let task = learn_task(console, args.work.as_deref(), &settings);
    let mut learned = match &args.primitives {
        Some(file) => {
            let layout = folder.plan().layout;
            let given = matrices::read_primitives(file, layout, DictionaryKind::Nmf)?;
            learn_given(&folder, &given, hash_file(file)?)?
        }
        None => learn_in(&folder, args.work.is_some(), &mut |progress| {
            console.say(&round_text(progress));
            let round = progress.start * settings.learn.max_iterations + progress.round;
            task.part(format!("round {}", round + 1), 1.0);
            task.rest(rounds(&settings).saturating_sub(round) as f64);
        })?,
    };
    drop(task);
    if let Some(choice) = &choice {
        choice.note(&mut learned.provenance);
        if let Some(figure) = learn_rank::figure_path(output) {
            let write = |path: &Path| choice.write_figure(path, output);
            write_output(&figure, args.force, write)?;
            console.wrote(&figure);
        }
    }
    write_learned(
        console,
        (output, args.force),
        &learned,
        (choice.as_ref(), &inspection),
        read_s,
        args.format,
    )?;
    let fail_on = args.options.look.fail_on;
    Ok(Exit::done_unless(fails(&inspection, fail_on)))
}

/// Rounds of all starts at most.
fn rounds(settings: &Settings) -> usize {
    settings.learn.restarts * settings.learn.max_iterations
}

/// The work of learning, and what is kept of it.
fn learn_task(console: &Console, work: Option<&Path>, settings: &Settings) -> Task {
    let Some(work) = work else {
        interrupt::keeps(
            "nothing was written; run the same command again, with --work FOLDER to keep rounds",
        );
        return console.step("learning");
    };
    interrupt::keeps(format!(
        "the rounds in {} are kept; the same command goes on from there",
        work.display()
    ));
    let task = console.task("learning", rounds(settings) as f64);
    task.part("round 1", 1.0);
    task
}

/// Refuses options that exclude each other before anything takes long.
fn check_together(args: &Args, settings: &mut Settings) -> Result<()> {
    let refuse = |message: &str| Err(UsageError(message.to_owned()).into());
    let is_pca = settings.learn.kind == DictionaryKind::Pca;
    if args.work.is_some() && is_pca {
        return refuse("--work: principal components have no rounds to keep; leave it out");
    }
    if args.work.is_some() && args.options.learn.ranks().is_some() {
        return refuse("--work: expected a single --rank; choose one first, without --work");
    }
    let Some(file) = &args.primitives else {
        return Ok(());
    };
    if is_pca {
        return refuse(
            "--primitives: expected --kind nmf; components about a mean are learned here",
        );
    }
    // The file has its own number of primitives; its content is checked against the takes' rate later.
    settings.learn.rank = None;
    matrices::read(file)?;
    Ok(())
}

/// A line about a round.
fn round_text(progress: &Progress) -> String {
    let start = match progress.starts {
        1 => String::new(),
        starts => format!("start {} of {starts}, ", progress.start + 1),
    };
    let error = progress
        .rms_m
        .map(|rms_m| format!("{:.4} mm rms", rms_m * 1000.0));
    let error = error.unwrap_or_else(|| "begun".to_owned());
    let stop = progress.stop.map_or_else(String::new, |stop| {
        format!(" ({})", stop.name().replace('_', " "))
    });
    format!("{start}round {}: {error}{stop}", progress.round)
}

/// Refuses before anything is learned where the output exists and was learned from other takes or by other settings.
fn check_repeats(args: &Args, output: &Path, settings: &Settings) -> Result<()> {
    let known = args.options.learn.ranks().is_none() && args.primitives.is_none();
    if args.force || !known || !output.is_file() {
        return Ok(());
    }
    let inputs: Result<Vec<_>, _> = args.inputs.iter().map(|path| hash_take(path)).collect();
    let made = provenance("learn", settings, inputs?);
    let earlier = read_dictionary(output).map(|dictionary| dictionary.provenance);
    match earlier.is_ok_and(|steps| steps.last() == Some(&made)) {
        true => Ok(()),
        false => Err(already_exists(output).into()),
    }
}

/// Writes the dictionary and prints the outcome of learning.
fn write_learned(
    console: &Console,
    (output, force): (&Path, bool),
    learned: &Learned,
    (choice, inspection): (Option<&RankChoice>, &Inspection),
    read_s: f64,
    format: Format,
) -> Result<()> {
    let dictionary = &learned.dictionary;
    let steps = std::slice::from_ref(&learned.provenance);
    write_output(output, force, |path| {
        write_dictionary(path, dictionary, steps)
    })?;
    let learning = &dictionary.learning;
    let text = || {
        let choice = choice.map(|choice| choice.text() + "\n");
        let mut text = choice.unwrap_or_default();
        text += &format!(
            "{} primitives from {} segments: {:.3} mm rms after {} iterations ({})\n",
            dictionary.rank(),
            learning.segments,
            learning.rms_m * 1000.0,
            learning.iterations,
            learning.stop_reason.name().replace('_', " "),
        );
        if learning.stop_reason == StopReason::IterationLimit {
            text += "More iterations would lower the error (--max-iterations).\n";
        }
        if dictionary.rank() == learning.segments {
            text += "warning: as many primitives as segments, so each may describe one segment alone; give more \
                     takes, --stride or a smaller --rank\n";
        }
        for restart in &learning.restarts {
            let fate = match restart.seed == learning.seed {
                true => "kept".to_owned(),
                false => format!("mean matched cosine {:.4} with it", restart.matched_cosine),
            };
            let rms_mm = restart.rms_m * 1000.0;
            text += &format!("  seed {}: {rms_mm:.4} mm rms, {fate}\n", restart.seed);
        }
        text
    };
    let json = || {
        let restarts = learning.restarts.iter().map(|restart| {
            let (rms_mm, cosine) = (restart.rms_m * 1000.0, restart.matched_cosine);
            json!({ "seed": restart.seed, "rms_mm": rms_mm, "matched_cosine": cosine })
        });
        let mut outcome = json!({
            "rms_mm": learning.rms_m * 1000.0,
            "relative_error": learning.relative_error,
            "iterations": learning.iterations,
            "stop_reason": learning.stop_reason.name(),
            "segments": learning.segments,
            "rank": dictionary.rank(),
            "seed": learning.seed,
            "restarts": restarts.collect::<Vec<_>>(),
            "inspection": inspection,
            "timings_s": {
                "read": read_s,
                "learn": learned.primitives_s,
                "deviations": learned.deviations_s,
            },
            "peak_memory_bytes": inhand_session::peak_memory_bytes(),
        });
        if let Some(choice) = choice {
            outcome["rank_choice"] = choice.json();
        }
        outcome
    };
    print(format, text, json)?;
    console.wrote(output);
    Ok(())
}
