//! Rules of the source: sizes, first lines, circles of imports.

use crate::source::{circles, files, imports};

/// Most lines of code of a module.
const MODULE_LINES: usize = 500;

/// Most lines of a function, from its first to its closing brace.
const FUNCTION_LINES: usize = 80;

/// Most lines of code of a crate.
const CRATE_LINES: usize = 9_000;

/// Most crates.
const CRATES: usize = 22;

#[test]
fn crates_and_modules_have_a_size_that_can_be_read() {
    let files = files();
    let mut crates = std::collections::BTreeMap::<&str, usize>::new();
    let mut long = Vec::new();
    for file in &files {
        let lines = file.lines_of_code();
        *crates.entry(&file.module[0]).or_default() += lines;
        if lines > MODULE_LINES {
            long.push((&file.path, lines));
        }
    }
    assert!(
        long.is_empty(),
        "modules of more than {MODULE_LINES} lines of code: {long:?}"
    );
    let large: Vec<_> = crates
        .iter()
        .filter(|(_, lines)| **lines > CRATE_LINES)
        .collect();
    assert!(
        large.is_empty(),
        "crates of more than {CRATE_LINES} lines of code: {large:?}"
    );
    assert!(crates.len() <= CRATES, "{} crates", crates.len());
}

#[test]
fn functions_fit_on_a_page() {
    let mut long = Vec::new();
    for file in files() {
        let lines = file.lines();
        for (at, line) in lines.iter().enumerate() {
            let Some(name) = function(line) else { continue };
            let indent = &line[..line.len() - line.trim_start().len()];
            let end = format!("{indent}}}");
            let length = lines[at..].iter().position(|line| *line == end);
            if let Some(length) =
                length.filter(|length| length + 1 > FUNCTION_LINES && line.ends_with(['{', '(']))
            {
                long.push(format!("{}: {name}, {} lines", file.path, length + 1));
            }
        }
    }
    assert!(
        long.is_empty(),
        "functions of more than {FUNCTION_LINES} lines: {long:#?}"
    );
}

/// Name of the function that begins on this line.
fn function(line: &str) -> Option<&str> {
    let (before, after) = line.trim_start().split_once("fn ")?;
    let modifier = |word: &str| {
        word.starts_with("pub") || matches!(word, "const" | "unsafe" | "in" | "crate)")
    };
    let name = after.split(['(', '<']).next()?;
    (before.split_whitespace().all(modifier) && !name.is_empty()).then_some(name)
}

#[test]
fn files_open_with_a_noun_phrase_or_a_verb() {
    let clauses = [
        "What ", "How ", "Where ", "When ", "Who ", "Why ", "Which ", "Whether ",
    ];
    for file in files() {
        let first = file
            .text
            .lines()
            .next()
            .unwrap_or("")
            .trim_start_matches("//! ");
        assert!(
            !clauses.iter().any(|clause| first.starts_with(clause)),
            "{} opens with a clause: {first}",
            file.path
        );
    }
}

#[test]
fn files_do_not_import_each_other_in_circles() {
    let files = files();
    let found = circles(&imports(&files));
    assert!(
        found.is_empty(),
        "{} groups of files that import each other: {found:#?}",
        found.len()
    );
}
