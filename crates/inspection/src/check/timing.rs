//! Rate, repeated frames, tracks that stand still to the last digit.

use std::ops::Range;

use inhand_model::{Recording, Sample, Track, runs};

use super::checkup::{CheckResult, Level};
use super::source_and_roles::finding_id;
use super::subject::Subject;
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
    let frames: usize = repeated.iter().map(Range::len).sum();
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
        let percent = percent(share);
        results.push(
            base(Level::Warn)
                .at(&clock, &repeated)
                .expected(format!("frames that differ, {stated_hz} Hz"))
                .found(format!(
                    "{percent} of frames repeat the one before: the data changes at about \
                     {changes_hz:.0} Hz, the file says {stated_hz} Hz"
                ))
                .advice("export at the rate of the capture")
                .number("changes_hz", changes_hz, steps),
        );
        return results;
    }
    if frames > 0 {
        let repeat = count(frames, ["frame repeats", "frames repeat"]);
        let when = times(&clock, &repeated);
        results.push(
            CheckResult::new("repeated-frames", Level::Warn, "")
                .at(&clock, &repeated)
                .expected("noise in every frame")
                .found(format!("{repeat} the one before to the last digit ({when})"))
                .advice("velocities there are wrong: see whether the capture dropped frames, or cut around them")
                .number("repeated_frames", frames as f64, steps),
        );
    }
    let jumped = (recording.findings.iter()).any(|f| finding_id(f) == "frame-jumps");
    let jumps = if jumped { "" } else { ", no jumps" };
    let duration_s = clock.time_s(n);
    results.push(base(Level::Ok).expected("as stated").found(format!(
        "rate {stated_hz:.2} Hz{jumps}, {n} samples ({duration_s:.2} s)"
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

/// Whether sample `k` equals the one before to the last bit; `None` where both are missing.
fn repeats<T: Sample + PartialEq>(track: &Track<T>, k: usize) -> Option<bool> {
    let (before, now) = (track.get(k - 1), track.get(k));
    (before.is_some() || now.is_some()).then(|| before == now)
}

/// Runs of frames in which everything that is present equals the frame before.
fn repeated_frames(recording: &Recording) -> Vec<Range<usize>> {
    runs(1..recording.len(), |k| {
        let markers = (recording.markers.iter()).filter_map(|m| repeats(&m.track, k));
        let bodies = (recording.bodies.iter()).filter_map(|b| repeats(&b.track, k));
        let mut present = markers.chain(bodies);
        present.next() == Some(true) && present.all(|repeats| repeats)
    })
}

/// Entities that report the very same numbers for longer than any camera does.
pub(crate) fn frozen(subject: &Subject<'_>) -> Vec<CheckResult> {
    let (recording, settings) = (subject.recording, subject.settings);
    let clock = recording.clock;
    let shortest = ((settings.frozen_s * clock.rate_hz()).ceil() as usize).max(MIN_FROZEN_SAMPLES);
    let repeated = repeated_frames(recording);
    let (mut results, mut others) = (Vec::new(), Vec::new());
    // A pose is looked at before the markers that its fit places.
    let bodies = (recording.bodies.iter()).map(|body| {
        (
            &body.name,
            true,
            frozen_runs(&body.track, &repeated, shortest),
        )
    });
    let markers = recording.markers.iter().map(|marker| {
        let found = frozen_runs(&marker.track, &repeated, shortest);
        (&marker.name, subject.plays_a_role(&marker.name), found)
    });
    for (name, matters, found) in bodies
        .chain(markers)
        .filter(|(.., found)| !found.is_empty())
    {
        if !matters {
            others.push(name.as_str());
            continue;
        }
        let longest_s = clock.time_s(found.iter().map(|range| range.len() + 1).max().unwrap_or(0));
        let intervals = count(found.len(), ["interval", "intervals"]);
        let when = times(&clock, &found);
        results.push(
            CheckResult::new("frozen", Level::Warn, name)
                .at(&clock, &found)
                .expected("noise in every sample")
                .found(format!(
                    "the very same numbers over {intervals} of up to {longest_s:.2} s ({when})"
                ))
                .advice(
                    "treat them as gaps: they were held or copied, or written with too few digits",
                )
                .number("longest_s", longest_s, recording.len())
                .number("stretches", found.len() as f64, recording.len()),
        );
    }
    if !others.is_empty() {
        let report = count(
            others.len(),
            ["other marker reports", "other markers report"],
        );
        let listed = names(others.iter().copied());
        let found = format!(
            "{report} the very same numbers for {:.2} s or more: {listed}",
            settings.frozen_s
        );
        results.push(
            CheckResult::new("frozen-other", Level::Info, "")
                .found(found)
                .number("markers", others.len() as f64, recording.markers.len()),
        );
    }
    results
}

/// Long runs of samples that equal the one before. What repeats with all else is a repeated frame, not a
/// frozen track.
fn frozen_runs<T: Sample + PartialEq>(
    track: &Track<T>,
    repeated_frames: &[Range<usize>],
    shortest: usize,
) -> Vec<Range<usize>> {
    let whole_frame = |k: usize| {
        let next = repeated_frames.partition_point(|range| range.end <= k);
        repeated_frames
            .get(next)
            .is_some_and(|range| range.contains(&k))
    };
    let mut found = runs(1..track.len(), |k| {
        repeats(track, k) == Some(true) && !whole_frame(k)
    });
    found.retain(|range| range.len() + 1 >= shortest);
    found
}
