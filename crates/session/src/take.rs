//! Takes in memory: read from a vendor file or MCAP, with roles and hash.

use std::ops::Range;
use std::path::{Path, PathBuf};

use inhand_capture::roles::{RoleSettings, resolve};
use inhand_channels::{CleanedTake, ReadCleaned, ReadTake, TakeFile};
use inhand_inspection::{ExactPosition, exact_positions, takes_alike};
use inhand_model::{
    Annotations, Change, Clock, Finger, InputHash, Motion, Provenance, Recording, Roles,
};

use crate::error::{Located, SessionError};
use crate::files::{
    FileSource, facts_path, hash_file, hash_files, hex_sha256_of, name_of, open_rows, open_take,
    take_name, unpack,
};
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
    let role_settings = settings.role_settings()?;
    let stored_name = name_of(path);
    let file_name = inhand_import::unpacked_name(&stored_name);
    let (sha256, parsed) = match open_rows(path)? {
        Some((mut file, extent)) => {
            let settings = settings.read_settings()?;
            let recording = inhand_capture::read_rows(&mut file, extent, file_name, &settings);
            (file.sha256(), recording.map(vendor_take).in_file(path))
        }
        None => read_stored(path, file_name, settings)?,
    };
    let ReadTake {
        recording,
        cleaned,
        roles: stored_roles,
        motion,
        annotations,
        provenance,
    } = parsed?;
    // Roles that an earlier step found stay, unless this call says otherwise.
    let roles = match &stored_roles {
        Some(roles) if role_settings == RoleSettings::default() => Ok(roles.clone()),
        Some(roles) => resolve(&recording, &role_settings.or_stored(roles)),
        None => resolve(&recording, &role_settings),
    };
    let roles = roles.map_err(|error| error.to_string());
    // A motion belongs to the roles that it was made with.
    let motion = motion.filter(|_| roles.as_ref().ok() == stored_roles.as_ref());
    let hash = InputHash {
        name: stored_name,
        sha256,
    };
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
        name: take_name(path),
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
        Some(steps) if take.cleaning.is_none() => crate::clean::cleaned(take, &steps),
        _ => Ok(take),
    }
}

/// Name and content of a take, the facts beside a table included: those of a [`Take`] without parsing it.
///
/// # Errors
///
/// [`SessionError::Io`], and [`SessionError::Data`] for a folder that is no bag.
pub fn hash_take(path: &Path) -> Result<InputHash, SessionError> {
    if path.is_file() && !facts_path(path).exists() {
        return hash_file(path);
    }
    let name = name_of(path);
    let sha256 = match Stored::open(path, &name)? {
        Stored::Mcap(_) => hash_files(path)?,
        Stored::Bytes(bytes, facts) => hex_sha256_of([&*bytes].into_iter().chain(facts.as_deref())),
    };
    Ok(InputHash { name, sha256 })
}

/// A take as it is stored.
enum Stored {
    /// An MCAP file or a bag, of any size.
    Mcap(FileSource),
    /// The bytes of another file or of a stream, and those of the file of facts beside a table.
    Bytes(Vec<u8>, Option<Vec<u8>>),
}

impl Stored {
    fn open(path: &Path, name: &str) -> Result<Self, SessionError> {
        if let Some(source) = open_take(path, name)? {
            return Ok(Self::Mcap(source));
        }
        let read = |path: &Path| std::fs::read(path).map_err(SessionError::io("read", path));
        let (bytes, facts) = (read(path)?, facts_path(path));
        let has_facts = inhand_export::looks_like_wide_csv(&bytes) && facts.exists();
        let facts = has_facts.then(|| read(&facts)).transpose()?;
        Ok(Self::Bytes(bytes, facts))
    }
}

/// Hash and content of a take that is not read by the block.
fn read_stored(
    path: &Path,
    file_name: &str,
    settings: &Settings,
) -> Result<(String, Result<ReadTake, SessionError>), SessionError> {
    let mut stored = Stored::open(path, file_name)?;
    // Hashing takes as long as parsing: do both at once.
    let (sha256, parsed) = match &mut stored {
        Stored::Mcap(source) => inhand_parallel::both(
            || hash_files(path),
            || inhand_import::take_of_source(source, &settings.import_settings()?).in_file(path),
        ),
        Stored::Bytes(bytes, facts) => inhand_parallel::both(
            || {
                Ok(hex_sha256_of(
                    [&**bytes].into_iter().chain(facts.as_deref()),
                ))
            },
            || parse(path, bytes, file_name, facts.as_deref(), settings),
        ),
    };
    Ok((sha256?, parsed))
}

/// The take in the bytes of a file, unpacked where zstd packed it, with the facts beside it.
fn parse(
    path: &Path,
    bytes: &[u8],
    file_name: &str,
    facts: Option<&[u8]>,
    settings: &Settings,
) -> Result<ReadTake, SessionError> {
    let bytes = unpack(path, bytes)?;
    if inhand_channels::is_mcap(&bytes) {
        let settings = settings.import_settings()?;
        return inhand_import::read_take(&bytes, file_name, &settings).in_file(path);
    }
    let settings = settings.read_settings()?;
    let recording = match inhand_export::looks_like_wide_csv(&bytes) {
        true => inhand_export::read_wide_csv(&bytes, file_name, facts, settings.up_axis)
            .in_file(path)?,
        false => inhand_capture::read(&bytes, file_name, &settings).in_file(path)?,
    };
    Ok(vendor_take(recording))
}

