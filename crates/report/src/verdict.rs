//! Comparison of a method with the baselines, in words. The same words
//! open the HTML and close the terminal table, so that neither can flatter.

use inhand_model::{Evaluation, Finger, MethodEvaluation, Statistics};

use crate::number::{NARROW_SPACE, count, millimetres, percent};
use crate::words::join_words;

/// Differences up to this share of the better value count as level: they vanish in the rounding
/// of the printed numbers, and a session's segments are far too few to establish them. So does a
/// difference whose interval holds zero.
const LEVEL_SHARE: f64 = 0.02;

/// A place in the distribution of errors at which methods are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Measure {
    Median,
    ThirdQuartile,
    P95,
    Max,
}

impl Measure {
    pub(crate) const ALL: [Measure; 4] = [
        Measure::Median,
        Measure::ThirdQuartile,
        Measure::P95,
        Measure::Max,
    ];

    /// Name in a sentence.
    pub(crate) const fn words(self) -> &'static str {
        match self {
            Measure::Median => "median",
            Measure::ThirdQuartile => "third quartile",
            Measure::P95 => "95 % quantile",
            Measure::Max => "maximum",
        }
    }

    /// The statistic that intervals are worked out of; none of a maximum.
    const fn with_interval(self) -> Option<inhand_model::Measure> {
        match self {
            Measure::Median => Some(inhand_model::Measure::P50),
            Measure::ThirdQuartile => Some(inhand_model::Measure::P75),
            Measure::P95 => Some(inhand_model::Measure::P95),
            Measure::Max => None,
        }
    }

    /// The value, unless nothing was judged.
    pub(crate) fn of(self, statistics: &Statistics) -> Option<f64> {
        let value = match self {
            Measure::Median => statistics.p50,
            Measure::ThirdQuartile => statistics.p75,
            Measure::P95 => statistics.p95,
            Measure::Max => statistics.max,
        };
        (statistics.n > 0 && value.is_finite()).then_some(value)
    }
}

/// How a method's value compares with the best baseline's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    Ahead,
    Level,
    Behind,
}

/// One measure of one method beside the best baseline.
#[derive(Clone, Debug)]
pub(crate) struct Comparison<'a> {
    pub(crate) measure: Measure,
    pub(crate) own_m: f64,
    pub(crate) baseline: &'a str,
    pub(crate) baseline_m: f64,
    pub(crate) outcome: Outcome,
}

/// Compares `method` with the best baseline at each measure that both have. Only baselines that were judged at as
/// many positions count: where plans of a method failed, it has been spared what is hard.
pub(crate) fn comparisons<'a>(
    method: &MethodEvaluation,
    evaluation: &'a Evaluation,
) -> Vec<Comparison<'a>> {
    let comparable =
        || baselines(method, evaluation).filter(|other| other.error.all.n == method.error.all.n);
    Measure::ALL
        .into_iter()
        .filter_map(|measure| {
            let own_m = measure.of(&method.error.all)?;
            let (baseline_m, baseline) = comparable()
                .filter_map(|other| Some((measure.of(&other.error.all)?, other.name.as_str())))
                .min_by(|a, b| a.0.total_cmp(&b.0))?;
            let told_apart = told_apart(evaluation, (&method.name, baseline), measure);
            Some(Comparison {
                measure,
                own_m,
                baseline,
                baseline_m,
                outcome: match told_apart {
                    Some(false) => Outcome::Level,
                    _ => outcome(own_m, baseline_m),
                },
            })
        })
        .collect()
}

fn baselines<'a>(
    method: &MethodEvaluation,
    evaluation: &'a Evaluation,
) -> impl Iterator<Item = &'a MethodEvaluation> {
    let name = method.name.clone();
    let others = evaluation.methods.iter();
    others.filter(move |other| other.baseline && other.name != name)
}

/// Whether the interval of the difference of two methods leaves zero out; `None` without an interval.
fn told_apart(evaluation: &Evaluation, names: (&str, &str), measure: Measure) -> Option<bool> {
    let measure = measure.with_interval()?;
    let differences = &evaluation.intervals.as_ref()?.differences;
    let found = differences.iter().find(|difference| {
        let own = (difference.method.as_str(), difference.other.as_str());
        difference.finger.is_none()
            && difference.measure == measure
            && (own == names || own == (names.1, names.0))
    })?;
    let [low, high] = found.absolute.interval?;
    Some(!(low <= 0.0 && 0.0 <= high))
}

