//! Dictionaries, residuals and targets from formulas.

use inhand_model::{
    Bandwidths, Configuration, Demonstrated, DeviationPredictor, Dictionary, DictionaryKind,
    EndConditions, Hull, Learning, PerFinger, PredictorWeights, Residual, SEGMENT_COORDINATES,
    SegmentLayout, SmoothCurve, StopReason, Validation, VelocityBounds, ends_len,
};
use inhand_planner::{Ends, Method, PlannerSettings, Target};
use nalgebra::{DMatrix, DVector};

use super::plain::{Gaussian, Plain, Rows};

/// A dictionary of the given parts, everything else neutral.
pub(crate) fn dictionary(
    kind: DictionaryKind,
    layout: SegmentLayout,
    offset_m: DVector<f64>,
    primitives: DMatrix<f64>,
    mean_m: DVector<f64>,
    covariance_m2: DMatrix<f64>,
) -> Dictionary {
    Dictionary {
        kind,
        layout,
        offset_m,
        primitives,
        activation_mean_m: mean_m,
        activation_covariance_m2: covariance_m2,
        covariance_shrinkage: 0.0,
        learning: Learning {
            segments: 0,
            rms_m: 0.0,
            relative_error: 0.0,
            iterations: 0,
            stop_reason: StopReason::ClosedForm,
            objective_history_m2: Vec::new(),
            seed: 0,
            restarts: vec![],
        },
        demonstrated: Demonstrated {
            hulls: PerFinger::from_fn(|_| Hull {
                vertices_m: Vec::new(),
                triangles: Vec::new(),
                normals: Vec::new(),
                offsets_m: Vec::new(),
            }),
            velocity: bounds(1.0),
        },
        residual: None,
        residual_held_out: None,
        choice: None,
    }
}

/// The dictionary of `tests/reference/solve_with_quadprog.py`: smooth positive primitives over one
/// second, activations of some centimetres that vary together.
pub(crate) fn smooth(kind: DictionaryKind, samples: usize, rank: usize) -> Dictionary {
    let layout = SegmentLayout {
        samples,
        rate_hz: samples as f64,
        object: false,
    };
    let mut primitives = DMatrix::from_fn(layout.rows(), rank, |row, k| {
        let t = (row / SEGMENT_COORDINATES) as f64 / samples as f64;
        let (c, k) = ((row % SEGMENT_COORDINATES) as f64, k as f64);
        let wave = 1.0 + (std::f64::consts::TAU * (0.3 + 0.11 * k) * t + 0.7 * k + c).sin();
        wave * (1.1 + (0.9 * c * (k + 1.0)).cos())
    });
    for mut column in primitives.column_iter_mut() {
        let length = column.norm();
        column /= length;
    }
    let offset_m = DVector::from_fn(layout.rows(), |row, _| {
        0.01 * ((row % SEGMENT_COORDINATES) as f64 + 1.0).sin()
    });
    let mean_m = DVector::from_fn(rank, |k, _| 0.03 + 0.02 * (1.7 * k as f64).sin());
    let covariance_m2 = DMatrix::from_fn(rank, rank, |i, j| {
        let (i, j) = (i as f64, j as f64);
        let own = if i == j { 2e-4 } else { 0.0 };
        let shared =
            3e-4 * (0.5 * i).sin() * (0.5 * j).sin() + 2e-4 * (1.3 * i).cos() * (1.3 * j).cos();
        own + shared
    });
    dictionary(kind, layout, offset_m, primitives, mean_m, covariance_m2)
}

/// End configurations that activations off the mean would make; larger `case`, larger `reach`:
/// farther.
pub(crate) fn ends(dictionary: &Dictionary, case: usize, reach: f64) -> EndConditions {
    let case = case as f64;
    let at = |row: usize, phase: f64| -> Configuration {
        std::array::from_fn(|c| {
            let mean: f64 = dictionary
                .primitives
                .row(row + c)
                .iter()
                .zip(dictionary.activation_mean_m.iter())
                .map(|(w, h)| w * h)
                .sum();
            dictionary.offset_m[row + c] + mean + reach * (1.3 * c as f64 + phase + case).sin()
        })
    };
    let last = dictionary.layout.rows() - SEGMENT_COORDINATES;
    EndConditions {
        first_m: at(0, 0.0),
        last_m: at(last, 2.0),
        first_velocity_m_s: [0.0; SEGMENT_COORDINATES],
        last_velocity_m_s: [0.0; SEGMENT_COORDINATES],
        object: None,
    }
}

/// What a method is given of [`ends`].
pub(crate) fn target(method: Method, dictionary: &Dictionary, case: usize, reach: f64) -> Target {
    method.target(&ends(dictionary, case, reach))
}

/// The same bounds for every coordinate, m/s.
pub(crate) fn bounds(size_m_s: f64) -> VelocityBounds {
    VelocityBounds {
        min_m_s: [-size_m_s; SEGMENT_COORDINATES],
        max_m_s: [size_m_s; SEGMENT_COORDINATES],
    }
}

/// Default numbers with the given velocity bounds.
pub(crate) fn settings(velocity_bounds: VelocityBounds) -> PlannerSettings {
    PlannerSettings::new(velocity_bounds)
}

