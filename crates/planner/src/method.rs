//! Which problem is solved, with which numbers, by which solver.

use std::fmt;
use std::str::FromStr;

use inhand_model::{Configuration, Finger, SEGMENT_COORDINATES, VelocityBounds};

use crate::error::PlanError;

/// Which problem is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Method {
    /// As printed in arXiv 2308.15153: only the last configuration is given. Fewer equations than
    /// unknowns, so a tiny ridge on the activations picks one of the many minimisers.
    Paper,
    /// First and last configuration are given; mean and covariance of the training activations
    /// decide what the targets leave open.
    Prior,
}

impl Method {
    /// All methods, in the order of reports.
    pub const ALL: [Method; 2] = [Method::Paper, Method::Prior];

    /// Lower-case name, as in files and settings.
    pub const fn name(self) -> &'static str {
        match self {
            Method::Paper => "paper",
            Method::Prior => "prior",
        }
    }

    /// One sentence for reports.
    pub const fn description(self) -> &'static str {
        match self {
            Method::Paper => {
                "last configuration given, as printed in arXiv 2308.15153; \
                 a tiny ridge on the activations makes the minimiser unique"
            }
            Method::Prior => {
                "first and last configuration given; mean and covariance of the training \
                 activations decide the rest"
            }
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Method {
    type Err = PlanError;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Method::ALL
            .into_iter()
            .find(|method| method.name() == name)
            .ok_or_else(|| PlanError::UnknownMethod {
                name: name.to_owned(),
                expected: Method::ALL.map(Method::name).join(", "),
            })
    }
}

/// Who solves the problem. Both reach the same optimum (it is unique) and both carry the same
/// certificate, recomputed apart from them.
///
/// The default is [`Backend::ActiveSet`], by measurement: on 200 primitives learned from one
/// session, about 40 of 200 activations end at zero and velocity bounds are almost never active, so
/// that the optimum is some 40 small steps away from the unconstrained one, which is a single
/// matrix-vector product. The interior-point method cannot start from there and factorises a
/// 200 x 200 system in each of its ten iterations, because the inverse of a full covariance is
/// dense. `benches/plan.rs` has both, and the same problem with every row present.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Backend {
    /// Dual active-set method on the factorised problem, with [`Backend::Clarabel`] behind it
    /// should it not pass its certificate.
    #[default]
    ActiveSet,
    /// Clarabel's interior-point method, its answer polished on the bounds it found active.
    Clarabel,
}

/// The numbers of a problem. No `Default`: velocity bounds are physics.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannerSettings {
    /// Standard deviation of what is given (targets), metres; not used by [`Method::Paper`].
    /// Usually [`PlannerSettings::SIGMA_M`].
    pub sigma_m: f64,
    /// Weight of the squared activations (mm²) in [`Method::Paper`], against squared target errors
    /// in mm². Usually [`PlannerSettings::RIDGE`].
    pub ridge: f64,
    /// Bounds on each coordinate's velocity between neighbouring samples, m/s, as they are to be
    /// enforced. Usually what the training takes show, [`widened`] by
    /// [`PlannerSettings::VELOCITY_FACTOR`].
    pub velocity_bounds: VelocityBounds,
}

impl PlannerSettings {
    /// A tenth of a millimetre: below what optical motion capture resolves, large enough to keep
    /// the problem well conditioned.
    pub const SIGMA_M: f64 = 1e-4;
    /// Changes the reached configuration by some hundredths of a millimetre.
    pub const RIDGE: f64 = 1e-4;
    /// Recorded test motion leaves the extremes of the training takes by a few per cent.
    pub const VELOCITY_FACTOR: f64 = 1.1;

    pub(crate) fn validate(&self) -> Result<(), PlanError> {
        for (name, value) in [("sigma_m", self.sigma_m), ("ridge", self.ridge)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(PlanError::Setting {
                    name,
                    value,
                    expected: "a positive number",
                });
            }
        }
        let VelocityBounds { min_m_s, max_m_s } = self.velocity_bounds;
        for coordinate in 0..SEGMENT_COORDINATES {
            let (min_m_s, max_m_s) = (min_m_s[coordinate], max_m_s[coordinate]);
            if !(min_m_s.is_finite() && max_m_s.is_finite() && min_m_s <= max_m_s) {
                return Err(PlanError::VelocityBounds {
                    finger: Finger::ALL[coordinate / 3],
                    axis: coordinate % 3,
                    min_m_s,
                    max_m_s,
                });
            }
        }
        Ok(())
    }
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
