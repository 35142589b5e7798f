//! The steps on values: process, demonstrate, learn, generate, evaluate. No file is touched here.

use std::time::Duration;

use inhand_contact::hull;
use inhand_dictionary::{NmfSettings, learn_nmf};
use inhand_evaluation::{
    EvaluationSettings, MethodResult, Recorded, Rows, TestData, evaluate_method, recorded,
    recording_quality,
};
use inhand_model::{
    Demonstrated, Dictionary, DictionaryFacts, Evaluation, Finger, MethodEvaluation, Motion,
    PerFinger, Plan, Roles, SegmentLayout, Segments, SessionFacts, TakeFacts, TakeQuality,
    Trajectory, VelocityBounds,
};
use inhand_motion::{
    SegmentSettings, Templates, cut_segments, fit_templates, smooth, to_hand_frame,
};
use inhand_planner::{Ends, Planner, PlannerSettings, plan_all, widened};
use inhand_trajectory::velocity;
use rayon::prelude::*;

use crate::error::PipelineError;
use crate::methods::Method;
use crate::settings::{Role, Settings};
use crate::take::Take;

/// Brings takes into the hand's frame and filters them, in order.
///
/// # Errors
///
/// [`PipelineError::Motion`] for the first take that cannot be processed.
pub fn process_takes(takes: &[Take], settings: &Settings) -> Result<Vec<Motion>, PipelineError> {
    smooth_motions(&motions_in_hand(takes, settings)?, settings)
}

/// Brings takes into the hand's frame, gaps filled, in order.
///
/// # Errors
///
/// [`PipelineError::Motion`] for the first take that cannot be processed.
pub fn motions_in_hand(takes: &[Take], settings: &Settings) -> Result<Vec<Motion>, PipelineError> {
    let roles = takes
        .iter()
        .map(Take::roles)
        .collect::<Result<Vec<_>, _>>()?;
    let templates = templates(takes, &roles)?;
    let process_settings = settings.process_settings()?;
    let motions: Vec<_> = (takes.par_iter().zip(&roles))
        .map(|(take, roles)| {
            to_hand_frame(&take.recording, roles, &templates, &process_settings).map_err(|source| {
                PipelineError::Motion {
                    take: take.name.clone(),
                    source: source.into(),
                }
            })
        })
        .collect();
    motions.into_iter().collect()
}

/// Filters motions, in order.
///
/// # Errors
///
/// [`PipelineError::Motion`] for a filter that cannot be used.
pub fn smooth_motions(
    motions: &[Motion],
    settings: &Settings,
) -> Result<Vec<Motion>, PipelineError> {
    let filter = settings.process_settings()?.filter;
    let smoothed: Vec<_> = (motions.par_iter())
        .map(|motion| {
            smooth(motion, filter).map_err(|source| PipelineError::Motion {
                take: motion.name.clone(),
                source: source.into(),
            })
        })
        .collect();
    smoothed.into_iter().collect()
}

/// Motions that an earlier step stored in takes; takes processed now where `reuse` is false or any
/// take of the call has none stored.
///
/// # Errors
///
/// As [`process_takes`].
pub fn motions(
    takes: &[Take],
    settings: &Settings,
    reuse: bool,
) -> Result<Vec<Motion>, PipelineError> {
    if !reuse {
        return process_takes(takes, settings);
    }
    let stored: Option<Vec<_>> = takes
        .iter()
        .map(|take| take.stored_motion.clone())
        .collect();
    stored.map_or_else(|| process_takes(takes, settings), Ok)
}

fn templates(takes: &[Take], roles: &[&Roles]) -> Result<Templates, PipelineError> {
    let pairs = takes
        .iter()
        .map(|take| &take.recording)
        .zip(roles.iter().copied());
    fit_templates(pairs).map_err(|source| PipelineError::Motion {
        take: "the session".to_owned(),
        source: source.into(),
    })
}

/// Segments of motions, by the rules of their role.
///
/// # Errors
///
/// [`PipelineError::Motion`] where the motions do not go together.
pub fn segments(
    motions: &[&Motion],
    role: Role,
    settings: &Settings,
) -> Result<Segments, PipelineError> {
    let segment_settings = segment_settings(motions, role, settings);
    cut_segments(motions, &segment_settings).map_err(|source| PipelineError::Motion {
        take: format!("{} takes", role.name()),
        source: source.into(),
    })
}

fn segment_settings(motions: &[&Motion], role: Role, settings: &Settings) -> SegmentSettings {
    let rate_hz = motions.first().map_or(1.0, |motion| motion.clock.rate_hz());
    let layout = SegmentLayout::one_second(rate_hz);
    let stride = match (role, settings.segments.stride) {
        (Role::Test, _) | (Role::Train, 0) => layout.samples,
        (Role::Train, stride) => stride,
    };
    SegmentSettings {
        layout,
        stride,
        margin_s: settings.segments.margin_s,
    }
}

