//! Invariants of the true motion.

use inhand_model::{Finger, Object, Position};
use inhand_simulation::{SimulatedTake, TakeSettings, simulate};
use nalgebra::Vector3;

use crate::{shapes, surface_distance_m};

fn takes() -> impl Iterator<Item = SimulatedTake> {
    shapes().into_iter().zip(1..).map(|(shape, seed)| {
        let settings = TakeSettings::new(shape, "take");
        simulate(&settings, seed).expect("the settings are valid")
    })
}

/// Fingertips in the object's frame.
fn in_object(take: &SimulatedTake, finger: Finger) -> Vec<Position<Object>> {
    let truth = &take.truth;
    (truth
        .world_from_object
        .iter()
        .zip(&truth.fingertips[finger]))
    .map(|(&pose, &tip)| pose.inverse() * tip)
    .collect()
}

#[test]
fn fingertips_in_contact_lie_on_the_surface_and_no_other_enters_the_object() {
    // Rounding of coordinates near one metre, through two poses: some 1e-16 m each.
    const TOLERANCE_M: f64 = 1e-12;
    for take in takes() {
        let shape = take.truth.shape;
        for finger in Finger::ALL {
            let mut highest_m = 0f64;
            for (k, tip) in in_object(&take, finger).into_iter().enumerate() {
                let distance_m = surface_distance_m(shape, tip);
                if take.truth.in_contact[finger][k] {
                    assert!(
                        distance_m.abs() <= TOLERANCE_M,
                        "{shape} {finger} {k} {distance_m}"
                    );
                } else {
                    assert!(
                        distance_m >= -TOLERANCE_M,
                        "{shape} {finger} {k} {distance_m}"
                    );
                }
                highest_m = highest_m.max(distance_m);
            }
            // A finger that moves at all leaves the surface visibly, and stays near.
            let moves = take.truth.in_contact[finger].iter().any(|&c| !c);
            assert!(!moves || (0.001..0.04).contains(&highest_m), "{highest_m}");
        }
    }
}

#[test]
fn three_fingers_or_more_touch_at_every_sample_and_all_of_them_move_sometimes() {
    for take in takes() {
        let contacts = &take.truth.in_contact;
        let mut least = Finger::COUNT;
        for k in 0..take.recording.len() {
            let touching = Finger::ALL.iter().filter(|&&f| contacts[f][k]).count();
            assert!(touching >= 3, "{} at {k}", take.truth.shape);
            least = least.min(touching);
        }
        assert!(least < Finger::COUNT, "no finger was ever lifted");
    }
    // Over ten minutes with the demo's cube every finger is lifted, each a few percent of the time.
    let settings = TakeSettings {
        duration_s: 600.0,
        ..TakeSettings::cube("long")
    };
    let truth = simulate(&settings, 4).unwrap().truth;
    for (finger, contact) in truth.in_contact.iter() {
        let air = contact.iter().filter(|&&c| !c).count() as f64 / contact.len() as f64;
        assert!((0.002..0.1).contains(&air), "{finger} {air}");
    }
}

#[test]
fn a_finger_in_contact_stays_where_it_is_on_the_object() {
    for take in takes() {
        for finger in Finger::ALL {
            let tips = in_object(&take, finger);
            let contact = &take.truth.in_contact[finger];
            for k in 1..tips.len() {
                if contact[k - 1] && contact[k] {
                    assert!(tips[k].distance_m(tips[k - 1]) < 1e-12, "{finger} {k}");
                }
            }
        }
    }
}

#[test]
fn fingers_never_come_within_ten_millimetres() {
    for take in takes() {
        let tips = &take.truth.fingertips;
        for a in Finger::ALL {
            for b in Finger::ALL.into_iter().filter(|&b| b > a) {
                let nearest_m = (tips[a].iter().zip(&tips[b]))
                    .map(|(p, q)| p.distance_m(*q))
                    .fold(f64::INFINITY, f64::min);
                assert!(
                    nearest_m > 0.010,
                    "{} {a} {b} {nearest_m}",
                    take.truth.shape
                );
            }
        }
    }
}

