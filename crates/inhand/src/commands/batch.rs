//! `inhand batch SESSIONS... -o OUT`.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Result;
use inhand_session::sessions::{MergeOptions, Part, merge};
use inhand_session::{Event, RunOptions, Settings, claim_folder, list_takes, write_text};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::run::{
    ResultOptions, SessionOptions, fails, finding_line, removed_line, share, skipped_line,
};
use crate::console::{Console, as_it_is, messages, print};
use crate::exit::{Exit, UsageError};
use crate::interrupt;
use crate::options::{Format, check_accepted};
use crate::output::check_output;

/// Run many sessions, skip and report those that fail, join their evaluations
///
/// Each session is written into a folder of its own; a report over all of them is written at the end. Called
/// again, it runs only sessions that failed, were interrupted or have changed. The exit code and the table printed are
/// of the sessions given; summary.html has those of earlier calls too.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Sessions: folders with train/ and test/, files inhand.toml, or takes split by time.
    #[arg(required = true)]
    sessions: Vec<PathBuf>,
    /// Folder for the results of each session, summary.html and batch.json.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Join sessions with different settings, listed in summary.html.
    #[arg(long)]
    allow_different: bool,
    /// Print as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    #[command(flatten)]
    overrides: SessionOptions,
    #[command(flatten)]
    writing: ResultOptions,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let record_file = args.output.join("batch.json");
    let summary_file = args.output.join("summary.html");
    let _claim = claim_folder(&args.output)?;
    let earlier = Record::read(&record_file);
    // Results beside a record are those of an earlier call.
    let force = args.writing.output.force || earlier.is_some();
    check_output(&record_file, || force)?;
    check_output(&summary_file, || force)?;
    let mut record = earlier.unwrap_or_default();
    // The folder of results that each session has had so far.
    let known = (record.sessions.iter())
        .map(|outcome| (outcome.session.clone(), outcome.name.clone()))
        .collect();
    let names = unique(&args.sessions, &known).map_err(UsageError)?;
    check_accepted_takes(args)?;
    let count = args.sessions.len();
    let task = console.task("batch", count as f64);
    let (mut failed, mut failed_check) = (0, false);
    for (at, (session, name)) in args.sessions.iter().zip(&names).enumerate() {
        let folder = args.output.join(name);
        keeps(args, at - failed);
        // A session that is up to date has no steps.
        task.rest((count - at) as f64);
        let label = match failed {
            0 => format!("{} of {count}, {name}", at + 1),
            _ => format!("{} of {count}, {failed} failed, {name}", at + 1),
        };
        let mut started = |step: &str| task.part(format!("{label}: {step}"), share(step));
        let begin = Instant::now();
        let mut found = Vec::new();
        let overrides = &args.overrides;
        let options = overrides.run_options(console, session, &folder, &args.writing);
        let one = |options| one(args, &options, &mut found, &mut started);
        let (state, error) = match options.and_then(one) {
            Ok((state, fails)) => {
                failed_check |= fails;
                (state, None)
            }
            Err(error) => (State::Failed, Some(chain(&error))),
        };
        let seconds = begin.elapsed().as_secs_f64();
        let line = match &error {
            Some(error) => format!("failed   {name}: {error}"),
            None => format!("{:<8} {name:<60} {seconds:>7.2} s", state.words()),
        };
        match state {
            // The reason of a failure is printed even when the console is quiet.
            State::Failed => as_it_is(&line),
            _ => (found.iter().chain([&line])).for_each(|line| console.say(line)),
        }
        failed += usize::from(state == State::Failed);
        record.set(Outcome {
            name: name.clone(),
            session: full(session),
            state,
            error,
            seconds,
        });
        // After every session, so that an interrupted batch has its record.
        record.write(&record_file)?;
    }
    keeps(args, count - failed);
    let _task = console.step("joining the sessions");
    // Sessions of earlier calls are neither counted nor judged.
    let given: BTreeSet<String> = args.sessions.iter().map(|own| full(own)).collect();
    let is_given = |own: &&Outcome| given.contains(&own.session);
    let given: Vec<Outcome> = record.sessions.iter().filter(is_given).cloned().collect();
    say_failures(console, &given);
    let joined = join(console, args, &given, &record.sessions, &summary_file)?;
    Ok(match exit(&given) {
        Exit::Done if !joined || failed_check => Exit::Lossy,
        exit => exit,
    })
}

