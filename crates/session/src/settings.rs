//! Every setting of a session: the content of `inhand.toml`, with the defaults of the method.

use std::collections::BTreeMap;
use std::path::PathBuf;

use inhand_dictionary::{DEVIATION_PRIMITIVES, NmfSettings, Precision, Start, Update};
use inhand_model::DictionaryKind;
use inhand_motion::GapFill;
use inhand_planner::PlannerSettings;
use serde::{Deserialize, Serialize};

use crate::methods::Method;

/// Declares a table of settings with the default of each.
macro_rules! section {
    ($(#[$about:meta])* pub struct $name:ident { $($(#[$what:meta])* pub $key:ident: $kind:ty = $default:expr,)* }) => {
        $(#[$about])*
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            $($(#[$what])* pub $key: $kind,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($key: $default,)* }
            }
        }
    };
}

mod check;
mod clean;
mod fingers;
mod layers;

pub use clean::CleanSection;
pub(crate) use layers::flatten;

/// Settings of a session, as `inhand.toml` holds them. Lengths are metres unless the name says
/// otherwise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Name of the session; the folder's name where it is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Who was recorded, for tables over sessions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub participant: Option<String>,
    /// What they did, for tables over sessions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub task: Option<String>,
    /// Whether one file may serve for training and testing over the same time range.
    pub allow_shared_takes: bool,
    /// What source files leave open.
    pub source: SourceSettings,
    /// What topics of third-party MCAP recordings are, by topic or `topic#name`: `ignore`, `body`,
    /// `marker`, `body:Hand`, `marker:Thumb,Index` (names by place in the message).
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub topics: BTreeMap<String, String>,
    /// Which tracked thing is the hand, the object.
    pub roles: BodySettings,
    /// Which marker is on which finger, by finger name.
    #[serde(deserialize_with = "fingers::by_finger")]
    pub fingers: BTreeMap<String, String>,
    /// The manipulated object.
    pub object: ObjectSettings,
    /// Which findings do not stop a run.
    #[serde(skip_serializing_if = "LookSection::is_plain")]
    pub look: LookSection,
    /// How takes are cleaned before anything else; by default not at all.
    pub clean: CleanSection,
    /// Gaps and filter.
    pub process: ProcessSection,
    /// Which events of takes segments come from.
    #[serde(skip_serializing_if = "SelectSection::is_everything")]
    pub select: SelectSection,
    /// How takes are cut.
    pub segments: SegmentSection,
    /// The dictionary.
    pub learn: LearnSection,
    /// Generation.
    pub plan: PlanSection,
    /// Thresholds of the evaluation.
    pub evaluate: EvaluateSection,
    /// Takes with their roles; empty for a folder with `train/` and `test/`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub takes: Vec<TakeEntry>,
}

/// Which intervals of takes are used, by their events. A label is written `task=rotate`, or as a word
/// such as `slip`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SelectSection {
    /// Only intervals of events with one of these labels; everything where there is none.
    pub with: Vec<String>,
    /// But no interval of an event with one of these labels.
    pub without: Vec<String>,
}

impl SelectSection {
    fn is_everything(&self) -> bool {
        self.with.is_empty() && self.without.is_empty()
    }
}

/// Which findings of the inspection do not stop a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LookSection {
    /// Findings that are accepted: an identifier such as `units`, or `units:TAKE` for one take.
    pub accept: Vec<String>,
}

impl LookSection {
    fn is_plain(&self) -> bool {
        self.accept.is_empty()
    }
}

/// A take and what it is for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TakeEntry {
    /// File, or folder of a ROS 2 bag, relative to the session's folder.
    pub path: PathBuf,
    /// Training or testing; where it is not given, the last `segments.test_share` of the time is for testing and the
    /// rest for training.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<Role>,
    /// First instant used, seconds after the take's first sample.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_s: Option<f64>,
    /// End of what is used, seconds after the take's first sample.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to_s: Option<f64>,
}

/// What a take is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// The dictionary is learned from it.
    Train,
    /// Methods are judged on it.
    Test,
}

