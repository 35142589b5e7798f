//! Closed forms: takes whose faults are known, and the same takes without them.

mod content;
mod conventions;
mod output;
mod support;
