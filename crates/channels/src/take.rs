//! Contents of a take's file, to write and as read.

use inhand_model::{
    Annotations, Change, Hull, Motion, PerFinger, Plan, Provenance, Recording, Roles, Shape,
    Trajectory,
};

/// Everything about a take that goes into one file; each part but the recording is optional.
#[derive(Clone, Debug)]
pub struct TakeFile<'a> {
    /// What was measured.
    pub recording: &'a Recording,
    /// The recording after cleaning, where it was cleaned: later steps use it, and everything but what
    /// was measured follows its clock.
    pub cleaned: Option<CleanedTake<'a>>,
    /// Which tracked thing is the hand, the object, a finger.
    pub roles: Option<&'a Roles>,
    /// The take in the hand's frame; of the clock and length of the recording, or of the cleaned one
    /// where there is one.
    pub motion: Option<&'a Motion>,
    /// Trajectories by method. Viewers show each in a colour of its own beside the recorded motion, the
    /// first one with trails.
    pub generated: &'a [GeneratedMethod<'a>],
    /// How trajectories compare with the recorded motion, by method. An entry named [`RECORDED`]
    /// has the recorded contacts with the object; viewers light them up.
    pub evaluated: &'a [EvaluatedMethod],
    /// The object's shape, drawn in the frame `object`.
    pub object_shape: Option<Shape>,
    /// Where each fingertip has been in training, frame `hand`: viewers draw the outlines.
    pub hulls: Option<&'a PerFinger<Hull>>,
    /// Events on the take's time line and facts about it.
    pub annotations: Option<&'a Annotations>,
    /// What made the nouns, first step first.
    pub provenance: &'a [Provenance],
}

impl<'a> TakeFile<'a> {
    /// A file with a recording alone.
    pub const fn new(recording: &'a Recording) -> Self {
        Self {
            recording,
            cleaned: None,
            roles: None,
            motion: None,
            generated: &[],
            evaluated: &[],
            object_shape: None,
            hulls: None,
            annotations: None,
            provenance: &[],
        }
    }

    /// The recording that later steps use: the cleaned one where there is one.
    pub fn used(&self) -> &'a Recording {
        self.cleaned
            .map_or(self.recording, |cleaned| cleaned.recording)
    }
}

/// A recording after cleaning.
#[derive(Clone, Copy, Debug)]
pub struct CleanedTake<'a> {
    /// The recording; its rate may be another one.
    pub recording: &'a Recording,
    /// What was changed, in the order of the steps; samples are those of the recording as measured.
    pub changes: &'a [Change],
}

/// What one method generated for a take.
#[derive(Clone, Copy, Debug)]
pub struct GeneratedMethod<'a> {
    /// Name, such as `prior`; becomes part of topics.
    pub name: &'a str,
    /// Trajectories, in any order.
    pub segments: &'a [GeneratedSegment<'a>],
    /// Plans that found no trajectory, in any order; their diagnosis goes into the file.
    pub unsolved: &'a [UnsolvedPlan<'a>],
}

/// A plan without a trajectory and where in the take its trajectory would be.
#[derive(Clone, Copy, Debug)]
pub struct UnsolvedPlan<'a> {
    /// Sample of the take at which it would start.
    pub start_sample: usize,
    /// Samples it would have.
    pub samples: usize,
    /// How planning ended.
    pub plan: &'a Plan,
}

/// Segments in the order in which they start.
pub(crate) fn by_start<'a>(segments: &'a [GeneratedSegment<'a>]) -> Vec<&'a GeneratedSegment<'a>> {
    let mut segments: Vec<_> = segments.iter().collect();
    segments.sort_by_key(|segment| segment.start_sample);
    segments
}

/// Which of the take's markers is on which fingertip.
pub(crate) fn marker_indices(recording: &Recording, roles: &Roles) -> PerFinger<Option<usize>> {
    (roles.fingers.each_ref()).map(|name| recording.marker_index(name))
}

/// One trajectory and where in the take it belongs.
#[derive(Clone, Copy, Debug)]
pub struct GeneratedSegment<'a> {
    /// Sample of the take at which the trajectory starts.
    pub start_sample: usize,
    /// The motion, at the take's rate.
    pub trajectory: &'a Trajectory,
    /// How it was planned, where it was.
    pub plan: Option<&'a Plan>,
}

/// Name of the recorded motion among methods: it has contacts and no error.
pub const RECORDED: &str = "recorded";

/// How one method compares with the recorded motion.
#[derive(Clone, Debug, PartialEq)]
pub struct EvaluatedMethod {
    /// Name, such as `prior`; becomes part of topics.
    pub name: String,
    /// The instants that were judged, in any order.
    pub samples: Vec<EvaluatedSample>,
}

/// One judged instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EvaluatedSample {
    /// Sample of the take.
    pub sample: usize,
    /// Distance between planned and recorded fingertip, metres; `None` for the recorded motion itself.
    pub error_m: Option<PerFinger<f64>>,
    /// Contacts, where the object's pose and shape are known.
    pub contact: Option<ContactSample>,
}

/// Contacts with the object at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactSample {
    /// Distance of each fingertip to the object's surface, metres.
    pub distance_m: PerFinger<f64>,
    /// Whether that counts as contact.
    pub in_contact: PerFinger<bool>,
    /// Fingers in contact.
    pub count: usize,
}

/// How to write a take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WriteSettings {
    /// Whether to add channels that viewers draw (`/tf`, `/tf_static`, `/view/...`).
    pub view: bool,
}

impl Default for WriteSettings {
    fn default() -> Self {
        Self { view: true }
    }
}

/// What a take's file holds of what later steps start from.
#[derive(Clone, Debug)]
pub struct ReadTake {
    /// What was measured, bit for bit as it was written.
    pub recording: Recording,
    /// The recording after cleaning, where the file holds one.
    pub cleaned: Option<ReadCleaned>,
    /// Which tracked thing is the hand, the object, a finger.
    pub roles: Option<Roles>,
    /// The take in the hand's frame, bit for bit as it was written.
    pub motion: Option<Motion>,
    /// Events on the take's time line and facts about it.
    pub annotations: Annotations,
    /// What made the file, first step first.
    pub provenance: Vec<Provenance>,
}

/// A cleaned recording of a file.
#[derive(Clone, Debug)]
pub struct ReadCleaned {
    /// The recording, bit for bit as it was written.
    pub recording: Recording,
    /// What was changed, in the order of the steps; samples are those of the recording as measured.
    pub changes: Vec<Change>,
}
