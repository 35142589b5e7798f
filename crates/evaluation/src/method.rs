//! One method against the recorded motion.

use inhand_model::{
    Finger, HandAndFingers, MethodEvaluation, PerFinger, SegmentLayout, Statistics, Trajectory,
};
use inhand_statistics::quantiles::statistics;
use rayon::prelude::*;

use crate::certificates::plan_facts;
use crate::constraints::{check_velocity, collision, reachability};
use crate::contacts::{contact_share, distance_difference, in_contact};
use crate::corridors::coverage;
use crate::input::{EvaluationSettings, MethodResult, TestData};
use crate::instants::{NearestPair, SegmentInstants, hull_probes, look, tips};
use crate::object::{PoseErrors, object_error, pose_errors};
use crate::recorded::Recorded;

/// What a method does at every instant of the test segments, in the order of [`Recorded`]: sample `t`
/// of segment `s` has the index `s * N + t`. NaN (and no contact) where its plan failed.
#[derive(Clone, Debug)]
pub struct Rows {
    /// Distance between planned and recorded fingertip, metres.
    pub error_m: Vec<PerFinger<f64>>,
    /// Signed distance of each pad to the object's surface, metres, negative inside, NaN where the object
    /// is missing;
    /// `None` where no take has an object, or its shape is not known.
    pub distance_m: Option<Vec<PerFinger<f64>>>,
    /// Whether each finger is in contact with the object, its `distance_m` between -tau and tau;
    /// `None` as for `distance_m`.
    pub in_contact: Option<Vec<PerFinger<bool>>>,
    /// Signed distance of each fingertip to its training hull, metres, negative inside.
    pub hull_distance_m: Vec<PerFinger<f64>>,
    /// Distance between the nearest two fingertips, metres, and which they are.
    pub nearest_pair: Vec<NearestPair>,
    /// Planned against recorded object; `None` where the method plans none, or no take has one.
    pub object: Option<PoseErrors>,
    /// Mahalanobis distance of each recorded fingertip from the planned corridor, no unit, NaN where there is no
    /// corridor; `None` where the method plans none.
    pub mahalanobis: Option<Vec<PerFinger<f64>>>,
}

/// The sizes that every count of an evaluation rests on.
#[derive(Clone, Copy)]
pub(crate) struct Counts {
    /// Samples in a segment.
    pub(crate) samples: usize,
    /// Segments that a take without gaps would have given.
    pub(crate) segments_without_gaps: usize,
}

impl Counts {
    /// How many of the instants that there would be without gaps and failures are not among `n`.
    pub(crate) fn left_out(self, n: usize) -> usize {
        (self.samples * self.segments_without_gaps).saturating_sub(n)
    }
}

