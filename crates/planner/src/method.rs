//! Problem and solver.

use inhand_model::EndConditions;

use crate::target::{Target, Tips};

/// Problem that is solved.
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

    /// What the method is given of the end conditions of a segment, when methods are compared:
    /// the last configuration, or both; the object's poses where segments carry it. A target may
    /// give any method more or less.
    pub fn target(self, ends: &EndConditions) -> Target {
        let mut target = Target::from(ends);
        target.first_velocity_m_s = Tips::default();
        target.last_velocity_m_s = Tips::default();
        if self == Method::Paper {
            target.first_m = Tips::default();
        }
        target
    }
}

/// Solver of the problem. Both reach the same optimum (it is unique) and both carry the same
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
