//! A planned trajectory with its proof.

use std::fmt;
use std::ops::{Index, IndexMut};

use nalgebra::{DVector, Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::finger::{Finger, PerFinger};
use crate::frame::{Hand, Object, Pose, Position};
use crate::names::named;
use crate::trajectory::Trajectory;

named! {
    /// How a solve ended.
    pub enum PlanStatus {
        /// Optimal, to the solver's full accuracy.
        Solved = "solved",
        /// Optimal, to the solver's reduced accuracy.
        AlmostSolved = "almost_solved",
        /// No activations satisfy the constraints.
        Infeasible = "infeasible",
        /// The solver stopped before either was shown.
        Failed = "failed",
    }
}

named! {
    /// A kind of constraint of a plan.
    #[derive(PartialOrd, Ord, Hash, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum ConstraintFamily {
        /// Given positions (start, goal, waypoints, object poses) where they are hard.
        Targets = "targets",
        /// Given velocities where they are hard.
        TargetVelocities = "target_velocities",
        /// Non-negative activations.
        Activations = "activations",
        /// Velocity bounds of each finger and axis.
        Velocity = "velocity",
        /// Acceleration bounds of each finger and axis.
        Acceleration = "acceleration",
        /// Fingertips inside their training hulls.
        Reachability = "reachability",
        /// Fingertips at a distance from one another.
        Separation = "separation",
        /// Holding fingers near their contact points.
        Holding = "holding",
    }
}

impl ConstraintFamily {
    /// How many families there are.
    pub const COUNT: usize = 8;

    /// Unit of the family's bounds.
    pub const fn unit(self) -> &'static str {
        match self {
            ConstraintFamily::TargetVelocities | ConstraintFamily::Velocity => "m/s",
            ConstraintFamily::Acceleration => "m/s²",
            _ => "m",
        }
    }
}

impl fmt::Display for ConstraintFamily {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// One value for each family of constraints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PerFamily<T>([T; ConstraintFamily::COUNT]);

impl<T> PerFamily<T> {
    /// Calls `make` once for each family.
    pub fn from_fn(mut make: impl FnMut(ConstraintFamily) -> T) -> Self {
        Self(ConstraintFamily::ALL.map(&mut make))
    }

    /// Families with their values.
    pub fn iter(&self) -> impl Iterator<Item = (ConstraintFamily, &T)> {
        ConstraintFamily::ALL.into_iter().zip(&self.0)
    }
}

impl<T> Index<ConstraintFamily> for PerFamily<T> {
    type Output = T;

    fn index(&self, family: ConstraintFamily) -> &T {
        &self.0[family as usize]
    }
}

impl<T> IndexMut<ConstraintFamily> for PerFamily<T> {
    fn index_mut(&mut self, family: ConstraintFamily) -> &mut T {
        &mut self.0[family as usize]
    }
}

/// By how much a family of constraints would have to give way for a problem to have a solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relaxation {
    /// The family.
    pub family: ConstraintFamily,
    /// The least by which all its bounds have to move outwards, in the family's
    /// [unit](ConstraintFamily::unit).
    pub by: f64,
    /// Whether this family alone is not enough: all relaxations of the plan are needed together.
    pub joint: bool,
}

/// Proof of optimality, recomputed over all rows of the full problem, apart from the solver.
///
/// Each residual is relative to max(1, size of its terms) in the problem's own units (mm).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Certificate {
    /// Norm of the Lagrangian's gradient.
    pub stationarity: f64,
    /// Largest violation of a constraint.
    pub primal: f64,
    /// Largest negative multiplier of an inequality.
    pub dual: f64,
    /// Largest product of a multiplier and its slack.
    pub complementarity: f64,
}

impl Certificate {
    /// The worst of the four residuals.
    pub fn worst(&self) -> f64 {
        self.stationarity
            .max(self.primal)
            .max(self.dual)
            .max(self.complementarity)
    }
}

/// What a plan's motion was checked against.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlanChecks {
    /// Bounds that hold with equality, as the multipliers say; for activations, those at zero.
    pub active: PerFamily<usize>,
    /// Largest violation over all bounds of each family, in its [unit](ConstraintFamily::unit);
    /// negative where every bound is kept with room to spare, `None` where the family is off.
    pub violation: PerFamily<Option<f64>>,
    /// Rows of all families that the certificate covers.
    pub rows: usize,
    /// Of these, the ones handed to the solver in the end.
    pub rows_taken_up: usize,
    /// Largest signed distance of the planned fingertips to their training hulls, metres: negative
    /// inside; `None` where no hulls are known.
    pub hull_distance_m: Option<f64>,
}