impl Role {
    /// Lower-case name, as in files.
    pub const fn name(self) -> &'static str {
        match self {
            Role::Train => "train",
            Role::Test => "test",
        }
    }
}

/// What source files leave open.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SourceSettings {
    /// Unit of length, where a file does not state it: m, cm, mm, in or ft.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<String>,
    /// `quaternion` or the order of Euler angles such as `XYZ`, where a file does not state it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation_order: Option<String>,
    /// Which axis points up, where a file does not state it: y or z.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<String>,
    /// Samples per second of a third-party MCAP recording, where its stamps do not prove a rate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
}

/// Which tracked thing is the hand, the object.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BodySettings {
    /// A rigid body, or three or more marker names separated by commas.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hand: Option<String>,
    /// A rigid body, or three or more marker names separated by commas; `none` ignores objects.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
}

/// The manipulated object.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ObjectSettings {
    /// `cube:EDGE`, `box:XxYxZ` or `cylinder:DIAMETERxHEIGHT` in metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<String>,
    /// From the tracked body's origin to the object's centre, in the body's frame.
    pub offset_m: [f64; 3],
}

section! {
    /// Gaps and filter.
    pub struct ProcessSection {
        /// Longest gap that is filled, seconds.
        pub max_gap_s: f64 = 0.1,
        /// How gaps are filled.
        pub fill: GapFill = GapFill::Cubic,
        /// The filter.
        pub filter: FilterKind = FilterKind::Median,
        /// Window of the median and Savitzky-Golay filters, samples.
        pub window: usize = 50,
        /// Order of the Savitzky-Golay and Butterworth filters.
        pub order: usize = 2,
        /// Cut-off of the Butterworth filter after both passes, Hz.
        pub cutoff_hz: f64 = 6.0,
    }
}

/// A filter of `inhand_motion`, whose numbers are settings of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FilterKind {
    /// Median over `window` samples.
    Median,
    /// Polynomial of `order` through `window` samples.
    SavitzkyGolay,
    /// Low-pass of `order` at `cutoff_hz`.
    Butterworth,
    /// The samples as they are.
    None,
}

section! {
    /// How takes are cut.
    pub struct SegmentSection {
        /// Samples from one training segment to the next; 0 for no overlap. Test segments never
        /// overlap.
        pub stride: usize = 0,
        /// Seconds kept free at both ends of an interval; end velocities are taken over them.
        pub margin_s: f64 = 0.04,
        /// Seconds of measured samples at each end of a segment that boundary conditions of the held-out protocol
        /// rest on, three samples at least.
        pub ends_s: f64 = 0.08,
        /// How much of a training segment may be missing between its ends, seconds. Non-negative
        /// primitives learn from what is there; deviations from the smooth curve and principal components
        /// from complete segments only.
        pub missing_s: f64 = 0.0,
        /// Share of the time that is for testing, at the end of a recording that serves for training too.
        pub test_share: f64 = 0.2,
    }
}

section! {
    /// The dictionary.
    pub struct LearnSection {
        /// Which primitives `prior` plans with.
        pub kind: DictionaryKind = DictionaryKind::Nmf,
        /// Number of primitives; 200 where it is not given, or as many as there are segments.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub rank: Option<usize> = None,
        /// Primitives of each finger's deviation from the smooth curve, for `residual`.
        pub deviation_primitives: usize = DEVIATION_PRIMITIVES,
        /// Most segments that deviations are learned from: more are drawn from by the seed.
        pub deviation_segments: usize = 4096,
        /// Whether segments carry the object.
        pub object: ObjectInSegments = ObjectInSegments::Auto,
        /// Update of the factors.
        pub update: Update = NmfSettings::default().update,
        /// Where primitives start.
        pub start: Start = NmfSettings::default().start,
        /// Seed of the random start.
        pub seed: u64 = NmfSettings::default().seed,
        /// Random starts, with seeds counted up; the best is kept.
        pub restarts: usize = NmfSettings::default().restarts,
        /// Kind of numbers.
        pub precision: Precision = NmfSettings::default().precision,
        /// What activations cost: weight of their sum, on a scale that does not depend on the number of
        /// segments or their length.
        pub activation_l1: f64 = 0.0,
        /// Weight of half the sum of their squares.
        pub activation_l2: f64 = 0.0,
        /// What primitives cost, in the same way.
        pub primitive_l1: f64 = 0.0,
        /// Weight of half the sum of their squares.
        pub primitive_l2: f64 = 0.0,
        /// Most iterations.
        pub max_iterations: usize = NmfSettings::default().max_iterations,
        /// Sweeps over the activations in an iteration; over the primitives half as many.
        pub sweeps: usize = NmfSettings::default().sweeps,
        /// Stop when a sweep lowers the objective by less than this share of it.
        pub relative_change: f64 = NmfSettings::default().relative_change,
        /// Stop when an iteration lowers the error of left-out takes by less than this share of it.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub left_out_change: Option<f64> = None,
        /// Stop at this reconstruction error, millimetres.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub stop_rms_mm: Option<f64> = None,
    }
}