/// A take of which there is nothing but what was measured.
fn vendor_take(mut recording: Recording) -> ReadTake {
    ReadTake {
        annotations: std::mem::take(&mut recording.annotations),
        recording,
        cleaned: None,
        roles: None,
        motion: None,
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

    /// The take of these samples alone.
    pub(crate) fn slice(mut self, samples: Range<usize>) -> Self {
        let [from_s, to_s] = [samples.start, samples.end].map(|k| self.recording.clock.time_s(k));
        self.recording = self.recording.slice(samples);
        if let Some(cleaning) = &mut self.cleaning {
            cleaning.keep(from_s, to_s);
        }
        self.stored_motion = None; // It belongs to the whole take.
        self
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
    let mut paths: Vec<&Path> = Vec::new();
    for take in &session.takes {
        if !paths.contains(&&*take.path) {
            paths.push(&take.path);
        }
    }
    // A recording with several time ranges is read once.
    let takes = inhand_parallel::try_map(&paths, |&path| {
        let whole = read_clean(path, settings)?;
        let entries = session.takes.iter().enumerate();
        let entries: Vec<_> = entries.filter(|(_, entry)| entry.path == path).collect();
        let used =
            |whole: Take, (n, entry)| -> Result<_, SessionError> { Ok((n, part(whole, entry)?)) };
        match entries[..] {
            [only] => Ok(vec![used(whole, only)?]),
            _ => (entries.into_iter())
                .map(|entry| used(whole.clone(), entry))
                .collect(),
        }
    });
    let mut takes: Vec<_> = takes?.into_iter().flatten().collect();
    takes.sort_by_key(|&(n, _)| n);
    let takes: Vec<Take> = takes.into_iter().map(|(_, take)| take).collect();
    for take in &takes {
        take.roles()?;
    }
    check_rates((takes.iter()).map(|take| (take.path.as_path(), take.recording.clock)))?;
    if !settings.allow_shared_takes {
        check_disjoint(session, &takes)?;
    }
    Ok(takes)
}

/// What a session uses of a take.
fn part(mut take: Take, entry: &SessionTake) -> Result<Take, SessionError> {
    take.name.clone_from(&entry.name);
    in_range(take, entry)
}

/// What a session uses of a take.
fn in_range(take: Take, entry: &SessionTake) -> Result<Take, SessionError> {
    Ok(match used(&take, entry)? {
        Some(range) => take.slice(range),
        None => take,
    })
}

/// The samples that a session uses of a take; `None` for all of them.
pub(crate) fn used(take: &Take, entry: &SessionTake) -> Result<Option<Range<usize>>, SessionError> {
    if entry.from_s.is_none() && entry.to_s.is_none() && !entry.is_part() {
        return Ok(None);
    }
    let (clock, len) = (take.recording.clock, take.recording.len());
    let from = entry.from_s.map_or(0, |s| clock.nearest_sample(s));
    let to = entry.to_s.map_or(len, |s| clock.nearest_sample(s).min(len));
    if from >= len {
        return Err(take.error(format!(
            "from_s is {} s, but the take ends after {} s",
            entry.from_s.unwrap_or_default(),
            clock.time_s(len)
        )));
    }
    // Both sides of a split meet at one sample, which is of the second.
    let [from, to] = entry
        .part
        .map(|share| from + ((to - from) as f64 * share).round() as usize);
    Ok(Some(from..to))
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

/// Refuses test takes that share samples with training takes.
fn check_disjoint(session: &Session, takes: &[Take]) -> Result<(), SessionError> {
    let role = |n: usize| session.takes[n].role;
    let thumbs: Vec<_> = takes.iter().map(thumb).collect();
    let alike = takes_alike(&thumbs);
    let alike = alike.iter().map(|alike| (alike.take, alike.other));
    let count = takes.len();
    let pairs = (0..count).flat_map(|test| (0..count).map(move |train| (test, train)));
    let overlap = pairs.filter(|&(test, train)| overlap(&takes[test], &takes[train]));
    let mut shared = alike.chain(overlap).filter(|&(a, b)| role(a) != role(b));
    let Some((a, b)) = shared.next() else {
        return Ok(());
    };
    let (test, train) = if role(a) == Role::Test {
        (a, b)
    } else {
        (b, a)
    };
    Err(takes[test].error(format!(
        "the test take is also the training take {}: give each its own time range (from_s, to_s), or set \
         allow_shared_takes = true to accept results that look better than they are",
        takes[train].path.display()
    )))
}

/// Whether two takes are of one recording, and of times that overlap.
fn overlap(a: &Take, b: &Take) -> bool {
    let span = |take: &Take| [0, take.recording.len()].map(|k| take.recording.clock.unix_nanos(k));
    let ([a_start, a_end], [b_start, b_end]) = (span(a), span(b));
    a_start < b_end && b_start < a_end && same_source(a, b)
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
/// stored, shifted or trimmed since.
pub(crate) fn same_motion(a: &Take, b: &Take) -> bool {
    !takes_alike(&[thumb(a), thumb(b)]).is_empty()
}

fn thumb(take: &Take) -> Vec<ExactPosition> {
    let roles = take.roles.as_ref().ok();
    let marker = roles.and_then(|roles| take.recording.marker(&roles.fingers[Finger::Thumb]));
    exact_positions(marker.map(|marker| &marker.track))
}
