//! The messages of `schemas/inhand`, generated, and how values of the model are in them.

// Generated for a public module; here everything stays inside the crate.
#![expect(
    unreachable_pub,
    reason = "generated code is public; the module is not"
)]

include!("generated/inhand.rs");

use inhand_model as model;
use inhand_model::{Finger, Frame, PerFinger, PoseTrack};

use crate::take::ContactSample;
use crate::wire::{Point, Timestamp};

/// Conversions between enums of the model and those of messages, which have the same names.
macro_rules! enums {
    ($($name:ident { $($variant:ident),* })*) => {$(
        impl From<model::$name> for $name {
            fn from(value: model::$name) -> Self {
                match value {
                    $(model::$name::$variant => $name::$variant,)*
                }
            }
        }

        impl $name {
            /// The value of the model, unless the number is none of them.
            pub(crate) fn to_model(number: i32) -> Option<model::$name> {
                match $name::try_from(number).ok()? {
                    $name::Unspecified => None,
                    $($name::$variant => Some(model::$name::$variant),)*
                }
            }
        }
    )*};
}

enums! {
    Status { Measured, Filled, Missing }
    PlanStatus { Solved, AlmostSolved, Infeasible, Failed }
    ConstraintFamily {
        Targets, TargetVelocities, Activations, Velocity, Acceleration, Reachability, Separation,
        Holding
    }
    DictionaryKind { Nmf, Pca }
    StopReason {
        Converged, TargetReached, IterationLimit, ClosedForm, NoLongerBetterOnLeftOutTakes
    }
    Protocol { Published, HeldOut }
    SmoothCurve { Hermite, MinimumJerk, Line }
}

impl Body {
    /// Takes over the pose at a sample.
    pub(crate) fn place<To: Frame, From: Frame>(&mut self, track: &PoseTrack<To, From>, k: usize) {
        let pose = track.get(k);
        self.position_m = pose.map(|pose| pose.origin().to_array().into());
        self.orientation = pose.map(|pose| pose.quaternion_xyzw().into());
        self.status = Status::from(track.status(k)).into();
    }
}

impl Fingertip {
    pub(crate) fn new(position_m: Option<[f64; 3]>, status: model::Status) -> Self {
        Self {
            position_m: position_m.map(Point::from),
            status: Status::from(status).into(),
        }
    }
}

impl Fingertips {
    pub(crate) fn new(unix_nanos: u64, tip: impl Fn(Finger) -> Fingertip) -> Self {
        let [thumb, index, middle, ring, little] = Finger::ALL.map(|finger| Some(tip(finger)));
        Self {
            timestamp: Some(Timestamp::from_unix_nanos(unix_nanos)),
            thumb,
            index,
            middle,
            ring,
            little,
        }
    }

    pub(crate) fn tips(&self) -> PerFinger<Option<Fingertip>> {
        PerFinger::new([self.thumb, self.index, self.middle, self.ring, self.little])
    }
}

impl FingerErrors {
    pub(crate) fn new(unix_nanos: u64, error_m: &PerFinger<f64>) -> Self {
        let [thumb_m, index_m, middle_m, ring_m, little_m] = error_m.as_array().map(model::stored);
        Self {
            timestamp: Some(Timestamp::from_unix_nanos(unix_nanos)),
            thumb_m,
            index_m,
            middle_m,
            ring_m,
            little_m,
        }
    }

    pub(crate) fn to_model(self) -> PerFinger<f64> {
        PerFinger::new([
            self.thumb_m,
            self.index_m,
            self.middle_m,
            self.ring_m,
            self.little_m,
        ])
    }
}

impl Contacts {
    pub(crate) fn new(unix_nanos: u64, contact: &ContactSample) -> Self {
        let (distance_m, in_contact) = (contact.distance_m.map(model::stored), &contact.in_contact);
        Self {
            timestamp: Some(Timestamp::from_unix_nanos(unix_nanos)),
            thumb_distance_m: distance_m[Finger::Thumb],
            index_distance_m: distance_m[Finger::Index],
            middle_distance_m: distance_m[Finger::Middle],
            ring_distance_m: distance_m[Finger::Ring],
            little_distance_m: distance_m[Finger::Little],
            thumb_in_contact: in_contact[Finger::Thumb],
            index_in_contact: in_contact[Finger::Index],
            middle_in_contact: in_contact[Finger::Middle],
            ring_in_contact: in_contact[Finger::Ring],
            little_in_contact: in_contact[Finger::Little],
            // At most the number of fingers.
            count: contact.count as u32,
        }
    }

    pub(crate) fn to_model(self) -> ContactSample {
        ContactSample {
            distance_m: PerFinger::new([
                self.thumb_distance_m,
                self.index_distance_m,
                self.middle_distance_m,
                self.ring_distance_m,
                self.little_distance_m,
            ]),
            in_contact: PerFinger::new([
                self.thumb_in_contact,
                self.index_in_contact,
                self.middle_in_contact,
                self.ring_in_contact,
                self.little_in_contact,
            ]),
            count: self.count as usize,
        }
    }
}
