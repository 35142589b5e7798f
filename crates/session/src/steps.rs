//! The steps on values: process, demonstrate, learn, generate, evaluate. No file is touched here.

use inhand_evaluation::{
    Corridors, EvaluationSettings, MethodResult, ObjectPoses, Recorded, TestData, evaluate_method,
    recorded, recording_quality,
};
use inhand_inspection::Coverage;
use inhand_model::{
    Dictionary, DictionaryFacts, Evaluation, EvaluationRows, MethodEvaluation, MethodRows, Motion,
    PerProtocol, Plan, Protocol, Roles, SegmentLayout, Segments, SessionFacts, TakeFacts,
    TakeQuality,
};
use inhand_motion::{
    Cut, EndsRule, FoundSegments, SegmentSettings, SegmentTable, Templates, fit_templates_to,
    smooth, to_hand_frame, with_hand,
};

use crate::error::{Located, SessionError, invalid};
use crate::settings::{ObjectInSegments, Role, Settings};
use crate::take::Take;

mod choose;
mod generate;
mod held_out;
mod illustrate;
mod intervals;
mod learn;
mod motion;
mod rank;
mod select;
mod shown;

pub use choose::{choice, choose_method, learn_and_choose, settled_methods};
use generate::velocity_bounds;
pub use generate::{Generated, Generator, SegmentCorridors, generate, plan_settings};
pub(crate) use generate::{hold_settings, plan_error, planner};
pub use held_out::{HeldOutResult, ProtocolRows, filter_moves, held_out};
pub use illustrate::{Illustrated, illustrate};
pub(crate) use intervals::SEED;
pub use intervals::intervals;
pub(crate) use learn::nmf_settings_of;
pub use learn::{
    complete, deviations, drawn_demonstrations, held_out_demonstrations, learn, nmf_settings,
};
use motion::evaluation_settings;
pub use motion::{MotionAnalysis, contact_rows, contact_rules, contacts, motion_analysis};
pub use rank::judge_ranks;
pub(crate) use select::select;
pub use select::{Tally, Used, used};
pub use shown::{Shown, demonstrated};

/// Brings takes into the hand's frame and filters them, in order.
///
/// # Errors
///
/// [`SessionError::At`] for the first take that cannot be processed.
pub fn process_takes(takes: &[Take], settings: &Settings) -> Result<Vec<Motion>, SessionError> {
    smooth_motions(motions_in_hand(takes, &|_| true, settings)?, settings)
}

/// Brings takes into the hand's frame, gaps filled, in order. The shapes of bodies that are fitted to markers are those
/// of the takes whose place is chosen.
///
/// # Errors
///
/// [`SessionError::At`] for the first take that cannot be processed.
pub fn motions_in_hand(
    takes: &[Take],
    chosen: &dyn Fn(usize) -> bool,
    settings: &Settings,
) -> Result<Vec<Motion>, SessionError> {
    let (roles, templates) = templates(takes, chosen)?;
    let process_settings = settings.process_settings()?;
    let mut motions = inhand_parallel::try_up_to(takes.len(), |n| {
        let take = &takes[n];
        to_hand_frame(&take.recording, roles[n], &templates, &process_settings)
            .during(format_args!("processing {}", take.name))
    })?;
    select(&mut motions, takes, settings)?;
    Ok(motions)
}

/// Filters motions, in order.
///
/// # Errors
///
/// [`SessionError::At`] for a filter that cannot be used.
pub fn smooth_motions(
    mut motions: Vec<Motion>,
    settings: &Settings,
) -> Result<Vec<Motion>, SessionError> {
    let filter = settings.process_settings()?.filter;
    for motion in &mut motions {
        smooth(motion, filter).during(format_args!("processing {}", motion.name))?;
    }
    Ok(motions)
}

