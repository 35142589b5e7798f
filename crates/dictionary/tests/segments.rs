//! Segments to learn from, made up here.

use inhand_model::{
    Demonstrated, EndConditions, Hull, PerFinger, SEGMENT_COORDINATES, SegmentLayout,
    SegmentOrigin, Segments, VelocityBounds,
};
use nalgebra::DMatrix;

/// Segments with these columns (15 N rows) at 100 Hz.
pub(crate) fn segments(columns_m: DMatrix<f64>) -> Segments {
    let samples = columns_m.nrows() / SEGMENT_COORDINATES;
    of_layout(columns_m, samples, false)
}

/// Segments with these columns at 100 Hz, in any layout.
pub(crate) fn of_layout(columns_m: DMatrix<f64>, samples: usize, object: bool) -> Segments {
    let count = columns_m.ncols();
    let layout = SegmentLayout {
        samples,
        rate_hz: 100.0,
        object,
    };
    let zero = [0.0; SEGMENT_COORDINATES];
    let ends = EndConditions {
        first_m: zero,
        last_m: zero,
        first_velocity_m_s: zero,
        last_velocity_m_s: zero,
        object: None,
    };
    let origins = (0..count)
        .map(|i| SegmentOrigin {
            take: i / 10,
            start: 4 + (i % 10) * layout.samples,
        })
        .collect();
    Segments::new(layout, columns_m, origins, vec![ends; count], 0)
        .expect("one origin and one pair of ends for each column")
}

/// Smooth motion of five fingers within some centimetres: every coordinate the sum of two
/// oscillations whose phases differ from segment to segment, and from finger to finger in their own way
/// for each segment. Thirteen dimensions, whatever the number of samples and segments.
pub(crate) fn motion(samples: usize, count: usize) -> DMatrix<f64> {
    DMatrix::from_fn(samples * SEGMENT_COORDINATES, count, |row, segment| {
        let (t, coordinate) = (row / SEGMENT_COORDINATES, row % SEGMENT_COORDINATES);
        let (time, c, s) = (t as f64 / samples as f64, coordinate as f64, segment as f64);
        let slow = (1.3 * time + 0.7 * c + 2.399 * s).sin();
        let fast = (5.0 * time + 0.9 * (c / 3.0).floor() * s + s.sqrt()).sin();
        0.01 * c - 0.08 + 0.02 * slow + 0.006 * fast
    })
}

/// A place holder: learning passes on what the takes showed, unseen.
pub(crate) fn demonstrated() -> Demonstrated {
    let hull = Hull {
        vertices_m: Vec::new(),
        triangles: Vec::new(),
        normals: Vec::new(),
        offsets_m: Vec::new(),
    };
    Demonstrated {
        hulls: PerFinger::from_fn(|_| hull.clone()),
        velocity: VelocityBounds {
            min_m_s: [-1.0; SEGMENT_COORDINATES],
            max_m_s: [1.0; SEGMENT_COORDINATES],
        },
    }
}
