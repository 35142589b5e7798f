//! Entities with columns in tables: markers, bodies, fingertips.

use inhand_model::{
    BodyKind, Finger, Frame, MarkerKind, Motion, PointTrack, PoseTrack, Recording, Status,
};

/// Position, metres, and rotation, a unit quaternion (x, y, z, w), where there is one.
pub(crate) type Value = ([f64; 3], Option<[f64; 4]>);

/// One tracked thing with what is known of it at every sample.
pub struct Entity<'a> {
    /// Its name, not always unique.
    pub name: String,
    /// What it is: `labelled`, `rigid_body_marker`, `unlabelled`, `rigid_body`, `bone`,
    /// `fingertip`, `object`, `hand`.
    pub kind: &'static str,
    /// Frame of its coordinates.
    pub frame: &'static str,
    /// Whether it has a rotation.
    pub has_rotation: bool,
    /// A number of the source for each sample, NaN where missing: its name with unit, and unit.
    pub(crate) extra: Option<(&'static str, &'static str, &'a [f64])>,
    pub(crate) track: Box<dyn Track + 'a>,
}

/// What tables need of a track.
pub(crate) trait Track: Sync {
    fn value(&self, k: usize) -> Option<Value>;
    fn status(&self, k: usize) -> Status;
}

impl<F: Frame> Track for &PointTrack<F> {
    fn value(&self, k: usize) -> Option<Value> {
        Some((self.get(k)?.to_array(), None))
    }

    fn status(&self, k: usize) -> Status {
        PointTrack::status(self, k)
    }
}

impl<To: Frame, From: Frame> Track for &PoseTrack<To, From> {
    fn value(&self, k: usize) -> Option<Value> {
        let pose = self.get(k)?;
        Some((pose.origin().to_array(), Some(pose.quaternion_xyzw())))
    }

    fn status(&self, k: usize) -> Status {
        PoseTrack::status(self, k)
    }
}

impl std::fmt::Debug for Entity<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Entity({} {})", self.kind, self.name)
    }
}

/// Bodies, then markers of a recording, in `world`.
pub fn recording_entities(recording: &Recording) -> Vec<Entity<'_>> {
    let bodies = recording.bodies.iter().map(|body| Entity {
        name: body.name.clone(),
        kind: match body.kind {
            BodyKind::RigidBody => "rigid_body",
            BodyKind::Bone => "bone",
        },
        frame: "world",
        has_rotation: true,
        extra: (body.marker_error_m.as_deref()).map(|series| ("marker_error_m", "m", series)),
        track: Box::new(&body.track),
    });
    let markers = recording.markers.iter().map(|marker| Entity {
        name: marker.name.clone(),
        kind: match marker.kind {
            MarkerKind::Labelled => "labelled",
            MarkerKind::RigidBodyMarker => "rigid_body_marker",
            MarkerKind::Unlabelled => "unlabelled",
        },
        frame: "world",
        has_rotation: false,
        extra: (marker.quality.as_deref()).map(|series| ("quality", "1", series)),
        track: Box::new(&marker.track),
    });
    bodies.chain(markers).collect()
}

/// Fingertips and object of a motion in `hand`, and the hand itself in `world`.
pub fn motion_entities(motion: &Motion) -> Vec<Entity<'_>> {
    let mut entities: Vec<Entity<'_>> = (Finger::ALL.into_iter())
        .map(|finger| Entity {
            name: finger.name().to_owned(),
            kind: "fingertip",
            frame: "hand",
            has_rotation: false,
            extra: None,
            track: Box::new(&motion.fingertips[finger]),
        })
        .collect();
    if let Some(object) = &motion.object {
        entities.push(Entity {
            name: "object".to_owned(),
            kind: "object",
            frame: "hand",
            has_rotation: true,
            extra: None,
            track: Box::new(object),
        });
    }
    entities.push(Entity {
        name: "hand".to_owned(),
        kind: "hand",
        frame: "world",
        has_rotation: true,
        extra: None,
        track: Box::new(&motion.hand),
    });
    entities
}
