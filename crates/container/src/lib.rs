//! The records of any MCAP file as bytes: read, written, cut, filtered, merged, recovered.
//!
//! This crate knows no message. What it keeps of a file stays byte for byte; what the format makes of
//! that (indexes, summary, checksums) it makes anew. Files of any size work: a [`Source`] is read from
//! front to back, and memory is taken for the largest record, never more than the file has bytes.
//!
//! ```
//! use std::io::Cursor;
//!
//! use inhand_container::{Interval, Packing, Selection, Source, Writer, select, span};
//!
//! # fn main() -> Result<(), inhand_container::ContainerError> {
//! let mut bag = Vec::new();
//! let mut writer = Writer::new(&mut bag, "", "example", Packing::Zstd)?;
//! let channel = writer.channel(0, "/a", "json", &Default::default())?;
//! for log_time in 0..10 {
//!     writer.message(channel, 0, log_time, |data| data.extend(b"{}"))?;
//! }
//! writer.finish()?;
//!
//! let mut source = Source::open("bag.mcap", Cursor::new(bag))?;
//! assert_eq!(span(&mut source)?, Some((0, 9)));
//! let selection = Selection {
//!     keep: vec![Interval::new(3, Some(7))],
//!     ..Selection::default()
//! };
//! let mut part = Vec::new();
//! let selected = select(&mut source, &mut part, &selection)?;
//! assert_eq!((selected.written.messages, selected.left_out), (4, 6));
//! # Ok(())
//! # }
//! ```
//!
//! Time is log time, nanoseconds since 1970-01-01 UTC. [`walk`] visits records parsed, [`recover`] saves
//! what is sound of a damaged file, [`verify`] reads a file back with every checksum, and [`audit`] compares
//! everything that a file states twice. A [`Timeline`] gives messages by log time from any instant on.

mod attachment;
mod audit;
mod channel;
mod chunk;
mod error;
mod feed;
mod fields;
mod format;
mod ids;
mod interval;
mod limit;
mod merge;
mod overview;
mod recover;
mod reopen;
mod replay;
mod select;
mod source;
mod timeline;
mod verify;
mod walk;
mod writer;

pub use audit::{Audit, Difference, Differences, Visit, audit};
pub use channel::{ChannelFacts, Latch, SchemaFacts, latch};
pub use chunk::{Packing, is_zstd, unpack_zstd, zstd_reader, zstd_size};
pub use error::ContainerError;
pub use fields::parse_record;
pub use interval::Interval;
pub use limit::{memory_limit, set_memory_limit};
pub use mcap::records::{MessageHeader, Record};
pub use merge::{Merge, Merged, merge};
pub use overview::{Listed, MetadataRecord, channels, listed, metadata, profile, span};
pub use recover::{Loss, Recovered, recover};
pub use reopen::Reopened;
pub use replay::Replayed;
pub use select::{Selected, Selection, select};
pub use source::Source;
pub use timeline::{KeptMessage, TimedMessage, Timeline};
pub use verify::verify;
pub use walk::{Depth, is_mcap, walk, walk_source};
pub use writer::{Writer, Written};
