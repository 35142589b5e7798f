//! The planner against closed forms, other solvers, properties, and bad input.

mod bad_input;
mod chain;
mod closed_form;
mod contacts;
mod families;
mod gaussian;
mod object;
mod optimum;
mod plain;
mod properties;
mod reference;
mod relaxation;
mod replan;
mod support;
