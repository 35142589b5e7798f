//! Errors of building a planner and of planning.

use inhand_model::{DictionaryError, Finger, TrajectoryError};
use thiserror::Error;

/// Why a planner cannot be built, or a target cannot be planned to.
///
/// A problem that has no solution is no error: it comes back as a plan with the status
/// [`Infeasible`](inhand_model::PlanStatus::Infeasible).
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The dictionary's parts do not fit together.
    #[error(transparent)]
    Dictionary(#[from] DictionaryError),
    /// The dictionary has no primitive to plan with.
    #[error("the dictionary has no primitives: planning needs at least one")]
    NoPrimitives,
    /// Segments too short for a velocity, or without a usable rate.
    #[error(
        "the dictionary's segments have {samples} samples at {rate_hz} Hz: \
         planning needs at least 2 samples and a positive rate"
    )]
    Layout {
        /// Samples in a segment.
        samples: usize,
        /// Samples per second.
        rate_hz: f64,
    },
    /// A setting outside its range.
    #[error("planner setting {name} is {value}: expected {expected}")]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// The value found.
        value: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// Velocity bounds that nothing satisfies, or that are no numbers.
    #[error(
        "velocity bounds of {finger}, axis {axis}, run from {min_m_s} to {max_m_s} m/s: \
         expected two numbers, the first not above the second"
    )]
    VelocityBounds {
        /// The finger.
        finger: Finger,
        /// 0 = x.
        axis: usize,
        /// Lower bound, m/s.
        min_m_s: f64,
        /// Upper bound, m/s.
        max_m_s: f64,
    },
    /// Acceleration bounds that nothing satisfies, or that are no numbers.
    #[error(
        "acceleration bounds of {finger}, axis {axis}, run from {min_m_s2} to {max_m_s2} m/s²: \
         expected two numbers, the first not above the second"
    )]
    AccelerationBounds {
        /// The finger.
        finger: Finger,
        /// 0 = x.
        axis: usize,
        /// Lower bound, m/s².
        min_m_s2: f64,
        /// Upper bound, m/s².
        max_m_s2: f64,
    },
    /// Reachability without a hull to reach within.
    #[error(
        "reachability needs the training hull of every finger, and that of {finger} has no faces: \
         give hulls in the settings, or switch reachability off"
    )]
    NoHull {
        /// The finger.
        finger: Finger,
    },
    /// A part of another size.
    #[error("{what} is {found}, expected {expected}")]
    Shape {
        /// Which size.
        what: &'static str,
        /// The size it should have.
        expected: usize,
        /// The size it has.
        found: usize,
    },
    /// A part with a number that is none.
    #[error("the {what} to plan with hold {value}: expected finite numbers")]
    NotFinite {
        /// Which part.
        what: &'static str,
        /// The number found.
        value: f64,
    },
    /// A covariance cannot be inverted.
    #[error(
        "the covariance of the {order} {what} is not positive definite \
         (smallest eigenvalue {smallest_m2:e} m²): learn with shrinkage, fewer primitives or more segments"
    )]
    Covariance {
        /// Of what.
        what: &'static str,
        /// Of how many.
        order: usize,
        /// Smallest eigenvalue, m².
        smallest_m2: f64,
    },
    /// Targets so sharp that rounding leaves no problem to solve.
    #[error(
        "the problem of {unknowns} unknowns cannot be factorised: \
         allow targets a larger standard deviation, or make them hard"
    )]
    Conditioning {
        /// Number of unknowns.
        unknowns: usize,
    },
    /// A target with a number that is none, or that no hand reaches.
    #[error(
        "target: {what} of {finger}, axis {axis}, is {value}: \
         expected a number of at most {limit} in size (metres and seconds)"
    )]
    Target {
        /// Which part of the target.
        what: &'static str,
        /// The finger.
        finger: Finger,
        /// 0 = x.
        axis: usize,
        /// The value found.
        value: f64,
        /// The largest size it may have.
        limit: f64,
    },
    /// A pose of the object with a number that is none, or that no hand reaches.
    #[error("target: {what} holds {value}: expected numbers of at most {limit} in size (metres)")]
    ObjectTarget {
        /// Which pose.
        what: &'static str,
        /// The value found.
        value: f64,
        /// The largest size it may have, metres.
        limit: f64,
    },
    /// A target that gives nothing.
    #[error("the target gives nothing to reach: give at least one position, velocity or pose")]
    NothingGiven,
    /// A waypoint outside the segment.
    #[error("a waypoint lies at {time_s} s: expected a time from 0 to {duration_s} s")]
    WaypointTime {
        /// Time of the waypoint, seconds.
        time_s: f64,
        /// Time of the last sample, seconds.
        duration_s: f64,
    },
    /// Two positions of one finger at one sample.
    #[error(
        "target: {one} and {other} want {finger} at {one_m:?} and at {other_m:?} m \
         at the same sample {sample} ({time_s} s): expected one position"
    )]
    Contradiction {
        /// The finger.
        finger: Finger,
        /// The sample.
        sample: usize,
        /// Its time, seconds.
        time_s: f64,
        /// One part of the target.
        one: &'static str,
        /// Where it wants the finger, metres.
        one_m: [f64; 3],
        /// The other part.
        other: &'static str,
        /// Where that wants it, metres.
        other_m: [f64; 3],
    },
    /// Two velocities of one finger at one sample.
    #[error(
        "target: {finger} is wanted to move at {one_m_s:?} and at {other_m_s:?} m/s \
         from the same sample {sample} ({time_s} s) on: expected one velocity"
    )]
    VelocityContradiction {
        /// The finger.
        finger: Finger,
        /// The sample.
        sample: usize,
        /// Its time, seconds.
        time_s: f64,
        /// One velocity, m/s.
        one_m_s: [f64; 3],
        /// The other.
        other_m_s: [f64; 3],
    },
    /// A pose of the object, but segments without it.
    #[error(
        "the target gives a pose of the object, which is not in these segments: \
         learn from takes that track it, or leave the object out of the target"
    )]
    NoObject,
    /// The object's last pose without the first.
    #[error(
        "the target gives the object's last pose and not its first: segments know how far it \
         turns from the first, so give both"
    )]
    ObjectStart,
    /// Holding without a finger that holds.
    #[error("holding needs a contact point of at least one finger, and there is none")]
    NobodyHolds,
    /// Too few fingers in contact at both ends.
    #[error(
        "{held} fingers hold the object at start and goal, {needed} are needed: {distances} \
         (in contact within {tau_m} m)"
    )]
    TooFewHold {
        /// Fingers that do.
        held: usize,
        /// Fingers needed.
        needed: usize,
        /// Contact distance, metres.
        tau_m: f64,
        /// Distances of every finger at start and goal.
        distances: String,
    },
    /// A corridor of a method that is no distribution.
    #[error(
        "the method paper has no corridor: its ridge makes the solution unique and says nothing \
         about how demonstrations vary"
    )]
    NoCorridor,
    /// Knots that make no chain.
    #[error("knot {knot} at {time_s} s: expected {expected}")]
    Knots {
        /// Which one, counted from 0.
        knot: usize,
        /// What was expected.
        expected: String,
        /// Its time, seconds.
        time_s: f64,
    },
    /// A knot with a position or velocity that cannot be.
    #[error("knot {knot} at {time_s} s: {source}")]
    Knot {
        /// Which one, counted from 0.
        knot: usize,
        /// Its time, seconds.
        time_s: f64,
        /// What is wrong with it.
        source: Box<PlanError>,
    },
    /// A segment of a chain that cannot be planned.
    #[error("segment {segment} of the chain, from {start_s} s on: {source}")]
    Segment {
        /// Which one, counted from 0.
        segment: usize,
        /// When it starts, seconds since the start.
        start_s: f64,
        /// Why not.
        source: Box<PlanError>,
    },
    /// Segments too short for a chain.
    #[error("segments of {samples} samples make no chain: expected at least 3")]
    TooShortToChain {
        /// Samples in a segment.
        samples: usize,
    },
    /// Planning anew where nothing is left to be planned, or before the start.
    #[error("planning anew at {time_s} s: expected a time from 0 to {limit_s} s")]
    Elapsed {
        /// The time, seconds since the first sample.
        time_s: f64,
        /// Time of the last sample but one, seconds.
        limit_s: f64,
    },
    /// A word that names no method.
    #[error("unknown planning method \"{name}\": expected one of {expected}")]
    UnknownMethod {
        /// The word found.
        name: String,
        /// The names there are.
        expected: String,
    },
    /// The solver returned numbers that make no trajectory.
    #[error("the solver's answer is no trajectory: {0}")]
    Trajectory(#[from] TrajectoryError),
}
