//! Source files of the workspace, with their modules and the imports between them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A source file of a crate.
pub(crate) struct File {
    /// Path below the workspace.
    pub(crate) path: String,
    /// Crate folder, then module path: `["planner", "rows", "reach"]`; a crate's root has the folder alone.
    pub(crate) module: Vec<String>,
    pub(crate) text: String,
}

/// Root of the workspace.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Files of `crates/*/src` that people write: neither generated nor tests.
pub(crate) fn files() -> Vec<File> {
    let mut files = Vec::new();
    let mut folders = vec![root().join("crates")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder of the workspace") {
            let path = entry.expect("an entry of a folder").path();
            let name = path.file_name().and_then(|name| name.to_str());
            let name = name.expect("names are text");
            if path.is_dir() && !matches!(name, "tests" | "benches" | "examples" | "generated") {
                folders.push(path);
            } else if name.ends_with(".rs") && name != "tests.rs" {
                files.push(File::read(&path));
            }
        }
    }
    files.sort_by(|a, b| a.path.cmp(&b.path));
    assert!(files.len() > 300, "only {} source files found", files.len());
    files
}

impl File {
    fn read(path: &Path) -> Self {
        let below = path.strip_prefix(root()).expect("below the workspace");
        let parts: Vec<_> = below
            .iter()
            .map(|part| part.to_str().expect("names are text").to_owned())
            .collect();
        // crates/NAME/src/a/b.rs
        let mut module = vec![parts[1].clone()];
        module.extend(
            parts[3..]
                .iter()
                .map(|part| part.trim_end_matches(".rs").to_owned()),
        );
        if matches!(
            module.last().map(String::as_str),
            Some("mod" | "lib" | "main")
        ) {
            module.pop();
        }
        Self {
            path: parts.join("/"),
            module,
            text: std::fs::read_to_string(path).expect("source is UTF-8 text"),
        }
    }

    /// Lines outside `#[cfg(test)]` modules.
    pub(crate) fn lines(&self) -> Vec<&str> {
        let end = self.text.find("\n#[cfg(test)]\nmod ");
        let inline = end.filter(|&end| {
            self.text[end..]
                .lines()
                .nth(2)
                .is_some_and(|l| l.ends_with('{'))
        });
        self.text[..inline.unwrap_or(self.text.len())]
            .lines()
            .collect()
    }

    /// Lines of code: neither blank nor comments.
    pub(crate) fn lines_of_code(&self) -> usize {
        let code = |line: &&&str| !line.trim().is_empty() && !line.trim_start().starts_with("//");
        self.lines().iter().filter(code).count()
    }

    /// Module paths that `use` items name, whole: `crate::a::B` of the crate `x` is `x::a::B`.
    fn imports(&self) -> Vec<Vec<String>> {
        let mut found = Vec::new();
        let mut rest = self.text.as_str();
        while let Some(start) = rest.find("use ") {
            let begins = rest[..start].rsplit('\n').next().unwrap_or("");
            let item = &rest[start + 4..];
            let end = item.find(';').unwrap_or(item.len());
            let visible = begins.trim_start();
            if visible.is_empty() || visible.starts_with("pub") {
                let text: String = item[..end].split_whitespace().collect();
                expand(&text, &mut Vec::new(), &mut found);
            }
            rest = &item[end..];
        }
        found
            .into_iter()
            .filter_map(|path| self.whole(&path))
            .collect()
    }

    /// A path of a `use` item from the crate's root on; `None` for those of other crates.
    fn whole(&self, path: &[String]) -> Option<Vec<String>> {
        let mut base = match path.first()?.as_str() {
            "crate" => self.module[..1].to_vec(),
            "self" | "super" => self.module.clone(),
            _ => return None,
        };
        for part in path {
            match part.as_str() {
                "crate" | "self" => {}
                "super" => drop(base.pop()),
                name => base.push(name.to_owned()),
            }
        }
        Some(base)
    }
}

/// The paths of a tree such as `a::{b,c::D}`.
fn expand(text: &str, before: &mut Vec<String>, found: &mut Vec<Vec<String>>) {
    let (mut depth, mut start) = (0, 0);
    let mut branches = Vec::new();
    for (at, letter) in text.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                branches.push(&text[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    branches.push(&text[start..]);
    for branch in branches.into_iter().filter(|branch| !branch.is_empty()) {
        let length = before.len();
        let mut rest = branch;
        while let Some((name, after)) = rest
            .split_once("::")
            .filter(|(name, _)| !name.contains('{'))
        {
            before.push(name.to_owned());
            rest = after;
        }
        match rest
            .strip_prefix('{')
            .and_then(|inner| inner.strip_suffix('}'))
        {
            Some(inner) => expand(inner, before, found),
            None => {
                let mut path = before.clone();
                path.push(rest.split("as").next().unwrap_or(rest).to_owned());
                found.push(path);
            }
        }
        before.truncate(length);
    }
}

/// For each file the files of its crate that it imports from, leaving out modules above and below it.
pub(crate) fn imports(files: &[File]) -> BTreeMap<&str, BTreeSet<&str>> {
    let places: BTreeMap<_, _> = files.iter().map(|file| (&file.module[..], file)).collect();
    let kin = |a: &[String], b: &[String]| a.starts_with(b) || b.starts_with(a);
    files
        .iter()
        .map(|file| {
            let used = file.imports().into_iter().filter_map(|path| {
                let prefixes = (1..=path.len()).rev().map(|n| &path[..n]);
                let place = prefixes.filter_map(|prefix| places.get(prefix)).next()?;
                (!kin(&place.module, &file.module)).then_some(place.path.as_str())
            });
            (file.path.as_str(), used.collect())
        })
        .collect()
}

/// Groups of files that import each other, directly or through others.
pub(crate) fn circles<'a>(
    imports: &BTreeMap<&'a str, BTreeSet<&'a str>>,
) -> Vec<BTreeSet<&'a str>> {
    let reach: BTreeMap<&str, BTreeSet<&str>> = imports
        .keys()
        .map(|&from| {
            let mut seen = BTreeSet::new();
            let mut open: Vec<&str> = imports[from].iter().copied().collect();
            while let Some(file) = open.pop() {
                if seen.insert(file) {
                    open.extend(&imports[file]);
                }
            }
            (from, seen)
        })
        .collect();
    let mut circles: Vec<BTreeSet<&str>> = Vec::new();
    for (&file, reached) in &reach {
        if reached.contains(file) && !circles.iter().any(|circle| circle.contains(file)) {
            circles.push(
                reached
                    .iter()
                    .copied()
                    .filter(|other| reach[other].contains(file))
                    .collect(),
            );
        }
    }
    circles
}
