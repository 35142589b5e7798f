//! From an evaluation to its document.

mod motion;

use inhand_model::{
    Collision, ContactShare, CorridorCoverage, DeviationFacts, DictionaryFacts, Evaluation,
    FamilyFacts, Finding, Finger, MethodChoice, MethodEvaluation, PerFinger, PlanFacts, Provenance,
    Reachability, SessionFacts, Statistics, TakeFacts, TakeQuality, TrackCounts, VelocityBounds,
    VelocityCheck,
};

use super::settings_value;
use super::wire::{
    AtTau, Bounds, ByFinger, Candidate, Choice, Collisions, Contact, Corridor, Counts, Deviation,
    Dictionary, Distribution, Document, Family, Found, Input, Method, Number, Plans, Quality,
    Reach, SCHEMA_VERSION, Session, Step, Take, TakeState, TrackState, Validated, Velocity,
    WithAll,
};
use crate::number::to_mm;

const MM2_PER_M2: f64 = 1e6;

/// The document of an evaluation.
pub(super) fn document(evaluation: &Evaluation, provenance: &[Provenance]) -> Document {
    Document {
        schema_version: SCHEMA_VERSION,
        session: session(&evaluation.session),
        default_method: evaluation.default_method.clone(),
        choice: evaluation.choice.as_ref().map(choice),
        dictionary: dictionary(&evaluation.dictionary),
        methods: evaluation.methods.iter().map(method).collect(),
        quality: quality(&evaluation.quality),
        intervals: (evaluation.intervals.as_ref()).map(super::intervals::document),
        movement: evaluation.movement.as_ref().map(motion::movements),
        contacts: evaluation.contacts.as_ref().map(motion::contacts),
        provenance: provenance.iter().map(step).collect(),
    }
}

fn session(facts: &SessionFacts) -> Session {
    Session {
        name: facts.name.clone(),
        rate_hz: Number::finite(facts.rate_hz),
        segment_samples: facts.segment_samples,
        object: facts.object.clone(),
        participant: facts.participant.clone(),
        task: facts.task.clone(),
        train: facts.train.iter().map(take).collect(),
        test: facts.test.iter().map(take).collect(),
    }
}

fn take(facts: &TakeFacts) -> Take {
    Take {
        name: facts.name.clone(),
        samples: facts.samples,
        duration_s: Number::finite(facts.duration_s),
        segments: facts.segments,
        left_out: facts.left_out,
    }
}

fn dictionary(facts: &DictionaryFacts) -> Dictionary {
    Dictionary {
        kind: facts.kind.name().to_owned(),
        rank: facts.rank,
        segments: facts.segments,
        rms_mm: mm(facts.rms_m),
        relative_error: Number::finite(facts.relative_error),
        iterations: facts.iterations,
        stop_reason: facts.stop_reason.name().to_owned(),
        objective_history_mm2: facts
            .objective_history_m2
            .iter()
            .map(|&objective| Number::finite(objective * MM2_PER_M2))
            .collect(),
        velocity_bounds_mm_s: ByFinger::from_fn(|finger| bounds(&facts.velocity_bounds, finger)),
        deviation: facts.deviation.as_ref().map(deviation),
    }
}

fn deviation(facts: &DeviationFacts) -> Deviation {
    let validation = facts.validation;
    Deviation {
        primitives: facts.primitives,
        demonstrations: facts.demonstrations,
        profile_weight: facts.weights.profile,
        hand_weight: facts.weights.hand,
        finger_weight: facts.weights.finger,
        hand_bandwidth: facts.bandwidths.hand,
        finger_bandwidth: facts.bandwidths.finger,
        validation: Validated {
            folds: validation.folds,
            segments: validation.segments,
            smooth_error_mm: mm(validation.smooth_error_m),
            error_mm: mm(validation.error_m),
            standard_error_mm: mm(validation.standard_error_m),
        },
    }
}

fn choice(choice: &MethodChoice) -> Choice {
    let or_null = |value: Option<f64>| mm(value.unwrap_or(f64::NAN));
    Choice {
        method: choice.method.clone(),
        candidates: (choice.candidates.iter())
            .map(|candidate| Candidate {
                name: candidate.name.clone(),
                mean_error_mm: mm(candidate.mean_error_m),
            })
            .collect(),
        gain_mm: or_null(choice.gain_m),
        gain_standard_error_mm: or_null(choice.gain_standard_error_m),
        folds: choice.folds,
        segments: choice.segments,
    }
}

