//! Bootstrap confidence intervals of errors, contact shares and differences, over segments or sessions.
//!
//! Clusters are drawn with replacement, the same ones for every method, so that differences are paired
//! ([`bootstrap`]).

use std::borrow::Cow;

use inhand_model::{
    Bootstrap, Estimate, EvaluationRows, Finger, HandAndFingers, Intervals, Measure,
    MeasureEstimates, MethodIntervals, PairedDifference, PerFinger, in_contact,
};
use inhand_parallel::{map, try_map};
use inhand_statistics::BootstrapError;
use inhand_statistics::bootstrap::{self, ClusteredRows, Difference};
use inhand_statistics::quantiles::sorted_statistics;

use crate::constraints::is_known;
use crate::contacts::STABLE;

/// Errors of a finger, metres: a list for each cluster, of the instants that were judged.
pub type ErrorsByCluster = Vec<Vec<f64>>;

/// A method as [`intervals`] needs to know it.
#[derive(Clone, Copy, Debug)]
pub struct Contestant<'a> {
    /// Name.
    pub name: &'a str,
    /// Whether it uses nothing learned.
    pub baseline: bool,
    /// Mean error over all fingers and instants, metres; NaN where none was judged.
    pub mean_error_m: f64,
}

/// Instants of a cluster at which planned and recorded contacts are known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ContactCounts {
    /// All of them.
    pub judged: usize,
    /// Those with three or more contacts, planned.
    pub three_or_more: usize,
    /// The same, recorded.
    pub recorded_three_or_more: usize,
}

