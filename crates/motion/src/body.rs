//! Bodies of a take: as the capture software tracked them, or fitted to marker clusters.

use std::borrow::Cow;

use inhand_model::{Body, BodyKind, BodySource, Pose, Recording, Status, TrackedBody, World};
use nalgebra::Vector3;
use rayon::prelude::*;

use crate::error::{MotionError, listed};
use crate::lookup::{body, marker_track};
use crate::rigid_fit::{MIN_SPREAD, rigid_fit};
use crate::template::{BodyRole, Templates};

/// Markers that a pose needs.
const MIN_MARKERS: usize = 3;

/// Samples that a thread fits at a time; a fit is short.
const SAMPLES_PER_TASK: usize = 512;

/// The body that plays a role, whatever it is taken from; not filled, not filtered.
///
/// A cluster is fitted at every sample: its pose, and as marker error the mean distance of the markers
/// seen from their place in the template. It is named after its role. A sample that shows fewer than
/// three markers of the cluster, or only such as lie on a line, is missing. One that rests on a filled
/// marker is filled.
///
/// # Errors
///
/// [`MotionError::Body`] for a cluster that the templates were not made for, and
/// [`MotionError::NotInTake`].
pub fn role_body<'a>(
    recording: &'a Recording,
    role: BodyRole,
    source: &BodySource,
    templates: &Templates,
) -> Result<Cow<'a, TrackedBody>, MotionError> {
    Ok(match source {
        BodySource::RigidBody(name) => Cow::Borrowed(body(recording, role.name(), name)?),
        BodySource::Markers(names) => Cow::Owned(fitted_body(recording, role, names, templates)?),
    })
}

fn fitted_body(
    recording: &Recording,
    role: BodyRole,
    names: &[String],
    templates: &Templates,
) -> Result<TrackedBody, MotionError> {
    let template = templates.get(role);
    let Some(template) = template.filter(|template| template.markers == names) else {
        let (take, names) = (&recording.name, listed(names));
        let found = template.map_or_else(
            || "there is no template for it".to_owned(),
            |template| format!("the template is of {}", listed(&template.markers)),
        );
        return Err(MotionError::Body(format!(
            "take \"{take}\": the {role} is the cluster {names}, but {found}; fit the templates over \
             this take too"
        )));
    };
    let tracks = (names.iter())
        .map(|name| marker_track(recording, role.name(), name))
        .collect::<Result<Vec<_>, MotionError>>()?;
    let samples: Vec<_> = (0..recording.len())
        .into_par_iter()
        .with_min_len(SAMPLES_PER_TASK)
        .map_init(
            || (Vec::new(), Vec::new()),
            |(placed, seen), k| {
                placed.clear();
                seen.clear();
                let mut status = Status::Measured;
                for (track, &position_m) in tracks.iter().zip(&template.positions_m) {
                    if let Some(position) = track.get(k) {
                        placed.push(position_m);
                        seen.push(position.coords_m());
                        status = status.and(track.status(k));
                    }
                }
                (fitted_sample(placed, seen), status)
            },
        )
        .collect();

    let poses = samples
        .iter()
        .map(|&(fit, status)| (fit.map(|(pose, _)| pose), status));
    let errors_m = samples
        .iter()
        .map(|(fit, _)| fit.map_or(f64::NAN, |(_, error_m)| error_m));
    Ok(TrackedBody {
        name: role.name().to_owned(),
        id: String::new(),
        kind: BodyKind::RigidBody,
        track: poses.collect(),
        marker_error_m: Some(errors_m.collect()),
    })
}

/// Fits the template's markers `placed` (body frame) to where they were `seen` (world); the pose and the
/// mean distance of the markers from their place, metres.
fn fitted_sample(
    placed: &[Vector3<f64>],
    seen: &[Vector3<f64>],
) -> Option<(Pose<World, Body>, f64)> {
    if placed.len() < MIN_MARKERS {
        return None;
    }
    let fit = rigid_fit(placed, seen).filter(|fit| fit.spread >= MIN_SPREAD)?;
    let distances = (placed.iter().zip(seen)).map(|(&placed, &seen)| {
        (fit.isometry.rotation * placed + fit.isometry.translation.vector - seen).norm()
    });
    let error_m = distances.sum::<f64>() / placed.len() as f64;
    Some((Pose::new(fit.isometry), error_m))
}
