//! Takes in memory: read from a vendor file or MCAP, with roles and hash.

use std::path::{Path, PathBuf};

use inhand_capture::roles::{RoleSettings, resolve};
use inhand_channels::{CleanedTake, ReadCleaned, ReadTake, TakeFile};
use inhand_model::{
    Annotations, BodySource, Change, Clock, Finger, InputHash, Motion, PointTrack, Provenance,
    Recording, Roles, World,
};

use crate::error::{Located, SessionError};
use crate::files::{facts_path, hex_sha256, name_of};
use crate::session::{Session, SessionTake};
use crate::settings::{Role, Settings};

/// A take in memory.
#[derive(Clone, Debug)]
pub struct Take {
    /// File it was read from.
    pub path: PathBuf,
    /// Name of its output.
    pub name: String,
    /// What is used of it: what was measured, or that after cleaning where it was cleaned.
    pub recording: Recording,
    /// What was measured, where `recording` is cleaned, and what was changed.
    pub cleaning: Option<Cleaning>,
    /// Which entity has which role; an error where it is undetermined.
    pub roles: Result<Roles, String>,
    /// Content of the file.
    pub hash: InputHash,
    /// Events on its time line and facts about it.
    pub annotations: Annotations,
    /// Steps that made the file, first to last; empty for a vendor file.
    pub provenance: Vec<Provenance>,
    /// Motion that an earlier step stored in the file.
    pub stored_motion: Option<Motion>,
}

/// Where a cleaned recording comes from.
#[derive(Clone, Debug)]
pub struct Cleaning {
    /// What was measured.
    pub measured: Recording,
    /// What was changed, in the order of the steps; samples are those of `measured`.
    pub changes: Vec<Change>,
}

/// Reads a take, whatever its format; cleaned where it was stored so, or where the settings' table
/// `[clean]` names steps. Roles are determined where that is possible.
///
/// # Errors
///
/// [`SessionError`] with file, line or topic.
pub fn read(path: &Path, settings: &Settings) -> Result<Take, SessionError> {
    let bytes = std::fs::read(path).map_err(SessionError::io("read", path))?;
    let file_name = name_of(path);
    let role_settings = settings.role_settings()?;
    // What a table cannot hold is in a file beside it, and counts as part of it.
    let facts = table_facts(path, &bytes)?;
    // Hashing takes as long as parsing: do both at once.
    let (sha256, parsed) = inhand_parallel::both(
        || content_hash(&bytes, facts.as_deref()),
        || -> Result<_, SessionError> {
            if inhand_channels::is_mcap(&bytes) {
                let settings = settings.import_settings()?;
                inhand_import::read_take(&bytes, &file_name, &settings).in_file(path)
            } else if inhand_export::looks_like_wide_csv(&bytes) {
                let up_axis = settings.read_settings()?.up_axis;
                let recording =
                    inhand_export::read_wide_csv(&bytes, &file_name, facts.as_deref(), up_axis)
                        .in_file(path)?;
                Ok(vendor_take(recording))
            } else {
                let recording =
                    inhand_capture::read(&bytes, &file_name, &settings.read_settings()?)
                        .in_file(path)?;
                Ok(vendor_take(recording))
            }
        },
    );
    let ReadTake {
        recording,
        cleaned,
        roles,
        motion,
        annotations,
        provenance,
    } = parsed?;
    // Roles that an earlier step found stay, unless this call says otherwise.
    let roles = match roles {
        Some(roles) if role_settings == RoleSettings::default() => Ok(roles),
        _ => resolve(&recording, &role_settings).map_err(|error| error.to_string()),
    };
    let hash = InputHash {
        name: file_name,
        sha256,
    };
    let name = crate::session::stem(path);
    let (recording, cleaning) = match cleaned {
        None => (recording, None),
        Some(ReadCleaned {
            recording: cleaned,
            changes,
        }) => {
            let measured = recording;
            (cleaned, Some(Cleaning { measured, changes }))
        }
    };
    Ok(Take {
        path: path.to_owned(),
        name,
        recording,
        cleaning,
        roles,
        hash,
        annotations,
        provenance,
        stored_motion: motion,
    })
}