/// States which sessions an interruption would keep.
fn keeps(args: &Args, done: usize) {
    interrupt::keeps(format!(
        "{done} of {} sessions are done and kept in {}; the same command goes on with the others",
        args.sessions.len(),
        args.output.display()
    ));
}

/// Refuses --accept ID:TAKE for a take that none of the sessions has.
fn check_accepted_takes(args: &Args) -> Result<()> {
    let look = &args.overrides.look;
    if !look.is_typed() {
        return Ok(());
    }
    // What is said of a session is said when it is run.
    let quiet = Console {
        quiet: true,
        once: RefCell::default(),
        lost: Cell::default(),
    };
    let mut names = BTreeSet::new();
    let mut typed = Settings::default();
    look.apply(&mut typed);
    for session in &args.sessions {
        let options = (args.overrides).run_options(&quiet, session, &args.output, &args.writing);
        let takes = options.and_then(|o| Ok(list_takes(&o.folder, &o.settings)?.takes));
        // A session that cannot be read fails when it is run; the take may be one of its takes.
        let Ok(takes) = takes else {
            return Ok(());
        };
        names.extend(takes.into_iter().map(|take| take.name));
    }
    let names: Vec<_> = names.into_iter().collect();
    Ok(check_accepted(&typed.look.accept, &names)?)
}

/// Runs one session and collects lines of findings; its state, and whether --fail-on is met.
fn one(
    args: &Args,
    options: &RunOptions,
    found: &mut Vec<String>,
    started: &mut dyn FnMut(&str),
) -> Result<(State, bool)> {
    let result = inhand_session::run(options, &mut |event| match event {
        Event::Started(step) => started(step),
        Event::Found(finding) => found.push(finding_line(finding)),
        Event::Skipped(files) => found.push(skipped_line(files)),
        Event::Removed(files) => found.push(removed_line(files)),
        _ => {}
    })?;
    let state = match (result.up_to_date, result.failed_plans) {
        (_, 1..) => State::PlansFailed,
        (true, 0) => State::UpToDate,
        (false, 0) => State::Done,
    };
    let inspection = result.evaluation.inspection.as_ref();
    let fails = inspection.is_some_and(|found| fails(found, args.overrides.look.fail_on));
    Ok((state, fails))
}

/// An error and its causes on one line.
fn chain(error: &anyhow::Error) -> String {
    let causes: Vec<String> = messages(error).collect();
    causes.join(": ").replace('\n', "; ")
}

fn say_failures(console: &Console, given: &[Outcome]) {
    let mut parts = vec![format!("{} sessions", given.len())];
    let mut counts = BTreeMap::<State, usize>::new();
    for outcome in given {
        *counts.entry(outcome.state).or_default() += 1;
    }
    parts.extend((counts.iter()).map(|(state, n)| format!("{n} {}", state.words())));
    console.say(&parts.join(", "));
}