/// Intervals of all methods. `errors` gives the errors of the method at a place and of a finger, `contacts` its
/// counts, `None` where no object is known; both have the same clusters in the same order for every
/// method. Each method is asked for once, finger by finger, and at most three are held at a time: many sessions
/// do not fit into memory at once. `seen` gets the errors of each method when they are sorted, for other
/// statistics of them.
///
/// # Errors
///
/// Those of `errors`, and [`BootstrapError`] for settings that make no sense, rows that are not finite, and
/// methods with different numbers of clusters.
pub fn intervals<E: From<BootstrapError>>(
    contestants: &[Contestant<'_>],
    default: &str,
    bootstrap: Bootstrap,
    mut errors: impl FnMut(usize, Finger) -> Result<ErrorsByCluster, E>,
    contacts: impl Fn(usize) -> Option<Vec<ContactCounts>>,
    mut seen: impl FnMut(usize, &SortedErrors),
) -> Result<Intervals, E> {
    let best = best_baseline(contestants);
    let default = contestants.iter().position(|method| method.name == default);

    let mut found: Vec<Option<MethodIntervals>> = vec![None; contestants.len()];
    let mut look = |place: usize| -> Result<SortedErrors, E> {
        let sample = SortedErrors::read(|finger| errors(place, finger))?;
        let counts = contacts(place);
        found[place] = Some(method_intervals(
            contestants[place].name,
            &sample,
            counts.as_deref(),
            &bootstrap,
        )?);
        seen(place, &sample);
        Ok(sample)
    };
    let name = |place: usize| contestants[place].name;
    let mut differences = Vec::new();
    let of_best = best.map(&mut look).transpose()?;
    let apart = default.filter(|_| default != best);
    let of_default = apart.map(&mut look).transpose()?;
    if let (Some(default), Some(sample), Some(best), Some(other)) =
        (default, &of_default, best, &of_best)
    {
        let names = (name(default), name(best));
        differences.extend(paired(names, None, &sample.all, &other.all, &bootstrap)?);
        let fingers = try_map(&Finger::ALL, |&finger| {
            let (one, other) = (&sample.by_finger[finger], &other.by_finger[finger]);
            paired(names, Some(finger), one, other, &bootstrap)
        })?;
        differences.extend(fingers.into_iter().flatten());
    }
    // From here on only what is pooled is compared: the fingers' copies may go.
    let of_best = of_best.map(|sample| sample.all);
    let of_default = of_default.map(|sample| sample.all);
    for place in 0..contestants.len() {
        if Some(place) == best || Some(place) == default {
            continue;
        }
        let sample = look(place)?.all;
        for (other, rows) in [(best, &of_best), (default, &of_default)] {
            if let (Some(other), Some(rows)) = (other, rows) {
                let names = (name(place), name(other));
                differences.extend(paired(names, None, &sample, rows, &bootstrap)?);
            }
        }
    }
    Ok(Intervals {
        bootstrap,
        methods: found.into_iter().flatten().collect(),
        best_baseline: best.map(|best| name(best).to_owned()),
        differences,
    })
}

/// Intervals over the segments of one session, from its rows. Which methods are baselines, and the mean
/// errors, stand in the evaluation.
///
/// # Errors
///
/// [`BootstrapError`] for settings that make no sense.
pub fn session_intervals(
    rows: &EvaluationRows,
    contestants: &[Contestant<'_>],
    default: &str,
    tau_m: f64,
    bootstrap: Bootstrap,
) -> Result<Intervals, BootstrapError> {
    intervals(
        contestants,
        default,
        bootstrap,
        |place, finger| Ok(segment_errors(rows, place, finger)),
        |place| segment_contacts(rows, place, tau_m),
        |_, _| (),
    )
}

/// Errors of a finger in each segment.
pub(crate) fn segment_errors(
    rows: &EvaluationRows,
    method: usize,
    finger: Finger,
) -> ErrorsByCluster {
    let samples = rows.layout.samples.max(1);
    (rows.methods[method].error_m.chunks(samples))
        .map(|segment| {
            let errors = segment.iter().map(|errors| errors[finger]);
            errors.filter(|error| error.is_finite()).collect()
        })
        .collect()
}

/// Contacts in each segment, planned and recorded at the same instants.
pub(crate) fn segment_contacts(
    rows: &EvaluationRows,
    method: usize,
    tau_m: f64,
) -> Option<Vec<ContactCounts>> {
    let planned = rows.methods[method].distance_m.as_ref()?;
    let recorded = rows.recorded_distance_m.as_ref()?;
    let samples = rows.layout.samples.max(1);
    let is_stable = |distance_m: &PerFinger<f64>| {
        let touching = distance_m.as_array().iter();
        touching.filter(|&&d| in_contact(d, tau_m)).count() >= STABLE
    };
    let counts = |(planned, recorded): (&[PerFinger<f64>], &[PerFinger<f64>])| {
        let judged = (planned.iter().zip(recorded))
            .filter(|(planned, recorded)| is_known(planned) && is_known(recorded));
        judged.fold(ContactCounts::default(), |counts, (planned, recorded)| {
            ContactCounts {
                judged: counts.judged + 1,
                three_or_more: counts.three_or_more + usize::from(is_stable(planned)),
                recorded_three_or_more: counts.recorded_three_or_more
                    + usize::from(is_stable(recorded)),
            }
        })
    };
    let segments = planned.chunks(samples).zip(recorded.chunks(samples));
    Some(segments.map(counts).collect())
}

/// Place of the baseline with the smallest mean error, the first of equal ones.
pub fn best_baseline(contestants: &[Contestant<'_>]) -> Option<usize> {
    (contestants.iter().enumerate())
        .filter(|(_, method)| method.baseline && method.mean_error_m.is_finite())
        .min_by(|a, b| a.1.mean_error_m.total_cmp(&b.1.mean_error_m))
        .map(|(place, _)| place)
}

/// Rows with what tells in which clusters one method is better than another.
#[derive(Debug)]
struct Rows {
    rows: ClusteredRows,
    /// Each measure of each cluster alone; NaN without rows.
    by_cluster: Vec<[f64; Measure::ALL.len()]>,
}

/// Errors of a method, sorted: of each finger and of all.
#[derive(Debug)]
pub struct SortedErrors {
    by_finger: PerFinger<Rows>,
    all: Rows,
}

impl SortedErrors {
    /// Those of a finger, or of all of them.
    pub fn rows(&self, finger: Option<Finger>) -> &ClusteredRows {
        &finger
            .map_or(&self.all, |finger| &self.by_finger[finger])
            .rows
    }

    /// The errors of one finger after the other: what is read of one is dropped before the next.
    fn read<E: From<BootstrapError>>(
        mut errors: impl FnMut(Finger) -> Result<ErrorsByCluster, E>,
    ) -> Result<Self, E> {
        let measured = |rows: ClusteredRows| Rows {
            by_cluster: map(&rows.by_cluster(), |rows| measures_of(rows)),
            rows,
        };
        let by_finger = PerFinger::try_from_fn(|finger| -> Result<Rows, E> {
            Ok(measured(ClusteredRows::new(&errors(finger)?)?))
        })?;
        let parts: Vec<&ClusteredRows> = by_finger.iter().map(|(_, rows)| &rows.rows).collect();
        let all = measured(ClusteredRows::merged(&parts)?);
        Ok(Self { by_finger, all })
    }
}

/// Each measure of ascending rows; NaN without any.
fn measures_of(rows: &[f64]) -> [f64; Measure::ALL.len()] {
    let of_all = sorted_statistics(rows, 0, 0);
    Measure::ALL.map(|measure| match measure {
        _ if of_all.n == 0 => f64::NAN,
        Measure::Mean => of_all.mean,
        Measure::Rmse => of_all.rmse,
        Measure::P50 => of_all.p50,
        Measure::P75 => of_all.p75,
        Measure::P95 => of_all.p95,
    })
}

fn estimates(
    rows: &ClusteredRows,
    bootstrap: &Bootstrap,
) -> Result<Option<MeasureEstimates>, BootstrapError> {
    let found = bootstrap::intervals(rows, &Measure::ALL, bootstrap)?;
    // Either there are rows, and every measure of them, or none.
    let found: Option<Vec<Estimate>> = found.into_iter().collect();
    Ok(found.and_then(|found| found.try_into().ok()))
}

fn method_intervals(
    method: &str,
    sample: &SortedErrors,
    contacts: Option<&[ContactCounts]>,
    bootstrap: &Bootstrap,
) -> Result<MethodIntervals, BootstrapError> {
    let by_finger = try_map(sample.by_finger.as_array(), |rows| {
        estimates(&rows.rows, bootstrap)
    })?;
    let mut by_finger = by_finger.into_iter();
    let (three_or_more, three_or_more_less_recorded) = contacts
        .map(|counts| contact_estimates(counts, bootstrap))
        .transpose()?
        .unwrap_or_default();
    Ok(MethodIntervals {
        method: method.to_owned(),
        error: HandAndFingers {
            all: estimates(&sample.all.rows, bootstrap)?,
            by_finger: PerFinger::from_fn(|_| by_finger.next().flatten()),
        },
        three_or_more,
        three_or_more_less_recorded,
    })
}

/// The share of instants with three or more contacts, and that share less the recorded one.
fn contact_estimates(
    counts: &[ContactCounts],
    bootstrap: &Bootstrap,
) -> Result<(Option<Estimate>, Option<Estimate>), BootstrapError> {
    let planned = ones_and_zeros(counts, |counts| counts.three_or_more)?;
    let recorded = ones_and_zeros(counts, |counts| counts.recorded_three_or_more)?;
    let mean = [Measure::Mean];
    let share = bootstrap::intervals(&planned, &mean, bootstrap)?;
    let less = bootstrap::differences(&planned, &recorded, true, &mean, bootstrap)?;
    Ok((share[0], less[0].map(|found| found.absolute)))
}

/// Ones and zeros whose mean is a share.
pub(crate) fn ones_and_zeros(
    counts: &[ContactCounts],
    of: fn(&ContactCounts) -> usize,
) -> Result<ClusteredRows, BootstrapError> {
    let clusters: Vec<Vec<f64>> = (counts.iter())
        .map(|counts| {
            let ones = of(counts).min(counts.judged);
            let mut values = vec![1.0; ones];
            values.resize(counts.judged, 0.0);
            values
        })
        .collect();
    ClusteredRows::new(&clusters)
}

/// In which clusters both have the same number of rows. A method whose plan failed has been spared what is hard about
/// a segment; the other one must be spared it too.
fn judged_by_both(first: &ClusteredRows, second: &ClusteredRows) -> Vec<bool> {
    let sizes = first.sizes().iter().zip(second.sizes());
    sizes.map(|(first, second)| first == second).collect()
}

/// Both samples over the clusters to keep.
fn only<'a>(
    keep: &[bool],
    first: &'a ClusteredRows,
    second: &'a ClusteredRows,
) -> [Cow<'a, ClusteredRows>; 2] {
    [first, second].map(|rows| match keep.iter().all(|&keep| keep) {
        true => Cow::Borrowed(rows),
        false => Cow::Owned(rows.only(keep)),
    })
}

/// Samples to compare: of pairs the clusters in which both judged the same instants, else all.
pub(crate) fn compared<'a>(
    paired: bool,
    first: &'a ClusteredRows,
    second: &'a ClusteredRows,
) -> [Cow<'a, ClusteredRows>; 2] {
    match paired {
        true => only(&judged_by_both(first, second), first, second),
        false => [first, second].map(Cow::Borrowed),
    }
}

/// Differences of the first from the second in each measure, over the clusters in which both judged the same instants;
/// nothing where there are none.
fn paired(
    (method, other): (&str, &str),
    finger: Option<Finger>,
    first: &Rows,
    second: &Rows,
    bootstrap: &Bootstrap,
) -> Result<Vec<PairedDifference>, BootstrapError> {
    let same = judged_by_both(&first.rows, &second.rows);
    let [rows, of_other] = only(&same, &first.rows, &second.rows);
    let found = bootstrap::differences(&rows, &of_other, true, &Measure::ALL, bootstrap)?;
    let of_measure = |(k, found): (usize, &Option<Difference>)| {
        let found = (*found)?;
        Some(PairedDifference {
            method: method.to_owned(),
            other: other.to_owned(),
            finger,
            measure: Measure::ALL[k],
            absolute: found.absolute,
            relative: found.relative,
            share_better: share_better(&first.by_cluster, &second.by_cluster, &same, k),
        })
    };
    Ok(found.iter().enumerate().filter_map(of_measure).collect())
}

/// Share of the clusters in which both judged the same instants and the first is smaller, a tie counting half.
fn share_better(
    first: &[[f64; Measure::ALL.len()]],
    second: &[[f64; Measure::ALL.len()]],
    same: &[bool],
    measure: usize,
) -> f64 {
    let pairs = (first.iter().zip(second).zip(same))
        .filter(|(_, same)| **same)
        .map(|((a, b), _)| (a[measure], b[measure]));
    let (mut n, mut better) = (0_u32, 0.0);
    for (a, b) in pairs.filter(|(a, b)| a.is_finite() && b.is_finite()) {
        n += 1;
        better += match a.total_cmp(&b) {
            std::cmp::Ordering::Less => 1.0,
            std::cmp::Ordering::Equal => 0.5,
            std::cmp::Ordering::Greater => 0.0,
        };
    }
    better / f64::from(n)
}
