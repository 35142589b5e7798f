//! `evaluation.json`: the form that outside scripts read. The contract is
//! `schemas/evaluation.schema.json`; these structs are written to fit it and nothing else uses
//! them. Lengths are millimetres and say so in their keys; a number that does not exist is null.

use inhand_model::{
    Collision, ContactShare, DictionaryFacts, Evaluation, Finding, Finger, MethodEvaluation,
    PerFinger, PlanFacts, Provenance, Reachability, SessionFacts, Statistics, TakeFacts,
    TakeQuality, TrackCounts, VelocityBounds, VelocityCheck,
};
use serde::Serialize;

use crate::error::ReportError;
use crate::number::to_mm;

/// Raised when a key changes its meaning or goes away; new keys alone do not raise it.
pub(crate) const SCHEMA_VERSION: u32 = 1;

const MM2_PER_M2: f64 = 1e6;

/// Writes the document with two spaces of indent and a trailing newline.
pub(crate) fn write(
    evaluation: &Evaluation,
    provenance: &[Provenance],
) -> Result<String, ReportError> {
    let mut text =
        serde_json::to_string_pretty(&document(evaluation, provenance)).map_err(|source| {
            ReportError::Json {
                session: evaluation.session.name.clone(),
                source,
            }
        })?;
    text.push('\n');
    Ok(text)
}

/// Settings as JSON; text that is no JSON (another tool's provenance) is kept as a string.
pub(crate) fn settings_value(settings_json: &str) -> serde_json::Value {
    serde_json::from_str(settings_json)
        .unwrap_or_else(|_| serde_json::Value::String(settings_json.to_owned()))
}

/// A number, or null.
type Number = Option<f64>;

#[derive(Serialize)]
struct Document<'a> {
    schema_version: u32,
    session: Session<'a>,
    default_method: &'a str,
    dictionary: Dictionary,
    methods: Vec<Method<'a>>,
    quality: Quality<'a>,
    provenance: Vec<Step<'a>>,
}

#[derive(Serialize)]
struct Session<'a> {
    name: &'a str,
    rate_hz: Number,
    segment_samples: usize,
    object: Option<&'a str>,
    train: Vec<Take<'a>>,
    test: Vec<Take<'a>>,
}

#[derive(Serialize)]
struct Take<'a> {
    name: &'a str,
    samples: usize,
    duration_s: Number,
    segments: usize,
    left_out: usize,
}

#[derive(Serialize)]
struct Dictionary {
    kind: &'static str,
    rank: usize,
    segments: usize,
    rms_mm: Number,
    relative_error: Number,
    iterations: usize,
    stop_reason: &'static str,
    objective_history_mm2: Vec<Number>,
    velocity_bounds_mm_s: ByFinger<Bounds>,
}

#[derive(Serialize)]
struct Bounds {
    min: [Number; 3],
    max: [Number; 3],
}

#[derive(Serialize)]
struct Method<'a> {
    name: &'a str,
    description: &'a str,
    baseline: bool,
    error_mm: WithAll<Distribution>,
    error_at_start_mm: Distribution,
    error_at_goal_mm: Distribution,
    median_error_by_sample_mm: Vec<Number>,
    reachability: Reach,
    collision: Collisions,
    velocity: Velocity,
    contact: Option<Contact>,
    distance_difference_mm: Option<ByFinger<Distribution>>,
    plan: Option<Plans>,
}

#[derive(Serialize)]
struct ByFinger<T> {
    thumb: T,
    index: T,
    middle: T,
    ring: T,
    little: T,
}

#[derive(Serialize)]
struct WithAll<T> {
    all: T,
    #[serde(flatten)]
    fingers: ByFinger<T>,
}

#[derive(Serialize)]
struct Distribution {
    n: usize,
    n_filled: usize,
    n_left_out: usize,
    mean: Number,
    rmse: Number,
    min: Number,
    p5: Number,
    p25: Number,
    p50: Number,
    p75: Number,
    p95: Number,
    max: Number,
    whisker_low: Number,
    whisker_high: Number,
}

#[derive(Serialize)]
struct Reach {
    n: usize,
    inside: WithAll<Number>,
    recorded_inside: WithAll<Number>,
    worst_outside_mm: ByFinger<Number>,
    distance_mm: ByFinger<Distribution>,
}

