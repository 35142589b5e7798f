//! Evaluations against closed forms, independent references, properties, and incomplete input.

mod closed_form;
mod incomplete;
mod intervals;
mod motion;
mod planned;
mod properties;
mod quality;
mod reference;
mod session;
