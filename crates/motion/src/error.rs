//! Errors of processing takes.

use std::fmt;

use thiserror::Error;

use crate::template::BodyRole;

/// Why takes could not be processed or cut.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MotionError {
    /// A setting outside its range.
    #[error("{setting} is {found}: expected {expected}")]
    Setting {
        /// The setting, as in the settings' fields.
        setting: &'static str,
        /// The value found.
        found: String,
        /// What it may be.
        expected: String,
    },
    /// A role names something that the take does not contain.
    #[error(
        "take \"{take}\" has no {kind} \"{name}\", wanted as {role}: it has {}; map the role to one of these",
        listed(.available)
    )]
    NotInTake {
        /// The take.
        take: String,
        /// What was wanted of it, such as `hand` or `thumb`.
        role: String,
        /// `rigid body` or `marker`.
        kind: &'static str,
        /// The name looked for.
        name: String,
        /// The names there are of that kind.
        available: Vec<String>,
    },
    /// A cluster with fewer than three different markers.
    #[error(
        "the {role} is a cluster of {}: a pose needs three different markers or more",
        listed(.markers)
    )]
    ClusterTooSmall {
        /// The body.
        role: BodyRole,
        /// The markers named.
        markers: Vec<String>,
    },
    /// A body that is not the same thing in every take of a session.
    #[error(
        "the {role} is {found} in take \"{take}\", but {expected} in take \"{first_take}\": its frame needs one definition for the session"
    )]
    BodyDiffers {
        /// The body.
        role: BodyRole,
        /// A take.
        take: String,
        /// What the body is there.
        found: String,
        /// The first take that has it.
        first_take: String,
        /// What the body is there.
        expected: String,
    },
    /// A cluster that is never seen whole.
    #[error(
        "the markers of the {role} ({}) are never all seen at once in {}: name a cluster with fewer markers, or other takes",
        listed(.markers),
        listed(.takes)
    )]
    NeverComplete {
        /// The body.
        role: BodyRole,
        /// The cluster.
        markers: Vec<String>,
        /// The takes searched.
        takes: Vec<String>,
    },
    /// Markers too near to one line to tell the turn about it.
    #[error(
        "the markers {} of the {role} lie on a line: they spread {:.1} % as far across it as along it, expected {:.0} % at least; name markers that span a triangle",
        listed(.markers),
        .spread * 100.0,
        .min_spread * 100.0
    )]
    Collinear {
        /// The body.
        role: BodyRole,
        /// The markers.
        markers: Vec<String>,
        /// Their spread across the line, relative to that along it.
        spread: f64,
        /// The least that would do.
        min_spread: f64,
    },
    /// A cluster without template, or with one that was made for other markers.
    #[error(
        "take \"{take}\": the {role} is the cluster {}, but {}; fit the templates over this take too",
        listed(.markers),
        template_found(.template)
    )]
    NoTemplate {
        /// The take.
        take: String,
        /// The body.
        role: BodyRole,
        /// Its markers.
        markers: Vec<String>,
        /// The markers of the template there is.
        template: Option<Vec<String>>,
    },
    /// Takes of different rates.
    #[error(
        "take \"{take}\" is sampled at {rate_hz} Hz, take \"{first_take}\" at {first_rate_hz} Hz: takes of one session need one rate"
    )]
    Rates {
        /// The first take.
        first_take: String,
        /// Its rate.
        first_rate_hz: f64,
        /// A take that differs.
        take: String,
        /// Its rate.
        rate_hz: f64,
    },
    /// Segments laid out for another rate than the takes'.
    #[error(
        "segments are laid out for {layout_rate_hz} Hz, but take \"{take}\" is sampled at {rate_hz} Hz"
    )]
    LayoutRate {
        /// Rate of the layout.
        layout_rate_hz: f64,
        /// A take.
        take: String,
        /// Its rate.
        rate_hz: f64,
    },
}

impl MotionError {
    /// A setting outside its range.
    pub fn setting(
        setting: &'static str,
        found: impl fmt::Display,
        expected: impl Into<String>,
    ) -> Self {
        Self::Setting {
            setting,
            found: format!("{found}"),
            expected: expected.into(),
        }
    }
}

fn listed(names: &[String]) -> String {
    if names.is_empty() {
        return "none".to_owned();
    }
    let quoted: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
    quoted.join(", ")
}

fn template_found(template: &Option<Vec<String>>) -> String {
    match template {
        None => "there is no template for it".to_owned(),
        Some(markers) => format!("the template is of {}", listed(markers)),
    }
}
