//! Folder names for the results of sessions.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Names that the batch needs for files of its own.
const RESERVED: [&str; 2] = ["batch.json", "summary.html"];

/// A session's path from the root, by which it is known from call to call.
pub(super) fn full(session: &Path) -> String {
    let full = session
        .canonicalize()
        .unwrap_or_else(|_| session.to_owned());
    full.display().to_string()
}

/// A name for each session: the one it has in `known` (paths from the root with names), else its folder's, with as
/// many folders above it as it takes to tell all of them apart.
pub(super) fn unique(
    sessions: &[PathBuf],
    known: &BTreeMap<String, String>,
) -> Result<Vec<String>, String> {
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
    let full = session
        .canonicalize()
        .unwrap_or_else(|_| session.to_owned());
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
