//! Comparison of planned with recorded motion. Lengths are metres; the report turns them
//! into millimetres.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize, Serializer};

use crate::contact_dynamics::ContactDynamics;
use crate::deviation_predictor::{Bandwidths, PredictorWeights};
use crate::dictionary::{Dictionary, DictionaryKind, MethodChoice, StopReason, VelocityBounds};
use crate::finding::{Finding, Severity};
use crate::finger::{Finger, HandAndFingers, PerFinger};
use crate::inspection::Inspection;
use crate::intervals::Intervals;
use crate::movement::MovementAnalysis;
use crate::plan::ConstraintFamily;
use crate::protocol::Protocol;
use crate::recording::{LengthUnit, RotationOrder, UpAxis};
use crate::residual::{Residual, SmoothCurve, Validation};
use crate::roles::Roles;
use crate::statistics::Statistics;
use crate::track::TrackCounts;
use crate::units::{AsIs, Degrees, Millimetres, SquareMillimetres, Unit};

/// How much of the planned motion lies where the training takes have been.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reachability {
    /// Instants judged, each finger.
    pub n: usize,
    /// Share of instants inside the training hull, each finger.
    #[serde(serialize_with = "with_mean", deserialize_with = "AsIs::deserialize")]
    pub inside: PerFinger<f64>,
    /// Share of recorded instants inside, each finger: what the test takes themselves do.
    #[serde(serialize_with = "with_mean", deserialize_with = "AsIs::deserialize")]
    pub recorded_inside: PerFinger<f64>,
    /// Farthest distance outside the hull, each finger, metres; 0 when never outside, NaN without instants.
    #[serde(rename = "worst_outside_mm", with = "Millimetres")]
    pub worst_outside_m: PerFinger<f64>,
    /// Signed distance to the surface of the hull, each finger: negative inside.
    #[serde(rename = "distance_mm", with = "Millimetres")]
    pub distance: PerFinger<Statistics>,
}

/// How near fingertips come to one another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Collision {
    /// Instants judged.
    pub n: usize,
    /// Distance below which two fingertips count as colliding, metres.
    #[serde(rename = "limit_mm", with = "Millimetres")]
    pub limit_m: f64,
    /// Instants with a pair nearer than the limit.
    pub instants: usize,
    /// Trajectories with at least one such instant.
    pub trajectories: usize,
    /// Smallest distance of any pair at any instant, metres; NaN without instants.
    #[serde(rename = "nearest_mm", with = "Millimetres")]
    pub nearest_m: f64,
    /// The pair that came so near; `None` without instants.
    pub nearest_pair: Option<(Finger, Finger)>,
    /// Instants of the recorded motion with a pair nearer than the limit.
    pub recorded_instants: usize,
    /// Smallest distance of any pair of the recorded motion, metres; NaN without instants.
    #[serde(rename = "recorded_nearest_mm", with = "Millimetres")]
    pub recorded_nearest_m: f64,
}

/// Share of instants with three or more contacts at one threshold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TauShare {
    /// Threshold, metres.
    #[serde(rename = "tau_mm", with = "Millimetres")]
    pub tau_m: f64,
    /// Share, planned.
    #[serde(with = "AsIs")]
    pub three_or_more: f64,
    /// Share, recorded.
    #[serde(with = "AsIs")]
    pub recorded_three_or_more: f64,
}

/// Contacts of the fingertips with the object.
///
/// A finger is in contact where its pad is within `tau_m` of the object's surface, outside or inside;
/// one deeper inside than that is not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactShare {
    /// Instants judged (those with a tracked object).
    pub n: usize,
    /// Instants among `n` at which a fingertip or the object was filled.
    pub n_filled: usize,
    /// Instants left out: the object was not tracked, a gap, or a plan that failed.
    pub n_left_out: usize,
    /// Largest distance to the surface, from outside or inside, that counts as contact, metres.
    #[serde(rename = "tau_mm", with = "Millimetres")]
    pub tau_m: f64,
    /// Share of instants with three or more fingers in contact, planned.
    #[serde(with = "AsIs")]
    pub three_or_more: f64,
    /// The same, recorded.
    #[serde(with = "AsIs")]
    pub recorded_three_or_more: f64,
    /// Share of instants in contact, each finger, planned.
    #[serde(with = "AsIs")]
    pub by_finger: PerFinger<f64>,
    /// The same, recorded.
    #[serde(with = "AsIs")]
    pub recorded_by_finger: PerFinger<f64>,
    /// How the three-contact share moves with the threshold.
    pub by_tau: Vec<TauShare>,
}

