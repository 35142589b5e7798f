//! One method against the recorded motion.

use inhand_model::{
    Calibration, ConstraintFamily, CorridorCoverage, FamilyFacts, Finger, Hand, HandAndFingers,
    MethodEvaluation, MethodRows, Object, ObjectError, PerFinger, Plan, PlanFacts, PlanStatus,
    Pose, SegmentLayout, Statistics, Trajectory,
};
use inhand_statistics::quantiles::statistics;

use crate::constraints::{check_velocity, collision, reachability};
use crate::contacts::{contact_share, distance_difference};
use crate::input::{EvaluationSettings, MethodResult, TestData};
use crate::instants::{UNKNOWN, fingertips, measure};
use crate::known::{Counts, finger_statistics, known_statistics};
use crate::recorded::Recorded;

/// Judges a method at every instant of the test segments.
///
/// Instants of plans that failed are in no statistic; `n_left_out` counts them together with those
/// that gaps took away. Shares of the recorded motion are taken over the instants at which the method
/// is judged, so that the two can be compared. An instant counts as filled in the statistics of a
/// fingertip where that fingertip was filled, and in those about the object where the object was.
///
/// The rows are NaN where the plan failed. The result is the same whatever the number of threads.
pub fn evaluate_method(
    data: &TestData<'_>,
    recorded: &Recorded,
    method: &MethodResult<'_>,
    settings: &EvaluationSettings,
) -> (MethodEvaluation, MethodRows) {
    let layout = data.segments.layout();
    let samples = layout.samples;
    let counts = Counts {
        samples,
        segments_without_gaps: data.segments.len() + data.segments.left_out,
    };
    let trajectories: Vec<Option<&Trajectory>> = (0..data.segments.len())
        .map(|segment| usable(method.trajectories, segment, layout))
        .collect();
    let instants = measure(data, settings, &recorded.object_from_hand, |segment| {
        trajectories[segment].map(Trajectory::values_m)
    });
    let error_m = |(segment, planned): (usize, &Option<&Trajectory>)| {
        planned.map_or_else(
            || vec![UNKNOWN; samples],
            |planned| errors_m(planned.values_m(), data.segments.fingertips_m(segment)),
        )
    };
    let (object_position_error_m, object_angle_error_rad) = (method.objects)
        .and_then(|objects| pose_errors(&whole(objects, &trajectories, samples), recorded, samples))
        .unzip();
    let mahalanobis =
        (method.corridors).map(|corridors| whole(corridors.mahalanobis, &trajectories, samples));
    let rows = MethodRows {
        name: method.name.to_owned(),
        error_m: joined(trajectories.iter().enumerate().map(error_m), counts.samples),
        distance_m: (recorded.rows.recorded_distance_m.as_ref()).map(|_| instants.distance_m),
        hull_distance_m: instants.hull_distance_m,
        nearest_pair_m: instants.nearest_pair.iter().map(|pair| pair.0).collect(),
        object_position_error_m,
        object_angle_error_rad,
        mahalanobis: (mahalanobis.as_ref()).map(|instants| unfolded(instants, samples)),
    };
    // `step_by` refuses 0; a segment without samples has no instants anyway.
    let (count, step) = (rows.error_m.len(), samples.max(1));
    let at = |first: usize| {
        let instants = (first..count).step_by(step);
        pooled(&rows, recorded, &instants, counts.segments_without_gaps)
    };
    let limit_m = settings.collision_limit_m;
    let evaluation = MethodEvaluation {
        name: method.name.to_owned(),
        description: method.description.to_owned(),
        baseline: method.baseline,
        error: HandAndFingers {
            all: pooled(&rows, recorded, &(0..count), counts.instants()),
            by_finger: finger_statistics(&rows.error_m, &recorded.rows.filled, counts),
        },
        error_at_start: at(0),
        error_at_goal: at(step - 1),
        median_error_by_sample_m: median_by_sample(&rows, samples),
        reachability: reachability(&rows, recorded, settings.hull_tolerance_m, counts),
        collision: collision(&instants.nearest_pair, recorded, limit_m, samples),
        velocity: check_velocity(&trajectories, &data.velocity_bounds),
        contact: contact_share(&rows, recorded, settings, counts),
        distance_difference: distance_difference(&rows, recorded, counts),
        object_error: object_error(&rows, recorded, counts),
        corridors: (method.corridors.iter().zip(&mahalanobis))
            .flat_map(|(corridors, instants)| {
                coverage(instants, corridors.widths, recorded, counts)
            })
            .collect(),
        plan: method.plans.map(plan_facts),
    };
    (evaluation, rows)
}

