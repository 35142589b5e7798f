//! `run.json`: what differs from run to run, and what tells whether results are up to date.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};
use std::time::Duration;

use inhand_model::Provenance;
use inhand_report::PlanTimes;
use inhand_statistics::quantiles::quantile;
use serde::{Deserialize, Serialize};

use crate::TOOL;
use crate::error::SessionError;
use crate::files::{hash_file, hex_sha256};
use crate::methods::Method;
use crate::output::{self, folder_of};
use crate::scope::OutputScope;
use crate::session::Session;
use crate::settings::{EvaluateSection, LookSection, PlanSection, Settings};
use crate::take::Take;

/// File name of the run's facts in its output folder.
pub(crate) const RUN_FILE: &str = "run.json";

/// Facts of one run.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct RunJson {
    /// Wall time of each step, seconds.
    pub timings_s: BTreeMap<String, f64>,
    /// Time of single plans by method, milliseconds.
    pub plan_ms: BTreeMap<String, PlanMs>,
    /// Largest memory in use, bytes; `None` where the system does not tell.
    pub peak_memory_bytes: Option<u64>,
    /// Threads.
    pub threads: usize,
    /// Command as typed.
    pub command: Vec<String>,
    /// What the results were made from, and their content.
    pub manifest: Manifest,
}

/// Times of single plans, milliseconds.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct PlanMs {
    /// Plans.
    pub n: usize,
    /// Median.
    pub p50: f64,
    /// 95 % quantile.
    pub p95: f64,
    /// Longest.
    pub max: f64,
}

impl PlanMs {
    /// Summary of plan times.
    pub fn new(times: &[Duration]) -> Self {
        let mut ms: Vec<_> = times
            .iter()
            .map(|time| time.as_secs_f64() * 1000.0)
            .collect();
        ms.sort_unstable_by(f64::total_cmp);
        let at = |q| quantile(&ms, q).unwrap_or(f64::NAN);
        Self {
            n: ms.len(),
            p50: at(0.5),
            p95: at(0.95),
            max: at(1.0),
        }
    }
}

/// What results were made from, and their content.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// Name of the session.
    pub session: String,
    /// SHA-256 over inputs, settings and version.
    pub key: String,
    /// SHA-256 of each result by its path in the output folder, with `/` between its parts.
    pub outputs: BTreeMap<String, String>,
}

impl Manifest {
    /// The manifest of results that were just written into a folder.
    ///
    /// # Errors
    ///
    /// [`SessionError::Io`].
    pub fn of(
        session: &str,
        key: String,
        folder: &Path,
        outputs: &[&Path],
    ) -> Result<Self, SessionError> {
        let outputs = inhand_parallel::try_map(outputs, |path| -> Result<_, SessionError> {
            Ok((name_in(folder, path), hash_of(path)?))
        })?;
        Ok(Self {
            session: session.to_owned(),
            key,
            outputs: outputs.into_iter().collect(),
        })
    }
}

/// Key of everything that results depend on; `scope` has the parts that are written.
pub(crate) fn key(session: &Session, provenance: &Provenance, scope: OutputScope) -> String {
    let takes: Vec<_> = (session.takes.iter())
        .map(|take| {
            format!(
                "{:?} {} {:?} {:?} {:?}",
                take.role, take.name, take.from_s, take.to_s, take.part
            )
        })
        .collect();
    hex_sha256(format!("{} {provenance:?} {takes:?} {scope:?}", session.name).as_bytes())
}

/// Key of results that were made by these steps, for all files of them.
pub fn results_key(session: &str, steps: &[Provenance]) -> String {
    hex_sha256(format!("{session} {steps:?}").as_bytes())
}

/// Provenance of a dictionary: only the settings and takes that it depends on.
pub(crate) fn learn_provenance<'a>(
    settings: &Settings,
    takes: impl IntoIterator<Item = &'a Take>,
) -> Provenance {
    let mut relevant = settings.clone();
    // The choice of a method depends on how plans are made; primitives and deviations do not.
    if !settings.plan.methods.contains(&Method::Auto) {
        relevant.plan = PlanSection::default();
    }
    // The offset of the object is in segments that carry it; shape and contact distance count where the method is
    // chosen among plans that hold.
    let chooses = settings.plan.methods.contains(&Method::Auto);
    if !(chooses && settings.plan.holding) {
        relevant.evaluate = EvaluateSection::default();
        relevant.object.shape = None;
    }
    relevant.look = LookSection::default();
    relevant.name = None;
    let ranges = settings
        .takes
        .iter()
        .filter(|take| take.role != Some(crate::settings::Role::Test));
    relevant.takes = ranges.cloned().collect();
    Provenance {
        tool: TOOL.to_owned(),
        step: "learn".to_owned(),
        settings_json: relevant.json(),
        inputs: takes.into_iter().map(|take| take.hash.clone()).collect(),
    }
}

