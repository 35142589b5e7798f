//! Dictionaries of motion primitives learned from segments.
//!
//! A dictionary writes a segment of motion (15 N numbers, with the object 21 N, metres) as
//! `offset + primitives * activations`. [`learn_nmf`] learns non-negative primitives with
//! non-negative activations, [`learn_pca`] orthonormal ones with activations of any sign;
//! [`activations`] finds the activations of a given segment.
//!
//! ```
//! use inhand_dictionary::{NmfSettings, activations, learn_nmf};
//! use inhand_model::{Demonstrated, EndConditions, SegmentLayout, SegmentOrigin, Segments};
//! use nalgebra::DMatrix;
//!
//! // Twenty segments of ten samples; the pipeline cuts them from recordings.
//! let layout = SegmentLayout { samples: 10, rate_hz: 10.0, object: false };
//! let columns_m = DMatrix::from_fn(layout.rows(), 20, |row, segment| {
//!     let (t, coordinate) = (row / 15, row % 15);
//!     0.02 * (0.2 * t as f64 + coordinate as f64 + 0.3 * segment as f64).sin()
//! });
//! # let zero = [0.0; 15];
//! # let ends = EndConditions {
//! #     first_m: zero, last_m: zero, first_velocity_m_s: zero, last_velocity_m_s: zero,
//! #     object: None,
//! # };
//! # let origins = (0..20).map(|i| SegmentOrigin { take: 0, start: 10 * i }).collect();
//! # let segments = Segments::new(layout, columns_m, origins, vec![ends; 20], 0)?;
//! let settings = NmfSettings { rank: 6, ..NmfSettings::default() };
//! let dictionary = learn_nmf(&segments, Demonstrated::default(), &settings)?;
//! assert!(dictionary.learning.rms_m < 1e-3);
//!
//! let h = activations(&dictionary, segments.column_m(3))?;
//! let back_m = &dictionary.offset_m + &dictionary.primitives * h;
//! assert!((back_m[0] - segments.column_m(3)[0]).abs() < 5e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # How it is made
//!
//! `nmf` and `pca` turn segments into dictionaries. Below them, `rounds`
//! alternates between two half steps: the primitives from sums over all segments, the activations
//! segment by segment. Segments live in fixed blocks (`block`), each with its own sums, added in
//! block order; inside a block, work is cut into chunks whose size depends on the data alone. So the
//! result has the same bits whatever the number of threads, and blocks can be spread over memory,
//! files or machines without changing it. `product` (dense products) and `descent` (the coordinate
//! descent of HALS) hold the hot loops and all of the crate's `unsafe`: the calls of matrixmultiply
//! and of functions compiled for CPU features.
//!
//! Invariants: objectives are formed so that they keep their digits near an exact fit; no step
//! raises the objective; nothing depends on hash order, clock or thread.

mod block;
mod covariance;
mod data;
mod descent;
mod eigen;
mod error;
mod explained;
mod lanes;
mod matrix_view;
mod missing;
mod multiplicative;
mod nmf;
mod nndsvd;
mod packed;
mod pca;
mod prediction_error;
mod product;
mod projection;
mod random;
mod rank;
mod real;
mod residual;
mod rounds;
mod settings;
mod singular;
mod stability;
mod start;
mod sums;

#[cfg(test)]
mod tests;

pub use data::Columns;
pub use error::LearnError;
pub use explained::explained_variance;
pub use nmf::{describe_nmf, learn_nmf, smallest_objective};
pub use pca::learn_pca;
pub use prediction_error::{mean, mean_distance_m, standard_error};
pub use projection::activations;
pub use random::draw;
pub use rank::{RankCurve, RankGroups, RankMethod, RankSuggestion, rank_curve};
pub use real::Activations;
pub use residual::{DEVIATION_PRIMITIVES, Fold, folds, learn_residual};
pub use rounds::{LeftOut, NmfProblem, NmfState, blocks};
pub use settings::{NmfSettings, Penalty, Precision, Start, Update};
pub use sums::{Node, Sums, Tree};