fn outcome(own_m: f64, baseline_m: f64) -> Outcome {
    if (own_m - baseline_m).abs() <= LEVEL_SHARE * own_m.min(baseline_m) {
        Outcome::Level
    } else if own_m < baseline_m {
        Outcome::Ahead
    } else {
        Outcome::Behind
    }
}

/// The default method, or the first one where a caller skipped the check of names.
pub(crate) fn default_method(evaluation: &Evaluation) -> Option<&MethodEvaluation> {
    evaluation
        .methods
        .iter()
        .find(|method| method.name == evaluation.default_method)
        .or(evaluation.methods.first())
}

/// What the error of the default method is, in a sentence.
pub(crate) fn error_sentence(evaluation: &Evaluation) -> String {
    let Some(method) = default_method(evaluation) else {
        return "No method was evaluated.".to_owned();
    };
    let (name, error) = (&method.name, &method.error.all);
    if error.n == 0 {
        return format!(
            "{name} could not be judged: no planned instant has a recorded one beside it."
        );
    }
    let all: usize = (evaluation.session.test.iter())
        .map(|take| take.segments)
        .sum();
    // Plans that failed have no positions.
    let judged = method.error_at_start.n.div_ceil(Finger::COUNT);
    let segments = match judged == all {
        true => format!("{} test segments", count(all, NARROW_SPACE)),
        false => format!(
            "{} of {} test segments",
            count(judged, NARROW_SPACE),
            count(all, NARROW_SPACE)
        ),
    };
    format!(
        "{name}, the default method, has a median fingertip error of {} mm and stays within {} mm \
         three quarters of the time, over {} fingertip positions in {segments}.",
        millimetres(error.p50),
        millimetres(error.p75),
        count(error.n, NARROW_SPACE),
    )
}

/// How `method` stands against the best baseline, in a sentence or two.
pub(crate) fn standing_sentence(method: &MethodEvaluation, evaluation: &Evaluation) -> String {
    let comparisons = comparisons(method, evaluation);
    let name = &method.name;
    if comparisons.is_empty() {
        let mut baselines = baselines(method, evaluation).peekable();
        let Some(first) = baselines.peek() else {
            return format!(
                "There is no baseline to compare {name} with, so its numbers stand alone."
            );
        };
        if method.error.all.n > 0 && first.error.all.n > 0 {
            return format!(
                "{name} was judged at {} fingertip positions, {} at {}: where plans failed, what is hard may be what is \
                 missing, so that these numbers say nothing of who does better.",
                count(method.error.all.n, NARROW_SPACE),
                first.name,
                count(first.error.all.n, NARROW_SPACE),
            );
        }
        return format!("{name} cannot be compared with a baseline: one of them has no errors.");
    }
    let total = comparisons.len();
    let group = |outcome| -> Vec<&Comparison<'_>> {
        comparisons
            .iter()
            .filter(|c| c.outcome == outcome)
            .collect()
    };
    let (behind, level, ahead) = (
        group(Outcome::Behind),
        group(Outcome::Level),
        group(Outcome::Ahead),
    );
    if ahead.len() == total {
        return format!(
            "{name} does better than every baseline: {}.",
            places(&ahead)
        );
    }
    let mut sentences = Vec::new();
    let better = by_baseline(&behind);
    if behind.len() == total && better.len() > 1 {
        sentences.push(format!("Baselines do better than {name} everywhere"));
    }
    for (baseline, behind) in better {
        let place = if behind.len() == total {
            "everywhere:"
        } else {
            "at the"
        };
        sentences.push(format!(
            "{baseline}, which learns nothing, does better than {name} {place} {}",
            places(&behind),
        ));
    }
    if !level.is_empty() {
        sentences.push(format!(
            "{name} is level with the best baseline at the {}",
            places(&level)
        ));
    }
    if !ahead.is_empty() {
        sentences.push(format!(
            "{name} does better than every baseline at the {}",
            places(&ahead)
        ));
    }
    format!("{}.", sentences.join(". "))
}

