//! Evaluations as HTML with figures, and as JSON.
