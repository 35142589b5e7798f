//! Fingertips as spheres with short trails.

use std::collections::VecDeque;

use foxglove::messages::{
    Color, LinePrimitive, Point3, Pose, Quaternion, SceneEntity, SceneUpdate, SpherePrimitive,
    Vector3,
};
use inhand_model::{Finger, PerFinger};

use super::tips::{Contacts, Tips};
use crate::colour::{FINGER_COLOURS, Rgb};
use crate::error::ChannelError;
use crate::output::{ChannelId, Output};
use crate::wire::viewer_time;
use crate::write::{Instant, Stream};

/// Diameter of a fingertip, metres: about that of a marker, so that neighbours stay apart.
const SPHERE_M: f64 = 0.008;
/// Diameter of a fingertip that touches the object, metres.
const CONTACT_SPHERE_M: f64 = 0.012;
/// Opacity of a fingertip of which contact is not known.
const PLAIN_ALPHA: f64 = 0.8;
/// Opacity of a fingertip off the object, so that those on it stand out.
const OFF_ALPHA: f64 = 0.35;
/// Length of a trail, seconds.
const TRAIL_S: f64 = 0.4;
/// Time between the points of a trail, seconds.
const TRAIL_STEP_S: f64 = 0.04;
/// Thickness of a trail, metres.
const TRAIL_M: f64 = 0.001;
/// Scenes show at most this many instants a second: a scene is ten times the size of a cloud.
const MAX_RATE_HZ: f64 = 25.0;

pub(crate) fn identity() -> Pose {
    pose([0.0; 3])
}

pub(crate) fn pose([x, y, z]: [f64; 3]) -> Pose {
    Pose {
        position: Some(Vector3 { x, y, z }),
        orientation: Some(Quaternion {
            x: 0.0,
            y: 0.0,
            z: 0.0,
            w: 1.0,
        }),
    }
}

pub(crate) fn size([x, y, z]: [f64; 3]) -> Vector3 {
    Vector3 { x, y, z }
}

pub(crate) fn colour(rgb: Rgb, alpha: f64) -> Color {
    let [r, g, b] = rgb.map(|channel| f64::from(channel) / 255.0);
    Color { r, g, b, a: alpha }
}

/// An entity that replaces the one of the same id and moves with its frame.
pub(crate) fn entity(frame: &str, id: &str, unix_nanos: u64) -> SceneEntity {
    SceneEntity {
        timestamp: Some(viewer_time(unix_nanos)),
        frame_id: frame.to_owned(),
        id: id.to_owned(),
        frame_locked: true,
        ..SceneEntity::default()
    }
}

pub(crate) struct FingertipScene<'a, T> {
    channel: ChannelId,
    frame: &'static str,
    stride: usize,
    trail_step: usize,
    trail_points: usize,
    tips: T,
    contacts: Option<Contacts<'a>>,
    trails: PerFinger<VecDeque<Point3>>,
}

impl<'a, T: Tips> FingertipScene<'a, T> {
    pub(crate) fn new(
        channel: ChannelId,
        frame: &'static str,
        (view_stride, rate_hz): (usize, f64),
        tips: T,
        contacts: Option<Contacts<'a>>,
    ) -> Self {
        // A multiple of the other views' stride, so that all speak of the same instants.
        let view_hz = rate_hz / view_stride as f64;
        let stride = view_stride * ((view_hz / MAX_RATE_HZ - 1e-3).ceil() as usize).max(1);
        let trail_step =
            ((TRAIL_STEP_S * rate_hz / stride as f64).round() as usize).max(1) * stride;
        Self {
            channel,
            frame,
            stride,
            trail_step,
            trail_points: (TRAIL_S * rate_hz / trail_step as f64).round() as usize,
            tips,
            contacts,
            trails: PerFinger::default(),
        }
    }

    fn sphere(&self, k: usize, finger: Finger, position_m: [f64; 3]) -> SpherePrimitive {
        let contact = (self.contacts.as_ref()).and_then(|contacts| contacts.in_contact(k, finger));
        let (diameter_m, alpha) = match contact {
            Some(true) => (CONTACT_SPHERE_M, 1.0),
            Some(false) => (SPHERE_M, OFF_ALPHA),
            None => (SPHERE_M, PLAIN_ALPHA),
        };
        SpherePrimitive {
            pose: Some(pose(position_m)),
            size: Some(size([diameter_m; 3])),
            color: Some(colour(FINGER_COLOURS[finger], alpha)),
        }
    }
}

impl<T: Tips> Stream for FingertipScene<'_, T> {
    fn sample(&mut self, at: &Instant<'_>, output: &mut Output) -> Result<(), ChannelError> {
        let &Instant { k, unix_nanos, .. } = at;
        if !k.is_multiple_of(self.stride) {
            return Ok(());
        }
        let mut scene = entity(self.frame, "fingertips", unix_nanos);
        for finger in Finger::ALL {
            let Some(position_m) = self.tips.position_m(at, finger) else {
                // A trail never bridges a gap.
                self.trails[finger].clear();
                continue;
            };
            scene.spheres.push(self.sphere(k, finger, position_m));
            let [x, y, z] = position_m;
            let trail = &mut self.trails[finger];
            let mut points: Vec<Point3> = trail.iter().copied().collect();
            points.push(Point3 { x, y, z });
            if points.len() > 1 {
                scene.lines.push(LinePrimitive {
                    pose: Some(identity()),
                    thickness: TRAIL_M,
                    points,
                    color: Some(colour(FINGER_COLOURS[finger], PLAIN_ALPHA)),
                    ..LinePrimitive::default()
                });
            }
            if k.is_multiple_of(self.trail_step) {
                if trail.len() >= self.trail_points {
                    trail.pop_front();
                }
                trail.push_back(Point3 { x, y, z });
            }
        }
        let update = SceneUpdate {
            deletions: Vec::new(),
            entities: vec![scene],
        };
        output.message(self.channel, k, unix_nanos, &update)
    }
}