/// The trajectory of a segment, where there is one with the samples of the segments; the object makes no
/// difference to fingertips.
pub(crate) fn usable(
    trajectories: &[Option<Trajectory>],
    segment: usize,
    layout: SegmentLayout,
) -> Option<&Trajectory> {
    let planned = trajectories.get(segment)?.as_ref()?;
    let of = |layout: SegmentLayout| (layout.samples, layout.rate_hz);
    (of(planned.layout()) == of(layout)).then_some(planned)
}

/// Every instant of every segment, NaN for those without.
fn unfolded(segments: &[Option<&[PerFinger<f64>]>], samples: usize) -> Vec<PerFinger<f64>> {
    let unknown = vec![UNKNOWN; samples];
    let of_segment = |instants: &Option<&[_]>| instants.unwrap_or(&unknown).to_vec();
    joined(segments.iter().map(of_segment), samples)
}

/// The instants of all segments. A list that grows bit by bit would take up to twice its room.
fn joined(
    segments: impl ExactSizeIterator<Item = Vec<PerFinger<f64>>>,
    samples: usize,
) -> Vec<PerFinger<f64>> {
    let mut joined = Vec::with_capacity(segments.len() * samples);
    segments.for_each(|instants| joined.extend(instants));
    joined
}

/// Parts of a method for each segment beside its trajectory, where that is there and both are whole.
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
    (fingertips(planned_m).zip(fingertips(recorded_m)))
        .map(|(planned, recorded)| {
            PerFinger::from_fn(|finger| planned[finger].distance_m(recorded[finger]))
        })
        .collect()
}

/// Errors of all fingers at some instants.
fn pooled(
    rows: &MethodRows,
    recorded: &Recorded,
    instants: &(impl Iterator<Item = usize> + Clone),
    whole: usize,
) -> Statistics {
    let filled = &recorded.rows.filled;
    let of_finger = |finger: Finger| {
        let instants = instants.clone();
        instants.map(move |k| (rows.error_m[k][finger], filled[k][finger]))
    };
    known_statistics(
        Finger::ALL.into_iter().flat_map(of_finger),
        Finger::COUNT * whole,
    )
}

fn median_by_sample(rows: &MethodRows, samples: usize) -> Vec<f64> {
    inhand_parallel::up_to(samples, |t| {
        let errors = (rows.error_m.iter().skip(t).step_by(samples))
            .flat_map(|errors| *errors.as_array())
            .filter(|error| error.is_finite())
            .collect();
        statistics(errors, 0, 0).p50
    })
}

/// Distance between the origins (metres) and angle (radians) of planned and recorded object at every instant, NaN
/// where one of them is not known. `planned` has one entry for each segment of the recording, `None` where the plan
/// failed; the result is `None` where no take has an object.
fn pose_errors(
    planned: &[Option<&[Pose<Hand, Object>]>],
    recorded: &Recorded,
    samples: usize,
) -> Option<(Vec<f64>, Vec<f64>)> {
    if recorded.object_from_hand.is_empty() {
        return None;
    }
    let error = |(k, object_from_hand): (usize, &Option<Pose<Object, Hand>>)| {
        let planned = planned[k / samples]?[k % samples];
        let hand_from_object = object_from_hand.filter(|_| planned.is_finite())?.inverse();
        let rotation = hand_from_object.isometry().rotation;
        Some((
            planned.origin().distance_m(hand_from_object.origin()),
            planned.isometry().rotation.angle_to(&rotation),
        ))
    };
    let instants = recorded.object_from_hand.iter().enumerate();
    Some(
        instants
            .map(|k| error(k).unwrap_or((f64::NAN, f64::NAN)))
            .unzip(),
    )
}

/// Errors of the planned object over all instants at which they are known; `None` where there is none.
fn object_error(rows: &MethodRows, recorded: &Recorded, counts: Counts) -> Option<ObjectError> {
    let filled = &recorded.rows.object_filled;
    let over = |values: &[f64]| {
        let values = values.iter().copied().zip(filled.iter().copied());
        known_statistics(values, counts.instants())
    };
    Some(ObjectError {
        position: over(rows.object_position_error_m.as_ref()?),
        angle: over(rows.object_angle_error_rad.as_ref()?),
    })
}

