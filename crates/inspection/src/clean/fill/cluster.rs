//! A marker from the other markers of a rigid cluster.

use std::ops::Range;

use inhand_model::{
    Body, BodySource, MarkerKind, PerFinger, Pose, PoseTrack, Position, Recording, Roles, Status,
    World,
};
use inhand_motion::{BodyRole, MotionError, fit_templates, role_body};
use nalgebra::Vector3;

use super::{Filled, inner_gaps, join};
use crate::lookup::{finger_of, is_named_after};
use crate::statistics::median;

/// Fewest other markers that say how a cluster is turned.
const LEAST_OTHERS: usize = 3;

/// Fills gaps of markers of clusters: those that roles name, and those of rigid bodies, whose names
/// begin with the body's and a colon, or `_` and a number, as older exports have it. Fingertips belong
/// to no cluster, whatever they are called: they move in the hand.
pub(super) fn from_clusters(
    recording: &Recording,
    roles: &Roles,
    tips: &PerFinger<usize>,
    limit: usize,
) -> Result<Vec<Filled>, MotionError> {
    let mut filled = Vec::new();
    let sources = [Some(&roles.hand), roles.object.as_ref()];
    for source in sources.into_iter().flatten() {
        if let BodySource::Markers(names) = source {
            filled.extend(from_role(recording, roles, tips, names, limit)?);
        }
    }
    for body in &recording.bodies {
        for (marker, source) in recording.markers.iter().enumerate() {
            if is_named_after(&source.name, &body.name)
                && source.kind != MarkerKind::Unlabelled
                && finger_of(tips, marker).is_none()
            {
                filled.extend(by_poses(recording, marker, &body.track, limit));
            }
        }
    }
    Ok(filled)
}

/// Gaps of the markers that a role names, each by the others.
fn from_role(
    recording: &Recording,
    roles: &Roles,
    tips: &PerFinger<usize>,
    names: &[String],
    limit: usize,
) -> Result<Vec<Filled>, MotionError> {
    let cluster: Vec<(&String, usize)> = (names.iter())
        .filter_map(|name| Some((name, recording.marker_index(name)?)))
        .filter(|&(_, marker)| finger_of(tips, marker).is_none())
        .collect();
    let mut filled = Vec::new();
    for &(name, marker) in &cluster {
        let track = &recording.markers[marker].track;
        if inner_gaps(track, limit).next().is_none() {
            continue;
        }
        let others: Vec<String> = (cluster.iter().map(|(other, _)| *other))
            .filter(|other| *other != name)
            .cloned()
            .collect();
        if others.len() < LEAST_OTHERS {
            let (take, cluster, found) = (&recording.name, names.join(", "), others.len());
            return Err(MotionError::Body(format!(
                "take \"{take}\": marker \"{name}\" of the cluster \"{cluster}\" has {found} others that \
                 are no fingertip, and {LEAST_OTHERS} are needed to fill it by the cluster: name more \
                 markers, or fill by another method"
            )));
        }
        // The pose of the cluster without the marker that is wanted.
        let source = BodySource::Markers(others);
        let without = Roles {
            hand: source.clone(),
            object: None,
            ..roles.clone()
        };
        let templates = fit_templates([(recording, &without)])?;
        let body = role_body(recording, BodyRole::Hand, &source, &templates)?;
        filled.extend(by_poses(recording, marker, &body.track, limit));
    }
    Ok(filled)
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
        median(seen.map(|at| at.coords_m()[axis]))
    };
    let place = Position::<Body>::new(axis(0), axis(1), axis(2));
    let placed = |k: usize| (poses.get(k)).map(|pose: Pose<World, Body>| (pose * place).coords_m());
    gaps.into_iter()
        .filter_map(|gap| {
            let guesses: Vec<Vector3<f64>> = gap.clone().map(placed).collect::<Option<_>>()?;
            // The body may be missing beside the gap; then there is nothing to join to.
            let off = |k: usize| {
                let both = placed(k).zip(track.get(k));
                both.map_or(Vector3::zeros(), |(guess, here)| here.coords_m() - guess)
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
