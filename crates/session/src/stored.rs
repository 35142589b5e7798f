//! Judging motion that an earlier step stored in takes.

use std::path::Path;

use inhand_channels::{
    ChannelError, EvaluatedMethod, ReadMethod, evaluated_of_source, generated_of_source,
};
use inhand_model::{
    Dictionary, Evaluation, EvaluationRows, HeldOutEvaluation, Motion, Plan, Protocol, Provenance,
    SegmentLayout, SegmentOrigin, Segments, Trajectory,
};

use crate::dictionary_file::DictionaryFile;
use crate::error::{Located, SessionError};
use crate::files::{FileSource, open_take};
use crate::methods::Method;
use crate::settings::{Role, Settings};
use crate::steps::{self, Generated, Generator, HeldOutResult, ProtocolRows, TakeResult};
use crate::take::Take;

/// An evaluation of stored trajectories, and what it is made of under each protocol.
#[derive(Debug)]
pub struct StoredEvaluation {
    /// The numbers.
    pub evaluation: Evaluation,
    /// What those of the published protocol are made of.
    pub published: StoredRows,
    /// The same of the held-out protocol; `None` for takes without trajectories of it.
    pub held_out: Option<StoredRows>,
    /// The settings that they are made by: those given, with the segments of the step that generated the trajectories.
    pub settings: Settings,
}

/// Rows of a protocol with the motion that they compare.
#[derive(Debug)]
pub struct StoredRows {
    rows: EvaluationRows,
    segments: Segments,
    generated: Vec<Generated>,
}

impl StoredRows {
    /// These as they are written.
    pub fn as_rows(&self) -> ProtocolRows<'_> {
        ProtocolRows {
            rows: &self.rows,
            segments: &self.segments,
            generated: &self.generated,
        }
    }
}

/// Compares the trajectories stored in takes with the motion recorded there.
///
/// # Errors
///
/// [`SessionError::Data`] for a take without generated channels, or whose trajectories do not
/// start where its segments do.
pub fn evaluate_stored(
    takes: &mut [Take],
    dictionary: &DictionaryFile,
    settings: &Settings,
) -> Result<StoredEvaluation, SessionError> {
    for take in &*takes {
        check_dictionary(take, dictionary)?;
    }
    let dictionary = &dictionary.dictionary;
    let effective = as_generated(takes, settings)?;
    let settings = &effective;
    steps::used(&*takes, settings)?;
    let (mut motions, takes) = (steps::motions(takes, settings)?, &*takes);
    let of = Protocol::Published;
    let test = stored_segments(takes, &mut motions.published, of, dictionary, settings)?;
    let motion_refs: Vec<_> = motions.published.iter().collect();
    let generated = stored_methods(takes, &test, dictionary, settings)?.ok_or_else(|| {
        let first = takes
            .first()
            .map_or(Path::new("the takes"), |take| &take.path);
        SessionError::data(
            first,
            "no /generated channels: `inhand generate` writes them",
        )
    })?;
    let comparison = steps::measure_recorded(&test, &motion_refs, dictionary, settings)?;
    let (methods, rows): (_, Vec<_>) = generated
        .iter()
        .map(|g| steps::evaluate(&comparison, g))
        .unzip();
    let motion = steps::motion_analysis(&comparison, &generated, &rows, None, settings)?;
    let rows = steps::evaluation_rows(&comparison, rows);
    let results: Vec<_> = (takes.iter().zip(&motions.published))
        .map(|(take, motion)| TakeResult {
            take,
            motion,
            role: Role::Test,
        })
        .collect();
    let names: Vec<&str> = takes.iter().map(|take| take.name.as_str()).collect();
    let name = settings.name.clone().unwrap_or_else(|| names.join(", "));
    let segments = (None, &test);
    let mut evaluation = steps::assemble(&name, &results, segments, dictionary, methods, settings)?;
    evaluation.movement = Some(motion.movement);
    evaluation.contacts = motion.contacts;
    evaluation.intervals = steps::intervals(&evaluation.methods, &rows, settings)?;
    let unfiltered: Vec<_> = motions.held_out.iter().collect();
    evaluation.filter_moves = steps::filter_moves(&test, &unfiltered, settings);
    drop(unfiltered);
    let held_out = held_out(takes, &mut motions.held_out, dictionary, settings)?;
    let (held_out, held_out_rows) = held_out.unzip();
    evaluation.held_out = held_out;
    let published = StoredRows {
        rows,
        segments: test,
        generated,
    };
    Ok(StoredEvaluation {
        evaluation,
        published,
        held_out: held_out_rows,
        settings: effective,
    })
}

