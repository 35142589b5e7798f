//! Plausibility of settings and results against the data.

use inhand_model::{Evaluation, Finger, HeldOutEvaluation, Inspection, Level, SessionFinding};
use inhand_motion::Filter;

use super::{SessionLimits, SessionMotion, add, finding, object, of_take};
use crate::check::words::{length, percent};
use crate::statistics::Finite;

/// Length of a segment, seconds.
const SEGMENT_S: f64 = 1.0;

/// Share of a segment from which a filter leaves little of what is predicted.
const WINDOW_SHARE: f64 = 0.6;

/// Share of a segment above which a margin is doubtful.
const QUARTER: f64 = 0.25;

/// Share of the segments without gaps below which few are usable.
const SEGMENTS_SHARE: f64 = 0.9;

/// Share of instants with three fingers in contact below which the recorded object was hardly of this shape.
const CONTACT_SHARE: f64 = 0.05;

/// Distance that a filter may move fingertips (95 %) whatever the errors are, metres: noise of markers alone gives
/// half of it.
const MOVED_M: f64 = 1e-3;

/// How many times longer than under other labels the path from index to little fingertip may be. It is the
/// shortest path in hands of people; two exchanged labels make it at least 1.15 times as long.
const ORDER: f64 = 1.08;

/// Looks at settings against takes of a rate.
pub(super) fn settings(inspection: &mut Inspection, rate_hz: f64, limits: &SessionLimits<'_>) {
    let mut look = |id, found: Option<SessionFinding>| {
        add(inspection, &[id], found.into_iter().collect(), limits);
    };
    if let Some(shape) = limits.shape {
        look("object-size", object::object_size(shape));
        look("tau", object::tau(shape, limits.tau_m));
    }
    look(
        "filter-window",
        filter_window(limits.check.process.filter, rate_hz),
    );
    let beside = [
        (limits.check.margin_s, "--margin"),
        (limits.ends_s, "--ends-s"),
    ];
    let margin = beside
        .into_iter()
        .find_map(|(time_s, flag)| margin(time_s, flag));
    look("margin", margin);
    look("held-out-resampled", resampled(limits.resampled));
}

fn resampled(is_resampled: bool) -> Option<SessionFinding> {
    is_resampled.then(|| {
        let found = "recordings are resampled: the low-pass filter before it reaches across ends of segments";
        let advice = "compare with the recorded rate: leave out clean.resample_hz";
        finding("held-out-resampled", Level::Warn, found.to_owned(), advice)
    })
}

/// Adds what only results show.
pub fn inspect_results(
    inspection: &mut Inspection,
    evaluation: &Evaluation,
    limits: &SessionLimits<'_>,
) {
    let mut look = |id, found: Option<SessionFinding>| {
        add(inspection, &[id], found.into_iter().collect(), limits);
    };
    look("primitives", primitives(evaluation));
    let methods = &evaluation.methods;
    let Some(method) = methods.iter().find(|m| m.name == evaluation.default_method) else {
        return;
    };
    if let Some(contact) = method.contact.as_ref().filter(|contact| contact.n > 0) {
        look(
            "contact-share",
            contact_share(contact.recorded_three_or_more),
        );
    }
    if let Some(moved) = &evaluation.filter_moves {
        let (moved_m, error_m) = (moved.all.p95, method.error.all.p50);
        look("filter-moves", filter_moves(moved_m, error_m));
    }
    add(inspection, &[], held_out_segments(evaluation), limits);
}

/// The path along the fingertips against that under other labels.
pub(super) fn finger_order(take: &SessionMotion<'_>) -> Option<SessionFinding> {
    let tips = &take.motion.fingertips;
    let mut apart_m = [[0.0; Finger::COUNT]; Finger::COUNT];
    for (n, a) in Finger::ALL.into_iter().enumerate() {
        for b in &Finger::ALL[n + 1..] {
            let both = tips[a].iter().zip(tips[*b].iter());
            let both = both.filter_map(|(a, b)| Some((a?.coords_m() - b?.coords_m()).norm()));
            let median_m = Finite::new(both).median();
            apart_m[n][b.index()] = median_m;
            apart_m[b.index()][n] = median_m;
        }
    }
    let path_m = |order: &[usize; 4]| -> f64 {
        order.windows(2).map(|pair| apart_m[pair[0]][pair[1]]).sum()
    };
    let orders = (0..625).map(|n: usize| [n / 125, n / 25 % 5, n / 5 % 5, n % 5]);
    let distinct = orders.filter(|order| (1..4).all(|n| !order[..n].contains(&order[n])));
    let best = distinct.min_by(|a, b| path_m(a).total_cmp(&path_m(b)))?;
    (path_m(&[1, 2, 3, 4]) > ORDER * path_m(&best)).then(|| {
        let row = best.map(|place| Finger::ALL[place].name()).join(", ");
        let found = format!("the fingertips are in the order {row}: labels may be exchanged");
        let advice = "see which marker is on which finger: --finger FINGER=MARKER";
        of_take(take, finding("finger-order", Level::Warn, found, advice))
    })
}