/// A planned trajectory with its activations and proof.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// How the solve ended.
    pub status: PlanStatus,
    /// The motion; `None` unless the status is solved or almost solved.
    pub trajectory: Option<Trajectory>,
    /// The object's motion, one `hand_from_object` a sample, where segments carry it and the target
    /// says how it is turned at first; empty otherwise.
    pub object: Vec<Pose<Hand, Object>>,
    /// What the solver chose: activations of the primitives, metres; for a smooth curve with a
    /// deviation the end conditions (m and m/s), then the activations. Empty without a trajectory.
    pub activations_m: DVector<f64>,
    /// Value of the minimised function, in the problem's own units (mm).
    pub objective: f64,
    /// Proof of optimality over all rows.
    pub certificate: Certificate,
    /// What the motion was checked against.
    pub checks: PlanChecks,
    /// Where there is no solution: by how much each family alone would have to give way for one,
    /// or all of them together where none alone is enough. Empty otherwise.
    pub relaxations: Vec<Relaxation>,
    /// Solves until no row was violated.
    pub rounds: usize,
    /// Solver iterations over all rounds.
    pub iterations: usize,
}

/// How far a motion may be from a plan, as the conditional covariance has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Corridor {
    covariance_m2: Vec<PerFinger<[[f64; 3]; 3]>>,
    /// Variances along the principal axes, and these: the same for every motion that is measured.
    axes: Vec<PerFinger<(Vector3<f64>, Matrix3<f64>)>>,
}

impl Corridor {
    /// A region from the covariance of each fingertip's position at each sample (N), m², hand frame.
    pub fn new(covariance_m2: Vec<PerFinger<[[f64; 3]; 3]>>) -> Self {
        let axes_of = |covariance: [[f64; 3]; 3]| {
            let eigen = Matrix3::from(covariance).symmetric_eigen();
            (eigen.eigenvalues, eigen.eigenvectors)
        };
        let axes = (covariance_m2.iter())
            .map(|at| PerFinger::from_fn(|finger| axes_of(at[finger])))
            .collect();
        Self {
            covariance_m2,
            axes,
        }
    }

    /// Covariance of each fingertip's position at each sample (N), m², hand frame.
    pub fn covariance_m2(&self) -> &[PerFinger<[[f64; 3]; 3]>] {
        &self.covariance_m2
    }

    /// Mahalanobis distance of a position from the plan's at sample `t`: its deviation in standard
    /// deviations. Infinite for a deviation in a direction in which there is no variance.
    ///
    /// # Panics
    ///
    /// If there is no such sample.
    pub fn mahalanobis(
        &self,
        plan: &Trajectory,
        t: usize,
        finger: Finger,
        position: Position<Hand>,
    ) -> f64 {
        let away = position.coords_m() - plan.position(t, finger).coords_m();
        let (variances, directions) = &self.axes[t][finger];
        // Variances below rounding of the largest are none.
        let least = variances.max().max(0.0) * 1e-12;
        let along = directions.tr_mul(&away);
        let squared: f64 = (along.iter().zip(variances))
            .map(|(&along, &variance)| match variance > least {
                true => along * along / variance,
                false if along.abs() <= 1e-12 => 0.0,
                false => f64::INFINITY,
            })
            .sum();
        squared.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::segments::SegmentLayout;

    #[test]
    fn distance_counts_standard_deviations_along_each_axis() {
        let layout = SegmentLayout {
            samples: 2,
            rate_hz: 10.0,
            object: false,
        };
        // Variances 1, 4 and 0 mm².
        let covariance = [[1e-6, 0.0, 0.0], [0.0, 4e-6, 0.0], [0.0; 3]];
        let corridor = Corridor::new(vec![PerFinger::from_fn(|_| covariance); 2]);
        let plan = Trajectory::new(layout, vec![0.01; 30]).unwrap();
        let distance = |x, y, z| {
            let position = Position::new(0.01 + x, 0.01 + y, 0.01 + z);
            corridor.mahalanobis(&plan, 1, Finger::Ring, position)
        };
        assert!((distance(3e-3, 0.0, 0.0) - 3.0).abs() < 1e-9);
        assert!((distance(0.0, -3e-3, 0.0) - 1.5).abs() < 1e-9);
        assert!((distance(3e-3, 8e-3, 0.0) - 5.0).abs() < 1e-9);
        assert_eq!(distance(0.0, 0.0, 0.0), 0.0);
        assert_eq!(distance(0.0, 0.0, 1e-6), f64::INFINITY);
    }
}
