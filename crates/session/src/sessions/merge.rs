//! Many evaluations as one summary.

use std::collections::BTreeMap;

use inhand_evaluation::{Contestant, best_baseline, intervals, outliers};
use inhand_model::{
    Bootstrap, Cluster, GroupSummary, HandAndFingers, HeldOutSummary, Intervals, Level,
    MethodEvaluation, MethodSummary, Protocol, SessionMethod, SessionSummary, SettingDifference,
    Severity, SharedContacts, Statistics, Summary,
};
use inhand_statistics::quantiles::sorted_statistics;

use super::groups::{Groups, counts};
use super::part::Part;
use super::settings::differences;
use crate::error::SessionError;
use crate::settings::EvaluateSection;
use crate::steps::SEED;

/// How evaluations are joined.
#[derive(Clone, Copy, Debug)]
pub struct MergeOptions {
    /// Join evaluations that were made with different settings, or of different methods.
    pub allow_different: bool,
    /// Draws of the bootstrap over sessions.
    pub draws: usize,
    /// Share of the draws inside an interval.
    pub confidence: f64,
}

impl Default for MergeOptions {
    fn default() -> Self {
        let EvaluateSection {
            draws, confidence, ..
        } = EvaluateSection::default();
        Self {
            allow_different: false,
            draws,
            confidence,
        }
    }
}

/// Joins parts. Quantiles over sessions are those of all their instants together.
///
/// # Errors
///
/// [`SessionError::Data`] for no session, for one that is given twice, settings or methods that differ unless that is
/// allowed, parts without rows or with those of another run; [`SessionError::At`] for damaged rows.
pub fn merge(parts: &[Part], options: MergeOptions) -> Result<Summary, SessionError> {
    if parts.is_empty() {
        return Err(SessionError::data("sessions", "none of them has results"));
    }
    check_twice(parts)?;
    let all: Vec<&Part> = parts.iter().collect();
    let different = differences(&all);
    if !options.allow_different {
        check_same(parts, &different)?;
    }
    let methods = common_methods(parts)?;
    let default_method = most_frequent_default(parts, &methods);
    let default = methods.iter().position(|name| *name == default_method);
    let default = default.unwrap_or_default();

    let chosen = (&methods[..], default_method.as_str());
    let published = pooled(parts, Protocol::Published, chosen, options)?;
    let is_held_out = |part: &Part| {
        part.has_rows(Protocol::HeldOut)
            && methods
                .iter()
                .all(|name| part.method(Protocol::HeldOut, name).is_some())
    };
    let held_out = (parts.iter().all(is_held_out))
        .then(|| pooled(parts, Protocol::HeldOut, chosen, options))
        .transpose()?;
    let sessions: Vec<SessionSummary> = (parts.iter().zip(names(parts)))
        .map(|(part, name)| session(part, name, &methods, held_out.is_some()))
        .collect();
    let judged = match held_out {
        Some(_) => format!("{default_method}, held out"),
        None => default_method.clone(),
    };
    Ok(Summary {
        outliers: outliers(&sessions, default, &judged),
        methods: published.methods,
        groups: published.groups,
        held_out: held_out.map(|own| HeldOutSummary {
            methods: own.methods,
            intervals: own.intervals,
        }),
        default_method,
        sessions,
        intervals: published.intervals,
        differences: different,
    })
}

/// Methods over all sessions under one protocol.
struct Pooled {
    methods: Vec<MethodSummary>,
    intervals: Intervals,
    groups: Vec<GroupSummary>,
}

