//! Column layout of the rows of one kind in a row-typed file.

use inhand_model::{BodyKind, Finding, MarkerKind};

use super::entities::Entities;
use super::instants::Instant;
use crate::assembly::{Entity, RotationColumns};

/// Tracks get at most this many times the samples that the file has...
const SAMPLES_PER_SEEN: u64 = 10;
/// ...or this many: a marker seen once must not cost a sample for each frame of a long take.
const SAMPLES_AT_LEAST: u64 = 1_000_000;

/// Values of a body: position, then quaternion.
const BODY_VALUES: usize = 7;
/// Values of a marker of a body: where the fit places it, its quality, where it was seen.
const BODY_MARKER_VALUES: usize = 7;

/// Where each thing stands in a row of `width` values.
pub(super) struct Layout {
    pub(super) width: usize,
    bodies: Vec<usize>,
    /// `None` for markers that are not kept.
    others: Vec<Option<usize>>,
    nameless: Vec<usize>,
}

impl Layout {
    /// Makes room for all bodies, and for the other markers that are seen most often as far as
    /// memory stays in proportion to the file. `None` where it cannot even hold the bodies.
    pub(super) fn new(entities: &Entities) -> Option<(Self, Option<Finding>)> {
        let samples = (SAMPLES_PER_SEEN * entities.seen).max(SAMPLES_AT_LEAST);
        let tracks = usize::try_from(samples / entities.frames.max(1)).unwrap_or(usize::MAX);
        let mut width = 0;
        let mut of_bodies = 0_usize;
        let mut bodies = Vec::with_capacity(entities.bodies.len());
        for body in &entities.bodies {
            bodies.push(width);
            let markers = if body.has_rows { body.markers } else { 0 };
            of_bodies += 1 + 2 * markers;
            width += BODY_VALUES + markers * BODY_MARKER_VALUES;
        }
        let mut left = tracks.checked_sub(of_bodies)?;

        let mut by_count: Vec<usize> = (0..entities.others.len()).collect();
        by_count.sort_by_key(|&n| std::cmp::Reverse(entities.others[n].seen));
        let mut kept = vec![false; entities.others.len()];
        by_count.iter().take(left).for_each(|&n| kept[n] = true);
        left -= left.min(by_count.len());
        let mut next = || {
            width += 3;
            width - 3
        };
        let others: Vec<_> = kept.iter().map(|&kept| kept.then(&mut next)).collect();
        let nameless: Vec<_> = (0..entities.nameless.len().min(left))
            .map(|_| next())
            .collect();

        let lost_others = entities.others.iter().zip(&others);
        let lost_others = lost_others
            .filter(|(_, slot)| slot.is_none())
            .map(|(other, _)| other.seen);
        let lost: Vec<u64> = lost_others
            .chain(entities.nameless.iter().skip(nameless.len()).copied())
            .collect();
        let finding = (!lost.is_empty()).then(|| {
            Finding::warning(
                "markers",
                format!(
                    "{} markers are seen too seldom to give each a track in {} frames: {} of their \
                     samples are not read",
                    lost.len(),
                    entities.frames,
                    lost.iter().sum::<u64>()
                ),
            )
        });
        let layout = Self {
            width,
            bodies,
            others,
            nameless,
        };
        Some((layout, finding))
    }

    /// The bodies and markers with their places.
    pub(super) fn entities(&self, entities: &Entities) -> Vec<Entity> {
        let mut all = Vec::new();
        let marker = |name: &str, id: &str, kind, at: usize, quality| Entity::Marker {
            name: name.to_owned(),
            id: id.to_owned(),
            kind,
            position: [at, at + 1, at + 2],
            quality,
        };
        for (body, &at) in entities.bodies.iter().zip(&self.bodies) {
            all.push(Entity::Body {
                name: body.name.clone(),
                id: body.id.clone(),
                kind: BodyKind::RigidBody,
                rotation: RotationColumns::Quaternion([at + 3, at + 4, at + 5, at + 6]),
                position: [at, at + 1, at + 2],
                marker_error: None,
            });
            let markers = if body.has_rows { body.markers } else { 0 };
            for n in 0..markers {
                let name = format!("{}-Marker {}", body.name, n + 1);
                let at = body_marker(at, n);
                let fitted = MarkerKind::RigidBodyMarker;
                all.push(marker(&name, "", fitted, at, Some(at + 3)));
                all.push(marker(&name, "", MarkerKind::Labelled, at + 4, None));
            }
        }
        for (other, slot) in entities.others.iter().zip(&self.others) {
            let Some(at) = *slot else { continue };
            // What the software cannot tell is called `Marker-1718`.
            let unknown = other.name.is_empty() || other.name.starts_with("Marker-");
            let kind = match unknown {
                true => MarkerKind::Unlabelled,
                false => MarkerKind::Labelled,
            };
            let name = match other.name.as_str() {
                "" => format!("Marker-{}", other.id),
                name => name.to_owned(),
            };
            all.push(marker(&name, &other.id, kind, at, None));
        }
        for (n, &at) in self.nameless.iter().enumerate() {
            let name = format!("Unlabeled {}", n + 1);
            all.push(marker(&name, "", MarkerKind::Unlabelled, at, None));
        }
        all
    }

    /// Appends a frame's values, NaN where it has none.
    pub(super) fn fill(&self, entities: &Entities, instant: &Instant<'_>, values: &mut Vec<f64>) {
        let start = values.len();
        values.resize(start + self.width, f64::NAN);
        let row = &mut values[start..];
        let at_body = |id: &str| {
            entities
                .body(id)
                .map(|n| (self.bodies[n], &entities.bodies[n]))
        };
        for body in &instant.frame.bodies {
            if let Some((at, _)) = at_body(body.id) {
                row[at..at + BODY_VALUES].copy_from_slice(&body.pose);
            }
        }
        for line in &instant.bodies {
            let Some((at, body)) = at_body(line.id) else {
                continue;
            };
            for (n, seen) in line.seen.iter().take(body.markers).enumerate() {
                let at = body_marker(at, n);
                // A body that is not tracked repeats where its markers were last.
                if line.tracked {
                    row[at..at + 3].copy_from_slice(&line.fitted[n]);
                    row[at + 3] = line.quality[n];
                }
                row[at + 4..at + 7].copy_from_slice(seen);
            }
        }
        let mut nameless = self.nameless.iter();
        for (marker, identity) in instant.other_markers() {
            let at = match identity {
                Some(identity) => entities.other(identity).and_then(|n| self.others[n]),
                None => nameless.next().copied(),
            };
            if let Some(at) = at {
                row[at..at + 3].copy_from_slice(&marker.position);
            }
        }
    }
}

/// Where marker `n` of a body stands that itself stands at `body`.
fn body_marker(body: usize, n: usize) -> usize {
    body + BODY_VALUES + n * BODY_MARKER_VALUES
}
