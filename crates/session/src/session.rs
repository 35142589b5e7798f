//! A session on disk: which takes there are, and what each is for.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::error::SessionError;
use crate::files::name_of;
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
}

/// Folder and settings file of what a person named as a session: a folder, or a settings file.
pub fn locate(path: &Path) -> Result<(PathBuf, Option<PathBuf>), SessionError> {
    let metadata = std::fs::metadata(path).map_err(SessionError::io("read session", path))?;
    if metadata.is_dir() {
        let file = path.join(SETTINGS_FILE);
        return Ok((path.to_owned(), file.is_file().then_some(file)));
    }
    if path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("toml"))
    {
        return Ok((folder_of(path).to_owned(), Some(path.to_owned())));
    }
    Err(SessionError::session(
        path,
        "expected a folder with train/ and test/ takes, or an inhand.toml",
    ))
}

/// Lists the takes of a session folder.
///
/// # Errors
///
/// [`SessionError::Data`] without training or test takes, or where two takes share a name.
pub fn list_takes(folder: &Path, settings: &Settings) -> Result<Session, SessionError> {
    let mut takes = if settings.takes.is_empty() {
        from_folders(folder)?
    } else {
        from_settings(folder, settings)?
    };
    takes.sort_by(|a, b| {
        (a.role, &a.path)
            .cmp(&(b.role, &b.path))
            .then(by_start(a, b))
    });
    for role in [Role::Train, Role::Test] {
        if !takes.iter().any(|take| take.role == role) {
            let message = format!(
                "no {role} take: expected .csv, .tsv, .trc, .c3d or .mcap files in {role}/, or an \
                 {SETTINGS_FILE} that lists takes with their roles",
                role = role.name()
            );
            return Err(SessionError::session(folder, message));
        }
    }
    name_apart(folder, &mut takes)?;
    let name = settings.name.clone().unwrap_or_else(|| folder_name(folder));
    Ok(Session {
        name,
        folder: folder.to_owned(),
        takes,
    })
}

fn by_start(a: &SessionTake, b: &SessionTake) -> std::cmp::Ordering {
    a.from_s.unwrap_or(0.0).total_cmp(&b.from_s.unwrap_or(0.0))
}

fn from_folders(folder: &Path) -> Result<Vec<SessionTake>, SessionError> {
    let mut takes = Vec::new();
    for role in [Role::Train, Role::Test] {
        let sub = folder.join(role.name());
        if !sub.is_dir() {
            continue;
        }
        for entry in std::fs::read_dir(&sub).map_err(SessionError::io("read", &sub))? {
            let path = entry.map_err(SessionError::io("read", &sub))?.path();
            if path.is_file() && is_take(&path) {
                takes.push(SessionTake {
                    name: stem(&path),
                    path,
                    role,
                    from_s: None,
                    to_s: None,
                });
            }
        }
    }
    Ok(takes)
}

fn from_settings(folder: &Path, settings: &Settings) -> Result<Vec<SessionTake>, SessionError> {
    let mut takes = Vec::new();
    for entry in &settings.takes {
        let path = folder.join(&entry.path);
        if !path.is_file() {
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
        takes.push(SessionTake {
            name: stem(&path),
            path,
            role: entry.role,
            from_s,
            to_s,
        });
    }
    Ok(takes)
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

/// Whether a file looks like a take by its extension.
pub fn is_take(path: &Path) -> bool {
    let name = name_of(path);
    let is_mcap = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("mcap"));
    !name.starts_with('.') && (is_mcap || inhand_capture::looks_like_capture_file(&name))
}

/// File name without folders and extension.
pub(crate) fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(
        || "take".to_owned(),
        |stem| stem.to_string_lossy().into_owned(),
    )
}

fn folder_name(folder: &Path) -> String {
    let absolute = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    absolute.components().next_back().map_or_else(
        || "session".to_owned(),
        |c| c.as_os_str().to_string_lossy().into_owned(),
    )
}
