//! Matrices from files that NumPy and SciPy wrote, and files that those read (`reference/make.py`).

#![expect(clippy::unwrap_used, reason = "tests may stop at what cannot fail")]

/// Bytes that are no sound file.
mod damaged;
/// What comes back from files of every shape.
mod files;
