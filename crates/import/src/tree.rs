//! Transforms of frames in frames that move themselves.

use std::collections::{BTreeMap, BTreeSet};

use inhand_model::rotation_from_xyzw;
use nalgebra::{Isometry3, Translation3};

use crate::reading::Kind;
use crate::series::{Gathered, Static};

/// Frames above each other at most.
const MAX_DEPTH: usize = 64;

/// A rigid transform from what a message says, in the unit of the source.
pub(crate) fn isometry(position: [f64; 3], rotation: [f64; 4]) -> Option<Isometry3<f64>> {
    let finite = position.iter().all(|c| c.is_finite());
    let rotation = rotation_from_xyzw(rotation).filter(|_| finite)?;
    Some(Isometry3::from_parts(
        Translation3::from(position),
        rotation,
    ))
}

/// The transform between a frame and the one above it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Link {
    /// A series, by its place in the list of those used.
    Moving(usize),
    /// The same all the time.
    Fixed(Isometry3<f64>),
}

/// The links above each transform among the used series, next one first, up to the highest frame
/// that moves: transforms above that one place the capture volume. Also the frame at the top.
///
/// `None` for series that are no transforms, and for frames that go round in a circle.
pub(crate) fn links_above(
    gathered: &Gathered<'_>,
    used: &[usize],
) -> Vec<Option<(Vec<Link>, String)>> {
    let mut moving: BTreeMap<&str, usize> = BTreeMap::new();
    for (at, &index) in used.iter().enumerate() {
        let series = &gathered.series[index];
        if series.kind == Kind::Transform {
            moving.entry(&series.source_name).or_insert(at);
        }
    }
    let above = |at: usize| {
        let series = &gathered.series[used[at]];
        (series.kind == Kind::Transform)
            .then(|| climb(gathered, used, &moving, &series.frame))
            .flatten()
    };
    (0..used.len()).map(above).collect()
}

/// The root of a frame's tree, seen from the frame: `frame_from_root` over the static
/// transforms above it. `None` where a transform above it moves, or they go round in a circle.
pub(crate) fn root_of(gathered: &Gathered<'_>, frame: &str) -> Option<(String, Isometry3<f64>)> {
    let moves = |frame: &str| {
        (gathered.series.iter())
            .any(|series| series.kind == Kind::Transform && series.source_name == frame)
    };
    let mut root = frame.to_owned();
    let mut root_from_frame = Isometry3::identity();
    for _ in 0..MAX_DEPTH {
        if moves(&root) {
            return None;
        }
        let Some(above) = gathered.statics.get(&root) else {
            return Some((root, root_from_frame.inverse()));
        };
        root_from_frame = isometry(above.position, above.rotation)? * root_from_frame;
        root.clone_from(&above.parent);
    }
    None
}

fn climb(
    gathered: &Gathered<'_>,
    used: &[usize],
    moving: &BTreeMap<&str, usize>,
    parent: &str,
) -> Option<(Vec<Link>, String)> {
    let mut links = Vec::new();
    let mut frame = parent;
    // The highest moving link so far, and the frame above it.
    let (mut kept, mut top) = (0, parent);
    let mut seen = BTreeSet::new();
    while links.len() < MAX_DEPTH && seen.insert(frame) {
        if let Some(&at) = moving.get(frame) {
            links.push(Link::Moving(at));
            frame = &gathered.series[used[at]].frame;
            (kept, top) = (links.len(), frame);
        } else if let Some(Static {
            parent,
            position,
            rotation,
        }) = gathered.statics.get(frame)
        {
            links.push(Link::Fixed(isometry(*position, *rotation)?));
            frame = parent;
        } else {
            links.truncate(kept);
            return Some((links, top.to_owned()));
        }
    }
    None
}
