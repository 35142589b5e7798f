//! Intervals of a session against plain resampling of the very draws.

use inhand_evaluation::{Contestant, session_intervals};
use inhand_model::{
    Bootstrap, Cluster, EvaluationRows, Finger, Intervals, Measure, MethodRows, PairedDifference,
    PerFinger, SegmentLayout, SegmentOrigin,
};
use inhand_statistics::bootstrap::draw_clusters;
use inhand_statistics::quantiles::statistics;

const SAMPLES: usize = 4;
const SEGMENTS: usize = 9;
const TAU_M: f64 = 0.005;

const BOOTSTRAP: Bootstrap = Bootstrap {
    cluster: Cluster::Segment,
    draws: 300,
    seed: 5,
    confidence: 0.9,
};

/// Numbers that differ from segment to segment and finger to finger, of a level of its own.
fn errors(level: f64) -> Vec<PerFinger<f64>> {
    (0..SEGMENTS * SAMPLES)
        .map(|k| {
            PerFinger::from_fn(|finger| {
                let place = (k / SAMPLES * 7 + k * 3 + finger.index() * 11) as f64;
                level * (0.1 + (place * 0.618_033_988_749_895).fract())
            })
        })
        .collect()
}

/// The plan of one segment of `gappy` failed. The cubic has two contacts where the recording has three.
fn rows() -> EvaluationRows {
    let touching = |fingers: usize| {
        PerFinger::from_fn(|finger| {
            if finger.index() < fingers {
                0.004
            } else {
                0.006
            }
        })
    };
    let distance_m = |fingers: usize| Some(vec![touching(fingers); SEGMENTS * SAMPLES]);
    let method = |name: &str, level, fingers| MethodRows {
        name: name.to_owned(),
        error_m: errors(level),
        distance_m: distance_m(fingers),
        hull_distance_m: vec![PerFinger::new([0.0; 5]); SEGMENTS * SAMPLES],
        nearest_pair_m: vec![0.02; SEGMENTS * SAMPLES],
        object_position_error_m: None,
        object_angle_error_rad: None,
        mahalanobis: None,
    };
    let mut gappy = method("gappy", 0.0015, 3);
    gappy.error_m[SAMPLES..2 * SAMPLES].fill(PerFinger::new([f64::NAN; 5]));
    EvaluationRows {
        layout: SegmentLayout {
            samples: SAMPLES,
            rate_hz: 4.0,
            object: false,
        },
        takes: vec!["take".to_owned()],
        segments: (0..SEGMENTS)
            .map(|s| SegmentOrigin {
                take: 0,
                start: s * SAMPLES,
            })
            .collect(),
        filled: vec![PerFinger::new([false; 5]); SEGMENTS * SAMPLES],
        object_filled: vec![false; SEGMENTS * SAMPLES],
        recorded_distance_m: distance_m(3),
        recorded_hull_distance_m: vec![PerFinger::new([0.0; 5]); SEGMENTS * SAMPLES],
        recorded_nearest_pair_m: vec![0.02; SEGMENTS * SAMPLES],
        methods: vec![
            method("learned", 0.001, 3),
            gappy,
            method("cubic", 0.002, 2),
            method("line", 0.003, 3),
        ],
    }
}

fn pooled(rows: &MethodRows, segment: usize, finger: Option<Finger>) -> Vec<f64> {
    let of_segment = &rows.error_m[segment * SAMPLES..][..SAMPLES];
    let fingers = Finger::ALL
        .into_iter()
        .filter(|f| finger.is_none_or(|finger| finger == *f));
    fingers
        .flat_map(|finger| of_segment.iter().map(move |errors| errors[finger]))
        .filter(|error| error.is_finite())
        .collect()
}

fn found(rows: &EvaluationRows) -> Intervals {
    let contestants: Vec<Contestant<'_>> = (rows.methods.iter())
        .map(|method| {
            let all = (0..SEGMENTS)
                .flat_map(|s| pooled(method, s, None))
                .collect();
            Contestant {
                name: &method.name,
                baseline: ["cubic", "line"].contains(&method.name.as_str()),
                mean_error_m: statistics(all, 0, 0).mean,
            }
        })
        .collect();
    session_intervals(rows, &contestants, "learned", TAU_M, BOOTSTRAP).expect("sound settings")
}

/// p75 of a method's errors in the segments of a draw.
fn p75(rows: &MethodRows, times: &[u32], finger: Option<Finger>) -> f64 {
    let drawn = (times.iter().enumerate())
        .flat_map(|(s, &times)| pooled(rows, s, finger).repeat(times as usize));
    statistics(drawn.collect(), 0, 0).p75
}

fn ends(of_draw: impl Fn(&[u32]) -> f64) -> [f64; 2] {
    let values = (0..BOOTSTRAP.draws as u64)
        .map(|draw| {
            let mut times = [0; SEGMENTS];
            draw_clusters(BOOTSTRAP.seed, draw, &mut times);
            of_draw(&times)
        })
        .collect();
    // At a confidence of 0.9 the ends are the 5 % and 95 % quantiles of the draws.
    let drawn = statistics(values, 0, 0);
    [drawn.p5, drawn.p95]
}

