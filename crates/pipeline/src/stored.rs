//! Judging motion that an earlier step stored in takes.

use inhand_model::{Evaluation, Segments};

use crate::dictionary_file::DictionaryFile;
use crate::error::PipelineError;
use crate::methods::Method;
use crate::settings::{Role, Settings};
use crate::steps::{self, Generated, TakeResult};
use crate::take::Take;

/// Compares the trajectories stored in takes with the motion recorded there.
///
/// # Errors
///
/// [`PipelineError::Take`] for a take without generated channels, or whose trajectories do not
/// start where its segments do.
pub fn evaluate_stored(
    takes: &[Take],
    dictionary: &DictionaryFile,
    settings: &Settings,
) -> Result<Evaluation, PipelineError> {
    let motions = steps::motions(takes, settings)?;
    let motion_refs: Vec<_> = motions.iter().collect();
    let test = steps::segments(&motion_refs, Role::Test, settings)?;
    let generated = stored_methods(takes, &test)?;
    let dictionary = &dictionary.dictionary;
    let comparison = steps::measure_recorded(&test, &motion_refs, dictionary, settings)?;
    let methods = generated.iter().map(|g| steps::evaluate(&comparison, g).0).collect();
    let results: Vec<_> = (takes.iter().zip(&motions))
        .map(|(take, motion)| TakeResult { take, motion, role: Role::Test })
        .collect();
    let name = settings.name.clone().unwrap_or_else(|| {
        takes.iter().map(|take| take.name.as_str()).collect::<Vec<_>>().join(", ")
    });
    Ok(steps::assemble(
        steps::session_facts(&name, &results, None, &test, settings),
        steps::dictionary_facts(dictionary, settings),
        methods,
        steps::quality(&results)?,
    ))
}

fn stored_methods(takes: &[Take], test: &Segments) -> Result<Vec<Generated>, PipelineError> {
    let Some(first) = takes.first() else { return Ok(Vec::new()) };
    if let Some(take) = takes.iter().find(|take| take.stored_methods.is_empty()) {
        let message = "no /generated channels: `inhand generate` or `inhand run` writes them";
        return Err(take.error(message.to_owned()));
    }
    first.stored_methods.iter().map(|method| stored_method(&method.name, takes, test)).collect()
}

fn stored_method(name: &str, takes: &[Take], test: &Segments) -> Result<Generated, PipelineError> {
    let method: Method = name.parse()?;
    let mut trajectories = vec![None; test.len()];
    let mut plans = vec![None; test.len()];
    for (index, take) in takes.iter().enumerate() {
        let Some(stored) = take.stored_methods.iter().find(|stored| stored.name == name) else {
            let message = format!("no /generated/{name} channels, which other takes have");
            return Err(take.error(message));
        };
        for segment in &stored.segments {
            let starts_here = |origin: &inhand_model::SegmentOrigin| {
                origin.take == index && origin.start == segment.start_sample
            };
            let Some(place) = test.origins().iter().position(starts_here) else {
                return Err(take.error(format!(
                    "/generated/{name}: a trajectory starts at sample {}, where no segment does; \
                     were gap, filter or margin settings others when it was generated?",
                    segment.start_sample
                )));
            };
            trajectories[place] = Some(segment.trajectory.clone());
            plans[place].clone_from(&segment.plan);
        }
    }
    let plans = plans.into_iter().collect();
    Ok(Generated { method, trajectories, plans, plan_times: Vec::new() })
}
