//! Data quality of each take.

use inhand_model::{
    Evaluation, Finding, Finger, TakeFacts, TakeQuality, TrackCounts, TrackQuality,
};
use maud::{Markup, html};

use super::table::{Column, Line, numbers, table, words};
use crate::number::{NARROW_SPACE, NONE, count, decimals, percent};

/// Findings of one take that are shown before they fold away.
const FINDINGS_SHOWN: usize = 6;

/// The section's content.
pub(super) fn section(evaluation: &Evaluation) -> Markup {
    let gaps = gap_lines(&evaluation.quality);
    let tracks = evaluation.quality.len() * Finger::COUNT;
    html! {
        (table("Takes", &TAKE_COLUMNS, take_lines(evaluation)))
        p.note {
            "Left out: segments that a take without gaps would have given in addition. Tracked: share of samples in which \
             the hand's or object's pose is known."
        }
        @if gaps.is_empty() {
            p {
                @if tracks == 0 { "Nothing is known of the takes' gaps." }
                @else { "No fingertip is missing at any sample of any take." }
            }
        } @else {
            @let complete = tracks - gaps.len();
            (table("Gaps of the fingertips", &GAP_COLUMNS, gaps))
            p.note {
                "Missing: samples without a measurement, as recorded. Filled: short gaps closed by interpolation, marked as such in \
                 every later step. Open: still missing after processing; segments that touch them are left out of all statistics. "
                @if complete > 0 { "The other " (complete) " of " (tracks) " fingertip tracks are complete." }
            }
        }
        @if !evaluation.quality.is_empty() { (findings(&evaluation.quality)) }
    }
}

const TAKE_COLUMNS: [Column<'static>; 9] = [
    words("take"),
    words("role"),
    numbers("length", "s"),
    numbers("samples", ""),
    numbers("segments", ""),
    numbers("left out", ""),
    numbers("hand tracked", "%"),
    numbers("object tracked", "%"),
    numbers("warnings", ""),
];

fn take_lines(evaluation: &Evaluation) -> Vec<Line> {
    let session = &evaluation.session;
    let roles = [("train", &session.train), ("test", &session.test)];
    roles
        .into_iter()
        .flat_map(|(role, takes)| takes.iter().map(move |take| (role, take)))
        .map(|(role, take)| take_line(role, take, &evaluation.quality))
        .collect()
}

fn take_line(role: &str, take: &TakeFacts, quality: &[TakeQuality]) -> Line {
    // One take may serve for both roles, in different time ranges.
    let quality = quality
        .iter()
        .find(|q| q.take == take.name && q.role == role);
    let known = |text: fn(&TakeQuality) -> String| quality.map_or_else(|| NONE.to_owned(), text);
    Line {
        head: html! { (take.name) },
        cells: vec![
            role.to_owned(),
            decimals(take.duration_s, 1),
            count(take.samples, NARROW_SPACE),
            count(take.segments, NARROW_SPACE),
            count(take.left_out, NARROW_SPACE),
            known(|q| percent(q.hand_tracked)),
            known(|q| q.object_tracked.map_or_else(|| NONE.to_owned(), percent)),
            known(|q| count(q.warnings(), NARROW_SPACE)),
        ],
        best: Vec::new(),
        stressed: false,
    }
}

const GAP_COLUMNS: [Column<'static>; 8] = [
    words("take"),
    words("role"),
    words("finger"),
    numbers("missing", "samples"),
    numbers("missing", "%"),
    numbers("filled", "samples"),
    numbers("open", "samples"),
    numbers("longest gap", "s"),
];

/// A line for each track with a gap; a complete track needs none.
fn gap_lines(takes: &[TakeQuality]) -> Vec<Line> {
    takes
        .iter()
        .flat_map(|take| Finger::ALL.map(|finger| (take, finger)))
        .filter(|(take, finger)| {
            let track = &take.fingers[*finger];
            track.recorded.missing > 0 || track.processed.filled > 0 || track.processed.missing > 0
        })
        .map(|(take, finger)| {
            let TrackQuality {
                recorded,
                processed,
                longest_gap_s,
            } = take.fingers[finger];
            Line {
                head: html! { (take.take) },
                cells: vec![
                    take.role.clone(),
                    finger.name().to_owned(),
                    count(recorded.missing, NARROW_SPACE),
                    percent(recorded.missing as f64 / total(recorded) as f64),
                    count(processed.filled, NARROW_SPACE),
                    count(processed.missing, NARROW_SPACE),
                    decimals(longest_gap_s, 2),
                ],
                best: Vec::new(),
                stressed: false,
            }
        })
        .collect()
}

fn total(counts: TrackCounts) -> usize {
    counts.measured + counts.filled + counts.missing
}

fn findings(takes: &[TakeQuality]) -> Markup {
    let odd: Vec<&TakeQuality> = takes
        .iter()
        .filter(|take| !take.findings.is_empty())
        .collect();
    html! {
        h3 { "Findings" }
        @if odd.is_empty() {
            p { "Nothing odd was found in any take." }
        }
        @for take in odd {
            h4 { (take.take) span.faint { " (" (take.role) ")" } }
            @let (shown, folded) = take.findings.split_at(take.findings.len().min(FINDINGS_SHOWN));
            (finding_list(shown))
            @if !folded.is_empty() {
                details {
                    summary { (folded.len()) " more" }
                    (finding_list(folded))
                }
            }
        }
    }
}

fn finding_list(findings: &[Finding]) -> Markup {
    html! {
        ul.findings {
            @for finding in findings {
                li {
                    span.badge.(finding.severity.name()) { (finding.severity.name()) }
                    " " (finding)
                }
            }
        }
    }
}
