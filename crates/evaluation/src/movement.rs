//! Movement of recorded and planned motion: lengths, speeds, smoothness, and the distance to anything
//! demonstrated.

use inhand_curves::smoothness::PathMeasures;
use inhand_curves::warping::Candidates;
use inhand_model::{
    Configuration, Finger, FingerMovement, MethodRows, Movement, MovementAnalysis, MovementRows,
    PathFacts, PerFinger, Position, SEGMENT_COORDINATES, SegmentMovement, Segments, Statistics,
    Trajectory,
};
use inhand_parallel::up_to;

use crate::input::TestData;
use crate::instants::tips;
use crate::known::known_statistics;
use crate::method::usable;
use crate::recorded::Recorded;

/// Plans of a method for the test segments, and their measures at every instant.
#[derive(Clone, Copy, Debug)]
pub struct JudgedMethod<'a> {
    /// One for each segment, as in [`MethodResult`](crate::MethodResult).
    pub trajectories: &'a [Option<Trajectory>],
    /// What [`evaluate_method`](crate::evaluate_method) gave for it.
    pub rows: &'a MethodRows,
}

/// Choices about measures of motion; they are written into the result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovementSettings {
    /// Steps slower than this count as standing still, m/s.
    pub static_speed_m_s: f64,
    /// Widest shift in time that warping may make, as a share of a segment.
    pub band_share: f64,
    /// Demonstrations that the nearest is looked for among at most: of more, an even spread.
    pub most_demonstrations: usize,
}

impl MovementSettings {
    /// 5 mm/s; a tenth of a segment, the width that most comparisons of series use; 2000 demonstrations.
    pub const USUAL: MovementSettings = MovementSettings {
        static_speed_m_s: 0.005,
        band_share: 0.1,
        most_demonstrations: 2000,
    };
}