/// The same under the held-out protocol; `None` for takes without trajectories of it.
fn held_out(
    takes: &[Take],
    motions: &mut [Motion],
    dictionary: &Dictionary,
    settings: &Settings,
) -> Result<Option<(HeldOutEvaluation, StoredRows)>, SessionError> {
    let test = stored_segments(takes, motions, Protocol::HeldOut, dictionary, settings)?;
    let Some(generated) = stored_methods(takes, &test, dictionary, settings)? else {
        return Ok(None);
    };
    let motions: Vec<_> = motions.iter().collect();
    let HeldOutResult { evaluation, rows } =
        steps::held_out(&test, &motions, dictionary, &generated, settings)?;
    let rows = StoredRows {
        rows,
        segments: test,
        generated,
    };
    Ok(Some((evaluation, rows)))
}

/// The segments that trajectories were generated for, as far as they lie in what is selected now.
fn stored_segments(
    takes: &[Take],
    motions: &mut [Motion],
    protocol: Protocol,
    dictionary: &Dictionary,
    settings: &Settings,
) -> Result<Segments, SessionError> {
    // Segments begin where events that were selected begin, so those of the earlier step count.
    let mut judged = Vec::with_capacity(motions.len());
    for (take, motion) in takes.iter().zip(motions.iter_mut()) {
        let earlier = Settings {
            select: generated_by(take).unwrap_or_default().select,
            ..Settings::default()
        };
        judged.push(motion.selected.take());
        steps::select(
            std::slice::from_mut(motion),
            std::slice::from_ref(take),
            &earlier,
        )?;
    }
    let motion_refs: Vec<_> = motions.iter().collect();
    let object = steps::segments_object(dictionary, &motion_refs, settings)?;
    let generated = steps::segments(&motion_refs, (Role::Test, protocol), object, settings)?;
    let samples = generated.layout().samples;
    let inside = |origin: &SegmentOrigin| {
        let end = origin.start + samples;
        let ranges = judged[origin.take].as_ref();
        ranges.is_none_or(|r| r.iter().any(|r| r.start <= origin.start && end <= r.end))
    };
    let kept: Vec<usize> = (generated.origins().iter().enumerate())
        .filter(|(_, origin)| inside(origin))
        .map(|(segment, _)| segment)
        .collect();
    for (motion, judged) in motions.iter_mut().zip(judged) {
        motion.selected = judged;
    }
    Ok(generated.select(&kept))
}

/// The settings with the margin of the step that generated the trajectories: segments start where those start.
fn as_generated(takes: &[Take], settings: &Settings) -> Result<Settings, SessionError> {
    let made = |take| {
        let segments = generated_by(take)?.segments;
        Some((take, [segments.margin_s, segments.ends_s]))
    };
    let made: Vec<(&Take, [f64; 2])> = takes.iter().filter_map(made).collect();
    let mut settings = settings.clone();
    if let [(_, ends_s), others @ ..] = &made[..] {
        if let Some((take, others_s)) = others.iter().find(|(_, others_s)| others_s != ends_s) {
            return Err(take.error(format!(
                "its trajectories have segments.margin_s and segments.ends_s = {others_s:?}, and those of other takes \
                 {ends_s:?}: evaluate one at a time"
            )));
        }
        [settings.segments.margin_s, settings.segments.ends_s] = *ends_s;
    }
    Ok(settings)
}

/// The settings of the step that generated a take's trajectories; `None` where none did.
pub fn generated_by(take: &Take) -> Option<Settings> {
    let of_step = |step: &Provenance| ["generate", "run"].contains(&&*step.step);
    let last = take.provenance.iter().rposition(of_step)?;
    Some(Settings::of_steps(&take.provenance[..=last]))
}

