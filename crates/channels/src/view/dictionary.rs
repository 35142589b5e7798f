//! Visualisation of a dictionary: the primitive that plays, its paths beside those of the mean motion,
//! and where fingertips have been.

use foxglove::messages::{Point3, PointCloud, SceneEntity, SceneUpdate, TextPrimitive};
use inhand_model::{
    Dictionary, Finger, Frame, Hand, PerFinger, SEGMENT_COORDINATES, SegmentLayout,
};
use nalgebra::UnitQuaternion;

use super::cloud::Cloud;
use super::entities::{TRAIL_M, ball, colour, entity, pose, strip};
use super::{hulls, scene_stride, stride, transforms};
use crate::colour::{FINGER_COLOURS, Rgb};
use crate::error::ChannelError;
use crate::output::{ChannelId, Output};
use crate::topic;

/// Colour and opacity of the mean motion.
const MEAN: (Rgb, f64) = ([0x99, 0x99, 0x99], 0.6);
/// Opacity of the paths of a primitive.
const PATH_ALPHA: f64 = 0.9;
/// Diameter of a fingertip, metres: less than most primitives move it.
const TIP_M: f64 = 0.003;
/// Height of the number of the primitive, metres, and how far above the fingertips it stands.
const TEXT_M: f64 = 0.005;
const TEXT_ABOVE_M: f64 = 0.03;

/// The views of primitives, which play one after the other.
pub(crate) struct DictionaryView {
    cloud_channel: ChannelId,
    scene_channel: ChannelId,
    paths_channel: ChannelId,
    points_channel: ChannelId,
    stride: usize,
    scene_stride: usize,
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
        hulls::write_filled(&dictionary.demonstrated.hulls, unix_nanos, output)?;
        let hand = Some(Hand::NAME);
        let rate_hz = dictionary.layout.rate_hz;
        Ok(Self {
            cloud_channel: output.channel::<PointCloud>(topic::VIEW_PRIMITIVES, hand)?,
            scene_channel: output.channel::<SceneUpdate>(topic::VIEW_PRIMITIVES_SCENE, hand)?,
            paths_channel: output.channel::<SceneUpdate>(topic::VIEW_PATHS, hand)?,
            points_channel: output.channel::<PointCloud>(topic::VIEW_PATH_POINTS, hand)?,
            stride: stride(rate_hz),
            scene_stride: scene_stride(rate_hz),
            cloud: Cloud::new(Hand::NAME, "finger"),
        })
    }

    /// The whole second of a primitive, when it begins: the path of each fingertip and, in grey, the one
    /// it has in the mean motion. `played` and `mean` have 15 N numbers (t, finger, axis), metres.
    pub(crate) fn begin(
        &mut self,
        (primitive, k): (usize, usize),
        unix_nanos: u64,
        (played, mean): (&[f64], &[f64]),
        output: &mut Output,
    ) -> Result<(), ChannelError> {
        let mut paths = entity(Hand::NAME, "paths", unix_nanos);
        self.cloud.clear();
        for finger in Finger::ALL {
            let own = (FINGER_COLOURS[finger], PATH_ALPHA);
            for (values_m, look, thickness_m) in
                [(mean, MEAN, TRAIL_M / 2.0), (played, own, TRAIL_M)]
            {
                let path = self.path(values_m, finger);
                for &Point3 { x, y, z } in &path {
                    self.cloud.push([x, y, z], finger.index(), look.0);
                }
                paths.lines.push(strip(path, thickness_m, look));
            }
        }
        paths.texts.push(TextPrimitive {
            pose: Some(pose(above(mean))),
            billboard: true,
            font_size: TEXT_M,
            scale_invariant: false,
            color: Some(colour(MEAN.0, 1.0)),
            text: format!("primitive {primitive}"),
        });
        output.message(self.paths_channel, k, unix_nanos, &update(paths))?;
        // For viewers that draw no scenes.
        let points = self.cloud.message(unix_nanos);
        output.message(self.points_channel, k, unix_nanos, points)
    }

    fn path(&self, values_m: &[f64], finger: Finger) -> Vec<Point3> {
        (0..values_m.len() / SEGMENT_COORDINATES)
            .step_by(self.stride)
            .map(|t| {
                let [x, y, z] = [0, 1, 2].map(|axis| values_m[SegmentLayout::row(t, finger, axis)]);
                Point3 { x, y, z }
            })
            .collect()
    }

    pub(crate) fn sample(
        &mut self,
        k: usize,
        unix_nanos: u64,
        positions_m: PerFinger<[f64; 3]>,
        output: &mut Output,
    ) -> Result<(), ChannelError> {
        if k.is_multiple_of(self.stride) {
            self.cloud.clear();
            for (finger, &position_m) in positions_m.iter() {
                (self.cloud).push(position_m, finger.index(), FINGER_COLOURS[finger]);
            }
            let message = self.cloud.message(unix_nanos);
            output.message(self.cloud_channel, k, unix_nanos, message)?;
        }
        if k.is_multiple_of(self.scene_stride) {
            let mut tips = entity(Hand::NAME, "fingertips", unix_nanos);
            for (finger, &position_m) in positions_m.iter() {
                tips.spheres
                    .push(ball(position_m, TIP_M, (FINGER_COLOURS[finger], 1.0)));
            }
            output.message(self.scene_channel, k, unix_nanos, &update(tips))?;
        }
        Ok(())
    }
}

fn update(entity: SceneEntity) -> SceneUpdate {
    SceneUpdate {
        deletions: Vec::new(),
        entities: vec![entity],
    }
}

/// Above the middle of the fingertips of the first instant, metres; from numbers (t, finger, axis).
fn above(values_m: &[f64]) -> [f64; 3] {
    let middle = [0, 1, 2].map(|axis| {
        let tips = Finger::ALL.map(|finger| values_m[SegmentLayout::row(0, finger, axis)]);
        tips.iter().sum::<f64>() / Finger::COUNT as f64
    });
    [middle[0], middle[1], middle[2] + TEXT_ABOVE_M]
}
