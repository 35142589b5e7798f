//! Rotations and positions of a body against the markers that it carries.
//!
//! Seen from a rigid body, its markers do not move: `R^T (marker - origin)` is constant, if rotations
//! are read as they were written. Where it is not, but becomes constant under another reading (the
//! opposite rotation, w before x, y, z, another order of Euler angles, positions with axes swapped or
//! mirrored), that reading is how the file was written.
//!
//! A file in which positions and rotations were mirrored alike is consistent, and nothing here can
//! tell it from one that was not.

use inhand_model::{
    MarkerKind, PointTrack, Position, Recording, Roles, RotationOrder, Setting, TrackedBody, World,
};
use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

use super::bodies::{MIN_MARKERS, markers_of};
use super::checkup::{CheckResult, Level};
use super::words::length;
use crate::statistics::{Finite, thinned};

/// Samples that are looked at, evenly spread.
const SAMPLES: usize = 300;

/// Fewest samples that prove anything.
const MIN_SAMPLES: usize = 10;

/// How far markers may move in the frame of their body, relative to their distance from it...
const TOLERANCE_SHARE: f64 = 0.05;

/// ...and at least, metres: noise of markers and of the fit.
const TOLERANCE_M: f64 = 1.5e-3;

/// Another reading has to be this many times better to be believed.
const BETTER: f64 = 4.0;

/// Readings whose markers wander this many times the least, and this much more in metres, are as good.
const AS_GOOD: f64 = 1.5;
/// See [`AS_GOOD`].
const AS_GOOD_M: f64 = 1e-4;

/// Turn that a body has to make before its rotations are proven, radians: 15 degrees.
const MIN_TURN_RAD: f64 = 0.26;

/// Motion of the fingertips' centre in the hand's frame (90 %) that fingers alone do not give, metres: at most
/// 10 mm in clean takes, 48 to 74 mm under other readings.
const TIPS_M: f64 = 0.02;

/// Another reading has to hold the fingertips' centre this many times better.
const TIPS_BETTER: f64 = 3.0;

/// How the rotations and positions of a file could have to be read.
struct Reading {
    words: String,
    advice: String,
    /// The rotation that was meant, from the one that was read.
    rotation: Box<dyn Fn(UnitQuaternion<f64>) -> UnitQuaternion<f64>>,
    positions: Matrix3<f64>,
}

/// Looks at every body that carries three or more markers.
pub(crate) fn convention(recording: &Recording) -> Vec<CheckResult> {
    let bodies = recording.bodies.iter();
    bodies.filter_map(|body| of_body(recording, body)).collect()
}

fn of_body(recording: &Recording, body: &TrackedBody) -> Option<CheckResult> {
    let kinds = [MarkerKind::RigidBodyMarker, MarkerKind::Labelled];
    let markers = (kinds.into_iter())
        .map(|kind| markers_of(recording, body, kind))
        .find(|markers| markers.len() >= MIN_MARKERS)?;
    let tracks: Vec<_> = markers.iter().map(|marker| &marker.track).collect();
    let seen = Seen::new(body, &tracks)?;
    let stated = seen.wander_m(&|read| read, Matrix3::identity());
    let tolerance_m = TOLERANCE_M.max(TOLERANCE_SHARE * seen.radius_m);
    let turn_deg = seen.turn_rad.to_degrees();
    let base = |level| {
        CheckResult::new("axes", level, body.name.clone())
            .expected("markers that stay in place, seen from their body")
            .number("wander_mm", 1e3 * stated, seen.n())
            .number("turn_deg", turn_deg, seen.n())
    };
    if stated <= tolerance_m {
        return Some(if seen.turn_rad >= MIN_TURN_RAD {
            base(Level::Ok).found("rotations and positions agree")
        } else {
            base(Level::Info).found(format!(
                "no evidence on how rotations were written: turned by {turn_deg:.0} degrees at most"
            ))
        });
    }
    let better = (seen.best_reading(recording.source.rotation))
        .filter(|(wander_m, _)| *wander_m <= tolerance_m && BETTER * wander_m <= stated);
    let moved = format!("its markers move by {} seen from the body", length(stated));
    Some(match better {
        None => base(Level::Warn)
            .found(format!("{moved}, under any convention known"))
            .advice("the markers and poses do not belong together: export both again"),
        Some((wander_m, Reading { words, advice, .. })) => base(Level::Warn)
            .found(format!(
                "{moved}; they stay within {} if {words}",
                length(wander_m)
            ))
            .advice(advice)
            .number("wander_then_mm", 1e3 * wander_m, seen.n()),
    })
}

