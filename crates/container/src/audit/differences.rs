//! Differences between what a file states and what it holds.

use std::fmt::Display;

use crate::error::ContainerError;

/// Differences that are listed; further ones are counted.
const MOST_LISTED: usize = 100;

/// Two statements that should agree and do not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// What and where, such as `byte 120: chunk index`.
    pub place: String,
    /// What should be there.
    pub expected: String,
    /// What is there.
    pub found: String,
}

/// Differences in the order in which they were found. The first hundred are listed, others counted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Differences {
    listed: Vec<Difference>,
    unlisted: u64,
}

impl Differences {
    /// Adds one.
    pub fn add(&mut self, place: impl Display, expected: impl Display, found: impl Display) {
        if self.listed.len() == MOST_LISTED {
            self.unlisted += 1;
            return;
        }
        self.listed.push(Difference {
            place: place.to_string(),
            expected: expected.to_string(),
            found: found.to_string(),
        });
    }

    /// Adds one unless both are equal.
    pub fn compare<T: PartialEq + Display>(&mut self, place: impl Display, expected: T, found: T) {
        if expected != found {
            self.add(place, expected, found);
        }
    }

    /// Adds a fault of a file as a difference.
    ///
    /// # Errors
    ///
    /// An error that says nothing about the file: it cannot be read, or takes too much memory.
    pub(crate) fn fault(&mut self, error: ContainerError) -> Result<(), ContainerError> {
        match error {
            ContainerError::Truncated {
                offset,
                record,
                expected,
                found,
                ..
            } => self.add(
                format_args!("byte {offset}: {record}"),
                format_args!("{expected} bytes"),
                format_args!("{found}: the file is cut off"),
            ),
            ContainerError::Damaged {
                offset,
                record,
                expected,
                found,
                ..
            } => self.add(format_args!("byte {offset}: {record}"), expected, found),
            other => return Err(other),
        }
        Ok(())
    }

    /// Those that are listed.
    pub fn listed(&self) -> &[Difference] {
        &self.listed
    }

    /// Number of those that are not listed.
    pub fn unlisted(&self) -> u64 {
        self.unlisted
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.listed.is_empty()
    }
}
