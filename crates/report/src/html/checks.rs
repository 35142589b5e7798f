//! Checks of an evaluation: numbers that are worrying, and those that are not.

use inhand_model::{Evaluation, Finger, MethodEvaluation, Movement, Protocol, StopReason};

use super::{dictionary, paper};
use crate::Report;
use crate::table::statistic;
use crate::verdict::{
    contact_sentence, default_method, filter_sentence, headline, inspection_sentence,
    missing_samples, region_sentence, without_held_out,
};
use crate::words::{
    count, counted, decimals, millimetres, part_of, percent, plain, stated_percent, to_mm,
};

/// Something that was looked at, with its numbers in a line.
pub(crate) struct Check {
    pub(crate) label: &'static str,
    pub(crate) words: String,
    /// Whether it may change what a reader concludes.
    pub(crate) worrying: bool,
}

impl Check {
    pub(super) fn new(label: &'static str, worrying: bool, words: impl Into<String>) -> Self {
        let mut words = words.into().trim_end_matches('.').to_owned();
        if let Some(first) = words.get_mut(..1) {
            first.make_ascii_lowercase();
        }
        Self {
            label,
            words,
            worrying,
        }
    }
}

/// Differences of shares from recorded or stated ones that are a worry beyond, 0 to 1.
const SHARE: f64 = 0.01;
/// Difference of the coverage of prediction regions from what they state that is a worry beyond, 0 to 1; five times as much of one finger.
const COVERAGE: f64 = 0.02;
/// Ratio of planned and recorded speed, and of errors to the unfiltered and filtered recording, that is a worry beyond.
const RATIO: f64 = 1.2;
/// Share of samples missing that is a worry beyond, 0 to 1.
const MISSING: f64 = 0.05;
/// Share of segments left out that is a worry beyond, 0 to 1.
const LEFT_OUT: f64 = 0.1;

/// Everything that was looked at, under the first protocol where a line does not name another; what was not planned or
/// recorded is not there.
pub(crate) fn checks(report: &Report<'_>) -> Vec<Check> {
    let evaluation = report.evaluation;
    let protocol = headline(evaluation);
    let method = default_method(evaluation, protocol);
    let checks = [
        method.and_then(|method| collisions(method, protocol)),
        peak_speed(evaluation),
        Some(learning(evaluation)),
        unfiltered(evaluation),
        paper::check(report, SHARE).map(|(off, words)| Check::new("Published values", off, words)),
        method.and_then(regions),
        method.and_then(plans),
        method.and_then(velocity),
        method.and_then(reach),
        method.and_then(contacts),
        gaps(evaluation),
        reader(evaluation),
        inspection(evaluation),
    ];
    checks.into_iter().flatten().collect()
}

fn collisions(method: &MethodEvaluation, protocol: Protocol) -> Option<Check> {
    let own = &method.collision;
    let recorded = match protocol {
        Protocol::HeldOut => "recording",
        Protocol::Published => "filtered recording",
    };
    let words = format!(
        "fingertips of {} nearer than {} mm at {} instants ({recorded}: {}), {} mm at the nearest ({recorded}: {} mm)",
        method.name,
        plain(to_mm(own.limit_m)),
        part_of(own.instants, own.n),
        count(own.recorded_instants),
        millimetres(own.nearest_m),
        millimetres(own.recorded_nearest_m),
    );
    let more = own.instants as f64 - own.recorded_instants as f64;
    let nearer = own.instants > 0 && RATIO * own.nearest_m < own.recorded_nearest_m;
    let worrying = more > SHARE * own.n as f64 || nearer;
    (own.n > 0).then(|| Check::new("Collisions", worrying, words))
}

/// The finger whose median peak speed differs most from the recorded one.
fn peak_speed(evaluation: &Evaluation) -> Option<Check> {
    let movement = evaluation.movement.as_ref()?;
    let name = &evaluation.default_method;
    let (_, planned) = movement.methods.iter().find(|(own, _)| own == name)?;
    let peak_mm_s = |own: &Movement, finger: Finger| {
        to_mm(statistic(&own.by_finger[finger].peak_speed_m_s, |s| s.p50))
    };
    let speeds = Finger::ALL.map(|finger| {
        let both = [planned, &movement.recorded].map(|own| peak_mm_s(own, finger));
        (finger, both, (both[0] / both[1]).ln().abs())
    });
    // A plan that never moves is infinitely far off.
    let known = speeds.into_iter().filter(|(.., far)| !far.is_nan());
    let (finger, both, far) = known.max_by(|a, b| a.2.total_cmp(&b.2))?;
    let [own, recorded] = both.map(|speed| decimals(speed, 1));
    let segments = counted(planned.by_finger[finger].peak_speed_m_s.n, "segment");
    let words = format!(
        "{finger} {own} mm/s with {name}, {recorded} mm/s in the filtered recording: medians over {segments}, \
         of the finger that differs most, published protocol"
    );
    Some(Check::new("Peak speed", far > RATIO.ln(), words))
}

fn learning(evaluation: &Evaluation) -> Check {
    let facts = &evaluation.dictionary;
    let words = format!(
        "{}; root mean square error {} mm over {}",
        dictionary::end(facts),
        decimals(to_mm(facts.rms_m), 3),
        counted(facts.segments, "training segment")
    );
    let early = facts.stop_reason == StopReason::IterationLimit;
    Check::new("Learning", early, words)
}

