//! Targets of a plan.

use inhand_model::{Configuration, EndConditions, Finger, Hand, Object, PerFinger, Pose, Position};

/// Positions (metres) or velocities (m/s) of some of the fingers, hand frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tips(
    /// What is given of each finger.
    pub PerFinger<Option<[f64; 3]>>,
);

impl From<Configuration> for Tips {
    fn from(all: Configuration) -> Self {
        Self::from(&all)
    }
}

impl From<&Configuration> for Tips {
    fn from(all: &Configuration) -> Self {
        let tips = all.as_chunks::<3>().0;
        Self(PerFinger::from_fn(|finger| Some(tips[finger.index()])))
    }
}

impl From<PerFinger<Option<[f64; 3]>>> for Tips {
    fn from(some: PerFinger<Option<[f64; 3]>>) -> Self {
        Self(some)
    }
}

/// Positions to be passed at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// Seconds since the first sample; taken to the nearest sample.
    pub time_s: f64,
    /// Positions of some of the fingers, metres, hand frame.
    pub tips: Tips,
}

/// Fingers that stay near their contact points on an object that moves in a known way:
/// `|f_i(t) - hand_from_object(t) c_i| <= tau` at every sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Holding {
    /// Pose of the object at each sample (N), such as [`object_between`](crate::object_between).
    pub hand_from_object: Vec<Pose<Hand, Object>>,
    /// Contact point of each finger that holds, such as [`held_fingers`](crate::held_fingers).
    pub contacts: PerFinger<Option<Position<Object>>>,
    /// How far a fingertip may be from its contact point, metres.
    pub tau_m: f64,
}

/// Goal of a plan, all of it optional, any part on any of the fingers; hand frame, metres
/// and m/s. What is not given follows from the demonstrations.
///
/// ```
/// use inhand_model::Finger;
/// use inhand_planner::{Target, Tips};
///
/// // Thumb and index from here to there, over a point half a second later; the others follow.
/// let target = Target::new()
///     .first([0.03; 15])
///     .last([0.05; 15])
///     .waypoint(0.5, [0.045; 15])
///     .only(&[Finger::Thumb, Finger::Index]);
/// # let _ = target;
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Target {
    pub(crate) first_m: Tips,
    pub(crate) last_m: Tips,
    pub(crate) first_velocity_m_s: Tips,
    pub(crate) last_velocity_m_s: Tips,
    pub(crate) waypoints: Vec<Waypoint>,
    /// Velocities from the sample at a time to the next one, m/s.
    pub(crate) steps: Vec<Waypoint>,
    /// When constraints begin to hold, seconds since the first sample.
    pub(crate) constrained_from_s: f64,
    /// When the state is known: what is given there is a fact, not a wish.
    pub(crate) now_s: Option<f64>,
    pub(crate) object_first: Option<Pose<Hand, Object>>,
    pub(crate) object_last: Option<Pose<Hand, Object>>,
    /// Whether it is an error that segments do not carry the object.
    pub(crate) object_needed: bool,
    pub(crate) holding: Option<Holding>,
}

impl Target {
    /// A target that gives nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Where fingertips start: all of them (a configuration) or some.
    #[must_use]
    pub fn first(mut self, tips: impl Into<Tips>) -> Self {
        self.first_m = tips.into();
        self
    }

    /// Where fingertips end.
    #[must_use]
    pub fn last(mut self, tips: impl Into<Tips>) -> Self {
        self.last_m = tips.into();
        self
    }

    /// Velocities on arriving at the start, m/s. Dictionaries of positions take them as those from
    /// the first sample to the second, a smooth curve with a deviation as end conditions.
    #[must_use]
    pub fn first_velocity(mut self, tips: impl Into<Tips>) -> Self {
        self.first_velocity_m_s = tips.into();
        self
    }

    /// Velocities on leaving the end, m/s.
    #[must_use]
    pub fn last_velocity(mut self, tips: impl Into<Tips>) -> Self {
        self.last_velocity_m_s = tips.into();
        self
    }

    /// Another waypoint: positions at a time in seconds since the first sample.
    #[must_use]
    pub fn waypoint(mut self, time_s: f64, tips: impl Into<Tips>) -> Self {
        let tips = tips.into();
        self.waypoints.push(Waypoint { time_s, tips });
        self
    }

    /// Velocities (m/s) of the motion itself at a time in seconds since the first sample: from the
    /// nearest sample to the next one (from the last sample but one, where that is the last).
    #[must_use]
    pub fn velocity_at(mut self, time_s: f64, tips: impl Into<Tips>) -> Self {
        let tips = tips.into();
        self.steps.push(Waypoint { time_s, tips });
        self
    }

    /// Constraints of the settings hold from this time on, in seconds since the first sample: what
    /// came before is over.
    #[must_use]
    pub fn constrained_from(mut self, time_s: f64) -> Self {
        self.constrained_from_s = time_s;
        self
    }

    /// Where the object is at the first sample. Needs segments that carry the object.
    #[must_use]
    pub fn object_first(mut self, hand_from_object: Pose<Hand, Object>) -> Self {
        self.object_first = Some(hand_from_object);
        self.object_needed = true;
        self
    }

    /// Where the object is at the last sample. Segments know its rotation only since the first
    /// sample, so the first pose has to be given too.
    #[must_use]
    pub fn object_last(mut self, hand_from_object: Pose<Hand, Object>) -> Self {
        self.object_last = Some(hand_from_object);
        self.object_needed = true;
        self
    }

    /// Fingers that stay near their contact points.
    #[must_use]
    pub fn holding(mut self, holding: Holding) -> Self {
        self.holding = Some(holding);
        self
    }

    /// The same target for some of the fingers: what is given of the others (at the ends and at
    /// waypoints) is dropped, and they follow the demonstrations.
    #[must_use]
    pub fn only(mut self, fingers: &[Finger]) -> Self {
        let keep = |tips: &mut Tips| {
            for finger in Finger::ALL {
                if !fingers.contains(&finger) {
                    tips.0[finger] = None;
                }
            }
        };
        keep(&mut self.first_m);
        keep(&mut self.last_m);
        keep(&mut self.first_velocity_m_s);
        keep(&mut self.last_velocity_m_s);
        for waypoint in self.waypoints.iter_mut().chain(&mut self.steps) {
            keep(&mut waypoint.tips);
        }
        self
    }
}

impl From<EndConditions> for Target {
    fn from(ends: EndConditions) -> Self {
        Self::from(&ends)
    }
}

/// Everything that the end conditions give; the object where segments carry it.
impl From<&EndConditions> for Target {
    fn from(ends: &EndConditions) -> Self {
        Self {
            object_first: ends.object.map(|object| object.first),
            object_last: ends.object.map(|object| object.last),
            ..Self::new()
                .first(ends.first_m)
                .last(ends.last_m)
                .first_velocity(ends.first_velocity_m_s)
                .last_velocity(ends.last_velocity_m_s)
        }
    }
}
