//! Cleaning against takes whose faults are known, closed forms, and bad input.

mod bad_input;
mod common;
mod fill;
mod flips;
mod mark;
mod repaired;
mod resample;
