//! Gaps of what matters, and of the rest in a line.

use std::ops::Range;

use inhand_model::{MarkerKind, Sample, Setting, Track};

use super::checkup::{CheckResult, Level};
use super::subject::Subject;
use super::words::{count, names, percent, times};

/// Gaps of fingertips, hand and object; of all bodies without roles.
pub(crate) fn gaps(subject: &Subject<'_>) -> Vec<CheckResult> {
    let samples = subject.recording.len();
    let mut looked_at: Vec<(&str, Vec<Range<usize>>)> = Vec::new();
    if subject.has_roles() {
        let fingertips = subject.fingertips.iter();
        looked_at.extend(fingertips.map(|(finger, track)| (finger.name(), track.gaps())));
        looked_at.extend(
            subject
                .bodies()
                .map(|(role, track)| (role.name(), track.gaps())),
        );
    } else {
        let bodies = subject.recording.bodies.iter();
        looked_at.extend(bodies.map(|body| (body.name.as_str(), body.track.gaps())));
    }
    let mut results: Vec<CheckResult> = (looked_at.iter())
        .filter_map(|(name, gaps)| of_entity(subject, name, gaps))
        .collect();
    if results.is_empty() && !looked_at.is_empty() {
        let what = if subject.has_roles() {
            "fingertips, hand and object"
        } else {
            "bodies"
        };
        results.push(
            CheckResult::new("gaps", Level::Ok, "")
                .expected("none")
                .found(format!("no gaps in {what}"))
                .number("looked_at", looked_at.len() as f64, samples),
        );
    }
    results.extend(
        [others(subject), unlabelled(subject), never_seen(subject)]
            .into_iter()
            .flatten(),
    );
    results
}

fn of_entity(subject: &Subject<'_>, name: &str, gaps: &[Range<usize>]) -> Option<CheckResult> {
    let (clock, n) = (subject.recording.clock, subject.recording.len());
    let max_gap_s = subject.settings.process.max_gap_s;
    let longest_filled = (max_gap_s * clock.rate_hz() + 1e-6) as usize;
    let missing: usize = gaps.iter().map(Range::len).sum();
    let longest_s = clock.time_s(gaps.iter().map(Range::len).max()?);
    let share = missing as f64 / n as f64;
    if missing == n {
        return Some(
            CheckResult::new("never-seen", Level::Fail, name)
                .expected("samples")
                .found("never seen in the whole take")
                .advice("label it in the capture software, or name another marker or body")
                .number("missing_share", 1.0, n),
        );
    }
    let open: Vec<_> = gaps
        .iter()
        .filter(|gap| gap.len() > longest_filled)
        .cloned()
        .collect();
    let result = |level, places: &[Range<usize>], found: String| {
        CheckResult::new("gaps", level, name)
            .at(&clock, places)
            .expected(format!(
                "gaps of at most {max_gap_s:.2} s, which are filled"
            ))
            .found(found)
            .number("gaps", gaps.len() as f64, n)
            .number("missing_share", share, n)
            .number("longest_s", longest_s, gaps.len())
            .number("open", open.len() as f64, gaps.len())
    };
    let percent = percent(share);
    let all = count(gaps.len(), ["gap", "gaps"]);
    if share >= subject.settings.useless_share {
        let found = format!("missing in {percent} of the take ({all}, longest {longest_s:.2} s)");
        let advice = "label it in the capture software, or record the take again";
        return Some(result(Level::Fail, &open, found).advice(advice));
    }
    if open.is_empty() {
        let found = format!(
            "{all}, {percent} of the take, the longest {longest_s:.2} s: short enough to be filled"
        );
        return Some(result(Level::Info, gaps, found));
    }
    let stays = if open.len() == 1 { "stays" } else { "stay" };
    let when = times(&clock, &open);
    let long = count(open.len(), ["gap", "gaps"]);
    let found = format!(
        "{long} longer than {max_gap_s:.2} s ({when}) {stays} open; {percent} missing in all, \
         longest {longest_s:.2} s"
    );
    let advice = format!(
        "no segment crosses an open gap: fill them in the capture software or with `inhand clean --fill`, or fill \
         longer ones with {}",
        Setting::MaxGap
    );
    Some(result(Level::Warn, &open, found).advice(advice))
}

/// Markers that have no role, in one line.
fn others(subject: &Subject<'_>) -> Option<CheckResult> {
    let markers = &subject.recording.markers;
    let n = subject.recording.len();
    let mut with_gaps: Vec<(usize, &str)> = (markers.iter())
        .filter(|m| m.kind == MarkerKind::Labelled && !subject.plays_a_role(&m.name))
        .map(|marker| (missing(&marker.track), marker.name.as_str()))
        .filter(|&(missing, _)| missing > 0 && missing < n)
        .collect();
    with_gaps.sort_by_key(|&(missing, _)| std::cmp::Reverse(missing));
    let share = |missing: usize| missing as f64 / n as f64;
    let worst = share(with_gaps.first()?.0);
    let listed: Vec<_> = (with_gaps.iter())
        .map(|&(missing, name)| format!("{name} {}", percent(share(missing))))
        .collect();
    let listed = names(listed.iter().map(String::as_str));
    let have = count(with_gaps.len(), ["other marker has", "other markers have"]);
    Some(
        CheckResult::new("gaps-other", Level::Info, "")
            .found(format!("{have} gaps: {listed}"))
            .number("markers", with_gaps.len() as f64, markers.len())
            .number("worst_missing_share", worst, n),
    )
}

/// Unlabelled markers, in one line.
fn unlabelled(subject: &Subject<'_>) -> Option<CheckResult> {
    let markers = &subject.recording.markers;
    let n = subject.recording.len();
    let seen: Vec<usize> = (markers.iter())
        .filter(|m| m.kind == MarkerKind::Unlabelled)
        .map(|m| n - missing(&m.track))
        .filter(|&seen| seen > 0)
        .collect();
    let at_a_time = seen.iter().sum::<usize>() as f64 / n as f64;
    let all = count(seen.len(), ["unlabelled marker", "unlabelled markers"]);
    (!seen.is_empty()).then(|| {
        CheckResult::new("unlabelled", Level::Info, "")
            .found(format!("{all}, {at_a_time:.1} at a time on average"))
            .number("markers", seen.len() as f64, markers.len())
            .number("at_a_time", at_a_time, n)
    })
}

/// Entities without a role that have no sample at all.
fn never_seen(subject: &Subject<'_>) -> Option<CheckResult> {
    let recording = subject.recording;
    let n = recording.len();
    let markers = (recording.markers.iter())
        .filter(|m| m.kind != MarkerKind::Unlabelled && missing(&m.track) == n)
        .map(|m| m.name.as_str());
    let bodies = (recording.bodies.iter())
        // Without roles each body has its own result.
        .filter(|b| subject.has_roles() && missing(&b.track) == n)
        .map(|b| b.name.as_str());
    let mut never: Vec<_> = markers
        .chain(bodies)
        .filter(|name| !subject.plays_a_role(name))
        .collect();
    never.dedup();
    let are = count(never.len(), ["other entity is", "other entities are"]);
    let entities = recording.markers.len() + recording.bodies.len();
    (!never.is_empty()).then(|| {
        CheckResult::new("never-seen", Level::Info, "")
            .found(format!(
                "{are} never seen: {}",
                names(never.iter().copied())
            ))
            .number("entities", never.len() as f64, entities)
    })
}

fn missing<T: Sample>(track: &Track<T>) -> usize {
    track.counts().missing
}
