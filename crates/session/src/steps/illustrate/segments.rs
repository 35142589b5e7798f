//! A usual segment, the worst ones, and where to look at them.

use inhand_model::{Finger, MethodRows, Path, PathExample, PerFinger, Position, WorstCase};

use super::Illustrated;
use crate::steps::Generated;

/// How many of the worst are listed.
const WORST: usize = 10;

/// The segments whose error of the default method is the median and the largest, each by its mean over
/// instants and fingers; of segments equally bad the first.
pub(super) fn paths(run: &Illustrated<'_>) -> Vec<PathExample> {
    let Some(rows) = run.rows.methods.first() else {
        return Vec::new();
    };
    let mut means: Vec<(f64, usize)> = (0..run.test.len())
        .filter_map(|segment| Some((mean_error_m(run, rows, segment)?, segment)))
        .collect();
    means.sort_by(|(a, i), (b, j)| a.total_cmp(b).then(j.cmp(i)));
    let (Some(&(_, worst)), Some(&(_, median))) =
        (means.last(), means.get((means.len().max(1) - 1) / 2))
    else {
        return Vec::new();
    };
    let mut examples = vec![example(run, "median", median)];
    if worst != median {
        examples.push(example(run, "worst", worst));
    }
    examples
}

fn mean_error_m(run: &Illustrated<'_>, rows: &MethodRows, segment: usize) -> Option<f64> {
    let samples = run.rows.layout.samples;
    let instants = rows
        .error_m
        .get(segment * samples..(segment + 1) * samples)?;
    let errors = instants.iter().flat_map(PerFinger::as_array);
    let mean = errors.sum::<f64>() / (Finger::COUNT * samples) as f64;
    mean.is_finite().then_some(mean)
}

fn example(run: &Illustrated<'_>, why: &'static str, segment: usize) -> PathExample {
    let origin = run.test.origins()[segment];
    let (layout, motion) = (run.test.layout(), run.test_motions.get(origin.take));
    let samples = 0..layout.samples;
    let of_method = |generated: &Generated| -> Option<(String, Path)> {
        let trajectory = generated.trajectories.get(segment)?.as_ref()?;
        let points = |finger| samples.clone().map(move |t| trajectory.position(t, finger));
        let path = PerFinger::from_fn(|finger| points(finger).map(Position::to_array).collect());
        Some((generated.method.name().to_owned(), path))
    };
    PathExample {
        why,
        take: run.rows.takes.get(origin.take).cloned().unwrap_or_default(),
        segment,
        start_s: motion.map_or(0.0, |motion| motion.clock.time_s(origin.start)),
        rate_hz: layout.rate_hz,
        recorded_m: PerFinger::from_fn(|finger| {
            let points = samples.clone();
            points
                .map(|t| run.test.position(segment, t, finger).to_array())
                .collect()
        }),
        methods: run.generated.iter().filter_map(of_method).collect(),
    }
}

/// The largest errors of the default method, one a segment, largest first.
pub(super) fn worst(run: &Illustrated<'_>) -> Vec<WorstCase> {
    let (Some(rows), samples) = (run.rows.methods.first(), run.rows.layout.samples) else {
        return Vec::new();
    };
    let mut cases: Vec<(f64, usize, usize, Finger)> = Vec::new();
    for (segment, instants) in rows.error_m.chunks(samples.max(1)).enumerate() {
        let mut largest: Option<(f64, usize, usize, Finger)> = None;
        for (t, errors) in instants.iter().enumerate() {
            for (finger, &error_m) in errors.iter() {
                // Never true of NaN, as where a plan failed.
                if error_m > largest.map_or(f64::NEG_INFINITY, |(most, ..)| most) {
                    largest = Some((error_m, segment, t, finger));
                }
            }
        }
        cases.extend(largest);
    }
    cases.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    cases.truncate(WORST);
    (cases.into_iter())
        .map(|(error_m, segment, t, finger)| {
            let origin = run.test.origins()[segment];
            let take = run.rows.takes.get(origin.take).cloned().unwrap_or_default();
            let motion = run.test_motions.get(origin.take);
            let instants = &rows.error_m[segment * samples..(segment + 1) * samples];
            WorstCase {
                method: rows.name.clone(),
                file: format!("{take}.mcap"),
                take,
                topic: inhand_channels::planned_fingertips_topic(&rows.name),
                finger,
                segment,
                time_s: motion.map_or(0.0, |motion| motion.clock.time_s(origin.start + t)),
                error_m,
                errors_m: instants.iter().map(|errors| errors[finger]).collect(),
            }
        })
        .collect()
}