/// Prints the table of the sessions given and writes the report over all sessions of the folder, or over those given
/// where others cannot be joined with them; `false` where those given cannot be joined.
fn join(
    console: &Console,
    args: &Args,
    given: &[Outcome],
    all: &[Outcome],
    target: &Path,
) -> Result<bool> {
    let options = MergeOptions {
        allow_different: args.allow_different,
        ..MergeOptions::default()
    };
    let merged = |folders: &[PathBuf]| match folders {
        [] => Ok(None),
        _ => Part::read_all(folders).and_then(|parts| merge(&parts, options).map(Some)),
    };
    let outcomes = given;
    let [given, all] = [given, all].map(|outcomes| with_results(&args.output, outcomes));
    let mut joined = merged(&given);
    let text = || match &joined {
        Ok(Some(summary)) => inhand_report::summary_text(summary, false),
        _ => String::new(),
    };
    print(args.format, text, || json!({ "sessions": outcomes }))?;
    if given.len() < all.len() {
        match merged(&all) {
            Ok(summary) => joined = Ok(summary),
            Err(refused) if !matches!(joined, Ok(Some(_))) => joined = joined.and(Err(refused)),
            Err(refused) => console.say(&format!(
                "{} leaves out sessions of earlier calls: {refused}",
                target.display()
            )),
        }
    }
    if let Ok(Some(summary)) = &joined {
        write_text(target, &inhand_report::summary_html(summary))?;
        console.say(&format!("{:<36} open in a browser", target.display()));
    } else if target.exists() {
        // A report over other sessions than these must not stay.
        std::fs::remove_file(target)?;
    }
    // The sessions are done; only what is over all of them is missing.
    let refused = joined.map_err(|refused| anyhow::Error::from(refused).context("no summary"));
    Ok(refused
        .inspect_err(|refused| console.error(refused))
        .is_ok())
}

/// Folders of the sessions that have results.
fn with_results(output: &Path, outcomes: &[Outcome]) -> Vec<PathBuf> {
    let made = outcomes.iter().filter(|own| own.state != State::Failed);
    made.map(|own| output.join(&own.name)).collect()
}

/// Folders of results in a folder that `batch` wrote; `None` for another one.
pub(super) fn results(output: &Path) -> Option<Vec<PathBuf>> {
    let record = Record::read(&output.join("batch.json"))?;
    Some(with_results(output, &record.sessions))
}

/// State of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum State {
    /// Everything was made.
    Done,
    /// Made earlier, and nothing has changed since.
    UpToDate,
    /// Made, but some plans have no trajectory.
    PlansFailed,
    /// Not made.
    Failed,
}

impl State {
    const fn words(self) -> &'static str {
        match self {
            State::Done => "done",
            State::UpToDate => "up to date",
            State::PlansFailed => "with plans that failed",
            State::Failed => "failed",
        }
    }
}

/// Outcome of a session.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Outcome {
    /// Folder of its results, beside the record.
    name: String,
    /// The session, from the root.
    session: String,
    state: State,
    /// Why it failed.
    error: Option<String>,
    seconds: f64,
}

/// All sessions of a batch so far.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Record {
    sessions: Vec<Outcome>,
}

