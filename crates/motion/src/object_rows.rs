//! The object in a segment's column: where it is, and how far it has turned.

use std::f64::consts::TAU;

use inhand_model::{Hand, OBJECT_COORDINATES, Object, Pose, ROTATION_LEVER_M};
use nalgebra::{Unit, UnitQuaternion, Vector3};

/// A turn below which its axis is rounding, radians: unit quaternions carry some 1e-16.
const SMALLEST_TURN_RAD: f64 = 1e-9;

/// Fills the object's rows of a column (6 N, time-major) from its poses at the N samples, all of them
/// present: position in the hand's frame, metres, and the rotation vector since the first sample
/// (hand frame) times [`ROTATION_LEVER_M`].
///
/// A rotation has many vectors, whole turns apart along its axis. The first sample's is zero, and
/// each further sample takes the one nearest to the sample before, so that a steady turn is a
/// straight line beyond half a turn too. Near a whole turn the axis of what is left is lost in noise
/// and the vector with it, as for any three numbers that stand for a rotation.
pub(crate) fn fill(rows_m: &mut [f64], poses: &[Pose<Hand, Object>]) {
    let Some(first) = poses.first() else {
        return;
    };
    let back = first.isometry().rotation.inverse();
    let mut turned = Vector3::zeros();
    for (k, (row, pose)) in (rows_m
        .as_chunks_mut::<OBJECT_COORDINATES>()
        .0
        .iter_mut()
        .zip(poses))
    .enumerate()
    {
        let [x, y, z] = pose.origin().to_array();
        if k > 0 {
            turned = nearest_rotation_vector(pose.isometry().rotation * back, turned);
        }
        let [a, b, c]: [f64; 3] = (turned * ROTATION_LEVER_M).into();
        *row = [x, y, z, a, b, c];
    }
}

/// The rotation vector of a rotation that is nearest to `previous`, radians: of
/// `axis * (angle + 2 pi k)` over whole k.
fn nearest_rotation_vector(rotation: UnitQuaternion<f64>, previous: Vector3<f64>) -> Vector3<f64> {
    let shortest = rotation.scaled_axis();
    let angle = shortest.norm();
    // No turn, or whole turns, have any axis: the nearest vector lies along the previous one.
    let axis = Unit::try_new(shortest, SMALLEST_TURN_RAD)
        .or_else(|| Unit::try_new(previous, SMALLEST_TURN_RAD));
    let Some(axis) = axis else {
        return shortest;
    };
    // Half a turn from nowhere is as near either way and stays as it is: ties go to even.
    let turns = ((axis.dot(&previous) - angle) / TAU).round_ties_even();
    axis.into_inner() * (angle + TAU * turns)
}
