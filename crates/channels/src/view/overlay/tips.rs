//! Fingertips of one of several motions, in its colour.
//!
//! There is little data in such a file, and views may not outgrow it: spheres come as often as scenes of
//! takes do, clouds and balls half as often, and trails, most of a scene's bytes, on a topic of their own with
//! each of their points.

use std::collections::VecDeque;

use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{PackedElementField, Point3, PointCloud, SceneEntity, SceneUpdate};
use inhand_model::{Clock, Finger, Frame, PerFinger, Position};

use super::Sources;
use crate::colour::Rgb;
use crate::error::ChannelError;
use crate::output::{ChannelId, Output};
use crate::overlay::{OverlayLayer, Source, layer_colour, samples_of};
use crate::topic::LayerTopics;
use crate::view::cloud::Cloud;
use crate::view::entities::{SPHERE_M, TRAIL_M, entity, identity, sphere, strip};
use crate::view::scene_stride;
use crate::wire::viewer_time;

/// Scenes show every fourth sample at most, so that slow takes keep the limit too.
const LEAST_STRIDE: usize = 4;
/// Points of a trail; with the time between them, trails are a good half second long.
const TRAIL_POINTS: usize = 4;
/// Time between the points of a trail, seconds.
const TRAIL_STEP_S: f64 = 0.16;
/// Opacity of a trail.
const TRAIL_ALPHA: f64 = 0.8;

/// Adds the views of the layer with this number, in a file that ends at `end_unix_nanos`.
pub(super) fn add<'a, F: Frame>(
    number: usize,
    layer: &OverlayLayer<'a, F>,
    end_unix_nanos: u64,
    output: &mut Output<'_>,
    sources: &mut Sources<'a>,
) -> Result<(), ChannelError> {
    let topics = LayerTopics::new(layer.name)?;
    let (rate_hz, frame) = (layer.clock.rate_hz(), Some(F::NAME));
    let (layer, colour) = (layer.clone(), layer_colour(number));
    let stride = scene_stride(rate_hz).max(LEAST_STRIDE);
    // A layer that ends before others has an empty message behind its last sample: it would stand still
    // beside them otherwise.
    let len = samples_of(layer.tips);
    let clock = layer.clock;
    let shown = |stride: usize| {
        let behind = len.next_multiple_of(stride);
        if clock.unix_nanos(behind) <= end_unix_nanos {
            behind + 1
        } else {
            len
        }
    };
    sources.push((
        0,
        Box::new(LayerCloud {
            channel: output.channel::<PointCloud>(&topics.view_fingertips, frame)?,
            stride: 2 * stride,
            samples: shown(2 * stride),
            number,
            layer: layer.clone(),
        }),
    ));
    sources.push((
        0,
        Box::new(LayerBalls {
            channel: output.channel::<PointCloud>(&topics.view_balls, frame)?,
            stride: 2 * stride,
            samples: shown(2 * stride),
            colour,
            layer: layer.clone(),
            cloud: Cloud::new(F::NAME, "finger"),
        }),
    ));
    sources.push((
        0,
        Box::new(LayerScene {
            channel: output.channel::<SceneUpdate>(&topics.view_scene, frame)?,
            stride,
            samples: shown(stride),
            colour,
            layer: layer.clone(),
        }),
    ));
    let steps = (TRAIL_STEP_S * rate_hz / stride as f64).round() as usize;
    sources.push((
        0,
        Box::new(LayerTrails {
            channel: output.channel::<SceneUpdate>(&topics.view_trails, frame)?,
            stride: steps.max(4) * stride,
            samples: shown(steps.max(4) * stride),
            colour,
            layer,
            trails: PerFinger::default(),
        }),
    ));
    Ok(())
}

/// Points of one colour with the numbers of their finger and layer.
fn cloud(
    frame: &str,
    layer: usize,
    points: impl Iterator<Item = ([f64; 3], usize)>,
    unix_nanos: u64,
) -> PointCloud {
    let field = |name: &str, offset, numeric_type: NumericType| PackedElementField {
        name: name.to_owned(),
        offset,
        r#type: numeric_type.into(),
    };
    let fields = vec![
        field("x", 0, NumericType::Float32),
        field("y", 4, NumericType::Float32),
        field("z", 8, NumericType::Float32),
        field("finger", 12, NumericType::Uint32),
        field("layer", 16, NumericType::Uint32),
        field("red", 20, NumericType::Uint8),
        field("green", 21, NumericType::Uint8),
        field("blue", 22, NumericType::Uint8),
        field("alpha", 23, NumericType::Uint8),
    ];
    let [red, green, blue] = layer_colour(layer);
    let mut data = Vec::new();
    for (at, number) in points {
        for coordinate in at {
            data.extend_from_slice(&(coordinate as f32).to_le_bytes());
        }
        data.extend_from_slice(&(number as u32).to_le_bytes());
        data.extend_from_slice(&(layer as u32).to_le_bytes());
        data.extend_from_slice(&[red, green, blue, u8::MAX]);
    }
    PointCloud {
        timestamp: Some(viewer_time(unix_nanos)),
        frame_id: frame.to_owned(),
        pose: Some(identity()),
        point_stride: 24,
        fields,
        data: data.into(),
    }
}

