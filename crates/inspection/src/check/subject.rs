//! A take that is checked, with what its roles name.

use std::borrow::Cow;

use inhand_model::{
    Body, BodySource, Finger, PointTrack, PoseTrack, Recording, Roles, TrackedBody, World,
};
use inhand_motion::{BodyRole, MotionError, Templates, fit_templates, role_body};

use super::CheckSettings;

/// A take, the limits of its check, and hand, object and fingertips; none of these without roles.
pub(crate) struct Subject<'a> {
    pub(crate) recording: &'a Recording,
    pub(crate) settings: &'a CheckSettings,
    pub(crate) templates: Templates,
    pub(crate) fingertips: Vec<(Finger, &'a PointTrack<World>)>,
    roles: Option<&'a Roles>,
    bodies: Vec<(BodyRole, Cow<'a, TrackedBody>)>,
}

impl<'a> Subject<'a> {
    pub(crate) fn new(recording: &'a Recording, settings: &'a CheckSettings) -> Self {
        Self {
            recording,
            settings,
            templates: Templates::default(),
            fingertips: Vec::new(),
            roles: None,
            bodies: Vec::new(),
        }
    }

    /// Looks up what the roles name, and fits bodies to marker clusters.
    pub(crate) fn set_roles(&mut self, roles: &'a Roles) -> Result<(), MotionError> {
        let recording = self.recording;
        self.templates = fit_templates([(recording, roles)])?;
        self.roles = Some(roles);
        self.fingertips = (roles.fingers.iter())
            .filter_map(|(finger, name)| Some((finger, &recording.marker(name)?.track)))
            .collect();
        self.bodies = BodyRole::ALL
            .into_iter()
            .filter_map(|role| {
                let body = role_body(recording, role, role.source(roles)?, &self.templates);
                Some((role, body.ok()?))
            })
            .collect();
        Ok(())
    }

    pub(crate) const fn has_roles(&self) -> bool {
        self.roles.is_some()
    }

    /// Hand and object with their poses.
    pub(crate) fn bodies(&self) -> impl Iterator<Item = (BodyRole, &PoseTrack<World, Body>)> {
        self.bodies.iter().map(|(role, body)| (*role, &body.track))
    }

    pub(crate) fn body(&self, role: BodyRole) -> Option<&PoseTrack<World, Body>> {
        let (_, track) = self.bodies().find(|(other, _)| *other == role)?;
        Some(track)
    }

    /// Whether a role is played by the marker or body of this name.
    pub(crate) fn plays_a_role(&self, name: &str) -> bool {
        let names = |source: &BodySource| match source {
            BodySource::RigidBody(body) => body == name,
            BodySource::Markers(markers) => markers.iter().any(|m| m == name),
        };
        self.roles.is_some_and(|roles| {
            roles.fingers.as_array().iter().any(|m| m == name)
                || BodyRole::ALL
                    .iter()
                    .filter_map(|role| role.source(roles))
                    .any(names)
        })
    }
}
