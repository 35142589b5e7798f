//! Reports as their readers get them.

/// Errors, and missing input.
mod answers;
/// Figures: on the page and in files, with their numbers.
mod figures;
/// The first screen, and how much of the page is open.
mod first_screen;
/// Figures of what a run shows beside its numbers.
mod illustrated;
/// The page: numbers shown, escaping, nothing loaded.
mod intervals;
/// The summary for pull requests.
mod markdown;
mod page;
/// Plans that failed, corridors, the planned object, the deviation and the choice of method.
mod planned;
mod sample;
mod sample_rows;
/// `evaluation.json` against its schema, and back.
mod schema;
/// The terminal table and the verdict.
mod text;
/// What takes are and give, line by line.
mod took;
