//! Hand, object and fingertips of a take.

use inhand_model::{Body, Finger, PointTrack, PoseTrack, Recording, Roles, TrackedBody, World};
use inhand_motion::{BodyRole, MotionError, Templates, fit_templates, fitted_bodies};

/// What the roles of a take point at; empty where they cannot be told.
#[derive(Debug, Default)]
pub(crate) struct Parts<'a> {
    pub(crate) roles: Option<&'a Roles>,
    pub(crate) templates: Templates,
    pub(crate) fingertips: Vec<(Finger, &'a PointTrack<World>)>,
    hand: Option<BodyPart<'a>>,
    object: Option<BodyPart<'a>>,
}

#[derive(Debug)]
enum BodyPart<'a> {
    Tracked(&'a TrackedBody),
    Fitted(TrackedBody),
}

impl BodyPart<'_> {
    fn body(&self) -> &TrackedBody {
        match self {
            BodyPart::Tracked(body) => body,
            BodyPart::Fitted(body) => body,
        }
    }
}

impl<'a> Parts<'a> {
    /// Looks up what the roles name, and fits bodies to marker clusters.
    pub(crate) fn of(recording: &'a Recording, roles: &'a Roles) -> Result<Self, MotionError> {
        let templates = fit_templates([(recording, roles)])?;
        let mut fitted = fitted_bodies(recording, roles, &templates)?;
        let mut part = |role: BodyRole| -> Option<BodyPart<'a>> {
            match role.source(roles)? {
                inhand_model::BodySource::RigidBody(name) => {
                    recording.body(name).map(BodyPart::Tracked)
                }
                inhand_model::BodySource::Markers(_) => {
                    let place = fitted.iter().position(|body| body.name == role.name())?;
                    Some(BodyPart::Fitted(fitted.swap_remove(place)))
                }
            }
        };
        let hand = part(BodyRole::Hand);
        let object = part(BodyRole::Object);
        let fingertips = Finger::ALL
            .into_iter()
            .filter_map(|f| Some((f, &recording.marker(&roles.fingers[f])?.track)))
            .collect();
        Ok(Self {
            roles: Some(roles),
            templates,
            fingertips,
            hand,
            object,
        })
    }

    pub(crate) fn is_known(&self) -> bool {
        self.roles.is_some()
    }

    /// Hand and object with their poses.
    pub(crate) fn bodies(&self) -> impl Iterator<Item = (&'static str, &PoseTrack<World, Body>)> {
        let hand = self.hand.iter().map(|part| ("hand", &part.body().track));
        let object = self
            .object
            .iter()
            .map(|part| ("object", &part.body().track));
        hand.chain(object)
    }

    pub(crate) fn object(&self) -> Option<&PoseTrack<World, Body>> {
        self.object.as_ref().map(|part| &part.body().track)
    }

    /// Clusters that bodies are fitted to, with the names of their markers.
    pub(crate) fn clusters(&self) -> impl Iterator<Item = (&'static str, &[String])> {
        [BodyRole::Hand, BodyRole::Object]
            .into_iter()
            .filter_map(|role| {
                self.templates
                    .get(role)
                    .map(|template| (role.name(), template.markers()))
            })
    }

    /// Whether a role is played by the marker or body of this name.
    pub(crate) fn has_marker(&self, name: &str) -> bool {
        let Some(roles) = self.roles else {
            return false;
        };
        let of_body = |source: &inhand_model::BodySource| match source {
            inhand_model::BodySource::RigidBody(body) => body == name,
            inhand_model::BodySource::Markers(markers) => markers.iter().any(|m| m == name),
        };
        roles.fingers.as_array().iter().any(|m| m == name)
            || of_body(&roles.hand)
            || roles.object.as_ref().is_some_and(of_body)
    }
}
