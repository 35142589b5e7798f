//! Fingers that hold the object, in targets made from boundary conditions.

use inhand_contact::FingerOffsets;
use inhand_model::{
    Configuration, EndConditions, ObjectEnds, PerFinger, Segments, Shape, Trajectory,
};

use crate::error::PlanError;
use crate::method::Method;
use crate::object::{held_fingers, object_between};
use crate::planner::Planner;
use crate::target::{Holding, Target};

/// What fingers that hold need to be known by.
#[derive(Clone, Debug)]
pub struct Hold {
    /// Shape of the object.
    pub shape: Shape,
    /// How far pads reach beyond markers.
    pub offsets: FingerOffsets,
    /// Distance to the surface up to which a finger touches, metres.
    pub tau_m: f64,
}

impl Hold {
    /// The fingers in contact at both ends, held to their contact points.
    ///
    /// # Errors
    ///
    /// As [`held_fingers`].
    pub fn holding(
        &self,
        first_m: &Configuration,
        last_m: &Configuration,
        object: &ObjectEnds,
        samples: usize,
    ) -> Result<Holding, PlanError> {
        Ok(Holding {
            hand_from_object: object_between(object, samples),
            contacts: held_fingers(
                &self.shape,
                &self.offsets,
                self.tau_m,
                first_m,
                last_m,
                object,
            )?,
            tau_m: self.tau_m,
        })
    }
}

impl Planner {
    /// What the method is given of a segment. Fingers hold where three or more are in contact at both
    /// ends; elsewhere there is nothing to hold on to. A method that does not know the start must not
    /// learn of it from what fingers hold.
    ///
    /// # Errors
    ///
    /// As [`held_fingers`], but for too few fingers.
    pub fn target(&self, ends: &EndConditions, hold: Option<&Hold>) -> Result<Target, PlanError> {
        let target = match self.method() {
            Some(method) => method.target(ends),
            None => Target::from(ends),
        };
        let knows_start = self.method() != Some(Method::Paper);
        let (Some(hold), Some(object), true) = (hold, ends.object, knows_start) else {
            return Ok(target);
        };
        let samples = self.layout().samples;
        match hold.holding(&ends.first_m, &ends.last_m, &object, samples) {
            Ok(holding) => Ok(target.holding(holding)),
            Err(PlanError::TooFewHold { .. }) => Ok(target),
            Err(error) => Err(error),
        }
    }

    /// Mahalanobis distance of each recorded fingertip from a plan between the ends of a segment, at each of its samples.
    ///
    /// # Errors
    ///
    /// As [`Planner::corridor`].
    pub fn distances(
        &self,
        planned: &Trajectory,
        recorded: &Segments,
        segment: usize,
    ) -> Result<Vec<PerFinger<f64>>, PlanError> {
        let corridor = self.corridor(&Target::from(&recorded.ends()[segment]))?;
        let samples = 0..recorded.layout().samples;
        let distances = samples.map(|t| {
            PerFinger::from_fn(|finger| {
                corridor.mahalanobis(planned, t, finger, recorded.position(segment, t, finger))
            })
        });
        Ok(distances.collect())
    }
}
