//! The nouns of inhand: time, frames, poses, recordings, motions, segments, dictionaries,
//! trajectories, evaluations. Data and invariants, no algorithms, no files.
//!
//! Units are SI and stand in the names (`_m`, `_s`, `_m_s`, `_rad`); millimetres exist only in
//! reports. Frames are types: a [`Position<Hand>`] cannot be added to a [`Position<World>`], and a
//! [`Pose<To, From>`] reads target first, like its name in the code:
//!
//! ```
//! use inhand_model::{Hand, Object, Pose, Position, World};
//! use nalgebra::{Isometry3, Vector3};
//!
//! let world_from_hand = Pose::<World, Hand>::new(Isometry3::new(
//!     Vector3::new(1.0, 0.0, 0.0),
//!     Vector3::z() * std::f64::consts::FRAC_PI_2, // a quarter turn about z
//! ));
//! // One metre along the hand's x is one metre along the world's y, seen from where the hand is.
//! let tip_in_world = world_from_hand * Position::<Hand>::new(1.0, 0.0, 0.0);
//! assert!((tip_in_world.coords_m() - Vector3::new(1.0, 1.0, 0.0)).norm() < 1e-12);
//!
//! let world_from_object = Pose::<World, Object>::identity();
//! let hand_from_object: Pose<Hand, Object> = world_from_hand.inverse() * world_from_object;
//! # let _ = hand_from_object;
//! ```

mod annotations;
mod clock;
mod comparison;
mod contact_dynamics;
mod dictionary;
mod evaluation;
mod expectation;
mod finding;
mod finger;
mod finger_set;
mod frame;
mod illustrations;
mod intervals;
mod motion;
mod movement;
mod names;
mod plan;
mod provenance;
mod recording;
mod residual;
mod roles;
mod rows;
mod segments;
mod setting;
mod shape;
mod summary;
mod track;
mod trajectory;
mod units;

pub use annotations::{Annotations, Event, FOUND, Label, LabelError, Selection};
pub use clock::{Clock, ClockError, StartTime};
pub use comparison::{ComparedSide, ContactChange, Drawn, ErrorChange, EvaluationComparison};
pub use contact_dynamics::{
    ContactDynamics, ContactRules, FingerContactFacts, GaitFacts, PhaseFacts, PhaseKind,
    SegmentContacts, StateFacts, TakeContacts, Transition, in_contact,
};
pub use dictionary::{
    Demonstrated, Dictionary, DictionaryError, DictionaryKind, HeldOut, Hull, Learning, RankPoint,
    Restart, StopReason, VelocityBounds,
};
pub use evaluation::{
    Collision, ContactShare, CorridorCoverage, DeviationFacts, DictionaryFacts, Evaluation,
    FamilyFacts, MethodCandidate, MethodChoice, MethodEvaluation, ObjectError, PlanFacts,
    Reachability, SessionFacts, Statistics, TakeFacts, TakeQuality, TauShare, TrackQuality,
    VelocityCheck,
};
pub use expectation::{Bandwidths, Distances, Expectation, ExpectationWeights};
pub use finding::{Change, ChangeKind, Finding, Severity};
pub use finger::{Finger, HandAndFingers, PerFinger, UnknownFinger};
pub use finger_set::FingerSet;
pub use frame::{Body, Frame, Hand, Object, Pose, Position, World, rotation_from_xyzw};
pub use illustrations::{
    ExplainedVariance, Filtering, Illustrations, Path, PathExample, PointCloud, PrimitivePath,
    Spectrum, TakeGaps, TrackGaps, WorstCase,
};
pub use intervals::{
    Bootstrap, Cluster, Estimate, Intervals, Measure, MeasureEstimates, MethodIntervals,
    PairedDifference,
};
pub use motion::Motion;
pub use movement::{FingerMovement, Movement, MovementAnalysis};
pub use plan::{
    Certificate, ConstraintFamily, Corridor, PerFamily, Plan, PlanChecks, PlanStatus, Relaxation,
};
pub use provenance::{InputHash, Provenance};
pub use recording::{
    BodyKind, LengthUnit, Marker, MarkerKind, Recording, RecordingError, RotationOrder, Source,
    TrackedBody, UpAxis,
};
pub use residual::{Calibration, Residual, Validation, ends_len, smooth_basis};
pub use roles::{BodySource, Roles};
pub use rows::{
    ContactRow, ContactRows, EvaluationRows, GaitRow, MethodRows, MotionRows, MovementRows,
    PathFacts, PhaseRow, SegmentMovement, StateRow,
};
pub use segments::{
    Configuration, EndConditions, OBJECT_COORDINATES, ObjectEnds, ROTATION_LEVER_M,
    SEGMENT_COORDINATES, SegmentLayout, SegmentOrigin, Segments, SegmentsError,
    object_coordinates_m,
};
pub use setting::Setting;
pub use shape::{Shape, ShapeError};
pub use summary::{
    GroupSummary, MethodSummary, Outlier, OutlierSession, SessionMethod, SessionSummary,
    SettingDifference, SharedContacts, Summary,
};
pub use track::{PointTrack, PoseTrack, Sample, Status, Track, TrackCounts, runs};
pub use trajectory::{Trajectory, TrajectoryError};
