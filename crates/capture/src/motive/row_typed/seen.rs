//! Everything that the frames of a row-typed file place.

use std::collections::{BTreeMap, BTreeSet};

use inhand_model::Finding;

use super::line::{BodyLine, Definition, FrameLine, SeenMarker, TypedLines, TypedRow};
use crate::error::CaptureError;

/// Values of a thing at the frames that have it.
#[derive(Default)]
pub(super) struct Samples {
    /// Rows of frames, rising.
    pub(super) rows: Vec<usize>,
    /// As many values for each of them.
    pub(super) values: Vec<f64>,
}

impl Samples {
    fn push(&mut self, row: usize, values: &[f64]) {
        self.rows.push(row);
        self.values.extend_from_slice(values);
    }
}

/// A body as defined above the frames.
pub(super) struct SeenBody {
    pub(super) name: String,
    pub(super) id: String,
    /// Position and quaternion.
    pub(super) pose: Samples,
    /// Number of its markers.
    markers: usize,
    /// Position of each by the fit with its quality, and as seen.
    pub(super) parts: Vec<[Samples; 2]>,
    /// Whether rows of its own place its markers.
    has_rows: bool,
}

/// A marker that is no body's.
pub(super) struct OtherMarker {
    pub(super) name: String,
    pub(super) id: String,
    pub(super) samples: Samples,
}

/// Bodies and markers of a file.
#[derive(Default)]
pub(super) struct Seen {
    pub(super) facts: BTreeMap<String, String>,
    /// Line, number and time of each frame.
    pub(super) frames: Vec<(usize, i64, f64)>,
    pub(super) bodies: Vec<SeenBody>,
    by_id: BTreeMap<String, usize>,
    /// Markers that are no body's, in the order in which they appear.
    pub(super) others: Vec<OtherMarker>,
    by_identity: BTreeMap<(String, String), usize>,
    /// Markers that nothing identifies, by their number in a row.
    pub(super) nameless: Vec<Samples>,
    /// Markers and bodies of all rows together.
    pub(super) count: u64,
    pub(super) findings: Vec<Finding>,
    /// IDs of bodies that are placed without being defined.
    undefined: Vec<String>,
}

