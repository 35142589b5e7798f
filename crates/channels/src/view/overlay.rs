//! Overlaid motions, each in its own colour.
//!
//! There is little data in such a file, and views may not outgrow it: spheres come as often as scenes of
//! takes do, clouds and balls half as often, and trails, most of a scene's bytes, on a topic of their own with
//! each of their points.

use std::collections::VecDeque;

use foxglove::messages::{FrameTransforms, Point3};
use inhand_model::{
    Clock, Finger, Frame, Hand, Object, PerFinger, Pose, PoseTrack, Position, World,
};
use nalgebra::UnitQuaternion;

use super::draw::{
    Dot, Paint, SPHERE_M, TRAIL_M, add_cloud, cloud_once, entity, point, scene, sphere, strip, text,
};
use super::object;
use super::transforms::{self, Edge, transform};
use crate::error::ChannelError;
use crate::overlay::{OverlayFile, OverlayLayer, OverlayObject, layer_colour};
use crate::streams::{Sampling, Streams};
use crate::take::{scene_stride, stride};
use crate::topic;

/// Height of the letters of the legend, metres.
const LETTER_M: f64 = 0.005;
/// Height of the last line of the legend above the fingertips, metres.
const LEGEND_ABOVE_M: f64 = 0.035;
/// From line to line of the legend, metres.
const LEGEND_LINE_M: f64 = 0.007;
/// Scenes show every fourth sample at most, so that slow takes keep the limit too.
const LEAST_STRIDE: usize = 4;
/// Points of a trail; with the time between them, trails are a good half second long.
const TRAIL_POINTS: usize = 4;
/// Time between the points of a trail, seconds.
const TRAIL_STEP_S: f64 = 0.16;
/// Opacity of a trail.
const TRAIL_ALPHA: f64 = 0.8;
/// Diameter of a fingertip of six points, metres: so small that they look like one.
const STAR_M: f64 = 0.003;
/// Opacity of the objects of layers after the first: objects behind stay visible.
const OBJECT_ALPHA: f64 = 0.3;

/// Draws an overlay.
pub(crate) fn draw_overlay<'a, F: Frame>(
    file: &OverlayFile<'a, F>,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    let starts = file.layers.iter().map(|layer| layer.clock.unix_nanos(0));
    let start = starts.min().unwrap_or_default();
    let placed = place_first(file, start, streams)?;
    draw_legend(file.layers, F::NAME, start, streams)?;
    let last = |layer: &OverlayLayer<'_, F>| {
        let last = layer.samples().samples.checked_sub(1)?;
        Some(layer.clock.unix_nanos(last))
    };
    let end = file.layers.iter().filter_map(last).max().unwrap_or(start);
    for (n, layer) in file.layers.iter().enumerate() {
        draw_tips(n, layer, end, streams)?;
    }
    for object in file.objects {
        match object.shape {
            Some(shape) if object.layer == 0 && placed => {
                object::draw(Some(shape), start, streams)?;
            }
            _ if object.layer == 0 => {}
            _ => draw_object(file, object, start, streams)?,
        }
    }
    Ok(())
}

/// The tree down to the frame that layers are in; returns whether the first object is in it.
fn place_first<'a, F: Frame>(
    file: &OverlayFile<'a, F>,
    start: u64,
    streams: &mut Streams<'a>,
) -> Result<bool, ChannelError> {
    let first = file.objects.iter().find(|object| object.layer == 0);
    let first = first.filter(|object| is_shown(object.track, object.clock));
    let in_hand = F::NAME == Hand::NAME;
    let hand = (file.hand).filter(|(clock, track)| in_hand && is_shown(track, *clock));
    if in_hand && hand.is_none() {
        // The hand is nowhere in the world, so the tree is the hand.
        transforms::write_static(Hand::NAME, UnitQuaternion::identity(), start, streams)?;
    } else {
        let rotation = UnitQuaternion::from_rotation_matrix(&file.up_axis.upright_from_world());
        transforms::write_static(World::NAME, rotation, start, streams)?;
    }
    let mut edges: Vec<Edge<'a>> = Vec::new();
    let mut samples: Option<Sampling> = None;
    let mut add = |clock: Clock, len: usize, edge: Edge<'a>| {
        let samples = samples.get_or_insert(Sampling::all(clock, len));
        samples.samples = samples.samples.max(len);
        edges.push(edge);
    };
    if let Some((clock, track)) = hand {
        let pose = move |k| track.get(k).map(Pose::isometry);
        let edge: Edge<'a> = (World::NAME, Hand::NAME, Box::new(move |at| pose(at.k)));
        add(clock, track.len(), edge);
    }
    if let Some(&OverlayObject { track, clock, .. }) = first {
        let pose = move |k| track.get(k).map(Pose::isometry);
        let edge: Edge<'a> = (F::NAME, Object::NAME, Box::new(move |at| pose(at.k)));
        add(clock, track.len(), edge);
    }
    if let Some(samples) = samples {
        let samples = samples.every(tree_stride(samples.clock));
        transforms::add_edges(edges, samples, streams)?;
    }
    Ok(first.is_some())
}

