//! Camera of a 3D panel.
//!
//! The camera goes with the hand: fingertips keep to their place in the view while the object turns
//! between them. A viewer that follows only where a frame is keeps the camera as it stood towards the
//! frame at first, so nothing would be gained for what is up.

use inhand_channels::Seen;
use inhand_model::{Frame, Hand, Object, World};
use serde_json::{Value, json};

use crate::content::Content;

/// Root of our trees of frames, z up.
const UPRIGHT: &str = "upright";

/// Least distance from fingertips around an object, metres.
const FINGERTIPS_M: f64 = 0.18;
/// Distance from a hand whose frame is on its back, metres: fingertips are a hand's breadth away.
const HAND_M: f64 = 0.5;
/// Least distance from fingertips that move about in the room, metres.
const ROOM_M: f64 = 0.5;
/// Distance in radii of what is looked at, and the most of it, metres.
const RADII: f64 = 3.0;
const MOST_M: f64 = 10.0;

/// Frame that a view follows, and what it looks at there.
pub(crate) struct Camera {
    /// Frame to follow; the viewer's choice where none is known.
    pub(crate) frame: Option<&'static str>,
    /// Where fingertips are in that frame, if that is known.
    pub(crate) seen: Option<Seen>,
    distance_m: f64,
}

impl Camera {
    /// The camera for the content: on fingertips in the hand's frame, else where fingertips or markers
    /// are first seen in the room, else on the object or the hand.
    pub(crate) fn of(content: &Content) -> Self {
        let (hand, world) = (
            content.has_frame(Hand::NAME),
            content.has_frame(World::NAME),
        );
        let in_hand = content.seen(Hand::NAME).filter(|_| hand);
        let in_room = content.seen(UPRIGHT);
        for (frame, seen, least_m) in [
            (Hand::NAME, in_hand, FINGERTIPS_M),
            (UPRIGHT, in_room, ROOM_M),
        ] {
            if let Some(seen) = seen {
                let distance_m = (RADII * seen.radius_m).clamp(least_m, MOST_M);
                return Self::at(frame, Some(seen), distance_m);
            }
        }
        if content.has_frame(Object::NAME) {
            return Self::at(Object::NAME, None, FINGERTIPS_M);
        }
        if hand {
            return Self::at(Hand::NAME, None, HAND_M);
        }
        Self {
            frame: world.then_some(UPRIGHT),
            seen: None,
            distance_m: 2.0,
        }
    }

    fn at(frame: &'static str, seen: Option<Seen>, distance_m: f64) -> Self {
        Self {
            frame: Some(frame),
            seen,
            distance_m,
        }
    }

    /// Writes the camera into the settings of a 3D panel.
    pub(crate) fn settings(&self, settings: &mut Value) {
        settings["cameraState"] = json!({
            "perspective": true,
            "distance": self.distance_m,
            "phi": 60,
            "thetaOffset": 45,
            "fovy": 45,
            // By default nothing nearer than half a metre is drawn.
            "near": 0.01,
            "far": 100,
            "target": [0, 0, 0],
            "targetOffset": self.seen.map_or([0.0; 3], |seen| seen.centre_m),
            "targetOrientation": [0, 0, 0, 1],
        });
        // The object turns: a camera that turned with it would show a still object.
        let turns = self.frame != Some(Object::NAME);
        settings["followMode"] = json!(if turns {
            "follow-pose"
        } else {
            "follow-position"
        });
        if let Some(frame) = self.frame {
            settings["followTf"] = json!(frame);
        }
    }
}
