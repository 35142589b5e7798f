//! Two evaluations side by side.

use inhand_evaluation::{
    MethodOf, compare_contacts, compare_errors, same_segments, stated_contacts, stated_errors,
};
use inhand_model::{
    Bootstrap, Cluster, ComparedSide, Drawn, EvaluationComparison, EvaluationRows,
    HeldOutComparison, MethodEvaluation, Protocol,
};

use super::part::Part;
use super::settings::{differences, reference};
use crate::error::SessionError;
use crate::steps::SEED;

/// What is compared with what.
#[derive(Clone, Debug)]
pub struct CompareOptions {
    /// Method after; `None` for every method that both have.
    pub method: Option<String>,
    /// Method before, where it is another one.
    pub against: Option<String>,
    /// Draws of the bootstrap over segments; 0 for no intervals.
    pub draws: usize,
    /// Share of the draws inside an interval.
    pub confidence: f64,
}

/// Compares two evaluations, or two methods of one (`before` and `after` the same).
///
/// # Errors
///
/// [`SessionError::Data`] for methods that are not there, or nothing to compare; [`SessionError::At`] for
/// damaged rows.
pub fn compare(
    before: &Part,
    after: &Part,
    options: &CompareOptions,
) -> Result<EvaluationComparison, SessionError> {
    let bootstrap = Bootstrap {
        cluster: Cluster::Segment,
        draws: options.draws,
        seed: SEED,
        confidence: options.confidence,
    };
    let published = changes(before, after, Protocol::Published, (options, bootstrap))?;
    let both = [before, after].map(|part| part.evaluation.held_out.is_some());
    let held_out = (both == [true; 2])
        .then(|| changes(before, after, Protocol::HeldOut, (options, bootstrap)))
        .transpose()?;
    Ok(EvaluationComparison {
        before: side(before),
        after: side(after),
        drawn: published.drawn,
        bootstrap,
        reference: reference(&[before, after]),
        errors: published.errors,
        contacts: published.contacts,
        held_out,
        settings: differences(&[before, after]),
    })
}

/// Changes under one protocol.
fn changes(
    before: &Part,
    after: &Part,
    protocol: Protocol,
    (options, bootstrap): (&CompareOptions, Bootstrap),
) -> Result<HeldOutComparison, SessionError> {
    let both = match bootstrap.draws {
        0 => None,
        _ => (before.read_rows(protocol)?).zip(after.read_rows(protocol)?),
    };
    let paired = (both.as_ref())
        .is_some_and(|(old, new)| same_segments(old, new) && same_takes(before, after));
    let (mut errors, mut contacts) = (Vec::new(), Vec::new());
    for (old, new) in pairs(before, after, protocol, options)? {
        if let Some((before_rows, after_rows)) = &both {
            let old = method_of(before_rows, old);
            let new = method_of(after_rows, new);
            if let (Some(old), Some(new)) = (old, new) {
                errors.extend(compare_errors(old, new, paired, bootstrap)?);
                contacts.extend(compare_contacts(old, new, paired, bootstrap)?);
            }
        } else {
            errors.extend(stated_errors(old, new));
            contacts.extend(stated_contacts(old, new));
        }
    }
    Ok(HeldOutComparison {
        drawn: match &both {
            Some(_) if paired => Drawn::Together,
            Some(_) => Drawn::Apart,
            None => Drawn::NotAtAll,
        },
        errors,
        contacts,
    })
}

/// Whether both were judged on the same recordings: test files of the same name have the same content, and there
/// are some. Takes of different sessions often have the same names.
fn same_takes(before: &Part, after: &Part) -> bool {
    let (before, after) = (before.test_sources(), after.test_sources());
    !before.is_empty() && before == after
}

fn side(part: &Part) -> ComparedSide {
    ComparedSide {
        file: part.file(),
        session: part.evaluation.session.name.clone(),
        held_out: part.evaluation.held_out.is_some(),
    }
}

type Pair<'a> = (&'a MethodEvaluation, &'a MethodEvaluation);

fn pairs<'a>(
    before: &'a Part,
    after: &'a Part,
    protocol: Protocol,
    options: &CompareOptions,
) -> Result<Vec<Pair<'a>>, SessionError> {
    let find = |part: &'a Part, name: &str| {
        part.method(protocol, name).ok_or_else(|| {
            let names = part.method_names().join(", ");
            let message = format!("no method \"{name}\"; evaluated were {names}");
            SessionError::data(&part.path, message)
        })
    };
    let pairs: Vec<Pair<'a>> = match (&options.method, &options.against) {
        (Some(new), old) => {
            let old = old.as_ref().unwrap_or(new);
            vec![(find(before, old)?, find(after, new)?)]
        }
        (None, Some(old)) => {
            let new = &after.evaluation.default_method;
            vec![(find(before, old)?, find(after, new)?)]
        }
        (None, None) => (after.evaluation.methods(protocol).iter())
            .filter_map(|new| Some((find(before, &new.name).ok()?, new)))
            .collect(),
    };
    let same = |(old, new): &Pair<'_>| before.path == after.path && old.name == new.name;
    if pairs.is_empty() || pairs.iter().all(same) {
        let message = "nothing to compare: name another evaluation, or two methods of this one with \
                       --method and --against";
        return Err(SessionError::data(&after.path, message));
    }
    Ok(pairs)
}

fn method_of<'a>(rows: &'a EvaluationRows, method: &MethodEvaluation) -> Option<MethodOf<'a>> {
    let place = rows
        .methods
        .iter()
        .position(|known| known.name == method.name)?;
    Some(MethodOf {
        rows,
        method: place,
        tau_m: method
            .contact
            .as_ref()
            .map_or(f64::NAN, |contact| contact.tau_m),
    })
}