/// Motions of takes under each protocol: those that an earlier step stored, moved out of them ([`stored_motions`]), else
/// takes processed now.
///
/// # Errors
///
/// As [`process_takes`].
pub fn motions(
    takes: &mut [Take],
    settings: &Settings,
) -> Result<PerProtocol<Vec<Motion>>, SessionError> {
    if let Some(motions) = stored_motions(takes, settings)? {
        return Ok(motions);
    }
    let held_out = motions_in_hand(takes, &|_| true, settings)?;
    Ok(PerProtocol {
        published: smooth_motions(held_out.clone(), settings)?,
        held_out,
    })
}

/// Motions that an earlier step stored in takes, moved out of them, and those before the filter in the frame of the stored
/// hand; `None` where a take has none, or one that was made by other settings than these.
///
/// # Errors
///
/// [`SessionError::Settings`] for labels that cannot be parsed; as [`process_takes`].
pub fn stored_motions(
    takes: &mut [Take],
    settings: &Settings,
) -> Result<Option<PerProtocol<Vec<Motion>>>, SessionError> {
    let stored = |take: &Take| {
        let made = Settings::of_steps(&take.provenance);
        let same =
            made.process == settings.process && made.object.offset_m == settings.object.offset_m;
        same && take.stored_motion.is_some()
    };
    if !takes.iter().all(stored) {
        return Ok(None);
    }
    let stored = takes.iter_mut().map(|take| take.stored_motion.take());
    let (mut published, takes): (Vec<_>, _) = (stored.flatten().collect(), &*takes);
    let (roles, templates) = templates(takes, &|_| true)?;
    let process_settings = settings.process_settings()?;
    let mut held_out = inhand_parallel::try_up_to(takes.len(), |n| {
        let (take, hand) = (&takes[n], published[n].hand.clone());
        with_hand(
            &take.recording,
            roles[n],
            hand,
            &templates,
            &process_settings,
        )
        .during(format_args!("processing {}", take.name))
    })?;
    for motions in [&mut published, &mut held_out] {
        select(motions, takes, settings)?;
    }
    Ok(Some(PerProtocol {
        published,
        held_out,
    }))
}

/// Roles of takes, and the shapes of bodies that are fitted to markers.
fn templates<'t>(
    takes: &'t [Take],
    chosen: &dyn Fn(usize) -> bool,
) -> Result<(Vec<&'t Roles>, Templates), SessionError> {
    let roles = takes
        .iter()
        .map(Take::roles)
        .collect::<Result<Vec<_>, _>>()?;
    let recordings = takes.iter().map(|take| &take.recording);
    let templates = fit_templates_to(recordings.zip(roles.iter().copied()), chosen)
        .during("processing the session")?;
    Ok((roles, templates))
}

/// Share of samples at which the object has to be known for segments to carry it: with less, more
/// is lost by leaving segments out than the object tells.
const OBJECT_KNOWN: f64 = 0.9;

/// Whether segments of these motions carry the object: as the settings say, else where every one of
/// them tracks it.
///
/// # Errors
///
/// [`SessionError::Settings`] where the object is asked for and a motion has none.
pub fn carries_object(motions: &[&Motion], settings: &Settings) -> Result<bool, SessionError> {
    object_in_segments(
        motions.iter().map(|motion| {
            let track = motion.object.as_ref();
            let known = track.map(|track| track.iter().flatten().count());
            (motion.name.as_str(), known, motion.len())
        }),
        settings,
    )
}

/// The same from each take's name, the samples at which its object is known (`None` where it is not
/// tracked) and all of its samples.
///
/// # Errors
///
/// As [`carries_object`].
pub fn object_in_segments<'a>(
    takes: impl Iterator<Item = (&'a str, Option<usize>, usize)>,
    settings: &Settings,
) -> Result<bool, SessionError> {
    let mut takes = takes.peekable();
    let any = takes.peek().is_some();
    let without = takes
        .find(|(_, known, samples)| (known.unwrap_or(0) as f64) < OBJECT_KNOWN * *samples as f64);
    match (settings.learn.object, without) {
        (ObjectInSegments::No, _) => Ok(false),
        (ObjectInSegments::Yes, Some((name, ..))) => Err(invalid(
            "learn.object",
            "takes that track the object, or `auto`",
            &format!("yes, but {name} does not track it"),
        )),
        (_, without) => Ok(without.is_none() && any),
    }
}

