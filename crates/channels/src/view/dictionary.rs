//! What viewers draw of a dictionary: the primitive that plays, and where fingertips have been.

use foxglove::messages::{Point3, PointCloud, SceneUpdate, TriangleListPrimitive};
use inhand_model::{Dictionary, Finger, Frame, Hand, Hull, PerFinger};
use nalgebra::UnitQuaternion;

use super::cloud::Cloud;
use super::entities::{colour, entity, identity};
use super::{stride, transforms};
use crate::colour::FINGER_COLOURS;
use crate::error::ChannelError;
use crate::output::{ChannelId, Output};
use crate::topic;

/// Hulls enclose each other and the fingertips.
const HULL_ALPHA: f64 = 0.2;

/// The point cloud of the primitive that plays.
pub(crate) struct DictionaryView {
    channel: ChannelId,
    stride: usize,
    cloud: Cloud,
}

impl DictionaryView {
    /// Sends what holds for the whole file: the tree of frames, in which the hand's own axes stand
    /// upright as nothing is known of a world, and the hulls.
    pub(crate) fn new(
        dictionary: &Dictionary,
        unix_nanos: u64,
        output: &mut Output,
    ) -> Result<Self, ChannelError> {
        transforms::write_static(Hand::NAME, UnitQuaternion::identity(), unix_nanos, output)?;
        let mut hulls = entity(Hand::NAME, "hulls", unix_nanos);
        hulls.triangles = (dictionary.demonstrated.hulls.iter())
            .map(|(finger, hull)| triangles(finger, hull))
            .collect();
        let update = SceneUpdate {
            deletions: Vec::new(),
            entities: vec![hulls],
        };
        let channel = output.channel::<SceneUpdate>(topic::VIEW_HULLS, Some(Hand::NAME))?;
        output.message(channel, 0, unix_nanos, &update)?;
        Ok(Self {
            channel: output.channel::<PointCloud>(topic::VIEW_PRIMITIVES, Some(Hand::NAME))?,
            stride: stride(dictionary.layout.rate_hz),
            cloud: Cloud::new(Hand::NAME, "finger"),
        })
    }

    pub(crate) fn sample(
        &mut self,
        k: usize,
        unix_nanos: u64,
        positions_m: PerFinger<[f64; 3]>,
        output: &mut Output,
    ) -> Result<(), ChannelError> {
        if !k.is_multiple_of(self.stride) {
            return Ok(());
        }
        self.cloud.clear();
        for (finger, &position_m) in positions_m.iter() {
            (self.cloud).push(position_m, finger.index(), FINGER_COLOURS[finger]);
        }
        output.message(self.channel, k, unix_nanos, self.cloud.message(unix_nanos))
    }
}

fn triangles(finger: Finger, hull: &Hull) -> TriangleListPrimitive {
    TriangleListPrimitive {
        pose: Some(identity()),
        points: (hull.vertices_m.iter())
            .map(|&[x, y, z]| Point3 { x, y, z })
            .collect(),
        color: Some(colour(FINGER_COLOURS[finger], HULL_ALPHA)),
        indices: hull.triangles.concat(),
        ..TriangleListPrimitive::default()
    }
}
