//! How well planned trajectories match recorded motion.
