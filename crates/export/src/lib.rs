//! Recordings, motions, events and matrices as files that other tools read: CSV (wide and tidy),
//! Parquet, Motion-BIDS, ROS 2 bags, `.npz` and `.mat`; and events, wide CSV and matrices back.
//!
//! Units are in the names of columns (`_m`, `_s`), a missing sample has blank cells, and every
//! entity has a `status` (`measured`, `filled`, `missing`). Numbers have as many digits as it takes
//! to read them back unchanged.
//!
//! ```
//! use inhand_model::{
//!     Clock, LengthUnit, Marker, MarkerKind, PointTrack, Position, Recording, Source, StartTime,
//!     UpAxis,
//! };
//! use inhand_export::{recording_entities, wide, write_csv};
//!
//! let thumb = Marker {
//!     name: "Thumb".to_owned(),
//!     id: String::new(),
//!     kind: MarkerKind::Labelled,
//!     track: PointTrack::from_measured([Some(Position::new(0.1, 0.2, 0.3)), None]),
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
//! let take = Recording::new("a".into(), clock, source, 2, vec![thumb], vec![])?;
//! let mut csv = Vec::new();
//! write_csv(&wide(&recording_entities(&take), clock, 2), &mut csv)?;
//! assert_eq!(
//!     String::from_utf8(csv)?,
//!     "time_s,Thumb.x_m,Thumb.y_m,Thumb.z_m,Thumb.status\n\
//!      0,0.1,0.2,0.3,measured\n\
//!      0.01,,,,missing\n"
//! );
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! * [`wide`], [`tidy`]: a recording or motion as a [`Table`]; [`write_csv`], [`write_parquet`].
//! * [`facts_json`], [`read_wide_csv`]: facts beside a wide table, and the table as a recording.
//! * [`motion_table`], [`finger_table`]: motion that methods generated, and other numbers of fingers.
//! * [`evaluation_rows`]: every instant behind an evaluation; [`RowsFile`] reads it back.
//! * [`segment_rows`], [`contact_rows`], [`phase_rows`]: the segments, contacts and phases behind it.
//! * [`events`]: events of a take as CSV and back.
//! * [`bids`]: a take as files of a BIDS dataset.
//! * [`write_ros2`]: a take or plan as a ROS 2 bag.
//! * [`pdf_of_svg`]: a figure of a report as PDF.
//! * [`matrices`]: named matrices for NumPy and MATLAB.

pub mod bids;
mod error;
pub mod events;
mod fingers;
pub mod matrices;
mod motion;
mod parquet_file;
mod pdf;
mod ros2;
mod rows;
mod table;
mod take;
mod wide_csv;

pub use error::ExportError;
pub use fingers::{
    CONTACT_COLUMNS, ERROR_COLUMNS, FingerColumn, FingerRow, TableLayout, finger_table,
    motion_table, trajectory_table,
};
pub use motion::{contact_rows, phase_rows, segment_rows};
pub use parquet_file::{ParquetTable, write_parquet};
pub use pdf::pdf_of_svg;
pub use ros2::{Colour, Ros2Bag, Ros2Method, Ros2Take, write_ros2, write_ros2_markers};
pub use rows::{RESULTS_KEY, RowPositions, RowsFile, evaluation_rows, rows_facts};
pub use table::{Column, Table, TableBuilder, write_csv};
pub use take::{Entity, motion_entities, recording_entities, tidy, wide};
pub use wide_csv::{facts_json, looks_like_wide_csv, read_wide_csv};
