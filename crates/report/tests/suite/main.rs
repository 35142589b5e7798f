//! Reports as their readers get them.

/// What goes wrong, and what is missing.
mod answers;
/// The page: numbers shown, escaping, nothing loaded.
mod intervals;
mod page;
/// Plans that failed, corridors, the planned object, the deviation and the choice of method.
mod planned;
mod sample;
/// `evaluation.json` against its schema, and back.
mod schema;
/// The terminal table and the verdict.
mod text;