/// Judges a method at every instant of the test segments.
///
/// Instants of plans that failed are in no statistic; `n_left_out` counts them together with those
/// that gaps took away. Shares of the recorded motion are taken over the instants at which the method
/// is judged, so that the two can be compared. An instant counts as filled in the statistics of a
/// fingertip where that fingertip was filled, and in those about the object where the object was.
///
/// The result is the same whatever the number of threads.
pub fn evaluate_method(
    data: &TestData<'_>,
    recorded: &Recorded,
    method: &MethodResult<'_>,
    settings: &EvaluationSettings,
) -> (MethodEvaluation, Rows) {
    let layout = data.segments.layout();
    let samples = layout.samples;
    let trajectories: Vec<Option<&Trajectory>> = (0..data.segments.len())
        .map(|segment| {
            (method.trajectories.get(segment))
                .and_then(Option::as_ref)
                .filter(|trajectory| has_times_of(trajectory.layout(), layout))
        })
        .collect();
    let looks: Vec<Option<(Vec<PerFinger<f64>>, SegmentInstants)>> = trajectories
        .par_iter()
        .enumerate()
        .map_init(
            || hull_probes(data),
            |probes, (segment, trajectory)| {
                trajectory.map(|trajectory| {
                    let object_from_hand = recorded.object_from_hand(segment, samples);
                    (
                        errors_m(trajectory.values_m(), data.segments.fingertips_m(segment)),
                        look(
                            data,
                            settings,
                            probes,
                            trajectory.values_m(),
                            object_from_hand,
                        ),
                    )
                })
            },
        )
        .collect();
    let mut rows = rows(
        looks,
        samples,
        recorded.distance_m.is_some(),
        settings.tau_m,
    );

    let counts = Counts {
        samples,
        segments_without_gaps: data.segments.len() + data.segments.left_out,
    };
    rows.object = (method.objects)
        .and_then(|objects| pose_errors(&whole(objects, &trajectories, samples), recorded, counts));
    let corridors = (method.corridors).map(|corridors| {
        (
            whole(corridors.mahalanobis, &trajectories, samples),
            corridors.widths,
        )
    });
    rows.mahalanobis = (corridors.as_ref()).map(|(instants, _)| unfolded(instants, samples));
    let ((errors, median_error_by_sample_m), ((reachability, velocity), (contact, difference))) =
        rayon::join(
            || {
                rayon::join(
                    || Errors::of(&rows, recorded, counts),
                    || median_by_sample(&rows, samples),
                )
            },
            || {
                rayon::join(
                    || {
                        (
                            reachability(&rows, recorded, settings.hull_tolerance_m, counts),
                            check_velocity(&trajectories, &data.velocity_bounds),
                        )
                    },
                    || {
                        (
                            contact_share(&rows, recorded, settings, counts),
                            distance_difference(&rows, recorded, counts),
                        )
                    },
                )
            },
        );
    let evaluation = MethodEvaluation {
        name: method.name.to_owned(),
        description: method.description.to_owned(),
        baseline: method.baseline,
        error: errors.over_time,
        error_at_start: errors.at_start,
        error_at_goal: errors.at_goal,
        median_error_by_sample_m,
        reachability,
        collision: collision(&rows, recorded, settings.collision_limit_m, samples),
        velocity,
        contact,
        distance_difference: difference,
        object_error: (rows.object.as_ref()).map(|errors| object_error(errors, recorded, counts)),
        corridors: corridors.map_or_else(Vec::new, |(instants, widths)| {
            coverage(&instants, widths, recorded, counts)
        }),
        plan: method.plans.map(plan_facts),
    };
    (evaluation, rows)
}

/// Every instant of every segment, NaN for those without.
fn unfolded(segments: &[Option<&[PerFinger<f64>]>], samples: usize) -> Vec<PerFinger<f64>> {
    let unknown = vec![PerFinger::new([f64::NAN; Finger::COUNT]); samples];
    (segments.iter())
        .flat_map(|instants| instants.unwrap_or(&unknown).to_vec())
        .collect()
}

/// Whether both have the same samples; the object makes no difference to fingertips.
pub(crate) fn has_times_of(one: SegmentLayout, other: SegmentLayout) -> bool {
    (one.samples, one.rate_hz) == (other.samples, other.rate_hz)
}

/// What a method says of each segment beside its trajectory, where that is there and both are whole.
fn whole<'a, T>(
    parts: &'a [Option<Vec<T>>],
    trajectories: &[Option<&Trajectory>],
    samples: usize,
) -> Vec<Option<&'a [T]>> {
    (trajectories.iter().enumerate())
        .map(|(segment, trajectory)| {
            let part = parts.get(segment)?.as_deref();
            part.filter(|part| trajectory.is_some() && part.len() == samples)
        })
        .collect()
}

fn errors_m(planned_m: &[f64], recorded_m: &[f64]) -> Vec<PerFinger<f64>> {
    let configurations = |values_m| <[f64]>::chunks_exact(values_m, 3 * Finger::COUNT).map(tips);
    configurations(planned_m)
        .zip(configurations(recorded_m))
        .map(|(planned, recorded)| {
            PerFinger::from_fn(|finger| planned[finger].distance_m(recorded[finger]))
        })
        .collect()
}

