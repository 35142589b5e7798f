//! From a document back to the evaluation it was written from.

mod motion;

use inhand_model::{
    Bandwidths, Collision, ConstraintFamily, ContactShare, CorridorCoverage, DeviationFacts,
    DictionaryFacts, DictionaryKind, Evaluation, ExpectationWeights, FamilyFacts, Finding, Finger,
    InputHash, MethodCandidate, MethodChoice, MethodEvaluation, ObjectError, PerFinger, PlanFacts,
    Provenance, Reachability, SEGMENT_COORDINATES, SessionFacts, Severity, Statistics, StopReason,
    TakeFacts, TakeQuality, TauShare, TrackCounts, Validation, VelocityBounds, VelocityCheck,
};
use serde::Deserialize;

use super::wire::{
    Bounds, ByFinger, Choice, Collisions, Contact, Corridor, Counts, Deviation, Dictionary,
    Distribution, Document, Family, Found, Method, Number, Plans, Reach, SCHEMA_VERSION, Session,
    Step, Take, TakeState, Velocity,
};
use crate::error::ReportError;

const MM_PER_M: f64 = 1e3;
const MM2_PER_M2: f64 = 1e6;

/// Reads a document. Its version comes first: keys of another version must not be guessed at.
pub(crate) fn read(text: &str) -> Result<(Evaluation, Vec<Provenance>), ReportError> {
    #[derive(Deserialize)]
    struct Version {
        schema_version: u64,
    }
    let not_an_evaluation = |source| ReportError::NotAnEvaluation { source };
    let version: Version = serde_json::from_str(text).map_err(not_an_evaluation)?;
    if version.schema_version != u64::from(SCHEMA_VERSION) {
        return Err(ReportError::Version {
            found: version.schema_version,
            expected: SCHEMA_VERSION,
        });
    }
    let document: Document = serde_json::from_str(text).map_err(not_an_evaluation)?;
    let provenance = document.provenance.into_iter().map(step).collect();
    let evaluation = Evaluation {
        session: session(document.session),
        default_method: document.default_method,
        choice: document.choice.map(choice),
        dictionary: dictionary(document.dictionary)?,
        methods: document
            .methods
            .into_iter()
            .map(method)
            .collect::<Result<_, _>>()?,
        quality: document
            .quality
            .takes
            .into_iter()
            .map(take_state)
            .collect::<Result<_, _>>()?,
        intervals: (document.intervals)
            .map(super::intervals::intervals)
            .transpose()?,
        movement: document.movement.map(motion::movements),
        contacts: document.contacts.map(motion::contacts).transpose()?,
    };
    Ok((evaluation, provenance))
}

fn session(session: Session) -> SessionFacts {
    SessionFacts {
        name: session.name,
        rate_hz: number(session.rate_hz),
        segment_samples: session.segment_samples,
        object: session.object,
        participant: session.participant,
        task: session.task,
        train: session.train.into_iter().map(take).collect(),
        test: session.test.into_iter().map(take).collect(),
    }
}

fn take(take: Take) -> TakeFacts {
    TakeFacts {
        name: take.name,
        samples: take.samples,
        duration_s: number(take.duration_s),
        segments: take.segments,
        left_out: take.left_out,
    }
}

fn dictionary(dictionary: Dictionary) -> Result<DictionaryFacts, ReportError> {
    Ok(DictionaryFacts {
        kind: word(
            "dictionary.kind",
            &dictionary.kind,
            "nmf or pca",
            &[DictionaryKind::Nmf, DictionaryKind::Pca],
            DictionaryKind::name,
        )?,
        rank: dictionary.rank,
        segments: dictionary.segments,
        rms_m: metres(dictionary.rms_mm),
        relative_error: number(dictionary.relative_error),
        iterations: dictionary.iterations,
        stop_reason: word(
            "dictionary.stop_reason",
            &dictionary.stop_reason,
            "converged, target_reached, iteration_limit or closed_form",
            &[
                StopReason::Converged,
                StopReason::TargetReached,
                StopReason::IterationLimit,
                StopReason::ClosedForm,
            ],
            StopReason::name,
        )?,
        objective_history_m2: dictionary
            .objective_history_mm2
            .into_iter()
            .map(|objective| number(objective) / MM2_PER_M2)
            .collect(),
        velocity_bounds: bounds(dictionary.velocity_bounds_mm_s),
        deviation: dictionary.deviation.map(deviation),
    })
}

fn deviation(deviation: Deviation) -> DeviationFacts {
    let validation = deviation.validation;
    DeviationFacts {
        primitives: deviation.primitives,
        demonstrations: deviation.demonstrations,
        weights: ExpectationWeights {
            profile: deviation.profile_weight,
            hand: deviation.hand_weight,
            finger: deviation.finger_weight,
        },
        bandwidths: Bandwidths {
            hand: deviation.hand_bandwidth,
            finger: deviation.finger_bandwidth,
        },
        validation: Validation {
            folds: validation.folds,
            segments: validation.segments,
            smooth_error_m: metres(validation.smooth_error_mm),
            error_m: metres(validation.error_mm),
            standard_error_m: metres(validation.standard_error_mm),
        },
    }
}