/// The rotations of the hand's body against the fingertips, whose centre stays where a hand has it. `None` without
/// evidence: fingertips that are hardly seen together, a hand that hardly turns. Where it carries markers, these
/// prove more.
pub(crate) fn rotation_by_fingertips(
    recording: &Recording,
    hand: &str,
    roles: &Roles,
) -> Option<Option<CheckResult>> {
    let tips = (roles.fingers.as_array().iter())
        .map(|name| Some(&recording.marker(name)?.track))
        .collect::<Option<Vec<_>>>()?;
    let centre = (0..recording.len()).map(|k| {
        let at: Option<Vec<_>> = tips
            .iter()
            .map(|tip| Some(tip.get(k)?.coords_m()))
            .collect();
        let sum: Vector3<f64> = at?.iter().sum();
        Some(Position::from_coords(sum / tips.len() as f64))
    });
    let centre = PointTrack::from_measured(centre);
    let body = recording.body(hand)?;
    let seen = Seen::new(body, &[&centre])?;
    if seen.turn_rad < MIN_TURN_RAD || has_proof(recording, body) {
        return None;
    }
    let stated = seen.wander_m(&|read| read, Matrix3::identity());
    let better = (stated > TIPS_M)
        .then(|| seen.best_reading(recording.source.rotation))
        .flatten()
        .filter(|(wander_m, _)| TIPS_BETTER * wander_m <= stated);
    Some(better.map(|(wander_m, Reading { words, advice, .. })| {
        let (moved, then) = (length(stated), length(wander_m));
        CheckResult::new("hand-rotation", Level::Fail, hand)
            .found(format!(
                "the fingertips' centre moves by {moved} in the hand; by {then} if {words}"
            ))
            .advice(advice)
    }))
}

/// Whether markers of a body prove how its rotations were written.
fn has_proof(recording: &Recording, body: &TrackedBody) -> bool {
    of_body(recording, body).is_some_and(|result| result.level != Level::Info)
}

/// A body and its markers at some samples.
struct Seen {
    rotations: Vec<UnitQuaternion<f64>>,
    /// Offsets from the body's origin, world axes; one list for each marker, `None` where missing.
    offsets: Vec<Vec<Option<Vector3<f64>>>>,
    radius_m: f64,
    turn_rad: f64,
}

impl Seen {
    fn new(body: &TrackedBody, markers: &[&PointTrack<World>]) -> Option<Self> {
        let present: Vec<usize> = (0..body.track.len())
            .filter(|&k| body.track.get(k).is_some())
            .collect();
        let poses: Vec<_> = (thinned(&present, SAMPLES).into_iter())
            .map(|k| (k, body.track.value(k).isometry()))
            .collect();
        if poses.len() < MIN_SAMPLES {
            return None;
        }
        let offsets: Vec<Vec<_>> = (markers.iter())
            .map(|marker| {
                let at = |&(k, pose): &(usize, Isometry3<f64>)| {
                    Some(marker.get(k)?.coords_m() - pose.translation.vector)
                };
                poses.iter().map(at).collect()
            })
            .collect();
        let radii = offsets.iter().flatten().flatten().map(Vector3::norm);
        let radius_m = Finite::new(radii).median();
        let rotations: Vec<_> = poses.iter().map(|(_, pose)| pose.rotation).collect();
        let turn_rad = (rotations.iter())
            .map(|rotation| rotation.angle_to(&rotations[0]))
            .fold(0.0, f64::max);
        radius_m.is_finite().then_some(Self {
            rotations,
            offsets,
            radius_m,
            turn_rad,
        })
    }

