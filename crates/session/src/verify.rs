//! Files and results against themselves, their inputs and each other.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use inhand_channels::{Metadata, VerifiedFile};
use inhand_container::{Differences, Interval};
use inhand_model::{BodySource, Finger, InputHash, Protocol, Provenance};
use inhand_motion::{Deviation, deviations};

use crate::containers;
use crate::error::{Located, SessionError, in_words};
use crate::files::{name_of, open, take_start};
use crate::manifest::{self, RUN_FILE};
use crate::output::folder_of;
use crate::sessions::Part;
use crate::settings::Settings;
use crate::steps;
use crate::take::{self, Take, hash_take};

/// Length of the start of a take whose processed motion is computed again.
const SAMPLE_NANOS: u64 = 20_000_000_000;

/// More than decoding and filtering a part of a take does to a position, metres.
const TOLERANCE_M: f64 = 1e-7;

/// What was compared of a file.
#[derive(Debug, Default)]
#[non_exhaustive]
pub struct Verified {
    /// Structure and messages of an MCAP file.
    pub container: Option<VerifiedFile>,
    /// Numbers that were computed again, and results that were compared with their hashes, by what they are.
    pub recomputed: BTreeMap<String, u64>,
    /// Inputs that the file names.
    pub inputs: usize,
    /// Those of them that are not at hand, by name.
    pub absent_inputs: Vec<String>,
    /// What was not compared.
    pub notes: Vec<String>,
    /// Differences, without those of the structure.
    pub differences: Differences,
}

/// Files among which inputs are looked for by name.
#[derive(Debug, Default)]
pub struct InputFiles {
    by_name: BTreeMap<String, Vec<PathBuf>>,
    hashes: BTreeMap<PathBuf, String>,
}

impl InputFiles {
    /// All files and folders in these folders and the folders in them.
    ///
    /// # Errors
    ///
    /// [`SessionError::Io`].
    pub fn new(folders: &[PathBuf]) -> Result<Self, SessionError> {
        let mut found = Self::default();
        for folder in folders {
            for path in entries(folder)? {
                found.by_name.entry(name_of(&path)).or_default().push(path);
            }
        }
        Ok(found)
    }

    fn hash(&mut self, path: &Path) -> Result<String, SessionError> {
        if let Some(known) = self.hashes.get(path) {
            return Ok(known.clone());
        }
        let hash = hash_take(path)?.sha256;
        self.hashes.insert(path.to_owned(), hash.clone());
        Ok(hash)
    }
}

/// Everything in a folder and the folders in it, sorted.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, SessionError> {
    let read = std::fs::read_dir(folder).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    let mut found = Vec::new();
    for entry in read.map_err(SessionError::io("read", folder))? {
        // Links may lead in circles.
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            found.extend(entries(&entry.path())?);
        }
        found.push(entry.path());
    }
    found.sort();
    Ok(found)
}

/// The files of a folder, and of the folders in it, that [`verify`] takes: MCAP files, `evaluation.json`, `run.json`.
///
/// # Errors
///
/// [`SessionError::Io`].
pub fn verifiable(folder: &Path) -> Result<Vec<PathBuf>, SessionError> {
    let mut found = entries(folder)?;
    found.retain(|path| {
        let of_run = ["evaluation.json", RUN_FILE].contains(&&*name_of(path));
        path.is_file() && (of_run || path.extension().is_some_and(|ending| ending == "mcap"))
    });
    Ok(found)
}

/// Compares a file with itself and with what is at hand of what it names: an MCAP file with its inputs and, of a take,
/// the processed motion of its first 20 s with that computed again from the recording; an `evaluation.json` with the
/// rows beside it and its inputs; a `run.json` with the results beside it.
///
/// # Errors
///
/// [`SessionError::Io`], [`SessionError::At`] for a file that is none of these.
pub fn verify(path: &Path, inputs: &mut InputFiles) -> Result<Verified, SessionError> {
    let mut verified = Verified::default();
    let name = name_of(path);
    if name == RUN_FILE {
        verified.results(path)?;
    } else if name.ends_with(".json") {
        verified.evaluation(path, inputs)?;
    } else {
        let container = inhand_channels::verify(&mut open(path)?).in_file(path)?;
        if container.audit.differences.is_empty() && container.metadata.is_take() {
            match verified.motion(path, &container.metadata) {
                Ok(()) => {}
                Err(error) => {
                    let note = format!("not computed again: {}", in_words(&error));
                    verified.notes.push(note);
                }
            }
        }
        match container.metadata.provenance(&name) {
            Ok(steps) => verified.inputs(path, &steps, inputs)?,
            Err(error) => verified
                .differences
                .add("provenance", "a record of each step", error),
        }
        verified.container = Some(container);
    }
    Ok(verified)
}

impl Verified {
    /// Results against the hashes that `run.json` states.
    fn results(&mut self, path: &Path) -> Result<(), SessionError> {
        let other = || SessionError::data(path, "expected the facts of a run, found other content");
        let manifest = manifest::read(path).ok_or_else(other)?.manifest;
        if manifest.key.is_empty() {
            self.differences
                .add(RUN_FILE, "a run that ended", "one that did not");
        }
        for (name, stated) in &manifest.outputs {
            let file = manifest::file_in(folder_of(path), name);
            let held = file.and_then(|file| manifest::hash_of(&file).ok());
            let held = held.as_deref().unwrap_or("no such file");
            self.differences.compare(name, stated.as_str(), held);
        }
        self.count("results", manifest.outputs.len());
        Ok(())
    }

