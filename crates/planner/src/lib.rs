//! Fingertip trajectories that reach targets, from demonstrations by convex optimisation.
//!
//! The motion of a segment is a linear function of unknowns, of which demonstrations say what to
//! expect:
//!
//! ```text
//! v = base + W h,    h ~ N(mu, Λ⁻¹)
//! ```
//!
//! For a [`Dictionary`](inhand_model::Dictionary) `W` are its primitives and `h` their activations;
//! for a [`Residual`](inhand_model::Residual) `W = [S | B]`, smooth curves through end conditions
//! and primitives of the deviation from them. Planning chooses the `h` that reach what a [`Target`]
//! gives and otherwise stay close to the demonstrations:
//!
//! ```text
//! minimise  1/2 sum_i (a_i h - y_i)² / sigma_i² + 1/2 (h - mu)ᵀ Λ (h - mu)
//! s.t.      a_i h = y_i                                   (instead, where targets are hard)
//!           h >= 0                                        (NMF dictionaries)
//!           bounds on velocity and acceleration, fingertips inside hulls, apart from one another,
//!           near contact points                           (as the settings and the target say)
//! ```
//!
//! * [`Planner::new`] with [`Method::Prior`] takes mean and covariance of a dictionary's
//!   activations; [`Method::Paper`] is the problem of Hammoud et al., *In-hand manipulation planning
//!   using human motion dictionary* (arXiv 2308.15153), as printed there; [`Planner::residual`]
//!   plans with deviations from the smooth curve.
//! * [`Target`]: start and goal, velocities there, waypoints, the object's poses, holding fingers;
//!   any part on any of the fingers. [`Ends`] says whether it is meant softly or exactly.
//! * [`Constraints`]: of their thousands of rows, hardly any is ever active. They are activated only
//!   where they are violated.
//! * Every [`Plan`](inhand_model::Plan) carries a certificate: the residuals of the optimality
//!   conditions over all rows, recomputed apart from the solver. Where there is no solution, it says
//!   which constraints would have to be relaxed and by how much.
//! * [`plan_chain`]: motion through knots, over as many segments as it takes. [`replan`]: what is
//!   left of a motion, from a state that is not the planned one.
//! * [`Planner::corridor`]: prediction region (95 %) of the motion around the plan, as the conditional covariance has
//!   it.
//!
//! ```
//! use inhand_model::PlanStatus;
//! use inhand_planner::{Method, Planner, PlannerSettings, Target, widened};
//! # use inhand_model::*;
//! # use nalgebra::{DMatrix, DVector};
//! # // Two positive primitives, one falling, one rising, over half a second.
//! # let layout = SegmentLayout { samples: 50, rate_hz: 100.0, object: false };
//! # let rise = |row: usize| (row / 15) as f64 / 49.0;
//! # let mut primitives = DMatrix::from_fn(layout.rows(), 2, |row, k| if k == 0 { 1.0 - rise(row) } else { rise(row) });
//! # for mut column in primitives.column_iter_mut() { column /= column.norm(); }
//! # let hull = Hull { vertices_m: vec![], triangles: vec![], normals: vec![], offsets_m: vec![] };
//! # let dictionary = Dictionary {
//! #     kind: DictionaryKind::Nmf, layout, offset_m: DVector::zeros(layout.rows()), primitives,
//! #     activation_mean_m: DVector::repeat(2, 0.5), activation_covariance_m2: DMatrix::identity(2, 2) * 0.01,
//! #     covariance_shrinkage: 0.0,
//! #     learning: Learning { segments: 0, rms_m: 0.0, relative_error: 0.0, iterations: 0,
//! #         stop_reason: StopReason::ClosedForm, objective_history_m2: vec![], seed: 0,
//! #         restarts: vec![] },
//! #     demonstrated: Demonstrated { hulls: PerFinger::from_fn(|_| hull.clone()),
//! #         velocity: VelocityBounds { min_m_s: [-0.2; 15], max_m_s: [0.2; 15] } },
//! #     residual: None, residual_held_out: None, choice: None,
//! # };
//! // `dictionary` was learned or read before.
//! let settings = PlannerSettings::new(widened(
//!     &dictionary.demonstrated.velocity,
//!     PlannerSettings::VELOCITY_FACTOR,
//! ));
//! let planner = Planner::new(&dictionary, Method::Prior, &settings)?;
//! let plan = planner.plan(&Target::new().first([0.030; 15]).last([0.042; 15]))?;
//!
//! assert_eq!(plan.status, PlanStatus::Solved);
//! assert!(plan.certificate.worst() < 1e-6);
//! let trajectory = plan.trajectory.expect("a solved plan has one");
//! assert!((trajectory.configuration_m(49)[0] - 0.042).abs() < 1e-5);
//! # Ok::<(), inhand_planner::PlanError>(())
//! ```
//!
//! `examples/plan.rs` loads a dictionary from its file, plans to a target, chains segments and plans
//! anew: `cargo run --release -p inhand-planner --example plan -- out/dictionary.mcap`.
//!
//! Reading order: `method` and `settings` (problems, backends, numbers), `target` with `target_values` (pattern
//! and values of what it gives), `model` with `basis`, `precision` and `completion` (motion as a linear
//! function of unknowns), `problem` with `equality` (what is minimised), `rows` (constraints on the
//! motion, family by family), `solve` (rows activated as needed, answers judged), `active_set` with
//! `cholesky` (the default solver), `interior_point` (Clarabel), `explain` (what would have to be relaxed),
//! `outcome` (the plan), `object`, `planner`, `chain` with `spline`.
//!
//! This is the only crate that knows Clarabel. It knows no files and no recordings.

mod active_set;
mod basis;
mod chain;
mod cholesky;
mod completion;
mod equality;
mod error;
mod explain;
mod hold;
mod interior_point;
mod method;
mod model;
mod object;
mod outcome;
mod planner;
mod precision;
mod problem;
mod rows;
mod settings;
mod solve;
mod spline;
mod target;
mod target_values;

pub use chain::{Chain, Knot, plan_chain, replan};
pub use error::PlanError;
pub use hold::Hold;
pub use method::{Backend, Method};
pub use object::{held_fingers, object_between};
pub use outcome::worst_hull_distance_m;
pub use planner::{Planner, plan_all};
pub use settings::{AccelerationBounds, Constraints, Ends, PlannerSettings, widened};
pub use target::{Holding, Target, Tips, Waypoint};

/// Lengths inside the crate are millimetres, outside metres.
pub(crate) const MM_PER_M: f64 = 1e3;