fn rows(
    looks: Vec<Option<(Vec<PerFinger<f64>>, SegmentInstants)>>,
    samples: usize,
    has_object: bool,
    tau_m: f64,
) -> Rows {
    let count = samples * looks.len();
    let unknown = [PerFinger::new([f64::NAN; Finger::COUNT])];
    let mut rows = Rows {
        error_m: Vec::with_capacity(count),
        distance_m: None,
        in_contact: None,
        hull_distance_m: Vec::with_capacity(count),
        nearest_pair: Vec::with_capacity(count),
        object: None,
        mahalanobis: None,
    };
    let mut distance_m = Vec::with_capacity(if has_object { count } else { 0 });
    for look in looks {
        if let Some((error_m, instants)) = look {
            rows.error_m.extend(error_m);
            rows.hull_distance_m.extend(instants.hull_distance_m);
            rows.nearest_pair.extend(instants.nearest_pair);
            distance_m.extend(instants.distance_m);
        } else {
            let unknown = || unknown.into_iter().cycle().take(samples);
            rows.error_m.extend(unknown());
            rows.hull_distance_m.extend(unknown());
            let no_pair = (f64::NAN, Finger::Thumb, Finger::Index);
            rows.nearest_pair
                .extend(std::iter::repeat_n(no_pair, samples));
            if has_object {
                distance_m.extend(unknown());
            }
        }
    }
    if has_object {
        let contact = |d: &PerFinger<f64>| d.map(|d| in_contact(d, tau_m));
        rows.in_contact = Some(distance_m.iter().map(contact).collect());
        rows.distance_m = Some(distance_m);
    }
    rows
}

struct Errors {
    over_time: HandAndFingers<Statistics>,
    at_start: Statistics,
    at_goal: Statistics,
}

impl Errors {
    fn of(rows: &Rows, recorded: &Recorded, counts: Counts) -> Self {
        let count = rows.error_m.len();
        // `step_by` refuses 0; a segment without samples has no instants anyway.
        let samples = counts.samples.max(1);
        let by_finger = PerFinger::from_fn(|finger| {
            Known::of(&rows.error_m, &recorded.filled, finger, 0..count)
        });
        let pooled = |by_finger: PerFinger<Known>, instants_without_gaps: usize| {
            let n_filled = by_finger.iter().map(|(_, known)| known.n_filled).sum();
            let values = by_finger.map(|known| known.values).into_array().concat();
            let n_left_out = (Finger::COUNT * instants_without_gaps).saturating_sub(values.len());
            statistics(values, n_filled, n_left_out)
        };
        let at = |first: usize| {
            let instants = (first..count).step_by(samples);
            let known = PerFinger::from_fn(|finger| {
                Known::of(&rows.error_m, &recorded.filled, finger, instants.clone())
            });
            pooled(known, counts.segments_without_gaps)
        };
        Self {
            at_start: at(0),
            at_goal: at(samples - 1),
            over_time: HandAndFingers {
                by_finger: by_finger.clone().map(|known| known.statistics(counts)),
                all: pooled(by_finger, counts.samples * counts.segments_without_gaps),
            },
        }
    }
}

/// One finger's values at the instants where they are known.
#[derive(Clone)]
struct Known {
    values: Vec<f64>,
    n_filled: usize,
}

impl Known {
    fn of(
        values: &[PerFinger<f64>],
        filled: &[PerFinger<bool>],
        finger: Finger,
        instants: impl ExactSizeIterator<Item = usize>,
    ) -> Self {
        let mut known = Self {
            values: Vec::with_capacity(instants.len()),
            n_filled: 0,
        };
        for k in instants {
            let value = values[k][finger];
            if value.is_finite() {
                known.values.push(value);
                known.n_filled += usize::from(filled[k][finger]);
            }
        }
        known
    }

    fn statistics(self, counts: Counts) -> Statistics {
        let n_left_out = counts.left_out(self.values.len());
        statistics(self.values, self.n_filled, n_left_out)
    }
}

/// Statistics of each finger over all instants at which its value is known.
pub(crate) fn finger_statistics(
    values: &[PerFinger<f64>],
    filled: &[PerFinger<bool>],
    counts: Counts,
) -> PerFinger<Statistics> {
    PerFinger::from_fn(|finger| {
        Known::of(values, filled, finger, 0..values.len()).statistics(counts)
    })
}

fn median_by_sample(rows: &Rows, samples: usize) -> Vec<f64> {
    (0..samples)
        .into_par_iter()
        .map(|t| {
            let errors = (rows.error_m.iter().skip(t).step_by(samples))
                .flat_map(|errors| *errors.as_array())
                .filter(|error| error.is_finite())
                .collect();
            statistics(errors, 0, 0).p50
        })
        .collect()
}
