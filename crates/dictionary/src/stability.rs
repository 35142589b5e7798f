//! Placeholder, not to be committed.
use nalgebra::DMatrix;
pub(crate) fn matched_cosine(_: &DMatrix<f64>, _: &DMatrix<f64>) -> f64 {
    f64::NAN
}
