//! Content checks of takes: gaps, bodies, units and axes against what the data says.

mod bodies;
mod checkup;
mod convention;
mod gaps;
mod hand_size;
mod output;
mod source_and_roles;
mod subject;
mod timing;
mod up;
pub(crate) mod words;

use std::ops::Range;

use inhand_model::{Clock, Motion, Recording, Roles, SegmentLayout, Setting};
use inhand_motion::{
    Cut, EndsRule, Filter, GapFill, ProcessSettings, SegmentSettings, SegmentTable, to_hand_frame,
};

use self::subject::Subject;
use self::words::{count, percent, times};
use crate::suspect::{Suspect, SuspectKind};

pub(crate) use convention::rotation_by_fingertips;

pub use checkup::*;
pub use output::{Checked, ranked, to_json, to_markdown, to_text};
pub use source_and_roles::{CUT_SHORT, is_cut_short};

/// Limits of a check.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckSettings {
    /// How the take would be processed: its longest gap filled says which gaps stay open.
    pub process: ProcessSettings,
    /// Time kept free at both ends of an interval when it is cut, seconds.
    pub margin_s: f64,
    /// How much of a segment may be missing, seconds.
    pub missing_s: f64,
    /// Share of samples missing from which a finger, the hand or the object is useless.
    pub useless_share: f64,
    /// Share of usable segments below which a take is worth a look.
    pub usable_share: f64,
    /// Shortest time for which a marker that reports the very same numbers counts as frozen, seconds.
    pub frozen_s: f64,
    /// Mean marker error of a body (median over the take) above which its fit is doubtful, metres.
    pub marker_error_m: f64,
    /// Change of distance between markers of one rigid body (95 % of samples) above which it is not
    /// rigid, metres...
    pub rigid_m: f64,
    /// ...and the same relative to the distance; the larger one counts.
    pub rigid_share: f64,
    /// Change of the median distance between two of its markers over the take, metres, above which
    /// it counts as drift.
    pub drift_m: f64,
    /// Shortest and longest plausible distance from the body on the back of the hand to the
    /// furthest fingertip (median over the take), metres.
    pub hand_reach_m: [f64; 2],
    /// Speed of rotation that no hand and no held object has, rad/s.
    pub turn_rad_s: f64,
}

impl Default for CheckSettings {
    /// Gaps up to 0.1 s are filled and 40 ms are kept free, as in the method. Hands of adults reach
    /// 7 to 18 cm from the back of the hand to the furthest fingertip, from closed to stretched; the
    /// limits leave room for children, for bodies worn at the wrist and for odd postures.
    fn default() -> Self {
        Self {
            process: ProcessSettings {
                max_gap_s: 0.1,
                fill: GapFill::Cubic,
                filter: Filter::None,
                object_offset_m: [0.0; 3],
            },
            margin_s: 0.04,
            missing_s: 0.0,
            useless_share: 0.5,
            usable_share: 0.9,
            frozen_s: 0.1,
            marker_error_m: 1e-3,
            rigid_m: 2e-3,
            rigid_share: 0.03,
            drift_m: 1e-3,
            hand_reach_m: [0.055, 0.26],
            turn_rad_s: 60.0,
        }
    }
}

/// Compares what a take's header states with what its data says.
///
/// `roles` say which marker is on which finger, or in words why that is not known; then what needs
/// no roles is still checked. `suspects` are what [`detect`](crate::detect) found, which become results
/// beside the others. The take is not changed and a check cannot fail: what goes wrong is a result.
pub fn check(
    recording: &Recording,
    roles: Result<&Roles, &str>,
    suspects: &[Suspect],
    settings: &CheckSettings,
) -> Checkup {
    let mut results = source_and_roles::findings(recording);
    let mut subject = Subject::new(recording, settings);
    let motion = match roles {
        Ok(roles) => (subject.set_roles(roles))
            .and_then(|()| to_hand_frame(recording, roles, &subject.templates, &settings.process))
            .map_err(|error| results.push(unusable(&error.to_string())))
            .ok(),
        Err(why) => {
            results.push(source_and_roles::roles_open(why));
            None
        }
    };
    results.extend(timing::rate(recording));
    results.extend(timing::frozen(&subject));
    results.extend(source_and_roles::duplicate_names(&subject));
    // What would be a wrong number comes before what is only missing.
    results.extend(suspected(&recording.clock, suspects));
    results.extend(gaps::gaps(&subject));
    results.extend(bodies::bodies(&subject));
    without_flips_said_twice(&mut results, suspects);
    results.extend(convention::convention(recording));
    results.extend(up::up_axis(&subject));
    match &motion {
        Some(motion) => results.extend(hand_size::hand_size(recording, motion, settings)),
        None => results.extend(hand_size::volume(recording)),
    }
    let segments = motion.map(|motion| segments(&motion, settings));
    results.extend(segments.map(|found| segment_result(found, recording, settings)));
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
    let (hand, object) = (Setting::Hand, Setting::Object);
    CheckResult::new("roles", Level::Fail, "")
        .expected("a hand whose pose is known")
        .found(source_and_roles::what_and_what_there_is(why))
        .advice(format!(
            "name another body or other markers with {hand} and {object}"
        ))
}

