//! The frames of a row-typed file, each with the rows of its bodies.

use std::collections::{BTreeMap, BTreeSet};

use super::line::{BodyLine, Definition, FrameLine, Lines, Row, SeenMarker};
use crate::error::CaptureError;

/// What stands above the frames.
#[derive(Default)]
pub(super) struct Prelude<'a> {
    pub(super) facts: BTreeMap<String, String>,
    pub(super) definitions: Vec<Definition<'a>>,
}

/// Everything about one frame.
pub(super) struct Instant<'a> {
    /// Line of the file.
    pub(super) line: usize,
    pub(super) frame: FrameLine<'a>,
    /// More about its bodies.
    pub(super) bodies: Vec<BodyLine<'a>>,
}

/// The frames of a file, in its order.
pub(super) struct Instants<'a> {
    lines: Lines<'a>,
    /// The frame whose rows of bodies may still come.
    waiting: Option<(usize, FrameLine<'a>)>,
}

impl<'a> Instants<'a> {
    /// Reads up to the first frame.
    pub(super) fn open(
        bytes: &'a [u8],
        file: &'a str,
    ) -> Result<(Prelude<'a>, Self), CaptureError> {
        let mut prelude = Prelude::default();
        let mut lines = Lines::new(bytes, file);
        let mut waiting = None;
        while let Some((line, row)) = lines.next_row()? {
            match row {
                Row::LeftHanded => {
                    return Err(CaptureError::UnsupportedFormat {
                        file: file.to_owned(),
                        found: format!("a take in left-handed coordinates (line {line})"),
                        hint: "export it right-handed",
                    });
                }
                Row::Info { key, value } => {
                    let fact = prelude.facts.entry(key.to_owned());
                    fact.or_insert_with(|| value.to_owned());
                }
                Row::Definition(body) => prelude.definitions.push(body),
                Row::Frame(frame) => {
                    waiting = Some((line, frame));
                    break;
                }
                Row::Body(_) | Row::Nothing => {}
            }
        }
        Ok((prelude, Self { lines, waiting }))
    }

    pub(super) fn next(&mut self) -> Result<Option<Instant<'a>>, CaptureError> {
        let Some((line, frame)) = self.waiting.take() else {
            return Ok(None);
        };
        let mut bodies = Vec::new();
        while let Some((line, row)) = self.lines.next_row()? {
            match row {
                Row::Frame(frame) => {
                    self.waiting = Some((line, frame));
                    break;
                }
                // A row that names another frame is out of place.
                Row::Body(body) if body.frame == frame.number => bodies.push(body),
                _ => {}
            }
        }
        Ok(Some(Instant {
            line,
            frame,
            bodies,
        }))
    }
}

impl<'a> Instant<'a> {
    /// The markers of the frame that no row of a body has, each with what identifies it: ID and
    /// name, once in a frame; nothing for the others.
    pub(super) fn other_markers(
        &self,
    ) -> impl Iterator<Item = (&SeenMarker<'a>, Option<(&'a str, &'a str)>)> {
        let bits = |position: &[f64; 3]| position.map(f64::to_bits);
        let of_bodies: BTreeSet<_> = (self.bodies.iter())
            .flat_map(|body| body.seen.iter().map(bits))
            .collect();
        let mut met = BTreeSet::new();
        let others = self.frame.markers.iter();
        let others = others.filter(move |marker| !of_bodies.contains(&bits(&marker.position)));
        others.map(move |marker| {
            let identity = (marker.id, marker.name);
            // Version 1 gives every marker the ID 0 and no name.
            let told = !marker.name.is_empty() || !matches!(marker.id, "" | "0");
            (marker, (told && met.insert(identity)).then_some(identity))
        })
    }
}