/// Whether segments carry the object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ObjectInSegments {
    /// Where every training take tracks it.
    Auto,
    /// Always: a take that does not track it is an error.
    Yes,
    /// Never.
    No,
}

section! {
    /// Generation.
    pub struct PlanSection {
        /// Methods in the order of the report; the first is the default one.
        pub methods: Vec<Method> = Method::ALL.to_vec(),
        /// How start and goal are met.
        pub ends: EndsKind = EndsKind::Soft,
        /// How exactly start and goal are met: standard deviation, millimetres.
        pub sigma_mm: f64 = 0.1,
        /// How exactly the object's start and goal are met: standard deviation of its position,
        /// millimetres. `(sigma_mm / object_sigma_mm)²` is the paper's weight alpha.
        pub object_sigma_mm: f64 = 0.2,
        /// The same of its rotation, degrees.
        pub object_sigma_deg: f64 = 0.5,
        /// Ridge that makes `paper` unique, in units of millimetres.
        pub ridge: f64 = 1e-4,
        /// Velocity bounds: training extremes times this; 0 for none.
        pub velocity_factor: f64 = PlannerSettings::VELOCITY_FACTOR,
        /// Velocity bound of every finger and axis instead, m/s.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub velocity_m_s: Option<f64> = None,
        /// Acceleration bound of every finger and axis, m/s².
        #[serde(skip_serializing_if = "Option::is_none")]
        pub acceleration_m_s2: Option<f64> = None,
        /// Whether fingertips have to stay inside their training hulls.
        pub reachability: bool = false,
        /// How far outside they may be then, millimetres.
        pub reachability_margin_mm: f64 = 0.0,
        /// Least distance between two fingertips, millimetres.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub separation_mm: Option<f64> = None,
        /// Whether fingers in contact at start and goal have to stay within `evaluate.tau_mm` of their
        /// contact points, as the object carries them.
        pub holding: bool = false,
    }
}

/// How start and goal are met.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EndsKind {
    /// Within `sigma_mm`.
    Soft,
    /// Exactly.
    Hard,
}

section! {
    /// Thresholds of the evaluation.
    pub struct EvaluateSection {
        /// Largest distance to the object's surface that counts as contact, millimetres.
        pub tau_mm: f64 = 5.0,
        /// Two fingertips nearer than this collide, millimetres.
        pub collision_mm: f64 = 10.0,
        /// Distance from marker to finger pad by finger name, millimetres; taken off the distance.
        #[serde(deserialize_with = "fingers::by_finger")]
        pub pad_offset_mm: BTreeMap<String, f64> = BTreeMap::new(),
        /// Contacts, and lifts, that last less are no changes of contact, seconds.
        pub min_contact_s: f64 = 0.05,
        /// A finger that stays off longer than this has left the grasp, seconds: setting down again is no gait.
        pub max_lift_s: f64 = 1.0,
        /// Fingers in contact that make a grasp.
        pub grasp_fingers: usize = 3,
        /// Draws of the bootstrap behind intervals; 0 for none.
        pub draws: usize = 2000,
        /// Share of the draws inside an interval.
        pub confidence: f64 = 0.95,
    }
}