/// The results of an earlier run with this key that have not changed since, and whether those are all of its results.
pub(crate) fn unchanged(run_file: &Path, session: &str, key: &str) -> (BTreeSet<PathBuf>, bool) {
    let earlier = read(run_file).map(|run| run.manifest);
    let earlier = earlier.filter(|earlier| earlier.key == key && earlier.session == session);
    let listed: Vec<_> =
        earlier.map_or_else(Vec::new, |earlier| earlier.outputs.into_iter().collect());
    let unchanged = inhand_parallel::map(&listed, |(name, hash)| {
        let path = file_in(folder_of(run_file), name)?;
        // A device or FIFO in its place may never end.
        if output::is_stream(&path) {
            return None;
        }
        hash_of(&path).is_ok_and(|now| now == *hash).then_some(path)
    });
    let unchanged: BTreeSet<_> = unchanged.into_iter().flatten().collect();
    let all = unchanged.len() == listed.len();
    (unchanged, all)
}

/// Whether a file is the `run.json` of an earlier run of this session.
pub(crate) fn is_run_of(path: &Path, session: &str) -> bool {
    read(path).is_some_and(|earlier| earlier.manifest.session == session)
}

/// Marks the output folder as ours and what is in it as not belonging together (yet); removes and returns what
/// an earlier run wrote, unchanged since, and this one will not write again.
///
/// # Errors
///
/// [`SessionError::Io`].
pub(crate) fn claim(
    run_file: &Path,
    session: &str,
    outputs: &[&Path],
    command: &[String],
) -> Result<Vec<PathBuf>, SessionError> {
    let (folder, mut removed) = (folder_of(run_file), Vec::new());
    let earlier = read(run_file).map_or_else(BTreeMap::new, |earlier| earlier.manifest.outputs);
    for (name, hash) in earlier {
        let Some(stale) = file_in(folder, &name) else {
            continue;
        };
        let kept = outputs.iter().any(|path| name_in(folder, path) == name);
        if !kept && hash_of(&stale).is_ok_and(|now| now == hash) {
            std::fs::remove_file(&stale).map_err(SessionError::io("remove", &stale))?;
            removed.push(stale);
        }
    }
    let unfinished = RunJson {
        threads: rayon::current_num_threads(),
        command: command.to_vec(),
        manifest: Manifest {
            session: session.to_owned(),
            ..Manifest::default()
        },
        ..RunJson::default()
    };
    write_run_json(run_file, &unfinished)?;
    Ok(removed)
}

/// Writes `run.json`.
///
/// # Errors
///
/// [`SessionError::Io`].
pub(crate) fn write_run_json(path: &Path, run: &RunJson) -> Result<(), SessionError> {
    let mut text = serde_json::to_string_pretty(run)
        .expect("a struct of numbers and strings with string keys is valid JSON");
    text.push('\n');
    output::write_text(path, &text)
}

/// How long plans took that an evaluation judges: from the `run.json` beside it, where that is of the run
/// that wrote it.
pub fn plan_times_beside(evaluation: &Path) -> Vec<PlanTimes> {
    let folder = folder_of(evaluation);
    let run = read(&folder.join(RUN_FILE)).filter(|run| {
        let hash = run.manifest.outputs.get(&name_in(folder, evaluation));
        hash.is_some_and(|hash| hash_of(evaluation).is_ok_and(|now| now == *hash))
    });
    let times = run.map_or_else(BTreeMap::new, |run| run.plan_ms);
    (times.into_iter())
        .map(|(method, ms)| PlanTimes {
            method,
            n: ms.n,
            p50_ms: ms.p50,
            p95_ms: ms.p95,
            max_ms: ms.max,
        })
        .collect()
}

/// Largest memory in use by this process so far, bytes, where the system tells.
pub fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}

pub(crate) fn read(path: &Path) -> Option<RunJson> {
    serde_json::from_slice(&std::fs::read(path).ok()?).ok()
}

pub(crate) fn hash_of(path: &Path) -> Result<String, SessionError> {
    Ok(hash_file(path)?.sha256)
}

/// The path of a result in its folder, with `/` on every system.
fn name_in(folder: &Path, path: &Path) -> String {
    let inside = path.strip_prefix(folder).unwrap_or(path);
    let parts = inside.components();
    let parts = parts.map(|part| part.as_os_str().to_string_lossy().into_owned());
    parts.collect::<Vec<_>>().join("/")
}

/// The file of that name in the folder; `None` for a name that leads out of it, as only a file that was
/// tampered with holds.
pub(crate) fn file_in(folder: &Path, name: &str) -> Option<PathBuf> {
    let inside = Path::new(name)
        .components()
        .all(|part| matches!(part, Component::Normal(_)));
    inside.then(|| folder.join(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_in_their_folder() {
        let folder = Path::new("/data/out");
        let name = name_in(folder, &folder.join("figures").join("a.svg"));
        assert_eq!(name, "figures/a.svg");
        assert_eq!(
            file_in(folder, &name),
            Some("/data/out/figures/a.svg".into())
        );
        for leading_out in ["../a", "/etc/passwd", "figures/../../a"] {
            assert_eq!(file_in(folder, leading_out), None);
        }
    }
}
