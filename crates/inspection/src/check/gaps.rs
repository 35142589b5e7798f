//! Gaps of what matters, and of the rest in a line.

use std::ops::Range;

use inhand_model::{MarkerKind, Recording, Sample, Track};

use super::checkup::{CheckResult, Level};
use super::parts::Parts;
use super::settings::CheckSettings;
use super::words::{count, names, percent, times};

/// Gaps of fingertips, hand and object; of everything that is tracked where these cannot be told.
pub(crate) fn gaps(
    recording: &Recording,
    parts: &Parts<'_>,
    settings: &CheckSettings,
) -> Vec<CheckResult> {
    let limit = Limit {
        samples: (settings.process.max_gap_s * recording.clock.rate_hz() + 1e-6) as usize,
        settings,
    };
    let mut results = Vec::new();
    let mut complete = 0;
    let mut add = |name: &str, gaps: &[Range<usize>]| {
        let result = of_entity(recording, name, gaps, &limit);
        complete += usize::from(result.is_none());
        results.extend(result);
    };
    if parts.is_known() {
        for (finger, track) in &parts.fingertips {
            add(finger.name(), &track.gaps());
        }
        for (role, track) in parts.bodies() {
            add(role, &track.gaps());
        }
    } else {
        for body in &recording.bodies {
            add(&body.name, &body.track.gaps());
        }
    }
    let looked_at = results.len() + complete;
    if complete > 0 && complete == looked_at {
        let what = if parts.is_known() {
            "fingertips, hand and object"
        } else {
            "bodies"
        };
        results.push(
            CheckResult::new("gaps", Level::Ok, "")
                .expected("none")
                .found(format!("no gaps in {what}"))
                .number("looked_at", looked_at as f64, recording.len()),
        );
    }
    results.extend(others(recording, parts));
    results.extend(unlabelled(recording));
    results.extend(never_seen(recording, parts));
    results
}

struct Limit<'a> {
    /// Missing samples in the longest gap that is filled.
    samples: usize,
    settings: &'a CheckSettings,
}

fn of_entity(
    recording: &Recording,
    name: &str,
    gaps: &[Range<usize>],
    limit: &Limit<'_>,
) -> Option<CheckResult> {
    let (clock, n) = (recording.clock, recording.len());
    let max_gap_s = limit.settings.process.max_gap_s;
    let missing: usize = gaps.iter().map(ExactSizeIterator::len).sum();
    let longest = gaps.iter().map(ExactSizeIterator::len).max()?;
    let share = missing as f64 / n as f64;
    let open: Vec<_> = gaps
        .iter()
        .filter(|gap| gap.len() > limit.samples)
        .cloned()
        .collect();
    let base = |level, places: &[Range<usize>]| {
        CheckResult::new("gaps", level, name)
            .at(&clock, places)
            .expected(format!(
                "gaps of at most {max_gap_s:.2} s, which are filled"
            ))
            .number("gaps", gaps.len() as f64, n)
            .number("missing_share", share, n)
            .number("longest_s", clock.time_s(longest), gaps.len())
            .number("open", open.len() as f64, gaps.len())
    };
    if missing == n {
        return Some(
            CheckResult::new("never-seen", Level::Fail, name)
                .expected("samples")
                .found("never seen in the whole take")
                .advice("label it in the capture software, or name another marker or body")
                .number("missing_share", 1.0, n),
        );
    }
    if share >= limit.settings.useless_share {
        return Some(
            base(Level::Fail, &open)
                .found(format!(
                    "missing in {} of the take ({}, longest {:.2} s)",
                    percent(share),
                    count(gaps.len(), ["gap", "gaps"]),
                    clock.time_s(longest)
                ))
                .advice("label it in the capture software, or record the take again"),
        );
    }
    if open.is_empty() {
        return Some(base(Level::Info, gaps).found(format!(
            "{}, {} of the take, the longest {:.2} s: short enough to be filled",
            count(gaps.len(), ["gap", "gaps"]),
            percent(share),
            clock.time_s(longest)
        )));
    }
    let stays = if open.len() == 1 { "stays" } else { "stay" };
    Some(
        base(Level::Warn, &open)
            .found(format!(
                "{} longer than {max_gap_s:.2} s ({}) {stays} open; {} missing in all, longest {:.2} s",
                count(open.len(), ["gap", "gaps"]),
                times(&clock, &open),
                percent(share),
                clock.time_s(longest),
            ))
            .advice("no segment crosses an open gap: fill them in the capture software, or live with fewer segments"),
    )
}

