//! Sessions small enough to be judged by hand.

use inhand_contact::hull;
use inhand_evaluation::{
    EvaluationSettings, MethodResult, Recorded, TestData, evaluate_method, recorded,
};
use inhand_model::{
    Clock, Demonstrated, EndConditions, Hand, MethodEvaluation, MethodRows, Motion, Object,
    PerFinger, Pose, PoseTrack, Position, SEGMENT_COORDINATES, SegmentLayout, SegmentOrigin,
    Segments, Shape, StartTime, Status, Track, Trajectory, VelocityBounds,
};
use nalgebra::{DMatrix, Isometry3};

/// Everything that a `TestData` borrows.
#[derive(Debug)]
pub(crate) struct Session {
    pub(crate) segments: Segments,
    pub(crate) motions: Vec<Motion>,
    pub(crate) demonstrated: Demonstrated,
    pub(crate) velocity_bounds: VelocityBounds,
    pub(crate) shape: Option<Shape>,
    pub(crate) settings: EvaluationSettings,
}

impl Session {
    /// Segments cut from motions at `starts`; fingertips without a value get NaN.
    pub(crate) fn new(
        motions: Vec<Motion>,
        samples: usize,
        origins: &[(usize, usize)],
        left_out: usize,
        demonstrated: Demonstrated,
    ) -> Self {
        let layout = SegmentLayout {
            samples,
            rate_hz: motions[0].clock.rate_hz(),
            object: false,
        };
        let mut numbers = Vec::new();
        for &(take, start) in origins {
            for k in start..start + samples {
                for (_, track) in motions[take].fingertips.iter() {
                    numbers.extend(track.value(k).to_array());
                }
            }
        }
        let origins: Vec<SegmentOrigin> = (origins.iter())
            .map(|&(take, start)| SegmentOrigin { take, start })
            .collect();
        let ends = EndConditions {
            first_m: [0.0; SEGMENT_COORDINATES],
            last_m: [0.0; SEGMENT_COORDINATES],
            first_velocity_m_s: [0.0; SEGMENT_COORDINATES],
            last_velocity_m_s: [0.0; SEGMENT_COORDINATES],
            object: None,
        };
        let count = origins.len();
        let columns = DMatrix::from_vec(layout.rows(), count, numbers);
        Self {
            segments: Segments::new(layout, columns, origins, vec![ends; count], left_out)
                .expect("sizes fit"),
            motions,
            velocity_bounds: demonstrated.velocity,
            demonstrated,
            shape: Some(Shape::Cuboid { edges_m: [0.05; 3] }),
            settings: EvaluationSettings::paper(),
        }
    }

    /// The recorded segments as trajectories: the perfect method.
    pub(crate) fn copies(&self) -> Vec<Option<Trajectory>> {
        (0..self.segments.len())
            .map(|s| Some(self.trajectory(self.segments.fingertips_m(s).to_vec())))
            .collect()
    }

    pub(crate) fn trajectory(&self, values_m: Vec<f64>) -> Trajectory {
        Trajectory::new(self.segments.layout(), values_m).expect("finite, of the right length")
    }

    pub(crate) fn recorded(&self) -> Recorded {
        self.with_data(|data| recorded(&data, &self.settings))
    }

    pub(crate) fn evaluate(
        &self,
        trajectories: &[Option<Trajectory>],
    ) -> (MethodEvaluation, MethodRows) {
        self.judge(&method(trajectories))
    }

    pub(crate) fn judge(&self, method: &MethodResult<'_>) -> (MethodEvaluation, MethodRows) {
        self.with_data(|data| evaluate_method(&data, &self.recorded(), method, &self.settings))
    }

    pub(crate) fn with_data<T>(&self, look: impl FnOnce(TestData<'_>) -> T) -> T {
        let motions: Vec<&Motion> = self.motions.iter().collect();
        look(TestData {
            segments: &self.segments,
            motions: &motions,
            demonstrated: &self.demonstrated,
            velocity_bounds: self.velocity_bounds,
            shape: self.shape,
        })
    }
}

/// A method that plans these trajectories and nothing else.
pub(crate) fn method(trajectories: &[Option<Trajectory>]) -> MethodResult<'_> {
    MethodResult {
        name: "test",
        description: "made for a test",
        baseline: true,
        trajectories,
        objects: None,
        corridors: None,
        plans: None,
    }
}

/// A motion from its fingertips, all measured, and where the object is (`None`: missing).
pub(crate) fn motion(
    rate_hz: f64,
    tips: &[PerFinger<Position<Hand>>],
    object: Option<&[Option<Pose<Hand, Object>>]>,
) -> Motion {
    Motion {
        name: "take".to_owned(),
        clock: Clock::new(0, StartTime::Unknown, rate_hz).expect("a positive rate"),
        fingertips: PerFinger::from_fn(|finger| {
            Track::from_measured(tips.iter().map(|tips| Some(tips[finger])))
        }),
        object: object.map(|object| PoseTrack::from_measured(object.iter().copied())),
        hand: PoseTrack::from_measured(tips.iter().map(|_| Some(Pose::identity()))),
        selected: None,
    }
}

/// Marks a sample as filled, whatever it was.
pub(crate) fn fill<T: inhand_model::Sample>(track: &mut Track<T>, k: usize) {
    track.set(k, track.get(k), Status::Filled);
}

/// A hull for every finger that is a cube of 1 m, and velocities up to 1 m/s.
pub(crate) fn anywhere() -> Demonstrated {
    let corners: Vec<Position<Hand>> = (0..8)
        .map(|k| Position::from([1, 2, 4].map(|bit| if k & bit == 0 { -0.5 } else { 0.5 })))
        .collect();
    Demonstrated {
        hulls: PerFinger::from_fn(|_| hull(&corners).expect("a cube has a hull")),
        velocity: VelocityBounds {
            min_m_s: [-1.0; SEGMENT_COORDINATES],
            max_m_s: [1.0; SEGMENT_COORDINATES],
        },
    }
}

/// The object 100 mm in front of the hand.
pub(crate) fn object_ahead() -> Pose<Hand, Object> {
    Pose::new(Isometry3::translation(0.1, 0.0, 0.0))
}

/// Fingertips beside a cube of 50 mm that is [`object_ahead`], each at its distance outside the
/// face towards +y, 12 mm apart.
pub(crate) fn beside_cube(distances_m: [f64; 5]) -> PerFinger<Position<Hand>> {
    PerFinger::from_fn(|finger| {
        let x = 0.076 + 0.012 * finger.index() as f64;
        Position::new(x, 0.025 + distances_m[finger.index()], 0.0)
    })
}
