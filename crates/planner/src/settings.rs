//! The numbers of a problem: how sharply targets are meant, and which constraints hold.

use std::sync::Arc;

use inhand_model::{Configuration, Finger, Hull, PerFinger, VelocityBounds};

use crate::error::PlanError;

/// Soft or hard targets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ends {
    /// To be reached about so exactly: with standard deviations of fingertip positions, metres
    /// (velocities and the object have their own), against how demonstrations vary.
    Soft {
        /// Standard deviation of each coordinate, metres; usually [`PlannerSettings::SIGMA_M`].
        sigma_m: f64,
    },
    /// To be reached exactly, velocities and the object's poses as well. A target that no motion
    /// reaches makes the problem infeasible.
    Hard,
}

/// Bounds on the acceleration of each coordinate, m/s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelerationBounds {
    /// Lower bounds, finger then axis.
    pub min_m_s2: Configuration,
    /// Upper bounds, finger then axis.
    pub max_m_s2: Configuration,
}

/// Constraints on the fingertips' motion, each of which can be off. They hold at, or between, all
/// samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Constraints {
    /// Velocity of each finger and axis between neighbouring samples: `(v(t+1) - v(t)) * rate`.
    /// Usually what the training takes show, [`widened`] by [`PlannerSettings::VELOCITY_FACTOR`].
    pub velocity: Option<VelocityBounds>,
    /// Acceleration of each finger and axis: `(v(t+1) - 2 v(t) + v(t-1)) * rate²`.
    pub acceleration: Option<AccelerationBounds>,
    /// Every fingertip stays in its training hull, each of whose half-spaces is moved outwards by
    /// this margin (metres; inwards where it is negative).
    pub reachability_margin_m: Option<f64>,
    /// Least distance between any two fingertips, metres. The set of such motions is not convex;
    /// the plan is the optimum among motions on the same side of each other, for sides that are
    /// taken from the motion without this constraint and then improved until they stay.
    pub separation_m: Option<f64>,
}

/// The numbers of a problem. No `Default`: velocity bounds are physics.
///
/// Targets are weighed by their variances. In the terms of arXiv 2308.15153, which minimises
/// `J = J_F + alpha J_O` with a position and a rotation part in `J_O`: alpha is
/// `(sigma_m / object_sigma_m)²` for the object's position (squared metres) and
/// `(sigma_m / object_sigma_rad)²` for its rotation (squared radians).
#[derive(Clone, Debug, PartialEq)]
pub struct PlannerSettings {
    /// How targets are meant. [`Method::Paper`](crate::Method::Paper) counts position errors in
    /// mm², so of soft deviations only the ratios to `sigma_m` matter there.
    pub ends: Ends,
    /// Standard deviation of given velocities, m/s, where targets are soft.
    pub velocity_sigma_m_s: f64,
    /// Standard deviation of the object's given positions, metres, where targets are soft.
    pub object_sigma_m: f64,
    /// Standard deviation of the object's given rotations, radians, where targets are soft.
    pub object_sigma_rad: f64,
    /// Weight of the squared activations (mm²) in [`Method::Paper`](crate::Method::Paper), against
    /// squared target errors in mm². Usually [`PlannerSettings::RIDGE`].
    pub ridge: f64,
    /// What the motion has to keep.
    pub constraints: Constraints,
    /// Training hulls, for reachability and for the distance to them; without, those of the
    /// dictionary.
    pub hulls: Option<Arc<PerFinger<Hull>>>,
}

impl PlannerSettings {
    /// A tenth of a millimetre: below what optical motion capture resolves, large enough to keep
    /// the problem well conditioned.
    pub const SIGMA_M: f64 = 1e-4;
    /// A tenth of a millimetre a second: given velocities are taken as they are. Demonstrated ones
    /// spread so narrowly around zero that with the noise of two markers over 40 ms (3.5 mm/s) as
    /// their deviation, plans were drawn to slower ends and missed left-out motion by 6 % more.
    pub const VELOCITY_SIGMA_M_S: f64 = 1e-4;
    /// A body's position comes from several markers, moved to its centre by an offset that is known
    /// less well than they are.
    pub const OBJECT_SIGMA_M: f64 = 2e-4;
    /// The same on the surface of an object of 5 cm: 0.2 mm over a lever of 25 mm.
    pub const OBJECT_SIGMA_RAD: f64 = 8e-3;
    /// Changes the reached configuration by some hundredths of a millimetre.
    pub const RIDGE: f64 = 1e-4;
    /// Recorded test motion leaves the extremes of the training takes by a few per cent.
    pub const VELOCITY_FACTOR: f64 = 1.1;

