//! Bodies of a take: as the capture software tracked them, or fitted to marker clusters.

use inhand_model::{
    Body, BodyKind, BodySource, Frame, Pose, PoseTrack, Recording, Roles, Sample, Status, Track,
    TrackedBody, World,
};
use nalgebra::Vector3;
use rayon::prelude::*;

use crate::error::MotionError;
use crate::lookup::{body, marker};
use crate::rigid_fit::{MIN_SPREAD, rigid_fit};
use crate::template::{BodyRole, Templates};

/// Markers that a pose needs.
const MIN_MARKERS: usize = 3;

/// Samples that a thread fits at a time; a fit is short.
const SAMPLES_PER_TASK: usize = 512;

/// The body of each cluster among the roles, fitted to every sample of a take: its pose, and as
/// marker error the mean distance of the markers seen from their place in the template. Empty where
/// hand and object are rigid bodies of the take. Each is named after its role.
///
/// A sample that shows fewer than three markers of the cluster, or only such as lie on a line, is
/// missing. One that rests on a filled marker is filled.
///
/// # Errors
///
/// [`MotionError::NoTemplate`] for a cluster that the templates were not made for, and
/// [`MotionError::NotInTake`].
pub fn fitted_bodies(
    recording: &Recording,
    roles: &Roles,
    templates: &Templates,
) -> Result<Vec<TrackedBody>, MotionError> {
    let mut bodies = Vec::new();
    for role in [BodyRole::Hand, BodyRole::Object] {
        if let Some(BodySource::Markers(names)) = role.source(roles) {
            bodies.push(fitted_body(recording, role, names, templates)?);
        }
    }
    Ok(bodies)
}

/// The pose of a body over a take, whatever it is taken from; not filled, not filtered.
pub(crate) fn pose_track<F: Frame>(
    recording: &Recording,
    role: BodyRole,
    source: &BodySource,
    templates: &Templates,
) -> Result<PoseTrack<World, F>, MotionError> {
    let in_role = |pose: Pose<World, Body>| Pose::new(pose.isometry());
    match source {
        BodySource::RigidBody(name) => Ok(body(recording, role.name(), name)?.track.map(in_role)),
        BodySource::Markers(names) => Ok(fitted_body(recording, role, names, templates)?
            .track
            .map(in_role)),
    }
}

fn fitted_body(
    recording: &Recording,
    role: BodyRole,
    names: &[String],
    templates: &Templates,
) -> Result<TrackedBody, MotionError> {
    let template = templates.get(role);
    let Some(template) = template.filter(|template| template.markers() == names) else {
        return Err(MotionError::NoTemplate {
            take: recording.name.clone(),
            role,
            markers: names.to_vec(),
            template: template.map(|template| template.markers().to_vec()),
        });
    };
    let tracks = (names.iter())
        .map(|name| Ok(&marker(recording, role.name(), name)?.track))
        .collect::<Result<Vec<_>, MotionError>>()?;
    let samples: Vec<FittedSample> = (0..recording.len())
        .into_par_iter()
        .with_min_len(SAMPLES_PER_TASK)
        .map_init(
            || (Vec::new(), Vec::new()),
            |(placed, seen), k| {
                placed.clear();
                seen.clear();
                let mut status = Status::Measured;
                for (track, &position_m) in tracks.iter().zip(template.positions_m()) {
                    if let Some(position) = track.get(k) {
                        placed.push(position_m);
                        seen.push(position.coords_m());
                        status = status.and(track.status(k));
                    }
                }
                fitted_sample(placed, seen, status)
            },
        )
        .collect();

    let mut track = Track::with_capacity(samples.len());
    for sample in &samples {
        track.push(sample.pose, sample.status);
    }
    Ok(TrackedBody {
        name: role.name().to_owned(),
        id: String::new(),
        kind: BodyKind::RigidBody,
        track,
        marker_error_m: Some(samples.iter().map(|sample| sample.error_m).collect()),
    })
}

struct FittedSample {
    pose: Option<Pose<World, Body>>,
    status: Status,
    error_m: f64,
}

/// Fits the template's markers `placed` (body frame) to where they were `seen` (world).
fn fitted_sample(placed: &[Vector3<f64>], seen: &[Vector3<f64>], status: Status) -> FittedSample {
    let fit = (placed.len() >= MIN_MARKERS)
        .then(|| rigid_fit(placed, seen))
        .flatten()
        .filter(|fit| fit.spread >= MIN_SPREAD);
    let Some(fit) = fit else {
        return FittedSample {
            pose: None,
            status: Status::Missing,
            error_m: f64::NAN,
        };
    };
    let distances = (placed.iter().zip(seen)).map(|(&placed, &seen)| {
        (fit.isometry.rotation * placed + fit.isometry.translation.vector - seen).norm()
    });
    let pose = Pose::new(fit.isometry);
    debug_assert!(Sample::is_finite(pose));
    FittedSample {
        pose: Some(pose),
        status,
        error_m: distances.sum::<f64>() / placed.len() as f64,
    }
}