/// As [`read`], cleaned by the steps that the settings name. A take that was cleaned before stays as it
/// is: what a person did by hand is kept.
///
/// # Errors
///
/// As [`read`]; [`SessionError::At`], and [`SessionError::Data`] where roles are undetermined.
pub fn read_clean(path: &Path, settings: &Settings) -> Result<Take, SessionError> {
    let take = read(path, settings)?;
    match settings.clean.steps()? {
        Some(steps) if take.cleaning.is_none() => crate::clean::cleaned(&take, &steps),
        _ => Ok(take),
    }
}

/// The facts beside a wide table, where there are any.
fn content_hash(bytes: &[u8], facts: Option<&[u8]>) -> String {
    facts.map_or_else(
        || hex_sha256(bytes),
        |facts| hex_sha256(&[bytes, facts].concat()),
    )
}

/// SHA-256 of a take, the facts beside a table included: that of a [`Take`] without parsing it.
///
/// # Errors
///
/// [`SessionError::Io`].
pub fn hash_take(path: &Path) -> Result<String, SessionError> {
    let bytes = std::fs::read(path).map_err(SessionError::io("read", path))?;
    let facts = table_facts(path, &bytes)?;
    Ok(content_hash(&bytes, facts.as_deref()))
}

fn table_facts(path: &Path, bytes: &[u8]) -> Result<Option<Vec<u8>>, SessionError> {
    let facts = facts_path(path);
    if !inhand_export::looks_like_wide_csv(bytes) || !facts.exists() {
        return Ok(None);
    }
    std::fs::read(&facts)
        .map(Some)
        .map_err(SessionError::io("read", &facts))
}

/// A take of which there is nothing but what was measured.
fn vendor_take(recording: Recording) -> ReadTake {
    ReadTake {
        recording,
        cleaned: None,
        roles: None,
        motion: None,
        annotations: Annotations::default(),
        provenance: Vec::new(),
    }
}

impl Take {
    /// What was measured, whether it was cleaned or not.
    pub fn measured(&self) -> &Recording {
        (self.cleaning.as_ref()).map_or(&self.recording, |cleaning| &cleaning.measured)
    }

    /// The cleaned recording as it goes into a file.
    pub fn cleaned(&self) -> Option<CleanedTake<'_>> {
        self.cleaning.as_ref().map(|cleaning| CleanedTake {
            recording: &self.recording,
            changes: &cleaning.changes,
        })
    }

    /// The take as a file of what was recorded and cleaned, made by these steps.
    pub fn file<'a>(&'a self, provenance: &'a [Provenance]) -> TakeFile<'a> {
        TakeFile {
            cleaned: self.cleaned(),
            roles: self.roles.as_ref().ok(),
            annotations: Some(&self.annotations),
            provenance,
            ..TakeFile::new(self.measured())
        }
    }

    /// The steps that made the take, and another one.
    pub fn made_by(&self, step: &Provenance) -> Vec<Provenance> {
        [&self.provenance[..], std::slice::from_ref(step)].concat()
    }

    /// The roles, or an error that says which one is undetermined.
    ///
    /// # Errors
    ///
    /// [`SessionError::Data`].
    pub fn roles(&self) -> Result<&Roles, SessionError> {
        self.roles
            .as_ref()
            .map_err(|message| self.error(message.clone()))
    }

    pub(crate) fn error(&self, message: String) -> SessionError {
        SessionError::data(&self.path, message)
    }
}

/// Reads every take of a session and checks that they can be used together.
///
/// # Errors
///
/// The first take, in the session's order, that cannot be read; takes of different rates; takes
/// that serve for training and testing at once.
pub fn read_session(session: &Session, settings: &Settings) -> Result<Vec<Take>, SessionError> {
    let takes = inhand_parallel::try_map(&session.takes, |entry| read_entry(entry, settings))?;
    for take in &takes {
        take.roles()?;
    }
    check_rates((takes.iter()).map(|take| (take.path.as_path(), take.recording.clock)))?;
    if !settings.allow_shared_takes {
        check_disjoint(session, &takes)?;
    }
    Ok(takes)
}

fn read_entry(entry: &SessionTake, settings: &Settings) -> Result<Take, SessionError> {
    let mut take = read_clean(&entry.path, settings)?;
    take.name.clone_from(&entry.name);
    if entry.from_s.is_none() && entry.to_s.is_none() {
        return Ok(take);
    }
    let (clock, len) = (take.recording.clock, take.recording.len());
    let from = entry.from_s.map_or(0, |s| clock.nearest_sample(s));
    let to = entry.to_s.map_or(len, |s| clock.nearest_sample(s));
    if from >= len {
        return Err(take.error(format!(
            "from_s is {} s, but the take ends after {} s",
            entry.from_s.unwrap_or_default(),
            clock.time_s(len)
        )));
    }
    take.recording = take.recording.slice(from..to);
    if let Some(cleaning) = &mut take.cleaning {
        cleaning.keep(clock.time_s(from), clock.time_s(to.min(len)));
    }
    take.stored_motion = None; // It belongs to the whole take.
    Ok(take)
}

