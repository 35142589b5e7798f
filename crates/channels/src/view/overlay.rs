//! Motions over each other, each in its own colour.

use std::collections::VecDeque;

use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{
    CubePrimitive, CylinderPrimitive, FrameTransforms, LinePrimitive, PackedElementField, Point3,
    PointCloud, SceneUpdate, SpherePrimitive, TextPrimitive,
};
use inhand_model::{
    Clock, Finger, Frame, Hand, Object, PerFinger, Pose, PoseTrack, Position, Shape, World,
};
use nalgebra::UnitQuaternion;

use super::entities::{colour, entity, identity, pose, size};
use super::{solid, stride, transforms};
use crate::colour::Rgb;
use crate::error::ChannelError;
use crate::output::{ChannelId, Output};
use crate::overlay::{OverlayFile, OverlayLayer, OverlayObject, Source, layer_colour, samples_of};
use crate::topic::{self, LayerTopics};
use crate::wire::viewer_time;

/// Diameter of a fingertip, metres: layers that nearly agree are seen side by side.
const SPHERE_M: f64 = 0.005;
/// Length of a trail, seconds.
const TRAIL_S: f64 = 0.4;
/// Time between the points of a trail, seconds.
const TRAIL_STEP_S: f64 = 0.04;
/// Thickness of a trail, metres.
const TRAIL_M: f64 = 0.001;
/// What lies behind an object stays visible.
const OBJECT_ALPHA: f64 = 0.3;
/// Height of the letters of the legend, metres.
const LETTER_M: f64 = 0.008;
/// Where the legend begins, metres: beside the hand.
const LEGEND_M: [f64; 3] = [0.0, 0.0, 0.15];
/// From line to line of the legend, metres.
const LEGEND_LINE_M: f64 = 0.011;

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
    for (n, layer) in file.layers.iter().enumerate() {
        let topics = LayerTopics::new(layer.name)?;
        let (stride, rate_hz) = (stride(layer.clock.rate_hz()), layer.clock.rate_hz());
        sources.push((
            0,
            Box::new(LayerCloud {
                channel: output.channel::<PointCloud>(&topics.view_fingertips, Some(F::NAME))?,
                stride,
                number: n,
                layer: layer.clone(),
            }),
        ));
        // Scenes are ten times the size of clouds, and half as many look as smooth.
        let scene_stride = stride * if rate_hz / stride as f64 > 25.1 { 2 } else { 1 };
        let trail_step =
            ((TRAIL_STEP_S * rate_hz / scene_stride as f64).round() as usize).max(1) * scene_stride;
        sources.push((
            0,
            Box::new(LayerScene {
                channel: output.channel::<SceneUpdate>(&topics.view_scene, Some(F::NAME))?,
                stride: scene_stride,
                trail_step,
                trail_points: (TRAIL_S * rate_hz / trail_step as f64).round() as usize,
                colour: layer_colour(n),
                layer: layer.clone(),
                trails: PerFinger::default(),
            }),
        ));
    }
    for object in file.objects {
        add_object(file, object, (start, placed), output, sources)?;
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
            stride: stride(clock.rate_hz()),
            hand: hand.map(|(_, track)| track),
            object: first.map(|object| object.track),
        }),
    ));
    Ok(first.is_some())
}

/// Whether any sample that views show has the pose.
fn is_shown<To: Frame, From: Frame>(track: &PoseTrack<To, From>, clock: Clock) -> bool {
    let mut samples = (0..track.len()).step_by(stride(clock.rate_hz()));
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

/// The frame and solid of an object.
fn add_object<'a, F: Frame>(
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
    output.message(channel, 0, start, &scene_of(shape, &frame, colour, start))?;
    let channel = output.channel::<PointCloud>(&topics.object_edges, Some(&frame))?;
    let edges = solid::edge_points_m(shape).into_iter();
    let points = edges.map(|(edge, at)| (at, edge));
    let cloud = cloud(&frame, ("edge", object.layer), points, colour, start);
    output.message(channel, 0, start, &cloud)
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
        let shown = k.is_multiple_of(stride(self.object.clock.rate_hz()));
        let Some(pose) = self.object.track.get(k).filter(|_| shown) else {
            return Ok(());
        };
        let transform =
            transforms::transform(F::NAME, &self.frame, Pose::isometry(pose), unix_nanos);
        let transforms = vec![transform];
        output.message(self.channel, k, unix_nanos, &FrameTransforms { transforms })
    }
}

