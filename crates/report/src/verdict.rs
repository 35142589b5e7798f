//! Comparison of a method with the baselines, choice of the method and validation of the deviation, in words. The same words
//! open the HTML and close the terminal table, so that neither can flatter.

use inhand_model::{
    Evaluation, Finger, Inspection, Level, Measure, MethodCandidate, MethodChoice,
    MethodEvaluation, Protocol, SessionFinding, Statistics,
};

use crate::table::statistic;
use crate::words::{
    count, counted, decimals, join_words, millimetres, part_of, percent, plain, stated_percent,
    to_mm,
};

/// Findings of the inspection that may affect numbers, worst first.
pub(crate) fn warnings(evaluation: &Evaluation) -> impl Iterator<Item = &SessionFinding> {
    let findings = evaluation
        .inspection
        .iter()
        .flat_map(|inspection| &inspection.findings);
    findings.filter(|finding| finding.level > Level::Info)
}

/// Number of checks that found nothing, in a sentence; `None` where nothing was looked at.
pub fn inspection_sentence(inspection: &Inspection) -> Option<String> {
    let (passed, all) = (inspection.passed().len(), inspection.checks.len());
    let checks = match all == passed {
        true => counted(all, "check"),
        false => part_of(passed, all) + " checks",
    };
    (all > 0).then(|| format!("Nothing odd was found in {checks}."))
}

/// Differences up to this share of the better value count as ties: they vanish in the rounding
/// of the printed numbers, and a session's segments are far too few to establish them. So does a
/// difference whose interval contains zero.
const TIE_SHARE: f64 = 0.02;

/// A place in the distribution of errors at which methods are compared: its name in a sentence, its value, and the
/// measure whose interval is known; none of a maximum.
type Place = (&'static str, fn(&Statistics) -> f64, Option<Measure>);

const PLACES: [Place; 4] = [
    ("median", |s| s.p50, Some(Measure::P50)),
    ("third quartile", |s| s.p75, Some(Measure::P75)),
    ("95 % quantile", |s| s.p95, Some(Measure::P95)),
    ("maximum", |s| s.max, None),
];

/// Comparison of a method's value with the best baseline's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    Lower,
    Tie,
    Higher,
}

/// One place of one method beside the best baseline.
#[derive(Clone, Debug)]
pub(crate) struct Comparison<'a> {
    place: &'static str,
    own_m: f64,
    pub(crate) baseline: &'a str,
    baseline_m: f64,
    pub(crate) outcome: Outcome,
}

/// Compares `method` with the best baseline at each place that both have. Only baselines that were evaluated at as
/// many positions count: where plans of a method failed, it has been spared what is hard.
pub(crate) fn comparisons<'a>(
    method: &MethodEvaluation,
    evaluation: &'a Evaluation,
    protocol: Protocol,
) -> Vec<Comparison<'a>> {
    let comparable = || {
        let others = baselines(method, evaluation, protocol);
        others.filter(|other| other.error.all.n == method.error.all.n)
    };
    (PLACES.into_iter())
        .filter_map(|(place, of, measure)| {
            let value = |method: &MethodEvaluation| {
                Some(statistic(&method.error.all, of)).filter(|value| value.is_finite())
            };
            let own_m = value(method)?;
            let (baseline_m, baseline) = comparable()
                .filter_map(|other| Some((value(other)?, other.name.as_str())))
                .min_by(|a, b| a.0.total_cmp(&b.0))?;
            let uncertain = may_be_zero(evaluation, protocol, (&method.name, baseline), measure);
            Some(Comparison {
                place,
                own_m,
                baseline,
                baseline_m,
                outcome: match uncertain {
                    Some(true) => Outcome::Tie,
                    _ => outcome(own_m, baseline_m),
                },
            })
        })
        .collect()
}

fn baselines<'a>(
    method: &MethodEvaluation,
    evaluation: &'a Evaluation,
    protocol: Protocol,
) -> impl Iterator<Item = &'a MethodEvaluation> {
    let name = method.name.clone();
    let others = evaluation.methods(protocol).iter();
    others.filter(move |other| other.baseline && other.name != name)
}