#[derive(Serialize)]
struct Collisions {
    n: usize,
    limit_mm: Number,
    instants: usize,
    trajectories: usize,
    nearest_mm: Number,
    nearest_pair: Option<[&'static str; 2]>,
    recorded_instants: usize,
    recorded_nearest_mm: Number,
}

#[derive(Serialize)]
struct Velocity {
    n: usize,
    outside: usize,
    trajectories_outside: usize,
    worst_ratio: Number,
}

#[derive(Serialize)]
struct Contact {
    n: usize,
    n_filled: usize,
    n_left_out: usize,
    tau_mm: Number,
    three_or_more: Number,
    recorded_three_or_more: Number,
    by_finger: ByFinger<Number>,
    recorded_by_finger: ByFinger<Number>,
    by_tau: Vec<AtTau>,
}

#[derive(Serialize)]
struct AtTau {
    tau_mm: Number,
    three_or_more: Number,
    recorded_three_or_more: Number,
}

#[derive(Serialize)]
struct Plans {
    solved: usize,
    infeasible: usize,
    failed: usize,
    worst_kkt_residual: Number,
    velocity_bound_active: usize,
}

#[derive(Serialize)]
struct Quality<'a> {
    warnings: usize,
    takes: Vec<TakeState<'a>>,
}

#[derive(Serialize)]
struct TakeState<'a> {
    take: &'a str,
    role: &'a str,
    hand_tracked: Number,
    object_tracked: Number,
    fingers: ByFinger<TrackState>,
    findings: Vec<Found<'a>>,
}

#[derive(Serialize)]
struct TrackState {
    recorded: Counts,
    processed: Counts,
    longest_gap_s: Number,
}

#[derive(Serialize)]
struct Counts {
    measured: usize,
    filled: usize,
    missing: usize,
}

#[derive(Serialize)]
struct Found<'a> {
    severity: &'static str,
    place: &'a str,
    message: &'a str,
}

#[derive(Serialize)]
struct Step<'a> {
    tool: &'a str,
    step: &'a str,
    settings: serde_json::Value,
    inputs: Vec<Input<'a>>,
}

#[derive(Serialize)]
struct Input<'a> {
    name: &'a str,
    sha256: &'a str,
}

fn document<'a>(evaluation: &'a Evaluation, provenance: &'a [Provenance]) -> Document<'a> {
    Document {
        schema_version: SCHEMA_VERSION,
        session: session(&evaluation.session),
        default_method: &evaluation.default_method,
        dictionary: dictionary(&evaluation.dictionary),
        methods: evaluation.methods.iter().map(method).collect(),
        quality: quality(&evaluation.quality),
        provenance: provenance.iter().map(step).collect(),
    }
}

fn session(facts: &SessionFacts) -> Session<'_> {
    Session {
        name: &facts.name,
        rate_hz: finite(facts.rate_hz),
        segment_samples: facts.segment_samples,
        object: facts.object.as_deref(),
        train: facts.train.iter().map(take).collect(),
        test: facts.test.iter().map(take).collect(),
    }
}

fn take(facts: &TakeFacts) -> Take<'_> {
    Take {
        name: &facts.name,
        samples: facts.samples,
        duration_s: finite(facts.duration_s),
        segments: facts.segments,
        left_out: facts.left_out,
    }
}

fn dictionary(facts: &DictionaryFacts) -> Dictionary {
    Dictionary {
        kind: facts.kind.name(),
        rank: facts.rank,
        segments: facts.segments,
        rms_mm: mm(facts.rms_m),
        relative_error: finite(facts.relative_error),
        iterations: facts.iterations,
        stop_reason: facts.stop_reason.name(),
        objective_history_mm2: facts
            .objective_history_m2
            .iter()
            .map(|&objective| finite(objective * MM2_PER_M2))
            .collect(),
        velocity_bounds_mm_s: by_finger(|finger| bounds(&facts.velocity_bounds, finger)),
    }
}

fn bounds(velocity: &VelocityBounds, finger: Finger) -> Bounds {
    let axes = |values: &[f64]| std::array::from_fn(|axis| mm(values[3 * finger.index() + axis]));
    Bounds {
        min: axes(&velocity.min_m_s),
        max: axes(&velocity.max_m_s),
    }
}

fn method(method: &MethodEvaluation) -> Method<'_> {
    Method {
        name: &method.name,
        description: &method.description,
        baseline: method.baseline,
        error_mm: WithAll {
            all: distribution(&method.error),
            fingers: by_finger(|finger| distribution(&method.error_by_finger[finger])),
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
            .map(|fingers| by_finger(|finger| distribution(&fingers[finger]))),
        plan: method.plan.as_ref().map(plans),
    }
}