fn scene_of(shape: Shape, frame: &str, rgb: Rgb, unix_nanos: u64) -> SceneUpdate {
    let mut solid = entity(frame, frame, unix_nanos);
    let (pose, color) = (Some(identity()), Some(colour(rgb, OBJECT_ALPHA)));
    match shape {
        Shape::Cuboid { edges_m } => solid.cubes.push(CubePrimitive {
            pose,
            size: Some(size(edges_m)),
            color,
        }),
        Shape::Cylinder {
            diameter_m,
            height_m,
        } => solid.cylinders.push(CylinderPrimitive {
            pose,
            size: Some(size([diameter_m, diameter_m, height_m])),
            bottom_scale: 1.0,
            top_scale: 1.0,
            color,
        }),
    }
    SceneUpdate {
        deletions: Vec::new(),
        entities: vec![solid],
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
    let [x, y, z] = LEGEND_M;
    for (n, layer) in layers.iter().enumerate() {
        legend.texts.push(TextPrimitive {
            pose: Some(pose([x, y, z - n as f64 * LEGEND_LINE_M])),
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

/// Points of one colour with a number each (what it numbers is `named`) and the number of their layer.
fn cloud(
    frame: &str,
    (named, layer): (&str, usize),
    points: impl Iterator<Item = ([f64; 3], usize)>,
    [red, green, blue]: Rgb,
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
        field(named, 12, NumericType::Uint32),
        field("layer", 16, NumericType::Uint32),
        field("red", 20, NumericType::Uint8),
        field("green", 21, NumericType::Uint8),
        field("blue", 22, NumericType::Uint8),
        field("alpha", 23, NumericType::Uint8),
    ];
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
    number: usize,
    layer: OverlayLayer<'a, F>,
}

impl<F: Frame> Source for LayerCloud<'_, F> {
    fn clock(&self) -> Clock {
        self.layer.clock
    }

    fn samples(&self) -> usize {
        samples_of(self.layer.tips)
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
        let of = ("finger", self.number);
        let cloud = cloud(F::NAME, of, points, layer_colour(self.number), unix_nanos);
        output.message(self.channel, k, unix_nanos, &cloud)
    }
}

struct LayerScene<'a, F: Frame> {
    channel: ChannelId,
    stride: usize,
    trail_step: usize,
    trail_points: usize,
    colour: Rgb,
    layer: OverlayLayer<'a, F>,
    trails: PerFinger<VecDeque<Point3>>,
}

impl<F: Frame> Source for LayerScene<'_, F> {
    fn clock(&self) -> Clock {
        self.layer.clock
    }

    fn samples(&self) -> usize {
        samples_of(self.layer.tips)
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
        for finger in Finger::ALL {
            let Some([x, y, z]) = self.layer.tips[finger].get(k).map(Position::to_array) else {
                // A trail never bridges a gap.
                self.trails[finger].clear();
                continue;
            };
            scene.spheres.push(SpherePrimitive {
                pose: Some(pose([x, y, z])),
                size: Some(size([SPHERE_M; 3])),
                color: Some(colour(self.colour, 1.0)),
            });
            let trail = &mut self.trails[finger];
            let mut points: Vec<Point3> = trail.iter().copied().collect();
            points.push(Point3 { x, y, z });
            if points.len() > 1 {
                scene.lines.push(LinePrimitive {
                    pose: Some(identity()),
                    thickness: TRAIL_M,
                    points,
                    color: Some(colour(self.colour, 0.8)),
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
