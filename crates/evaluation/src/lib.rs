//! Compares planned trajectories with recorded motion.
//!
//! [`recorded`] looks once at what the recorded motion does at every instant of the test segments;
//! [`evaluate_method`] looks at the same instants of what a method planned, in the same way, and
//! compares: errors, reachability, finger collisions, velocities, contacts (sections as in *In-hand
//! manipulation planning using human motion dictionary*, arXiv 2308.15153). [`recording_quality`]
//! says what the data itself is worth. Where a method plans the object as well, that is compared with
//! the recorded one, and where it states prediction regions, the share of the recording inside is counted. [`movement`] and
//! [`contact_dynamics`] say the same of recording and methods alike: how smoothly they move, how near to
//! anything demonstrated, and what their contacts do over time.
//!
//! Three rules hold for every number. It says how many values it rests on, how many of them were
//! filled, and how many were left out. Recorded and planned motion are judged at the same instants.
//! It does not depend on the number of threads.
//!
//! ```
//! use inhand_contact::hull;
//! use inhand_evaluation::{
//!     EvaluationSettings, MethodResult, TestData, evaluate_method, recorded,
//! };
//! # use inhand_model::{
//! #     Clock, Demonstrated, EndConditions, Finger, Hand, Motion, PerFinger, PointTrack, Pose,
//! #     PoseTrack, Position, SegmentLayout, SegmentOrigin, Segments, StartTime, Trajectory,
//! #     VelocityBounds,
//! # };
//! # use nalgebra::{DMatrix, Isometry3};
//! # // A take of two samples at rest, fingertips 20 mm apart, pads 2 mm from a cube.
//! # let tip = |f: Finger| Position::<Hand>::new(0.06 + 0.02 * f.index() as f64, 0.027, 0.0);
//! # let take = Motion {
//! #     name: "take".into(),
//! #     clock: Clock::new(0, StartTime::Unknown, 2.0)?,
//! #     fingertips: PerFinger::from_fn(|f| PointTrack::from_measured([Some(tip(f)); 2])),
//! #     object: Some(PoseTrack::from_measured([Some(Pose::new(Isometry3::translation(0.1, 0.0, 0.0))); 2])),
//! #     hand: PoseTrack::from_measured([Some(Pose::identity()); 2]),
//! #     selected: None,
//! # };
//! # let layout = SegmentLayout::one_second(2.0);
//! # let column = Finger::ALL.map(|f| tip(f).to_array()).concat().repeat(2);
//! # let ends = EndConditions { first_m: [0.0; 15], last_m: [0.0; 15], first_velocity_m_s: [0.0; 15], last_velocity_m_s: [0.0; 15], object: None };
//! # let segments = Segments::new(layout, DMatrix::from_vec(30, 1, column.clone()), vec![SegmentOrigin { take: 0, start: 0 }], vec![ends], 0)?;
//! # let corners = [[0.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 1.0, -1.0], [0.2, 0.2, 1.0]].map(Position::<Hand>::from);
//! # let everywhere = hull(&corners)?;
//! # let velocity = VelocityBounds { min_m_s: [-1.0; 15], max_m_s: [1.0; 15] };
//! # let demonstrated = Demonstrated { hulls: PerFinger::from_fn(|_| everywhere.clone()), velocity };
//! // One segment of a hand at rest on a cube, and a plan that is 1 mm off along y.
//! let data = TestData {
//!     segments: &segments,
//!     motions: &[&take],
//!     demonstrated: &demonstrated,
//!     velocity_bounds: velocity,
//!     shape: Some("cube:0.05".parse()?),
//! };
//! # let mut shifted = column;
//! # for y in shifted.iter_mut().skip(1).step_by(3) { *y += 0.001; }
//! let plan = Trajectory::new(layout, shifted)?;
//! let settings = EvaluationSettings::paper();
//! let of_recording = recorded(&data, &settings);
//! let method = MethodResult {
//!     name: "shifted",
//!     description: "the recording, 1 mm off",
//!     baseline: true,
//!     trajectories: &[Some(plan)],
//!     objects: None,
//!     corridors: None,
//!     plans: None,
//! };
//! let (evaluation, rows) = evaluate_method(&data, &of_recording, &method, &settings);
//!
//! assert_eq!(evaluation.error.all.n, 10);
//! assert!((evaluation.error.all.p75 - 0.001).abs() < 1e-12);
//! let contact = evaluation.contact.ok_or("object and shape are known")?;
//! assert_eq!(contact.three_or_more, 1.0);
//! assert!((rows.distance_m.ok_or("likewise")?[0][Finger::Middle] - 0.003).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod compare;
mod constraints;
mod contacts;
mod dynamics;
mod found_events;
mod input;
mod instants;
mod intervals;
mod known;
mod method;
mod movement;
mod outliers;
pub mod overlay;
mod quality;
mod recorded;
mod reference;

pub use compare::{
    MethodOf, compare_contacts, compare_errors, same_segments, stated_contacts, stated_errors,
};
pub use contacts::motion_contacts;
pub use dynamics::{DynamicsRows, contact_dynamics, contact_rows};
pub use found_events::with_found;
pub use input::{Corridors, EvaluationSettings, MethodResult, ObjectPoses, TestData};
pub use intervals::{Contestant, ErrorsByCluster, best_baseline, intervals, session_intervals};
pub use method::evaluate_method;
pub use movement::{JudgedMethod, MovementSettings, filled_segments, movement};
pub use outliers::outliers;
pub use quality::recording_quality;
pub use recorded::{Recorded, recorded};
pub use reference::filter_moves;
