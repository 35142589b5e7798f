//! Markers and bodies of a row-typed file.

use std::collections::BTreeMap;

use inhand_model::Finding;

use super::instants::{Instant, Prelude};

/// Bodies and markers of a file.
#[derive(Default)]
pub(super) struct Entities {
    pub(super) bodies: Vec<BodyFacts>,
    by_id: BTreeMap<String, usize>,
    /// Markers that are no body's, by what identifies them, in the order in which they turn up.
    pub(super) others: Vec<Other>,
    by_identity: BTreeMap<(String, String), usize>,
    /// How often there were more than so many markers that nothing identifies.
    pub(super) nameless: Vec<u64>,
    /// Rows of frames.
    pub(super) frames: u64,
    /// Markers and bodies of all rows together.
    pub(super) seen: u64,
    findings: Vec<Finding>,
    /// IDs of bodies that are placed without being defined.
    undefined: Vec<String>,
}

/// A body as defined above the frames.
pub(super) struct BodyFacts {
    pub(super) name: String,
    pub(super) id: String,
    /// Markers that it has.
    pub(super) markers: usize,
    /// Whether rows of its own place its markers.
    pub(super) has_rows: bool,
}

/// A marker that is no body's.
pub(super) struct Other {
    pub(super) name: String,
    pub(super) id: String,
    /// Frames that have it.
    pub(super) seen: u64,
}

impl Entities {
    pub(super) fn new(prelude: &Prelude<'_>) -> Self {
        let mut entities = Self::default();
        for body in &prelude.definitions {
            if entities.body(body.id).is_some() {
                entities.findings.push(Finding::warning(
                    format!("body \"{}\"", body.name),
                    format!("its ID {} is that of a body before it: not read", body.id),
                ));
                continue;
            }
            (entities.by_id).insert(body.id.to_owned(), entities.bodies.len());
            entities.bodies.push(BodyFacts {
                name: body.name.to_owned(),
                id: body.id.to_owned(),
                markers: body.markers,
                has_rows: false,
            });
        }
        entities
    }

    /// Takes note of what a frame has.
    pub(super) fn see(&mut self, instant: &Instant<'_>) {
        self.frames += 1;
        self.seen += (instant.frame.bodies.len() + instant.frame.markers.len()) as u64;
        for body in &instant.frame.bodies {
            if self.body(body.id).is_none() && !self.undefined.iter().any(|id| id == body.id) {
                self.undefined.push(body.id.to_owned());
            }
        }
        for line in &instant.bodies {
            self.seen += line.seen.len() as u64;
            if let Some(body) = self.body(line.id) {
                self.bodies[body].has_rows = true;
            }
        }
        let mut nameless = 0;
        for (_, identity) in instant.other_markers() {
            match identity {
                Some((id, name)) => {
                    let fresh = self.others.len();
                    let identity = (id.to_owned(), name.to_owned());
                    let other = *self.by_identity.entry(identity).or_insert(fresh);
                    if other == fresh {
                        self.others.push(Other {
                            name: name.to_owned(),
                            id: id.to_owned(),
                            seen: 0,
                        });
                    }
                    self.others[other].seen += 1;
                }
                None => {
                    if nameless == self.nameless.len() {
                        self.nameless.push(0);
                    }
                    self.nameless[nameless] += 1;
                    nameless += 1;
                }
            }
        }
    }

    pub(super) fn body(&self, id: &str) -> Option<usize> {
        self.by_id.get(id).copied()
    }

    pub(super) fn other(&self, (id, name): (&str, &str)) -> Option<usize> {
        self.by_identity
            .get(&(id.to_owned(), name.to_owned()))
            .copied()
    }

    pub(super) fn findings(&self) -> Vec<Finding> {
        let mut findings = self.findings.clone();
        if let Some(first) = self.undefined.first() {
            findings.push(Finding::warning(
                format!("body {first}"),
                format!(
                    "{} bodies are placed in frames and defined nowhere: not read",
                    self.undefined.len()
                ),
            ));
        }
        if let Some(frames) = self.nameless.first() {
            findings.push(Finding::warning(
                "markers",
                format!(
                    "in {frames} frames there are up to {} markers that nothing identifies: they \
                     are numbered in the order of their row, so that one number may stand for \
                     several markers",
                    self.nameless.len()
                ),
            ));
        }
        if self.bodies.iter().any(|body| body.has_rows) {
            findings.push(Finding::info(
                "mean errors",
                "not read: the file calls them millimetres, but they are as large as metres would \
                 be",
            ));
        }
        findings
    }
}