/// Velocities of planned motion against their bounds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VelocityCheck {
    /// Steps judged (trajectories x 99 x 15).
    pub n: usize,
    /// Steps outside the bounds by more than 1e-6 of the bound.
    pub outside: usize,
    /// Trajectories with at least one such step.
    pub trajectories_outside: usize,
    /// Largest ratio of a velocity to its bound; NaN without steps.
    #[serde(with = "AsIs")]
    pub worst_ratio: f64,
}

/// Planned against recorded pose of the object, at every instant where both are known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectError {
    /// Distance between the origins, metres.
    pub position: Statistics,
    /// Angle of the rotation from one to the other, 0 to pi, radians.
    pub angle: Statistics,
}

/// How often the recorded motion lies within a prediction region of a stated width.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CorridorCoverage {
    /// Share of instants that the region was made to hold, 0 to 1.
    pub share_stated: f64,
    /// Its width, as a Mahalanobis distance, without unit.
    #[serde(with = "AsIs")]
    pub mahalanobis: f64,
    /// Instants judged, those of every finger added up.
    pub n: usize,
    /// Instants among `n` at which the fingertip was filled.
    pub n_filled: usize,
    /// Instants left out: a gap, a plan that failed, or one without region.
    pub n_left_out: usize,
    /// Share of the `n` instants inside; NaN without any.
    #[serde(rename = "inside", with = "AsIs")]
    pub share_inside: HandAndFingers<f64>,
}

/// How planning went.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanFacts {
    /// Plans with a trajectory.
    pub solved: usize,
    /// Plans shown to be infeasible.
    pub infeasible: usize,
    /// Plans that ended in neither.
    pub failed: usize,
    /// Worst recomputed optimality residual over all plans.
    #[serde(with = "AsIs")]
    pub worst_kkt_residual: f64,
    /// Plans with at least one active velocity bound.
    pub velocity_bound_active: usize,
    /// What each family of constraints did; families that were off are not there.
    #[serde(rename = "constraints", default)]
    pub families: Vec<FamilyFacts>,
    /// Plans with a fingertip outside its training hull; `None` where no hulls are known.
    pub outside_hull: Option<usize>,
}

/// What one family of constraints did to the plans of a method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FamilyFacts {
    /// The family.
    #[serde(flatten, with = "family_and_unit")]
    pub family: ConstraintFamily,
    /// Plans with at least one active bound.
    pub active: usize,
    /// Largest violation over all plans with a trajectory, in the family's
    /// [unit](ConstraintFamily::unit); negative where every bound is kept with room to spare.
    #[serde(with = "AsIs")]
    pub worst_violation: f64,
    /// Infeasible plans that would have a solution if this family alone gave way.
    pub would_mend: usize,
    /// The most that it would have to give way for one of them, in the family's unit.
    #[serde(with = "AsIs")]
    pub largest_relaxation: f64,
}

/// What was learned of deviations from the smooth curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DeviationFacts {
    /// Primitives of all parts.
    pub primitives: usize,
    /// Demonstrations that the expectation rests on.
    pub demonstrations: usize,
    /// Weights of its parts.
    #[serde(flatten)]
    pub weights: PredictorWeights,
    /// Widths of its kernels.
    #[serde(flatten)]
    pub bandwidths: Bandwidths,
    /// The smooth curve.
    #[serde(default)]
    pub curve: SmoothCurve,
    /// How the weights were chosen.
    pub validation: Validation,
}

