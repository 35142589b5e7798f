//! Dictionaries and targets from formulas, and the plain formulation of the same problem.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus,
};
use inhand_model::{
    Configuration, Demonstrated, Dictionary, DictionaryKind, EndConditions, Hull, Learning,
    PerFinger, SEGMENT_COORDINATES, SegmentLayout, StopReason, VelocityBounds,
};
use inhand_planner::{Ends, Method, PlannerSettings, Target};
use nalgebra::{DMatrix, DVector};

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

/// The standard deviation of soft targets.
pub(crate) fn sigma_m(settings: &PlannerSettings) -> f64 {
    match settings.ends {
        Ends::Soft { sigma_m } => sigma_m,
        Ends::Hard => panic!("the plain problem has soft targets"),
    }
}

/// The problem written out plainly, mm: `1/2 hᵀ P h + qᵀ h + c`, `G h >= b`, every row present.
pub(crate) struct Plain {
    pub(crate) p: DMatrix<f64>,
    pub(crate) q: DVector<f64>,
    pub(crate) c: f64,
    pub(crate) g: DMatrix<f64>,
    pub(crate) b: DVector<f64>,
}

/// What the plain problem's solver says.
#[derive(Debug)]
pub(crate) enum Answer {
    Solved(DVector<f64>),
    Infeasible,
}

impl Plain {
    pub(crate) fn new(
        dictionary: &Dictionary,
        method: Method,
        settings: &PlannerSettings,
        ends: &EndConditions,
    ) -> Self {
        let rank = dictionary.rank();
        let w = &dictionary.primitives;
        let rows = w.nrows();
        let wanted = [ends.first_m, ends.last_m].concat();
        let all: Vec<usize> = (0..SEGMENT_COORDINATES)
            .chain(rows - SEGMENT_COORDINATES..rows)
            .collect();
        let (observed, wanted) = match method {
            Method::Paper => (&all[SEGMENT_COORDINATES..], &wanted[SEGMENT_COORDINATES..]),
            _ => (&all[..], &wanted[..]),
        };
        let a = w.select_rows(observed);
        let y = DVector::from_iterator(
            observed.len(),
            observed
                .iter()
                .zip(wanted)
                .map(|(&row, value)| (value - dictionary.offset_m[row]) * 1e3),
        );
        let (weight, precision, mean) = match method {
            Method::Paper => (
                1.0,
                DMatrix::identity(rank, rank) * settings.ridge,
                DVector::zeros(rank),
            ),
            _ => (
                (sigma_m(settings) * 1e3).powi(-2),
                (&dictionary.activation_covariance_m2 * 1e6)
                    .try_inverse()
                    .expect("the covariance is regular"),
                &dictionary.activation_mean_m * 1e3,
            ),
        };
        let p = &precision + a.transpose() * &a * weight;
        let q = -(&precision * &mean) - a.transpose() * &y * weight;
        let c = 0.5 * (mean.dot(&(&precision * &mean)) + weight * y.dot(&y));

        let velocity_bounds = settings
            .constraints
            .velocity
            .expect("the plain problem has them");
        let signed = if dictionary.kind == DictionaryKind::Nmf {
            rank
        } else {
            0
        };
        let steps = rows - SEGMENT_COORDINATES;
        let mut g = DMatrix::zeros(signed + 2 * steps, rank);
        let mut b = DVector::zeros(signed + 2 * steps);
        for i in 0..signed {
            g[(i, i)] = 1.0;
        }
        for row in 0..steps {
            let coordinate = row % SEGMENT_COORDINATES;
            let rate = dictionary.layout.rate_hz;
            let normal = w.row(row + SEGMENT_COORDINATES) - w.row(row);
            let base =
                (dictionary.offset_m[row + SEGMENT_COORDINATES] - dictionary.offset_m[row]) * 1e3;
            let lower = velocity_bounds.min_m_s[coordinate] * 1e3 / rate;
            let upper = velocity_bounds.max_m_s[coordinate] * 1e3 / rate;
            g.row_mut(signed + 2 * row).copy_from(&normal);
            b[signed + 2 * row] = lower - base;
            g.row_mut(signed + 2 * row + 1).copy_from(&-normal);
            b[signed + 2 * row + 1] = base - upper;
        }
        Self { p, q, c, g, b }
    }

    pub(crate) fn objective(&self, h_mm: &DVector<f64>) -> f64 {
        0.5 * h_mm.dot(&(&self.p * h_mm)) + self.q.dot(h_mm) + self.c
    }

    /// Clarabel on dense matrices, without any of the planner's shortcuts.
    pub(crate) fn solve(&self) -> Answer {
        let csc = |m: &DMatrix<f64>, upper: bool| {
            let (mut starts, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
            for j in 0..m.ncols() {
                let end = if upper { j + 1 } else { m.nrows() };
                indices.extend(0..end);
                values.extend(m.column(j).iter().take(end));
                starts.push(indices.len());
            }
            CscMatrix::new(m.nrows(), m.ncols(), starts, indices, values)
        };
        let settings = DefaultSettingsBuilder::default()
            .verbose(false)
            .tol_gap_abs(1e-11)
            .tol_gap_rel(1e-11)
            .tol_feas(1e-11)
            .build()
            .expect("the tolerances are in range");
        let right: Vec<f64> = self.b.iter().map(|b| -b).collect();
        let mut solver = DefaultSolver::new(
            &csc(&self.p, true),
            self.q.as_slice(),
            &csc(&-&self.g, false),
            &right,
            &[NonnegativeConeT(self.b.len())],
            settings,
        )
        .expect("the sizes fit");
        solver.solve();
        match solver.solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => {
                Answer::Solved(DVector::from_column_slice(&solver.solution.x))
            }
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => {
                Answer::Infeasible
            }
            status => panic!("the plain problem ended with {status:?}"),
        }
    }
}