fn bounds(velocity: &VelocityBounds, finger: Finger) -> Bounds {
    let axes = |values: &[f64]| std::array::from_fn(|axis| mm(values[3 * finger.index() + axis]));
    Bounds {
        min: axes(&velocity.min_m_s),
        max: axes(&velocity.max_m_s),
    }
}

fn method(method: &MethodEvaluation) -> Method {
    Method {
        name: method.name.clone(),
        description: method.description.clone(),
        baseline: method.baseline,
        error_mm: WithAll {
            all: distribution(&method.error),
            fingers: ByFinger::from_fn(|finger| distribution(&method.error_by_finger[finger])),
        },
        error_at_start_mm: distribution(&method.error_at_start),
        error_at_goal_mm: distribution(&method.error_at_goal),
        median_error_by_sample_mm: method
            .median_error_by_sample_m
            .iter()
            .copied()
            .map(mm)
            .collect(),
        reachability: reachability(&method.reachability),
        collision: collision(&method.collision),
        velocity: velocity(&method.velocity),
        contact: method.contact.as_ref().map(contact),
        distance_difference_mm: method
            .distance_difference
            .as_ref()
            .map(|fingers| ByFinger::from_fn(|finger| distribution(&fingers[finger]))),
        object_error_mm: (method.object_error.as_ref()).map(|error| distribution(&error.position)),
        object_angle_deg: (method.object_error.as_ref())
            .map(|error| scaled_distribution(&error.angle, f64::to_degrees)),
        corridors: method.corridors.iter().map(corridor).collect(),
        plan: method.plan.as_ref().map(plans),
    }
}

/// Quantiles of nothing do not exist: with n = 0 every number is null, whatever stands there.
pub(super) fn distribution(statistics: &Statistics) -> Distribution {
    scaled_distribution(statistics, to_mm)
}

/// The same in the unit that `scale` goes to.
fn scaled_distribution(statistics: &Statistics, scale: impl Fn(f64) -> f64) -> Distribution {
    let value = |value: f64| Number::finite(scale(value)).only_if(statistics.n > 0);
    Distribution {
        n: statistics.n,
        n_filled: statistics.n_filled,
        n_left_out: statistics.n_left_out,
        mean: value(statistics.mean),
        rmse: value(statistics.rmse),
        min: value(statistics.min),
        p5: value(statistics.p5),
        p25: value(statistics.p25),
        p50: value(statistics.p50),
        p75: value(statistics.p75),
        p95: value(statistics.p95),
        max: value(statistics.max),
        whisker_low: value(statistics.whisker_low),
        whisker_high: value(statistics.whisker_high),
    }
}

fn reachability(reach: &Reachability) -> Reach {
    let judged = |value: f64| Number::finite(value).only_if(reach.n > 0);
    let with_all = |shares: &PerFinger<f64>| WithAll {
        all: judged(super::mean(shares)),
        fingers: ByFinger::from_fn(|finger| judged(shares[finger])),
    };
    Reach {
        n: reach.n,
        inside: with_all(&reach.inside),
        recorded_inside: with_all(&reach.recorded_inside),
        worst_outside_mm: ByFinger::from_fn(|finger| judged(to_mm(reach.worst_outside_m[finger]))),
        distance_mm: ByFinger::from_fn(|finger| distribution(&reach.distance[finger])),
    }
}

fn collision(collision: &Collision) -> Collisions {
    Collisions {
        n: collision.n,
        limit_mm: mm(collision.limit_m),
        instants: collision.instants,
        trajectories: collision.trajectories,
        nearest_mm: mm(collision.nearest_m).only_if(collision.n > 0),
        nearest_pair: collision
            .nearest_pair
            .map(|(a, b)| [a, b].map(|finger| finger.name().to_owned())),
        recorded_instants: collision.recorded_instants,
        recorded_nearest_mm: mm(collision.recorded_nearest_m).only_if(collision.n > 0),
    }
}

