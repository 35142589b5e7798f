//! Rate, frames that repeat, tracks that stand still to the last digit.

use std::ops::Range;

use inhand_model::Recording;
use inhand_statistics::runs;

use super::checkup::{CheckResult, Level};
use super::origin::finding_id;
use super::settings::CheckSettings;
use super::words::{count, names, percent, times};

/// Share of repeated frames from which the rate itself is in doubt: a file exported at twice the
/// rate of its data repeats every other frame.
const RATE_IN_DOUBT: f64 = 0.2;

/// Fewest steps between frames that say something about the rate.
const MIN_STEPS: usize = 20;

/// Shortest run of equal samples that counts as frozen, whatever the rate.
const MIN_FROZEN_SAMPLES: usize = 5;

/// Rate stated against the rate at which the data changes, and repeated frames.
pub(crate) fn rate(recording: &Recording) -> Vec<CheckResult> {
    let (clock, n) = (recording.clock, recording.len());
    let stated_hz = clock.rate_hz();
    let repeated = repeated_frames(recording);
    let frames: usize = repeated.iter().map(ExactSizeIterator::len).sum();
    let steps = n.saturating_sub(1);
    let share = frames as f64 / steps.max(1) as f64;
    let base = |level| {
        CheckResult::new("rate", level, "")
            .number("stated_hz", stated_hz, n)
            .number("repeated_frames", frames as f64, steps)
    };
    let mut results = Vec::new();
    if let Some(capture_hz) = exported_below(recording) {
        results.push(
            CheckResult::new("exported-rate", Level::Info, "")
                .found(format!(
                    "exported at {stated_hz} Hz, captured at {capture_hz} Hz"
                ))
                .number("capture_hz", capture_hz, 1),
        );
    }
    if steps >= MIN_STEPS && share >= RATE_IN_DOUBT {
        let changes_hz = stated_hz * (1.0 - share);
        results.push(
            base(Level::Warn)
                .at(&clock, &repeated)
                .expected(format!("frames that differ, {stated_hz} Hz"))
                .found(format!(
                    "{} of frames repeat the one before: the data changes at about {changes_hz:.0} \
                     Hz, the file says {stated_hz} Hz",
                    percent(share)
                ))
                .advice("export at the rate of the capture")
                .number("changes_hz", changes_hz, steps),
        );
        return results;
    }
    if frames > 0 {
        results.push(
            CheckResult::new("repeated-frames", Level::Warn, "")
                .at(&clock, &repeated)
                .expected("noise in every frame")
                .found(format!(
                    "{} the one before to the last digit ({})",
                    count(frames, ["frame repeats", "frames repeat"]),
                    times(&clock, &repeated)
                ))
                .advice("velocities there are wrong: see whether the capture dropped frames, or cut around them")
                .number("repeated_frames", frames as f64, steps),
        );
    }
    let jumped = (recording.findings.iter()).any(|f| finding_id(f) == "frame-jumps");
    let jumps = if jumped { "" } else { ", no jumps" };
    results.push(base(Level::Ok).expected("as stated").found(format!(
        "rate {stated_hz:.2} Hz{jumps}, {n} samples ({:.2} s)",
        clock.time_s(n)
    )));
    results
}

/// The rate of the capture, where the header says that the export has another.
fn exported_below(recording: &Recording) -> Option<f64> {
    let fact = |key: &str| recording.source.header.get(key)?.trim().parse::<f64>().ok();
    let capture_hz = fact("Capture Frame Rate").or_else(|| fact("DataRate"))?;
    let rate_hz = recording.clock.rate_hz();
    (capture_hz.is_finite() && (capture_hz - rate_hz).abs() > 1e-3 * rate_hz).then_some(capture_hz)
}

/// Runs of frames in which everything that is present equals the frame before, to the last bit.
fn repeated_frames(recording: &Recording) -> Vec<Range<usize>> {
    let repeats = |k: usize| {
        let mut present = false;
        for marker in &recording.markers {
            match (marker.track.get(k - 1), marker.track.get(k)) {
                (None, None) => {}
                (Some(before), Some(now)) if before == now => present = true,
                _ => return false,
            }
        }
        for body in &recording.bodies {
            match (body.track.get(k - 1), body.track.get(k)) {
                (None, None) => {}
                (Some(before), Some(now)) if before == now => present = true,
                _ => return false,
            }
        }
        present
    };
    runs(1..recording.len(), repeats)
}

/// Entities that report the very same numbers for longer than any camera does.
pub(crate) fn frozen(
    recording: &Recording,
    settings: &CheckSettings,
    matters: impl Fn(&str) -> bool,
) -> Vec<CheckResult> {
    let clock = recording.clock;
    let n = recording.len();
    let repeated = repeated_frames(recording);
    let whole_frame = |k: usize| {
        let next = repeated.partition_point(|range| range.end <= k);
        repeated.get(next).is_some_and(|range| range.contains(&k))
    };
    let shortest = ((settings.frozen_s * clock.rate_hz()).ceil() as usize).max(MIN_FROZEN_SAMPLES);
    // What repeats with all else is a repeated frame, not a frozen track; and a pose is looked at
    // before the markers that its fit places.
    let find = |equal: &dyn Fn(usize) -> bool| -> Vec<Range<usize>> {
        let mut found = runs(1..n, |k| equal(k) && !whole_frame(k));
        found.retain(|range| range.len() + 1 >= shortest);
        found
    };
    let mut results = Vec::new();
    let mut others: Vec<(&str, usize)> = Vec::new();
    let mut add = |name: &'_ str, found: &[Range<usize>]| {
        let longest = found.iter().map(|range| range.len() + 1).max().unwrap_or(0);
        results.push(
            CheckResult::new("frozen", Level::Warn, name)
                .at(&clock, found)
                .expected("noise in every sample")
                .found(format!(
                    "the very same numbers over {} of up to {:.2} s ({})",
                    count(found.len(), ["stretch", "stretches"]),
                    clock.time_s(longest),
                    times(&clock, found)
                ))
                .advice(
                    "treat them as gaps: they were held or copied, or written with too few digits",
                )
                .number("longest_s", clock.time_s(longest), n)
                .number("stretches", found.len() as f64, n),
        );
    };
    for body in &recording.bodies {
        let same = |k: usize| {
            let both = body.track.get(k - 1).zip(body.track.get(k));
            both.is_some_and(|(before, now)| before == now)
        };
        let found = find(&same);
        if !found.is_empty() {
            add(&body.name, &found);
        }
    }
    for marker in &recording.markers {
        let same = |k: usize| {
            let both = marker.track.get(k - 1).zip(marker.track.get(k));
            both.is_some_and(|(before, now)| before == now)
        };
        let found = find(&same);
        if found.is_empty() {
            continue;
        }
        if matters(&marker.name) {
            add(&marker.name, &found);
        } else {
            others.push((&marker.name, found.len()));
        }
    }
    if !others.is_empty() {
        results.push(
            CheckResult::new("frozen-other", Level::Info, "")
                .found(format!(
                    "{} the very same numbers for {:.2} s or more: {}",
                    count(
                        others.len(),
                        ["other marker reports", "other markers report"]
                    ),
                    settings.frozen_s,
                    names(others.iter().map(|(name, _)| *name))
                ))
                .number("markers", others.len() as f64, recording.markers.len()),
        );
    }
    results
}