/// Markers that have no role, in one line.
fn others(recording: &Recording, parts: &Parts<'_>) -> Option<CheckResult> {
    let n = recording.len();
    let labelled = recording
        .markers
        .iter()
        .filter(|m| m.kind == MarkerKind::Labelled);
    let mut with_gaps: Vec<(usize, &str)> = labelled
        .filter(|marker| !parts.has_marker(&marker.name))
        .map(|marker| (missing(&marker.track), marker.name.as_str()))
        .filter(|&(missing, _)| missing > 0 && missing < n)
        .collect();
    with_gaps.sort_by_key(|&(missing, _)| std::cmp::Reverse(missing));
    let worst = with_gaps.first()?.0 as f64 / n as f64;
    let listed: Vec<_> = (with_gaps.iter())
        .map(|&(missing, name)| format!("{name} {}", percent(missing as f64 / n as f64)))
        .collect();
    Some(
        CheckResult::new("gaps-other", Level::Info, "")
            .found(format!(
                "{} gaps: {}",
                count(with_gaps.len(), ["other marker has", "other markers have"]),
                names(listed.iter().map(String::as_str))
            ))
            .number("markers", with_gaps.len() as f64, recording.markers.len())
            .number("worst_missing_share", worst, n),
    )
}

/// Unlabelled markers, in one line.
fn unlabelled(recording: &Recording) -> Option<CheckResult> {
    let n = recording.len();
    let all: Vec<_> = (recording.markers.iter())
        .filter(|m| m.kind == MarkerKind::Unlabelled && missing(&m.track) < n)
        .collect();
    if all.is_empty() {
        return None;
    }
    let seen: usize = all.iter().map(|m| n - missing(&m.track)).sum();
    Some(
        CheckResult::new("unlabelled", Level::Info, "")
            .found(format!(
                "{}, {:.1} at a time on average",
                count(all.len(), ["unlabelled marker", "unlabelled markers"]),
                seen as f64 / n as f64
            ))
            .number("markers", all.len() as f64, recording.markers.len())
            .number("at_a_time", seen as f64 / n as f64, n),
    )
}

/// Entities without a role that have no sample at all.
fn never_seen(recording: &Recording, parts: &Parts<'_>) -> Option<CheckResult> {
    let n = recording.len();
    let markers = (recording.markers.iter())
        .filter(|m| m.kind != MarkerKind::Unlabelled && missing(&m.track) == n)
        .map(|m| m.name.as_str());
    let bodies = (recording.bodies.iter())
        // Without roles each body has its own result.
        .filter(|b| parts.is_known() && missing(&b.track) == n)
        .map(|b| b.name.as_str());
    let mut never: Vec<_> = markers
        .chain(bodies)
        .filter(|name| !parts.has_marker(name))
        .collect();
    never.dedup();
    if never.is_empty() {
        return None;
    }
    Some(
        CheckResult::new("never-seen", Level::Info, "")
            .found(format!(
                "{} never seen: {}",
                count(never.len(), ["other entity is", "other entities are"]),
                names(never.iter().copied())
            ))
            .number(
                "entities",
                never.len() as f64,
                recording.markers.len() + recording.bodies.len(),
            ),
    )
}

fn missing<T: Sample>(track: &Track<T>) -> usize {
    track.counts().missing
}