/// Whether the interval of the difference of two methods contains zero; `None` without an interval.
fn may_be_zero(
    evaluation: &Evaluation,
    protocol: Protocol,
    names: (&str, &str),
    measure: Option<Measure>,
) -> Option<bool> {
    let measure = measure?;
    let differences = &evaluation.intervals(protocol)?.differences;
    let found = differences.iter().find(|difference| {
        let own = (difference.method.as_str(), difference.other.as_str());
        difference.finger.is_none()
            && difference.measure == measure
            && (own == names || own == (names.1, names.0))
    })?;
    let [low, high] = found.absolute.interval?;
    Some(low <= 0.0 && 0.0 <= high)
}

fn outcome(own_m: f64, baseline_m: f64) -> Outcome {
    if (own_m - baseline_m).abs() <= TIE_SHARE * own_m.min(baseline_m) {
        Outcome::Tie
    } else if own_m < baseline_m {
        Outcome::Lower
    } else {
        Outcome::Higher
    }
}

/// The protocols under which methods were compared, the one to look at first before the other.
pub(crate) fn protocols(evaluation: &Evaluation) -> impl Iterator<Item = Protocol> {
    let all = [Protocol::HeldOut, Protocol::Published].into_iter();
    all.filter(|protocol| {
        let segments = evaluation.held_out.as_ref().map_or(0, |own| own.segments);
        *protocol == Protocol::Published || segments > 0
    })
}

/// The protocol to look at first.
pub(crate) fn headline(evaluation: &Evaluation) -> Protocol {
    protocols(evaluation).next().unwrap_or_default()
}

/// Why an evaluation has no held-out errors; `None` where it has some.
pub(crate) fn without_held_out(evaluation: &Evaluation) -> Option<&'static str> {
    match &evaluation.held_out {
        None => Some(
            "This evaluation was made before the held-out protocol: errors are distances to the filtered recording alone.",
        ),
        Some(own) if own.segments == 0 => Some(
            "No segment can be judged under the held-out protocol: errors are distances to the filtered recording alone.",
        ),
        Some(_) => None,
    }
}

/// Reference and boundary conditions of a protocol, in two sentences.
pub(crate) fn definition(protocol: Protocol, evaluation: &Evaluation) -> String {
    match protocol {
        Protocol::HeldOut => {
            let own = evaluation.held_out.as_ref();
            let samples = own.map_or(0, |own| own.ends_samples);
            let ends_ms = 1e3 * samples as f64 / evaluation.session.rate_hz;
            format!(
                "Held out: the reference is the recorded motion with gaps filled, not filtered. Start and goal are values and \
                 slopes of least-squares lines over {} ms of measured samples up to the segment's first and from its last on; \
                 nothing in between, filtered or not, reaches the planner.",
                plain(ends_ms)
            )
        }
        Protocol::Published => "Published: the reference is the recorded motion after gap filling and filtering; start, goal \
            and velocities are taken from that filtered motion, so up to half the filter's window (0.25 s by default) of the \
            segment reaches the planner. It is the protocol of arXiv:2308.15153 and says how well a smoothed motion is \
            reproduced."
            .to_owned(),
    }
}

/// How far the filter moves the reference, in a sentence; `None` without a filter.
pub(crate) fn filter_sentence(evaluation: &Evaluation) -> Option<String> {
    let moved = evaluation.filter_moves.as_ref()?.all;
    (moved.n > 0).then(|| {
        format!(
            "The filter moves recorded fingertips by {} mm (median), {} mm (95 %), {} mm at most.",
            millimetres(moved.p50),
            millimetres(moved.p95),
            millimetres(moved.max)
        )
    })
}

/// The default method, or the first one where a caller skipped the check of names.
pub(crate) fn default_method(
    evaluation: &Evaluation,
    protocol: Protocol,
) -> Option<&MethodEvaluation> {
    let methods = evaluation.methods(protocol);
    let named = |method: &&MethodEvaluation| method.name == evaluation.default_method;
    methods.iter().find(named).or(methods.first())
}

