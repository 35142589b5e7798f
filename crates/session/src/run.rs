//! A run: from a session folder to one MCAP per take, a dictionary, an evaluation and a report.

mod files;
mod judge;
mod times;
mod write;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use inhand_inspection::{Smoothing, inspect_results, smoothing};
use inhand_model::{
    Dictionary, Evaluation, InputHash, Inspection, Level, Motion, PerProtocol, Protocol,
    Provenance, Segments, SessionFacts, SessionFinding,
};
use inhand_parallel::both;

use crate::TOOL;
use crate::dictionary_file;
use crate::error::{Located, SessionError};
use crate::look;
use crate::manifest::{self, Manifest, RunJson};
use crate::output::{FolderClaim, claim_folder};
use crate::scope::OutputScope;
use crate::session::{self, Session, SessionTake};
use crate::settings::{Role, Settings};
use crate::steps::{self, Generated, TakeResult};
use crate::take::{self, Take};
pub use files::RunFiles;
use files::check_output;
use judge::judge;
use times::Times;
use write::{Results, plan_times, write_reports, write_takes};

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
    /// Parts of the results that are written.
    pub scope: OutputScope,
    /// The command as typed, for `run.json`.
    pub command: Vec<String>,
}

/// Progress of a run.
#[derive(Clone, Debug)]
pub enum Event<'a> {
    /// A step begins.
    Started(&'a str),
    /// A step ended after this time.
    Finished(&'a str, Duration),
    /// What the takes are and how many segments they give; once, before anything is learned.
    Took(&'a SessionFacts),
    /// A finding that may affect numbers, or one that is accepted.
    Found(&'a SessionFinding),
    /// Files among the takes that are no takes, relative to the session.
    Skipped(&'a [PathBuf]),
    /// Results of an earlier run that this one does not write; they are gone.
    Removed(&'a [PathBuf]),
}

/// What a run gave.
#[derive(Debug)]
pub struct RunResult {
    /// The evaluation, now or when the results were made.
    pub evaluation: Evaluation,
    /// Whether everything was up to date and nothing was computed.
    pub up_to_date: bool,
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
    let mut run = Run::new(options, watch)?;
    let settings = run.settings;
    let takes = run.time("read", || take::read_session(&run.session, settings))?;
    let hashes = takes.iter().map(|take| take.hash.clone());
    let provenance = provenance("run", settings, hashes);
    let key = manifest::key(&run.session, &provenance, options.scope);
    let (kept, all) = manifest::unchanged(&run.files.run, &run.session.name, &key);
    run.files.kept = kept;
    let outputs = run.files.reproducible();
    if all && outputs.iter().all(|path| run.files.is_kept(path)) {
        let evaluation = stored_evaluation(&run.files.evaluation)?;
        (run.watch.borrow_mut())(Event::Took(&evaluation.session));
        if let Some(inspection) = &evaluation.inspection {
            run.found(inspection, &[]);
        }
        return Ok(RunResult {
            // What failed then is as missing now.
            failed_plans: evaluation.failed_plans(),
            evaluation,
            up_to_date: true,
            files: run.files,
            dictionary_reused: true,
        });
    }
    let (motions, smoothing, mut inspection) = run.process(&takes)?;
    let cut = run.cut(&takes, &motions)?;
    let (dictionary, dictionary_reused) = run.learn(&cut)?;
    if !run.files.is_kept(&run.files.dictionary) {
        // What is there may be of another dictionary.
        run.files.kept.clear();
    }
    let generated = run.generate(&cut, &dictionary, dictionary_reused)?;
    let mut judged = run.time_all("evaluate", |times| {
        let name = &run.session.name;
        judge(name, &cut, &dictionary, &generated, settings, times)
    })?;
    let earlier = inspection.findings.clone();
    let limits = look::limits(settings)?;
    inspect_results(&mut inspection, &judged.evaluation, &limits);
    run.found(&inspection, &earlier);
    judged.evaluation.inspection = Some(inspection);
    judged.evaluation.key = Some(key.clone());
    let results = Results {
        cut: &cut,
        dictionary: &dictionary,
        generated: &generated,
        judged: &judged,
        smoothing,
        provenance: &provenance,
    };
    let files = &run.files;
    let figures = run.time_all("write", |times| {
        let (takes, reports) = both(
            || times.time("write", || write_takes(&results, options, files)),
            || write_reports(&results, options, files, times),
        );
        takes.and(reports)
    })?;
    let evaluation = judged.evaluation;
    run.finish(key, &figures, &generated.published)?;
    Ok(RunResult {
        failed_plans: evaluation.failed_plans(),
        evaluation,
        up_to_date: false,
        files: run.files,
        dictionary_reused,
    })
}

/// A session that is run, where its results go, and who watches.
struct Run<'a> {
    options: &'a RunOptions,
    settings: &'a Settings,
    session: Session,
    files: RunFiles,
    _claim: Option<FolderClaim>,
    begin: Instant,
    watch: RefCell<&'a mut dyn FnMut(Event<'_>)>,
    timings_s: RefCell<BTreeMap<String, f64>>,
}

/// Segments of both roles with the motions that they are cut from. Those to learn from under the held-out protocol
/// are cut when they are needed.
struct Cut<'a> {
    results: Vec<TakeResult<'a>>,
    train_motions: PerProtocol<Vec<&'a Motion>>,
    test_motions: PerProtocol<Vec<&'a Motion>>,
    train: Segments,
    test: PerProtocol<Segments>,
}

impl<'a> Run<'a> {
    /// Lists the takes and checks that the results may be written.
    fn new(
        options: &'a RunOptions,
        watch: &'a mut dyn FnMut(Event<'_>),
    ) -> Result<Self, SessionError> {
        let (begin, settings) = (Instant::now(), &options.settings);
        settings.validate()?;
        let session = session::list_takes(&options.folder, settings)?;
        let files = RunFiles::new(&options.output, &session, options.scope);
        check_output(options, &session, &files)?;
        let _claim = claim_folder(&options.output)?;
        if !session.skipped.is_empty() {
            watch(Event::Skipped(&session.skipped));
        }
        Ok(Self {
            options,
            settings,
            session,
            files,
            _claim,
            begin,
            watch: RefCell::new(watch),
            timings_s: RefCell::default(),
        })
    }

    fn time<T>(
        &self,
        step: &'static str,
        work: impl FnOnce() -> Result<T, SessionError>,
    ) -> Result<T, SessionError> {
        self.time_all(step, |times| times.time(step, work))
    }

    /// Steps that run beside each other; `first` names them while they run.
    fn time_all<T>(
        &self,
        first: &'static str,
        work: impl FnOnce(&Times) -> Result<T, SessionError>,
    ) -> Result<T, SessionError> {
        (self.watch.borrow_mut())(Event::Started(first));
        let times = Times::default();
        let result = work(&times)?;
        for (k, (step, elapsed)) in times.into_steps().into_iter().enumerate() {
            if k > 0 {
                (self.watch.borrow_mut())(Event::Started(step));
            }
            let timings_s = &mut *self.timings_s.borrow_mut();
            timings_s.insert(step.to_owned(), elapsed.as_secs_f64());
            (self.watch.borrow_mut())(Event::Finished(step, elapsed));
        }
        Ok(result)
    }

    /// What belongs to takes of a role, of all that is in the session's order.
    fn of_role<'v, T>(&self, all: &'v [T], role: Role) -> Vec<&'v T> {
        let of_role = all.iter().zip(&self.session.takes);
        let of_role = of_role.filter(|(_, entry)| entry.role == role);
        of_role.map(|(value, _)| value).collect()
    }

    /// Reports findings that may affect numbers, but those reported earlier.
    fn found(&self, inspection: &Inspection, earlier: &[SessionFinding]) {
        let findings = inspection.findings.iter();
        for finding in findings.filter(|f| f.level >= Level::Warn && !earlier.contains(f)) {
            (self.watch.borrow_mut())(Event::Found(finding));
        }
    }

    /// Motions in the hand's frame, before and after the filter, what the filter did, and findings before it.
    fn process(
        &self,
        takes: &[Take],
    ) -> Result<(PerProtocol<Vec<Motion>>, Smoothing, Inspection), SessionError> {
        for role in [Role::Train, Role::Test] {
            steps::used(self.of_role(takes, role), self.settings)?;
        }
        let in_hand = self.time("hand_frame", || {
            // What is held out has no say in the frame that it is judged in.
            let trains = |n: usize| self.session.takes[n].role == Role::Train;
            steps::motions_in_hand(takes, &trains, self.settings)
        })?;
        let (session, settings) = (&self.session, self.settings);
        let tests = |all| self.of_role(all, Role::Test);
        let (inspection, motions) = self.time_all("look", |times| {
            let (inspection, motions) = both(
                || times.time("look", || look::look(session, takes, &in_hand, settings)),
                || {
                    times.time("filter", || {
                        steps::smooth_motions(in_hand.clone(), settings)
                    })
                },
            );
            Ok((inspection?, motions?))
        })?;
        look::refuse(&session.name, &inspection)?;
        self.found(&inspection, &[]);
        let smoothing = smoothing(&tests(&in_hand), &tests(&motions))
            .during("comparing takes with the filtered ones")?;
        let motions = PerProtocol {
            published: motions,
            held_out: in_hand,
        };
        Ok((motions, smoothing, inspection))
    }

    fn cut<'t>(
        &self,
        takes: &'t [Take],
        motions: &'t PerProtocol<Vec<Motion>>,
    ) -> Result<Cut<'t>, SessionError> {
        let results: Vec<_> = (takes
            .iter()
            .zip(&motions.published)
            .zip(&self.session.takes))
        .map(|((take, motion), entry)| TakeResult {
            take,
            motion,
            role: entry.role,
        })
        .collect();
        let settings = self.settings;
        let of_role = |role| (motions.as_ref()).map(|motions| self.of_role(motions, role));
        let (train_motions, test_motions) = (of_role(Role::Train), of_role(Role::Test));
        let object = steps::carries_object(&train_motions.published, settings)?;
        let of = (Role::Train, Protocol::Published);
        let train = steps::segments(&train_motions.published, of, object, settings)?;
        let object = object && steps::carries_object(&test_motions.published, settings)?;
        let test = |protocol| {
            let of = (Role::Test, protocol);
            steps::segments(&test_motions[protocol], of, object, settings)
        };
        let test = PerProtocol::try_from_fn(test)?;
        let name = &self.session.name;
        let facts = steps::session_facts(name, &results, Some(&train), &test.published, settings);
        (self.watch.borrow_mut())(Event::Took(&facts));
        if test.published.is_empty() {
            let mut message =
                "no test segment: no interval of the test takes is long enough without gaps"
                    .to_owned();
            if self.session.takes.iter().any(SessionTake::is_part) {
                message += "; a larger segments.test_share makes them longer";
            }
            return Err(SessionError::session(self.session.name.as_ref(), message));
        }
        Ok(Cut {
            results,
            train_motions,
            test_motions,
            train,
            test,
        })
    }

    /// The dictionary, and whether it is that of an earlier run.
    fn learn(&self, cut: &Cut<'_>) -> Result<(Dictionary, bool), SessionError> {
        let reused = dictionary_file::read_if(&self.files.dictionary, &self.learned_by(cut));
        let is_reused = reused.is_some();
        let dictionary = self.time("learn", || match reused {
            Some(dictionary) => Ok(dictionary),
            None => {
                let PerProtocol {
                    published,
                    held_out,
                } = &cut.train_motions;
                let demonstrated = steps::demonstrated(published)?;
                let layout = cut.train.layout();
                let held_out = steps::held_out_demonstrations(held_out, layout, self.settings)?;
                steps::learn_and_choose(&cut.train, &held_out, demonstrated, self.settings)
            }
        })?;
        Ok((dictionary, is_reused))
    }

    fn learned_by(&self, cut: &Cut<'_>) -> Provenance {
        let train = self.of_role(&cut.results, Role::Train);
        manifest::learn_provenance(self.settings, train.into_iter().map(|result| result.take))
    }

    /// Motion by every method, once the dictionary is written.
    fn generate(
        &self,
        cut: &Cut<'_>,
        dictionary: &Dictionary,
        dictionary_reused: bool,
    ) -> Result<PerProtocol<Vec<Generated>>, SessionError> {
        let (files, session) = (&self.files, &self.session.name);
        let methods = steps::settled_methods(dictionary, self.settings)?;
        // Everything that can be wrong with the takes would have shown by now. From here on results
        // are written one by one, and an interrupted run is known as ours to go on with.
        let outputs = files.reproducible();
        let removed = manifest::claim(&files.run, session, &outputs, &self.options.command)?;
        let takes: Vec<_> = (removed.into_iter())
            .filter(|path| path.extension().is_some_and(|ending| ending == "mcap"))
            .collect();
        if !takes.is_empty() {
            (self.watch.borrow_mut())(Event::Removed(&takes));
        }
        if !dictionary_reused {
            dictionary_file::write(&files.dictionary, dictionary, &[self.learned_by(cut)])?;
        }
        let by_each = |segments: &Segments| -> Result<Vec<_>, _> {
            let generate = |&method| steps::generate(method, dictionary, segments, self.settings);
            methods.iter().map(generate).collect()
        };
        self.time("generate", || {
            PerProtocol::try_from_fn(|protocol| by_each(&cut.test[protocol]))
        })
    }

    /// Writes `run.json`, which makes the results those of a finished run.
    fn finish(
        &self,
        key: String,
        figures: &[PathBuf],
        generated: &[Generated],
    ) -> Result<(), SessionError> {
        let mut written = self.files.reproducible();
        written.extend(figures.iter().map(PathBuf::as_path));
        let mut timings_s = self.timings_s.take();
        timings_s.insert("total".to_owned(), self.begin.elapsed().as_secs_f64());
        manifest::write_run_json(
            &self.files.run,
            &RunJson {
                timings_s,
                plan_ms: plan_times(generated),
                peak_memory_bytes: manifest::peak_memory_bytes(),
                threads: rayon::current_num_threads(),
                command: self.options.command.clone(),
                manifest: Manifest::of(&self.session.name, key, &self.options.output, &written)?,
            },
        )
    }
}

fn stored_evaluation(path: &Path) -> Result<Evaluation, SessionError> {
    let text = std::fs::read_to_string(path).map_err(SessionError::io("read", path))?;
    Ok(inhand_report::read_evaluation_json(&text)?.0)
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
