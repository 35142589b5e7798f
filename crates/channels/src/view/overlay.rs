//! Motions over each other, each in its own colour.

mod objects;
mod tips;

use foxglove::messages::{FrameTransforms, SceneUpdate, TextPrimitive};
use inhand_model::{Clock, Finger, Frame, Hand, Object, Pose, PoseTrack, World};
use nalgebra::UnitQuaternion;

use super::entities::{colour, entity, pose};
use super::{stride, transforms};
use crate::error::ChannelError;
use crate::output::{ChannelId, Output};
use crate::overlay::{OverlayFile, OverlayLayer, Source, layer_colour, samples_of};
use crate::topic;

/// Height of the letters of the legend, metres.
const LETTER_M: f64 = 0.005;
/// How far above the fingertips the last line of the legend stands, metres.
const LEGEND_ABOVE_M: f64 = 0.035;
/// From line to line of the legend, metres.
const LEGEND_LINE_M: f64 = 0.007;

/// Where a file's sources are added, each with the sample at which it begins.
type Sources<'a> = Vec<(usize, Box<dyn Source + 'a>)>;

pub(crate) fn add<'a, F: Frame>(
    file: &OverlayFile<'a, F>,
    output: &mut Output<'_>,
    sources: &mut Sources<'a>,
) -> Result<(), ChannelError> {
    let start = (file.layers.iter())
        .map(|layer| layer.clock.unix_nanos(0))
        .min()
        .unwrap_or_default();
    let placed = place_first(file, start, output, sources)?;
    legend(file.layers, F::NAME, start, output)?;
    let end = (file.layers.iter())
        .filter_map(|layer| {
            Some(
                layer
                    .clock
                    .unix_nanos(samples_of(layer.tips).checked_sub(1)?),
            )
        })
        .max()
        .unwrap_or(start);
    for (n, layer) in file.layers.iter().enumerate() {
        tips::add(n, layer, end, output, sources)?;
    }
    for object in file.objects {
        objects::add(file, object, (start, placed), output, sources)?;
    }
    Ok(())
}

/// The tree down to the frame that layers stand in; says whether the first object is in it.
fn place_first<'a, F: Frame>(
    file: &OverlayFile<'a, F>,
    start: u64,
    output: &mut Output<'_>,
    sources: &mut Sources<'a>,
) -> Result<bool, ChannelError> {
    let first = file.objects.iter().find(|object| object.layer == 0);
    let first = first.filter(|object| is_shown(object.track, object.clock));
    let hand = file.hand.filter(|(clock, track)| is_shown(track, *clock));
    if F::NAME == Hand::NAME && hand.is_none() {
        // The hand is nowhere in the world, so the tree is the hand.
        transforms::write_static(Hand::NAME, UnitQuaternion::identity(), start, output)?;
    } else {
        let rotation = UnitQuaternion::from_rotation_matrix(&file.up_axis.upright_from_world());
        transforms::write_static(World::NAME, rotation, start, output)?;
    }
    let hand = hand.filter(|_| F::NAME == Hand::NAME);
    let Some(clock) = (hand.map(|(clock, _)| clock)).or(first.map(|object| object.clock)) else {
        return Ok(false);
    };
    sources.push((
        0,
        Box::new(FirstFrames::<F> {
            channel: output.channel::<FrameTransforms>(topic::TF, None)?,
            clock,
            stride: tree_stride(clock.rate_hz()),
            hand: hand.map(|(_, track)| track),
            object: first.map(|object| object.track),
        }),
    ));
    Ok(first.is_some())
}

/// Every how many samples frames are placed: every second at most, so that views of slow takes do not
/// outgrow the data.
fn tree_stride(rate_hz: f64) -> usize {
    stride(rate_hz).max(2)
}

/// Whether any sample that views show has the pose.
fn is_shown<To: Frame, From: Frame>(track: &PoseTrack<To, From>, clock: Clock) -> bool {
    let mut samples = (0..track.len()).step_by(tree_stride(clock.rate_hz()));
    samples.any(|k| track.status(k).is_present())
}

/// Hand and object of the first layer; both in every message, where they are there.
struct FirstFrames<'a, F: Frame> {
    channel: ChannelId,
    clock: Clock,
    stride: usize,
    hand: Option<&'a PoseTrack<World, Hand>>,
    object: Option<&'a PoseTrack<F, Object>>,
}

impl<F: Frame> Source for FirstFrames<'_, F> {
    fn clock(&self) -> Clock {
        self.clock
    }

    fn samples(&self) -> usize {
        let hand = self.hand.map_or(0, PoseTrack::len);
        hand.max(self.object.map_or(0, PoseTrack::len))
    }

    fn sample(
        &mut self,
        k: usize,
        unix_nanos: u64,
        output: &mut Output<'_>,
    ) -> Result<(), ChannelError> {
        if !k.is_multiple_of(self.stride) {
            return Ok(());
        }
        let hand = self.hand.filter(|track| k < track.len());
        let hand = hand.and_then(|track| track.get(k)).map(|pose| {
            transforms::transform(World::NAME, Hand::NAME, Pose::isometry(pose), unix_nanos)
        });
        let object = self.object.filter(|track| k < track.len());
        let object = object.and_then(|track| track.get(k)).map(|pose| {
            transforms::transform(F::NAME, Object::NAME, Pose::isometry(pose), unix_nanos)
        });
        let transforms: Vec<_> = hand.into_iter().chain(object).collect();
        if transforms.is_empty() {
            return Ok(());
        }
        output.message(self.channel, k, unix_nanos, &FrameTransforms { transforms })
    }
}

/// Which colour is whose, once, on a topic of its own.
fn legend<F: Frame>(
    layers: &[OverlayLayer<'_, F>],
    frame: &str,
    unix_nanos: u64,
    output: &mut Output<'_>,
) -> Result<(), ChannelError> {
    let mut legend = entity(frame, "legend", unix_nanos);
    let [x, y, z] = layers.first().map_or([0.0; 3], first_seen_m);
    let top_m = z + LEGEND_ABOVE_M + LEGEND_LINE_M * layers.len() as f64;
    for (n, layer) in layers.iter().enumerate() {
        legend.texts.push(TextPrimitive {
            pose: Some(pose([x, y, top_m - n as f64 * LEGEND_LINE_M])),
            billboard: true,
            font_size: LETTER_M,
            scale_invariant: false,
            color: Some(colour(layer_colour(n), 1.0)),
            text: layer.name.to_owned(),
        });
    }
    let update = SceneUpdate {
        deletions: Vec::new(),
        entities: vec![legend],
    };
    let channel = output.channel::<SceneUpdate>(topic::VIEW_LEGEND, Some(frame))?;
    output.message(channel, 0, unix_nanos, &update)
}

/// The middle of the fingertips where they are first seen, metres; the origin where they never are.
fn first_seen_m<F: Frame>(layer: &OverlayLayer<'_, F>) -> [f64; 3] {
    let at = |k: usize| -> Vec<[f64; 3]> {
        (Finger::ALL.into_iter())
            .filter_map(|finger| Some(layer.tips[finger].get(k)?.to_array()))
            .collect()
    };
    let seen = (0..samples_of(layer.tips))
        .map(at)
        .find(|tips| !tips.is_empty());
    seen.map_or([0.0; 3], |tips| {
        [0, 1, 2].map(|axis| tips.iter().map(|tip| tip[axis]).sum::<f64>() / tips.len() as f64)
    })
}
