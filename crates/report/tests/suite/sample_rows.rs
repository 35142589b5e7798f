//! Rows and intervals of the sample, from closed forms as its numbers are.

use inhand_model::{
    Bootstrap, Cluster, Estimate, Evaluation, EvaluationRows, Finger, HandAndFingers, Intervals,
    Measure, MethodIntervals, MethodRows, PairedDifference, PerFinger, SegmentLayout,
    SegmentOrigin,
};

const SEGMENTS: usize = 30;
const SAMPLES: usize = 100;

/// Whether nothing is known at a place: a gap of the ring finger in the fifth segment.
fn unknown(segment: usize, sample: usize, finger: Finger) -> bool {
    segment == 4 && (40..60).contains(&sample) && finger == Finger::Ring
}

fn error_m(median: f64, segment: usize, sample: usize, finger: Finger) -> f64 {
    if unknown(segment, sample, finger) {
        return f64::NAN;
    }
    let t = sample as f64 / (SAMPLES - 1) as f64;
    let size = 0.4 + 0.09 * segment as f64 + 0.1 * finger.index() as f64;
    median * size * (2.0 * t * (1.0 - t) + 0.1 * (1.0 + (9.0 * t + segment as f64).sin()))
}

/// A finger's distance to the object: it lifts now and then, the more the larger `lift`.
fn distance_m(lift: f64, segment: usize, sample: usize, finger: Finger) -> f64 {
    if unknown(segment, sample, finger) {
        return f64::NAN;
    }
    let seconds = segment as f64 + sample as f64 / SAMPLES as f64;
    let phase = 0.7 * seconds + 1.3 * finger.index() as f64;
    0.004 * phase.sin() + 0.003 * lift * (0.31 * phase).cos()
}

/// Rows for every method of the evaluation, with distances unless `object` is false.
pub(crate) fn rows(evaluation: &Evaluation, object: bool) -> EvaluationRows {
    let places = || (0..SEGMENTS).flat_map(|segment| (0..SAMPLES).map(move |t| (segment, t)));
    let distances = |lift: f64| -> Option<Vec<PerFinger<f64>>> {
        let at = |(segment, t)| PerFinger::from_fn(|finger| distance_m(lift, segment, t, finger));
        object.then(|| places().map(at).collect())
    };
    let method = |(place, method): (usize, &inhand_model::MethodEvaluation)| MethodRows {
        name: method.name.clone(),
        error_m: places()
            .map(|(segment, t)| {
                PerFinger::from_fn(|finger| error_m(method.error.all.p50, segment, t, finger))
            })
            .collect(),
        distance_m: distances(1.0 + 0.2 * place as f64),
        hull_distance_m: places().map(|_| PerFinger::new([-0.001; 5])).collect(),
        nearest_pair_m: places().map(|_| 0.02).collect(),
        object_position_error_m: None,
        object_angle_error_rad: None,
        mahalanobis: None,
    };
    EvaluationRows {
        layout: SegmentLayout::one_second(SAMPLES as f64),
        takes: (evaluation.session.test.iter())
            .map(|take| take.name.clone())
            .collect(),
        segments: (0..SEGMENTS)
            .map(|segment| SegmentOrigin {
                take: 0,
                start: 4 + SAMPLES * segment,
            })
            .collect(),
        filled: vec![PerFinger::new([false; 5]); SEGMENTS * SAMPLES],
        object_filled: vec![false; SEGMENTS * SAMPLES],
        recorded_distance_m: distances(1.0),
        recorded_hull_distance_m: places().map(|_| PerFinger::new([-0.001; 5])).collect(),
        recorded_nearest_pair_m: places().map(|_| 0.02).collect(),
        methods: evaluation.methods.iter().enumerate().map(method).collect(),
    }
}

fn estimate(value: f64, spread: f64) -> Estimate {
    Estimate {
        value,
        n: SEGMENTS * SAMPLES * Finger::COUNT,
        clusters: SEGMENTS,
        standard_error: Some(0.5 * spread),
        interval: Some([value - spread, value + spread]),
    }
}

/// Intervals for every method, and differences from `hermite`.
pub(crate) fn intervals(evaluation: &Evaluation) -> Intervals {
    let baseline = evaluation
        .methods
        .iter()
        .find(|method| method.name.starts_with("hermite"));
    let baseline = baseline.expect("the sample has this baseline");
    let of = |measure: Measure, s: &inhand_model::Statistics| match measure {
        Measure::Mean => s.mean,
        Measure::Rmse => s.rmse,
        Measure::P50 => s.p50,
        Measure::P75 => s.p75,
        Measure::P95 => s.p95,
    };
    let estimates = |s: &inhand_model::Statistics| {
        Measure::ALL.map(|measure| estimate(of(measure, s), 0.06 * of(measure, s)))
    };
    let methods = evaluation.methods.iter().map(|method| MethodIntervals {
        method: method.name.clone(),
        error: HandAndFingers {
            all: Some(estimates(&method.error.all)),
            by_finger: PerFinger::from_fn(|f| Some(estimates(&method.error.by_finger[f]))),
        },
        three_or_more: method
            .contact
            .as_ref()
            .map(|c| estimate(c.three_or_more, 0.003)),
        three_or_more_less_recorded: (method.contact.as_ref())
            .map(|c| estimate(c.three_or_more - c.recorded_three_or_more, 0.003)),
    });
    let others = evaluation
        .methods
        .iter()
        .filter(|method| method.name != baseline.name);
    let differences = others.flat_map(|method| {
        Measure::ALL.map(|measure| {
            let (own, other) = (
                of(measure, &method.error.all),
                of(measure, &baseline.error.all),
            );
            PairedDifference {
                method: method.name.clone(),
                other: baseline.name.clone(),
                finger: None,
                measure,
                absolute: estimate(own - other, 0.05 * other),
                relative: Some(estimate(own / other - 1.0, 0.05)),
                share_better: if own < other { 0.8 } else { 0.1 },
            }
        })
    });
    Intervals {
        bootstrap: Bootstrap {
            cluster: Cluster::Segment,
            draws: 2000,
            seed: 0,
            confidence: 0.95,
        },
        methods: methods.collect(),
        best_baseline: Some(baseline.name.clone()),
        differences: differences.collect(),
    }
}
