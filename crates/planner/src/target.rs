//! What a plan has to reach.

use inhand_model::{Configuration, EndConditions, Finger};

use crate::error::PlanError;

/// Farther from the hand than any fingertip, metres. Catches targets in millimetres.
const FARTHEST_M: f64 = 10.0;

/// What a plan has to reach: the configurations at both ends and the velocities there, hand frame.
/// A method uses the parts it is defined for and does not look at the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    ends: EndConditions,
}

impl Target {
    /// The end conditions, metres and m/s.
    pub const fn ends(&self) -> &EndConditions {
        &self.ends
    }

    /// Checks a configuration the method uses.
    pub(crate) fn check_position(
        what: &'static str,
        value: &Configuration,
    ) -> Result<(), PlanError> {
        check(what, value, FARTHEST_M)
    }
}

impl From<EndConditions> for Target {
    fn from(ends: EndConditions) -> Self {
        Self { ends }
    }
}

impl From<&EndConditions> for Target {
    fn from(ends: &EndConditions) -> Self {
        Self { ends: *ends }
    }
}

fn check(what: &'static str, values: &Configuration, limit: f64) -> Result<(), PlanError> {
    match values
        .iter()
        .position(|value| value.is_nan() || value.abs() > limit)
    {
        None => Ok(()),
        Some(coordinate) => Err(PlanError::Target {
            what,
            finger: Finger::ALL[coordinate / 3],
            axis: coordinate % 3,
            value: values[coordinate],
            limit,
        }),
    }
}