/// Error of the default method under the first protocol, and how it compares with the best baselines, in a sentence to
/// quote.
pub(crate) fn verdict(evaluation: &Evaluation) -> String {
    let protocol = headline(evaluation);
    let Some(method) = default_method(evaluation, protocol) else {
        return "No method was evaluated.".to_owned();
    };
    let (name, error) = (&method.name, &method.error.all);
    if error.n == 0 {
        let compared = comparison_sentence(method, evaluation, protocol);
        return format!(
            "{name} could not be evaluated: no planned instant has a recorded one beside it. {compared}"
        );
    }
    let all = match (&evaluation.held_out, protocol) {
        (Some(own), Protocol::HeldOut) => own.segments,
        _ => evaluation.session.test.iter().map(|t| t.segments).sum(),
    };
    // Plans that failed have no positions.
    let evaluated = method.error_at_start.n.div_ceil(Finger::COUNT);
    let segments = match evaluated == all {
        true => count(all),
        false => part_of(evaluated, all),
    };
    let start = match protocol {
        Protocol::HeldOut => "Held out, over",
        Protocol::Published => "Over",
    };
    let subject = format!(
        "{start} {} fingertip positions in {segments} test segments, {name} ({})",
        count(error.n),
        method.description
    );
    let comparisons = comparisons(method, evaluation, protocol);
    if comparisons.is_empty() {
        return format!(
            "{subject} has a median fingertip error of {} mm and a 95 % quantile of {} mm. {}",
            millimetres(error.p50),
            millimetres(error.p95),
            comparison_sentence(method, evaluation, protocol)
        );
    }
    format!(
        "{subject} {}.",
        outcomes(&comparisons, evaluation.methods(protocol))
    )
}

/// `method` compared with the best baselines, in a sentence or two.
pub(crate) fn comparison_sentence(
    method: &MethodEvaluation,
    evaluation: &Evaluation,
    protocol: Protocol,
) -> String {
    let comparisons = comparisons(method, evaluation, protocol);
    let name = &method.name;
    if comparisons.is_empty() {
        let Some(first) = baselines(method, evaluation, protocol).next() else {
            return format!("There is no baseline to compare {name} with.");
        };
        if method.error.all.n > 0 && first.error.all.n > 0 {
            return format!(
                "{name} was evaluated at {} fingertip positions, {} at {}: failed plans leave out what may be the hardest \
                 segments, so their errors cannot be compared.",
                count(method.error.all.n),
                first.name,
                count(first.error.all.n),
            );
        }
        return format!("{name} cannot be compared with a baseline: one of them has no errors.");
    }
    format!(
        "{name} {}.",
        outcomes(&comparisons, evaluation.methods(protocol))
    )
}

