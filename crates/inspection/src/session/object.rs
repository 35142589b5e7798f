//! The object of a session: its size, its fit between the fingertips, its body.

use inhand_model::{Level, Pose, SessionFinding, Shape};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::{SessionMotion, finding, of_take};
use crate::check::words::length;
use crate::statistics::Finite;

/// Least and largest size of an object in one hand, metres: below, fingertips cannot be apart; above, they do not
/// span it.
const OBJECT_M: [f64; 2] = [0.005, 0.28];

/// Share of the object's least size above which a contact distance is doubtful.
const QUARTER: f64 = 0.25;

/// Median distance of a fingertip from the surface above which the object is hardly held, metres: markers on nails
/// are up to 12 mm out.
const FAR_M: f64 = 0.015;

/// Motion in the hand's frame (95 %) below which two bodies are one, metres...
const SAME_M: f64 = 5e-4;

/// ...and radians: half a degree.
const SAME_RAD: f64 = 0.009;

/// Turn of the hand (95 %) that shows whether a body turns with it, radians: ten times as much.
const MIN_TURN_RAD: f64 = 0.09;

/// Fewest samples that prove anything.
const MIN_SAMPLES: usize = 10;

/// Time from which contact of all fingers at every instant is doubtful, seconds.
const ALWAYS_S: f64 = 30.0;

/// An object that is the hand's body, or is fixed to it.
pub(super) fn object_is_hand(take: &SessionMotion<'_>) -> Option<SessionFinding> {
    let found = if take.roles.object.as_ref() == Some(&take.roles.hand) {
        "hand and object are the same body"
    } else if is_fixed_to_hand(take) {
        "the object never moves in the hand"
    } else {
        return None;
    };
    let advice = "name the object's body: --object-body";
    let finding = finding("object-is-hand", Level::Fail, found.to_owned(), advice);
    Some(of_take(take, finding))
}

fn is_fixed_to_hand(take: &SessionMotion<'_>) -> bool {
    let turn_rad = |all: &[Isometry3<f64>], from: &UnitQuaternion<f64>| {
        Finite::new(all.iter().map(|pose| pose.rotation.angle_to(from))).quantile(0.95)
    };
    let hand: Vec<_> = take
        .motion
        .hand
        .iter()
        .flatten()
        .map(Pose::isometry)
        .collect();
    let object = take
        .motion
        .object
        .iter()
        .flat_map(|track| track.iter().flatten());
    let object: Vec<_> = object.map(Pose::isometry).collect();
    let turns = |first: &Isometry3<f64>| turn_rad(&hand, &first.rotation) >= MIN_TURN_RAD;
    if object.len() < MIN_SAMPLES || !hand.first().is_some_and(turns) {
        return false;
    }
    let places = || object.iter().map(|pose| pose.translation.vector);
    let middle = Vector3::from_fn(|axis, _| Finite::new(places().map(|at| at[axis])).median());
    let moved_m = Finite::new(places().map(|at| (at - middle).norm())).quantile(0.95);
    moved_m < SAME_M && turn_rad(&object, &object[object.len() / 2].rotation) < SAME_RAD
}

pub(super) fn no_shape(take: &SessionMotion<'_>) -> Option<SessionFinding> {
    take.motion.object.as_ref().map(|_| {
        let found = "an object is tracked, but its shape is not given: contacts, distances and phases are \
                     left out";
        let advice = "give it, such as --object cube:0.05";
        of_take(take, finding("no-shape", Level::Warn, found.to_owned(), advice))
    })
}

fn sizes_m(shape: Shape) -> Vec<f64> {
    match shape {
        Shape::Cuboid { edges_m } => edges_m.to_vec(),
        Shape::Cylinder {
            diameter_m,
            height_m,
        } => vec![diameter_m, height_m],
    }
}

pub(super) fn object_size(shape: Shape) -> Option<SessionFinding> {
    let [least, most] = OBJECT_M;
    let size_m = sizes_m(shape)
        .into_iter()
        .find(|size| !(least..=most).contains(size))?;
    let found = format!(
        "{shape} measures {}; expected {} to {} in one hand",
        length(size_m),
        length(least),
        length(most)
    );
    let advice = "give its size in metres, such as --object cube:0.05";
    Some(finding("object-size", Level::Fail, found, advice))
}

pub(super) fn tau(shape: Shape, tau_m: f64) -> Option<SessionFinding> {
    let least_m = sizes_m(shape).into_iter().fold(f64::INFINITY, f64::min);
    (tau_m > QUARTER * least_m).then(|| {
        let (tau, size) = (length(tau_m), length(least_m));
        let found = format!("a fingertip {tau} from an object of {size} counts as touching it");
        let advice = "use less than a quarter of the object's least size: --tau-mm";
        finding("tau", Level::Warn, found, advice)
    })
}

/// Fingertips inside the object or far from it in the middle of the take, or all of them on it at every instant.
pub(super) fn object_fit(take: &SessionMotion<'_>, tau_m: f64) -> Option<SessionFinding> {
    let known = || take.distances_m.iter().flatten();
    let distances = known().flat_map(|distances| distances.as_array().to_owned());
    let middle_m = Finite::new(distances).median();
    let instants = known().count();
    let touches = known().filter(|distances| distances.as_array().iter().all(|m| m.abs() <= tau_m));
    let always = instants as f64 >= ALWAYS_S * take.motion.clock.rate_hz();
    let found = if middle_m < -tau_m / 2.0 {
        format!(
            "half of the fingertip positions are more than {} inside the object",
            length(-middle_m)
        )
    } else if middle_m > FAR_M {
        format!(
            "half of the fingertip positions are more than {} from the object",
            length(middle_m)
        )
    } else if always && touches.count() == instants {
        "all five fingertips touch the object at every instant".to_owned()
    } else {
        return None;
    };
    let advice = "see shape, size and centre of the object: --object, --object-offset";
    Some(of_take(
        take,
        finding("object-fit", Level::Warn, found, advice),
    ))
}