/// Measures the motion of the recording and of each method over the test segments, and how far each is from
/// the nearest of the `demonstrations`, the training segments; without them that is not known.
///
/// A segment counts as filled for a fingertip where any of its recorded samples was filled, and for the
/// distance to demonstrations where one of any finger was.
///
/// The rows hold each segment; the result is the same whatever the number of threads.
pub fn movement(
    data: &TestData<'_>,
    recorded: &Recorded,
    methods: &[JudgedMethod<'_>],
    demonstrations: Option<&Segments>,
    settings: &MovementSettings,
) -> (MovementAnalysis, Vec<MovementRows>) {
    let layout = data.segments.layout();
    let complete: Vec<usize> = demonstrations.map_or_else(Vec::new, |segments| {
        (0..segments.len())
            .filter(|&segment| segments.is_complete(segment))
            .collect()
    });
    let used = spread(&complete, settings.most_demonstrations);
    let paths: Vec<Vec<Configuration>> = (demonstrations.iter())
        .flat_map(|segments| {
            used.iter()
                .map(|&s| configurations(segments.fingertips_m(s)))
        })
        .collect();
    let band = (layout.samples as f64 * settings.band_share).round() as usize;
    let candidates = Candidates::new(paths.iter().map(Vec::as_slice), band);

    let measures = PathMeasures::new(layout.samples, layout.rate_hz, settings.static_speed_m_s);
    let measure = |values_m: Option<&[f64]>| {
        values_m.map_or(UNKNOWN, |values_m| {
            let path = configurations(values_m);
            let nearest = candidates.nearest(&path);
            SegmentMovement {
                by_finger: path_facts(&path, measures.as_ref()),
                nearest_demonstration_m: nearest.map_or(f64::NAN, |nearest| nearest.distance_m),
                nearest_demonstration: nearest.map(|nearest| used[nearest.index]),
            }
        })
    };
    let segments = data.segments.len();
    let of_recording = MovementRows {
        name: inhand_model::MotionRows::RECORDED.to_owned(),
        segments: up_to(segments, |segment| {
            measure(Some(data.segments.fingertips_m(segment)))
        }),
    };
    let of_methods = methods.iter().map(|method| MovementRows {
        name: method.rows.name.clone(),
        segments: up_to(segments, |segment| {
            measure(usable(method.trajectories, segment, layout).map(Trajectory::values_m))
        }),
    });
    let rows: Vec<MovementRows> = std::iter::once(of_recording).chain(of_methods).collect();

    let filled = filled_segments(recorded);
    let whole = segments + data.segments.left_out;
    let of = |rows: &MovementRows| summary(rows, &filled, whole, !used.is_empty());
    let analysis = MovementAnalysis {
        recorded: of(&rows[0]),
        methods: (rows[1..].iter())
            .map(|rows| (rows.name.clone(), of(rows)))
            .collect(),
        static_speed_m_s: settings.static_speed_m_s,
        demonstrations: used.len(),
        demonstrations_available: complete.len(),
        warping_band: Some(band),
    };
    (analysis, rows)
}

/// Whether any sample of each recorded fingertip was filled, for each segment.
pub fn filled_segments(recorded: &Recorded) -> Vec<PerFinger<bool>> {
    let rows = &recorded.rows;
    (rows.filled.chunks(rows.layout.samples.max(1)))
        .map(|instants| PerFinger::from_fn(|finger| instants.iter().any(|filled| filled[finger])))
        .collect()
}

const NO_PATH: PathFacts = PathFacts {
    length_m: f64::NAN,
    peak_speed_m_s: f64::NAN,
    static_share: f64::NAN,
    sparc: f64::NAN,
    ldlj: f64::NAN,
};

const UNKNOWN: SegmentMovement = SegmentMovement {
    by_finger: PerFinger::new([NO_PATH; Finger::COUNT]),
    nearest_demonstration_m: f64::NAN,
    nearest_demonstration: None,
};

/// At most `most` of a list, evenly spread over it.
fn spread(all: &[usize], most: usize) -> Vec<usize> {
    if all.len() <= most {
        return all.to_vec();
    }
    (0..most).map(|k| all[k * all.len() / most]).collect()
}

fn configurations(values_m: &[f64]) -> Vec<Configuration> {
    values_m.as_chunks::<SEGMENT_COORDINATES>().0.to_vec()
}

fn path_facts(path: &[Configuration], measures: Option<&PathMeasures>) -> PerFinger<PathFacts> {
    let Some(measures) = measures else {
        return UNKNOWN.by_finger;
    };
    let positions = Finger::ALL.map(|finger| -> Vec<Position<_>> {
        path.iter().map(|sample| tips(sample)[finger]).collect()
    });
    let facts = measures.of(positions.each_ref().map(Vec::as_slice));
    PerFinger::new(facts.map(|facts| facts.unwrap_or(NO_PATH)))
}

fn summary(
    rows: &MovementRows,
    filled: &[PerFinger<bool>],
    whole: usize,
    has_demonstrations: bool,
) -> Movement {
    let over = |value: &dyn Fn(&SegmentMovement) -> f64,
                is_filled: &dyn Fn(&PerFinger<bool>) -> bool|
     -> Statistics {
        let segments = rows.segments.iter().zip(filled);
        let values = segments.map(|(segment, filled)| (value(segment), is_filled(filled)));
        known_statistics(values, whole)
    };
    Movement {
        by_finger: PerFinger::from_fn(|finger| {
            let of = |part: fn(&PathFacts) -> f64| {
                over(&|segment| part(&segment.by_finger[finger]), &|filled| {
                    filled[finger]
                })
            };
            FingerMovement {
                length_m: of(|path| path.length_m),
                peak_speed_m_s: of(|path| path.peak_speed_m_s),
                static_share: of(|path| path.static_share),
                sparc: of(|path| path.sparc),
                ldlj: of(|path| path.ldlj),
            }
        }),
        nearest_demonstration_m: has_demonstrations.then(|| {
            over(&|segment| segment.nearest_demonstration_m, &|filled| {
                filled.as_array().contains(&true)
            })
        }),
    }
}
