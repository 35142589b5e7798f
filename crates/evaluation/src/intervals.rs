//! Bootstrap confidence intervals of errors, contact shares and differences, over segments or sessions.
//!
//! Clusters are drawn with replacement, the same ones for every method, so that differences are paired
//! ([`bootstrap`]).

use std::rc::Rc;

use inhand_model::{
    Bootstrap, EvaluationRows, Finger, HandAndFingers, Intervals, Measure, MeasureEstimates,
    MethodEvaluation, MethodIntervals, PairedDifference, PerFinger, SharedContacts, in_contact,
};
use inhand_parallel::map;
use inhand_statistics::BootstrapError;
use inhand_statistics::bootstrap::{ClusteredRows, Difference, Drawn, Draws, SortedRows};
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

impl<'a> Contestant<'a> {
    /// An evaluated method.
    pub fn new(method: &'a MethodEvaluation) -> Self {
        let error = Some(&method.error.all).filter(|error| error.n > 0);
        Self {
            name: &method.name,
            baseline: method.baseline,
            mean_error_m: error.map_or(f64::NAN, |error| error.mean),
        }
    }
}

/// Intervals of all methods. `errors` gives the errors of the method at a place and of a finger, `sizes` how many of them
/// each cluster has, `contacts` its counts, `None` where no object is known; all have the same clusters in the same
/// order for every method. Errors are read once, those of a finger of a method at a time: many sessions do not fit into
/// memory at once. `seen` gets the errors of each method and finger, and then of all fingers, when they are sorted, for
/// other statistics of them.
///
/// # Errors
///
/// Those of `errors`, and [`BootstrapError`] for settings that make no sense, rows that are not finite, and
/// methods with different numbers of clusters.
pub fn intervals<E: From<BootstrapError>>(
    contestants: &[Contestant<'_>],
    default: &str,
    bootstrap: Bootstrap,
    errors: impl Fn(usize, Finger) -> Result<ErrorsByCluster, E>,
    sizes: impl Fn(usize, Finger) -> Vec<usize>,
    contacts: impl Fn(usize) -> Option<Vec<SharedContacts>>,
    mut seen: impl FnMut(usize, Option<Finger>, &ClusteredRows),
) -> Result<Intervals, E> {
    let best = best_baseline(contestants);
    let default = contestants.iter().position(|method| method.name == default);
    let mut pairs = pairs(contestants.len(), best, default, &sizes);
    let clusters = contestants.first().map(|_| sizes(0, Finger::Thumb).len());
    let draws = Draws::new(&bootstrap, clusters.unwrap_or(0))?;
    let mut methods = Vec::with_capacity(contestants.len());
    for (place, contestant) in contestants.iter().enumerate() {
        let mut drawn_of = |finger, rows: &ClusteredRows| {
            let drawn = Rc::new(rows.drawn(&draws, &Measure::ALL)?);
            let own = pairs.iter_mut().filter(|pair| pair.finger == finger);
            let own = own.filter(|pair| pair.methods.contains(&place));
            take_side(own, place, rows, &drawn, &draws)?;
            seen(place, finger, rows);
            Ok::<_, BootstrapError>(drawn)
        };
        let (mut drawn, mut fingers) = (Vec::new(), Vec::new());
        for finger in Finger::ALL {
            let rows = ClusteredRows::new(&errors(place, finger)?)?;
            drawn.push(drawn_of(Some(finger), &rows)?);
            fingers.push(rows.into_rows());
        }
        let all = SortedRows::merged(&fingers)?;
        drop(fingers);
        drawn.insert(0, drawn_of(None, &all.into())?);
        let counts = contacts(place);
        let own = method_intervals(contestant.name, &drawn, counts.as_deref(), &draws)?;
        methods.push(own);
    }
    Ok(Intervals {
        bootstrap,
        methods,
        best_baseline: best.map(|best| contestants[best].name.to_owned()),
        differences: (pairs.iter())
            .flat_map(|pair| pair.differences(contestants))
            .collect(),
    })
}

/// All fingers together, then each.
pub(crate) const FINGERS: [Option<Finger>; 1 + Finger::COUNT] = [
    None,
    Some(Finger::Thumb),
    Some(Finger::Index),
    Some(Finger::Middle),
    Some(Finger::Ring),
    Some(Finger::Little),
];

/// Two methods that are compared, over the clusters in which both judged the same instants: a method whose plan failed
/// has been spared what is hard about a segment, and the other one must be spared it too.
struct Pair {
    methods: [usize; 2],
    /// `None` for all of them.
    finger: Option<Finger>,
    /// Of each cluster.
    judged_by_both: Vec<bool>,
    sides: [Option<Side>; 2],
}

/// A method in a comparison.
struct Side {
    drawn: Rc<Drawn>,
    /// Each measure of each cluster alone; NaN without rows.
    by_cluster: Rc<Vec<[f64; Measure::ALL.len()]>>,
}

/// The default method against the best baseline, also finger by finger; the others against each of both.
fn pairs(
    methods: usize,
    best: Option<usize>,
    default: Option<usize>,
    sizes: &impl Fn(usize, Finger) -> Vec<usize>,
) -> Vec<Pair> {
    let sizes = |method, finger: Option<Finger>| match finger {
        Some(finger) => sizes(method, finger),
        None => (Finger::ALL.iter().map(|&finger| sizes(method, finger)))
            .reduce(|all, own| all.iter().zip(own).map(|(all, own)| all + own).collect())
            .unwrap_or_default(),
    };
    let pair = |first, second, finger| Pair {
        methods: [first, second],
        finger,
        judged_by_both: judged_by_both(&sizes(first, finger), &sizes(second, finger)),
        sides: [None, None],
    };
    let apart = default.filter(|_| default != best);
    let main = apart.zip(best).into_iter();
    let main = main.flat_map(|(default, best)| FINGERS.map(|finger| pair(default, best, finger)));
    let others = (0..methods).filter(|&place| Some(place) != best && Some(place) != default);
    let others = others.flat_map(|place| {
        let with = [best, apart].into_iter().flatten();
        with.map(move |other| (place, other))
    });
    main.chain(others.map(|(place, other)| pair(place, other, None)))
        .collect()
}

/// Gives pairs the side of a method.
fn take_side<'p>(
    pairs: impl Iterator<Item = &'p mut Pair>,
    method: usize,
    rows: &ClusteredRows,
    drawn: &Rc<Drawn>,
    draws: &Draws,
) -> Result<(), BootstrapError> {
    let mut pairs = pairs.peekable();
    if pairs.peek().is_none() {
        return Ok(());
    }
    let by_cluster = Rc::new(map(&rows.by_cluster(), |rows| measures_of(rows)));
    for pair in pairs {
        let drawn = match pair.judged_by_both.iter().all(|&same| same) {
            true => Rc::clone(drawn),
            false => Rc::new(rows.drawn(&draws.only(&pair.judged_by_both)?, &Measure::ALL)?),
        };
        let by_cluster = Rc::clone(&by_cluster);
        let side = pair.methods.map(|own| own == method);
        pair.sides[usize::from(side[1])] = Some(Side { drawn, by_cluster });
    }
    Ok(())
}

