//! Learning from more than memory holds, by one process or many, that can be killed and resumed.
//!
//! A learning folder holds a run of it:
//!
//! ```text
//! learning.json                 takes with their hashes, settings, counts; its hash is the run's id
//! takes/00000.table ...         each take in the hand's frame, filtered: fingertips and object
//! takes/00000.unfiltered.table  the same before the filter
//! problem.bin                   what is taken off the data, hulls and velocities of the takes
//! start-000/round-00003/        one start (seed) and one of its rounds:
//!     state.bin                     the primitives that the round begins with
//!     shard-1-of-8.sums             what a shard's blocks say about them
//!     activations/00000000.bin      activations of each block that they gave
//! ```
//!
//! [`init`] reads the takes once, one after the other, and writes the first state. For each round,
//! every shard's [`stats`] reads its blocks of columns from the tables, fits their activations and
//! writes sums; [`update`] adds the sums of all shards and writes the state of the next round, or
//! marks the last one as the result. [`finish`] makes the dictionary. [`learn_in`] runs all of them
//! in one process. Files of a round are never changed, only written whole; what is written twice is
//! written equal. A run that is killed goes on with the round it was in, and the steps can be driven
//! by anything that starts processes. Files carry the id of the run, start and round, and a checksum.
//!
//! In reading order: `folder` (names, `learning.json`, what is written and read), `file` (one file),
//! `gather` (takes to tables), `tables` (columns from tables), `rounds`, `finish`.

mod file;
mod finish;
mod folder;
mod init;
mod rounds;
mod tables;

pub use finish::{Learned, finish, learn_given, learn_in};
pub use folder::{LearningFolder, LearningPlan, PlannedTake};
pub use init::init;
pub use rounds::{Progress, Shard, Updated, begin_rounds, stats, update};
