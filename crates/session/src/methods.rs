//! The methods that are compared, by name. A new one is a variant with a curve, or with an arm in
//! `steps::generate::planner`, and a colour in `channels::colour`.

use std::fmt;
use std::str::FromStr;

use inhand_curves::curves;
use inhand_model::{EndConditions, SegmentLayout, Trajectory};
use serde::{Deserialize, Serialize};

use crate::error::{SessionError, invalid};

/// A way to make motion between given ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// The best of the others on left-out training takes; named in place of one of them, never runs itself.
    Auto,
    /// Learned: ends and end velocities given, the deviation from the smooth curve expected from
    /// the demonstrations.
    Residual,
    /// Learned: start and end given, activation mean and covariance as prior.
    Prior,
    /// Learned: end only, as the paper prints it.
    Paper,
    /// Stay at the final configuration.
    Hold,
    /// Straight line.
    Line,
    /// Minimum jerk.
    MinimumJerk,
    /// Cubic with end velocities.
    Hermite,
}

impl Method {
    /// Every method that runs, learned ones first.
    pub const ALL: [Method; 7] = [
        Method::Residual,
        Method::Prior,
        Method::Paper,
        Method::Hermite,
        Method::MinimumJerk,
        Method::Line,
        Method::Hold,
    ];

    /// Name in files and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Method::Auto => "auto",
            Method::Residual => "residual",
            Method::Prior => "prior",
            Method::Paper => "paper",
            Method::Hold => "hold",
            Method::Line => "line",
            Method::MinimumJerk => "minimum_jerk",
            Method::Hermite => "hermite",
        }
    }

    /// What it knows and does, in a line.
    pub const fn description(self) -> &'static str {
        match self {
            Method::Auto => "the best on left-out training takes",
            Method::Residual => "curve + learned deviation",
            Method::Prior => "learned prior, ends given",
            Method::Paper => "end given, as published",
            Method::Hold => "stays at end, no learning",
            Method::Line => "straight, no learning",
            Method::MinimumJerk => "minimum jerk, no learning",
            Method::Hermite => "cubic, no learning",
        }
    }

    /// Whether it uses demonstrations.
    pub const fn is_learned(self) -> bool {
        matches!(
            self,
            Method::Auto | Method::Residual | Method::Prior | Method::Paper
        )
    }

    /// The smooth curve, for methods that learn nothing.
    pub fn curve(self, ends: &EndConditions, layout: SegmentLayout) -> Option<Trajectory> {
        match self {
            Method::Auto | Method::Residual | Method::Prior | Method::Paper => None,
            Method::Hold => Some(curves::hold(ends, layout)),
            Method::Line => Some(curves::line(ends, layout)),
            Method::MinimumJerk => Some(curves::minimum_jerk(ends, layout)),
            Method::Hermite => Some(curves::hermite(ends, layout)),
        }
    }
}

/// Viewers distinguish methods by colour: each has one of its own.
const _: () = assert!(Method::ALL.len() <= inhand_channels::METHOD_COLOURS.len());

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Method {
    type Err = SessionError;

    fn from_str(name: &str) -> Result<Self, SessionError> {
        let mut known = std::iter::once(Method::Auto).chain(Method::ALL);
        known.find(|method| method.name() == name).ok_or_else(|| {
            let names = Method::ALL.map(Method::name).join(", ");
            invalid("plan.methods", &format!("auto, {names}"), &name)
        })
    }
}
