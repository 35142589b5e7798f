//! Judging motion that an earlier step stored in takes.

use std::path::Path;

use inhand_channels::{
    ChannelError, EvaluatedMethod, ReadMethod, ReadSegments, evaluated_of_source,
    generated_of_source, segments_of_source,
};
use inhand_model::{
    Dictionary, Evaluation, EvaluationRows, HeldOutEvaluation, MethodEvaluation, Motion, Plan,
    Protocol, Provenance, SegmentOrigin, Segments,
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
    /// What those of the published protocol are made of; `None` unless asked for.
    pub published: Option<StoredRows>,
    /// The same of the held-out protocol; `None` also for takes without trajectories of it.
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

/// Compares the trajectories stored in takes with the motion recorded there. The rows of all instants are kept for
/// `tables`; without, memory is that of one protocol. Takes keep their facts and lose their samples.
///
/// # Errors
///
/// [`SessionError::Data`] for a take without generated channels, or whose trajectories do not
/// start where its segments do.
pub fn evaluate_stored(
    takes: &mut [Take],
    dictionary: &DictionaryFile,
    settings: &Settings,
    tables: bool,
) -> Result<StoredEvaluation, SessionError> {
    for take in &*takes {
        check_dictionary(take, dictionary)?;
    }
    let dictionary = &dictionary.dictionary;
    let effective = as_generated(takes, settings)?;
    let settings = &effective;
    steps::used(&*takes, settings)?;
    let mut motions = steps::motions(takes, settings)?;
    let of = Protocol::Published;
    let test = stored_segments(takes, &mut motions.published, of, dictionary, settings)?;
    let mut evaluation = of_takes(takes, &motions.published, &test, dictionary, settings)?;
    // The rest rests on motion: samples as recorded only take memory.
    takes.iter_mut().for_each(without_samples);
    let takes = &*takes;
    let motion_refs: Vec<_> = motions.published.iter().collect();
    let mut generated = stored_methods(takes, &test, dictionary, settings)?.ok_or_else(|| {
        let first = takes
            .first()
            .map_or(Path::new("the takes"), |take| &take.path);
        SessionError::data(
            first,
            "no /generated channels: `inhand generate` writes them",
        )
    })?;
    let comparison = steps::measure_recorded(&test, &motion_refs, dictionary, settings)?;
    let evaluate = |generated: &mut Generated| {
        let (method, rows) = steps::evaluate(&comparison, generated);
        // From here on trajectories are enough.
        (generated.plans, generated.corridors) = (None, None);
        (method, if tables { rows } else { rows.compared() })
    };
    let (methods, rows): (Vec<MethodEvaluation>, Vec<_>) =
        generated.iter_mut().map(evaluate).unzip();
    let motion = steps::motion_analysis(&comparison, &generated, &rows, None, settings)?;
    generated.truncate(if tables { usize::MAX } else { 0 });
    let rows = comparison.into_rows(rows);
    if let Some(first) = methods.first() {
        evaluation.default_method.clone_from(&first.name);
    }
    evaluation.methods = methods;
    evaluation.movement = Some(motion.movement);
    evaluation.contacts = motion.contacts;
    evaluation.intervals = steps::intervals(&evaluation.methods, &rows, settings)?;
    let unfiltered: Vec<_> = motions.held_out.iter().collect();
    evaluation.filter_moves = steps::filter_moves(&test, &unfiltered, settings);
    // Without tables nothing of this protocol is left when the other one comes.
    motions.published = Vec::new();
    let published = tables.then_some(StoredRows {
        rows,
        segments: test,
        generated,
    });
    let held_out = held_out(takes, &mut motions.held_out, dictionary, settings, tables)?;
    let (held_out, held_out_rows) = held_out.unzip();
    evaluation.held_out = held_out;
    Ok(StoredEvaluation {
        evaluation,
        published,
        held_out: held_out_rows.filter(|_| tables),
        settings: effective,
    })
}

/// What an evaluation says of takes, without methods.
fn of_takes(
    takes: &[Take],
    motions: &[Motion],
    test: &Segments,
    dictionary: &Dictionary,
    settings: &Settings,
) -> Result<Evaluation, SessionError> {
    let results: Vec<_> = (takes.iter().zip(motions))
        .map(|(take, motion)| TakeResult {
            take,
            motion,
            role: Role::Test,
        })
        .collect();
    let names: Vec<&str> = takes.iter().map(|take| take.name.as_str()).collect();
    let name = settings.name.clone().unwrap_or_else(|| names.join(", "));
    steps::assemble(
        &name,
        &results,
        (None, test),
        dictionary,
        Vec::new(),
        settings,
    )
}

/// Drops what was recorded of a take.
fn without_samples(take: &mut Take) {
    take.recording = take.recording.slice(0..0);
    if let Some(cleaning) = &mut take.cleaning {
        cleaning.measured = cleaning.measured.slice(0..0);
    }
}

/// The same under the held-out protocol; `None` for takes without trajectories of it.
fn held_out(
    takes: &[Take],
    motions: &mut [Motion],
    dictionary: &Dictionary,
    settings: &Settings,
    tables: bool,
) -> Result<Option<(HeldOutEvaluation, StoredRows)>, SessionError> {
    let test = stored_segments(takes, motions, Protocol::HeldOut, dictionary, settings)?;
    let Some(generated) = stored_methods(takes, &test, dictionary, settings)? else {
        return Ok(None);
    };
    let motions: Vec<_> = motions.iter().collect();
    let HeldOutResult { evaluation, rows } =
        steps::held_out(&test, &motions, dictionary, &generated, tables, settings)?;
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
    let read = |(index, take): (usize, &Take)| {
        let of_take = test.origins().iter().filter(|origin| origin.take == index);
        let starts: Vec<usize> = of_take.map(|origin| origin.start).collect();
        let (protocol, layout) = (test.protocol(), test.layout());
        let read = |source: &mut FileSource| segments_of_source(source, protocol, &starts, layout);
        read_stored(take, read)
    };
    let stored = takes.iter().enumerate().map(read);
    let mut stored = stored.collect::<Result<Vec<_>, _>>()?;
    if stored.is_empty() || stored.iter().any(Vec::is_empty) {
        return Ok(None);
    }
    let names: Vec<String> = stored[0].iter().map(|m| m.name.clone()).collect();
    let generated = names.iter().map(|name| {
        let own = stored.iter_mut().map(|methods| {
            let place = methods.iter().position(|method| method.name == *name)?;
            Some(methods.remove(place))
        });
        let mut generated = join_takes(name, takes, own, test)?;
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
    stored: impl Iterator<Item = Option<ReadSegments>>,
    test: &Segments,
) -> Result<Generated, SessionError> {
    let method: Method = name.parse()?;
    let mut trajectories = Vec::with_capacity(test.len());
    let mut plans = Vec::with_capacity(test.len());
    for (index, (take, stored)) in takes.iter().zip(stored).enumerate() {
        let has_segments = test.origins().iter().any(|origin| origin.take == index);
        let Some(stored) = stored else {
            if !has_segments {
                continue;
            }
            return Err(take.error(format!(
                "no {} trajectories by {name}, which other takes have",
                test.protocol().title()
            )));
        };
        let parts = stored.plans.into_iter().zip(&stored.trajectories);
        plans.extend(parts.map(|(plan, trajectory)| {
            Some(Plan {
                trajectory: trajectory.clone(),
                ..plan?
            })
        }));
        trajectories.extend(stored.trajectories);
    }
    if !test.is_empty() && trajectories.iter().all(Option::is_none) {
        let message = format!(
            "{name}: no {} trajectory covers a segment of the takes; were gap, filter or margin settings \
             (--ends-s) others when it was generated?",
            test.protocol().title()
        );
        return Err(takes[0].error(message));
    }
    Ok(Generated {
        trajectories,
        plans: plans.into_iter().collect(),
        ..Generated::new(method)
    })
}