fn pooled(
    parts: &[Part],
    protocol: Protocol,
    (methods, default_method): (&[String], &str),
    options: MergeOptions,
) -> Result<Pooled, SessionError> {
    let of_parts: Vec<Vec<&MethodEvaluation>> = (methods.iter())
        .map(|name| {
            let of_parts = parts.iter().filter_map(|part| part.method(protocol, name));
            of_parts.collect()
        })
        .collect();
    let contestants: Vec<Contestant<'_>> = (methods.iter().zip(&of_parts))
        .map(|(name, of_parts)| Contestant {
            name,
            baseline: of_parts.iter().all(|method| method.baseline),
            mean_error_m: Statistics::pooled_mean(of_parts.iter().map(|method| &method.error.all)),
        })
        .collect();
    let default = methods.iter().position(|name| name == default_method);
    let best = best_baseline(&contestants).filter(|&best| Some(best) != default);
    let shown = [default, best];

    let groups = Groups::new(parts);
    let (mut errors, mut of_groups) = (BTreeMap::new(), BTreeMap::new());
    let intervals = intervals(
        &contestants,
        default_method,
        Bootstrap {
            cluster: Cluster::Session,
            draws: options.draws,
            seed: SEED,
            confidence: options.confidence,
        },
        |place, finger| -> Result<_, SessionError> {
            let name = &methods[place];
            inhand_parallel::try_map(parts, |part| part.errors_m(protocol, name, finger))
        },
        |place, finger| {
            let of_parts = of_parts[place].iter();
            of_parts
                .map(|part| part.error.by_finger[finger].n)
                .collect()
        },
        |place| contact_counts(&of_parts[place]),
        |place, finger, rows| {
            let name = &methods[place];
            let (filled, left_out) = counts(parts, protocol, name, finger);
            let own = sorted_statistics(rows.sorted(), filled, left_out);
            errors.insert((place, finger), own);
            if shown.contains(&Some(place)) {
                let own = groups.statistics(parts, protocol, name, (finger, rows));
                of_groups.insert((place, finger), own);
            }
        },
    )?;
    let summary = |(place, of_parts): (usize, &Vec<&MethodEvaluation>)| MethodSummary {
        name: methods[place].clone(),
        description: of_parts[0].description.clone(),
        baseline: of_parts[0].baseline,
        error: HandAndFingers::from_fn(|finger| errors[&(place, finger)]),
        contacts: (of_parts.iter())
            .filter_map(|method| SharedContacts::stated(method))
            .reduce(SharedContacts::plus),
    };
    // The method to look at first comes first.
    let of_shown = shown.into_iter().flatten().flat_map(|place| {
        let error = |finger, group: usize| of_groups[&(place, finger)][group];
        groups.summaries(&methods[place], error)
    });
    Ok(Pooled {
        methods: of_parts.iter().enumerate().map(summary).collect(),
        intervals,
        groups: of_shown.collect(),
    })
}

/// A session must not count twice, whatever the way its file is spelled.
fn check_twice(parts: &[Part]) -> Result<(), SessionError> {
    let mut seen = BTreeMap::new();
    for part in parts {
        let file = part
            .path
            .canonicalize()
            .unwrap_or_else(|_| part.path.clone());
        if let Some(other) = seen.insert(file, part) {
            let message = format!(
                "given twice (also as {}): a session counts once",
                other.path.display()
            );
            return Err(SessionError::data(&part.path, message));
        }
    }
    for (place, part) in parts.iter().enumerate() {
        let own = part.test_sources();
        let same = |other: &&Part| !own.is_empty() && other.test_sources() == own;
        if let Some(other) = parts[..place].iter().find(same) {
            let message = format!(
                "judged on the very files that {} was judged on: a session counts once",
                other.path.display()
            );
            return Err(SessionError::data(&part.path, message));
        }
    }
    Ok(())
}

fn check_same(parts: &[Part], different: &[SettingDifference]) -> Result<(), SessionError> {
    const TO_DO: &str =
        "run them with the same settings, or join them all the same with --allow-different";
    if let Some(first) = different.first() {
        // Name the first file that is unlike the one before all others.
        let place = (first.values.iter()).position(|value| *value != first.values[0]);
        let place = place.unwrap_or_default();
        let more = match different.len() - 1 {
            0 => String::new(),
            more => format!(" ({more} more settings differ among the sessions)"),
        };
        let message = format!(
            "{} is {}, in {} it is {}{more}; {TO_DO}",
            first.key,
            first.values[place],
            parts[0].path.display(),
            first.values[0],
        );
        return Err(SessionError::data(&parts[place].path, message));
    }
    let expected = parts[0].method_names();
    match parts.iter().find(|part| part.method_names() != expected) {
        None => Ok(()),
        Some(part) => {
            let message = format!(
                "the methods are {}, in {} they are {}; {TO_DO}",
                part.method_names().join(", "),
                parts[0].path.display(),
                expected.join(", "),
            );
            Err(SessionError::data(&part.path, message))
        }
    }
}

