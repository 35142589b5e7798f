//! Processing and contacts against ground truth.

use inhand_model::{BodySource, Finger, Motion, PerFinger, Roles, Status};
use inhand_motion::{Filter, GapFill, ProcessSettings, fit_templates, process};
use inhand_simulation::{GapSettings, SimulatedTake, TakeSettings, simulate};

fn take(gaps: Option<GapSettings>) -> SimulatedTake {
    let settings = TakeSettings {
        duration_s: 30.0,
        gaps,
        ..TakeSettings::cube("truth")
    };
    simulate(&settings, 11).expect("the default settings can be simulated")
}

fn roles() -> Roles {
    Roles {
        hand: BodySource::RigidBody("Hand".into()),
        object: Some(BodySource::RigidBody("Object".into())),
        fingers: PerFinger::new(["Thumb", "Index", "Middle", "Ring", "Little"].map(str::to_owned)),
    }
}

fn motion(take: &SimulatedTake, filter: Filter) -> Motion {
    let settings = ProcessSettings {
        max_gap_s: 0.1,
        fill: GapFill::Cubic,
        filter,
        object_offset_m: [0.0; 3],
    };
    let templates = fit_templates([(&take.recording, &roles())]).expect("rigid bodies need none");
    process(&take.recording, &roles(), &templates, &settings).expect("the take has all roles")
}

/// Distance between processed and true fingertip in the hand's frame at every present sample.
fn errors_m(take: &SimulatedTake, motion: &Motion, status: Status) -> Vec<f64> {
    let mut errors = Vec::new();
    for finger in Finger::ALL {
        for k in 0..motion.len() {
            let truth = take.truth.world_from_hand[k].inverse() * take.truth.fingertips[finger][k];
            if let Some(tip) = motion.fingertips[finger].get(k)
                && motion.fingertips[finger].status(k) == status
            {
                errors.push(tip.distance_m(truth));
            }
        }
    }
    errors.sort_by(f64::total_cmp);
    errors
}

fn median(sorted: &[f64]) -> f64 {
    assert!(!sorted.is_empty());
    sorted[sorted.len() / 2]
}

#[test]
fn hand_frame_is_the_true_one_up_to_noise() {
    let take = take(None);
    let errors = errors_m(&take, &motion(&take, Filter::None), Status::Measured);
    assert_eq!(errors.len(), 5 * 3000);
    // Noise of 0.1 mm a coordinate has a median length of 0.15 mm; the hand's own noise adds some,
    // more at a lever of 15 cm.
    assert!(
        (0.000_1..0.001).contains(&median(&errors)),
        "{}",
        median(&errors)
    );
}

#[test]
fn a_short_median_takes_noise_away() {
    let take = take(None);
    let raw = median(&errors_m(
        &take,
        &motion(&take, Filter::None),
        Status::Measured,
    ));
    let filter = Filter::Median { window: 9 };
    let smooth = median(&errors_m(&take, &motion(&take, filter), Status::Measured));
    assert!(smooth < 0.7 * raw, "{smooth} after, {raw} before");
}

#[test]
fn filled_samples_are_near_the_truth_and_long_gaps_stay() {
    let take = take(Some(GapSettings::with_share(0.03)));
    let motion = motion(&take, Filter::None);
    let filled = errors_m(&take, &motion, Status::Filled);
    assert!(median(&filled) < 0.001, "{}", median(&filled));
    for finger in Finger::ALL {
        let track = &motion.fingertips[finger];
        for gap in &take.truth.gaps[finger] {
            let expected = if gap.len() <= 10 {
                Status::Filled
            } else {
                Status::Missing
            };
            let inside = gap.start > 0 && gap.end < track.len();
            for k in gap.clone().filter(|_| inside) {
                assert_eq!(
                    track.status(k),
                    expected,
                    "{finger} sample {k} of gap {gap:?}"
                );
            }
        }
    }
}

#[test]
fn contacts_are_the_true_ones() {
    let take = take(None);
    let motion = motion(&take, Filter::None);
    let object = motion.object.as_ref().expect("the object is tracked");
    let (mut agree, mut n) = (0, 0);
    for k in 0..motion.len() {
        let object_from_hand = object.get(k).expect("nothing is missing").inverse();
        for finger in Finger::ALL {
            let tip = object_from_hand
                * motion.fingertips[finger]
                    .get(k)
                    .expect("nothing is missing");
            let near = inhand_contact::surface_distance_m(&take.truth.shape, tip) <= 0.002;
            agree += usize::from(near == take.truth.in_contact[finger][k]);
            n += 1;
        }
    }
    // A lifting finger leaves the surface slowly: a few samples at each lift are within 2 mm.
    assert!(agree as f64 > 0.97 * n as f64, "{agree} of {n}");
}
