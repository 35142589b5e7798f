//! A session on disk: which takes there are, and what each is for.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::error::SessionError;
use crate::files::{name_of, take_name};
use crate::output::folder_of;
use crate::settings::{Role, Settings};

/// Settings file of a session folder.
pub const SETTINGS_FILE: &str = "inhand.toml";

/// A session: its folder, settings and takes.
#[derive(Clone, Debug)]
pub struct Session {
    /// Name for reports.
    pub name: String,
    /// Folder that the takes' paths are relative to.
    pub folder: PathBuf,
    /// Takes in a fixed order: training first, each role by path.
    pub takes: Vec<SessionTake>,
    /// What is in `train/` and `test/` and is no take, relative to the folder.
    pub skipped: Vec<PathBuf>,
}

/// A take of a session.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionTake {
    /// Its file.
    pub path: PathBuf,
    /// What it is for.
    pub role: Role,
    /// Name of its output, unique in the session.
    pub name: String,
    /// First instant used, seconds after the first sample.
    pub from_s: Option<f64>,
    /// End of what is used, seconds after the first sample.
    pub to_s: Option<f64>,
    /// Which part of that is used, from 0 to 1: all of it, unless the take serves both roles.
    pub part: [f64; 2],
}

/// A session as a person named it.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionPlace {
    /// Folder that takes' paths are relative to.
    pub folder: PathBuf,
    /// Settings file, where there is one.
    pub settings: Option<PathBuf>,
    /// The take, where it is one recording: a file, or a ROS 2 bag.
    pub take: Option<PathBuf>,
}

/// Finds out whether a path is a session's folder, its settings file or one take.
///
/// # Errors
///
/// [`SessionError::Io`], and [`SessionError::Data`] for another file.
pub fn locate(path: &Path) -> Result<SessionPlace, SessionError> {
    let metadata = std::fs::metadata(path).map_err(SessionError::io("read session", path))?;
    let in_folder = |folder: &Path, take| {
        let settings = Some(folder.join(SETTINGS_FILE));
        let (folder, settings) = (folder.to_owned(), settings.filter(|file| file.is_file()));
        SessionPlace {
            folder,
            settings,
            take,
        }
    };
    let ending = path.extension();
    if is_take(path) {
        let name = path.file_name().map(PathBuf::from);
        return Ok(in_folder(folder_of(path), name));
    }
    if metadata.is_dir() {
        return Ok(in_folder(path, None));
    }
    if ending.is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
        let settings = Some(path.to_owned());
        return Ok(SessionPlace {
            settings,
            ..in_folder(folder_of(path), None)
        });
    }
    Err(SessionError::session(
        path,
        "expected a take, a folder with train/ and test/ takes, or an inhand.toml",
    ))
}

/// Lists the takes of a session folder.
///
/// # Errors
///
/// [`SessionError::Data`] without training or test takes, or where two takes share a name.
pub fn list_takes(folder: &Path, settings: &Settings) -> Result<Session, SessionError> {
    let (mut takes, skipped) = match settings.takes.is_empty() {
        true => from_folders(folder)?,
        false => (from_settings(folder, settings)?, Vec::new()),
    };
    takes.sort_by(|a, b| {
        (a.role, &a.path)
            .cmp(&(b.role, &b.path))
            .then(by_start(a, b))
    });
    for role in [Role::Train, Role::Test] {
        if !takes.iter().any(|take| take.role == role) {
            return Err(SessionError::session(folder, without_takes(folder, role)));
        }
    }
    name_apart(folder, &mut takes)?;
    let name = settings.name.clone().unwrap_or_else(|| folder_name(folder));
    Ok(Session {
        name,
        folder: folder.to_owned(),
        takes,
        skipped,
    })
}

/// Why a session has no take of a role, and what to do.
fn without_takes(folder: &Path, role: Role) -> String {
    let mut message = format!(
        "no {} take: expected .csv, .tsv, .trc, .c3d or .mcap files or ROS 2 bags in {}/, or an {SETTINGS_FILE} \
         that lists takes with their roles",
        role.name(),
        role.name()
    );
    let inside = ["", "train", "test"].iter().find_map(|sub| {
        let mut entries = std::fs::read_dir(folder.join(sub))
            .ok()?
            .flatten()
            .map(|entry| entry.path());
        entries.find(|path| is_take(path))
    });
    if let Some(take) = inside {
        message += &format!(
            "; to split one recording by time, name it in place of the folder: {}",
            take.display()
        );
    }
    message
}

fn by_start(a: &SessionTake, b: &SessionTake) -> std::cmp::Ordering {
    a.from_s.unwrap_or(0.0).total_cmp(&b.from_s.unwrap_or(0.0))
}