    fn n(&self) -> usize {
        self.rotations.len()
    }

    /// The other reading under which markers wander the least, with by how much; of readings that are as good as
    /// each other the likeliest, which is the first.
    fn best_reading(&self, written: Option<RotationOrder>) -> Option<(f64, Reading)> {
        let tried: Vec<_> = (readings(written).into_iter())
            .map(|reading| (self.wander_m(&reading.rotation, reading.positions), reading))
            .collect();
        let wanders_m = tried.iter().map(|(wander_m, _)| *wander_m);
        let as_good_m = AS_GOOD * wanders_m.fold(f64::INFINITY, f64::min) + AS_GOOD_M;
        tried
            .into_iter()
            .find(|(wander_m, _)| *wander_m <= as_good_m)
    }

    /// How far markers wander in the frame of the body under a reading: 90th percentile of the
    /// distances from each marker's median place.
    fn wander_m(
        &self,
        rotation: &dyn Fn(UnitQuaternion<f64>) -> UnitQuaternion<f64>,
        positions: Matrix3<f64>,
    ) -> f64 {
        let body_from_world: Vec<Matrix3<f64>> = (self.rotations.iter())
            .map(|&read| rotation(read).to_rotation_matrix().into_inner().transpose() * positions)
            .collect();
        let mut distances = Vec::with_capacity(self.n() * self.offsets.len());
        for offsets in &self.offsets {
            let places: Vec<Vector3<f64>> = (offsets.iter().zip(&body_from_world))
                .filter_map(|(offset, turn)| Some(turn * (*offset)?))
                .collect();
            let middle = Vector3::from_fn(|axis, _| {
                Finite::new(places.iter().map(|place| place[axis])).median()
            });
            distances.extend(places.iter().map(|place| (place - middle).norm()));
        }
        Finite::new(distances).quantile(0.9)
    }
}

/// Other readings, the likeliest first.
fn readings(written: Option<RotationOrder>) -> Vec<Reading> {
    let stated = written.map_or_else(|| "nothing".to_owned(), |order| order.to_string());
    let mut readings = Vec::new();
    let mut add = |words: &str, advice: &str, rotation| {
        readings.push(Reading {
            words: format!("{words}, and the file says {stated}"),
            advice: advice.to_owned(),
            rotation,
            positions: Matrix3::identity(),
        });
    };
    let again = "export again with quaternions, or with the convention that the file states";
    if let Some(RotationOrder::Euler(order)) = written {
        for other in EULER_ORDERS.into_iter().filter(|&other| other != order) {
            let (name, setting) = (RotationOrder::Euler(other), Setting::RotationOrder);
            let advice = format!(
                "read it with {setting} {name} where the file does not state one; else export again"
            );
            let words = format!("its Euler angles are in the order {name}");
            add(
                &words,
                &advice,
                Box::new(move |read| compose(angles(read, order), other)),
            );
        }
    } else {
        // The four numbers were taken as x, y, z, w and are w, x, y, z.
        let scalar_first = |read: UnitQuaternion<f64>| {
            let [x, y, z, w] = read.coords.into();
            UnitQuaternion::new_normalize(Quaternion::new(x, y, z, w))
        };
        add("w comes before x, y and z", again, Box::new(scalar_first));
    }
    let opposite = "its rotations are the opposite ones";
    add(
        opposite,
        again,
        Box::new(|read: UnitQuaternion<f64>| read.inverse()),
    );
    readings.extend(axis_changes().map(|(words, positions)| Reading {
        words: format!("positions are taken with {words}, and rotations as they are"),
        advice:
            "positions and rotations are in different axes: export both in one convention".into(),
        rotation: Box::new(|read| read),
        positions,
    }));
    readings
}

const EULER_ORDERS: [[u8; 3]; 6] = [
    [0, 1, 2],
    [0, 2, 1],
    [1, 0, 2],
    [1, 2, 0],
    [2, 0, 1],
    [2, 1, 0],
];

