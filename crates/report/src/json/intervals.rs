//! Intervals and paired differences in the document.

use inhand_model::{
    Bootstrap, Cluster, Estimate, Finger, Intervals, Measure, MethodIntervals, PairedDifference,
    PerFinger,
};
use serde::{Deserialize, Serialize};

use super::read::{number, word};
use super::wire::{ByFinger, Number};
use crate::error::ReportError;

const MM_PER_M: f64 = 1e3;
/// Shares and relative differences stay as they are.
const NO_UNIT: f64 = 1.0;
/// In the place of a finger's name.
const ALL_FINGERS: &str = "all";

#[derive(Serialize, Deserialize)]
pub(super) struct Document {
    cluster: String,
    draws: usize,
    seed: u64,
    confidence: f64,
    best_baseline: Option<String>,
    methods: Vec<Method>,
    differences: Vec<Difference>,
}

#[derive(Serialize, Deserialize)]
struct Method {
    name: String,
    error_mm: Errors,
    three_or_more: Option<Interval>,
    three_or_more_less_recorded: Option<Interval>,
}

#[derive(Serialize, Deserialize)]
struct Errors {
    all: Option<Measures>,
    #[serde(flatten)]
    by_finger: ByFinger<Option<Measures>>,
}

#[derive(Serialize, Deserialize)]
struct Measures {
    mean: Interval,
    rmse: Interval,
    p50: Interval,
    p75: Interval,
    p95: Interval,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Interval {
    value: Number,
    low: Number,
    high: Number,
    standard_error: Number,
    n: usize,
    clusters: usize,
}

#[derive(Serialize, Deserialize)]
struct Difference {
    method: String,
    other: String,
    finger: String,
    measure: String,
    absolute_mm: Interval,
    relative: Option<Interval>,
    share_better: Number,
}

/// What is written.
pub(super) fn document(intervals: &Intervals) -> Document {
    let Bootstrap {
        cluster,
        draws,
        seed,
        confidence,
    } = intervals.bootstrap;
    Document {
        cluster: cluster.name().to_owned(),
        draws,
        seed,
        confidence,
        best_baseline: intervals.best_baseline.clone(),
        methods: intervals.methods.iter().map(method).collect(),
        differences: intervals.differences.iter().map(difference).collect(),
    }
}

fn method(found: &MethodIntervals) -> Method {
    let measures = |found: &Option<[Estimate; 5]>| {
        found.map(|found| {
            let [mean, rmse, p50, p75, p95] = found.map(|found| interval(&found, MM_PER_M));
            Measures {
                mean,
                rmse,
                p50,
                p75,
                p95,
            }
        })
    };
    let share = |found: &Option<Estimate>| found.as_ref().map(|found| interval(found, NO_UNIT));
    Method {
        name: found.method.clone(),
        error_mm: Errors {
            all: measures(&found.error),
            by_finger: ByFinger::from_fn(|finger| measures(&found.error_by_finger[finger])),
        },
        three_or_more: share(&found.three_or_more),
        three_or_more_less_recorded: share(&found.three_or_more_less_recorded),
    }
}

fn difference(found: &PairedDifference) -> Difference {
    Difference {
        method: found.method.clone(),
        other: found.other.clone(),
        finger: found.finger.map_or(ALL_FINGERS, Finger::name).to_owned(),
        measure: found.measure.name().to_owned(),
        absolute_mm: interval(&found.absolute, MM_PER_M),
        relative: found.relative.map(|found| interval(&found, NO_UNIT)),
        share_better: Number::finite(found.share_better),
    }
}

pub(super) fn interval(found: &Estimate, factor: f64) -> Interval {
    let scaled = |value: Option<f64>| Number::finite(value.map_or(f64::NAN, |v| v * factor));
    Interval {
        value: scaled(Some(found.value)),
        low: scaled(found.interval.map(|[low, _]| low)),
        high: scaled(found.interval.map(|[_, high]| high)),
        standard_error: scaled(found.standard_error),
        n: found.n,
        clusters: found.clusters,
    }
}

/// What was written, back.
pub(super) fn intervals(document: Document) -> Result<Intervals, ReportError> {
    let cluster = word(
        "intervals.cluster",
        &document.cluster,
        "segment or session",
        &[Cluster::Segment, Cluster::Session],
        Cluster::name,
    )?;
    Ok(Intervals {
        bootstrap: Bootstrap {
            cluster,
            draws: document.draws,
            seed: document.seed,
            confidence: document.confidence,
        },
        best_baseline: document.best_baseline,
        methods: document.methods.into_iter().map(read_method).collect(),
        differences: (document.differences.into_iter())
            .map(read_difference)
            .collect::<Result<_, _>>()?,
    })
}

fn read_method(method: Method) -> MethodIntervals {
    let measures = |measures: Option<Measures>| {
        measures.map(|m| [m.mean, m.rmse, m.p50, m.p75, m.p95].map(|i| estimate(&i, MM_PER_M)))
    };
    let share = |share: Option<Interval>| share.map(|share| estimate(&share, NO_UNIT));
    MethodIntervals {
        method: method.name,
        error: measures(method.error_mm.all),
        error_by_finger: PerFinger::new(method.error_mm.by_finger.into_array()).map(measures),
        three_or_more: share(method.three_or_more),
        three_or_more_less_recorded: share(method.three_or_more_less_recorded),
    }
}

fn read_difference(found: Difference) -> Result<PairedDifference, ReportError> {
    let finger = match found.finger.as_str() {
        ALL_FINGERS => None,
        name => Some(word(
            "intervals.differences.finger",
            name,
            "all, thumb, index, middle, ring or little",
            &Finger::ALL,
            Finger::name,
        )?),
    };
    let measure = word(
        "intervals.differences.measure",
        &found.measure,
        "mean, rmse, p50, p75 or p95",
        &Measure::ALL,
        Measure::name,
    )?;
    Ok(PairedDifference {
        method: found.method,
        other: found.other,
        finger,
        measure,
        absolute: estimate(&found.absolute_mm, MM_PER_M),
        relative: (found.relative).map(|found| estimate(&found, NO_UNIT)),
        share_better: number(found.share_better),
    })
}

fn estimate(interval: &Interval, factor: f64) -> Estimate {
    let scaled = |number: Number| number.0.map(|value| value / factor);
    Estimate {
        value: scaled(interval.value).unwrap_or(f64::NAN),
        n: interval.n,
        clusters: interval.clusters,
        standard_error: scaled(interval.standard_error),
        interval: (scaled(interval.low).zip(scaled(interval.high))).map(|(low, high)| [low, high]),
    }
}
