//! Simulated sessions on disk.

use std::path::{Path, PathBuf};

use inhand_channels::{TakeFile, Views};
use inhand_model::Provenance;
use inhand_simulation::{FaultKind, SessionSettings, SimulatedTake, session};
use serde_json::json;

use crate::TOOL;
use crate::error::{Located, SessionError};
use crate::output;
use crate::session::{SETTINGS_FILE, is_take};
use crate::settings::Role;
use crate::take_file;

/// Folder of the simulated session inside the demo's output.
pub const DEMO_SESSION: &str = "session";

/// File format of simulated takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TakeFormat {
    /// MCAP recordings.
    Mcap,
    /// Motive CSV 1.23.
    MotiveCsv,
}

/// Simulates a session and writes it as a folder with `train/`, `test/` and settings.
///
/// # Errors
///
/// [`SessionError::At`], [`SessionError::Io`], [`SessionError::Usage`].
pub fn simulate_session(
    folder: &Path,
    simulated: &SessionSettings,
    seed: u64,
    format: TakeFormat,
    force: bool,
) -> Result<Vec<PathBuf>, SessionError> {
    let takes = session(simulated, seed)?;
    let _claim = output::claim_folder(folder)?;
    let roles = (takes.train.iter().map(|take| (Role::Train, take)))
        .chain(takes.test.iter().map(|take| (Role::Test, take)));
    let files: Vec<_> = roles
        .map(|(role, take)| (path(folder, role, take, format), take))
        .collect();
    let settings_path = folder.join(SETTINGS_FILE);
    for target in files.iter().map(|(path, _)| path).chain([&settings_path]) {
        output::check_target(target, &[], || force)?;
    }
    refuse_other_takes(folder, &files)?;
    let provenance = Provenance {
        tool: TOOL.to_owned(),
        step: "simulate".to_owned(),
        settings_json: format!("{{\"seed\":{seed}}}"),
        inputs: Vec::new(),
    };
    // Before the takes: it says that a session which a killed process left behind is a simulated one.
    let text = format!("[object]\nshape = \"{}\"\n", simulated.take.shape);
    output::write_text(&settings_path, &text)?;
    inhand_parallel::try_map(&files, |(path, take)| {
        write_simulated(path, take, format, &provenance)
    })?;
    for (path, take) in &files {
        if simulated.faults.is_some() {
            let truth = path.with_extension("truth.json");
            output::write_text(&truth, &faults_json(take))?;
        }
    }
    Ok(files.into_iter().map(|(path, _)| path).collect())
}

/// Places of planted faults, to judge a search by. Samples count from 0, `last` is
/// the last one that is wrong; lengths are metres, rotations quaternions x, y, z, w.
fn faults_json(take: &SimulatedTake) -> String {
    let faults: Vec<_> = (take.faults.iter())
        .map(|fault| {
            let mut entry = json!({
                "kind": fault.kind.name(),
                "entities": fault.entities,
                "first": fault.samples.start,
                "last": fault.samples.end.saturating_sub(1),
            });
            match &fault.kind {
                FaultKind::Spike { off_m, was_m } => {
                    entry["off_m"] = json!(off_m);
                    entry["was_m"] = json!(was_m);
                }
                FaultKind::Flip { true_from_recorded } => {
                    let translation: [f64; 3] = true_from_recorded.translation.vector.into();
                    let rotation: [f64; 4] = true_from_recorded.rotation.coords.into();
                    entry["true_from_recorded"] =
                        json!({ "translation_m": translation, "rotation_xyzw": rotation });
                }
                _ => {}
            }
            entry
        })
        .collect();
    let truth = json!({
        "take": take.recording.name,
        "samples": take.recording.len(),
        "rate_hz": take.recording.clock.rate_hz(),
        "faults": faults,
    });
    format!("{truth:#}\n")
}

/// Takes of another session in the same folders would become part of this one.
fn refuse_other_takes(
    folder: &Path,
    files: &[(PathBuf, &SimulatedTake)],
) -> Result<(), SessionError> {
    for role in [Role::Train, Role::Test] {
        let Ok(entries) = std::fs::read_dir(folder.join(role.name())) else {
            continue; // Not there yet.
        };
        let mut others = entries.flatten().map(|entry| entry.path());
        let other =
            others.find(|path| is_take(path) && !files.iter().any(|(ours, _)| ours == path));
        if let Some(path) = other {
            let message = "the folder holds a take of another session: name another folder, or \
                           remove that session"
                .to_owned();
            return Err(SessionError::usage(path, message));
        }
    }
    Ok(())
}

fn path(folder: &Path, role: Role, take: &SimulatedTake, format: TakeFormat) -> PathBuf {
    let extension = match format {
        TakeFormat::Mcap => "mcap",
        TakeFormat::MotiveCsv => "csv",
    };
    folder
        .join(role.name())
        .join(format!("{}.{extension}", take.recording.name))
}

fn write_simulated(
    path: &Path,
    take: &SimulatedTake,
    format: TakeFormat,
    provenance: &Provenance,
) -> Result<(), SessionError> {
    match format {
        TakeFormat::MotiveCsv => output::write_atomic(path, |out| {
            inhand_capture::motive::write(&take.recording, out).in_file(path)
        }),
        TakeFormat::Mcap => {
            let recording = take.rounded_recording();
            let file = TakeFile {
                provenance: std::slice::from_ref(provenance),
                ..TakeFile::new(&recording)
            };
            take_file::write_parts(path, &file, Views::None)
        }
    }
}
