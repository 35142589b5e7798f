//! Data quality of each take.

use inhand_model::{Evaluation, Finding, Finger, TakeFacts, TakeQuality, TrackQuality};
use maud::{Markup, html};

use super::session::finding_list;
use super::{Body, processing};
use crate::Report;
use crate::table::{Table, known};
use crate::took::{missing, session_facts};
use crate::verdict::inspection_sentence;
use crate::words::{count, percent, tied};

/// Findings of one take that are shown before they fold away.
const FINDINGS_SHOWN: usize = 6;

/// The section's content.
pub(super) fn section(report: &Report<'_>) -> Body {
    let evaluation = report.evaluation;
    let gaps = gaps(&evaluation.quality);
    let tracks = evaluation.quality.len() * Finger::COUNT;
    let facts = html! {
        dl.took {
            @for (label, lines) in session_facts(&evaluation.session) {
                dt { (label) }
                @for line in lines { dd { (tied(&line)) } }
            }
        }
    };
    let takes_note = html! {
        p.note {
            "Left out: segments that a take without gaps would have given in addition; what is missing in most of their samples \
             has the gaps. Tracked: share of samples in which \
             the hand's or object's pose is known."
        }
    };
    let takes = Body::from(facts).prose(takes(evaluation)).prose(takes_note);
    let sentence = match gaps.len() {
        0 if tracks == 0 => "The gaps of the takes are not known.".to_owned(),
        0 => "No fingertip is missing at any sample of any take.".to_owned(),
        n if n == tracks => "Every fingertip has gaps in every take.".to_owned(),
        n => format!("{n} of {tracks} fingertip tracks have gaps; the others are complete."),
    };
    let illustrations = report.illustrations;
    let body = Body::from(html! { p { (sentence) } })
        .append(illustrations.map(|all| processing::gaps(&all.gaps)))
        .folded("Format, roles, takes and segments", takes);
    body.folded(
        "Gaps of each fingertip",
        (!gaps.is_empty()).then(|| gap_part(gaps)),
    )
    .folded("Findings and checks", Body::from(findings(evaluation)))
    .folded(
        "The filter: before and after, spectrum",
        illustrations.map(processing::filter),
    )
}

fn gap_part(gaps: Vec<Track<'_>>) -> Body {
    Body::default().prose(gap_table(gaps)).prose(html! {
        p.note {
            "Missing: samples without a measurement, as recorded. Filled: short gaps closed by interpolation, marked as such in \
             every later step. Open: still missing after processing; segments that touch them are left out of all statistics."
        }
    })
}

/// A take with its role and its quality.
type Take<'a> = (&'static str, &'a TakeFacts, Option<&'a TakeQuality>);

fn takes(evaluation: &Evaluation) -> Table<Take<'_>> {
    let session = &evaluation.session;
    // One take may serve for both roles, in different time ranges.
    let quality = |role: &str, take: &TakeFacts| {
        let mut all = evaluation.quality.iter();
        all.find(|q| q.take == take.name && q.role == role)
    };
    let roles = [("train", &session.train), ("test", &session.test)];
    let takes = roles.into_iter().flat_map(|(role, takes)| {
        takes
            .iter()
            .map(move |take| (role, take, quality(role, take)))
    });
    Table::new("Takes", takes, "take", |(_, take, _)| take.name.clone())
        .words("role", |(role, ..)| (*role).to_owned())
        .decimals("length", "s", 1, |(_, take, _)| take.duration_s)
        .counts("samples", "", |(_, take, _)| take.samples)
        .counts("segments", "", |(_, take, _)| take.segments)
        .counts("left out", "", |(_, take, _)| take.left_out)
        .words("gaps in", |(_, take, _)| missing(&[take]))
        .numbers("hand tracked", "%", |(.., q)| {
            known(q.map(|q| percent(q.hand_tracked)))
        })
        .numbers("object tracked", "%", |(.., q)| {
            known(q.and_then(|q| q.object_tracked).map(percent))
        })
        .numbers("warnings", "", |(.., q)| {
            known(q.map(|q| count(q.warnings())))
        })
}

/// A fingertip of a take.
type Track<'a> = (&'a TakeQuality, Finger, &'a TrackQuality);

/// The tracks with a gap; a complete track needs no line.
fn gaps(takes: &[TakeQuality]) -> Vec<Track<'_>> {
    let tracks = takes.iter().flat_map(|take| {
        take.fingers
            .iter()
            .map(move |(finger, track)| (take, finger, track))
    });
    let gap = |track: &TrackQuality| {
        track.recorded.missing > 0 || track.processed.filled > 0 || track.processed.missing > 0
    };
    tracks.filter(|(.., track)| gap(track)).collect()
}

fn gap_table(gaps: Vec<Track<'_>>) -> Table<Track<'_>> {
    Table::new("Gaps of the fingertips", gaps, "take", |(take, ..)| {
        take.take.clone()
    })
    .words("role", |(take, ..)| take.role.clone())
    .words("finger", |(_, finger, _)| finger.name().to_owned())
    .counts("missing", "samples", |(.., track)| track.recorded.missing)
    .percents("missing", "%", |(.., track)| {
        let recorded = track.recorded;
        let all = recorded.measured + recorded.filled + recorded.missing;
        recorded.missing as f64 / all as f64
    })
    .counts("filled", "samples", |(.., track)| track.processed.filled)
    .counts("open", "samples", |(.., track)| track.processed.missing)
    .decimals("longest gap", "s", 2, |(.., track)| track.longest_gap_s)
}

fn findings(evaluation: &Evaluation) -> Markup {
    let takes = &evaluation.quality;
    let odd = || takes.iter().filter(|take| !take.findings.is_empty());
    html! {
        @if !takes.is_empty() {
            @if odd().next().is_none() { p { "The reader of the takes found nothing." } }
            @if let Some(inspection) = &evaluation.inspection {
                @if let Some(sentence) = inspection_sentence(inspection) {
                    p { (sentence) " They are: " (inspection.passed().join(", ")) "." }
                }
                (finding_list(inspection.findings.iter()))
            } @else { p { "Content of the takes and settings were not inspected." } }
        }
        @for take in odd() {
            h4 { (take.take) span.faint { " (" (take.role) ")" } }
            @let (shown, folded) = take.findings.split_at(take.findings.len().min(FINDINGS_SHOWN));
            (reader_findings(shown))
            @if !folded.is_empty() {
                details {
                    summary { (folded.len()) " more" }
                    (reader_findings(folded))
                }
            }
        }
    }
}

fn reader_findings(findings: &[Finding]) -> Markup {
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