/// Coverage of each width over all instants at which the distance is known. `mahalanobis` has one entry
/// for each segment of the recording, `None` where there is no region. On the edge is inside.
fn coverage(
    mahalanobis: &[Option<&[PerFinger<f64>]>],
    widths: &[Calibration],
    recorded: &Recorded,
    counts: Counts,
) -> Vec<CorridorCoverage> {
    // Distances of each finger, the same for all widths.
    let mut n_filled = 0;
    let known: PerFinger<Vec<f64>> = PerFinger::from_fn(|finger| {
        let mut known = Vec::new();
        for (segment, instants) in mahalanobis.iter().enumerate() {
            for (t, distances) in instants.unwrap_or_default().iter().enumerate() {
                if !distances[finger].is_nan() {
                    known.push(distances[finger]);
                    let k = segment * counts.samples + t;
                    n_filled += usize::from(recorded.rows.filled[k][finger]);
                }
            }
        }
        known
    });
    let n: usize = known.iter().map(|(_, known)| known.len()).sum();
    let n_left_out = (Finger::ALL.into_iter())
        .map(|finger| counts.left_out(known[finger].len()))
        .sum();
    (widths.iter())
        .map(|width| {
            let inside = (known.each_ref())
                .map(|known| known.iter().filter(|&&d| d <= width.mahalanobis).count());
            CorridorCoverage {
                share_stated: width.share,
                mahalanobis: width.mahalanobis,
                n,
                n_filled,
                n_left_out,
                share_inside: HandAndFingers {
                    all: inside.as_array().iter().sum::<usize>() as f64 / n as f64,
                    by_finger: PerFinger::from_fn(|finger| {
                        inside[finger] as f64 / known[finger].len() as f64
                    }),
                },
            }
        })
        .collect()
}

fn plan_facts(plans: &[Plan]) -> PlanFacts {
    let solved: Vec<_> = (plans.iter())
        .filter(|plan| plan.trajectory.is_some())
        .collect();
    let infeasible: Vec<_> = (plans.iter())
        .filter(|plan| plan.status == PlanStatus::Infeasible)
        .collect();
    let families = ConstraintFamily::ALL
        .into_iter()
        .filter_map(|family| family_facts(family, &solved, &infeasible))
        .collect();
    let outside = (solved.iter())
        .filter_map(|plan| plan.checks.hull_distance_m)
        .map(|distance_m| usize::from(distance_m > 0.0));
    let active = |plan: &&&Plan| plan.checks.active[ConstraintFamily::Velocity] > 0;
    PlanFacts {
        solved: solved.len(),
        infeasible: infeasible.len(),
        failed: plans.len().saturating_sub(solved.len() + infeasible.len()),
        // NaN is the worst of all.
        worst_kkt_residual: (solved.iter())
            .map(|plan| plan.certificate.worst())
            .max_by(f64::total_cmp)
            .unwrap_or(0.0),
        velocity_bound_active: solved.iter().filter(active).count(),
        families,
        outside_hull: outside.clone().next().map(|_| outside.sum()),
    }
}

/// Facts of one family; `None` where it was off in every plan.
fn family_facts(
    family: ConstraintFamily,
    solved: &[&Plan],
    infeasible: &[&Plan],
) -> Option<FamilyFacts> {
    let relaxations: Vec<f64> = (infeasible.iter())
        .flat_map(|plan| &plan.relaxations)
        .filter(|relaxation| relaxation.family == family && !relaxation.joint)
        .map(|relaxation| relaxation.by)
        .collect();
    let violation = |plan: &&Plan| plan.checks.violation[family];
    (solved.iter().chain(infeasible)).find_map(violation)?;
    Some(FamilyFacts {
        family,
        active: (solved.iter())
            .filter(|plan| plan.checks.active[family] > 0)
            .count(),
        // Null in files where no plan has a motion to judge.
        worst_violation: (solved.iter().filter_map(violation))
            .max_by(f64::total_cmp)
            .unwrap_or(f64::NAN),
        would_mend: relaxations.len(),
        largest_relaxation: relaxations.into_iter().fold(0.0, f64::max),
    })
}