impl Cleaning {
    /// Keeps what is in this time range, seconds after the first sample.
    fn keep(&mut self, from_s: f64, to_s: f64) {
        let clock = self.measured.clock;
        let kept = clock.nearest_sample(from_s)..clock.nearest_sample(to_s);
        self.measured = self.measured.slice(kept.clone());
        for change in &mut self.changes {
            let within = |k: usize| k.clamp(kept.start, kept.end) - kept.start;
            change.samples = within(change.samples.start)..within(change.samples.end);
        }
        self.changes.retain(|change| !change.samples.is_empty());
    }
}

/// Refuses takes of different rates; each comes with its file.
///
/// # Errors
///
/// [`SessionError::Data`] for the first take of another rate than the first.
pub fn check_rates<'a>(
    takes: impl IntoIterator<Item = (&'a Path, Clock)>,
) -> Result<(), SessionError> {
    let mut takes = takes.into_iter();
    let Some((first, clock)) = takes.next() else {
        return Ok(());
    };
    match takes.find(|(_, other)| !other.has_rate_of(clock)) {
        None => Ok(()),
        Some((path, other)) => Err(SessionError::data(
            path,
            format!(
                "the take has {} Hz, but {} has {} Hz: takes that are used together need one rate",
                other.rate_hz(),
                first.display(),
                clock.rate_hz()
            ),
        )),
    }
}

fn check_disjoint(session: &Session, takes: &[Take]) -> Result<(), SessionError> {
    let with = |role| {
        takes
            .iter()
            .zip(&session.takes)
            .filter(move |(_, entry)| entry.role == role)
    };
    for (test, test_entry) in with(Role::Test) {
        for (train, train_entry) in with(Role::Train) {
            let same = same_source(test, train) && overlap(test_entry, train_entry);
            if same || same_motion(test, train) {
                return Err(test.error(format!(
                    "the test take is also the training take {}: give each its own time range \
                     (from_s, to_s), or set allow_shared_takes = true to accept results that \
                     look better than they are",
                    train.path.display()
                )));
            }
        }
    }
    Ok(())
}

/// Whether two takes are one file, or come from one by steps that each read a single file.
pub(crate) fn same_source(a: &Take, b: &Take) -> bool {
    let sources = |take: &Take| -> Vec<String> {
        let steps = take.provenance.iter().filter(|step| step.inputs.len() == 1);
        let inputs = steps.map(|step| step.inputs[0].sha256.clone());
        inputs.chain([take.hash.sha256.clone()]).collect()
    };
    let of_b = sources(b);
    sources(a).iter().any(|source| of_b.contains(source))
}

/// Whether most samples of a fingertip are equal to the last digit: the same take, however it was
/// stored or touched since.
pub(crate) fn same_motion(a: &Take, b: &Take) -> bool {
    let (Some(a), Some(b)) = (thumb(a), thumb(b)) else {
        return false;
    };
    let both = a.iter().zip(b.iter()).filter_map(|(a, b)| Some((a?, b?)));
    let (mut equal, mut n) = (0, 0);
    for (a, b) in both {
        equal += usize::from(a == b);
        n += 1;
    }
    n > 0 && 2 * equal > n
}

fn thumb(take: &Take) -> Option<&PointTrack<World>> {
    let marker = &take.roles.as_ref().ok()?.fingers[Finger::Thumb];
    Some(&take.recording.marker(marker)?.track)
}

fn overlap(a: &SessionTake, b: &SessionTake) -> bool {
    let start = |take: &SessionTake| take.from_s.unwrap_or(0.0);
    let end = |take: &SessionTake| take.to_s.unwrap_or(f64::INFINITY);
    start(a) < end(b) && start(b) < end(a)
}

/// Names of a body's source, for messages.
pub fn describe_source(source: &BodySource) -> String {
    match source {
        BodySource::RigidBody(name) => format!("rigid body \"{name}\""),
        BodySource::Markers(names) => format!("markers {}", names.join(", ")),
    }
}