/// Methods that all parts have, in the order of the first.
fn common_methods(parts: &[Part]) -> Result<Vec<String>, SessionError> {
    let first = parts[0].method_names().into_iter();
    let in_all = first.filter(|name| {
        parts
            .iter()
            .all(|part| part.method(Protocol::Published, name).is_some())
    });
    let common: Vec<String> = in_all.map(str::to_owned).collect();
    if common.is_empty() {
        let message = "no method is in every evaluation";
        return Err(SessionError::data(&parts[0].path, message));
    }
    Ok(common)
}

/// The method that most sessions look at first, the first of equally many.
fn most_frequent_default(parts: &[Part], methods: &[String]) -> String {
    let defaults: Vec<_> = parts
        .iter()
        .map(|part| &part.evaluation.default_method)
        .collect();
    let times = |name: &String| defaults.iter().filter(|own| **own == name).count();
    // The last of equal ones is taken, so they are gone through from the end.
    methods
        .iter()
        .rev()
        .max_by_key(|name| times(name))
        .cloned()
        .unwrap_or_default()
}

/// Of every session; one without an object adds nothing.
fn contact_counts(of_parts: &[&MethodEvaluation]) -> Option<Vec<SharedContacts>> {
    let counts: Vec<_> = (of_parts.iter())
        .map(|method| SharedContacts::stated(method))
        .collect();
    let any = counts.iter().any(Option::is_some);
    any.then(|| counts.into_iter().map(Option::unwrap_or_default).collect())
}

/// Names that tell sessions apart: with the folder of the results where several have the same one.
fn names(parts: &[Part]) -> Vec<String> {
    let name = |part: &Part| part.evaluation.session.name.clone();
    let mut times: BTreeMap<String, usize> = BTreeMap::new();
    for part in parts {
        *times.entry(name(part)).or_default() += 1;
    }
    let unlike = |part: &Part| {
        let own = name(part);
        match part.folder() {
            Some(folder) if times[&own] > 1 => format!("{own} ({folder})"),
            _ => own,
        }
    };
    parts.iter().map(unlike).collect()
}

fn session(part: &Part, name: String, methods: &[String], held_out: bool) -> SessionSummary {
    let (evaluation, facts) = (&part.evaluation, &part.evaluation.session);
    let findings = evaluation.quality.iter().flat_map(|take| &take.findings);
    let add = |of: fn(&inhand_model::TakeFacts) -> usize| {
        facts.test.iter().map(of).fold(0, usize::saturating_add)
    };
    SessionSummary {
        name,
        file: part.file(),
        participant: facts.participant.clone(),
        object: facts.object.clone(),
        task: facts.task.clone(),
        takes: facts.test.len(),
        duration_s: facts.test.iter().map(|take| take.duration_s).sum(),
        segments: add(|take| take.segments),
        left_out: add(|take| take.left_out),
        warnings: match &evaluation.inspection {
            Some(own) => own
                .findings
                .iter()
                .filter(|f| f.level >= Level::Warn)
                .count(),
            None => findings.filter(|f| f.severity == Severity::Warning).count(),
        },
        methods: (methods.iter())
            .filter_map(|name| part.method(Protocol::Published, name))
            .map(|method| SessionMethod {
                name: method.name.clone(),
                error: method.error,
                held_out: (part.method(Protocol::HeldOut, &method.name))
                    .filter(|_| held_out)
                    .map(|method| method.error),
                contacts: SharedContacts::stated(method),
            })
            .collect(),
    }
}
