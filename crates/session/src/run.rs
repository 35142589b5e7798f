//! From a session folder to one MCAP per take, a dictionary, an evaluation and a report.

mod files;
mod write;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use inhand_model::{Evaluation, InputHash, Motion, Provenance};
use inhand_report::Report;
use rayon::prelude::*;

use crate::dictionary_file;
use crate::error::SessionError;
use crate::manifest::{self, Manifest, RunJson};
use crate::session::{self, Session};
use crate::settings::{Role, Settings};
use crate::steps::{self, Illustrated, TakeResult};
use crate::take;
pub use files::RunFiles;
use files::check_output;
use write::{plan_times, write_reports, write_takes};

/// Name and version of the tool, as written into files.
pub const TOOL: &str = concat!("inhand ", env!("CARGO_PKG_VERSION"));

/// Folder of the report's figures, in that of the results.
pub(crate) const FIGURES: &str = "figures";

/// What `run` needs to know.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// Folder that the takes' paths are relative to.
    pub folder: PathBuf,
    /// Effective settings.
    pub settings: Settings,
    /// Folder of the results.
    pub output: PathBuf,
    /// Replace results that another session left in the output folder.
    pub force: bool,
    /// Write channels that viewers draw without set-up.
    pub view: bool,
    /// The command as typed, for `run.json`.
    pub command: Vec<String>,
}

/// What happens during a run, for whoever watches it.
#[derive(Clone, Debug)]
pub enum Event<'a> {
    /// A step begins.
    Started(&'a str),
    /// A step ended after this time.
    Finished(&'a str, Duration),
}

/// What a run gave.
#[derive(Debug)]
pub struct RunResult {
    /// The evaluation; `None` when everything was up to date and nothing was computed.
    pub evaluation: Option<Evaluation>,
    /// Files of the results.
    pub files: RunFiles,
    /// Whether the dictionary of an earlier run was used again.
    pub dictionary_reused: bool,
    /// Plans without a trajectory, over all methods.
    pub failed_plans: usize,
}

/// Runs a session from takes to report. Results of an earlier run with the same inputs, settings
/// and version are kept.
///
/// # Errors
///
/// [`SessionError`]; a file is either written whole or not at all.
pub fn run(
    options: &RunOptions,
    watch: &mut dyn FnMut(Event<'_>),
) -> Result<RunResult, SessionError> {
    let begin = Instant::now();
    let settings = &options.settings;
    settings.validate()?;
    let session = session::list_takes(&options.folder, settings)?;
    let files = RunFiles::new(&options.output, &session);
    check_output(options, &session, &files)?;
    let mut timer = Timer {
        watch,
        timings_s: BTreeMap::new(),
    };

    let takes = timer.time("read", || take::read_session(&session, settings))?;
    let provenance = provenance("run", settings, takes.iter().map(|take| take.hash.clone()));
    let key = manifest::key(&session, &provenance, options.view);
    if manifest::up_to_date(&files.run, &session.name, &key, &files.reproducible()) {
        // What failed then is as missing now.
        let (evaluation, failed_plans) = (None, stored_failures(&files.evaluation)?);
        return Ok(RunResult {
            evaluation,
            files,
            dictionary_reused: true,
            failed_plans,
        });
    }

    for role in [Role::Train, Role::Test] {
        let of_role = takes.iter().zip(&session.takes);
        let of_role = of_role.filter(|(_, entry)| entry.role == role);
        steps::used(of_role.map(|(take, _)| take), settings)?;
    }
    let in_hand = timer.time("hand_frame", || steps::motions_in_hand(&takes, settings))?;
    let (motions, smoothing) = timer.time("filter", || {
        let motions = steps::smooth_motions(&in_hand, settings)?;
        let tests = |motions| motions_of_role(motions, &session, Role::Test);
        // Before what was there before the filter goes.
        let smoothing = steps::smoothing(&tests(&in_hand), &tests(&motions))?;
        Ok((motions, smoothing))
    })?;
    drop(in_hand);
    let results: Vec<_> = (takes.iter().zip(&motions).zip(&session.takes))
        .map(|((take, motion), entry)| TakeResult {
            take,
            motion,
            role: entry.role,
        })
        .collect();
    let train_motions = motions_of(&results, Role::Train);
    let test_motions = motions_of(&results, Role::Test);

    let object = steps::carries_object(&train_motions, settings)?;
    let train = steps::segments(&train_motions, Role::Train, object, settings)?;
    let object = object && steps::carries_object(&test_motions, settings)?;
    let test = steps::segments(&test_motions, Role::Test, object, settings)?;
    if test.is_empty() {
        let message = "no test segment: no stretch of the test takes is long enough without gaps";
        return Err(SessionError::session(&options.folder, message));
    }
    let learned_by = learned_by(&results, settings);
    let reused = dictionary_file::read_if(&files.dictionary, &learned_by);
    let dictionary_reused = reused.is_some();
    let dictionary = timer.time("learn", || match reused {
        Some(dictionary) => Ok(dictionary),
        None => steps::learn_and_choose(&train, steps::demonstrated(&train_motions)?, settings),
    })?;
    let plan_methods = steps::settled_methods(&dictionary, settings)?;
    // Everything that can be wrong with the takes would have shown by now. From here on results
    // are written one by one, and an interrupted run is known as ours to go on with.
    manifest::claim(
        &files.run,
        &session.name,
        &files.reproducible(),
        &options.command,
    )?;
    if !dictionary_reused {
        dictionary_file::write(&files.dictionary, &dictionary, &[learned_by])?;
    }

    let generated = timer.time("generate", || {
        (plan_methods.iter())
            .map(|&method| steps::generate(method, &dictionary, &test, settings))
            .collect::<Result<Vec<_>, _>>()
    })?;

    let comparison = timer.time("contacts", || {
        steps::measure_recorded(&test, &test_motions, &dictionary, settings)
    })?;
    let evaluated = timer.time("evaluate", || {
        let all: Vec<_> = generated
            .par_iter()
            .map(|g| steps::evaluate(&comparison, g))
            .collect();
        Ok(all)
    })?;
    let (methods, rows): (Vec<_>, Vec<_>) = evaluated.into_iter().unzip();
    let mut evaluation = steps::assemble(
        steps::session_facts(&session.name, &results, Some(&train), &test, settings),
        dictionary.choice.clone(),
        steps::dictionary_facts(&dictionary, settings),
        methods,
        steps::quality(&results)?,
    );

    let motion = timer.time("motion", || {
        steps::motion_analysis(&comparison, &generated, &rows, Some(&train), settings)
    })?;
    evaluation.movement = Some(motion.movement);
    evaluation.contacts = motion.contacts;

    timer.time("write", || {
        write_takes(
            &results,
            &test,
            (&generated, &rows),
            &dictionary.demonstrated.hulls,
            &provenance,
            options,
            &files,
        )
    })?;
    let rows = steps::evaluation_rows(&comparison, &generated, rows);
    evaluation.intervals = timer.time("intervals", || {
        steps::intervals(&evaluation, &rows, settings)
    })?;
    let illustrated = Illustrated {
        takes: &results,
        train: &train,
        test: &test,
        test_motions: &test_motions,
        dictionary: &dictionary,
        generated: &generated,
        rows: &rows,
        settings,
    };
    let illustrations = timer.time("illustrate", || steps::illustrate(&illustrated, smoothing))?;
    let report = Report::new(&evaluation, std::slice::from_ref(&provenance))
        .with_rows(&rows)
        .with_illustrations(&illustrations);
    let figures = timer.time("report", || {
        write_reports(&report, &rows, &motion.rows, &files)
    })?;
    let mut written = files.reproducible();
    written.extend(figures.iter().map(PathBuf::as_path));
    let mut timings_s = timer.timings_s;
    timings_s.insert("total".to_owned(), begin.elapsed().as_secs_f64());
    manifest::write_run_json(
        &files.run,
        &RunJson {
            timings_s,
            plan_ms: plan_times(&generated),
            peak_memory_bytes: manifest::peak_memory_bytes(),
            threads: rayon::current_num_threads(),
            command: options.command.clone(),
            manifest: Manifest::of(&session.name, key, &options.output, &written)?,
        },
    )?;
    let failed_plans = (generated.iter())
        .map(|g| {
            g.trajectories
                .iter()
                .filter(|trajectory| trajectory.is_none())
                .count()
        })
        .sum();
    Ok(RunResult {
        evaluation: Some(evaluation),
        files,
        dictionary_reused,
        failed_plans,
    })
}

/// Plans without a trajectory, over all methods of an evaluation that was made earlier.
fn stored_failures(path: &Path) -> Result<usize, SessionError> {
    let text = std::fs::read_to_string(path).map_err(SessionError::io("read", path))?;
    let (evaluation, _) = inhand_report::read_evaluation_json(&text)?;
    let plans = evaluation
        .methods
        .iter()
        .filter_map(|method| method.plan.as_ref());
    Ok(plans.map(|plans| plans.infeasible + plans.failed).sum())
}

struct Timer<'a> {
    watch: &'a mut dyn FnMut(Event<'_>),
    timings_s: BTreeMap<String, f64>,
}

