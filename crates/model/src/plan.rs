//! A planned trajectory with its proof.

use nalgebra::DVector;

use crate::trajectory::Trajectory;

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanStatus {
    /// Optimal, to the solver's full accuracy.
    Solved,
    /// Optimal, to the solver's reduced accuracy.
    AlmostSolved,
    /// No activations satisfy the constraints.
    Infeasible,
    /// The solver stopped before either was shown.
    Failed,
}

impl PlanStatus {
    /// Lower-case name, as in files.
    pub const fn name(self) -> &'static str {
        match self {
            PlanStatus::Solved => "solved",
            PlanStatus::AlmostSolved => "almost_solved",
            PlanStatus::Infeasible => "infeasible",
            PlanStatus::Failed => "failed",
        }
    }
}

/// How many bounds hold with equality at the solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ActiveBounds {
    /// Velocity bounds.
    pub velocity: usize,
    /// Activations at zero.
    pub activation: usize,
}

/// Proof of optimality, recomputed over all rows of the full problem, apart from the solver.
///
/// Each residual is relative to max(1, size of its terms) in the problem's own units (mm).
#[derive(Clone, Copy, Debug, PartialEq)]
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

/// A planned trajectory with its activations and proof.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// How the solve ended.
    pub status: PlanStatus,
    /// The motion; `None` unless the status is solved or almost solved.
    pub trajectory: Option<Trajectory>,
    /// Activations of the primitives, metres; empty without a trajectory.
    pub activations_m: DVector<f64>,
    /// Value of the minimised function, in the problem's own units (mm).
    pub objective: f64,
    /// Proof of optimality over all rows.
    pub certificate: Certificate,
    /// Bounds that hold with equality.
    pub active: ActiveBounds,
    /// Velocity rows handed to the solver in the end.
    pub velocity_rows: usize,
    /// Solves until no velocity bound was violated.
    pub rounds: usize,
    /// Solver iterations over all rounds.
    pub iterations: usize,
}
