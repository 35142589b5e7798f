//! The records of any MCAP file as bytes, whoever wrote it: read, cut, filtered, merged, recovered.
//!
//! This crate knows no message. What it keeps of a file stays byte for byte; what the format makes of
//! that (indexes, summary, checksums) it makes anew. Files of any size work: a [`Source`] is read from
//! front to back, and memory is taken for the largest record, never more than the file has bytes.
//!
//! ```
//! use std::io::Cursor;
//!
//! use inhand_container::{Interval, Selection, Source, select, span};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let mut file = Cursor::new(Vec::new());
//! # let mut writer = mcap::Writer::new(&mut file)?;
//! # let channel_id = writer.add_channel(0, "/a", "json", &Default::default())?;
//! # for log_time in 0..10 {
//! #     let header = mcap::records::MessageHeader { channel_id, sequence: 0, log_time, publish_time: 0 };
//! #     writer.write_to_known_channel(&header, b"{}")?;
//! # }
//! # writer.finish()?;
//! # drop(writer);
//! let mut source = Source::open("bag.mcap", file)?;
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
//! what is sound of a damaged file, and [`verify`] reads a file back with every checksum. A [`Timeline`]
//! gives messages by log time from any instant on.

mod attachment;
mod channel;
mod chunk;
mod error;
mod fault;
mod fields;
mod format;
mod index;
mod interval;
mod merge;
mod overview;
mod quick;
mod recover;
mod select;
mod source;
mod timeline;
mod verify;
mod walk;
mod writer;

pub use channel::{ChannelFacts, Latch, latch};
pub use chunk::Packing;
pub use error::ContainerError;
pub use index::Written;
pub use interval::Interval;
pub use mcap::records::Record;
pub use merge::{Merge, Merged, merge};
pub use overview::{MetadataRecord, channels, metadata, metadata_of, span};
pub use quick::walk_in_place;
pub use recover::{Loss, Recovered, recover};
pub use select::{Selected, Selection, select};
pub use source::Source;
pub use timeline::{KeptMessage, SchemaFacts, TimedMessage, Timeline, TimelineChannel};
pub use verify::verify;
pub use walk::{Depth, is_mcap, walk, walk_source, walk_while};
