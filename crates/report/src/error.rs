//! Why an evaluation cannot become a report.

use thiserror::Error;

/// Why an evaluation cannot become a report.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The method to look at first is not there, so no verdict can be given.
    #[error(
        "evaluation of session \"{session}\": the default method \"{name}\" was not evaluated; \
         evaluated were: {}; name one of these as the default or add it to the methods",
        list(.known)
    )]
    UnknownDefaultMethod {
        /// The session.
        session: String,
        /// The method that was asked for.
        name: String,
        /// The methods there are.
        known: Vec<String>,
    },
    /// Two methods under one name cannot be told apart by those who read the report.
    #[error(
        "evaluation of session \"{session}\": the method \"{name}\" appears {times} times, \
         expected once; give each method a name of its own"
    )]
    DuplicateMethod {
        /// The session.
        session: String,
        /// The name.
        name: String,
        /// How often it is there.
        times: usize,
    },
    /// The JSON could not be written.
    #[error("evaluation of session \"{session}\": could not be written as JSON")]
    Json {
        /// The session.
        session: String,
        /// What the JSON writer says.
        source: serde_json::Error,
    },
}

fn list(names: &[String]) -> String {
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}