    /// An evaluation against its rows.
    fn evaluation(&mut self, path: &Path, inputs: &mut InputFiles) -> Result<(), SessionError> {
        let text = std::fs::read_to_string(path).map_err(SessionError::io("read", path))?;
        let (_, provenance) = inhand_report::read_evaluation_json(&text).in_file(path)?;
        match Part::read(path).and_then(|part| self.rows(&part)) {
            Ok(()) => {}
            Err(error) => {
                self.differences
                    .add("rows", "those of this evaluation", in_words(&error));
            }
        }
        self.inputs(path, &provenance, inputs)
    }

    fn rows(&mut self, part: &Part) -> Result<(), SessionError> {
        for protocol in Protocol::ALL {
            if !part.has_rows(protocol) {
                self.notes
                    .push(format!("no rows of the protocol {}", protocol.name()));
                continue;
            }
            for method in part.evaluation.methods(protocol) {
                for finger in Finger::ALL {
                    let errors = part.errors_m(protocol, &method.name, finger)?;
                    self.count("errors behind means", errors.len());
                }
            }
        }
        Ok(())
    }

    /// Inputs at hand against the hashes that the steps name.
    fn inputs(
        &mut self,
        path: &Path,
        steps: &[Provenance],
        files: &mut InputFiles,
    ) -> Result<(), SessionError> {
        let mut named: Vec<&InputHash> = steps.iter().flat_map(|step| &step.inputs).collect();
        named.sort();
        named.dedup();
        self.inputs = named.len();
        for input in &named {
            let mut at_hand = files.by_name.get(&input.name).cloned().unwrap_or_default();
            let beside = folder_of(path).join(&input.name);
            at_hand.extend(beside.exists().then_some(beside));
            // Results often have the name of the take that they were made from.
            at_hand.retain(|other| !is_made_from(other, input));
            let hashes = (at_hand.iter()).map(|other| files.hash(other));
            let hashes = hashes.collect::<Result<Vec<_>, _>>()?;
            // So do the inputs of earlier and later steps.
            let is_named = |hash: &String| named.iter().any(|other| other.sha256 == *hash);
            if hashes.contains(&input.sha256) {
                continue;
            }
            match hashes.iter().position(|hash| !is_named(hash)) {
                None => self.absent_inputs.push(input.name.clone()),
                Some(k) => {
                    let place = format_args!("input {}, SHA-256", at_hand[k].display());
                    self.differences.add(place, &input.sha256, &hashes[k]);
                }
            }
        }
        Ok(())
    }

    /// Stored motion against that computed again.
    fn motion(&mut self, path: &Path, metadata: &Metadata) -> Result<(), SessionError> {
        let Some(start) = take_start(metadata).filter(|_| metadata.0.contains_key("inhand.motion"))
        else {
            return Ok(());
        };
        let folder =
            tempfile::tempdir().map_err(SessionError::io("write", &std::env::temp_dir()))?;
        let part = folder.path().join(name_of(path));
        let first = Interval::new(0, Some(start.saturating_add(SAMPLE_NANOS)));
        containers::cut(path, &part, &[first])?;
        let take = take::read(&part, &Settings::default())?;
        let settings = Settings::of_steps(&take.provenance);
        let (roles, stored) = (take.roles()?.clone(), take.stored_motion.clone());
        let mut takes = [take];
        let mut bodies = [&roles.hand].into_iter().chain(&roles.object);
        let fitted = bodies.any(|body| matches!(body, BodySource::Markers(_)));
        let held = match fitted {
            false => steps::process_takes(&takes, &settings)?,
            true => {
                let note = "not computed again: hand and object, fitted to markers of all takes";
                self.notes.push(note.to_owned());
                let motions = steps::stored_motions(&mut takes, &settings)?;
                steps::smooth_motions(motions.map_or_else(Vec::new, |m| m.held_out), &settings)?
            }
        };
        let (Some(held), Some(stored)) = (held.first(), &stored) else {
            return Ok(());
        };
        let within = inside(&takes[0], &settings);
        for Deviation { part, sample, by } in
            deviations(held, stored, &within, !fitted, TOLERANCE_M)
        {
            let expected = "as computed from the recording";
            let found = format!("{:.4} mm from there", by * 1e3);
            self.differences.add(
                format_args!("/processed, {part}, sample {sample}"),
                expected,
                found,
            );
        }
        self.count("processed samples", within.len());
        Ok(())
    }

    fn count(&mut self, what: &str, number: usize) {
        *self.recomputed.entry(what.to_owned()).or_default() += number as u64;
    }
}

/// Samples that no filter connects with what an earlier or this cut took away.
fn inside(take: &Take, settings: &Settings) -> Range<usize> {
    let (process, rate_hz) = (&settings.process, take.recording.clock.rate_hz());
    let margin_s = 1.0 + 2.0 * process.max_gap_s + 5.0 / process.cutoff_hz;
    let margin = (margin_s * rate_hz) as usize + process.window;
    margin..take.recording.len().saturating_sub(margin).max(margin)
}

/// Whether a file names this input among its own.
fn is_made_from(path: &Path, input: &InputHash) -> bool {
    let metadata = || inhand_channels::metadata_of_source(&mut open(path).ok()?).ok();
    let steps = || metadata()?.provenance(&input.name).ok();
    let ends_in_mcap = path.extension().is_some_and(|ending| ending == "mcap");
    let steps = ends_in_mcap.then(steps).flatten().unwrap_or_default();
    steps.iter().any(|step| step.inputs.contains(input))
}
