//! Fingertip trajectories that reach targets, from a dictionary by convex optimisation.

mod active_set;
mod certificate;
mod cholesky;
mod error;
mod interior_point;
mod method;
mod objective;
mod planner;
mod target;
mod velocity;

pub use error::PlanError;
pub use method::{Backend, Method, PlannerSettings, widened};
pub use planner::{Planner, plan_all};
pub use target::Target;