/// What training motions show: hulls and velocity extremes.
///
/// # Errors
///
/// [`PipelineError::Hull`] where a fingertip was never seen, or does not move.
pub fn demonstrated(motions: &[&Motion]) -> Result<Demonstrated, PipelineError> {
    let hulls: Vec<_> = Finger::ALL
        .into_par_iter()
        .map(|finger| {
            let tracks = motions.iter().map(|motion| &motion.fingertips[finger]);
            let points: Vec<_> = tracks.flat_map(|track| track.iter().flatten()).collect();
            hull(&points).map_err(|source| PipelineError::Hull {
                finger,
                source: source.into(),
            })
        })
        .collect();
    let mut hulls = hulls.into_iter();
    let hulls = PerFinger::try_from_fn(|_| {
        hulls
            .next()
            .expect("one hull was computed for each of the five fingers")
    })?;
    // A hull needs points, so there are neighbouring samples unless every other one is missing.
    let velocity = velocity::extremes(motions.iter().copied()).ok_or_else(|| {
        let message = "no two neighbouring samples are present in the training takes".to_owned();
        PipelineError::Take {
            path: "training takes".into(),
            message,
        }
    })?;
    Ok(Demonstrated { hulls, velocity })
}

/// Learns the dictionary.
///
/// # Errors
///
/// [`PipelineError::Learn`].
pub fn learn(
    segments: &Segments,
    demonstrated: Demonstrated,
    settings: &Settings,
) -> Result<Dictionary, PipelineError> {
    learn_nmf(segments, demonstrated, &nmf_settings(settings))
        .map_err(|source| PipelineError::Learn(source.into()))
}

fn nmf_settings(settings: &Settings) -> NmfSettings {
    let section = &settings.learn;
    NmfSettings {
        rank: section.rank,
        seed: section.seed,
        max_iterations: section.max_iterations,
        sweeps: section.sweeps,
        relative_change: section.relative_change,
        stop_rms_m: section.stop_rms_mm.map(|mm| mm / 1000.0),
        ..NmfSettings::default()
    }
}

/// What one method made of every test segment.
#[derive(Clone, Debug)]
pub struct Generated {
    /// The method.
    pub method: Method,
    /// A trajectory for each segment; `None` where planning failed.
    pub trajectories: Vec<Option<Trajectory>>,
    /// A plan for each segment, of learned methods.
    pub plans: Option<Vec<Plan>>,
    /// Time of each plan, of learned methods.
    pub plan_times: Vec<Duration>,
}

/// Generates a trajectory for every segment.
///
/// # Errors
///
/// [`PipelineError::Plan`] for settings or a dictionary that cannot be used. A plan that is
/// infeasible is data, not an error.
pub fn generate(
    method: Method,
    dictionary: &Dictionary,
    segments: &Segments,
    settings: &Settings,
) -> Result<Generated, PipelineError> {
    let Some(planner_method) = method.planner() else {
        let layout = segments.layout();
        let trajectories = segments
            .ends()
            .iter()
            .map(|ends| method.curve(ends, layout))
            .collect();
        return Ok(Generated {
            method,
            trajectories,
            plans: None,
            plan_times: Vec::new(),
        });
    };
    let plan_error = |source: inhand_planner::PlanError| PipelineError::Plan {
        method: method.name().to_owned(),
        source: source.into(),
    };
    let planner = Planner::new(
        dictionary,
        planner_method,
        &planner_settings(dictionary, settings),
    )
    .map_err(plan_error)?;
    let ends = segments.ends().iter();
    let targets: Vec<_> = ends.map(|ends| planner_method.target(ends)).collect();
    let (mut plans, mut plan_times) = (Vec::new(), Vec::new());
    for (plan, time) in plan_all(&planner, &targets) {
        plans.push(plan.map_err(plan_error)?);
        plan_times.push(time);
    }
    let trajectories = plans.iter().map(|plan| plan.trajectory.clone()).collect();
    Ok(Generated {
        method,
        trajectories,
        plans: Some(plans),
        plan_times,
    })
}

fn velocity_bounds(dictionary: &Dictionary, settings: &Settings) -> VelocityBounds {
    widened(
        &dictionary.demonstrated.velocity,
        settings.plan.velocity_factor,
    )
}

fn planner_settings(dictionary: &Dictionary, settings: &Settings) -> PlannerSettings {
    PlannerSettings {
        ends: Ends::Soft {
            sigma_m: settings.plan.sigma_mm / 1000.0,
        },
        ridge: settings.plan.ridge,
        ..PlannerSettings::new(velocity_bounds(dictionary, settings))
    }
}

/// What is compared with what: the recorded side of an evaluation.
#[derive(Debug)]
pub struct Comparison<'a> {
    data: TestData<'a>,
    settings: EvaluationSettings,
    recorded: Recorded,
}

