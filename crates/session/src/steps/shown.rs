//! Demonstrated range of training motions: fingertip hulls and speeds.

use inhand_contact::hull;
use inhand_curves::velocity;
use inhand_model::{
    Demonstrated, Finger, Hand, Motion, PerFinger, Position, SEGMENT_COORDINATES, VelocityBounds,
};

use crate::error::{Located, SessionError};

/// What motions have shown so far, in as little room as it needs.
#[derive(Clone, Debug)]
pub struct Shown {
    /// Positions that the hull of each fingertip can have corners at, metres.
    corners: PerFinger<Vec<Position<Hand>>>,
    velocity: VelocityBounds,
}

impl Default for Shown {
    fn default() -> Self {
        Self {
            corners: PerFinger::from_fn(|_| Vec::new()),
            velocity: VelocityBounds {
                min_m_s: [f64::INFINITY; SEGMENT_COORDINATES],
                max_m_s: [f64::NEG_INFINITY; SEGMENT_COORDINATES],
            },
        }
    }
}

impl Shown {
    /// What the selected samples of a motion show: the corners of its hulls and its velocity
    /// extremes.
    pub fn of(motion: &Motion) -> Self {
        let motion = motion.selected_only();
        let corners = Finger::ALL.map(|finger| {
            let track = &motion.fingertips[finger];
            let points: Vec<_> = track.iter().flatten().collect();
            match hull(&points) {
                Ok(hull) => (hull.vertices_m.iter())
                    .map(|[x, y, z]| Position::new(*x, *y, *z))
                    .collect(),
                // A take may be too short or too flat for a hull of its own, and still add to one.
                Err(_) => points,
            }
        });
        let mut corners = corners.into_iter();
        Self {
            corners: PerFinger::from_fn(|_| corners.next().unwrap_or_default()),
            velocity: velocity::extremes([motion.as_ref()]).unwrap_or(Self::default().velocity),
        }
    }

    /// Adds what another motion shows.
    pub fn add(&mut self, other: &Self) {
        for finger in Finger::ALL {
            self.corners[finger].extend_from_slice(&other.corners[finger]);
        }
        let (velocity, other) = (&mut self.velocity, &other.velocity);
        for i in 0..SEGMENT_COORDINATES {
            velocity.min_m_s[i] = velocity.min_m_s[i].min(other.min_m_s[i]);
            velocity.max_m_s[i] = velocity.max_m_s[i].max(other.max_m_s[i]);
        }
    }

    /// Hulls and velocity bounds of all motions.
    ///
    /// # Errors
    ///
    /// [`SessionError::At`] where a fingertip was never seen, or does not move.
    pub fn demonstrated(&self) -> Result<Demonstrated, SessionError> {
        let hulls = inhand_parallel::try_map(&Finger::ALL, |&finger| {
            hull(&self.corners[finger]).during(format_args!("training hull of the {finger} finger"))
        })?;
        let mut hulls = hulls.into_iter();
        let hulls = PerFinger::from_fn(|_| hulls.next().expect("a hull for each finger"));
        let bounds = self.velocity.min_m_s.iter().chain(&self.velocity.max_m_s);
        if !bounds.copied().all(f64::is_finite) {
            // A hull needs points, so there are neighbouring samples unless every other one is
            // missing.
            let message = "no two neighbouring samples are present in the training takes";
            return Err(SessionError::data("training takes", message));
        }
        Ok(Demonstrated {
            hulls,
            velocity: self.velocity,
        })
    }
}

/// What training motions show: hulls and velocity extremes.
///
/// # Errors
///
/// As [`Shown::demonstrated`].
pub fn demonstrated(motions: &[&Motion]) -> Result<Demonstrated, SessionError> {
    let each: Vec<Shown> = inhand_parallel::map(motions, |motion| Shown::of(motion));
    let mut all = Shown::default();
    for shown in &each {
        all.add(shown);
    }
    all.demonstrated()
}
