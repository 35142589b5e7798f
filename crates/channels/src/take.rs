//! Contents of a take's file, to write and as read.

use inhand_model::{
    Annotations, Change, Finding, Hull, Motion, PerFinger, Plan, Provenance, Recording, Roles,
    Shape, Trajectory, in_contact,
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
    /// Trajectories by method. Viewers show each that is drawn in a colour of its own beside the recorded motion,
    /// the first one with trails.
    pub generated: &'a [GeneratedMethod<'a>],
    /// Trajectories by method under the held-out protocol, which viewers do not show.
    pub held_out: &'a [GeneratedMethod<'a>],
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
            held_out: &[],
            evaluated: &[],
            object_shape: None,
            hulls: None,
            annotations: Some(&recording.annotations),
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

/// Visualisation channels that a file gets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Views {
    /// None.
    None,
    /// Those of the recording and of the first method.
    #[default]
    Default,
    /// Those of every method, and contacts of the first one as points.
    All,
}

/// What one method generated for a take.
#[derive(Clone, Copy, Debug)]
pub struct GeneratedMethod<'a> {
    /// Name, such as `prior`; becomes part of topics.
    pub name: &'a str,
    /// Whether its segments have plans: there is a channel for them.
    pub plans: bool,
    /// Trajectories and plans that found none, in any order.
    pub segments: &'a [GeneratedSegment<'a>],
}

/// Which of the take's markers is on which fingertip.
pub(crate) fn marker_indices(recording: &Recording, roles: &Roles) -> PerFinger<Option<usize>> {
    (roles.fingers.each_ref()).map(|name| recording.marker_index(name))
}

/// A trajectory, or a plan that found none, and where in the take it belongs.
#[derive(Clone, Copy, Debug)]
pub struct GeneratedSegment<'a> {
    /// Sample of the take at which the trajectory starts or would start.
    pub start_sample: usize,
    /// Samples that it has or would have.
    pub samples: usize,
    /// The motion, at the take's rate; of a plan without one the diagnosis goes into the file.
    pub trajectory: Option<&'a Trajectory>,
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

impl ContactSample {
    /// From the distances, of which those up to `tau_m` count as contact.
    pub fn new(distance_m: PerFinger<f64>, tau_m: f64) -> Self {
        let in_contact = distance_m.map(|distance_m| in_contact(distance_m, tau_m));
        let touching = in_contact.as_array().iter().filter(|&&touches| touches);
        Self {
            distance_m,
            in_contact,
            count: touching.count(),
        }
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

/// Views show at most this many instants a second: more than a screen needs only costs space.
const MAX_RATE_HZ: f64 = 50.0;

/// Scenes show at most this many instants a second: a scene is ten times the size of a cloud.
const MAX_SCENE_RATE_HZ: f64 = 25.0;

/// Every how many samples views show one.
pub(crate) fn stride(rate_hz: f64) -> usize {
    // The quotient of a rate and 50 is far below the largest integer; a tiny slack keeps 100.0001
    // Hz at two.
    ((rate_hz / MAX_RATE_HZ - 1e-3).ceil() as usize).max(1)
}

/// Every how many samples scenes show one: a multiple of [`stride`], so that all views show the same
/// instants.
pub(crate) fn scene_stride(rate_hz: f64) -> usize {
    let stride = stride(rate_hz);
    let view_hz = rate_hz / stride as f64;
    stride * ((view_hz / MAX_SCENE_RATE_HZ - 1e-3).ceil() as usize).max(1)
}

/// Facts of a whole take that its first sample depends on. They are gathered in
/// a first pass over the blocks of a take that is too long for memory.
#[derive(Clone, Debug, Default)]
pub struct Outline {
    /// Samples of the take.
    pub(crate) samples: usize,
    /// Findings about its source.
    pub(crate) findings: Vec<Finding>,
    /// Whether each body is present at any sample that views show.
    pub(crate) shown_bodies: Vec<bool>,
}

impl Outline {
    /// The outline of a take in memory.
    pub fn new(recording: &Recording) -> Self {
        let mut outline = Self::default();
        outline.add(recording);
        outline.findings.clone_from(&recording.findings);
        outline
    }

    /// Adds the samples that follow those so far. Findings of a block are not looked at.
    pub fn add(&mut self, block: &Recording) {
        let stride = stride(block.clock.rate_hz());
        // The first sample of the block that views show.
        let first = self.samples.next_multiple_of(stride) - self.samples;
        self.shown_bodies.resize(block.bodies.len(), false);
        for (shown, body) in self.shown_bodies.iter_mut().zip(&block.bodies) {
            let mut samples = (first..block.len()).step_by(stride);
            *shown = *shown || samples.any(|row| body.track.status(row).is_present());
        }
        self.samples += block.len();
    }

    /// Adds findings about the whole take's source.
    #[must_use]
    pub fn with_findings(mut self, findings: Vec<Finding>) -> Self {
        self.findings = findings;
        self
    }
}
