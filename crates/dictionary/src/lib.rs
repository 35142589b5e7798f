//! Dictionaries of motion primitives learned from segments.

mod nmf;
mod pca;

mod projection;

mod settings;

mod error;

mod factorise;

mod block;

mod start;

mod covariance;

mod data;

mod descent;

mod multiplicative;

mod product;

pub use error::LearnError;
pub use nmf::learn_nmf;
pub use pca::learn_pca;
pub use projection::{Projection, activations};
pub use settings::{NmfSettings, Start, Update};