/// Takes in `train/` and `test/`, and what else is there.
fn from_folders(folder: &Path) -> Result<(Vec<SessionTake>, Vec<PathBuf>), SessionError> {
    let (mut takes, mut skipped) = (Vec::new(), Vec::new());
    for role in [Role::Train, Role::Test] {
        let sub = folder.join(role.name());
        if !sub.is_dir() {
            continue;
        }
        for entry in std::fs::read_dir(&sub).map_err(SessionError::io("read", &sub))? {
            let path = entry.map_err(SessionError::io("read", &sub))?.path();
            if is_take(&path) {
                takes.push(SessionTake::new(path, role));
            } else if !name_of(&path).starts_with('.') {
                skipped.push(path.strip_prefix(folder).unwrap_or(&path).to_owned());
            }
        }
    }
    skipped.sort();
    Ok((takes, skipped))
}

fn from_settings(folder: &Path, settings: &Settings) -> Result<Vec<SessionTake>, SessionError> {
    let mut takes = Vec::new();
    for entry in &settings.takes {
        let path = folder.join(&entry.path);
        if !path.exists() {
            let message = format!(
                "take {} is listed in the settings but not there",
                entry.path.display()
            );
            return Err(SessionError::session(folder, message));
        }
        let (from_s, to_s) = (entry.from_s, entry.to_s);
        let wrong = |what: String| {
            let message = format!("take {}: {what}", entry.path.display());
            Err(SessionError::session(folder, message))
        };
        for (key, value) in [("from_s", from_s), ("to_s", to_s)] {
            if value.is_some_and(|v| !v.is_finite() || v < 0.0) {
                return wrong(format!("{key} must be 0 or more"));
            }
        }
        if let (Some(from), Some(to)) = (from_s, to_s)
            && from >= to
        {
            return wrong(format!("from_s is {from}, which is not before to_s, {to}"));
        }
        let split = 1.0 - settings.segments.test_share;
        let parts = match entry.role {
            Some(role) => vec![(role, [0.0, 1.0])],
            None => vec![(Role::Train, [0.0, split]), (Role::Test, [split, 1.0])],
        };
        takes.extend(parts.into_iter().map(|(role, part)| SessionTake {
            from_s,
            to_s,
            part,
            ..SessionTake::new(path.clone(), role)
        }));
    }
    Ok(takes)
}

impl SessionTake {
    /// A whole take.
    fn new(path: PathBuf, role: Role) -> Self {
        Self {
            name: take_name(&path),
            path,
            role,
            from_s: None,
            to_s: None,
            part: [0.0, 1.0],
        }
    }

    /// Whether the rest of its time range serves the other role.
    pub(crate) fn is_part(&self) -> bool {
        self.part != [0.0, 1.0]
    }
}

/// Gives takes of the same file stem names that tell them apart by role; refuses what stays equal.
fn name_apart(folder: &Path, takes: &mut [SessionTake]) -> Result<(), SessionError> {
    let mut count = BTreeMap::<String, usize>::new();
    for take in takes.iter() {
        *count.entry(take.name.clone()).or_default() += 1;
    }
    for take in takes.iter_mut().filter(|take| count[&take.name] > 1) {
        take.name = format!("{}.{}", take.name, take.role.name());
    }
    // Ranges of one recording for one role are counted: they follow each other, by their starts.
    for n in (1..takes.len()).rev() {
        let same =
            |other: &&SessionTake| (&other.path, other.role) == (&takes[n].path, takes[n].role);
        let earlier = takes[..n].iter().filter(same).count();
        if earlier > 0 {
            takes[n].name += &format!(".{}", earlier + 1);
        }
    }
    if let Some(take) = takes
        .iter()
        .find(|take| take.name.eq_ignore_ascii_case("dictionary"))
    {
        let message = format!(
            "the take {} would be written as dictionary.mcap, the name of the dictionary: rename it",
            take.path.display()
        );
        return Err(SessionError::session(folder, message));
    }
    let mut seen = BTreeMap::<&str, &SessionTake>::new();
    for take in takes.iter() {
        if let Some(other) = seen.insert(&take.name, take) {
            let message = format!(
                "two {} takes would both be written as {}.mcap: {} and {}; rename one, or remove \
                 one where both hold the same motion",
                take.role.name(),
                take.name,
                other.path.display(),
                take.path.display()
            );
            return Err(SessionError::session(folder, message));
        }
    }
    Ok(())
}

/// Whether a file looks like a take by its extension, packed or not, or a folder is a ROS 2 bag. Bags of a kind that
/// is not read are takes too: reading them says why.
pub fn is_take(path: &Path) -> bool {
    let name = name_of(path);
    let file = inhand_import::unpacked_name(&name);
    let ending = Path::new(file).extension().unwrap_or_default();
    let is_bag = ["mcap", "db3"]
        .iter()
        .any(|known| ending.eq_ignore_ascii_case(known));
    let is_file = is_bag || inhand_capture::looks_like_capture_file(file);
    match path.is_dir() {
        true => path.join(inhand_import::BAG_FACTS).is_file(),
        false => !name.starts_with('.') && is_file,
    }
}

fn folder_name(folder: &Path) -> String {
    let absolute = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    absolute.components().next_back().map_or_else(
        || "session".to_owned(),
        |c| c.as_os_str().to_string_lossy().into_owned(),
    )
}
