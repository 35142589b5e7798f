//! A marker from the other markers of a rigid cluster.

use std::ops::Range;

use inhand_model::{
    Body, BodySource, MarkerKind, Pose, PoseTrack, Position, Recording, Roles, Status, World,
};
use inhand_motion::{fit_templates, fitted_bodies};
use nalgebra::Vector3;

use super::{Filled, inner_gaps, join};
use crate::lookup::marker_index;
use crate::statistics::median;

/// Fills gaps of markers of clusters: those that roles name, and those of rigid bodies, whose names
/// begin with the body's and a colon (or `_`, as older exports have it).
pub(super) fn from_clusters(recording: &Recording, roles: &Roles, limit: usize) -> Vec<Filled> {
    let mut filled = Vec::new();
    for source in [Some(&roles.hand), roles.object.as_ref()]
        .into_iter()
        .flatten()
    {
        if let BodySource::Markers(names) = source {
            for name in names {
                let others: Vec<String> = names.iter().filter(|o| *o != name).cloned().collect();
                let Some(marker) = marker_index(recording, name) else {
                    continue;
                };
                let Some(poses) = fitted(recording, roles, &others) else {
                    continue;
                };
                filled.extend(by_poses(recording, marker, &poses, limit));
            }
        }
    }
    for body in &recording.bodies {
        for (marker, source) in recording.markers.iter().enumerate() {
            let rest = source.name.strip_prefix(&body.name);
            let of_body = rest.is_some_and(|rest| rest.starts_with([':', '_']));
            if of_body && source.kind != MarkerKind::Unlabelled {
                filled.extend(by_poses(recording, marker, &body.track, limit));
            }
        }
    }
    filled
}

/// The pose of a cluster without the marker that is wanted. `None` where the others are fewer than three
/// or lie on a line.
fn fitted(
    recording: &Recording,
    roles: &Roles,
    names: &[String],
) -> Option<PoseTrack<World, Body>> {
    let others = Roles {
        hand: BodySource::Markers(names.to_vec()),
        object: None,
        ..roles.clone()
    };
    let templates = fit_templates([(recording, &others)]).ok()?;
    let bodies = fitted_bodies(recording, &others, &templates).ok()?;
    Some(bodies.into_iter().next()?.track)
}

fn by_poses(
    recording: &Recording,
    marker: usize,
    poses: &PoseTrack<World, Body>,
    limit: usize,
) -> Vec<Filled> {
    let track = &recording.markers[marker].track;
    let gaps: Vec<Range<usize>> = inner_gaps(track, limit).collect();
    if gaps.is_empty() {
        return Vec::new();
    }
    let in_body = |k: usize| -> Option<Position<Body>> {
        (track.status(k) == Status::Measured).then_some(())?;
        Some(poses.get(k)?.inverse() * track.get(k)?)
    };
    let axis = |axis: usize| {
        let seen = (0..track.len()).filter_map(in_body);
        median(&mut seen.map(|at| at.coords_m()[axis]).collect::<Vec<f64>>())
    };
    let place = Position::<Body>::new(axis(0), axis(1), axis(2));
    let placed = |k: usize| {
        poses
            .get(k)
            .map(|pose: Pose<World, Body>| (pose * place).coords_m())
    };
    gaps.into_iter()
        .filter_map(|gap| {
            let guesses: Vec<Vector3<f64>> = gap.clone().map(placed).collect::<Option<_>>()?;
            // The body may be missing beside the gap; then there is nothing to join to.
            let off = |k: usize| {
                let here = track.get(k).map(Position::coords_m);
                placed(k)
                    .zip(here)
                    .map_or(Vector3::zeros(), |(guess, here)| here - guess)
            };
            let (before, after) = (off(gap.start - 1), off(gap.end));
            let values = join(&gap, before, after, |k| guesses[k - gap.start]);
            Some(Filled {
                marker,
                gap,
                values,
            })
        })
        .collect()
}