impl Record {
    /// The record of earlier calls, where there is one.
    fn read(path: &Path) -> Option<Self> {
        let text = std::fs::read_to_string(path).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// Adds the outcome of a session, or replaces an earlier one.
    fn set(&mut self, outcome: Outcome) {
        let mut known = self.sessions.iter_mut();
        match known.find(|known| known.session == outcome.session) {
            Some(known) => *known = outcome,
            None => self.sessions.push(outcome),
        }
    }

    fn write(&self, path: &Path) -> Result<()> {
        let mut text = serde_json::to_string_pretty(self)?;
        text.push('\n');
        Ok(write_text(path, &text)?)
    }
}

/// Failed where nothing was made; lossy where something is missing.
fn exit(given: &[Outcome]) -> Exit {
    let complete = |o: &Outcome| matches!(o.state, State::Done | State::UpToDate);
    if given.iter().all(|o| o.state == State::Failed) {
        Exit::Failed
    } else {
        Exit::done_unless(!given.iter().all(complete))
    }
}

/// Names that the batch needs for files of its own.
const RESERVED: [&str; 2] = ["batch.json", "summary.html"];

/// A session's path from the root, by which it is known from call to call.
fn full(session: &Path) -> String {
    canonical(session).display().to_string()
}

fn canonical(session: &Path) -> PathBuf {
    (session.canonicalize()).unwrap_or_else(|_| session.to_owned())
}

/// A name for each session: the one it has in `known` (paths from the root with names), else its folder's, with as
/// many folders above it as it takes to tell all of them apart.
fn unique(sessions: &[PathBuf], known: &BTreeMap<String, String>) -> Result<Vec<String>, String> {
    let parts: Vec<Vec<String>> = sessions.iter().map(|session| components(session)).collect();
    for (place, own) in parts.iter().enumerate() {
        if let Some(other) = parts[..place].iter().position(|other| other == own) {
            return Err(format!(
                "{} and {} are the same session: name it once",
                sessions[other].display(),
                sessions[place].display()
            ));
        }
    }
    let longest = parts.iter().map(Vec::len).max().unwrap_or(0);
    let named = |depth: usize| -> Vec<String> {
        let fresh = |parts: &Vec<String>| parts[parts.len().saturating_sub(depth)..].join("_");
        (sessions.iter().zip(&parts))
            .map(|(session, parts)| {
                let known = known.get(&full(session)).cloned();
                known.unwrap_or_else(|| fresh(parts))
            })
            .collect()
    };
    let are_apart = |names: &[String]| {
        // Sessions of earlier calls keep their folders.
        let given: BTreeSet<String> = sessions.iter().map(|session| full(session)).collect();
        let earlier = known
            .iter()
            .filter(|(session, _)| !given.contains(*session));
        let taken = earlier.map(|(_, name)| name.as_str()).chain(RESERVED);
        // Some file systems ignore the case of names.
        let mut sorted: Vec<String> = (names.iter().map(String::as_str).chain(taken))
            .map(str::to_lowercase)
            .collect();
        sorted.sort_unstable();
        sorted.windows(2).all(|pair| pair[0] != pair[1])
    };
    (1..=longest)
        .map(named)
        .find(|names| are_apart(names))
        .ok_or_else(|| "the folder names of the sessions are not unique".to_owned())
}

/// Names of the folders down to a session. A settings file of a name of its own names the session, since a folder may
/// hold several.
fn components(session: &Path) -> Vec<String> {
    let full = canonical(session);
    let is_plain = full
        .file_name()
        .is_some_and(|name| name == inhand_session::SETTINGS_FILE);
    let named = match (is_plain, full.is_file()) {
        (true, _) => full.parent().unwrap_or(Path::new("")).to_owned(),
        (false, true) => full.with_extension(""),
        (false, false) => full,
    };
    let names = named.components().filter_map(|part| match part {
        std::path::Component::Normal(name) => Some(name.to_string_lossy().into_owned()),
        _ => None,
    });
    let names: Vec<String> = names.collect();
    if names.is_empty() {
        vec!["session".to_owned()]
    } else {
        names
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(sessions: &[&str], known: &[(&str, &str)]) -> Result<Vec<String>, String> {
        let sessions: Vec<PathBuf> = sessions.iter().map(PathBuf::from).collect();
        let known = known
            .iter()
            .map(|(a, b)| ((*a).to_owned(), (*b).to_owned()));
        unique(&sessions, &known.collect())
    }

    #[test]
    fn folders_above_are_added_only_where_needed() {
        let fresh = |sessions: &[&str]| names(sessions, &[]).unwrap();
        assert_eq!(fresh(&["/x/a", "/x/b"]), ["a", "b"]);
        assert_eq!(fresh(&["/x/p1/cube", "/x/p2/cube"]), ["p1_cube", "p2_cube"]);
        assert_eq!(fresh(&["/x/p1/cube", "/x/p2/Cube"]), ["p1_cube", "p2_Cube"]);
        assert_eq!(fresh(&["/x/batch.json"]), ["x_batch.json"]);
        let twice = names(&["/x/a", "/x/a"], &[]).unwrap_err();
        assert!(twice.contains("same session"));
    }

    #[test]
    fn a_session_keeps_its_folder_and_no_other_gets_it() {
        let known = [("/x/p1/cube", "cube")];
        assert_eq!(names(&["/x/p2/cube"], &known).unwrap(), ["p2_cube"]);
        let both = names(&["/x/p1/cube", "/x/p2/cube"], &known).unwrap();
        assert_eq!(both, ["cube", "p2_cube"]);
    }
}
