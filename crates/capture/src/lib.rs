//! Vendor motion-capture files to recordings and back: Motive CSV, Qualisys TSV, TRC,
//! C3D.
//!
//! A reader turns bytes into a [`Recording`](inhand_model::Recording): metres, unit quaternions, an even clock, a status on
//! every sample. Odd but usable content becomes a [`Finding`](inhand_model::Finding) on the
//! recording; unusable content is a [`CaptureError`] that says where, what was expected,
//! what was found and what to do. Nothing here opens a file. [`read()`] takes a file in memory, [`Blocks`]
//! one of any length.
//!
//! ```
//! use inhand_capture::{ReadSettings, roles};
//! use inhand_model::BodySource;
//!
//! let csv = b"\
//! Format Version,1.23,Take Name,demo,Capture Frame Rate,100,Export Frame Rate,100,\
//! Capture Start Time,2023-03-29 06.23.40.520 PM,Total Exported Frames,2,\
//! Rotation Type,Quaternion,Length Units,Millimeters,Coordinate Space,Global\r
//! \r
//! ,Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Marker,Marker,Marker\r
//! ,Name,Hand,Hand,Hand,Hand,Hand,Hand,Hand,Thumb,Thumb,Thumb\r
//! ,ID,A,A,A,A,A,A,A,B,B,B\r
//! ,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Position,Position,Position\r
//! Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,X,Y,Z\r
//! 0,0.000,0,0,0,1,250,0,0,300,0,0\r
//! 1,0.010,0,0,0,1,251,0,0,,,\r
//! ";
//! let recording = inhand_capture::read(csv, "demo.csv", &ReadSettings::default())?;
//! let thumb = &recording.markers[0].track;
//! assert_eq!(thumb.get(0).map(|tip| tip.to_array()), Some([0.3, 0.0, 0.0])); // metres
//! assert_eq!(thumb.get(1), None); // blank cells are a missing sample
//!
//! // Which marker is which finger: four are not there, and the error says so.
//! let error = roles::resolve(&recording, &roles::RoleSettings::default()).unwrap_err();
//! assert!(error.to_string().contains("the markers: Thumb"));
//! # Ok::<(), inhand_capture::CaptureError>(())
//! ```
//!
//! * [`motive`]: Motive CSV, the row-typed versions 1 and 1.1 as well; writes 1.23.
//! * [`qualisys`]: TSV files of Qualisys Track Manager.
//! * [`trc`]: TRC files, as Cortex, Motive and OpenSim write them; writes them too.
//! * [`c3d`]: C3D files of any processor; writes them too.
//! * [`roles`]: which body or marker cluster is the hand, the object, which marker is which finger.

mod assembly;
pub mod c3d;
mod error;
mod format;
mod header;
mod lines;
pub mod motive;
pub mod qualisys;
mod read;
pub mod roles;
mod settings;
mod start_time;
mod table;
mod text;
pub mod trc;
mod trial;

pub use error::CaptureError;
pub use read::{Blocks, has_even_rows, read, read_rows};
pub use settings::{ReadSettings, parse_length_unit, parse_rotation_order, parse_up_axis};
pub use table::Extent;

/// Whether a path names a file that [`read()`] may be able to read, by its extension `.csv`,
/// `.tsv`, `.trc` or `.c3d`.
pub fn looks_like_capture_file(path_name: &str) -> bool {
    path_name.rsplit_once('.').is_some_and(|(_, extension)| {
        (format::FORMATS.iter()).any(|format| extension.eq_ignore_ascii_case(format.extension))
    })
}