/// A take whose motion was generated with another dictionary cannot be judged by this one.
fn check_dictionary(take: &Take, dictionary: &DictionaryFile) -> Result<(), SessionError> {
    let generated = take
        .provenance
        .iter()
        .rev()
        .find(|step| step.step == "generate");
    match generated {
        Some(step) if !step.inputs.contains(&dictionary.hash) => Err(take.error(format!(
            "its motion was generated with another dictionary than {}",
            dictionary.hash.name
        ))),
        _ => Ok(()),
    }
}

/// What is stored for segments of a protocol, of the methods that the first take has; `None` where a take has none.
fn stored_methods(
    takes: &[Take],
    test: &Segments,
    dictionary: &Dictionary,
    settings: &Settings,
) -> Result<Option<Vec<Generated>>, SessionError> {
    let read = |take| read_methods(take, test.protocol());
    let stored = takes.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let Some(first) = stored
        .first()
        .filter(|_| stored.iter().all(|s| !s.is_empty()))
    else {
        return Ok(None);
    };
    let generated = first.iter().map(|method| {
        let mut generated = join_takes(&method.name, takes, &stored, test)?;
        if let Some(plans) = &generated.plans {
            let method = generated.method;
            let generator = Generator::new(method, dictionary, test.protocol(), settings)?;
            generated.corridors = generator.corridors(test, plans)?;
        }
        Ok(generated)
    });
    generated.collect::<Result<_, _>>().map(Some)
}

/// Motion that a take stores for segments of a protocol, by method; none where it stores none.
pub(crate) fn read_methods(
    take: &Take,
    protocol: Protocol,
) -> Result<Vec<ReadMethod>, SessionError> {
    read_stored(take, |source| generated_of_source(source, protocol))
}

/// Errors and contacts that a take stores, by method; none where it stores none.
pub(crate) fn read_evaluated_methods(take: &Take) -> Result<Vec<EvaluatedMethod>, SessionError> {
    read_stored(take, evaluated_of_source)
}

fn read_stored<T>(
    take: &Take,
    read: impl FnOnce(&mut FileSource) -> Result<Vec<T>, ChannelError>,
) -> Result<Vec<T>, SessionError> {
    let Some(mut source) = open_take(&take.path, &take.hash.name)? else {
        return Ok(Vec::new());
    };
    let metadata = inhand_channels::metadata_of_source(&mut source).in_file(&take.path)?;
    // Third-party files have other messages on topics of these names.
    match metadata.is_take() {
        true => read(&mut source).in_file(&take.path),
        false => Ok(Vec::new()),
    }
}

/// One method over the segments of all takes.
fn join_takes(
    name: &str,
    takes: &[Take],
    stored: &[Vec<ReadMethod>],
    test: &Segments,
) -> Result<Generated, SessionError> {
    let method: Method = name.parse()?;
    let mut trajectories = Vec::with_capacity(test.len());
    let mut plans = Vec::with_capacity(test.len());
    for origin in test.origins() {
        let take = &takes[origin.take];
        let Some(stored) = stored[origin.take]
            .iter()
            .find(|stored| stored.name == name)
        else {
            return Err(take.error(format!(
                "no {} trajectories by {name}, which other takes have",
                test.protocol().title()
            )));
        };
        let trajectory = trajectory(stored, origin.start, test.layout());
        let plan = stored.plans.get(&origin.start).cloned();
        plans.push(plan.map(|plan| Plan {
            trajectory: trajectory.clone(),
            ..plan
        }));
        trajectories.push(trajectory);
    }
    if !test.is_empty() && trajectories.iter().all(Option::is_none) {
        let message = format!(
            "{name}: no {} trajectory covers a segment of the takes; were gap, filter or margin settings \
             (--ends-s) others when it was generated?",
            test.protocol().title()
        );
        return Err(takes[0].error(message));
    }
    let plans = plans.into_iter().collect();
    Ok(Generated {
        method,
        trajectories,
        plans,
        plan_times: Vec::new(),
        corridors: None,
    })
}

/// The generated motion over one segment, if it covers it.
fn trajectory(stored: &ReadMethod, start: usize, layout: SegmentLayout) -> Option<Trajectory> {
    let samples = start..start + layout.samples;
    let configurations: Vec<_> = stored
        .configurations_m
        .range(samples)
        .map(|(_, c)| *c)
        .collect();
    if configurations.len() < layout.samples {
        return None;
    }
    Trajectory::new(layout, configurations.concat()).ok()
}
