//! Errors of hulls and contact phases.

use thiserror::Error;

/// Reasons why a convex hull cannot be made, or contacts cannot be judged.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ContactError {
    /// Fewer points than a solid has corners.
    #[error("a hull needs at least 4 points: found {found}")]
    TooFewPoints {
        /// Points found.
        found: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error(
        "{not_finite} of {points} points have a coordinate that is not finite, the first is point {first}: leave missing samples out"
    )]
    NotFinite {
        /// Points given.
        points: usize,
        /// How many of them are not finite.
        not_finite: usize,
        /// Index of the first of those.
        first: usize,
    },
    /// A coordinate beyond any capture volume, most likely another unit.
    #[error(
        "point {first} has a coordinate of {found_m} m: expected at most {limit_m} m, are the units right?"
    )]
    TooFar {
        /// Index of the first such point.
        first: usize,
        /// Its largest coordinate by size, metres.
        found_m: f64,
        /// The largest size allowed, metres.
        limit_m: f64,
    },
    /// All points lie in one plane, on one line or in one place.
    #[error(
        "{points} points span no solid: {extent_m} m long but only {thickness_m} m thick, expected at least {needed_m} m"
    )]
    Flat {
        /// Points given.
        points: usize,
        /// Distance of the two points chosen farthest apart, metres.
        extent_m: f64,
        /// Farthest distance of a point from the plane through the largest triangle found, metres.
        thickness_m: f64,
        /// The least thickness accepted, metres.
        needed_m: f64,
    },
    /// The surface did not close, or it leaves a point outside: numbers so small that they underflow.
    #[error(
        "the hull of {points} points is inconsistent ({corners} corners, {triangles} triangles, {outside_m} m outside): scale the points"
    )]
    Inconsistent {
        /// Points given.
        points: usize,
        /// Corners found.
        corners: usize,
        /// Triangles found.
        triangles: usize,
        /// Farthest distance of a point outside the surface, metres; NaN if there is no surface.
        outside_m: f64,
    },
    /// Samples per second that are not a positive number.
    #[error("contacts at {found_hz} Hz: expected a positive number of samples per second")]
    Rate {
        /// What was given, Hz.
        found_hz: f64,
    },
    /// A duration that is negative or not finite.
    #[error("{name} is {found_s} s: expected 0 or more")]
    Duration {
        /// Name of the setting.
        name: &'static str,
        /// What was given, seconds.
        found_s: f64,
    },
    /// A grasp of no finger or of more than a hand has.
    #[error("a grasp of {found} fingers: expected min_fingers from 1 to 5")]
    MinFingers {
        /// What was given.
        found: usize,
    },
}
