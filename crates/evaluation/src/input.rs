//! Input of an evaluation, with its limits.

use inhand_model::{
    Calibration, Demonstrated, Hand, Motion, Object, PerFinger, Plan, Pose, Segments, Shape,
    Trajectory, VelocityBounds,
};

/// The limits an evaluation applies. All of them are choices about the experiment and are written
/// into its report.
#[derive(Clone, Debug, PartialEq)]
pub struct EvaluationSettings {
    /// Largest distance to the object's surface, from outside or inside, that counts as contact,
    /// metres.
    pub tau_m: f64,
    /// Distance below which two fingertips count as colliding, metres.
    pub collision_limit_m: f64,
    /// How far the pad of each finger reaches beyond its marker, metres; taken off the signed
    /// distance to the object.
    pub finger_offsets_m: PerFinger<f64>,
    /// Thresholds at which the share of three contacts is reported in addition, metres.
    pub tau_sweep_m: Vec<f64>,
    /// How far outside the training hull still counts as inside, metres.
    pub hull_tolerance_m: f64,
}

impl EvaluationSettings {
    /// The limits of the paper (arXiv 2308.15153) where it gives any: contact within 5 mm, as far as
    /// fingertip pulp deforms (Delhaye et al. 2021). It gives no collision distance: 10 mm, since
    /// fingertips are no points. Distances count from the markers; the sweep goes from 0 to 10 mm in
    /// steps of 1 mm; the hull is taken to a nanometre.
    pub fn paper() -> Self {
        Self {
            tau_m: 0.005,
            collision_limit_m: 0.010,
            finger_offsets_m: PerFinger::default(),
            tau_sweep_m: (0..=10).map(|mm| f64::from(mm) / 1000.0).collect(),
            hull_tolerance_m: 1e-9,
        }
    }
}

/// The recorded motion that methods are judged by.
#[derive(Clone, Copy, Debug)]
pub struct TestData<'a> {
    /// Test segments (n of N samples).
    pub segments: &'a Segments,
    /// The takes they were cut from, in the order that [`inhand_model::SegmentOrigin::take`] counts.
    pub motions: &'a [&'a Motion],
    /// What the training takes showed.
    pub demonstrated: &'a Demonstrated,
    /// The velocities that plans had to keep to.
    pub velocity_bounds: VelocityBounds,
    /// The object's shape, where it is known.
    pub shape: Option<Shape>,
}

/// Pose of the object at each of the N samples of a segment (`hand_from_object`).
pub type ObjectPoses = Vec<Pose<Hand, Object>>;

/// Plans of a method for the test segments.
#[derive(Clone, Copy, Debug)]
pub struct MethodResult<'a> {
    /// Name, such as `prior`.
    pub name: &'a str,
    /// What it knows and does, in a line.
    pub description: &'a str,
    /// Whether it uses nothing learned.
    pub baseline: bool,
    /// One for each segment, `None` where the plan failed. One that is not there, or that has another
    /// rate or number of samples than the segments, counts as failed too.
    pub trajectories: &'a [Option<Trajectory>],
    /// Where the method plans the object to be, for each segment: `None` where the plan failed;
    /// another number of poses than samples counts as failed too. `None` for a method that plans
    /// fingertips alone.
    pub objects: Option<&'a [Option<ObjectPoses>]>,
    /// How far the recording lies from the plan as the plan's own uncertainty measures it, where the
    /// method has any.
    pub corridors: Option<Corridors<'a>>,
    /// How planning went, where there was any.
    pub plans: Option<&'a [Plan]>,
}

/// The recorded fingertips measured by the uncertainty of the planned ones.
#[derive(Clone, Copy, Debug)]
pub struct Corridors<'a> {
    /// For each segment and each of its N instants the Mahalanobis distance
    /// `sqrt((x - m)ᵀ C⁻¹ (x - m))` of each recorded fingertip `x` from the planned one `m` with
    /// covariance `C` (3 x 3); infinite where a prediction region of no width misses, NaN where there is
    /// none. `None`, or another number of instants, where the plan failed.
    pub mahalanobis: &'a [Option<Vec<PerFinger<f64>>>],
    /// The widths to judge, with the shares they are meant to hold.
    pub widths: &'a [Calibration],
}