/// One method against the recorded motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MethodEvaluation {
    /// Name, such as `prior`.
    pub name: String,
    /// What it knows and does, in a line.
    pub description: String,
    /// Whether it uses nothing learned.
    pub baseline: bool,
    /// Distance between planned and recorded fingertip over all instants, of all fingers together and of each.
    #[serde(rename = "error_mm", with = "Millimetres")]
    pub error: HandAndFingers<Statistics>,
    /// Error at the first sample of each trajectory, all fingers.
    #[serde(rename = "error_at_start_mm", with = "Millimetres")]
    pub error_at_start: Statistics,
    /// Error at the last sample of each trajectory, all fingers.
    #[serde(rename = "error_at_goal_mm", with = "Millimetres")]
    pub error_at_goal: Statistics,
    /// Median over trajectories of the pooled error at each sample of a segment, metres.
    #[serde(rename = "median_error_by_sample_mm", with = "Millimetres")]
    pub median_error_by_sample_m: Vec<f64>,
    /// Where it goes compared to training.
    pub reachability: Reachability,
    /// How near fingertips come.
    pub collision: Collision,
    /// Velocities against the bounds.
    pub velocity: VelocityCheck,
    /// Contacts, where the object's pose and shape are known.
    pub contact: Option<ContactShare>,
    /// Absolute difference between planned and recorded distance to the object's surface, each finger;
    /// neither distance counts a side.
    #[serde(rename = "distance_difference_mm", default, with = "Millimetres")]
    pub distance_difference: Option<PerFinger<Statistics>>,
    /// Planned against recorded object; `None` where the method plans no object or no take has one.
    #[serde(flatten, with = "object_error")]
    pub object_error: Option<ObjectError>,
    /// Coverage of the region, one for each width; empty where the method plans no region.
    #[serde(default)]
    pub corridors: Vec<CorridorCoverage>,
    /// How planning went; `None` for baselines.
    pub plan: Option<PlanFacts>,
}

/// Source of a take: how it was written, and which of its entities have which role.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TakeSource {
    /// Format and version.
    pub format: String,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Unit of length in the file.
    pub length_unit: LengthUnit,
    /// Axis of the file that points up.
    pub up_axis: UpAxis,
    /// How the file writes rotations; `None` where it has none.
    pub rotation: Option<RotationOrder>,
    /// Hand, object and fingers; `None` where not all of them were identified.
    pub roles: Option<Roles>,
    /// Share of samples with a measured hand; `None` where markers stand for a body.
    pub hand_tracked: Option<f64>,
    /// Share of samples with a measured object; `None` also where it has no role.
    pub object_tracked: Option<f64>,
    /// What is missing of each fingertip.
    pub gaps: PerFinger<FingerGaps>,
}

/// Missing samples of a fingertip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FingerGaps {
    /// Share of samples without a position.
    pub missing: f64,
    /// Longest gap, seconds.
    pub longest_s: f64,
}

/// A take in an evaluation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TakeFacts {
    /// Name.
    pub name: String,
    /// Samples.
    pub samples: usize,
    /// Length, seconds.
    pub duration_s: f64,
    /// Segments it gave.
    pub segments: usize,
    /// Segments that it would have given in addition without gaps.
    pub left_out: usize,
    /// Segments of the take without gaps that are not complete, by what most of their missing samples lack: a finger,
    /// or the object. An interval after a gap has a grid of its own, so these may be more than those left out.
    #[serde(default)]
    pub left_out_by: BTreeMap<String, usize>,
    /// Where it comes from; `None` in evaluations of older versions.
    #[serde(default)]
    pub source: Option<TakeSource>,
}

/// The data behind an evaluation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SessionFacts {
    /// Name of the session.
    pub name: String,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Samples in a segment.
    pub segment_samples: usize,
    /// Object shape in words, such as `cube:0.05`.
    pub object: Option<String>,
    /// Who was recorded, where that is stated.
    pub participant: Option<String>,
    /// What they did, where that is stated.
    pub task: Option<String>,
    /// Training takes.
    pub train: Vec<TakeFacts>,
    /// Test takes.
    pub test: Vec<TakeFacts>,
}

/// The dictionary behind an evaluation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DictionaryFacts {
    /// How it was learned.
    pub kind: DictionaryKind,
    /// Primitives.
    pub rank: usize,
    /// Training segments.
    pub segments: usize,
    /// Root mean square of the reconstruction error, metres.
    #[serde(rename = "rms_mm", with = "Millimetres")]
    pub rms_m: f64,
    /// Relative Frobenius error.
    #[serde(with = "AsIs")]
    pub relative_error: f64,
    /// Iterations done.
    pub iterations: usize,
    /// Why learning stopped.
    pub stop_reason: StopReason,
    /// Objective after each sweep, m².
    #[serde(rename = "objective_history_mm2", with = "SquareMillimetres")]
    pub objective_history_m2: Vec<f64>,
    /// Velocity bounds that plans had to keep.
    #[serde(rename = "velocity_bounds_mm_s", with = "Millimetres")]
    pub velocity_bounds: VelocityBounds,
    /// Deviations from the smooth curve, where they were learned.
    pub deviation: Option<DeviationFacts>,
}