/// Errors to the recording itself beside those to what the filter made of it.
fn unfiltered(evaluation: &Evaluation) -> Option<Check> {
    let label = "Unfiltered recording";
    if let Some(words) = without_held_out(evaluation) {
        return Some(Check::new(label, true, words));
    }
    let [own, filtered] = [Protocol::HeldOut, Protocol::Published].map(|protocol| {
        let method = default_method(evaluation, protocol);
        method.map_or(f64::NAN, |own| statistic(&own.error.all, |s| s.p50))
    });
    let words = format!(
        "median error {} mm against it, {} mm against the filtered one, which also gives both ends. {}",
        millimetres(own),
        millimetres(filtered),
        filter_sentence(evaluation).unwrap_or_default(),
    );
    // What is not a number is not fine.
    let fine = own <= RATIO * filtered;
    Some(Check::new(label, !fine, words.trim_end()))
}

/// Regions of all stated shares, with the finger whose coverage is farthest from what one states.
fn regions(method: &MethodEvaluation) -> Option<Check> {
    let sentence = region_sentence(method)?;
    let known = || method.corridors.iter().filter(|own| own.n > 0);
    let far = |share: f64, stated: f64| (share - stated).abs();
    let fine = known().all(|own| far(own.share_inside.all, own.share_stated) <= COVERAGE);
    let fingers = known().flat_map(|own| {
        let fingers = own.share_inside.by_finger.iter();
        fingers.map(|(finger, &share)| (finger, share, own.share_stated))
    });
    let (finger, share, stated) = fingers.max_by(|a, b| far(a.1, a.2).total_cmp(&far(b.1, b.2)))?;
    let words = format!(
        "{}; farthest off is {finger}, with {} % in those of {} %",
        sentence.trim_end_matches('.'),
        percent(share),
        stated_percent(stated)
    );
    let worrying = !fine || far(share, stated) > 5.0 * COVERAGE;
    Some(Check::new("Coverage", worrying, words))
}

fn plans(method: &MethodEvaluation) -> Option<Check> {
    let plan = method.plan.as_ref()?;
    let all = plan.solved + plan.infeasible + plan.failed;
    let words = format!(
        "{} solved, {} infeasible, {} failed",
        part_of(plan.solved, all),
        count(plan.infeasible),
        count(plan.failed)
    );
    (all > 0).then(|| Check::new("Plans", plan.solved < all, words))
}

fn velocity(method: &MethodEvaluation) -> Option<Check> {
    let own = &method.velocity;
    let words = part_of(own.outside, own.n) + " steps outside the bounds";
    (own.n > 0).then(|| Check::new("Velocity", own.outside > 0, words))
}

fn reach(method: &MethodEvaluation) -> Option<Check> {
    let own = &method.reachability;
    let (inside, recorded) = (own.inside.mean(), own.recorded_inside.mean());
    let words = format!(
        "{} % of positions inside the training hull (recorded: {} %)",
        percent(inside),
        percent(recorded)
    );
    let fine = recorded - inside <= SHARE;
    (own.n > 0).then(|| Check::new("Reach", !fine, words))
}

fn contacts(method: &MethodEvaluation) -> Option<Check> {
    let own = method.contact.as_ref()?;
    let fine = (own.three_or_more - own.recorded_three_or_more).abs() <= SHARE;
    let words = contact_sentence(method)?;
    Some(Check::new("Contacts", own.n == 0 || !fine, words))
}

fn gaps(evaluation: &Evaluation) -> Option<Check> {
    let takes = || (evaluation.session.train.iter()).chain(&evaluation.session.test);
    let left_out: usize = takes().map(|take| take.left_out).sum();
    let segments = takes().map(|take| take.segments).sum::<usize>() + left_out;
    let (missing, samples) = missing_samples(evaluation);
    let words = format!(
        "{} fingertip samples missing, {} segments left out",
        part_of(missing, samples),
        part_of(left_out, segments)
    );
    let worrying =
        missing as f64 > MISSING * samples as f64 || left_out as f64 > LEFT_OUT * segments as f64;
    (samples > 0).then(|| Check::new("Gaps", worrying, words))
}

/// Warnings of the reader of the takes.
fn reader(evaluation: &Evaluation) -> Option<Check> {
    let takes = &evaluation.quality;
    let with: Vec<_> = takes.iter().filter(|take| take.warnings() > 0).collect();
    let warnings = with.iter().map(|take| take.warnings()).sum();
    let words = match with.first() {
        None => format!("no warning about {}", counted(takes.len(), "take")),
        Some(first) => format!(
            "{} about {} takes, the first {}",
            counted(warnings, "warning"),
            part_of(with.len(), takes.len()),
            first.take
        ),
    };
    (!takes.is_empty()).then(|| Check::new("Reader", !with.is_empty(), words))
}

/// How many checks found nothing; what others found has lines of its own.
fn inspection(evaluation: &Evaluation) -> Option<Check> {
    let label = "Inspection";
    let Some(inspection) = &evaluation.inspection else {
        let words = "content of takes and settings was not inspected";
        return Some(Check::new(label, true, words));
    };
    let words = inspection_sentence(inspection)?;
    Some(Check::new(label, false, words))
}
