//! The command line: exit codes, what is printed where, what is written and what is not. What the
//! numbers are is tested below the command line.

mod annotate;
mod bad_input;
mod bags;
mod check;
mod clean;
mod containers;
mod convert;
mod exit_codes;
mod export;
mod faults;
#[cfg(unix)]
mod interrupt;
mod json;
mod layout;
mod learn_rank;
mod learn_runs;
#[cfg(target_os = "linux")]
mod long_takes;
mod look;
mod motion;
mod one_recording;
mod outputs;
mod overlay;
mod plan;
mod plant;
mod play;
mod printing;
#[cfg(unix)]
mod progress;
mod run;
mod sessions;
mod steps;
mod stored;
mod support;
mod tables;
#[cfg(unix)]
mod targets;
mod verify;
mod view;