impl Pair {
    /// Differences of the first from the second in each measure; nothing where no rows are left.
    fn differences(&self, contestants: &[Contestant<'_>]) -> Vec<PairedDifference> {
        let [Some(first), Some(second)] = &self.sides else {
            return Vec::new();
        };
        let [method, other] = self.methods.map(|place| contestants[place].name.to_owned());
        let found = first.drawn.less(&second.drawn);
        let found = found.into_iter().zip(Measure::ALL).enumerate();
        let of_measure = |(k, (found, measure)): (usize, (Option<Difference>, Measure))| {
            let found = found?;
            Some(PairedDifference {
                method: method.clone(),
                other: other.clone(),
                finger: self.finger,
                measure,
                absolute: found.absolute,
                relative: found.relative,
                share_better: share_better(
                    &first.by_cluster,
                    &second.by_cluster,
                    &self.judged_by_both,
                    k,
                ),
            })
        };
        found.filter_map(of_measure).collect()
    }
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
    let samples = rows.layout.samples.max(1);
    let judged = |segment: &[PerFinger<f64>], finger: Finger| {
        let judged = segment.iter().filter(|errors| errors[finger].is_finite());
        judged.count()
    };
    intervals(
        contestants,
        default,
        bootstrap,
        |place, finger| Ok(segment_errors(rows, place, finger)),
        |place, finger| {
            let segments = rows.methods[place].error_m.chunks(samples);
            segments.map(|segment| judged(segment, finger)).collect()
        },
        |place| segment_contacts(rows, place, tau_m),
        |_, _, _| (),
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
) -> Option<Vec<SharedContacts>> {
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
        judged.fold(SharedContacts::default(), |counts, (planned, recorded)| {
            SharedContacts {
                n: counts.n + 1,
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

fn estimates(drawn: &Drawn) -> Option<MeasureEstimates> {
    // Either there are rows, and every measure of them, or none.
    let found: Option<Vec<_>> = drawn.estimates().into_iter().collect();
    found.and_then(|found| found.try_into().ok())
}

fn method_intervals(
    method: &str,
    drawn: &[Rc<Drawn>],
    contacts: Option<&[SharedContacts]>,
    draws: &Draws,
) -> Result<MethodIntervals, BootstrapError> {
    let mean = |counts, of| ones_and_zeros(counts, of)?.drawn(draws, &[Measure::Mean]);
    let (mut three_or_more, mut three_or_more_less_recorded) = (None, None);
    if let Some(counts) = contacts {
        let planned = mean(counts, |counts| counts.three_or_more)?;
        let recorded = mean(counts, |counts| counts.recorded_three_or_more)?;
        three_or_more = planned.estimates()[0];
        three_or_more_less_recorded = planned.less(&recorded)[0].map(|found| found.absolute);
    }
    let mut found = drawn.iter().map(|drawn| estimates(drawn));
    Ok(MethodIntervals {
        method: method.to_owned(),
        error: HandAndFingers::from_fn(|_| found.next().flatten()),
        three_or_more,
        three_or_more_less_recorded,
    })
}

/// Ones and zeros whose mean is a share.
pub(crate) fn ones_and_zeros(
    counts: &[SharedContacts],
    of: fn(&SharedContacts) -> usize,
) -> Result<ClusteredRows, BootstrapError> {
    let clusters: Vec<Vec<f64>> = (counts.iter())
        .map(|counts| {
            let ones = of(counts).min(counts.n);
            let mut values = vec![1.0; ones];
            values.resize(counts.n, 0.0);
            values
        })
        .collect();
    ClusteredRows::new(&clusters)
}

/// In which clusters both have the same number of rows.
pub(crate) fn judged_by_both(first: &[usize], second: &[usize]) -> Vec<bool> {
    let sizes = first.iter().zip(second);
    sizes.map(|(first, second)| first == second).collect()
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
