//! Content checks of takes: gaps, bodies, units and axes against what the data says.

mod bodies;
mod checkup;
mod convention;
mod gaps;
mod hand;
mod json;
mod markdown;
mod numbers;
mod origin;
mod parts;
mod rank;
mod settings;
mod suspicion;
mod text;
mod timing;
mod up;
mod words;

use inhand_model::{Motion, Recording, Roles, SegmentLayout, Setting};
use inhand_motion::{Cut, SegmentSettings, SegmentTable, to_hand_frame};

use self::parts::Parts;
use self::suspicion::suspected;
use self::words::percent;

pub use checkup::{CheckResult, Checkup, Level, MAX_PLACES, Number, Place, SegmentShare};
pub use json::to_json;
pub use markdown::to_markdown;
pub use rank::{Checked, ranked};
pub use settings::CheckSettings;
pub use suspicion::{Suspicion, SuspicionKind};
pub use text::to_text;

/// Looks at everything that a take tells of itself.
///
/// `roles` say which marker is on which finger, or in words why that cannot be told; then what needs
/// no roles is still looked at. `suspicions` are those of other detectors, which become results
/// beside the others. The take is not changed and a check cannot fail: what goes wrong is a result.
pub fn check(
    recording: &Recording,
    roles: Result<&Roles, &str>,
    suspicions: &[Suspicion],
    settings: &CheckSettings,
) -> Checkup {
    let mut results = origin::findings(recording);
    let mut parts = Parts::default();
    let mut motion = None;
    match roles {
        Ok(roles) => match Parts::of(recording, roles) {
            Ok(found) => {
                match to_hand_frame(recording, roles, &found.templates, &settings.process) {
                    Ok(in_hand) => motion = Some(in_hand),
                    Err(error) => results.push(unusable(&error.to_string())),
                }
                parts = found;
            }
            Err(error) => results.push(unusable(&error.to_string())),
        },
        Err(why) => results.push(origin::roles_open(why)),
    }
    results.extend(timing::rate(recording));
    results.extend(timing::frozen(recording, settings, |name| {
        parts.has_marker(name)
    }));
    results.extend(origin::duplicate_names(recording, &parts));
    // What would be a wrong number comes before what is only missing.
    results.extend(suspected(&recording.clock, suspicions));
    results.extend(gaps::gaps(recording, &parts, settings));
    results.extend(bodies::bodies(recording, &parts, settings));
    without_flips_said_twice(&mut results, suspicions);
    results.extend(convention::convention(recording));
    results.extend(up::up_axis(recording, &parts));
    match &motion {
        Some(motion) => results.extend(hand::hand_size(recording, motion, settings)),
        None => results.extend(hand::volume(recording)),
    }
    let segments = motion.map(|motion| segments(&motion, settings));
    results.extend(
        segments
            .as_ref()
            .map(|found| segment_result(*found, recording, settings)),
    );
    // Stable: results of one level stay in the order above.
    results.sort_by_key(|result| std::cmp::Reverse(result.level));
    Checkup {
        take: recording.name.clone(),
        format: recording.source.format.clone(),
        samples: recording.len(),
        rate_hz: recording.clock.rate_hz(),
        duration_s: recording.clock.time_s(recording.len()),
        segments,
        results,
    }
}

fn unusable(why: &str) -> CheckResult {
    CheckResult::new("roles", Level::Fail, "")
        .expected("a hand whose pose can be told")
        .found(origin::what_and_what_there_is(why))
        .advice(format!(
            "name another body or other markers with {} and {}",
            Setting::Hand,
            Setting::Object
        ))
}

/// A flip that a detector has found need not be said once more as a jump of the orientation.
fn without_flips_said_twice(results: &mut Vec<CheckResult>, suspicions: &[Suspicion]) {
    let flips = |entity: &str| {
        let flips = suspicions.iter().filter(|s| s.kind == SuspicionKind::Flip);
        flips.filter(|s| s.entity == entity).count()
    };
    // A flip goes there and back: two jumps.
    results.retain(|result| {
        let jumps = result.numbers.iter().find(|number| number.name == "jumps");
        let explained =
            jumps.is_some_and(|number| number.value <= 2.0 * flips(&result.entity) as f64);
        !(result.id == "orientation" && result.level == Level::Warn && explained)
    });
}

/// Segments of a second, one after the other, as a test take is cut.
fn segments(motion: &Motion, settings: &CheckSettings) -> SegmentShare {
    let layout = SegmentLayout::one_second(motion.clock.rate_hz());
    let cut = Cut::new(&SegmentSettings {
        layout,
        stride: layout.samples,
        margin_s: settings.margin_s,
        missing_s: settings.missing_s,
    });
    // A rate so low that a second has no two samples gives no segment.
    let Ok(cut) = cut else {
        return SegmentShare {
            usable: 0,
            possible: 0,
        };
    };
    SegmentShare {
        usable: cut.starts(&SegmentTable::of(motion)).starts.len(),
        possible: cut.without_gaps(motion.len(), None),
    }
}

fn segment_result(
    segments: SegmentShare,
    recording: &Recording,
    settings: &CheckSettings,
) -> CheckResult {
    let SegmentShare { usable, possible } = segments;
    let base = |level| {
        CheckResult::new("segments", level, "")
            .expected(format!("{} of them usable", percent(settings.usable_share)))
            .number("usable", usable as f64, possible)
            .number("possible", possible as f64, recording.len())
            .number("usable_share", segments.share(), possible)
    };
    if possible == 0 {
        let duration_s = recording.clock.time_s(recording.len());
        return base(Level::Fail)
            .expected("a second and what end velocities are taken over")
            .found(format!("{duration_s:.2} s are too short for a segment"))
            .advice("record longer takes");
    }
    let found = format!("{usable} of {possible} segments are usable");
    if usable == 0 {
        return base(Level::Fail)
            .found(found)
            .advice("gaps leave no whole second: see the gaps above");
    }
    if segments.share() < settings.usable_share {
        return base(Level::Warn)
            .found(found)
            .advice("gaps cut the others: see the gaps above");
    }
    base(Level::Ok).found(found)
}
