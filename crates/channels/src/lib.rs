//! Recordings, motions, dictionaries, trajectories as MCAP channels and back.
