//! Dictionaries of motion primitives learned from segments.
