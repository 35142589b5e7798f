//! Six methods against 119 test segments of 100 samples: what a session asks for.

use divan::Bencher;
use inhand_contact::hull;
use inhand_evaluation::{
    EvaluationSettings, MethodResult, Recorded, TestData, evaluate_method, recorded,
};
use inhand_model::{
    Clock, Demonstrated, EndConditions, Finger, Hand, Motion, PerFinger, PointTrack, Pose,
    PoseTrack, Position, SEGMENT_COORDINATES, SegmentLayout, SegmentOrigin, Segments, Shape,
    StartTime, Trajectory, VelocityBounds,
};
use nalgebra::{DMatrix, Isometry3, Vector3};

const METHODS: usize = 6;
const SEGMENTS: usize = 119;
const SAMPLES: usize = 100;

fn main() {
    divan::main();
}

/// Where a coordinate is at sample `k`: within some centimetres, about 0.1 mm a sample.
fn wave(k: usize, coordinate: usize) -> f64 {
    let (t, c) = (k as f64 * 0.01, 1.0 + 0.13 * coordinate as f64);
    (0.37 * c * t).sin() * 0.012 + (0.61 / c * t + c).sin() * 0.008 + (1.3 * c * t).cos() * 0.003
}

fn tip(k: usize, finger: Finger) -> Position<Hand> {
    let row = SegmentLayout::row(0, finger, 0);
    Position::new(wave(k, row), wave(k, row + 1), wave(k, row + 2))
}

struct Session {
    segments: Segments,
    motion: Motion,
    demonstrated: Demonstrated,
    methods: Vec<Vec<Option<Trajectory>>>,
    settings: EvaluationSettings,
}

impl Session {
    fn new() -> Self {
        let count = SEGMENTS * SAMPLES;
        let object = (0..count).map(|k| {
            let turn = Vector3::new(wave(k, 20), wave(k, 21), wave(k, 22)) * 30.0;
            Some(Pose::new(Isometry3::new(
                Vector3::new(0.0, 0.0, wave(k, 23)),
                turn,
            )))
        });
        let motion = Motion {
            name: "take".to_owned(),
            clock: Clock::new(0, StartTime::Unknown, 100.0).expect("a positive rate"),
            fingertips: PerFinger::from_fn(|finger| {
                PointTrack::from_measured((0..count).map(|k| Some(tip(k, finger))))
            }),
            object: Some(PoseTrack::from_measured(object)),
            hand: PoseTrack::from_measured((0..count).map(|_| Some(Pose::identity()))),
            selected: None,
        };
        let layout = SegmentLayout::one_second(100.0);
        let numbers: Vec<f64> = (0..count)
            .flat_map(|k| (0..SEGMENT_COORDINATES).map(move |c| wave(k, c)))
            .collect();
        let still = [0.0; SEGMENT_COORDINATES];
        let ends = EndConditions {
            first_m: still,
            last_m: still,
            first_velocity_m_s: still,
            last_velocity_m_s: still,
            object: None,
        };
        let segments = Segments::new(
            layout,
            DMatrix::from_vec(layout.rows(), SEGMENTS, numbers),
            (0..SEGMENTS)
                .map(|s| SegmentOrigin {
                    take: 0,
                    start: s * SAMPLES,
                })
                .collect(),
            vec![ends; SEGMENTS],
            0,
        )
        .expect("sizes fit");
        let methods = (0..METHODS)
            .map(|method| {
                let off = |row: usize| 0.002 * (row as f64 * 0.002 + method as f64).sin();
                (0..SEGMENTS)
                    .map(|segment| {
                        let values = segments.fingertips_m(segment).iter().enumerate();
                        let values = values.map(|(row, v)| v + off(row)).collect();
                        Some(Trajectory::new(layout, values).expect("finite"))
                    })
                    .collect()
            })
            .collect();
        let demonstrated = Demonstrated {
            hulls: PerFinger::from_fn(|finger| {
                // Filtered motion of a real hand rests often: its hull has some 200 triangles, that of
                // this path has thousands unless it is coarsened.
                let coarse = |k| tip(k, finger).coords_m().map(|c| (c * 2e3).round() / 2e3);
                let points: Vec<_> = (0..60_000)
                    .map(|k| Position::<Hand>::from_coords(coarse(k + 5_000)))
                    .collect();
                hull(&points).expect("a path in space has a hull")
            }),
            velocity: VelocityBounds {
                min_m_s: [-0.05; SEGMENT_COORDINATES],
                max_m_s: [0.05; SEGMENT_COORDINATES],
            },
        };
        Self {
            segments,
            motion,
            demonstrated,
            methods,
            settings: EvaluationSettings::paper(),
        }
    }

    fn run(&self) -> (Recorded, usize) {
        let data = TestData {
            segments: &self.segments,
            motions: &[&self.motion],
            demonstrated: &self.demonstrated,
            velocity_bounds: self.demonstrated.velocity,
            shape: Some(Shape::Cuboid { edges_m: [0.02; 3] }),
        };
        let of_recording = recorded(&data, &self.settings);
        let mut collisions = 0;
        for trajectories in &self.methods {
            let method = MethodResult {
                name: "off",
                description: "the recording, some millimetres off",
                baseline: true,
                trajectories,
                objects: None,
                corridors: None,
                plans: None,
            };
            let (evaluation, _) = evaluate_method(&data, &of_recording, &method, &self.settings);
            collisions += evaluation.collision.instants;
        }
        (of_recording, collisions)
    }
}

#[divan::bench]
fn session_of_six_methods(bencher: Bencher<'_, '_>) {
    let session = Session::new();
    bencher.bench(|| session.run());
}
