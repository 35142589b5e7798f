//! Errors of making and reading reports.

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
    /// Two methods under one name cannot be distinguished.
    #[error(
        "evaluation of session \"{session}\": the method \"{name}\" appears {times} times, \
         expected once; give each method a name of its own"
    )]
    DuplicateMethod {
        /// The session.
        session: String,
        /// The name.
        name: String,
        /// Number of methods of that name.
        times: usize,
    },
    /// Text that is no `evaluation.json`.
    #[error(
        "not an evaluation of inhand (line {}, column {}); expected the evaluation.json that \
         `inhand run` or `inhand evaluate` writes",
        .source.line(),
        .source.column()
    )]
    NotAnEvaluation {
        /// Error of the JSON reader: the key or character and where it is.
        source: serde_json::Error,
    },
    /// A document of another version, in which keys may mean something else.
    #[error(
        "schema_version is {found}, expected {expected}; make the evaluation again with this \
         version of inhand, or read it with the one that wrote it"
    )]
    Version {
        /// The version of the document.
        found: u64,
        /// The version that can be read.
        expected: u32,
    },
    /// The JSON could not be written.
    #[error("evaluation of session \"{session}\": could not be written as JSON")]
    Json {
        /// The session.
        session: String,
        /// Error of the JSON writer.
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
