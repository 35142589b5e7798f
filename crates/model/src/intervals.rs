//! Confidence intervals of an evaluation, and differences between methods.

use crate::finger::{Finger, PerFinger};

/// A statistic with its percentile bootstrap interval. All of them are in the unit of the statistic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The statistic of all rows.
    pub value: f64,
    /// Rows it is made of.
    pub n: usize,
    /// Clusters with at least one of these rows.
    pub clusters: usize,
    /// Standard deviation over the draws; `None` where there is no interval.
    pub standard_error: Option<f64>,
    /// Lower and upper end; `None` with fewer than [`FEWEST_CLUSTERS`](Self::FEWEST_CLUSTERS), and where no
    /// draw differs from another.
    pub interval: Option<[f64; 2]>,
}

impl Estimate {
    /// Percentile intervals of fewer clusters are so much too narrow that none is better: of two they are the two
    /// clusters, and hold the true value hardly every second time.
    pub const FEWEST_CLUSTERS: usize = 5;
}

/// What is drawn with replacement, with all of its rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cluster {
    /// Segments of one session: the interval is about other segments of the same hand and object.
    Segment,
    /// Sessions: the interval is about other sessions of the same kind.
    Session,
}

impl Cluster {
    /// Lower-case name, as in files.
    pub const fn name(self) -> &'static str {
        match self {
            Cluster::Segment => "segment",
            Cluster::Session => "session",
        }
    }
}

/// How intervals were made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bootstrap {
    /// What was drawn.
    pub cluster: Cluster,
    /// How often.
    pub draws: usize,
    /// Seed of the draws.
    pub seed: u64,
    /// Share of the draws inside an interval, such as 0.95.
    pub confidence: f64,
}

/// A statistic of errors that has an interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Measure {
    /// Arithmetic mean.
    Mean,
    /// Root of the mean square.
    Rmse,
    /// Median.
    P50,
    /// Third quartile.
    P75,
    /// 95 % quantile.
    P95,
}

impl Measure {
    /// All of them, in the order of tables.
    pub const ALL: [Measure; 5] = [
        Measure::Mean,
        Measure::Rmse,
        Measure::P50,
        Measure::P75,
        Measure::P95,
    ];

    /// Lower-case name, as in files and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Measure::Mean => "mean",
            Measure::Rmse => "rmse",
            Measure::P50 => "p50",
            Measure::P75 => "p75",
            Measure::P95 => "p95",
        }
    }
}

/// Intervals of one method.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodIntervals {
    /// Name of the method.
    pub method: String,
    /// Error over all fingers and instants, metres, in the order of [`Measure::ALL`]; `None` where no
    /// instant was judged.
    pub error: Option<[Estimate; Measure::ALL.len()]>,
    /// The same, each finger.
    pub error_by_finger: PerFinger<Option<[Estimate; Measure::ALL.len()]>>,
    /// Share of instants with three or more contacts, 0 to 1; `None` without an object.
    pub three_or_more: Option<Estimate>,
    /// That share less the recorded one at the same instants.
    pub three_or_more_less_recorded: Option<Estimate>,
}

/// How the errors of one method differ from those of another, on the clusters in which both judged the same
/// instants: those in which a plan of one failed are left out for both.
#[derive(Clone, Debug, PartialEq)]
pub struct PairedDifference {
    /// The method.
    pub method: String,
    /// The one it is compared with.
    pub other: String,
    /// The finger; `None` for all of them together.
    pub finger: Option<Finger>,
    /// Of which statistic.
    pub measure: Measure,
    /// Statistic of the method less that of the other, metres: below 0 the method is better.
    pub absolute: Estimate,
    /// The difference over the statistic of the other, no unit; `None` where that is 0.
    pub relative: Option<Estimate>,
    /// Share of clusters in which the method has the smaller one, a tie counting half: 0.5 is chance.
    pub share_better: f64,
}

/// Intervals of all methods of an evaluation.
#[derive(Clone, Debug, PartialEq)]
pub struct Intervals {
    /// How they were made.
    pub bootstrap: Bootstrap,
    /// Each method, in the order of the evaluation.
    pub methods: Vec<MethodIntervals>,
    /// The baseline with the smallest mean error over all fingers and instants; `None` without baselines.
    pub best_baseline: Option<String>,
    /// For all fingers together every method against the best baseline and against the default method; the
    /// default method against the best baseline for each finger as well.
    pub differences: Vec<PairedDifference>,
}
