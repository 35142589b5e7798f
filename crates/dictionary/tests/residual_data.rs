//! Segments around the cubic Hermite baseline, made up here: boundary conditions and deviations are given.

use std::f64::consts::TAU;

use inhand_dictionary::{DEVIATION_PRIMITIVES, learn_residual};
use inhand_model::{
    EndConditions, ObjectEnds, Pose, ROTATION_LEVER_M, Residual, SEGMENT_COORDINATES,
    SegmentLayout, SegmentOrigin, Segments, SmoothCurve, ends_len,
};
use nalgebra::{DMatrix, DVector, Isometry3, Translation3, UnitQuaternion, Vector3};

/// From -1 to 1, by an integer hash that `make_residual_reference.py` has too.
pub(crate) fn uniform(key: &[usize]) -> f64 {
    let mut h = 0_u32;
    for part in key {
        h = (h ^ *part as u32)
            .wrapping_mul(2_654_435_761)
            .wrapping_add(1_013_904_223);
        h ^= h >> 15;
        h = h.wrapping_mul(2_246_822_519);
        h ^= h >> 13;
    }
    f64::from(h) / f64::from(1_u32 << 31) - 1.0
}

/// Standard normal (Box and Muller).
pub(crate) fn normal(key: &[usize]) -> f64 {
    let half = |last| 0.5 * (uniform(&[key, &[last]].concat()) + 1.0);
    let radius = (-2.0 * (1.0 - half(0)).max(1e-300).ln()).sqrt();
    radius * (TAU * half(1)).cos()
}

/// Boundary conditions as numbers: some centimetres apart, slow, the object a little turned.
pub(crate) fn numbers(i: usize, layout: SegmentLayout) -> DVector<f64> {
    let first = |c| 0.05 * uniform(&[1, i, c]);
    let object = |a| 0.1 + 0.02 * uniform(&[4, i, a]);
    DVector::from_fn(ends_len(layout), |k, _| match k {
        0..15 => first(k),
        15..30 => first(k - 15) + 0.02 * uniform(&[2, i, k - 15]),
        30..60 => 0.06 * uniform(&[3, i, k - 30]),
        60..63 => object(k - 60),
        63..66 => object(k - 63) + 0.03 * uniform(&[5, i, k - 63]),
        _ => 0.01 * uniform(&[6, i, k - 66]),
    })
}

/// Boundary conditions from numbers.
pub(crate) fn ends(numbers: &DVector<f64>) -> EndConditions {
    let part = |part: usize| {
        let mut configuration = [0.0; SEGMENT_COORDINATES];
        configuration.copy_from_slice(&numbers.as_slice()[15 * part..15 * part + 15]);
        configuration
    };
    let object = (numbers.len() > 60).then(|| {
        let vector = |k: usize| Vector3::new(numbers[k], numbers[k + 1], numbers[k + 2]);
        let pose = |at: usize, rotation| {
            Pose::new(Isometry3::from_parts(
                Translation3::from(vector(at)),
                rotation,
            ))
        };
        ObjectEnds {
            first: pose(60, UnitQuaternion::identity()),
            last: pose(
                63,
                UnitQuaternion::from_scaled_axis(vector(66) / ROTATION_LEVER_M),
            ),
        }
    });
    EndConditions {
        first_m: part(0),
        last_m: part(1),
        first_velocity_m_s: part(2),
        last_velocity_m_s: part(3),
        object,
    }
}

/// A short layout: what is tested does not depend on the number of samples.
pub(crate) fn layout(samples: usize, object: bool) -> SegmentLayout {
    SegmentLayout {
        samples,
        rate_hz: 20.0,
        object,
    }
}

/// Segments with these boundary conditions (d x n) and deviations (rows x n), side by side in takes of
/// `per_take`.
pub(crate) fn around_smooth(
    layout: SegmentLayout,
    x: &DMatrix<f64>,
    deviations_m: &DMatrix<f64>,
    per_take: usize,
) -> Segments {
    let origins = (0..x.ncols())
        .map(|i| SegmentOrigin {
            take: i / per_take,
            start: 4 + i % per_take * layout.samples,
        })
        .collect();
    let ends = x.column_iter().map(|x| ends(&x.into_owned())).collect();
    let columns_m = SmoothCurve::Hermite.basis(layout) * x + deviations_m;
    Segments::new(layout, columns_m, origins, ends, 0)
        .expect("one origin and one pair of ends each")
}

/// Boundary conditions number `from` to `from + count` (d x n).
pub(crate) fn conditions(layout: SegmentLayout, from: usize, count: usize) -> DMatrix<f64> {
    let columns: Vec<_> = (from..from + count).map(|i| numbers(i, layout)).collect();
    DMatrix::from_columns(&columns)
}

/// Deviations (rows x n) by what each coordinate (21 with the object) of a segment does at a share
/// `s` of the way.
pub(crate) fn deviations(
    layout: SegmentLayout,
    count: usize,
    deviation_m: impl Fn(usize, usize, f64) -> f64,
) -> DMatrix<f64> {
    DMatrix::from_fn(layout.rows(), count, |row, segment| {
        let (t, coordinate) = match row.checked_sub(layout.finger_rows()) {
            None => (row / 15, row % 15),
            Some(row) => (row / 6, 15 + row % 6),
        };
        let s = t as f64 / (layout.samples - 1) as f64;
        deviation_m(segment, coordinate, s)
    })
}

/// Zero with its slope at both ends, one in the middle.
pub(crate) fn bump(s: f64) -> f64 {
    16.0 * (s * (1.0 - s)).powi(2)
}

/// Displacement of a coordinate (21 with the object) between two ends; for the object's rotation,
/// the rotation.
pub(crate) fn displacement(x: &DMatrix<f64>, segment: usize, coordinate: usize) -> f64 {
    let x = x.column(segment);
    match coordinate {
        0..15 => x[15 + coordinate] - x[coordinate],
        15..18 => x[63 + coordinate - 15] - x[60 + coordinate - 15],
        _ => x[66 + coordinate - 18],
    }
}

pub(crate) fn learn(segments: &Segments) -> Residual {
    learn_residual(segments, DEVIATION_PRIMITIVES).expect("segments that can be learned")
}

/// The deviation that is expected, metres (rows).
pub(crate) fn expected_m(residual: &Residual, x: &DVector<f64>) -> DVector<f64> {
    &residual.primitives * residual.expected_m(x)
}

/// Mean distance over fingers and samples between deviations (rows x n) and what is expected of
/// them, metres.
pub(crate) fn mean_error_m(
    residual: &Residual,
    x: &DMatrix<f64>,
    deviations_m: &DMatrix<f64>,
    weight: f64,
) -> f64 {
    let mut sum = 0.0;
    for (x, wanted) in x.column_iter().zip(deviations_m.column_iter()) {
        let error = wanted - expected_m(residual, &x.into_owned()) * weight;
        let fingers = &error.as_slice()[..residual.layout.finger_rows()];
        let points = fingers.as_chunks::<3>().0;
        sum += points.iter().map(|p| Vector3::from(*p).norm()).sum::<f64>() / points.len() as f64;
    }
    sum / x.ncols() as f64
}