/// Measures the recorded motion: distances, contacts, where it lies.
///
/// # Errors
///
/// [`PipelineError::Settings`].
pub fn measure_recorded<'a>(
    segments: &'a Segments,
    motions: &'a [&'a Motion],
    dictionary: &'a Dictionary,
    settings: &Settings,
) -> Result<Comparison<'a>, PipelineError> {
    let data = TestData {
        segments,
        motions,
        demonstrated: &dictionary.demonstrated,
        velocity_bounds: velocity_bounds(dictionary, settings),
        shape: settings.shape()?,
    };
    let settings = EvaluationSettings {
        tau_m: settings.evaluate.tau_mm / 1000.0,
        collision_limit_m: settings.evaluate.collision_mm / 1000.0,
        finger_offsets_m: settings.pad_offsets_m()?,
        ..EvaluationSettings::paper()
    };
    let recorded = recorded(&data, &settings);
    Ok(Comparison {
        data,
        settings,
        recorded,
    })
}

/// Compares a method's motion with the recorded one.
pub fn evaluate(comparison: &Comparison<'_>, generated: &Generated) -> (MethodEvaluation, Rows) {
    let method = MethodResult {
        name: generated.method.name(),
        description: generated.method.description(),
        baseline: generated.method.planner().is_none(),
        trajectories: &generated.trajectories,
        objects: None,
        corridors: None,
        plans: generated.plans.as_deref(),
    };
    evaluate_method(
        &comparison.data,
        &comparison.recorded,
        &method,
        &comparison.settings,
    )
}

/// Facts of the dictionary for an evaluation.
pub fn dictionary_facts(dictionary: &Dictionary, settings: &Settings) -> DictionaryFacts {
    let learning = &dictionary.learning;
    DictionaryFacts {
        kind: dictionary.kind,
        rank: dictionary.rank(),
        segments: learning.segments,
        rms_m: learning.rms_m,
        relative_error: learning.relative_error,
        iterations: learning.iterations,
        stop_reason: learning.stop_reason,
        objective_history_m2: learning.objective_history_m2.clone(),
        velocity_bounds: velocity_bounds(dictionary, settings),
    }
}

/// A take with what was made of it.
#[derive(Clone, Copy, Debug)]
pub struct TakeResult<'a> {
    /// The take.
    pub take: &'a Take,
    /// Its motion.
    pub motion: &'a Motion,
    /// What it was for.
    pub role: Role,
}

/// Facts of the session for an evaluation.
pub fn session_facts(
    name: &str,
    takes: &[TakeResult<'_>],
    train: Option<&Segments>,
    test: &Segments,
    settings: &Settings,
) -> SessionFacts {
    let facts = |role: Role, segments: &Segments| -> Vec<TakeFacts> {
        let of_role: Vec<_> = takes.iter().filter(|take| take.role == role).collect();
        let motions: Vec<_> = of_role.iter().map(|take| take.motion).collect();
        let cut = segment_settings(&motions, role, settings);
        (of_role.iter().enumerate())
            .map(|(index, result)| {
                let found = segments
                    .origins()
                    .iter()
                    .filter(|o| o.take == index)
                    .count();
                let samples = result.motion.len();
                TakeFacts {
                    name: result.take.name.clone(),
                    samples,
                    duration_s: samples as f64 / result.motion.clock.rate_hz(),
                    segments: found,
                    left_out: segments_without_gaps(samples, &cut).saturating_sub(found),
                }
            })
            .collect()
    };
    SessionFacts {
        name: name.to_owned(),
        rate_hz: test.layout().rate_hz,
        segment_samples: test.layout().samples,
        object: settings.object.shape.clone(),
        train: train.map_or_else(Vec::new, |train| facts(Role::Train, train)),
        test: facts(Role::Test, test),
    }
}

fn segments_without_gaps(samples: usize, cut: &SegmentSettings) -> usize {
    let margin = (cut.margin_s * cut.layout.rate_hz).round() as usize;
    samples
        .checked_sub(cut.layout.samples + 2 * margin)
        .map_or(0, |room| room / cut.stride.max(1) + 1)
}

/// What each take's data is worth.
///
/// # Errors
///
/// [`PipelineError::Take`] where a take has no roles.
pub fn quality(takes: &[TakeResult<'_>]) -> Result<Vec<TakeQuality>, PipelineError> {
    let one = |result: &TakeResult<'_>| {
        let roles = result.take.roles()?;
        let mut quality = recording_quality(
            &result.take.recording,
            roles,
            result.motion,
            result.role.name(),
        );
        quality.take.clone_from(&result.take.name);
        Ok(quality)
    };
    takes
        .par_iter()
        .map(one)
        .collect::<Vec<_>>()
        .into_iter()
        .collect()
}

/// Puts the parts of an evaluation together.
pub fn assemble(
    session: SessionFacts,
    dictionary: DictionaryFacts,
    methods: Vec<MethodEvaluation>,
    quality: Vec<TakeQuality>,
) -> Evaluation {
    let default_method = methods
        .first()
        .map_or_else(String::new, |method| method.name.clone());
    Evaluation {
        session,
        default_method,
        dictionary,
        methods,
        quality,
    }
}