/// Methods compared with the recorded motion under [`Protocol::HeldOut`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeldOutEvaluation {
    /// Length of the lines that give boundary conditions, seconds.
    pub ends_s: f64,
    /// Samples of such a line, with the segment's first or last.
    pub ends_samples: usize,
    /// Test segments.
    pub segments: usize,
    /// Test segments that takes without gaps would have given in addition.
    pub left_out: usize,
    /// Deviations learned under this protocol; `None` where the dictionary has those of the published one alone.
    pub deviation: Option<DeviationFacts>,
    /// Methods, in the order of the published protocol.
    pub methods: Vec<MethodEvaluation>,
    /// How sure the numbers are and how methods differ; `None` where that was not worked out.
    pub intervals: Option<Intervals>,
}

/// What a take's data is worth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TakeQuality {
    /// Take.
    pub take: String,
    /// `train` or `test`.
    pub role: String,
    /// Share of samples in which the hand was tracked.
    #[serde(with = "AsIs")]
    pub hand_tracked: f64,
    /// Share of samples in which the object was tracked; `None` where it never was.
    #[serde(default, with = "AsIs")]
    pub object_tracked: Option<f64>,
    /// Each fingertip.
    pub fingers: PerFinger<TrackQuality>,
    /// What was odd about the take.
    pub findings: Vec<Finding>,
}

/// How much of a fingertip's track is known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrackQuality {
    /// Samples as recorded (filled is 0).
    pub recorded: TrackCounts,
    /// Samples after processing.
    pub processed: TrackCounts,
    /// Longest gap as recorded, seconds.
    pub longest_gap_s: f64,
}

/// Everything a report says about a session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// The data.
    pub session: SessionFacts,
    /// The method a reader should look at first.
    pub default_method: String,
    /// How methods compare on left-out training takes, where that was asked for.
    pub choice: Option<MethodChoice>,
    /// The dictionary.
    pub dictionary: DictionaryFacts,
    /// Methods under [`Protocol::Published`], learned ones first.
    pub methods: Vec<MethodEvaluation>,
    /// Methods under [`Protocol::HeldOut`]; `None` where they were not compared under it.
    #[serde(default)]
    pub held_out: Option<HeldOutEvaluation>,
    /// Distance between the references of the two protocols, at the instants judged under [`Protocol::Published`]:
    /// how far the filter moves fingertips. `None` without a filter, or where that was not worked out.
    #[serde(rename = "filter_moves_mm", default, with = "Millimetres")]
    pub filter_moves: Option<HandAndFingers<Statistics>>,
    /// What each take's data is worth.
    #[serde(with = "quality")]
    pub quality: Vec<TakeQuality>,
    /// How sure the numbers of [`Protocol::Published`] are and how methods differ; `None` where that was not worked
    /// out.
    pub intervals: Option<Intervals>,
    /// Lengths, speeds and smoothness of the motion; `None` where that was not worked out.
    pub movement: Option<MovementAnalysis>,
    /// What contacts do over time; `None` without an object of known shape.
    pub contacts: Option<ContactDynamics>,
    /// What was looked at before and after learning, and what was found; `None` where nothing was.
    #[serde(default)]
    pub inspection: Option<Inspection>,
    /// SHA-256 over inputs, settings and version, which all results of a run carry; `None` in files of before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub key: Option<String>,
}

impl DictionaryFacts {
    /// Facts of a dictionary, and the velocity bounds that plans had to keep.
    pub fn new(dictionary: &Dictionary, velocity_bounds: VelocityBounds) -> Self {
        let learning = &dictionary.learning;
        Self {
            kind: dictionary.kind,
            rank: dictionary.rank(),
            segments: learning.segments,
            rms_m: learning.rms_m,
            relative_error: learning.relative_error,
            iterations: learning.iterations,
            stop_reason: learning.stop_reason,
            objective_history_m2: learning.objective_history_m2.clone(),
            velocity_bounds,
            deviation: dictionary.residual.as_ref().map(DeviationFacts::new),
        }
    }
}

impl DeviationFacts {
    /// Facts of learned deviations.
    pub fn new(residual: &Residual) -> Self {
        Self {
            primitives: residual.primitives.ncols(),
            demonstrations: residual.expectation.demonstrations(),
            weights: residual.expectation.weights(),
            bandwidths: residual.expectation.bandwidths(),
            curve: residual.curve,
            validation: residual.validation,
        }
    }
}