/// Every how many samples frames are placed: every second at most, so that views of slow takes do not
/// outgrow the data.
fn tree_stride(clock: Clock) -> usize {
    stride(clock.rate_hz()).max(2)
}

/// Whether any sample that views show has the pose.
fn is_shown<To: Frame, From: Frame>(track: &PoseTrack<To, From>, clock: Clock) -> bool {
    let mut samples = (0..track.len()).step_by(tree_stride(clock));
    samples.any(|k| track.status(k).is_present())
}

/// Draws the names of the layers in their colours, once, on a topic of its own.
fn draw_legend<F: Frame>(
    layers: &[OverlayLayer<'_, F>],
    frame: &str,
    unix_nanos: u64,
    streams: &mut Streams<'_>,
) -> Result<(), ChannelError> {
    let mut legend = entity(frame, "legend", unix_nanos);
    let [x, y, z] = layers.first().map_or([0.0; 3], first_seen_m);
    let top_m = z + LEGEND_ABOVE_M + LEGEND_LINE_M * layers.len() as f64;
    for (n, layer) in layers.iter().enumerate() {
        let place_m = [x, y, top_m - n as f64 * LEGEND_LINE_M];
        let line = text(place_m, LETTER_M, layer_colour(n), layer.name.to_owned());
        legend.texts.push(line);
    }
    streams.once(
        topic::VIEW_LEGEND,
        Some(frame),
        unix_nanos,
        &scene(vec![legend]),
    )
}

/// Fingertips that are there at a sample, metres.
fn tips_m<F: Frame>(
    layer: &OverlayLayer<'_, F>,
    k: usize,
) -> impl Iterator<Item = (Finger, [f64; 3])> {
    let tips = layer.tips;
    (Finger::ALL.into_iter())
        .filter_map(move |finger| Some((finger, tips[finger].get(k)?.to_array())))
}

/// The middle of the fingertips where they are first seen, metres; the origin where they never are.
fn first_seen_m<F: Frame>(layer: &OverlayLayer<'_, F>) -> [f64; 3] {
    let seen = (0..layer.samples().samples)
        .map(|k| tips_m(layer, k).map(|(_, tip)| tip).collect::<Vec<_>>())
        .find(|tips| !tips.is_empty());
    seen.map_or([0.0; 3], |tips| {
        [0, 1, 2].map(|axis| tips.iter().map(|tip| tip[axis]).sum::<f64>() / tips.len() as f64)
    })
}

/// Draws the fingertips of the layer with this number, in a file that ends at `end_unix_nanos`.
fn draw_tips<'a, F: Frame>(
    number: usize,
    layer: &'a OverlayLayer<'a, F>,
    end_unix_nanos: u64,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    let topic = |leaf| topic::named(topic::VIEW_OVERLAY, layer.name, leaf);
    let (samples, rate_hz) = (layer.samples(), layer.clock.rate_hz());
    let (colour, frame) = (layer_colour(number), Some(F::NAME));
    // A layer that ends before others has an empty message behind its last sample: it would be drawn beside
    // them until the end otherwise.
    let every = |stride: usize| {
        let behind = samples.samples.next_multiple_of(stride);
        let fits = layer.clock.unix_nanos(behind) <= end_unix_nanos;
        let samples = if fits { behind + 1 } else { samples.samples };
        Sampling::all(layer.clock, samples).every(stride)
    };
    let stride = scene_stride(rate_hz).max(LEAST_STRIDE);

    let place = (&*topic("fingertips"), F::NAME);
    add_cloud(
        streams,
        place,
        &["finger", "layer"],
        every(2 * stride),
        move |at, cloud| {
            for (finger, tip_m) in tips_m(layer, at.k) {
                cloud.push(tip_m, &[finger.index(), number], colour);
            }
        },
    )?;
    // For viewers that draw no scenes.
    let place = (&*topic("fingertip_balls"), F::NAME);
    add_cloud(
        streams,
        place,
        &["finger"],
        every(2 * stride),
        move |at, cloud| {
            for (finger, tip_m) in tips_m(layer, at.k) {
                cloud.push_dot(Dot::Star(STAR_M), tip_m, &[finger.index()], colour);
            }
        },
    )?;
    streams.sampled(
        &topic("fingertips_scene"),
        frame,
        every(stride),
        move |at| {
            let mut tips = entity(F::NAME, layer.name, at.unix_nanos);
            let spheres =
                tips_m(layer, at.k).map(|(_, tip_m)| sphere(tip_m, SPHERE_M, (colour, 1.0)));
            tips.spheres = spheres.collect();
            Some(scene(vec![tips]))
        },
    )?;
    let steps = (TRAIL_STEP_S * rate_hz / stride as f64).round() as usize;
    let sampling = every(steps.max(4) * stride);
    draw_trails(layer, number, (&topic("trails"), sampling), streams)
}

