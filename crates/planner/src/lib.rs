//! Fingertip trajectories that reach targets, from a dictionary by convex optimisation.