/// A dictionary that can do any motion: its activations are the trajectory's coordinates, metres.
/// Each coordinate moves smoothly about its mean of `at(coordinate)`, by about 20 mm, coordinates by
/// themselves but for half a millimetre that neighbours share.
pub(crate) fn free(samples: usize, rate_hz: f64, at: impl Fn(usize) -> f64) -> Dictionary {
    let layout = SegmentLayout {
        samples,
        rate_hz,
        object: false,
    };
    let rows = layout.rows();
    let place = |row: usize| (row / SEGMENT_COORDINATES, row % SEGMENT_COORDINATES);
    dictionary(
        DictionaryKind::Pca,
        layout,
        DVector::zeros(rows),
        DMatrix::identity(rows, rows),
        DVector::from_fn(rows, |row, _| at(place(row).1)),
        DMatrix::from_fn(rows, rows, |i, j| {
            let ((t, a), (u, b)) = (place(i), place(j));
            let lag = (t as f64 - u as f64) / samples as f64;
            let smooth = (-0.5 * (lag / 0.4).powi(2)).exp();
            let own = if a == b { 4e-4 * smooth } else { 0.0 };
            let shared = if a / 3 == b / 3 { 2.5e-7 * smooth } else { 0.0 };
            let white = if i == j { 1e-6 } else { 0.0 };
            own + shared + white
        }),
    )
}

/// A smooth curve with a deviation of `rank` primitives, from formulas: end conditions of some
/// centimetres that vary together, deviations that vanish at both ends.
pub(crate) fn residual(samples: usize, rank: usize, object: bool) -> Residual {
    let layout = SegmentLayout {
        samples,
        rate_hz: samples as f64,
        object,
    };
    let ends = ends_len(layout);
    let mut primitives = DMatrix::from_fn(layout.rows(), rank, |row, k| {
        let (t, c) = match row.checked_sub(layout.finger_rows()) {
            None => (row / SEGMENT_COORDINATES, row % SEGMENT_COORDINATES),
            Some(row) => (row / 6, 15 + row % 6),
        };
        let s = t as f64 / (samples - 1) as f64;
        let (c, k) = (c as f64, k as f64);
        s * s * (1.0 - s).powi(2) * (std::f64::consts::PI * (k + 1.0) * s + c * (k + 0.7)).sin()
            + 0.3 * s * (1.0 - s) * (1.7 * c + 2.3 * k).sin()
    });
    if rank > 0 {
        primitives = primitives.qr().q();
    }
    let wave = |i: usize, j: usize| ((1.3 * i as f64 + 0.4) * (0.7 * j as f64 + 0.3)).sin();
    let spread = |n: usize, size: f64, own: f64| {
        let factor = DMatrix::from_fn(n, n, |i, j| wave(i, j) * size / (n as f64).sqrt());
        &factor * factor.transpose() + DMatrix::identity(n, n) * own * own
    };
    let mut ends_covariance = spread(ends, 0.02, 0.004);
    // Velocities vary by five times the number that positions do.
    let velocity = |i: usize| if (30..60).contains(&i) { 5.0 } else { 1.0 };
    for i in 0..ends {
        for j in 0..ends {
            ends_covariance[(i, j)] *= velocity(i) * velocity(j);
        }
    }
    let fingers = [0, 1, 2, 3, 4].map(|f| (rank * (f + 1)) / 5 - (rank * f) / 5);
    let mut blocks = fingers.to_vec();
    if object {
        blocks.push(0);
    }
    let expectation = DeviationPredictor::new(
        layout,
        blocks,
        DMatrix::from_fn(rank, ends, |i, j| 0.02 * wave(i + 3, j)),
        DMatrix::zeros(ends, 0),
        DMatrix::zeros(rank, 0),
    )
    .weighted(
        Bandwidths {
            hand: 1.0,
            finger: 1.0,
        },
        PredictorWeights {
            profile: 1.0,
            hand: 0.0,
            finger: 0.0,
        },
    );
    Residual {
        layout,
        curve: SmoothCurve::Hermite,
        ends_mean: DVector::from_fn(ends, |i, _| 0.01 * (0.9 * i as f64).sin()),
        ends_covariance,
        primitives,
        expectation,
        covariance_m2: spread(rank, 0.01, 0.001),
        unexplained_m2: 4e-8,
        calibration: Vec::new(),
        validation: Validation {
            folds: 0,
            segments: 0,
            smooth_error_m: 0.0,
            error_m: 0.0,
            standard_error_m: 0.0,
        },
    }
}

/// The standard deviation of soft targets.
pub(crate) fn sigma_m(settings: &PlannerSettings) -> f64 {
    match settings.ends {
        Ends::Soft { sigma_m } => sigma_m,
        Ends::Hard => panic!("the plain problem has soft targets"),
    }
}

/// What a method is given of end conditions, under velocity bounds, written out plainly.
pub(crate) fn plain(
    dictionary: &Dictionary,
    method: Method,
    settings: &PlannerSettings,
    ends: &EndConditions,
) -> Plain {
    let gaussian = Gaussian::of_dictionary(dictionary);
    let (rows, wanted) = gaussian.ends(ends);
    let mut plain = match method {
        Method::Paper => {
            let mut plain = Plain::with_ridge(&gaussian, settings.ridge);
            let last = Rows {
                factors: rows.factors.rows(15, 15).into_owned(),
                base: rows.base.rows(15, 15).into_owned(),
            };
            plain.soft(&last, &wanted.rows(15, 15).into_owned(), 1.0);
            plain
        }
        _ => {
            let mut plain = Plain::new(&gaussian);
            plain.soft(&rows, &wanted, sigma_m(settings) * 1e3);
            plain
        }
    };
    let velocity = settings.constraints.velocity.expect("there are bounds");
    plain.between(
        &gaussian.differences(1),
        &velocity.min_m_s.map(|v| v * 1e3),
        &velocity.max_m_s.map(|v| v * 1e3),
    );
    plain
}
