//! Recordings to hand-frame motions and segments: gaps, rigid bodies, filters.
//!
//! * [`fit_templates`]: what the marker clusters of a session look like, for hands and objects that
//!   are not rigid bodies of the takes; [`role_body`] places them at every sample.
//! * [`process`]: a recording in the hand's frame with short gaps filled ([`to_hand_frame`]), smoothed
//!   by a [`filter`] ([`smooth`]).
//! * [`cut_segments`]: pieces of a second, with or without the object, and the end conditions that a
//!   planner knows.
//! * [`Welch`]: over which frequencies motion and noise spread.
//!
//! Missing stays missing unless a gap is short enough to fill, and what was filled is marked, from
//! here to the last report. Nothing here reads or writes files.
//!
//! ```
//! use inhand_model::*;
//! use inhand_motion::*;
//! use nalgebra::{Isometry3, Vector3};
//!
//! // Two seconds at 100 Hz: the hand moves along x, and the fingertips move with it.
//! let clock = Clock::new(0, StartTime::Unknown, 100.0)?;
//! let x_m = |k: u32| 0.001 * f64::from(k);
//! let hand = TrackedBody {
//!     name: "Hand".into(),
//!     id: String::new(),
//!     kind: BodyKind::RigidBody,
//!     track: Track::from_measured(
//!         (0..200).map(|k| Some(Pose::new(Isometry3::translation(x_m(k), 0.0, 0.0)))),
//!     ),
//!     marker_error_m: None,
//! };
//! let markers = Finger::ALL.map(|finger| Marker {
//!     name: finger.to_string(),
//!     id: String::new(),
//!     kind: MarkerKind::Labelled,
//!     track: Track::from_measured(
//!         (0..200).map(|k| Some(Position::new(x_m(k), 0.08, 0.01 * finger.index() as f64))),
//!     ),
//!     quality: None,
//! });
//! let source = Source {
//!     format: "example".into(),
//!     length_unit: LengthUnit::Metres,
//!     up_axis: UpAxis::Y,
//!     rotation: None,
//!     header: Default::default(),
//! };
//! let take = Recording::new("take".into(), clock, source, 200, markers.into(), vec![hand])?;
//! let roles = Roles {
//!     hand: BodySource::RigidBody("Hand".into()),
//!     object: None,
//!     fingers: PerFinger::from_fn(|finger| finger.to_string()),
//! };
//!
//! let templates = fit_templates([(&take, &roles)])?;
//! let settings = ProcessSettings {
//!     max_gap_s: 0.1,
//!     fill: GapFill::Cubic,
//!     filter: Filter::Median { window: 50 },
//!     object_offset_m: [0.0; 3],
//! };
//! let motion = process(&take, &roles, &templates, &settings)?;
//! // Seen from the hand, nothing moves.
//! let index = motion.fingertips[Finger::Index].get(150).expect("nothing is missing");
//! assert!((index.coords_m() - Vector3::new(0.0, 0.08, 0.01)).norm() < 1e-12);
//!
//! let segments = cut_segments(
//!     &[&motion],
//!     &SegmentSettings { layout: SegmentLayout::one_second(100.0), stride: 10, ends: EndsRule::Differences { margin_s: 0.04 }, missing_s: 0.0 },
//! )?;
//! // Starts 4, 14, ... 94: 4 samples are kept free at both ends.
//! assert_eq!((segments.len(), segments.left_out), (10, 0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod filter;

mod boundary;
mod compare;
mod process;
mod segments;
mod settings;
mod table;

mod body;
mod gaps;
mod template;

mod error;
mod lookup;
mod rigid_fit;
mod spectrum;

pub use body::role_body;
pub use compare::{Deviation, deviations};
pub use error::MotionError;
pub use gaps::{fill_points, fill_poses, lagrange_weight};
pub use lookup::fingertip_markers;
pub use process::{in_hand, process, smooth, to_hand_frame, with_hand};
pub use segments::{Cut, FoundSegments, Starts, cut_segments, cut_some};
pub use settings::{EndsRule, Filter, GapFill, ProcessSettings, SegmentSettings, gap_samples};
pub use spectrum::Welch;
pub use table::SegmentTable;
pub use template::{BodyRole, Template, Templates, fit_templates, fit_templates_to};