/// The time over which a filter smooths against a segment.
fn filter_window(filter: Filter, rate_hz: f64) -> Option<SessionFinding> {
    let (window_s, flag) = match filter {
        Filter::None => return None,
        Filter::Median { window } | Filter::SavitzkyGolay { window, .. } => {
            (window as f64 / rate_hz, "--window")
        }
        Filter::Butterworth { cutoff_hz, .. } => (1.0 / cutoff_hz, "--cutoff"),
    };
    let level = match window_s / SEGMENT_S {
        share if share >= 1.0 => Level::Fail,
        share if share > WINDOW_SHARE => Level::Warn,
        _ => return None,
    };
    let found = format!(
        "the filter smooths over {window_s:.2} s of segments of {SEGMENT_S} s: it removes the motion that is \
         to be predicted"
    );
    let advice = format!("use at most half a segment: {flag}");
    Some(finding("filter-window", level, found, advice))
}

/// Few segments that can be judged under the held-out protocol.
fn held_out_segments(evaluation: &Evaluation) -> Vec<SessionFinding> {
    let few = |own: &&HeldOutEvaluation| {
        (own.segments as f64) < SEGMENTS_SHARE * (own.segments + own.left_out) as f64
            || own.segments == 0
    };
    let own = evaluation.held_out.iter().filter(few);
    own.map(|own| {
        let found = format!(
            "{} of {} test segments can be judged under the held-out protocol",
            own.segments,
            own.segments + own.left_out
        );
        let advice =
            "fill gaps (--max-gap), record longer, or take ends from shorter lines (--ends-s)";
        let mut finding = finding("segments", Level::Warn, found, advice);
        if own.segments == 0 {
            "held out".clone_into(&mut finding.entity);
        }
        finding
    })
    .collect()
}

/// A time beside segments from which end velocities are taken.
fn margin(margin_s: f64, flag: &str) -> Option<SessionFinding> {
    (margin_s > QUARTER * SEGMENT_S).then(|| {
        let found = format!(
            "{margin_s} s beside segments of {SEGMENT_S} s serve for end velocities: they are those of other motion"
        );
        let advice = format!("use less than a quarter of a segment: {flag}");
        finding("margin", Level::Warn, found, advice)
    })
}

fn primitives(evaluation: &Evaluation) -> Option<SessionFinding> {
    let (rank, segments) = (evaluation.dictionary.rank, evaluation.dictionary.segments);
    (rank >= segments).then(|| {
        let found = format!(
            "{rank} primitives from {segments} training segments: nothing is left to generalise from"
        );
        let advice = "use fewer (--rank), cut more segments (--stride), or record more";
        finding("primitives", Level::Warn, found, advice)
    })
}

fn contact_share(share: f64) -> Option<SessionFinding> {
    (share < CONTACT_SHARE).then(|| {
        let found = format!(
            "three fingers touch the object at {} of the recorded instants",
            percent(share)
        );
        let advice = "see shape, size and centre of the object: --object, --object-offset";
        finding("contact-share", Level::Warn, found, advice)
    })
}

fn filter_moves(moved_m: f64, error_m: f64) -> Option<SessionFinding> {
    (moved_m > MOVED_M.max(error_m)).then(|| {
        let (moved, error) = (length(moved_m), length(error_m));
        let found = format!(
            "the filter moves recorded fingertips by up to {moved} (95 %), more than the median error of {error}: \
             errors are distances to the filtered motion"
        );
        let advice = "compare with a shorter window (--window) or --filter none";
        finding("filter-moves", Level::Warn, found, advice)
    })
}
