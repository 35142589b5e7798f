//! The steps on values, against what is true of simulated takes; takes too long for memory on files.

mod demo;
mod long_take;
mod truth;
