//! Distance between the references of two protocols.

use inhand_model::{Finger, HandAndFingers, Motion, PerFinger, Segments, Statistics, Status};
use inhand_statistics::quantiles::statistics;

/// How far a filter moves fingertips: distances between segments of filtered motion and the motions before the filter,
/// at every instant of the segments.
pub fn filter_moves(segments: &Segments, before: &[&Motion]) -> HandAndFingers<Statistics> {
    let samples = segments.layout().samples;
    let moved = |finger: Finger| {
        let (mut distances_m, mut filled) = (Vec::new(), 0);
        for (segment, origin) in segments.origins().iter().enumerate() {
            let track = &before[origin.take].fingertips[finger];
            for t in 0..samples {
                if let Some(position) = track.get(origin.start + t) {
                    let after = segments.position(segment, t, finger);
                    distances_m.push((after.coords_m() - position.coords_m()).norm());
                    filled += usize::from(track.status(origin.start + t) == Status::Filled);
                }
            }
        }
        (distances_m, filled)
    };
    let moved = PerFinger::from_fn(moved);
    let left_out = segments.left_out * samples;
    let all = (moved.as_array().iter()).flat_map(|(distances_m, _)| distances_m.iter().copied());
    let filled = moved.as_array().iter().map(|(_, filled)| filled).sum();
    HandAndFingers {
        all: statistics(all.collect(), filled, Finger::COUNT * left_out),
        by_finger: moved.map(|(distances_m, filled)| statistics(distances_m, filled, left_out)),
    }
}
