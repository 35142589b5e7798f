//! The steps on values, against what is true of simulated takes. No file is touched.

mod demo;
mod truth;
