//! Missing and filled samples of tracks.

use inhand_model::{Clock, Finger, Motion, Status, TakeGaps, TrackGaps};

/// The gaps of a take, as they are in the hand's frame: where the hand is missing, so is all else.
pub fn take_gaps(take: &str, role: &str, motion: &Motion) -> TakeGaps {
    let of = |track: &str, statuses: &[Status]| track_gaps(track, statuses, motion.clock);
    let mut tracks: Vec<TrackGaps> = Finger::ALL
        .iter()
        .map(|&finger| of(finger.name(), motion.fingertips[finger].statuses()))
        .collect();
    tracks.push(of("hand", motion.hand.statuses()));
    if let Some(object) = &motion.object {
        tracks.push(of("object", object.statuses()));
    }
    TakeGaps {
        take: take.to_owned(),
        role: role.to_owned(),
        duration_s: motion.clock.time_s(motion.len()),
        tracks,
    }
}

fn track_gaps(track: &str, statuses: &[Status], clock: Clock) -> TrackGaps {
    let mut gaps = TrackGaps {
        track: track.to_owned(),
        missing_s: Vec::new(),
        filled_s: Vec::new(),
    };
    let mut start = 0;
    for run in statuses.chunk_by(|a, b| a == b) {
        let end = start + run.len();
        // A sample covers one period.
        let interval_s = [clock.time_s(start), clock.time_s(end)];
        match run[0] {
            Status::Missing => gaps.missing_s.push(interval_s),
            Status::Filled => gaps.filled_s.push(interval_s),
            Status::Measured => {}
        }
        start = end;
    }
    gaps
}

#[cfg(test)]
mod tests {
    use inhand_model::StartTime;

    use super::*;

    #[test]
    fn missing_and_filled_intervals_are_distinguished() {
        use Status::{Filled, Measured, Missing};
        let clock = Clock::new(0, StartTime::Unknown, 10.0).expect("a rate");
        let statuses = [Missing, Measured, Filled, Filled, Missing, Measured, Filled];
        let gaps = track_gaps("thumb", &statuses, clock);
        assert_eq!(gaps.missing_s, [[0.0, 0.1], [0.4, 0.5]]);
        assert_eq!(gaps.filled_s, [[0.2, 0.4], [0.6, 0.7]]);
        assert_eq!(track_gaps("hand", &[], clock).missing_s.len(), 0);
    }
}
