//! Segments of a take by the block of samples.

use inhand_channels::TakeSegments;
use inhand_model::{MethodRows, PerFinger, SegmentLayout, SegmentOrigin, Trajectory};

const LENGTH: usize = 4;

/// Segments at 0, 4 and 10 of take 1, after one of take 0.
fn origins() -> [SegmentOrigin; 4] {
    [(0, 0), (1, 0), (1, 4), (1, 10)].map(|(take, start)| SegmentOrigin { take, start })
}

fn block(origins: &[SegmentOrigin], samples: std::ops::Range<usize>) -> TakeSegments<'_> {
    TakeSegments {
        origins,
        length: LENGTH,
        take: 1,
        samples,
    }
}

#[test]
fn blocks_have_the_segments_that_reach_into_them() {
    let origins = origins();
    let places = |samples| block(&origins, samples).places().collect::<Vec<_>>();
    assert_eq!(places(0..4), [1]);
    assert_eq!(places(3..5), [1, 2]);
    assert_eq!(places(7..11), [2, 3]);
    assert!(places(8..10).is_empty());
    assert!(places(0..0).is_empty());
}

#[test]
fn what_spans_blocks_counts_once() {
    let origins = origins();
    let layout = SegmentLayout {
        samples: LENGTH,
        rate_hz: 100.0,
        object: false,
    };
    let rest = Trajectory::new(layout, vec![0.0; layout.finger_rows()]).unwrap();
    let trajectories = [Some(rest.clone()), Some(rest), None, None];
    let errors = (0..4 * LENGTH).map(|row| PerFinger::new([row as f64; 5]));
    let rows = MethodRows {
        name: "line".to_owned(),
        error_m: errors.collect(),
        ..MethodRows::default()
    };
    for length in [1, 3, 5, 14] {
        let blocks: Vec<_> = (0..14)
            .step_by(length)
            .map(|start| block(&origins, start..(start + length).min(14)))
            .collect();
        let lost = blocks.iter().map(|b| b.without_trajectory(&trajectories));
        assert_eq!(lost.sum::<usize>(), 2, "blocks of {length}");
        let judged: Vec<_> = (blocks.iter())
            .flat_map(|block| block.evaluated(&rows, 0.005))
            .map(|judged| (judged.sample, judged.error_m.unwrap().as_array()[0]))
            .collect();
        let expected: Vec<_> = ((0..8).map(|k| (k, 4 + k)))
            .chain((0..4).map(|k| (10 + k, 12 + k)))
            .map(|(sample, row)| (sample, row as f64))
            .collect();
        assert_eq!(judged, expected, "blocks of {length}");
        let started: Vec<_> = (blocks.iter())
            .flat_map(|block| block.generated(&trajectories, None))
            .map(|segment| segment.start_sample)
            .collect();
        assert!(started.iter().all(|&start| start == 0), "{started:?}");
    }
}