/// Whether segments to plan with a dictionary carry the object: where its segments do and all of
/// these motions track it. Otherwise the object is just not given to the planner.
///
/// # Errors
///
/// As [`carries_object`].
pub fn segments_object(
    dictionary: &Dictionary,
    motions: &[&Motion],
    settings: &Settings,
) -> Result<bool, SessionError> {
    Ok(dictionary.layout.object && carries_object(motions, settings)?)
}

/// Segments of motions, by the rules of their role and of a protocol, with the object or without.
///
/// # Errors
///
/// [`SessionError::At`] where the motions do not go together.
pub fn segments(
    motions: &[&Motion],
    of: (Role, Protocol),
    object: bool,
    settings: &Settings,
) -> Result<Segments, SessionError> {
    let found = found_segments(motions, of, object, settings)?;
    Ok(found.segments(0..found.origins().len()))
}

/// Where these segments are; they are cut some at a time.
///
/// # Errors
///
/// As [`segments`].
pub fn found_segments(
    motions: &[&Motion],
    of: (Role, Protocol),
    object: bool,
    settings: &Settings,
) -> Result<FoundSegments, SessionError> {
    let rate_hz = motions.first().map_or(1.0, |motion| motion.clock.rate_hz());
    let mut segment_settings = cut_settings(SegmentLayout::one_second(rate_hz), of, settings);
    segment_settings.layout.object = object;
    FoundSegments::new(motions, &segment_settings)
        .during(format_args!("processing {} takes", of.0.name()))
}

/// How takes of a role are cut into segments of a layout under a protocol.
pub fn cut_settings(
    layout: SegmentLayout,
    (role, protocol): (Role, Protocol),
    settings: &Settings,
) -> SegmentSettings {
    let section = &settings.segments;
    let stride = match (role, section.stride) {
        (Role::Test, _) | (Role::Train, 0) => layout.samples,
        (Role::Train, stride) => stride,
    };
    SegmentSettings {
        layout,
        stride,
        ends: match protocol {
            Protocol::Published => EndsRule::Differences {
                margin_s: section.margin_s,
            },
            Protocol::HeldOut => EndsRule::Lines {
                ends_s: section.ends_s,
            },
        },
        missing_s: match role {
            Role::Train => section.missing_s,
            Role::Test => 0.0,
        },
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
/// [`SessionError::Settings`].
pub fn measure_recorded<'a>(
    segments: &'a Segments,
    motions: &'a [&'a Motion],
    dictionary: &'a Dictionary,
    settings: &Settings,
) -> Result<Comparison<'a>, SessionError> {
    let data = TestData {
        segments,
        motions,
        demonstrated: &dictionary.demonstrated,
        velocity_bounds: velocity_bounds(dictionary, settings),
        shape: settings.shape()?,
    };
    let settings = evaluation_settings(settings)?;
    let recorded = recorded(&data, &settings);
    Ok(Comparison {
        data,
        settings,
        recorded,
    })
}

/// Compares a method's motion with the recorded one.
pub fn evaluate(
    comparison: &Comparison<'_>,
    generated: &Generated,
) -> (MethodEvaluation, MethodRows) {
    let objects = planned_objects(generated);
    let method = MethodResult {
        name: generated.method.name(),
        description: generated.method.description(),
        baseline: !generated.method.is_learned(),
        trajectories: &generated.trajectories,
        objects: objects.as_deref(),
        corridors: (generated.corridors.as_ref()).map(|corridors| Corridors {
            mahalanobis: &corridors.mahalanobis,
            widths: &corridors.widths,
        }),
        plans: generated.plans.as_deref(),
    };
    evaluate_method(
        &comparison.data,
        &comparison.recorded,
        &method,
        &comparison.settings,
    )
}