fn choice(choice: Choice) -> MethodChoice {
    let known = |number: Number| number.0.map(|value| value / MM_PER_M);
    MethodChoice {
        method: choice.method,
        candidates: (choice.candidates.into_iter())
            .map(|candidate| MethodCandidate {
                name: candidate.name,
                // Null stands for a method whose plans failed.
                mean_error_m: known(candidate.mean_error_mm).unwrap_or(f64::INFINITY),
            })
            .collect(),
        gain_m: known(choice.gain_mm),
        gain_standard_error_m: known(choice.gain_standard_error_mm),
        folds: choice.folds,
        segments: choice.segments,
    }
}

fn bounds(fingers: ByFinger<Bounds>) -> VelocityBounds {
    let mut bounds = VelocityBounds {
        min_m_s: [0.0; SEGMENT_COORDINATES],
        max_m_s: [0.0; SEGMENT_COORDINATES],
    };
    for (finger, own) in fingers.into_array().into_iter().enumerate() {
        for axis in 0..3 {
            bounds.min_m_s[3 * finger + axis] = metres(own.min[axis]);
            bounds.max_m_s[3 * finger + axis] = metres(own.max[axis]);
        }
    }
    bounds
}

fn method(method: Method) -> Result<MethodEvaluation, ReportError> {
    Ok(MethodEvaluation {
        name: method.name,
        description: method.description,
        baseline: method.baseline,
        error: statistics(method.error_mm.all),
        error_by_finger: per_finger(method.error_mm.fingers, statistics),
        error_at_start: statistics(method.error_at_start_mm),
        error_at_goal: statistics(method.error_at_goal_mm),
        median_error_by_sample_m: method
            .median_error_by_sample_mm
            .into_iter()
            .map(metres)
            .collect(),
        reachability: reachability(method.reachability),
        collision: collision(method.collision)?,
        velocity: velocity(method.velocity),
        contact: method.contact.map(contact),
        distance_difference: method
            .distance_difference_mm
            .map(|fingers| per_finger(fingers, statistics)),
        object_error: (method.object_error_mm.zip(method.object_angle_deg)).map(
            |(position, angle)| ObjectError {
                position: statistics(position),
                angle: scaled_statistics(angle, |degrees| number(degrees).to_radians()),
            },
        ),
        corridors: method.corridors.into_iter().map(corridor).collect(),
        plan: method.plan.as_ref().map(plans).transpose()?,
    })
}

fn statistics(distribution: Distribution) -> Statistics {
    scaled_statistics(distribution, metres)
}

/// A distribution in another unit, which `value` comes from.
fn scaled_statistics(distribution: Distribution, value: impl Fn(Number) -> f64) -> Statistics {
    Statistics {
        n: distribution.n,
        n_filled: distribution.n_filled,
        n_left_out: distribution.n_left_out,
        mean: value(distribution.mean),
        rmse: value(distribution.rmse),
        min: value(distribution.min),
        p5: value(distribution.p5),
        p25: value(distribution.p25),
        p50: value(distribution.p50),
        p75: value(distribution.p75),
        p95: value(distribution.p95),
        max: value(distribution.max),
        whisker_low: value(distribution.whisker_low),
        whisker_high: value(distribution.whisker_high),
    }
}

fn reachability(reach: Reach) -> Reachability {
    Reachability {
        n: reach.n,
        inside: per_finger(reach.inside.fingers, number),
        worst_outside_m: per_finger(reach.worst_outside_mm, metres),
        distance: per_finger(reach.distance_mm, statistics),
        recorded_inside: per_finger(reach.recorded_inside.fingers, number),
    }
}

fn collision(collision: Collisions) -> Result<Collision, ReportError> {
    let finger = |name: &String| {
        word(
            "collision.nearest_pair",
            name,
            "thumb, index, middle, ring or little",
            &Finger::ALL,
            Finger::name,
        )
    };
    let pair = |[a, b]: [String; 2]| Ok::<_, ReportError>((finger(&a)?, finger(&b)?));
    Ok(Collision {
        n: collision.n,
        limit_m: metres(collision.limit_mm),
        instants: collision.instants,
        trajectories: collision.trajectories,
        nearest_m: metres(collision.nearest_mm),
        nearest_pair: collision.nearest_pair.map(pair).transpose()?,
        recorded_instants: collision.recorded_instants,
        recorded_nearest_m: metres(collision.recorded_nearest_mm),
    })
}

