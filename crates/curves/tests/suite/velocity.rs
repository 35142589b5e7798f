//! Velocities over takes and along trajectories.

use inhand_curves::velocity;
use inhand_model::{
    Clock, Finger, Motion, PerFinger, PointTrack, Position, SegmentLayout, StartTime, Status,
    Track, Trajectory,
};

/// A take whose fingertips all move along `x_m` (in y: minus that), missing where `None`.
fn motion(rate_hz: f64, x_m: &[Option<f64>]) -> Motion {
    let track = PointTrack::from_measured(
        x_m.iter()
            .map(|x_m| x_m.map(|x_m| Position::new(x_m, -x_m, 1.0))),
    );
    Motion {
        name: "take".into(),
        clock: Clock::new(0, StartTime::Unknown, rate_hz).unwrap(),
        fingertips: PerFinger::from_fn(|_| track.clone()),
        object: None,
        hand: Track::missing(x_m.len()),
        selected: None,
    }
}

fn assert_near(found: &[f64], expected: &[f64]) {
    assert!(
        found
            .iter()
            .zip(expected)
            .all(|(a, b)| (a - b).abs() < 1e-12),
        "{found:?}, expected {expected:?}"
    );
}

#[test]
fn extremes_are_over_all_takes_at_their_own_rates() {
    let slow = motion(10.0, &[Some(0.0), Some(0.1), Some(0.05)]); // 1 m/s, -0.5 m/s
    let fast = motion(100.0, &[Some(0.0), Some(0.02)]); // 2 m/s
    let bounds = velocity::extremes([&slow, &fast]).unwrap();
    for finger in Finger::ALL {
        let at = finger.index() * 3;
        assert_near(&bounds.min_m_s[at..at + 3], &[-0.5, -2.0, 0.0]);
        assert_near(&bounds.max_m_s[at..at + 3], &[2.0, 0.5, 0.0]);
    }
}

#[test]
fn gaps_give_no_velocity() {
    // 0.9 m in two samples: across the gap nothing is known of how fast it was.
    let gap = motion(
        100.0,
        &[Some(0.0), Some(0.01), None, Some(0.91), Some(0.92)],
    );
    let bounds = velocity::extremes([&gap]).unwrap();
    assert_near(&bounds.max_m_s[..1], &[1.0]);
    assert_near(&bounds.min_m_s[..1], &[1.0]);
}

#[test]
fn filled_samples_count() {
    let mut filled = motion(100.0, &[Some(0.0), None]);
    for finger in Finger::ALL {
        filled.fingertips[finger].set(1, Some(Position::new(0.01, 0.0, 1.0)), Status::Filled);
    }
    assert!(velocity::extremes([&filled]).is_some());
}

#[test]
fn no_pair_of_samples_no_extremes() {
    assert_eq!(velocity::extremes([]), None);
    let alone = motion(100.0, &[Some(0.0), None, Some(0.1)]);
    assert_eq!(velocity::extremes([&alone]), None);
    // One finger never seen: its bounds are not known, so there are none.
    let mut four = motion(100.0, &[Some(0.0), Some(0.1)]);
    four.fingertips[Finger::Ring] = Track::missing(2);
    assert_eq!(velocity::extremes([&four]), None);
    assert!(velocity::extremes([&four, &motion(100.0, &[Some(0.0), Some(0.1)])]).is_some());
}

#[test]
fn steps_are_differences_times_rate() {
    let layout = |samples| SegmentLayout {
        samples,
        rate_hz: 50.0,
        object: false,
    };
    let values = [[0.0; 15], [0.5; 15], [0.25; 15]].concat();
    let trajectory = Trajectory::new(layout(3), values).unwrap();
    assert_eq!(velocity::steps(&trajectory), [[25.0; 15], [-12.5; 15]]);
    for samples in [0, 1] {
        let still = Trajectory::new(layout(samples), vec![0.0; 15 * samples]).unwrap();
        assert!(velocity::steps(&still).is_empty());
    }
}
