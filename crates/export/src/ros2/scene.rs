//! Markers of `visualization_msgs`: what RViz, Foxglove and Lichtblick draw of a take.

use inhand_model::{BodySource, Finger, Shape};
use nalgebra::{Isometry3, Translation3};

use super::cdr::Cdr;
use super::content::{Colour, Ros2Take};

const MARKER: Colour = [0xF0, 0xE4, 0x42];
const BODY: Colour = [0x00, 0x72, 0xB2];
const OBJECT: Colour = [0xBB, 0xBB, 0xBB];

/// Diameters, metres.
const TIP_M: f64 = 0.01;
const MARKER_M: f64 = 0.006;

/// Numbers of `visualization_msgs/Marker`.
const CUBE: i32 = 1;
const SPHERE: i32 = 2;
const CYLINDER: i32 = 3;
const DELETE_ALL: i32 = 3;

/// A solid in a frame.
struct Solid<'a> {
    frame: &'a str,
    /// Namespace and number tell markers apart.
    space: &'a str,
    id: usize,
    kind: i32,
    pose: Isometry3<f64>,
    size_m: [f64; 3],
    colour: Colour,
    alpha: f32,
}

/// What viewers draw of a take.
pub(super) struct Scene<'a> {
    take: &'a Ros2Take<'a>,
    /// Frame of markers and bodies, and the pose of the take's world in it.
    frame: &'a str,
    frame_from_world: Isometry3<f64>,
    /// Frame of the hand.
    hand: &'a str,
}

impl<'a> Scene<'a> {
    pub(super) fn new(
        take: &'a Ros2Take<'a>,
        (frame, frame_from_world): (&'a str, Isometry3<f64>),
        hand: &'a str,
    ) -> Self {
        Self {
            take,
            frame,
            frame_from_world,
            hand,
        }
    }

    /// Writes the `visualization_msgs/MarkerArray` of sample `k`. It replaces all markers before it, so that a
    /// viewer that jumps in time shows what there is at that instant.
    pub(super) fn write(&self, cdr: &mut Cdr<'_>, k: usize) {
        let unix_nanos = self.take.recording.clock.unix_nanos(k);
        let solids = self.solids(k);
        cdr.u32(solids.len() + 1);
        let none = self.ball("", 0, [0.0; 3], (0.0, [0; 3]));
        none.write(cdr, DELETE_ALL, unix_nanos);
        for solid in solids {
            solid.write(cdr, 0, unix_nanos);
        }
    }

    fn solids(&self, k: usize) -> Vec<Solid<'a>> {
        let take = self.take;
        let mut solids = Vec::new();
        for (n, marker) in take.recording.markers.iter().enumerate() {
            let is_on = |finger: &Finger| {
                (take.roles).is_some_and(|roles| roles.fingers[*finger] == marker.name)
            };
            let look = match Finger::ALL.into_iter().find(is_on) {
                Some(finger) => (TIP_M, take.finger_colours[finger]),
                None => (MARKER_M, MARKER),
            };
            let position = marker.track.get(k);
            solids.extend(position.map(|at| self.ball(&marker.name, n, at.to_array(), look)));
        }
        for (n, body) in take.recording.bodies.iter().enumerate() {
            solids.extend(body.track.get(k).map(|pose| Solid {
                kind: CUBE,
                pose: self.frame_from_world * pose.isometry(),
                ..self.ball(&body.name, n, [0.0; 3], (TIP_M, BODY))
            }));
        }
        solids.extend(self.object(k));
        for method in take.methods {
            let tips = method.positions_m.get(&k).into_iter();
            for (n, tip) in tips.flat_map(|tips| tips.as_chunks::<3>().0).enumerate() {
                solids.push(Solid {
                    frame: self.hand,
                    pose: Translation3::from(*tip).into(),
                    ..self.ball(method.name, n, [0.0; 3], (TIP_M, method.colour))
                });
            }
        }
        solids
    }

    /// A ball of this diameter and colour at a place in the world.
    fn ball(
        &self,
        space: &'a str,
        id: usize,
        position_m: [f64; 3],
        (diameter_m, colour): (f64, Colour),
    ) -> Solid<'a> {
        let place: Isometry3<f64> = Translation3::from(position_m).into();
        Solid {
            frame: self.frame,
            space,
            id,
            kind: SPHERE,
            pose: self.frame_from_world * place,
            size_m: [diameter_m; 3],
            colour,
            alpha: 1.0,
        }
    }

    /// The object, where its shape and pose are known: as in the motion, else where its body is.
    fn object(&self, k: usize) -> Option<Solid<'a>> {
        let take = self.take;
        let (kind, size_m) = match take.shape? {
            Shape::Cuboid { edges_m } => (CUBE, edges_m),
            Shape::Cylinder {
                diameter_m,
                height_m,
            } => (CYLINDER, [diameter_m, diameter_m, height_m]),
        };
        let (frame, pose) = match take.motion {
            Some(motion) => (self.hand, motion.object.as_ref()?.get(k)?.isometry()),
            None => {
                let Some(BodySource::RigidBody(name)) = &take.roles?.object else {
                    return None;
                };
                let pose = take.recording.body(name)?.track.get(k)?;
                (self.frame, self.frame_from_world * pose.isometry())
            }
        };
        Some(Solid {
            frame,
            kind,
            pose,
            size_m,
            alpha: 0.5,
            ..self.ball("object", 0, [0.0; 3], (0.0, OBJECT))
        })
    }
}

impl Solid<'_> {
    fn write(&self, cdr: &mut Cdr<'_>, action: i32, unix_nanos: u64) {
        cdr.header(unix_nanos, self.frame)
            .text(self.space)
            .u32(self.id)
            .i32(self.kind)
            .i32(action)
            .pose(&self.pose)
            .f64s(self.size_m);
        for part in self.colour {
            cdr.f32(f32::from(part) / 255.0);
        }
        cdr.f32(self.alpha);
        cdr.time(0).u8(0); // No end of life; not locked to its frame.
        cdr.u32(0).u32(0); // No points or colours.
        cdr.text("").header(0, "").text("").u32(0).u32(0); // No texture.
        cdr.text("").text("").text("").u32(0).u8(0); // No text or mesh.
    }
}