/// Outcomes of comparisons as the end of a sentence about a method, in the order of the places.
fn outcomes(comparisons: &[Comparison<'_>], methods: &[MethodEvaluation]) -> String {
    // Takes that hold some of the methods have one.
    let baselines = methods.iter().filter(|method| method.baseline).count();
    let best = if baselines == 1 { "only" } else { "best" };
    let mut groups: Vec<(Outcome, Vec<String>)> = Vec::new();
    for c in comparisons {
        let (own, theirs) = (millimetres(c.own_m), millimetres(c.baseline_m));
        let place = format!("{} ({own} vs {theirs} mm of {})", c.place, c.baseline);
        match groups.iter_mut().find(|(outcome, _)| *outcome == c.outcome) {
            Some((_, places)) => places.push(place),
            None => groups.push((c.outcome, vec![place])),
        }
    }
    let clauses = groups.iter().map(|(outcome, places)| {
        let words = match outcome {
            Outcome::Lower if best == "best" => "has a lower error than every baseline".to_owned(),
            Outcome::Lower => format!("has a lower error than the {best} baseline"),
            Outcome::Tie => format!("ties with the {best} baseline"),
            Outcome::Higher => format!("has a higher error than the {best} baseline"),
        };
        format!("{words} at the {}", join_words(places))
    });
    clauses.collect::<Vec<_>>().join("; it ")
}

/// Share of instants with three or more contacts, in a sentence; `None` without an object.
pub(crate) fn contact_sentence(method: &MethodEvaluation) -> Option<String> {
    let contact = method.contact.as_ref()?;
    if contact.n == 0 {
        return Some(format!(
            "Contacts could not be evaluated: there is no instant with a tracked object and a trajectory of {}.",
            method.name
        ));
    }
    Some(format!(
        "Three or more fingertips touch the object {} % of the time with {}, {} % in the recorded \
         motion (contact: within {} mm).",
        percent(contact.three_or_more),
        method.name,
        percent(contact.recorded_three_or_more),
        plain(to_mm(contact.tau_m)),
    ))
}

/// Coverage of the widest prediction regions of a method that were evaluated, in a sentence.
pub(crate) fn region_sentence(method: &MethodEvaluation) -> Option<String> {
    let known = (method.corridors.iter()).filter(|c| c.n > 0 && c.share_stated.is_finite());
    let widest = known.max_by(|a, b| a.share_stated.total_cmp(&b.share_stated))?;
    Some(format!(
        "{} % prediction regions of {} contain {} % of {} recorded fingertip positions.",
        stated_percent(widest.share_stated),
        method.name,
        percent(widest.share_inside.all),
        count(widest.n),
    ))
}

/// Fingertip samples missing as recorded, and all, over the takes.
pub(crate) fn missing_samples(evaluation: &Evaluation) -> (usize, usize) {
    let takes = evaluation.quality.iter();
    let tracks = takes.flat_map(|take| take.fingers.as_array());
    tracks.fold((0, 0), |(missing, samples), track| {
        let own = &track.recorded;
        let all = own.measured + own.filled + own.missing;
        (missing + own.missing, samples + all)
    })
}

/// Which method was chosen and why, in a sentence; `None` where no choice was asked for.
pub(crate) fn choice_sentence(evaluation: &Evaluation) -> Option<String> {
    let choice = evaluation.choice.as_ref()?;
    Some(format!(
        "auto chose {}: {}.",
        choice.method,
        reason(evaluation, choice)
    ))
}

fn reason(evaluation: &Evaluation, choice: &MethodChoice) -> String {
    let left_out = format!(
        "on {} training segments left out of learning{}",
        count(choice.segments),
        match choice.protocol {
            Protocol::HeldOut => ", under the held-out protocol,",
            Protocol::Published => "",
        }
    );
    let Some(chosen) = choice.candidates.iter().find(|c| c.name == choice.method) else {
        return format!("it has the lowest error {left_out}");
    };
    let own_m = chosen.mean_error_m;
    let start = format!("{left_out} its mean error is {}", fine_mm(own_m));
    let Some((rival, learned)) = rival(evaluation, choice) else {
        let least = (choice.candidates.iter()).all(|c| own_m.total_cmp(&c.mean_error_m).is_le());
        return match choice.candidates.len() {
            0 | 1 => format!("{start}, and nothing else was compared"),
            n if least => format!("{start}, the least of {n} methods"),
            _ => start,
        };
    };
    let kind = match learned {
        true => "the best learned method",
        false => "the best baseline",
    };
    let (name, error_m) = (&rival.name, rival.mean_error_m);
    if !error_m.is_finite() {
        return format!("{start}; {name}, {kind}, fails for some segments");
    }
    let against = format!("{start}, against {} of {name}, {kind}", fine_mm(error_m));
    let gain = choice.gain_m.filter(|gain_m| gain_m.is_finite());
    let words = gain.map(|gain_m| gain_words(gain_m, choice.gain_standard_error_m));
    match words {
        Some(gain) if !learned => {
            format!("{against}; the gain of {gain} is above its standard error")
        }
        Some(words) if gain > Some(0.0) => {
            format!("{against}, whose gain of {words} is not above its standard error")
        }
        _ => against,
    }
}

/// The best candidate of the kind that was not chosen, and whether it is learned; `None` where the chosen method was
/// not evaluated, so that its kind is not known, or where all candidates are of one kind.
fn rival<'a>(
    evaluation: &Evaluation,
    choice: &'a MethodChoice,
) -> Option<(&'a MethodCandidate, bool)> {
    let baseline = |name: &str| {
        let mut methods = evaluation.methods.iter();
        Some(methods.find(|method| method.name == name)?.baseline)
    };
    let chosen = baseline(&choice.method)?;
    let others = (choice.candidates.iter()).filter(|c| baseline(&c.name) == Some(!chosen));
    let best = others.min_by(|a, b| a.mean_error_m.total_cmp(&b.mean_error_m))?;
    Some((best, chosen))
}

fn gain_words(gain_m: f64, standard_error_m: Option<f64>) -> String {
    match standard_error_m {
        Some(error_m) if error_m.is_finite() => {
            format!("{} ± {}", decimals(to_mm(gain_m), 3), fine_mm(error_m))
        }
        _ => fine_mm(gain_m),
    }
}

/// Millimetres with a third decimal: means over many segments differ by less than a hundredth.
pub(crate) fn fine_mm(metres: f64) -> String {
    format!("{} mm", decimals(to_mm(metres), 3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outcomes_by_hand() {
        assert_eq!(outcome(0.001, 0.002), Outcome::Lower);
        assert_eq!(outcome(0.002, 0.001), Outcome::Higher);
        assert_eq!(outcome(0.001_019, 0.001), Outcome::Tie);
        assert_eq!(outcome(0.001_021, 0.001), Outcome::Higher);
        assert_eq!(outcome(0.0, 0.0), Outcome::Tie);
    }
}
