//! The public interface: learning from segments, and using a dictionary.

#![expect(
    clippy::unwrap_used,
    reason = "helpers outside of test functions: a panic is how a test fails"
)]

mod bad_input;
mod explained;
mod nmf;
mod object;
mod pca;
mod projection;
mod rank;
mod residual;
mod residual_bad_input;
mod residual_data;
mod residual_properties;
mod residual_reference;
mod rounds;
mod segments;