fn velocity(velocity: Velocity) -> VelocityCheck {
    VelocityCheck {
        n: velocity.n,
        outside: velocity.outside,
        trajectories_outside: velocity.trajectories_outside,
        worst_ratio: number(velocity.worst_ratio),
    }
}

fn contact(contact: Contact) -> ContactShare {
    ContactShare {
        n: contact.n,
        n_filled: contact.n_filled,
        n_left_out: contact.n_left_out,
        tau_m: metres(contact.tau_mm),
        three_or_more: number(contact.three_or_more),
        recorded_three_or_more: number(contact.recorded_three_or_more),
        by_finger: per_finger(contact.by_finger, number),
        recorded_by_finger: per_finger(contact.recorded_by_finger, number),
        by_tau: contact
            .by_tau
            .into_iter()
            .map(|at| TauShare {
                tau_m: metres(at.tau_mm),
                three_or_more: number(at.three_or_more),
                recorded_three_or_more: number(at.recorded_three_or_more),
            })
            .collect(),
    }
}

fn corridor(corridor: Corridor) -> CorridorCoverage {
    CorridorCoverage {
        share_stated: number(corridor.share_stated),
        mahalanobis: number(corridor.mahalanobis),
        n: corridor.n,
        n_filled: corridor.n_filled,
        n_left_out: corridor.n_left_out,
        share_inside: number(corridor.inside.all),
        share_inside_by_finger: per_finger(corridor.inside.fingers, number),
    }
}

fn plans(plans: &Plans) -> Result<PlanFacts, ReportError> {
    Ok(PlanFacts {
        solved: plans.solved,
        infeasible: plans.infeasible,
        failed: plans.failed,
        worst_kkt_residual: number(plans.worst_kkt_residual),
        velocity_bound_active: plans.velocity_bound_active,
        families: (plans.constraints.iter())
            .map(family)
            .collect::<Result<_, _>>()?,
        outside_hull: plans.outside_hull,
    })
}

fn family(facts: &Family) -> Result<FamilyFacts, ReportError> {
    Ok(FamilyFacts {
        family: word(
            "plan.constraints.family",
            &facts.family,
            "a family of constraints",
            &ConstraintFamily::ALL,
            ConstraintFamily::name,
        )?,
        active: facts.active,
        worst_violation: number(facts.worst_violation),
        would_mend: facts.would_mend,
        largest_relaxation: number(facts.largest_relaxation),
    })
}

fn take_state(take: TakeState) -> Result<TakeQuality, ReportError> {
    let fingers = PerFinger::new(take.fingers.into_array());
    let tracks = fingers.each_ref();
    Ok(TakeQuality {
        take: take.take,
        role: take.role,
        recorded: tracks.map(|track| counts(&track.recorded)),
        processed: tracks.map(|track| counts(&track.processed)),
        longest_gap_s: tracks.map(|track| number(track.longest_gap_s)),
        hand_tracked: number(take.hand_tracked),
        object_tracked: take.object_tracked.map(number),
        findings: take
            .findings
            .into_iter()
            .map(found)
            .collect::<Result<_, _>>()?,
    })
}

fn counts(counts: &Counts) -> TrackCounts {
    TrackCounts {
        measured: counts.measured,
        filled: counts.filled,
        missing: counts.missing,
    }
}

fn found(found: Found) -> Result<Finding, ReportError> {
    Ok(Finding {
        severity: word(
            "severity of a finding",
            &found.severity,
            "info or warning",
            &[Severity::Info, Severity::Warning],
            Severity::name,
        )?,
        place: found.place,
        message: found.message,
    })
}

/// Settings that were no JSON were kept as a string, and go back to what they were.
fn step(step: Step) -> Provenance {
    Provenance {
        tool: step.tool,
        step: step.step,
        settings_json: match step.settings {
            serde_json::Value::String(text) => text,
            value => value.to_string(),
        },
        inputs: step
            .inputs
            .into_iter()
            .map(|input| InputHash {
                name: input.name,
                sha256: input.sha256,
            })
            .collect(),
    }
}

pub(super) fn word<T: Copy>(
    key: &'static str,
    found: &str,
    expected: &'static str,
    known: &[T],
    name: impl Fn(T) -> &'static str,
) -> Result<T, ReportError> {
    known
        .iter()
        .copied()
        .find(|&value| name(value) == found)
        .ok_or_else(|| ReportError::UnknownWord {
            key,
            found: found.to_owned(),
            expected,
        })
}

fn per_finger<T, U>(fingers: ByFinger<T>, change: impl FnMut(T) -> U) -> PerFinger<U> {
    PerFinger::new(fingers.into_array()).map(change)
}

pub(super) fn number(value: Number) -> f64 {
    value.0.unwrap_or(f64::NAN)
}

fn metres(millimetres: Number) -> f64 {
    number(millimetres) / MM_PER_M
}
