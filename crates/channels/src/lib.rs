//! Recordings, motions, dictionaries, trajectories as MCAP channels and back.
//!
//! Nouns of [`inhand_model`] go in, bytes come out, and the other way round. Third-party files are read
//! by `inhand-import`.
//!
//! ```
//! use std::io::Cursor;
//!
//! use inhand_channels::{TakeFile, Views, info, read_take, write_take};
//! use inhand_model::{
//!     Clock, LengthUnit, Marker, MarkerKind, PointTrack, Position, Recording, Source, StartTime,
//!     UpAxis,
//! };
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let seen = Position::new(0.1, 0.2, 0.3);
//! let thumb = Marker {
//!     name: "Thumb".to_owned(),
//!     id: String::new(),
//!     kind: MarkerKind::Labelled,
//!     track: PointTrack::from_measured([Some(seen), None]),
//!     quality: None,
//! };
//! let source = Source {
//!     format: "an example".to_owned(),
//!     length_unit: LengthUnit::Metres,
//!     up_axis: UpAxis::Y,
//!     rotation: None,
//!     header: Default::default(),
//! };
//! let clock = Clock::new(0, StartTime::Unknown, 100.0)?;
//! let recording = Recording::new("a".to_owned(), clock, source, 2, vec![thumb], vec![])?;
//!
//! let mut bytes = Cursor::new(Vec::new());
//! write_take(&mut bytes, &TakeFile::new(&recording), Views::Default)?;
//!
//! let take = read_take(bytes.get_ref(), "a.mcap")?;
//! assert_eq!(take.recording.markers[0].track.get(0), Some(seen));
//! assert_eq!(take.recording.markers[0].track.get(1), None);
//! let topics: Vec<String> = info(bytes.get_ref(), "a.mcap")?
//!     .channels
//!     .into_iter()
//!     .map(|channel| channel.topic)
//!     .collect();
//! assert_eq!(topics, ["/recording/markers", "/tf_static", "/view/markers"]);
//! # Ok(())
//! # }
//! ```
//!
//! # Files
//!
//! Topics, schemas, units and frames are listed in `schemas/README.md`; the messages of package
//! `inhand` are defined in `schemas/inhand`, and what no message holds is in metadata records
//! (`inhand.recording`, `inhand.provenance.<n>` and others). Files are chunked, compressed with
//! zstd (dictionaries are not, so that they load at once), indexed, with a summary and checksums;
//! messages are in time order; every schema carries
//! its complete descriptors. The same nouns give the same bytes.

mod annotations;
mod colour;
mod cut;
mod dictionary;
mod error;
mod info;
mod made;
mod messages;
mod metadata;
mod overlay;
mod preview;
mod read;
mod schema;
mod segments;
mod streams;
mod take;
mod topic;
mod topic_role;
mod verify;
mod view;
mod wire;
mod write;

pub use annotations::{
    EventReader, FileEvents, annotation_records, events_json, is_ros2, read_annotations,
    read_file_events, write_annotations,
};
pub use colour::{FINGER_COLOURS, METHOD_COLOURS, Rgb, finger_hex, method_colour};
pub use cut::{TakeCut, cut_take, is_of_whole_take, latch};
pub use dictionary::{dictionary_of_source, read_dictionary, write_dictionary};
pub use error::ChannelError;
pub use info::{
    AttachmentInfo, ChannelInfo, ChunkInfo, FileInfo, FingerInfo, FingertipsInfo, FrameInfo, info,
    info_of_source,
};
pub use inhand_container::is_mcap;
pub use metadata::Metadata;
pub use overlay::{
    MAX_LAYERS, OverlayFile, OverlayLayer, OverlayObject, layer_colour, write_overlay,
};
pub use preview::{PointExtent, Preview, preview};
pub use read::{
    ReadMethod, ReadSegments, StoredMethod, absent, evaluated_of_source, generated_of_source,
    metadata_of_source, read_evaluated, read_generated, read_leading_metadata, read_metadata,
    read_take, segments_of_source, take_of_source,
};
pub use segments::TakeSegments;
pub use take::{
    CleanedTake, ContactSample, EvaluatedMethod, EvaluatedSample, GeneratedMethod,
    GeneratedSegment, Outline, RECORDED, ReadCleaned, ReadTake, TakeFile, Views,
};
pub use topic::{VIEW as VIEW_TOPICS, planned_fingertips_topic};
pub use topic_role::{TopicRole, TopicSource, take_topics};
pub use verify::{VerifiedFile, verify};
pub use write::{TakeWriter, ViewsFor, view_channels, view_topics, write_take, write_views};