fn velocity(check: &VelocityCheck) -> Velocity {
    Velocity {
        n: check.n,
        outside: check.outside,
        trajectories_outside: check.trajectories_outside,
        worst_ratio: Number::finite(check.worst_ratio).only_if(check.n > 0),
    }
}

fn contact(share: &ContactShare) -> Contact {
    let judged = |value: f64| Number::finite(value).only_if(share.n > 0);
    Contact {
        n: share.n,
        n_filled: share.n_filled,
        n_left_out: share.n_left_out,
        tau_mm: mm(share.tau_m),
        three_or_more: judged(share.three_or_more),
        recorded_three_or_more: judged(share.recorded_three_or_more),
        by_finger: ByFinger::from_fn(|finger| judged(share.by_finger[finger])),
        recorded_by_finger: ByFinger::from_fn(|finger| judged(share.recorded_by_finger[finger])),
        by_tau: share
            .by_tau
            .iter()
            .map(|at| AtTau {
                tau_mm: mm(at.tau_m),
                three_or_more: judged(at.three_or_more),
                recorded_three_or_more: judged(at.recorded_three_or_more),
            })
            .collect(),
    }
}

fn corridor(coverage: &CorridorCoverage) -> Corridor {
    let judged = |value: f64| Number::finite(value).only_if(coverage.n > 0);
    Corridor {
        share_stated: Number::finite(coverage.share_stated),
        mahalanobis: Number::finite(coverage.mahalanobis),
        n: coverage.n,
        n_filled: coverage.n_filled,
        n_left_out: coverage.n_left_out,
        inside: WithAll {
            all: judged(coverage.share_inside),
            fingers: ByFinger::from_fn(|finger| judged(coverage.share_inside_by_finger[finger])),
        },
    }
}

fn plans(facts: &PlanFacts) -> Plans {
    Plans {
        solved: facts.solved,
        infeasible: facts.infeasible,
        failed: facts.failed,
        worst_kkt_residual: Number::finite(facts.worst_kkt_residual),
        velocity_bound_active: facts.velocity_bound_active,
        constraints: facts.families.iter().map(family).collect(),
        outside_hull: facts.outside_hull,
    }
}

fn family(facts: &FamilyFacts) -> Family {
    Family {
        family: facts.family.name().to_owned(),
        unit: facts.family.unit().to_owned(),
        active: facts.active,
        worst_violation: Number::finite(facts.worst_violation),
        would_mend: facts.would_mend,
        largest_relaxation: Number::finite(facts.largest_relaxation),
    }
}

fn quality(takes: &[TakeQuality]) -> Quality {
    Quality {
        warnings: takes.iter().map(crate::quality::warnings).sum(),
        takes: takes.iter().map(take_state).collect(),
    }
}

fn take_state(quality: &TakeQuality) -> TakeState {
    TakeState {
        take: quality.take.clone(),
        role: quality.role.clone(),
        hand_tracked: Number::finite(quality.hand_tracked),
        object_tracked: quality.object_tracked.map(Number::finite),
        fingers: ByFinger::from_fn(|finger| TrackState {
            recorded: counts(quality.recorded[finger]),
            processed: counts(quality.processed[finger]),
            longest_gap_s: Number::finite(quality.longest_gap_s[finger]),
        }),
        findings: quality.findings.iter().map(found).collect(),
    }
}

fn counts(counts: TrackCounts) -> Counts {
    Counts {
        measured: counts.measured,
        filled: counts.filled,
        missing: counts.missing,
    }
}

fn found(finding: &Finding) -> Found {
    Found {
        severity: finding.severity.name().to_owned(),
        place: finding.place.clone(),
        message: finding.message.clone(),
    }
}

fn step(provenance: &Provenance) -> Step {
    Step {
        tool: provenance.tool.clone(),
        step: provenance.step.clone(),
        settings: settings_value(&provenance.settings_json),
        inputs: provenance
            .inputs
            .iter()
            .map(|input| Input {
                name: input.name.clone(),
                sha256: input.sha256.clone(),
            })
            .collect(),
    }
}

fn mm(metres: f64) -> Number {
    Number::finite(to_mm(metres))
}