/// Quantiles of nothing do not exist: with n = 0 every number is null, whatever stands there.
fn distribution(statistics: &Statistics) -> Distribution {
    let value = |metres: f64| mm(metres).filter(|_| statistics.n > 0);
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
    let judged = |value: f64| finite(value).filter(|_| reach.n > 0);
    let with_all = |shares: &PerFinger<f64>| WithAll {
        all: judged(mean(shares)),
        fingers: by_finger(|finger| judged(shares[finger])),
    };
    Reach {
        n: reach.n,
        inside: with_all(&reach.inside),
        recorded_inside: with_all(&reach.recorded_inside),
        worst_outside_mm: by_finger(|finger| judged(to_mm(reach.worst_outside_m[finger]))),
        distance_mm: by_finger(|finger| distribution(&reach.distance[finger])),
    }
}

/// Share over all fingers; each finger was judged at the same number of instants.
pub(crate) fn mean(shares: &PerFinger<f64>) -> f64 {
    shares.as_array().iter().sum::<f64>() / Finger::COUNT as f64
}

fn collision(collision: &Collision) -> Collisions {
    Collisions {
        n: collision.n,
        limit_mm: mm(collision.limit_m),
        instants: collision.instants,
        trajectories: collision.trajectories,
        nearest_mm: mm(collision.nearest_m).filter(|_| collision.n > 0),
        nearest_pair: collision.nearest_pair.map(|(a, b)| [a.name(), b.name()]),
        recorded_instants: collision.recorded_instants,
        recorded_nearest_mm: mm(collision.recorded_nearest_m).filter(|_| collision.n > 0),
    }
}

fn velocity(check: &VelocityCheck) -> Velocity {
    Velocity {
        n: check.n,
        outside: check.outside,
        trajectories_outside: check.trajectories_outside,
        worst_ratio: finite(check.worst_ratio).filter(|_| check.n > 0),
    }
}

fn contact(share: &ContactShare) -> Contact {
    let judged = |value: f64| finite(value).filter(|_| share.n > 0);
    Contact {
        n: share.n,
        n_filled: share.n_filled,
        n_left_out: share.n_left_out,
        tau_mm: mm(share.tau_m),
        three_or_more: judged(share.three_or_more),
        recorded_three_or_more: judged(share.recorded_three_or_more),
        by_finger: by_finger(|finger| judged(share.by_finger[finger])),
        recorded_by_finger: by_finger(|finger| judged(share.recorded_by_finger[finger])),
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

fn plans(facts: &PlanFacts) -> Plans {
    Plans {
        solved: facts.solved,
        infeasible: facts.infeasible,
        failed: facts.failed,
        worst_kkt_residual: finite(facts.worst_kkt_residual),
        velocity_bound_active: facts.velocity_bound_active,
    }
}

fn quality(takes: &[TakeQuality]) -> Quality<'_> {
    Quality {
        warnings: takes.iter().map(crate::quality::warnings).sum(),
        takes: takes.iter().map(take_state).collect(),
    }
}

fn take_state(quality: &TakeQuality) -> TakeState<'_> {
    TakeState {
        take: &quality.take,
        role: &quality.role,
        hand_tracked: finite(quality.hand_tracked),
        object_tracked: quality.object_tracked.and_then(finite),
        fingers: by_finger(|finger| TrackState {
            recorded: counts(quality.recorded[finger]),
            processed: counts(quality.processed[finger]),
            longest_gap_s: finite(quality.longest_gap_s[finger]),
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

fn found(finding: &Finding) -> Found<'_> {
    Found {
        severity: finding.severity.name(),
        place: &finding.place,
        message: &finding.message,
    }
}

fn step(provenance: &Provenance) -> Step<'_> {
    Step {
        tool: &provenance.tool,
        step: &provenance.step,
        settings: settings_value(&provenance.settings_json),
        inputs: provenance
            .inputs
            .iter()
            .map(|input| Input {
                name: &input.name,
                sha256: &input.sha256,
            })
            .collect(),
    }
}

fn by_finger<T>(mut make: impl FnMut(Finger) -> T) -> ByFinger<T> {
    ByFinger {
        thumb: make(Finger::Thumb),
        index: make(Finger::Index),
        middle: make(Finger::Middle),
        ring: make(Finger::Ring),
        little: make(Finger::Little),
    }
}

fn finite(value: f64) -> Number {
    value.is_finite().then_some(value)
}

fn mm(metres: f64) -> Number {
    finite(to_mm(metres))
}