/// The other 47 ways to swap and mirror axes, those that change least first, with their words.
fn axis_changes() -> impl Iterator<Item = (String, Matrix3<f64>)> {
    let mut changes = Vec::new();
    for order in EULER_ORDERS {
        for signs in 0..8_u8 {
            let sign = |axis: usize| if signs >> axis & 1 == 1 { -1.0 } else { 1.0 };
            let mut matrix = Matrix3::zeros();
            let mut words = Vec::new();
            for (row, &from) in order.iter().enumerate() {
                matrix[(row, usize::from(from))] = sign(row);
                let minus = if sign(row) < 0.0 { "-" } else { "" };
                words.push(format!("{minus}{}", ["x", "y", "z"][usize::from(from)]));
            }
            let moved = (0..3).filter(|&row| row != usize::from(order[row])).count();
            let changed = moved + signs.count_ones() as usize;
            if changed > 0 {
                changes.push((changed, format!("axes ({})", words.join(", ")), matrix));
            }
        }
    }
    changes.sort_by_key(|(changed, ..)| *changed);
    changes
        .into_iter()
        .map(|(_, words, matrix)| (words, matrix))
}

/// Intrinsic Euler angles about x, y, z in radians, whose product in the stated order is the
/// rotation; the middle one lies within a quarter turn, as capture software writes it.
fn angles(rotation: UnitQuaternion<f64>, order: [u8; 3]) -> [f64; 3] {
    let [i, j, k] = order.map(usize::from);
    let r = rotation.to_rotation_matrix().into_inner();
    // R = R_i(a) R_j(b) R_k(c); for odd orders the signs of the off-diagonal elements change.
    let sign = if (i + 1) % 3 == j { 1.0 } else { -1.0 };
    let mut angles = [0.0; 3];
    angles[j] = (sign * r[(i, k)]).clamp(-1.0, 1.0).asin();
    if r[(i, k)].abs() < 1.0 - 1e-12 {
        angles[i] = (-sign * r[(j, k)]).atan2(r[(k, k)]);
        angles[k] = (-sign * r[(i, j)]).atan2(r[(i, i)]);
    } else {
        // Both outer turns are about the same line: give all of it to the first.
        angles[i] = (sign * r[(k, j)]).atan2(r[(j, j)]);
    }
    angles
}

/// The product of intrinsic rotations by angles about x, y, z, in an order.
fn compose(angles: [f64; 3], order: [u8; 3]) -> UnitQuaternion<f64> {
    let about = |axis: u8| {
        let axis = usize::from(axis);
        let mut direction = Vector3::zeros();
        direction[axis] = angles[axis];
        Rotation3::new(direction)
    };
    UnitQuaternion::from_rotation_matrix(&(about(order[0]) * about(order[1]) * about(order[2])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_and_their_product_are_opposite_in_every_order() {
        for order in EULER_ORDERS {
            for angles_rad in [[0.3, -0.7, 1.1], [-2.0, 0.4, 0.9], [0.1, 1.2, -3.0]] {
                // The middle angle of each order within a quarter turn.
                let mut angles_rad: [f64; 3] = angles_rad;
                let middle = usize::from(order[1]);
                angles_rad[middle] = angles_rad[middle].sin();
                let found = angles(compose(angles_rad, order), order);
                for axis in 0..3 {
                    assert!(
                        (found[axis] - angles_rad[axis]).abs() < 1e-12,
                        "{order:?}: {found:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn angles_at_the_pole_still_give_the_rotation() {
        for order in EULER_ORDERS {
            let mut at_pole = [0.4, 0.4, 0.4];
            at_pole[usize::from(order[1])] = std::f64::consts::FRAC_PI_2;
            let rotation = compose(at_pole, order);
            let again = compose(angles(rotation, order), order);
            assert!(rotation.angle_to(&again) < 1e-6, "{order:?}");
        }
    }

    #[test]
    fn there_are_47_changes_of_axes_half_of_them_mirrored() {
        let changes: Vec<_> = axis_changes().collect();
        assert_eq!(changes.len(), 47);
        let mirrored = changes
            .iter()
            .filter(|(_, m)| m.determinant() < 0.0)
            .count();
        assert_eq!(mirrored, 24);
        assert_eq!(changes[0].0, "axes (-x, y, z)");
    }
}