impl Seen {
    pub(super) fn read(bytes: &[u8], file: &str) -> Result<Self, CaptureError> {
        let mut seen = Self::default();
        let mut lines = TypedLines::new(bytes, file);
        // The frame whose rows of bodies may still come.
        let mut frame: Option<(usize, FrameLine<'_>)> = None;
        let mut bodies: Vec<BodyLine<'_>> = Vec::new();
        while let Some((line, row)) = lines.next_row()? {
            match (row, &frame) {
                (TypedRow::LeftHanded, None) => {
                    let found = format_args!("a take in left-handed coordinates (line {line})");
                    return Err(CaptureError::unsupported(
                        file,
                        found,
                        "export it right-handed",
                    ));
                }
                (TypedRow::Info { key, value }, None) => {
                    let fact = seen.facts.entry(key.to_owned());
                    fact.or_insert_with(|| value.to_owned());
                }
                (TypedRow::Definition(body), None) => seen.define(&body),
                (TypedRow::Frame(next), _) => {
                    if let Some((line, frame)) = frame.replace((line, next)) {
                        seen.place(line, &frame, &std::mem::take(&mut bodies));
                    }
                }
                // A row that names another frame is out of place.
                (TypedRow::Body(body), Some((_, frame))) if body.frame == frame.number => {
                    bodies.push(body);
                }
                _ => {}
            }
        }
        if let Some((line, frame)) = frame {
            seen.place(line, &frame, &bodies);
        }
        seen.add_findings();
        Ok(seen)
    }

    fn define(&mut self, body: &Definition<'_>) {
        let fresh = self.bodies.len();
        if *self.by_id.entry(body.id.to_owned()).or_insert(fresh) != fresh {
            self.findings.push(Finding::warning(
                format!("body \"{}\"", body.name),
                format!("its ID {} is that of a body before it: not read", body.id),
            ));
            return;
        }
        self.bodies.push(SeenBody {
            name: body.name.to_owned(),
            id: body.id.to_owned(),
            pose: Samples::default(),
            markers: body.markers,
            parts: Vec::new(),
            has_rows: false,
        });
    }

    /// Takes note of what a frame and its rows of bodies place.
    fn place(&mut self, line: usize, frame: &FrameLine<'_>, bodies: &[BodyLine<'_>]) {
        let row = self.frames.len();
        self.frames.push((line, frame.number, frame.time_s));
        self.count += (frame.bodies.len() + frame.markers.len()) as u64;
        for &(id, pose) in &frame.bodies {
            match self.by_id.get(id) {
                Some(&known) => self.bodies[known].pose.push(row, &pose),
                None if self.undefined.iter().any(|other| other == id) => {}
                None => self.undefined.push(id.to_owned()),
            }
        }
        for line in bodies {
            self.count += line.seen.len() as u64;
            let Some(&known) = self.by_id.get(line.id) else {
                continue;
            };
            let body = &mut self.bodies[known];
            body.parts.resize_with(body.markers, Default::default);
            for (n, [fitted, seen]) in body.parts.iter_mut().enumerate().take(line.seen.len()) {
                // A body that is not tracked repeats where its markers were last.
                if line.tracked {
                    let [x, y, z] = line.fitted[n];
                    fitted.push(row, &[x, y, z, line.quality[n]]);
                }
                seen.push(row, &line.seen[n]);
            }
            body.has_rows = true;
        }
        let mut nameless = 0;
        for (marker, identity) in other_markers(frame, bodies) {
            let samples = if let Some((id, name)) = identity {
                let fresh = self.others.len();
                let identity = (id.to_owned(), name.to_owned());
                let other = *self.by_identity.entry(identity).or_insert(fresh);
                if other == fresh {
                    self.others.push(OtherMarker {
                        name: name.to_owned(),
                        id: id.to_owned(),
                        samples: Samples::default(),
                    });
                }
                &mut self.others[other].samples
            } else {
                if nameless == self.nameless.len() {
                    self.nameless.push(Samples::default());
                }
                nameless += 1;
                &mut self.nameless[nameless - 1]
            };
            samples.push(row, &marker.position);
        }
    }

    fn add_findings(&mut self) {
        let findings = &mut self.findings;
        if let Some(first) = self.undefined.first() {
            let count = self.undefined.len();
            findings.push(Finding::warning(
                format!("body {first}"),
                format!("{count} bodies are placed in frames and defined nowhere: not read"),
            ));
        }
        if let Some(first) = self.nameless.first() {
            let message = format!(
                "in {} frames there are up to {} markers that nothing identifies: they are \
                 numbered in the order of their row, so that one number may stand for several \
                 markers",
                first.rows.len(),
                self.nameless.len()
            );
            findings.push(Finding::warning("markers", message));
        }
        if self.bodies.iter().any(|body| body.has_rows) {
            findings.push(Finding::info(
                "mean errors",
                "not read: the file calls them millimetres, but they are as large as metres would \
                 be",
            ));
        }
    }
}

/// The markers of a frame that no row of a body has, each with what identifies it: ID and name, once
/// in a frame; nothing for the others.
fn other_markers<'a, 'b>(
    frame: &'b FrameLine<'a>,
    bodies: &[BodyLine<'_>],
) -> impl Iterator<Item = (&'b SeenMarker<'a>, Option<(&'a str, &'a str)>)> {
    let bits = |position: &[f64; 3]| position.map(f64::to_bits);
    let of_bodies = bodies.iter().flat_map(|body| body.seen.iter().map(bits));
    let of_bodies: BTreeSet<_> = of_bodies.collect();
    let mut met = BTreeSet::new();
    let others = frame.markers.iter();
    let others = others.filter(move |marker| !of_bodies.contains(&bits(&marker.position)));
    others.map(move |marker| {
        let identity = (marker.id, marker.name);
        // Version 1 gives every marker the ID 0 and no name.
        let is_identified = !marker.name.is_empty() || !matches!(marker.id, "" | "0");
        (
            marker,
            (is_identified && met.insert(identity)).then_some(identity),
        )
    })
}
