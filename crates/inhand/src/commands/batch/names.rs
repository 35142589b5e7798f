//! Folder names for the results of sessions.

use std::path::{Path, PathBuf};

/// A name for each session: its folder's, with as many folders above it as it takes to tell all of them apart.
pub(super) fn unique(sessions: &[PathBuf]) -> Result<Vec<String>, String> {
    let parts = sessions
        .iter()
        .map(|session| components(session))
        .collect::<Vec<_>>();
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
        let name = |parts: &Vec<String>| parts[parts.len().saturating_sub(depth)..].join("_");
        parts.iter().map(name).collect()
    };
    let are_apart = |names: &[String]| {
        let mut sorted: Vec<String> = names.iter().map(|name| name.to_lowercase()).collect();
        sorted.sort_unstable();
        sorted.windows(2).all(|pair| pair[0] != pair[1])
    };
    (1..=longest)
        .map(named)
        .find(|names| are_apart(names))
        .ok_or_else(|| "sessions cannot be told apart by their folders' names".to_owned())
}

/// Names of the folders down to a session. A settings file of a name of its own names the session, since a folder may
/// hold several.
fn components(session: &Path) -> Vec<String> {
    let full = session
        .canonicalize()
        .unwrap_or_else(|_| session.to_owned());
    let is_plain = full
        .file_name()
        .is_some_and(|name| name == inhand_pipeline::SETTINGS_FILE);
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

    fn names(sessions: &[&str]) -> Result<Vec<String>, String> {
        unique(&sessions.iter().map(PathBuf::from).collect::<Vec<_>>())
    }

    #[test]
    fn folders_above_are_added_only_where_needed() {
        assert_eq!(names(&["/x/a", "/x/b"]).unwrap(), ["a", "b"]);
        assert_eq!(
            names(&["/x/p1/cube", "/x/p2/cube"]).unwrap(),
            ["p1_cube", "p2_cube"]
        );
        // Not every file system tells upper and lower case apart.
        assert_eq!(
            names(&["/x/p1/cube", "/x/p2/Cube"]).unwrap(),
            ["p1_cube", "p2_Cube"]
        );
        assert!(
            names(&["/x/a", "/x/a"])
                .unwrap_err()
                .contains("same session")
        );
    }
}