/// One result for each kind and entity, in the order of the first suspect of each.
fn suspected(clock: &Clock, suspects: &[Suspect]) -> Vec<CheckResult> {
    let mut groups: Vec<((&'static str, String), Vec<&Suspect>)> = Vec::new();
    for suspect in suspects {
        let key = (suspect.kind.id(), suspect.kind.entity());
        match groups.iter_mut().find(|(other, _)| *other == key) {
            Some((_, group)) => group.push(suspect),
            None => groups.push((key, vec![suspect])),
        }
    }
    let results = groups
        .into_iter()
        .map(|((id, entity), group)| suspect_result(clock, id, entity, &group));
    results.collect()
}

fn suspect_result(
    clock: &Clock,
    id: &'static str,
    entity: String,
    group: &[&Suspect],
) -> CheckResult {
    let mut ranges: Vec<_> = group.iter().map(|s| s.samples.clone()).collect();
    ranges.sort_by_key(|range| (range.start, range.end));
    let samples = ranges.iter().map(Range::len).sum();
    let scores = group.iter().map(|s| s.score);
    let found = format!(
        "{} ({})",
        count(group.len(), one_and_many(&group[0].kind)),
        times(clock, &ranges)
    );
    CheckResult::new(id, Level::Warn, entity)
        .at(clock, &ranges)
        .expected("none")
        .found(match group {
            [suspect] => format!("{found}: {suspect}"),
            _ => found,
        })
        .advice("look at it in a viewer; `inhand clean` lists and repairs it")
        .number("count", group.len() as f64, samples)
        .number(
            "largest_score",
            scores.fold(f64::NEG_INFINITY, f64::max),
            group.len(),
        )
}

const fn one_and_many(kind: &SuspectKind) -> [&'static str; 2] {
    match kind {
        SuspectKind::Spike { .. } => ["spike", "spikes"],
        SuspectKind::Swap { .. } => ["suspected swap", "suspected swaps"],
        SuspectKind::Flip { .. } => ["suspected flip", "suspected flips"],
        SuspectKind::Unlabelled { .. } => [
            "interval without its label",
            "intervals without their label",
        ],
    }
}

/// Removes jumps of an orientation that a detected flip explains.
fn without_flips_said_twice(results: &mut Vec<CheckResult>, suspects: &[Suspect]) {
    let flips = |entity: &str| {
        let kinds = suspects.iter().map(|suspect| &suspect.kind);
        kinds
            .filter(|kind| matches!(kind, SuspectKind::Flip { name, .. } if name == entity))
            .count()
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
        ends: EndsRule::Differences {
            margin_s: settings.margin_s,
        },
        missing_s: settings.missing_s,
    });
    // A rate so low that a second has no two samples gives no segment.
    let Ok(cut) = cut else {
        return SegmentShare::default();
    };
    SegmentShare {
        usable: cut.starts(&SegmentTable::from_motion(motion)).starts.len(),
        possible: cut.without_gaps(motion.len(), None),
    }
}

fn segment_result(
    segments: SegmentShare,
    recording: &Recording,
    settings: &CheckSettings,
) -> CheckResult {
    let SegmentShare { usable, possible } = segments;
    let found = format!("{usable} of {possible} segments are usable");
    let result = |level, found: String| {
        CheckResult::new("segments", level, "")
            .expected(format!("{} of them usable", percent(settings.usable_share)))
            .found(found)
            .number("usable", usable as f64, possible)
            .number("possible", possible as f64, recording.len())
            .number("usable_share", segments.share(), possible)
    };
    if possible == 0 {
        let duration_s = recording.clock.time_s(recording.len());
        result(
            Level::Fail,
            format!("{duration_s:.2} s are too short for a segment"),
        )
        .expected("a second and what end velocities are taken over")
        .advice("record longer takes")
    } else if usable == 0 {
        result(Level::Fail, found).advice("gaps leave no whole second: see the gaps above")
    } else if segments.share() < settings.usable_share {
        result(Level::Warn, found).advice("gaps cut the others: see the gaps above")
    } else {
        result(Level::Ok, found)
    }
}
