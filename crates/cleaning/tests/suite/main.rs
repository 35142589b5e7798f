//! Cleaning against takes whose faults are known.

mod common;
mod mark;
