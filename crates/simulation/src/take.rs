//! One simulated take: the truth, and the recording made of it.

use std::collections::BTreeMap;
use std::ops::Range;

use inhand_model::{
    Clock, Finger, Hand, LengthUnit, Marker, Object, PerFinger, Pose, Position, Recording,
    RotationOrder, Shape, Source, StartTime, TrackedBody, UpAxis, World,
};
use nalgebra::Isometry3;

use crate::camera_system::{capture_body, capture_marker, draw_gaps};
use crate::choreography::{Choreography, choreograph};
use crate::error::SimulationError;
use crate::motion::HandMotion;
use crate::random::{Purpose, Random};
use crate::settings::TakeSettings;
use crate::surface::Solid;

/// Markers on the back of the hand, metres; their centroid is the origin.
const HAND_MARKERS: [Position<Hand>; 3] = [
    Position::new(0.036, -0.012, 0.001),
    Position::new(-0.032, -0.018, 0.003),
    Position::new(-0.004, 0.030, -0.004),
];
/// Markers on the end of the object that looks away from the palm: x and y as shares of the half
/// extent, and height above the end, metres.
const OBJECT_MARKERS: [(f64, f64, f64); 3] =
    [(0.8, 0.1, 0.006), (-0.5, 0.75, 0.006), (-0.3, -0.8, 0.010)];

/// A take with what is true of it.
#[derive(Clone, Debug)]
pub struct SimulatedTake {
    /// What the cameras saw.
    pub recording: Recording,
    /// What was there.
    pub truth: Truth,
    /// Faults that were planted into the recording, in order of time.
    pub faults: Vec<Fault>,
}

/// Multiples of this length are what a recording file holds, metres: about a micrometre, as in Motive's CSV files.
const FILE_RESOLUTION_M: f64 = 1.0 / (1 << 20) as f64;

impl SimulatedTake {
    /// The recording with all lengths rounded to 2^-20 m, less than a micrometre; rotations are kept.
    ///
    /// Cameras resolve 10 to 100 micrometres. The bits below are noise that no file packs: with them MCAP takes are
    /// larger by half.
    pub fn rounded_recording(&self) -> Recording {
        let rounded_m = |length_m: f64| (length_m / FILE_RESOLUTION_M).round() * FILE_RESOLUTION_M;
        let mut recording = self.recording.clone();
        for marker in &mut recording.markers {
            let place = |p: Position<World>| Position::from(p.to_array().map(rounded_m));
            marker.track = marker.track.map(place);
        }
        for body in &mut recording.bodies {
            body.track = body.track.map(|pose| {
                let mut isometry = pose.isometry();
                isometry.translation.vector.apply(|m| *m = rounded_m(*m));
                Pose::new(isometry)
            });
            for error_m in body.marker_error_m.iter_mut().flatten() {
                *error_m = rounded_m(*error_m);
            }
        }
        recording
    }
}

/// Kind of a fault.
#[derive(Clone, Debug, PartialEq)]
pub enum FaultKind {
    /// A marker is missing.
    Gap,
    /// Two fingertip labels have changed places.
    Swap,
    /// A body's recorded pose is the true one times this transform, in the body's frame.
    Flip {
        /// From the frame recorded to the body's true frame.
        true_from_recorded: Isometry3<f64>,
    },
    /// A marker is off its way.
    Spike {
        /// How far at most, metres.
        off_m: f64,
        /// Where it was seen, sample by sample, metres in `world`.
        was_m: Vec<[f64; 3]>,
    },
    /// A fingertip has lost its label; the second entity is the marker that has its samples.
    Unlabelled,
    /// An unlabelled marker that is no fingertip.
    Ghost,
}

impl FaultKind {
    /// Lower-case name, as in files.
    pub const fn name(&self) -> &'static str {
        match self {
            FaultKind::Gap => "gap",
            FaultKind::Swap => "swap",
            FaultKind::Flip { .. } => "flip",
            FaultKind::Spike { .. } => "spike",
            FaultKind::Unlabelled => "unlabelled",
            FaultKind::Ghost => "ghost",
        }
    }
}

/// A planted fault.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// What is wrong, and what was there.
    pub kind: FaultKind,
    /// Names of the markers or the body.
    pub entities: Vec<String>,
    /// Samples that are wrong.
    pub samples: Range<usize>,
}

/// Ground truth of a simulated take, at every sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// The object in the hand.
    pub shape: Shape,
    /// Pose of the hand, quaternion without jumps of sign.
    pub world_from_hand: Vec<Pose<World, Hand>>,
    /// Pose of the object, its origin at its centre.
    pub world_from_object: Vec<Pose<World, Object>>,
    /// Where the fingertips are, without noise, in gaps too.
    pub fingertips: PerFinger<Vec<Position<World>>>,
    /// Whether a fingertip touches the object.
    pub in_contact: PerFinger<Vec<bool>>,
    /// Runs of samples that the recording lacks, in order, apart by at least one sample.
    pub gaps: PerFinger<Vec<Range<usize>>>,
}

