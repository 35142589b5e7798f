//! Checks, detection and cleaning against takes whose faults are known, closed forms, and bad input.

mod bad_input;
mod common;
mod content;
mod conventions;
mod fill;
mod flips;
mod mark;
mod output;
mod repaired;
mod resample;
mod support;
