//! Recordings to hand-frame motions and segments: gaps, rigid bodies, filters.