/// Simulates one take. The same settings and seed give the same bits; noise, gaps and whether the
/// object is tracked leave the motion as it is.
///
/// The recording looks like one that Motive exports: bodies `Hand` and (if tracked) `Object` with
/// `Mean Marker Error`, their markers `Hand:Marker1`, ..., and the fingertip markers `Thumb`,
/// `Index`, `Middle`, `Ring`, `Little`. Rigid body poses are least-squares fits to three noisy
/// markers, so the orientation of a small body is noisier than that of a large one. Its clock
/// starts at the epoch, as nothing was captured at any time of day.
///
/// Cost: linear in the samples, some microseconds each.
///
/// # Errors
///
/// [`SimulationError`] for settings out of range, an object that the hand does not hold, or gaps
/// that do not fit into the take.
pub fn simulate(settings: &TakeSettings, seed: u64) -> Result<SimulatedTake, SimulationError> {
    let samples = settings.samples()?;
    let clock = Clock::new(0, StartTime::Unknown, settings.rate_hz)?;
    let gaps = PerFinger::try_from_fn(|finger| match &settings.gaps {
        None => Ok(Vec::new()),
        Some(gaps) => draw_gaps(gaps, samples, &mut Random::new(seed, Purpose::Gaps(finger))),
    })?;
    let truth = truth(settings, samples, gaps, seed)?;

    let (mut bodies, mut markers) = (Vec::new(), Vec::new());
    let mut add = |(body, of_body): (TrackedBody, [Marker; 3])| {
        bodies.push(body);
        markers.extend(of_body);
    };
    let (noise_m, rate_hz) = (settings.noise_m, settings.rate_hz);
    add(capture_body(
        "Hand",
        &HAND_MARKERS,
        &truth.world_from_hand,
        noise_m,
        rate_hz,
        &mut Random::new(seed, Purpose::HandMarkers),
    ));
    if settings.track_object {
        add(capture_body(
            "Object",
            &object_markers(&Solid::new(settings.shape)?),
            &truth.world_from_object,
            noise_m,
            rate_hz,
            &mut Random::new(seed, Purpose::ObjectMarkers),
        ));
    }
    markers.extend(Finger::ALL.map(|finger| {
        capture_marker(
            marker_name(finger),
            &truth.fingertips[finger],
            noise_m,
            &truth.gaps[finger],
            &mut Random::new(seed, Purpose::Fingertip(finger)),
        )
    }));
    let source = source(settings, seed);
    let name = settings.name.clone();
    let recording = Recording::new(name, clock, source, samples, markers, bodies)?;
    Ok(SimulatedTake {
        recording,
        truth,
        faults: Vec::new(),
    })
}

fn truth(
    settings: &TakeSettings,
    samples: usize,
    gaps: PerFinger<Vec<Range<usize>>>,
    seed: u64,
) -> Result<Truth, SimulationError> {
    let Choreography { object, grasp, .. } =
        choreograph(settings.shape, settings.duration_s, seed)?;
    let hand = HandMotion::new(&mut Random::new(seed, Purpose::HandMotion));
    let time_s = |k: usize| k as f64 / settings.rate_hz;
    let world_from_hand: Vec<_> = (0..samples)
        .map(|k| hand.world_from_hand(time_s(k)))
        .collect();
    let world_from_object: Vec<_> = (world_from_hand.iter().enumerate())
        .map(|(k, &world_from_hand)| world_from_hand * object.hand_from_object(time_s(k)))
        .collect();
    let fingertips = PerFinger::from_fn(|finger| {
        (world_from_object.iter().enumerate())
            .map(|(k, &pose)| pose * grasp.fingers[finger].position_at(time_s(k)))
            .collect()
    });
    let in_contact = PerFinger::from_fn(|finger| {
        (0..samples)
            .map(|k| grasp.fingers[finger].in_contact_at(time_s(k)))
            .collect()
    });
    Ok(Truth {
        shape: settings.shape,
        world_from_hand,
        world_from_object,
        fingertips,
        in_contact,
        gaps,
    })
}

fn object_markers(solid: &Solid) -> [Position<Object>; 3] {
    let half = solid.half_extent_m();
    OBJECT_MARKERS.map(|(x, y, above_m)| Position::new(x * half.x, y * half.y, half.z + above_m))
}

pub(crate) const fn marker_name(finger: Finger) -> &'static str {
    match finger {
        Finger::Thumb => "Thumb",
        Finger::Index => "Index",
        Finger::Middle => "Middle",
        Finger::Ring => "Ring",
        Finger::Little => "Little",
    }
}

fn source(settings: &TakeSettings, seed: u64) -> Source {
    let gaps = settings.gaps.map_or(0.0, |gaps| gaps.share);
    let header = [
        ("Object Shape", settings.shape.to_string()),
        ("Marker Noise (m)", settings.noise_m.to_string()),
        ("Gap Share", gaps.to_string()),
        ("Seed", seed.to_string()),
    ];
    Source {
        format: "inhand simulation".to_owned(),
        length_unit: LengthUnit::Metres,
        up_axis: UpAxis::Y,
        rotation: Some(RotationOrder::Quaternion),
        header: BTreeMap::from(header.map(|(key, value)| (key.to_owned(), value))),
    }
}
