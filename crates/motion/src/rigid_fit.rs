//! The rigid motion that takes one set of points nearest to another.

use nalgebra::{Isometry3, Matrix3, Matrix4, Quaternion, Translation3, UnitQuaternion, Vector3};

/// How far a set of points has to spread across its main line, relative to along it, before a turn
/// about that line can be told.
///
/// At this limit, markers spread over 60 mm lie some 2 mm off their line, and 0.2 mm of noise turns
/// the body by several degrees: nothing to build a frame on.
pub(crate) const MIN_SPREAD: f64 = 0.03;

/// Eigenvalue iterations before giving up; a 4 x 4 matrix takes about eight, and one that overflowed
/// would take for ever.
const MAX_ITERATIONS: usize = 100;

/// A fit and what it rests on.
pub(crate) struct RigidFit {
    /// Takes the first set to the second.
    pub(crate) isometry: Isometry3<f64>,
    /// Root mean square spread across the main line relative to along it.
    pub(crate) spread: f64,
}

/// The proper rigid motion of least squares (Kabsch's problem): rotation `R` and translation `t`
/// that minimise `sum |R from_i + t - to_i|²` over sets of equal length (n x 3 each).
///
/// Solved by Horn's quaternion form (*Closed-form solution of absolute orientation using unit
/// quaternions*, J. Opt. Soc. Am. A 4(4), 1987): the rotation is the eigenvector of the largest
/// eigenvalue of a symmetric 4 x 4 matrix. That is the minimiser over rotations alone, mirrored and
/// flat sets included, so the reflection that the singular value form has to undo cannot occur.
///
/// With singular values `s1 >= s2 >= s3` of the cross-covariance the two largest eigenvalues are
/// `s1 + s2 ± s3` and `s1 - s2 ∓ s3`: their gap, `2 (s2 ± s3)`, says how well the turn about the
/// main line is determined, and is what `spread` is taken from. `None` for fewer than two points,
/// coinciding points and numbers that overflow.
pub(crate) fn rigid_fit(from: &[Vector3<f64>], to: &[Vector3<f64>]) -> Option<RigidFit> {
    debug_assert_eq!(from.len(), to.len());
    if from.len() < 2 {
        return None;
    }
    let from_centre = centroid(from);
    let to_centre = centroid(to);
    let s: Matrix3<f64> = (from.iter().zip(to))
        .map(|(from, to)| (from - from_centre) * (to - to_centre).transpose())
        .sum();
    let (xx, xy, xz) = (s.m11, s.m12, s.m13);
    let (yx, yy, yz) = (s.m21, s.m22, s.m23);
    let (zx, zy, zz) = (s.m31, s.m32, s.m33);
    #[rustfmt::skip]
    let n = Matrix4::new(
        xx + yy + zz, yz - zy,      zx - xz,       xy - yx,
        yz - zy,      xx - yy - zz, xy + yx,       zx + xz,
        zx - xz,      xy + yx,      yy - xx - zz,  yz + zy,
        xy - yx,      zx + xz,      yz + zy,       zz - xx - yy,
    );
    if !n.iter().all(|v| v.is_finite()) {
        return None;
    }
    let eigen = n.try_symmetric_eigen(f64::EPSILON, MAX_ITERATIONS)?;
    let first = eigen.eigenvalues.imax();
    let largest = eigen.eigenvalues[first];
    if largest <= 0.0 {
        return None;
    }
    let second = (0..4)
        .filter(|&i| i != first)
        .map(|i| eigen.eigenvalues[i])
        .fold(f64::NEG_INFINITY, f64::max);
    let across = (0.5 * (largest - second)).max(0.0);
    let along = 0.5 * (largest + second);
    let spread = if across < along {
        (across / along).sqrt()
    } else {
        1.0
    };

    let q = eigen.eigenvectors.column(first);
    let rotation = UnitQuaternion::try_new(Quaternion::new(q[0], q[1], q[2], q[3]), 0.0)?;
    let translation = Translation3::from(to_centre - rotation * from_centre);
    Some(RigidFit {
        isometry: Isometry3::from_parts(translation, rotation),
        spread,
    })
}

pub(crate) fn centroid(points: &[Vector3<f64>]) -> Vector3<f64> {
    points.iter().sum::<Vector3<f64>>() / points.len() as f64
}
