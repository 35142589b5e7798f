//! Data of the report's figures beside the numbers of an evaluation: intervals of motion, filtering,
//! spectra, hulls, primitives.

use crate::dictionary::Hull;
use crate::finger::{Finger, PerFinger};
use crate::statistics::Statistics;

/// A path of five fingertips in the hand frame, metres: a list of points for each finger.
pub type Path = PerFinger<Vec<[f64; 3]>>;

/// Everything that figures draw and no other number says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Illustrations {
    /// Where tracks have gaps, each take.
    pub gaps: Vec<TakeGaps>,
    /// What the filter does, on one stretch.
    pub filtering: Option<Filtering>,
    /// How motion and noise spread over frequencies, before and after the filter.
    pub spectrum: Option<Spectrum>,
    /// Test segments, recorded and planned: a usual one and the worst ones.
    pub paths: Vec<PathExample>,
    /// The worst errors, worst first.
    pub worst: Vec<WorstCase>,
    /// Where each fingertip has been in training.
    pub hulls: Option<PerFinger<Hull>>,
    /// The primitives used most, most used first.
    pub primitives: Vec<PrimitivePath>,
    /// Explained variance against rank.
    pub explained: Option<ExplainedVariance>,
    /// Distances to the object against those to clouds of points on it.
    pub point_clouds: Vec<PointCloud>,
}

/// A track of a take and where it is missing or filled.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackGaps {
    /// Name: a finger, `hand` or `object`.
    pub track: String,
    /// Missing, seconds since the first sample.
    pub missing_s: Vec<[f64; 2]>,
    /// Filled.
    pub filled_s: Vec<[f64; 2]>,
}

/// Gaps of a take.
#[derive(Clone, Debug, PartialEq)]
pub struct TakeGaps {
    /// Take.
    pub take: String,
    /// `train` or `test`.
    pub role: String,
    /// Length, seconds.
    pub duration_s: f64,
    /// Each track.
    pub tracks: Vec<TrackGaps>,
}

/// One coordinate of one fingertip over a few seconds, before and after filtering.
#[derive(Clone, Debug, PartialEq)]
pub struct Filtering {
    /// Take.
    pub take: String,
    /// Finger.
    pub finger: Finger,
    /// `x`, `y` or `z` in the hand frame: the one that moves most.
    pub axis: &'static str,
    /// Seconds since the take's first sample.
    pub time_s: Vec<f64>,
    /// As measured and filled, metres; NaN where missing.
    pub before_m: Vec<f64>,
    /// Filtered, metres.
    pub after_m: Vec<f64>,
    /// Distance between both over whole test takes, each finger.
    pub moved: PerFinger<Statistics>,
}

/// Power spectral density of fingertip coordinates, averaged over the test takes, fingers and axes (Welch).
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Frequencies, Hz.
    pub frequency_hz: Vec<f64>,
    /// Before the filter, m²/Hz.
    pub before_m2_hz: Vec<f64>,
    /// After it.
    pub after_m2_hz: Vec<f64>,
    /// Samples in a window.
    pub window: usize,
    /// Windows averaged.
    pub windows: usize,
}

/// A test segment as recorded and as methods planned it.
#[derive(Clone, Debug, PartialEq)]
pub struct PathExample {
    /// Why it is shown: `median` or `worst`.
    pub why: &'static str,
    /// Take.
    pub take: String,
    /// Segment, counted over all takes.
    pub segment: usize,
    /// Its begin, seconds since the take's first sample.
    pub start_s: f64,
    /// Samples a second.
    pub rate_hz: f64,
    /// Recorded.
    pub recorded_m: Path,
    /// Each method whose plan has a trajectory.
    pub methods: Vec<(String, Path)>,
}

/// One of the worst errors of the default method, one for each segment.
#[derive(Clone, Debug, PartialEq)]
pub struct WorstCase {
    /// Method.
    pub method: String,
    /// Take.
    pub take: String,
    /// File of the take in the results, relative to the report.
    pub file: String,
    /// Topic of the planned fingertips in it.
    pub topic: String,
    /// Finger.
    pub finger: Finger,
    /// Segment, counted over all takes.
    pub segment: usize,
    /// The instant, seconds since the take's first sample.
    pub time_s: f64,
    /// The error there, metres.
    pub error_m: f64,
    /// The error of this finger at every instant of the segment, metres.
    pub errors_m: Vec<f64>,
}

/// A primitive of a dictionary as a path.
#[derive(Clone, Debug, PartialEq)]
pub struct PrimitivePath {
    /// Its place in the dictionary.
    pub index: usize,
    /// Share of all activations, 0 to 1.
    pub share: f64,
    /// Each finger; offsets in metres, as the dictionary holds it.
    pub path_m: Path,
}

/// How much of the training segments' variance dictionaries explain.
#[derive(Clone, Debug, PartialEq)]
pub struct ExplainedVariance {
    /// Ranks with the share of variance about the mean segment that the best dictionary of that rank explains (principal
    /// components), 0 to 1.
    pub principal: Vec<(usize, f64)>,
    /// Rank and share of the dictionary that was learned.
    pub learned: (usize, f64),
    /// Segments.
    pub segments: usize,
}

/// How distances to a cloud of points on the object differ from those to its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointCloud {
    /// Points of the cloud.
    pub points: usize,
    /// Distance to the nearest point less the distance to the surface, metres, over all fingers and recorded
    /// instants; not below 0.
    pub excess_m: Statistics,
    /// Share of the instants with three or more contacts by the cloud.
    pub three_or_more: f64,
    /// The same by the surface.
    pub exact_three_or_more: f64,
}
