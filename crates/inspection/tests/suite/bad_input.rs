//! Takes and settings that nothing can be made of.

use inhand_inspection::{CleanSettings, FillMethod, FillSettings, clean, detect};
use inhand_model::{BodySource, Finger, PerFinger, Roles, Status};
use inhand_motion::MotionError;
use inhand_simulation::{TakeSettings, simulate};
use proptest::prelude::*;

use crate::common::{repairs, roles};

fn short() -> inhand_model::Recording {
    let settings = TakeSettings {
        duration_s: 3.0,
        ..TakeSettings::cube("short")
    };
    simulate(&settings, 1)
        .expect("the settings are valid")
        .recording
}

fn everything(method: FillMethod) -> CleanSettings {
    CleanSettings {
        fill: Some(FillSettings {
            method,
            limit_s: 0.2,
        }),
        pads_m: PerFinger::from_fn(|_| Some([0.0, 0.0, 0.005])),
        resample_hz: Some(60.0),
        ..repairs()
    }
}

#[test]
fn roles_that_are_not_in_the_take_are_named() {
    let take = short();
    let no_marker = Roles {
        fingers: PerFinger::from_fn(|f| format!("nobody's {f}")),
        ..roles(true)
    };
    let error = detect::all(&take, Some(&no_marker)).expect_err("there is no such marker");
    assert!(error.to_string().contains("nobody's thumb"), "{error}");
    let no_hand = Roles {
        hand: BodySource::RigidBody("Foot".into()),
        ..roles(true)
    };
    let error = clean(&take, &no_hand, &repairs()).expect_err("no such body");
    assert!(
        matches!(
            error,
            MotionError::NotInTake {
                kind: "rigid body",
                ..
            }
        ),
        "{error}"
    );
    let no_cluster = Roles {
        hand: BodySource::Markers(["Thumb", "Index"].map(String::from).into()),
        ..roles(true)
    };
    assert!(detect::swaps(&take, &no_cluster).is_err());
}

#[test]
fn settings_out_of_range_are_named() {
    for limit_s in [-1.0, f64::NAN, f64::INFINITY] {
        let settings = CleanSettings {
            fill: Some(FillSettings {
                method: FillMethod::Cubic,
                limit_s,
            }),
            ..CleanSettings::default()
        };
        let error = clean(&short(), &roles(true), &settings).expect_err("no such limit");
        assert!(error.to_string().contains("fill limit"), "{error}");
    }
    let settings = CleanSettings {
        pads_m: PerFinger::from_fn(|_| Some([0.0, f64::NAN, 0.0])),
        ..CleanSettings::default()
    };
    let error = clean(&short(), &roles(true), &settings).expect_err("no such offset");
    assert!(error.to_string().contains("pad offset"), "{error}");
}

#[test]
fn takes_of_nothing_are_cleaned_to_nothing() {
    for samples in [0, 1, 2, 3] {
        let take = short().slice(0..samples);
        assert!(
            detect::all(&take, Some(&roles(true)))
                .expect("roles are there")
                .is_empty()
        );
        let cleaned =
            clean(&take, &roles(true), &everything(FillMethod::Neighbours)).expect("it cleans");
        assert!(cleaned.recording.len() <= samples);
    }
    let mut take = short();
    for marker in &mut take.markers {
        (0..300).for_each(|k| marker.track.set(k, None, Status::Missing));
    }
    assert!(
        detect::all(&take, Some(&roles(true)))
            .expect("roles are there")
            .is_empty()
    );
    for body in &mut take.bodies {
        (0..300).for_each(|k| body.track.set(k, None, Status::Missing));
    }
    assert!(
        detect::all(&take, Some(&roles(true)))
            .expect("roles are there")
            .is_empty()
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// Any mess of numbers and gaps is searched and cleaned without a panic.
    #[test]
    fn any_mess_is_survived(
        noise in prop::collection::vec((0_usize..11, 0_usize..300, prop::array::uniform3(-1e6..1e6_f64)), 0..60),
        holes in prop::collection::vec((0_usize..11, 0_usize..300, 1_usize..80), 0..20),
        turns in prop::collection::vec((0_usize..2, 0_usize..300, -3.0..3.0_f64), 0..12),
        method in prop::sample::select(vec![
            FillMethod::Linear, FillMethod::Cubic, FillMethod::Cluster, FillMethod::Neighbours,
        ]),
    ) {
        let mut take = short();
        for (marker, k, at) in noise {
            take.markers[marker].track.set(k, Some(at.into()), Status::Measured);
        }
        for (marker, from, len) in holes {
            (from..(from + len).min(300))
                .for_each(|k| take.markers[marker].track.set(k, None, Status::Missing));
        }
        for (body, k, turn) in turns {
            let turned = take.bodies[body].track.get(k).map(|pose| {
                let turn = nalgebra::Isometry3::rotation(nalgebra::Vector3::y() * turn);
                inhand_model::Pose::new(pose.isometry() * turn)
            });
            take.bodies[body].track.set(k, turned, Status::Measured);
        }
        let cleaned = clean(&take, &roles(true), &everything(method)).expect("roles are there");
        prop_assert_eq!(cleaned.recording.markers.len(), take.markers.len());
        let thumb = Finger::Thumb.index();
        prop_assert!(cleaned.changes.iter().all(|change| change.samples.end <= 300), "{}", thumb);
    }
}
