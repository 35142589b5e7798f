//! Files made by the mcap crate's writer, compared by its reader.

mod merge;
mod recover;
mod select;
mod support;