/// The rows of all methods, in the order of [`evaluate`], beside what the recording itself does.
pub fn evaluation_rows(comparison: &Comparison<'_>, methods: Vec<MethodRows>) -> EvaluationRows {
    EvaluationRows {
        methods,
        ..comparison.recorded.rows.clone()
    }
}

impl Comparison<'_> {
    /// As [`evaluation_rows`], of a comparison that is over.
    pub fn into_rows(self, methods: Vec<MethodRows>) -> EvaluationRows {
        EvaluationRows {
            methods,
            ..self.recorded.rows
        }
    }
}

/// Where a method plans the object to be; `None` for one that plans fingertips alone.
fn planned_objects(generated: &Generated) -> Option<Vec<Option<ObjectPoses>>> {
    let plans = generated.plans.as_ref()?;
    let known = |plan: &Plan| (!plan.object.is_empty()).then(|| plan.object.clone());
    let objects: Vec<_> = plans.iter().map(known).collect();
    objects.iter().any(Option::is_some).then_some(objects)
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
pub(crate) fn session_facts(
    name: &str,
    takes: &[TakeResult<'_>],
    train: Option<&Segments>,
    test: &Segments,
    settings: &Settings,
) -> SessionFacts {
    let facts = |role: Role, segments: &Segments| -> Vec<TakeFacts> {
        let of_role: Vec<_> = takes.iter().filter(|take| take.role == role).collect();
        let cut = cut_settings(segments.layout(), (role, Protocol::Published), settings);
        let cut = Cut::new(&cut).ok();
        (of_role.iter().enumerate())
            .map(|(index, result)| {
                let found = segments
                    .origins()
                    .iter()
                    .filter(|o| o.take == index)
                    .count();
                let (take, motion) = (result.take, result.motion);
                let selected = motion.selected.as_deref();
                let whole = (cut.as_ref()).map_or(0, |c| c.without_gaps(motion.len(), selected));
                let left_out = whole.saturating_sub(found);
                let left_out_by = (cut.as_ref())
                    .filter(|_| left_out > 0)
                    .map(|cut| cut.left_out_by(&SegmentTable::from_motion(motion)));
                let coverage = Coverage::of(&take.recording);
                TakeFacts {
                    name: take.name.clone(),
                    segments: found,
                    left_out,
                    left_out_by: left_out_by.unwrap_or_default(),
                    ..coverage.take_facts(&take.recording, take.roles.as_ref().ok())
                }
            })
            .collect()
    };
    SessionFacts {
        name: name.to_owned(),
        rate_hz: test.layout().rate_hz,
        segment_samples: test.layout().samples,
        object: settings.object.shape.clone(),
        participant: settings.participant.clone(),
        task: settings.task.clone(),
        train: train.map_or_else(Vec::new, |train| facts(Role::Train, train)),
        test: facts(Role::Test, test),
    }
}

/// What each take's data is worth.
fn quality(takes: &[TakeResult<'_>]) -> Result<Vec<TakeQuality>, SessionError> {
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
    inhand_parallel::try_map(takes, one)
}

/// Puts an evaluation together; movement, contacts over time and intervals are not in it yet. `train`
/// are the training segments, where they are at hand.
///
/// # Errors
///
/// [`SessionError::Data`] where a take has no roles.
pub fn assemble(
    name: &str,
    takes: &[TakeResult<'_>],
    (train, test): (Option<&Segments>, &Segments),
    dictionary: &Dictionary,
    methods: Vec<MethodEvaluation>,
    settings: &Settings,
) -> Result<Evaluation, SessionError> {
    let default_method = methods.first().map(|method| method.name.clone());
    Ok(Evaluation {
        session: session_facts(name, takes, train, test, settings),
        default_method: default_method.unwrap_or_default(),
        choice: dictionary.choice.clone(),
        dictionary: DictionaryFacts::new(dictionary, velocity_bounds(dictionary, settings)),
        methods,
        held_out: None,
        filter_moves: None,
        quality: quality(takes)?,
        intervals: None,
        movement: None,
        contacts: None,
        inspection: None,
        key: None,
    })
}
