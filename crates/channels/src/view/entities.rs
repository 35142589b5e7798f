//! Fingertips as spheres with short trails, tied to the hand.

use std::collections::VecDeque;

use foxglove::messages::{
    Color, LinePrimitive, Point3, Pose, Quaternion, SceneEntity, SceneUpdate, SpherePrimitive,
    Vector3, line_primitive,
};
use inhand_model::{Finger, PerFinger};

use super::scene_stride;
use super::tips::{Contacts, Paint, Tips};
use crate::colour::Rgb;
use crate::error::ChannelError;
use crate::output::{ChannelId, Output};
use crate::wire::viewer_time;
use crate::write::{Instant, Stream};

/// Diameter of a fingertip, metres: about that of a marker, so that neighbours stay apart.
pub(crate) const SPHERE_M: f64 = 0.005;
/// Diameter and opacity of a fingertip that is drawn as a shell, metres.
const SHELL_M: f64 = 0.007;
const SHELL_ALPHA: f64 = 0.25;
/// Diameter of the light around a fingertip that touches the object, metres.
pub(crate) const CONTACT_SPHERE_M: f64 = 0.012;
/// How bright it is: in the fingertip's own colour, which stays to be seen.
const CONTACT_ALPHA: f64 = 0.35;
/// Opacity of a trail.
const TRAIL_ALPHA: f64 = 0.8;
/// Length of a trail, seconds.
const TRAIL_S: f64 = 0.4;
/// Time between the points of a trail, seconds.
const TRAIL_STEP_S: f64 = 0.04;
/// Thickness of a trail, metres.
pub(crate) const TRAIL_M: f64 = 0.001;
/// Thickness and opacity of the line from the hand to a fingertip.
const LINK_M: f64 = 0.0006;
const LINK_ALPHA: f64 = 0.5;

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

/// A sphere of a fingertip's size.
pub(crate) fn sphere(position_m: [f64; 3], rgb: Rgb) -> SpherePrimitive {
    ball(position_m, SPHERE_M, (rgb, 1.0))
}

/// A sphere.
pub(crate) fn ball(
    position_m: [f64; 3],
    diameter_m: f64,
    (rgb, alpha): (Rgb, f64),
) -> SpherePrimitive {
    SpherePrimitive {
        pose: Some(pose(position_m)),
        size: Some(size([diameter_m; 3])),
        color: Some(colour(rgb, alpha)),
    }
}

/// A line through all points.
pub(crate) fn strip(
    points: Vec<Point3>,
    thickness_m: f64,
    (rgb, alpha): (Rgb, f64),
) -> LinePrimitive {
    LinePrimitive {
        r#type: line_primitive::Type::LineStrip.into(),
        pose: Some(identity()),
        thickness: thickness_m,
        points,
        color: Some(colour(rgb, alpha)),
        ..LinePrimitive::default()
    }
}

/// The line from the hand's origin to a fingertip: which finger of which hand it is shows at once.
pub(crate) fn link([x, y, z]: [f64; 3], rgb: Rgb) -> LinePrimitive {
    let ends = vec![Point3::default(), Point3 { x, y, z }];
    strip(ends, LINK_M, (rgb, LINK_ALPHA))
}

/// How fingertips of one motion look.
#[derive(Clone, Copy)]
pub(crate) struct Look {
    pub(crate) frame: &'static str,
    pub(crate) paint: Paint,
    /// Whether lines tie fingertips to the origin of the frame, which is then that of the hand.
    pub(crate) links: bool,
    /// Whether fingertips are shells that show what they lie around: planned ones are often within a
    /// fraction of a millimetre of the recorded ones.
    pub(crate) shells: bool,
}

pub(crate) struct FingertipScene<'a, T> {
    channel: ChannelId,
    look: Look,
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
        look: Look,
        rate_hz: f64,
        tips: T,
        contacts: Option<Contacts<'a>>,
    ) -> Self {
        let stride = scene_stride(rate_hz);
        let trail_step =
            ((TRAIL_STEP_S * rate_hz / stride as f64).round() as usize).max(1) * stride;
        Self {
            channel,
            look,
            stride,
            trail_step,
            trail_points: (TRAIL_S * rate_hz / trail_step as f64).round() as usize,
            tips,
            contacts,
            trails: PerFinger::default(),
        }
    }

    /// The light around a fingertip that touches the object.
    fn contact(&self, k: usize, finger: Finger, position_m: [f64; 3]) -> Option<SpherePrimitive> {
        let touches = (self.contacts.as_ref())?.in_contact(k, finger)?;
        // Lights of a plan would outshine what was recorded.
        let touches = touches && !self.look.shells;
        let light = (self.look.paint.of(finger), CONTACT_ALPHA);
        touches.then(|| ball(position_m, CONTACT_SPHERE_M, light))
    }
}

impl<T: Tips> Stream for FingertipScene<'_, T> {
    fn sample(&mut self, at: &Instant<'_>, output: &mut Output) -> Result<(), ChannelError> {
        let &Instant { k, unix_nanos, .. } = at;
        if !k.is_multiple_of(self.stride) {
            return Ok(());
        }
        let frame = self.look.frame;
        let mut scene = entity(frame, "fingertips", unix_nanos);
        let mut lights = entity(frame, "contacts", unix_nanos);
        for finger in Finger::ALL {
            let Some(position_m) = self.tips.position_m(at, finger) else {
                // A trail never bridges a gap.
                self.trails[finger].clear();
                continue;
            };
            let rgb = self.look.paint.of(finger);
            scene.spheres.push(if self.look.shells {
                ball(position_m, SHELL_M, (rgb, SHELL_ALPHA))
            } else {
                sphere(position_m, rgb)
            });
            (lights.spheres).extend(self.contact(k, finger, position_m));
            if self.look.links {
                scene.lines.push(link(position_m, rgb));
            }
            let [x, y, z] = position_m;
            let trail = &mut self.trails[finger];
            let mut points: Vec<Point3> = trail.iter().copied().collect();
            points.push(Point3 { x, y, z });
            if points.len() > 1 {
                scene.lines.push(strip(points, TRAIL_M, (rgb, TRAIL_ALPHA)));
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
            entities: vec![scene, lights],
        };
        output.message(self.channel, k, unix_nanos, &update)
    }
}