#[test]
fn speeds_are_those_of_a_hand() {
    // A finger that reaches for a new place 40 mm away in 0.28 s peaks at 15/8 * 40/0.28 mm/s;
    // the rest of the motion is far below.
    const FINGER_LIMIT_M_S: f64 = 0.45;
    const OBJECT_LIMIT_RAD_S: f64 = 1.5;
    const HAND_LIMIT_M_S: f64 = 0.15;
    for take in takes() {
        let truth = &take.truth;
        for finger in Finger::ALL {
            let tips: Vec<_> = (truth.world_from_hand.iter().zip(&truth.fingertips[finger]))
                .map(|(&pose, &tip)| pose.inverse() * tip)
                .collect();
            for pair in tips.windows(2) {
                assert!(pair[0].distance_m(pair[1]) * 100.0 < FINGER_LIMIT_M_S);
            }
        }
        let in_hand: Vec<_> = (truth.world_from_hand.iter().zip(&truth.world_from_object))
            .map(|(&hand, &object)| (hand.inverse() * object).isometry())
            .collect();
        let mut turned = 0f64;
        for pair in in_hand.windows(2) {
            let speed = pair[0].rotation.angle_to(&pair[1].rotation) * 100.0;
            assert!(speed < OBJECT_LIMIT_RAD_S);
            turned += speed / 100.0;
        }
        // It does turn: more than a full turn in sum over two minutes.
        assert!(turned > std::f64::consts::TAU, "{turned}");
        for pair in truth.world_from_hand.windows(2) {
            assert!(pair[0].origin().distance_m(pair[1].origin()) * 100.0 < HAND_LIMIT_M_S);
        }
    }
}

#[test]
fn velocity_is_continuous() {
    // Where velocity is continuous, second differences at half the step are about a quarter as
    // large; at a jump of velocity they would only halve.
    let second_difference_m = |rate_hz: f64| {
        let settings = TakeSettings {
            rate_hz,
            duration_s: 60.0,
            ..TakeSettings::cube("smooth")
        };
        let truth = simulate(&settings, 12).unwrap().truth;
        let mut largest_m = 0f64;
        for finger in Finger::ALL {
            for three in truth.fingertips[finger].windows(3) {
                let [a, b, c]: [Vector3<f64>; 3] = std::array::from_fn(|i| three[i].coords_m());
                largest_m = largest_m.max((a - 2.0 * b + c).norm());
            }
        }
        largest_m
    };
    let (coarse_m, fine_m) = (second_difference_m(500.0), second_difference_m(1000.0));
    let ratio = coarse_m / fine_m;
    assert!((3.8..4.2).contains(&ratio), "{ratio}");
    // 20 m/s² is what a finger does that crosses 40 mm in 0.28 s.
    assert!(fine_m * 1e6 < 20.0, "{fine_m}");
}

#[test]
fn strokes_use_every_axis_in_the_hand_frame() {
    let take = simulate(&TakeSettings::cube("axes"), 2).unwrap();
    let truth = &take.truth;
    let (mut low, mut high) = ([f64::INFINITY; 6], [f64::NEG_INFINITY; 6]);
    for (&hand, &object) in truth.world_from_hand.iter().zip(&truth.world_from_object) {
        let pose = (hand.inverse() * object).isometry();
        let (place, turn) = (pose.translation.vector, pose.rotation.scaled_axis());
        for axis in 0..6 {
            let value = if axis < 3 {
                place[axis]
            } else {
                turn[axis - 3]
            };
            low[axis] = low[axis].min(value);
            high[axis] = high[axis].max(value);
        }
    }
    for axis in 0..6 {
        let (least, most) = if axis < 3 { (0.008, 0.03) } else { (0.35, 1.8) };
        let range = high[axis] - low[axis];
        assert!((least..most).contains(&range), "axis {axis}: {range}");
    }
}
