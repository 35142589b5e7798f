//! Data quality of a take.

use inhand_model::{
    BodySource, Finding, Marker, Motion, PerFinger, Recording, Roles, TakeQuality, TrackCounts,
    TrackQuality,
};

/// Markers that a body's pose can be fitted to at the least.
const FIT_MARKERS: usize = 3;

/// Completeness of a take: samples of each fingertip as recorded and after processing, the longest
/// gap as recorded, how often hand and object were tracked, and what was odd.
///
/// A body fitted to markers counts as tracked where three of them or more were seen. A role whose
/// marker or body the take lacks counts as never tracked, and is a finding. `role` is what the take is
/// used for: `train` or `test`.
pub fn recording_quality(
    recording: &Recording,
    roles: &Roles,
    motion: &Motion,
    role: &str,
) -> TakeQuality {
    let mut findings = recording.findings.clone();
    let mut absent = |kind: &str, name: &str, used_for: &str| {
        findings.push(Finding::warning(
            name,
            format!("the take has no {kind} of this name, {used_for} is missing throughout"),
        ));
    };
    let fingertips: PerFinger<Option<&Marker>> = PerFinger::from_fn(|finger| {
        let name = &roles.fingers[finger];
        let marker = recording.marker(name);
        if marker.is_none() {
            absent("marker", name, &format!("the {finger}"));
        }
        marker
    });
    let share = |tracked: usize| match recording.len() {
        0 => 0.0,
        samples => tracked as f64 / samples as f64,
    };
    let hand_tracked = share(tracked(recording, &roles.hand, "the hand", &mut absent));
    let object_tracked = (roles.object.as_ref())
        .map(|object| tracked(recording, object, "the object", &mut absent))
        .filter(|&tracked| tracked > 0)
        .map(share);

    let all_missing = TrackCounts {
        missing: recording.len(),
        ..TrackCounts::default()
    };
    let longest_gap = |marker: &Marker| {
        let gaps = marker.track.gaps();
        gaps.iter().map(ExactSizeIterator::len).max().unwrap_or(0)
    };
    TakeQuality {
        take: recording.name.clone(),
        role: role.to_owned(),
        hand_tracked,
        object_tracked,
        fingers: PerFinger::from_fn(|finger| {
            let marker = fingertips[finger];
            let gap = marker.map_or(recording.len(), longest_gap);
            TrackQuality {
                recorded: marker.map_or(all_missing, |m| m.track.counts()),
                processed: motion.fingertips[finger].counts(),
                longest_gap_s: gap as f64 / recording.clock.rate_hz(),
            }
        }),
        findings,
    }
}

/// Samples at which a body is tracked; `absent` gets the kind, name and use of what the take lacks.
fn tracked(
    recording: &Recording,
    source: &BodySource,
    used_for: &str,
    absent: &mut impl FnMut(&str, &str, &str),
) -> usize {
    match source {
        BodySource::RigidBody(name) => {
            let body = recording.body(name);
            if body.is_none() {
                absent("rigid body", name, used_for);
            }
            body.map_or(0, |body| {
                let counts = body.track.counts();
                counts.measured + counts.filled
            })
        }
        BodySource::Markers(names) => {
            let mut cluster: Vec<&Marker> = Vec::new();
            for name in names {
                match recording.marker(name) {
                    Some(marker) => cluster.push(marker),
                    None => absent("marker", name, &format!("a part of {used_for}")),
                }
            }
            let seen = |k: usize| {
                let seen = cluster.iter().filter(|m| m.track.status(k).is_present());
                seen.count()
            };
            (0..recording.len())
                .filter(|&k| seen(k) >= FIT_MARKERS)
                .count()
        }
    }
}