struct LayerCloud<'a, F: Frame> {
    channel: ChannelId,
    stride: usize,
    samples: usize,
    number: usize,
    layer: OverlayLayer<'a, F>,
}

impl<F: Frame> Source for LayerCloud<'_, F> {
    fn clock(&self) -> Clock {
        self.layer.clock
    }

    fn samples(&self) -> usize {
        self.samples
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
        let points = (Finger::ALL.into_iter()).filter_map(|finger| {
            let position = self.layer.tips[finger].get(k)?;
            Some((position.to_array(), finger.index()))
        });
        let cloud = cloud(F::NAME, self.number, points, unix_nanos);
        output.message(self.channel, k, unix_nanos, &cloud)
    }
}

/// Balls of points, for viewers that draw no scenes.
struct LayerBalls<'a, F: Frame> {
    channel: ChannelId,
    stride: usize,
    samples: usize,
    colour: Rgb,
    layer: OverlayLayer<'a, F>,
    cloud: Cloud,
}

impl<F: Frame> Source for LayerBalls<'_, F> {
    fn clock(&self) -> Clock {
        self.layer.clock
    }

    fn samples(&self) -> usize {
        self.samples
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
        self.cloud.clear();
        for finger in Finger::ALL {
            if let Some(position) = self.layer.tips[finger].get(k) {
                let (at, number) = (position.to_array(), finger.index());
                self.cloud.push_star(at, SPHERE_M, number, self.colour);
            }
        }
        output.message(self.channel, k, unix_nanos, self.cloud.message(unix_nanos))
    }
}

/// Fingertips as spheres.
struct LayerScene<'a, F: Frame> {
    channel: ChannelId,
    stride: usize,
    samples: usize,
    colour: Rgb,
    layer: OverlayLayer<'a, F>,
}

impl<F: Frame> Source for LayerScene<'_, F> {
    fn clock(&self) -> Clock {
        self.layer.clock
    }

    fn samples(&self) -> usize {
        self.samples
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
        let mut scene = entity(F::NAME, self.layer.name, unix_nanos);
        let tips = (Finger::ALL.into_iter()).filter_map(|finger| self.layer.tips[finger].get(k));
        scene.spheres = tips
            .map(|tip| sphere(tip.to_array(), self.colour))
            .collect();
        output.message(self.channel, k, unix_nanos, &update(scene))
    }
}

/// Where fingertips were a moment ago; a trail moves on when it gets a new point.
struct LayerTrails<'a, F: Frame> {
    channel: ChannelId,
    stride: usize,
    samples: usize,
    colour: Rgb,
    layer: OverlayLayer<'a, F>,
    trails: PerFinger<VecDeque<Point3>>,
}

impl<F: Frame> Source for LayerTrails<'_, F> {
    fn clock(&self) -> Clock {
        self.layer.clock
    }

    fn samples(&self) -> usize {
        self.samples
    }

    fn sample(
        &mut self,
        k: usize,
        unix_nanos: u64,
        output: &mut Output<'_>,
    ) -> Result<(), ChannelError> {
        // A trail never bridges a gap, however short.
        for finger in Finger::ALL {
            if self.layer.tips[finger].get(k).is_none() {
                self.trails[finger].clear();
            }
        }
        if !k.is_multiple_of(self.stride) {
            return Ok(());
        }
        let mut scene = entity(F::NAME, self.layer.name, unix_nanos);
        for finger in Finger::ALL {
            let Some(tip) = self.layer.tips[finger].get(k).map(Position::to_array) else {
                continue;
            };
            let [x, y, z] = tip;
            let trail = &mut self.trails[finger];
            if trail.len() >= TRAIL_POINTS {
                trail.pop_front();
            }
            trail.push_back(Point3 { x, y, z });
            if trail.len() > 1 {
                let points = trail.iter().copied().collect();
                let line = strip(points, TRAIL_M, (self.colour, TRAIL_ALPHA));
                scene.lines.push(line);
            }
        }
        output.message(self.channel, k, unix_nanos, &update(scene))
    }
}

fn update(entity: SceneEntity) -> SceneUpdate {
    SceneUpdate {
        deletions: Vec::new(),
        entities: vec![entity],
    }
}