/// Draws the recent path of each fingertip of a layer.
fn draw_trails<'a, F: Frame>(
    layer: &'a OverlayLayer<'a, F>,
    number: usize,
    (topic, sampling): (&str, Sampling),
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    let paint = (layer_colour(number), TRAIL_ALPHA);
    let mut trails = PerFinger::<VecDeque<Point3>>::default();
    streams.sampled(topic, Some(F::NAME), sampling.every(1), move |at| {
        let shown = at.k.is_multiple_of(sampling.stride);
        let mut lines = entity(F::NAME, layer.name, at.unix_nanos);
        for finger in Finger::ALL {
            let trail = &mut trails[finger];
            match layer.tips[finger].get(at.k).map(Position::to_array) {
                // A trail never bridges a gap, however short.
                None => trail.clear(),
                // It moves on when it gets a new point.
                Some(tip_m) if shown => {
                    if trail.len() >= TRAIL_POINTS {
                        trail.pop_front();
                    }
                    trail.push_back(point(tip_m));
                    if trail.len() > 1 {
                        let points = trail.iter().copied().collect();
                        lines.lines.push(strip(points, TRAIL_M, paint));
                    }
                }
                Some(_) => {}
            }
        }
        shown.then(|| scene(vec![lines]))
    })
}

/// Draws the object of a layer after the first, in the layer's colour and in a frame of its own.
fn draw_object<'a, F: Frame>(
    file: &OverlayFile<'a, F>,
    object: &OverlayObject<'a, F>,
    start: u64,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    let OverlayObject { track, clock, .. } = *object;
    if !is_shown(track, clock) {
        return Ok(());
    }
    let name = file.layers[object.layer].name;
    let topic = |leaf| topic::named(topic::VIEW_OVERLAY, name, leaf);
    let frame = format!("{}_{name}", Object::NAME);
    let samples = Sampling::all(clock, track.len()).every(tree_stride(clock));
    let child = frame.clone();
    // A topic of its own: of a shared one, a viewer that jumps in time shows the last message alone.
    streams.sampled(&topic("tf"), None, samples, move |at| {
        let pose = Pose::isometry(track.get(at.k)?);
        let transforms = vec![transform(F::NAME, &child, pose, at.unix_nanos)];
        Some(FrameTransforms { transforms })
    })?;
    let Some(shape) = object.shape else {
        return Ok(());
    };
    let paint: Paint = (layer_colour(object.layer), OBJECT_ALPHA);
    let solid = object::solid(shape, (&frame, &frame), paint, start);
    streams.once(&topic("object"), Some(&frame), start, &scene(vec![solid]))?;
    let edges = (&*topic("object_edges"), &*frame, "edge");
    let points_m = object::edge_points_m(shape);
    cloud_once(edges, points_m, |_| paint.0, start, streams)
}