/// Comparisons under the baseline they are with, in the order of the first of each.
fn by_baseline<'a, 'b>(
    comparisons: &[&'b Comparison<'a>],
) -> Vec<(&'a str, Vec<&'b Comparison<'a>>)> {
    let mut groups: Vec<(&str, Vec<&Comparison<'_>>)> = Vec::new();
    for &comparison in comparisons {
        match groups
            .iter_mut()
            .find(|(baseline, _)| *baseline == comparison.baseline)
        {
            Some((_, group)) => group.push(comparison),
            None => groups.push((comparison.baseline, vec![comparison])),
        }
    }
    groups
}

/// Where, with the better number first.
fn places(comparisons: &[&Comparison<'_>]) -> String {
    let items: Vec<String> = comparisons
        .iter()
        .map(|c| {
            let (own, theirs) = (millimetres(c.own_m), millimetres(c.baseline_m));
            match c.outcome {
                Outcome::Behind => format!("{} ({theirs} against {own} mm)", c.measure.words()),
                Outcome::Level | Outcome::Ahead => {
                    format!(
                        "{} ({own} against {theirs} mm by {})",
                        c.measure.words(),
                        c.baseline
                    )
                }
            }
        })
        .collect();
    join_words(&items)
}

/// How often three fingertips or more touch the object, in a sentence; `None` without an object.
pub(crate) fn contact_sentence(evaluation: &Evaluation) -> Option<String> {
    let method = default_method(evaluation)?;
    let contact = method.contact.as_ref()?;
    if contact.n == 0 {
        return Some(format!(
            "Contacts could not be judged: there is no instant with a tracked object and a trajectory of {}.",
            method.name
        ));
    }
    Some(format!(
        "Three or more fingertips touch the object {} % of the time with {}, {} % in the recorded \
         motion (contact: within {} mm).",
        percent(contact.three_or_more),
        method.name,
        percent(contact.recorded_three_or_more),
        crate::number::plain(1e3 * contact.tau_m),
    ))
}

/// Whether the default method's plans exist and keep their constraints, in a sentence.
pub(crate) fn constraint_sentence(evaluation: &Evaluation) -> Option<String> {
    let method = default_method(evaluation)?;
    let mut parts = Vec::new();
    if let Some(plan) = &method.plan {
        let total = plan.solved + plan.infeasible + plan.failed;
        parts.push(if plan.solved == total {
            format!("all {} plans were solved", count(total, NARROW_SPACE))
        } else {
            format!(
                "{} of {} plans were solved, {} are infeasible and {} failed",
                count(plan.solved, NARROW_SPACE),
                count(total, NARROW_SPACE),
                count(plan.infeasible, NARROW_SPACE),
                count(plan.failed, NARROW_SPACE),
            )
        });
    }
    if method.velocity.n > 0 {
        parts.push(match method.velocity.outside {
            0 => "no velocity is outside its bounds".to_owned(),
            outside => format!(
                "{} of {} velocities are outside their bounds",
                count(outside, NARROW_SPACE),
                count(method.velocity.n, NARROW_SPACE),
            ),
        });
    }
    if method.reachability.n > 0 {
        parts.push(format!(
            "{} % of fingertip positions lie where the training takes have been (recorded motion: {} %)",
            percent(method.reachability.inside.mean()),
            percent(method.reachability.recorded_inside.mean()),
        ));
    }
    if method.collision.n > 0 {
        parts.push(format!(
            "fingertips come nearer than {} mm to each other at {} of {} instants (recorded: {})",
            crate::number::plain(1e3 * method.collision.limit_m),
            count(method.collision.instants, NARROW_SPACE),
            count(method.collision.n, NARROW_SPACE),
            count(method.collision.recorded_instants, NARROW_SPACE),
        ));
    }
    (!parts.is_empty()).then(|| format!("With {}, {}.", method.name, join_words(&parts)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outcomes_by_hand() {
        assert_eq!(outcome(0.001, 0.002), Outcome::Ahead);
        assert_eq!(outcome(0.002, 0.001), Outcome::Behind);
        assert_eq!(outcome(0.001_019, 0.001), Outcome::Level);
        assert_eq!(outcome(0.001_021, 0.001), Outcome::Behind);
        assert_eq!(outcome(0.0, 0.0), Outcome::Level);
    }
}