impl Timer<'_> {
    fn time<T>(
        &mut self,
        step: &'static str,
        work: impl FnOnce() -> Result<T, SessionError>,
    ) -> Result<T, SessionError> {
        (self.watch)(Event::Started(step));
        let begin = Instant::now();
        let result = work()?;
        let elapsed = begin.elapsed();
        self.timings_s
            .insert(step.to_owned(), elapsed.as_secs_f64());
        (self.watch)(Event::Finished(step, elapsed));
        Ok(result)
    }
}

/// What made a result of this step, for its file.
pub fn provenance(
    step: &str,
    settings: &Settings,
    inputs: impl IntoIterator<Item = InputHash>,
) -> Provenance {
    Provenance {
        tool: TOOL.to_owned(),
        step: step.to_owned(),
        settings_json: settings.provenance_json(),
        inputs: inputs.into_iter().collect(),
    }
}

/// Motions of takes of a role, those of all takes being in the session's order.
fn motions_of_role<'a>(motions: &'a [Motion], session: &Session, role: Role) -> Vec<&'a Motion> {
    let of_role = motions.iter().zip(&session.takes);
    let of_role = of_role.filter(|(_, entry)| entry.role == role);
    of_role.map(|(motion, _)| motion).collect()
}

fn motions_of<'a>(results: &[TakeResult<'a>], role: Role) -> Vec<&'a Motion> {
    results
        .iter()
        .filter(|result| result.role == role)
        .map(|result| result.motion)
        .collect()
}

fn learned_by(results: &[TakeResult<'_>], settings: &Settings) -> Provenance {
    let train = results.iter().filter(|result| result.role == Role::Train);
    manifest::learn_provenance(settings, train.map(|result| result.take))
}
