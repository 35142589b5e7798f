//! The planner against closed forms, other solvers, properties, and bad input.

mod bad_input;
mod closed_form;
mod optimum;
mod properties;
mod reference;
mod support;
