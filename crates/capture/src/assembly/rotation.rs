//! Rotations as vendors write them.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// A quaternion whose length is further from 1 than this is no rotation: six decimals leave 1e-6,
/// a spreadsheet set to three decimals 1e-3.
const QUATERNION_LENGTH_TOLERANCE: f64 = 1e-2;

/// Squared length up to which a quaternion counts as normalised already and is kept bit by bit.
const NORMALISED: f64 = 4.0 * f64::EPSILON;

/// A rotation from x, y, z, w, unless their length is nowhere near 1. Its sign is kept.
pub(super) fn unit_quaternion([x, y, z, w]: [f64; 4]) -> Option<UnitQuaternion<f64>> {
    let quaternion = Quaternion::new(w, x, y, z);
    let squared = quaternion.norm_squared();
    if (squared - 1.0).abs() <= NORMALISED {
        return Some(UnitQuaternion::new_unchecked(quaternion));
    }
    let length = squared.sqrt();
    ((length - 1.0).abs() <= QUATERNION_LENGTH_TOLERANCE)
        .then(|| UnitQuaternion::new_unchecked(quaternion / length))
}

/// A rotation from intrinsic Euler angles: `angles_deg` about x, y, z, the rotation about `axes[0]`
/// first, each next one about the axis that the ones before have turned; as matrices
/// `R(axes[0]) R(axes[1]) R(axes[2])`.
pub(super) fn euler(angles_deg: [f64; 3], axes: [u8; 3]) -> UnitQuaternion<f64> {
    let about = |axis: u8| {
        let angle = angles_deg[usize::from(axis)].to_radians();
        match axis {
            0 => UnitQuaternion::from_axis_angle(&Vector3::x_axis(), angle),
            1 => UnitQuaternion::from_axis_angle(&Vector3::y_axis(), angle),
            _ => UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle),
        }
    };
    about(axes[0]) * about(axes[1]) * about(axes[2])
}
