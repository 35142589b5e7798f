//! Confidence intervals of an evaluation, and differences between methods.

use serde::{Deserialize, Serialize};

use crate::finger::{Finger, HandAndFingers};
use crate::names::named;
use crate::units::{AsIs, Millimetres, Numbers, Unit};

/// A statistic with its percentile bootstrap interval. All of them are in the unit of the statistic.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The statistic of all rows.
    #[serde(with = "AsIs")]
    pub value: f64,
    /// Lower and upper end; `None` with fewer than [`FEWEST_CLUSTERS`](Self::FEWEST_CLUSTERS), and where no
    /// draw differs from another.
    #[serde(flatten, with = "ends")]
    pub interval: Option<[f64; 2]>,
    /// Standard deviation over the draws; `None` where there is no interval.
    #[serde(with = "AsIs")]
    pub standard_error: Option<f64>,
    /// Rows it is made of.
    pub n: usize,
    /// Clusters with at least one of these rows.
    pub clusters: usize,
}

impl Numbers for Estimate {
    type Written = Estimate;

    fn write(&self, unit: fn(f64) -> f64) -> Estimate {
        Estimate {
            value: unit(self.value),
            interval: self.interval.map(|ends| ends.map(unit)),
            standard_error: self.standard_error.map(unit),
            ..*self
        }
    }

    fn read(written: Estimate, unit: fn(f64) -> f64) -> Self {
        written.write(unit)
    }
}

impl Estimate {
    /// Percentile intervals of fewer clusters are so much too narrow that none is better: of two they are the two
    /// clusters, and hold the true value hardly every second time.
    pub const FEWEST_CLUSTERS: usize = 5;
}

named! {
    /// What is drawn with replacement, with all of its rows.
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Cluster {
        /// Segments of one session: the interval is about other segments of the same hand and object.
        Segment = "segment",
        /// Sessions: the interval is about other sessions of the same kind.
        Session = "session",
    }
}

/// How intervals were made.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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

named! {
    /// A statistic of errors that has an interval.
    #[derive(PartialOrd, Ord, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Measure {
        /// Arithmetic mean.
        Mean = "mean",
        /// Root of the mean square.
        Rmse = "rmse",
        /// Median.
        P50 = "p50",
        /// Third quartile.
        P75 = "p75",
        /// 95 % quantile.
        P95 = "p95",
    }
}

/// An estimate for each of [`Measure::ALL`].
pub type MeasureEstimates = [Estimate; Measure::ALL.len()];

/// Estimates in a document, by the names of their measures.
#[derive(Serialize, Deserialize)]
pub(crate) struct EstimatesByName {
    mean: Estimate,
    rmse: Estimate,
    p50: Estimate,
    p75: Estimate,
    p95: Estimate,
}

impl Numbers for MeasureEstimates {
    type Written = EstimatesByName;

    fn write(&self, unit: fn(f64) -> f64) -> EstimatesByName {
        let [mean, rmse, p50, p75, p95] = self.map(|estimate| estimate.write(unit));
        EstimatesByName {
            mean,
            rmse,
            p50,
            p75,
            p95,
        }
    }

    fn read(written: EstimatesByName, unit: fn(f64) -> f64) -> Self {
        let EstimatesByName {
            mean,
            rmse,
            p50,
            p75,
            p95,
        } = written;
        [mean, rmse, p50, p75, p95].map(|estimate| Estimate::read(estimate, unit))
    }
}

/// Intervals of one method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MethodIntervals {
    /// Name of the method.
    #[serde(rename = "name")]
    pub method: String,
    /// Error over all instants, of all fingers together and of each, metres, in the order of [`Measure::ALL`]; `None` where no
    /// instant was judged.
    #[serde(rename = "error_mm", with = "Millimetres")]
    pub error: HandAndFingers<Option<MeasureEstimates>>,
    /// Share of instants with three or more contacts, 0 to 1; `None` without an object.
    pub three_or_more: Option<Estimate>,
    /// That share less the recorded one at the same instants.
    pub three_or_more_less_recorded: Option<Estimate>,
}

/// How the errors of one method differ from those of another, on the clusters in which both judged the same
/// instants: those in which a plan of one failed are left out for both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairedDifference {
    /// The method.
    pub method: String,
    /// The one it is compared with.
    pub other: String,
    /// The finger; `None` for all of them together.
    #[serde(with = "finger_or_all")]
    pub finger: Option<Finger>,
    /// Of which statistic.
    pub measure: Measure,
    /// Statistic of the method less that of the other, metres: below 0 the method is better.
    #[serde(rename = "absolute_mm", with = "Millimetres")]
    pub absolute: Estimate,
    /// The difference over the statistic of the other, no unit; `None` where that is 0.
    pub relative: Option<Estimate>,
    /// Share of clusters in which the method has the smaller one, a tie counting half: 0.5 is chance.
    #[serde(with = "AsIs")]
    pub share_better: f64,
}

/// Intervals of all methods of an evaluation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Intervals {
    /// How they were made.
    #[serde(flatten)]
    pub bootstrap: Bootstrap,
    /// The baseline with the smallest mean error over all fingers and instants; `None` without baselines.
    pub best_baseline: Option<String>,
    /// Each method, in the order of the evaluation.
    pub methods: Vec<MethodIntervals>,
    /// For all fingers together every method against the best baseline and against the default method; the
    /// default method against the best baseline for each finger as well.
    pub differences: Vec<PairedDifference>,
}

/// Ends of an interval as two keys, null where there is none.
mod ends {
    use super::{AsIs, Unit};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Serialize, Deserialize)]
    struct Keys {
        #[serde(with = "AsIs")]
        low: Option<f64>,
        #[serde(with = "AsIs")]
        high: Option<f64>,
    }

    pub(super) fn serialize<S: Serializer>(
        ends: &Option<[f64; 2]>,
        s: S,
    ) -> Result<S::Ok, S::Error> {
        let [low, high] = ends.map_or([None; 2], |ends| ends.map(Some));
        Keys { low, high }.serialize(s)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        d: D,
    ) -> Result<Option<[f64; 2]>, D::Error> {
        let Keys { low, high } = Keys::deserialize(d)?;
        Ok(low.zip(high).map(|(low, high)| [low, high]))
    }
}

/// A finger's name, or `all`.
pub(crate) mod finger_or_all {
    use super::Finger;
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    const ALL: &str = "all";

    pub(crate) fn serialize<S: Serializer>(
        finger: &Option<Finger>,
        s: S,
    ) -> Result<S::Ok, S::Error> {
        finger.map_or(ALL, Finger::name).serialize(s)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Option<Finger>, D::Error> {
        let name = String::deserialize(d)?;
        (name != ALL)
            .then(|| name.parse().map_err(D::Error::custom))
            .transpose()
    }
}