fn difference<'a>(
    intervals: &'a Intervals,
    method: &str,
    other: &str,
    finger: Option<Finger>,
) -> Option<&'a PairedDifference> {
    intervals.differences.iter().find(|d| {
        d.method == method && d.other == other && d.finger == finger && d.measure == Measure::P75
    })
}

#[test]
fn intervals_are_those_of_the_rows_of_the_draws() {
    let rows = rows();
    let found = found(&rows);
    assert_eq!(found.best_baseline.as_deref(), Some("cubic"));
    for (method, intervals) in rows.methods.iter().zip(&found.methods) {
        // Not in the order of work, which has the baseline first.
        assert_eq!(intervals.method, method.name);
        for finger in [None, Some(Finger::Ring)] {
            let found = match finger {
                None => &intervals.error.all,
                Some(finger) => &intervals.error.by_finger[finger],
            };
            let found = found.as_ref().expect("there are rows")[3];
            let clusters = if method.name == "gappy" {
                SEGMENTS - 1
            } else {
                SEGMENTS
            };
            let fingers = if finger.is_none() { 5 } else { 1 };
            assert_eq!(
                (found.n, found.clusters),
                (clusters * SAMPLES * fingers, clusters)
            );
            assert_eq!(found.value, p75(method, &[1; SEGMENTS], finger));
            assert_eq!(
                found.interval,
                Some(ends(|times| p75(method, times, finger)))
            );
        }
    }
}

#[test]
fn differences_are_drawn_together() {
    let rows = rows();
    let found = found(&rows);
    let [learned, gappy, cubic, _] = &rows.methods[..] else {
        panic!("four methods")
    };
    for (method, other, finger) in [
        (learned, cubic, None),
        (learned, cubic, Some(Finger::Index)),
        (gappy, cubic, None),
        (gappy, learned, None),
    ] {
        let found = difference(&found, &method.name, &other.name, finger).expect("compared");
        // Where the plan of one failed the other is not looked at either.
        let common = |times: &[u32]| -> Vec<u32> {
            (times.iter().enumerate())
                .map(|(s, &times)| times * u32::from(method.name != "gappy" || s != 1))
                .collect()
        };
        let p75 = |of, times: &[u32]| p75(of, &common(times), finger);
        let less = |times: &[u32]| p75(method, times) - p75(other, times);
        assert_eq!(
            found.absolute.clusters,
            if method.name == "gappy" { 8 } else { 9 }
        );
        assert_eq!(found.absolute.value, less(&[1; SEGMENTS]));
        assert_eq!(found.absolute.interval, Some(ends(less)));
        let relative = |times: &[u32]| less(times) / p75(other, times);
        // Half of it in every draw is no spread, and no interval.
        let spread = Some(ends(relative)).filter(|[low, high]| low < high);
        assert_eq!(found.relative.and_then(|r| r.interval), spread);
    }
    // Half the level everywhere: half the error in every segment, whatever is drawn.
    let halved = difference(&found, "learned", "cubic", None).expect("compared");
    let relative = halved.relative.expect("the other is not 0");
    assert!((relative.value + 0.5).abs() < 1e-12);
    assert_eq!(halved.share_better, 1.0);
    // No method is compared with itself, and not twice with the same.
    assert!(difference(&found, "learned", "learned", None).is_none());
    let pairs = found.differences.iter().filter(|d| d.finger.is_none());
    assert_eq!(pairs.count(), Measure::ALL.len() * 5);
}

#[test]
fn contact_shares_have_intervals_and_are_set_against_the_recording() {
    let found = found(&rows());
    let of = |place: usize| {
        let method = &found.methods[place];
        let value = |e: Option<inhand_model::Estimate>| e.expect("an object is known").value;
        (
            value(method.three_or_more),
            value(method.three_or_more_less_recorded),
        )
    };
    assert_eq!((of(0), of(2)), ((1.0, 0.0), (0.0, -1.0)));
    assert_eq!(
        found.methods[0].three_or_more.map(|e| e.n),
        Some(SEGMENTS * SAMPLES)
    );
}

#[test]
fn one_segment_has_no_interval_and_nothing_judged_has_no_statistic() {
    let mut rows = rows();
    for method in &mut rows.methods {
        method.error_m[SAMPLES..].fill(PerFinger::new([f64::NAN; 5]));
    }
    rows.methods[1].error_m.fill(PerFinger::new([f64::NAN; 5]));
    let found = found(&rows);
    let alone = found.methods[0].error.all.expect("one segment is judged")[0];
    assert_eq!((alone.clusters, alone.interval), (1, None));
    assert_eq!(found.methods[1].error.all, None);
    assert!(difference(&found, "gappy", "cubic", None).is_none());
}
