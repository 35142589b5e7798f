//! The held-out protocol: no sample between a segment's first and last reaches a planner.

use std::ops::Range;

use inhand_model::{
    BodySource, Dictionary, EndConditions, Finger, Motion, PerFinger, Protocol, Recording, Roles,
    Sample, SegmentLayout, Segments, Status, Track,
};
use inhand_motion::{fit_templates, to_hand_frame};
use inhand_session::{Method, Role, Settings, steps};
use inhand_simulation::{GapSettings, TakeSettings, simulate};

fn recording(seed: u64, gaps: Option<GapSettings>) -> Recording {
    let settings = TakeSettings {
        duration_s: 30.0,
        gaps,
        ..TakeSettings::cube("held_out")
    };
    let take = simulate(&settings, seed).expect("the default settings can be simulated");
    take.recording
}

/// The motion before the filter, and after it.
fn motions(recording: &Recording, settings: &Settings) -> [Motion; 2] {
    let roles = Roles {
        hand: BodySource::RigidBody("Hand".into()),
        object: Some(BodySource::RigidBody("Object".into())),
        fingers: PerFinger::new(["Thumb", "Index", "Middle", "Ring", "Little"].map(str::to_owned)),
    };
    let templates = fit_templates([(recording, &roles)]).expect("rigid bodies need none");
    let process = settings.process_settings().unwrap();
    let unfiltered = to_hand_frame(recording, &roles, &templates, &process).unwrap();
    let filtered = steps::smooth_motions(vec![unfiltered.clone()], settings).unwrap();
    [unfiltered, filtered.into_iter().next().unwrap()]
}

fn cut(motion: &Motion, protocol: Protocol, settings: &Settings) -> Segments {
    steps::segments(&[motion], (Role::Test, protocol), true, settings).unwrap()
}

fn dictionary(settings: &Settings) -> Dictionary {
    let takes = [1, 2, 3].map(|seed| motions(&recording(seed, None), settings));
    let filtered: Vec<_> = takes.iter().map(|[_, filtered]| filtered).collect();
    let unfiltered: Vec<_> = takes.iter().map(|[unfiltered, _]| unfiltered).collect();
    let of = (Role::Train, Protocol::Published);
    let train = steps::segments(&filtered, of, true, settings).unwrap();
    let layout = SegmentLayout {
        object: true,
        ..train.layout()
    };
    let held_out = steps::held_out_demonstrations(&unfiltered, layout, settings).unwrap();
    let demonstrated = steps::demonstrated(&filtered).unwrap();
    steps::learn(&train, &held_out, demonstrated, settings).unwrap()
}

/// Every second segment, so that none lies beside another that is changed.
fn changed(segments: &Segments) -> Vec<usize> {
    (1..segments.len()).step_by(2).collect()
}

/// Reverses what was measured inside segments, a permutation; what is missing stays missing.
fn reverse<T: Sample>(track: &mut Track<T>, insides: &[Range<usize>]) {
    let before = track.clone();
    for inside in insides {
        for k in inside.clone() {
            let from = inside.end - 1 - (k - inside.start);
            if before.status(k) == Status::Measured && before.status(from) == Status::Measured {
                track.set(k, before.get(from), Status::Measured);
            }
        }
    }
}

fn reversed(recording: &Recording, segments: &Segments) -> Recording {
    let samples = segments.layout().samples;
    let insides: Vec<_> = (changed(segments).iter())
        .map(|&segment| {
            let start = segments.origins()[segment].start;
            start + 1..start + samples - 1
        })
        .collect();
    let mut changed = recording.clone();
    for marker in &mut changed.markers {
        reverse(&mut marker.track, &insides);
    }
    for body in &mut changed.bodies {
        reverse(&mut body.track, &insides);
    }
    changed
}

fn ends(segments: &Segments) -> Vec<EndConditions> {
    (changed(segments).into_iter())
        .map(|segment| segments.ends()[segment])
        .collect()
}

#[test]
fn reversing_time_inside_segments_changes_no_boundary_condition_and_no_plan() {
    let mut settings = Settings::default();
    settings.learn.rank = Some(20);
    settings.learn.max_iterations = 20;
    let dictionary = dictionary(&settings);
    assert!(dictionary.residual_held_out.is_some());
    for gaps in [None, Some(GapSettings::with_share(0.02))] {
        let before = recording(4, gaps);
        let [unfiltered, filtered] = motions(&before, &settings);
        let segments = cut(&unfiltered, Protocol::HeldOut, &settings);
        assert!(segments.len() > 8, "{}", segments.len());
        let [other, other_filtered] = motions(&reversed(&before, &segments), &settings);
        let other = cut(&other, Protocol::HeldOut, &settings);
        assert_eq!(other.origins(), segments.origins());
        assert_ne!(other.columns_m(), segments.columns_m());
        assert_eq!(ends(&other), ends(&segments));
        for method in Method::ALL {
            let generate = |segments| {
                steps::generate(method, &dictionary, segments, &settings)
                    .unwrap()
                    .trajectories
            };
            let (found, expected) = (generate(&other), generate(&segments));
            for segment in changed(&segments) {
                assert!(expected[segment].is_some());
                assert_eq!(found[segment], expected[segment], "{method} {segment}");
            }
        }
        // The published protocol takes its boundary conditions from filtered motion, which holds some of the inside.
        let published = |motion| cut(motion, Protocol::Published, &settings);
        assert_ne!(
            ends(&published(&other_filtered)),
            ends(&published(&filtered))
        );
    }
}

#[test]
fn dictionaries_without_deviations_of_the_protocol_use_the_published_ones() {
    let mut settings = Settings::default();
    settings.learn.rank = Some(20);
    settings.learn.max_iterations = 5;
    let with = dictionary(&settings);
    let older = Dictionary {
        residual_held_out: None,
        ..with.clone()
    };
    let [unfiltered, filtered] = motions(&recording(4, None), &settings);
    let error_m = |dictionary, segments: &Segments| {
        let made = steps::generate(Method::Residual, dictionary, segments, &settings).unwrap();
        let errors = (made.trajectories.iter().enumerate()).flat_map(|(segment, trajectory)| {
            let trajectory = trajectory.as_ref().unwrap();
            (0..segments.layout().samples).map(move |t| {
                let planned = trajectory.position(t, Finger::Index);
                planned.distance_m(segments.position(segment, t, Finger::Index))
            })
        });
        errors.sum::<f64>() / (segments.len() * segments.layout().samples) as f64
    };
    let held_out = cut(&unfiltered, Protocol::HeldOut, &settings);
    assert!(error_m(&with, &held_out) < error_m(&older, &held_out));
    let published = cut(&filtered, Protocol::Published, &settings);
    assert_eq!(error_m(&with, &published), error_m(&older, &published));
}
