//! Smooth curves through end conditions, velocities, error metrics and quantiles.