impl Evaluation {
    /// Methods under a protocol; none where they were not compared under it.
    pub fn methods(&self, protocol: Protocol) -> &[MethodEvaluation] {
        match protocol {
            Protocol::Published => &self.methods,
            Protocol::HeldOut => (self.held_out.as_ref()).map_or(&[], |held_out| &held_out.methods),
        }
    }

    /// Names of the default method and of the baseline with the smallest mean error, held out where there is that.
    pub fn compared(&self) -> BTreeSet<&str> {
        let protocols = [Protocol::HeldOut, Protocol::Published].map(|p| self.methods(p));
        let methods = protocols.into_iter().find(|methods| !methods.is_empty());
        let methods = methods.into_iter().flatten();
        let best = (methods.filter(|m| m.baseline && m.error.all.mean.is_finite()))
            .min_by(|a, b| a.error.all.mean.total_cmp(&b.error.all.mean));
        let best = best.map(|method| method.name.as_str());
        best.into_iter()
            .chain([self.default_method.as_str()])
            .collect()
    }

    /// Plans without a trajectory, over all methods and protocols.
    pub fn failed_plans(&self) -> usize {
        let methods = Protocol::ALL
            .into_iter()
            .flat_map(|protocol| self.methods(protocol));
        let plans = methods.filter_map(|method| method.plan.as_ref());
        plans.map(|plans| plans.infeasible + plans.failed).sum()
    }

    /// Intervals under a protocol, where they were worked out.
    pub fn intervals(&self, protocol: Protocol) -> Option<&Intervals> {
        match protocol {
            Protocol::Published => self.intervals.as_ref(),
            Protocol::HeldOut => self.held_out.as_ref()?.intervals.as_ref(),
        }
    }
}

impl TakeQuality {
    /// Findings that may affect a number.
    pub fn warnings(&self) -> usize {
        (self.findings.iter())
            .filter(|finding| finding.severity == Severity::Warning)
            .count()
    }
}

/// Shares of fingers with their mean, which reading leaves out: each finger was judged at the same instants.
fn with_mean<S: Serializer>(shares: &PerFinger<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    let (all, by_finger) = (shares.mean(), *shares);
    AsIs::serialize(&HandAndFingers { all, by_finger }, serializer)
}

/// A family of constraints beside the unit of its numbers.
mod family_and_unit {
    use super::ConstraintFamily;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Serialize, Deserialize)]
    struct Keys {
        family: ConstraintFamily,
        #[serde(skip_deserializing)]
        unit: &'static str,
    }

    pub(super) fn serialize<S: Serializer>(
        family: &ConstraintFamily,
        s: S,
    ) -> Result<S::Ok, S::Error> {
        let (family, unit) = (*family, family.unit());
        Keys { family, unit }.serialize(s)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        d: D,
    ) -> Result<ConstraintFamily, D::Error> {
        Keys::deserialize(d).map(|keys| keys.family)
    }
}

/// Position and angle of the object as two keys, null where there are none.
mod object_error {
    use super::{Degrees, Millimetres, ObjectError, Statistics, Unit};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Serialize, Deserialize)]
    struct Keys {
        #[serde(rename = "object_error_mm", default, with = "Millimetres")]
        position: Option<Statistics>,
        #[serde(rename = "object_angle_deg", default, with = "Degrees")]
        angle: Option<Statistics>,
    }

    pub(super) fn serialize<S: Serializer>(
        error: &Option<ObjectError>,
        s: S,
    ) -> Result<S::Ok, S::Error> {
        let keys = Keys {
            position: error.map(|error| error.position),
            angle: error.map(|error| error.angle),
        };
        keys.serialize(s)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        d: D,
    ) -> Result<Option<ObjectError>, D::Error> {
        let Keys { position, angle } = Keys::deserialize(d)?;
        Ok((position.zip(angle)).map(|(position, angle)| ObjectError { position, angle }))
    }
}

/// Takes with the number of their warnings, which reading leaves out.
mod quality {
    use super::TakeQuality;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Serialize, Deserialize)]
    struct Keys<T> {
        #[serde(skip_deserializing)]
        warnings: usize,
        takes: T,
    }

    pub(super) fn serialize<S: Serializer>(takes: &[TakeQuality], s: S) -> Result<S::Ok, S::Error> {
        let warnings = takes.iter().map(TakeQuality::warnings).sum();
        Keys { warnings, takes }.serialize(s)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        d: D,
    ) -> Result<Vec<TakeQuality>, D::Error> {
        Keys::deserialize(d).map(|keys| keys.takes)
    }
}
