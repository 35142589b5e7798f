//! The objects of motions over each other: that of the first as everywhere, others in their layer's colour.

use foxglove::messages::{FrameTransforms, PointCloud, SceneUpdate};
use inhand_model::{Clock, Frame, Object, Pose};

use super::{Sources, is_shown, tree_stride};
use crate::error::ChannelError;
use crate::output::{ChannelId, Output};
use crate::overlay::{OverlayFile, OverlayObject, Source, layer_colour};
use crate::topic::LayerTopics;
use crate::view::cloud::Cloud;
use crate::view::{solid, transforms};

/// What lies behind an object stays visible.
const OBJECT_ALPHA: f64 = 0.3;

/// The frame and solid of an object.
pub(super) fn add<'a, F: Frame>(
    file: &OverlayFile<'a, F>,
    object: &OverlayObject<'a, F>,
    (start, first_is_placed): (u64, bool),
    output: &mut Output<'_>,
    sources: &mut Sources<'a>,
) -> Result<(), ChannelError> {
    if object.layer == 0 {
        if let Some(shape) = object.shape.filter(|_| first_is_placed) {
            solid::write(shape, Object::NAME, start, output)?;
        }
        return Ok(());
    }
    let Some(layer) =
        (file.layers.get(object.layer)).filter(|_| is_shown(object.track, object.clock))
    else {
        return Ok(());
    };
    let topics = LayerTopics::new(layer.name)?;
    let frame = format!("{}_{}", Object::NAME, layer.name);
    let colour = layer_colour(object.layer);
    sources.push((
        0,
        Box::new(OtherObject {
            // A topic of its own: in one with others, a viewer that jumps would see the last alone.
            channel: output.channel::<FrameTransforms>(&topics.tf, None)?,
            frame: frame.clone(),
            object: *object,
        }),
    ));
    let Some(shape) = object.shape else {
        return Ok(());
    };
    let channel = output.channel::<SceneUpdate>(&topics.object, Some(&frame))?;
    let solid = solid::scene(shape, (&frame, &frame), (colour, OBJECT_ALPHA), start);
    output.message(channel, 0, start, &solid)?;
    let channel = output.channel::<PointCloud>(&topics.object_edges, Some(&frame))?;
    let mut cloud = Cloud::new(&frame, "edge");
    for (edge, point) in solid::edge_points_m(shape) {
        cloud.push(point, edge, colour);
    }
    output.message(channel, 0, start, cloud.message(start))
}

struct OtherObject<'a, F: Frame> {
    channel: ChannelId,
    frame: String,
    object: OverlayObject<'a, F>,
}

impl<F: Frame> Source for OtherObject<'_, F> {
    fn clock(&self) -> Clock {
        self.object.clock
    }

    fn samples(&self) -> usize {
        self.object.track.len()
    }

    fn sample(
        &mut self,
        k: usize,
        unix_nanos: u64,
        output: &mut Output<'_>,
    ) -> Result<(), ChannelError> {
        let shown = k.is_multiple_of(tree_stride(self.object.clock.rate_hz()));
        let Some(pose) = self.object.track.get(k).filter(|_| shown) else {
            return Ok(());
        };
        let transform =
            transforms::transform(F::NAME, &self.frame, Pose::isometry(pose), unix_nanos);
        let transforms = vec![transform];
        output.message(self.channel, k, unix_nanos, &FrameTransforms { transforms })
    }
}