    /// Soft targets with the usual deviations, and these velocity bounds (m/s, as they are to be
    /// enforced) as the only constraint.
    pub fn new(velocity_bounds: VelocityBounds) -> Self {
        Self {
            ends: Ends::Soft {
                sigma_m: Self::SIGMA_M,
            },
            velocity_sigma_m_s: Self::VELOCITY_SIGMA_M_S,
            object_sigma_m: Self::OBJECT_SIGMA_M,
            object_sigma_rad: Self::OBJECT_SIGMA_RAD,
            ridge: Self::RIDGE,
            constraints: Constraints {
                velocity: Some(velocity_bounds),
                ..Constraints::default()
            },
            hulls: None,
        }
    }

    pub(crate) fn validate(&self) -> Result<(), PlanError> {
        let sigma_m = match self.ends {
            Ends::Soft { sigma_m } => sigma_m,
            Ends::Hard => Self::SIGMA_M,
        };
        for (name, value) in [
            ("sigma_m", sigma_m),
            ("velocity_sigma_m_s", self.velocity_sigma_m_s),
            ("object_sigma_m", self.object_sigma_m),
            ("object_sigma_rad", self.object_sigma_rad),
            ("ridge", self.ridge),
            // Off, it is as good as any number.
            ("separation_m", self.constraints.separation_m.unwrap_or(1.0)),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(PlanError::setting(name, value, "a positive number"));
            }
        }
        let constraints = &self.constraints;
        if let Some(value) = constraints.reachability_margin_m.filter(|m| !m.is_finite()) {
            let name = "reachability_margin_m";
            return Err(PlanError::setting(name, value, "a finite number"));
        }
        if let Some(VelocityBounds { min_m_s, max_m_s }) = &constraints.velocity {
            check_bounds("velocity", "m/s", min_m_s, max_m_s)?;
        }
        if let Some(AccelerationBounds { min_m_s2, max_m_s2 }) = &constraints.acceleration {
            check_bounds("acceleration", "m/s²", min_m_s2, max_m_s2)?;
        }
        Ok(())
    }
}

/// Refuses bounds that nothing satisfies, or that are no numbers.
fn check_bounds(
    what: &str,
    unit: &str,
    min: &Configuration,
    max: &Configuration,
) -> Result<(), PlanError> {
    for (coordinate, (min, max)) in min.iter().zip(max).enumerate() {
        if !(min.is_finite() && max.is_finite() && min <= max) {
            let (finger, axis) = (Finger::ALL[coordinate / 3], coordinate % 3);
            return Err(PlanError::Setting(format!(
                "{what} bounds of {finger}, axis {axis}, run from {min} to {max} {unit}: \
                 expected two numbers, the first not above the second"
            )));
        }
    }
    Ok(())
}

/// Velocity bounds moved outwards: each bound goes `factor - 1` of its own size away from the other
/// one.
///
/// ```
/// use inhand_model::VelocityBounds;
///
/// let bounds = VelocityBounds { min_m_s: [-0.2; 15], max_m_s: [0.1; 15] };
/// let wider = inhand_planner::widened(&bounds, 1.1);
/// assert!((wider.min_m_s[0] + 0.22).abs() < 1e-12 && (wider.max_m_s[0] - 0.11).abs() < 1e-12);
/// ```
pub fn widened(bounds: &VelocityBounds, factor: f64) -> VelocityBounds {
    let moved = |values: &Configuration, direction: f64| {
        values.map(|value| value + direction * (factor - 1.0) * value.abs())
    };
    VelocityBounds {
        min_m_s: moved(&bounds.min_m_s, -1.0),
        max_m_s: moved(&bounds.max_m_s, 1.0),
    }
}
