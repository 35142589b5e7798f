//! Motions of several takes or methods in one file, each on its own clock.

use std::collections::BTreeMap;
use std::io::Write;

use inhand_model::{
    Clock, Frame, Hand, Object, PerFinger, PointTrack, PoseTrack, Position, Provenance, Shape,
    UpAxis, World,
};

use crate::colour::Rgb;
use crate::error::{ChannelError, ensure};
use crate::messages;
use crate::metadata::{Metadata, OVERLAY};
use crate::streams::{PACKED, Sampling, Streams};
use crate::topic;
use crate::view::draw_overlay;

/// Most layers: colours distinguish eight, and a darker shade of each.
pub const MAX_LAYERS: usize = 16;

/// The seven colours of Okabe and Ito and a grey, in an order in which those that come first differ most.
const COLOURS: [Rgb; MAX_LAYERS / 2] = [
    [0x00, 0x72, 0xB2],
    [0xE6, 0x9F, 0x00],
    [0x00, 0x9E, 0x73],
    [0xD5, 0x5E, 0x00],
    [0xCC, 0x79, 0xA7],
    [0x56, 0xB4, 0xE9],
    [0xF0, 0xE4, 0x42],
    [0x99, 0x99, 0x99],
];

/// Colour of the layer with this number, counted from 0.
pub fn layer_colour(layer: usize) -> Rgb {
    let colour = COLOURS[layer % COLOURS.len()];
    if (layer / COLOURS.len()).is_multiple_of(2) {
        colour
    } else {
        colour.map(|channel| channel / 2)
    }
}

/// Overlaid motions in the frame `F`: `hand`, where hands coincide, or `world`.
#[derive(Clone, Copy, Debug)]
pub struct OverlayFile<'a, F: Frame> {
    /// The motions; the others are compared with the first.
    pub layers: &'a [OverlayLayer<'a, F>],
    /// Pose of the hand of the first layer in the world, on its clock; for motions in the hand's frame.
    pub hand: Option<(Clock, &'a PoseTrack<World, Hand>)>,
    /// The objects that are turned.
    pub objects: &'a [OverlayObject<'a, F>],
    /// Axis of `world` that points up.
    pub up_axis: UpAxis,
    /// Other facts of the record `inhand.overlay`.
    pub about: &'a BTreeMap<String, String>,
    /// Steps that made the file, first to last.
    pub provenance: &'a [Provenance],
}

/// One motion.
#[derive(Clone, Debug)]
pub struct OverlayLayer<'a, F: Frame> {
    /// Name; becomes part of topics.
    pub name: &'a str,
    /// Times of the samples, on the time line of the file.
    pub clock: Clock,
    /// Fingertips.
    pub tips: &'a PerFinger<PointTrack<F>>,
    /// Distances to the first layer at its samples, metres, NaN where one is missing; none for the first.
    pub distances_m: &'a [PerFinger<f64>],
}

impl<F: Frame> OverlayLayer<'_, F> {
    /// Samples that every finger has; a track of another length would be no part of the motion.
    pub(crate) fn samples(&self) -> Sampling {
        let lengths = self.tips.iter().map(|(_, track)| track.len());
        Sampling::all(self.clock, lengths.min().unwrap_or_default())
    }
}

/// An object.
#[derive(Clone, Copy, Debug)]
pub struct OverlayObject<'a, F: Frame> {
    /// Number of the layer that it belongs to; the frame of the first layer's is `object`, others have
    /// the layer's name behind it.
    pub layer: usize,
    /// Times of the samples.
    pub clock: Clock,
    /// Its pose.
    pub track: &'a PoseTrack<F, Object>,
    /// Its shape, where it is known.
    pub shape: Option<Shape>,
}

/// Writes an overlay of motions as one MCAP file, by time; the same values give the same bytes.
///
/// Each layer has its own samples and times on `/overlay/<name>/fingertips`; its distances to the first
/// layer, on `/overlay/<name>/distance`, have the times of the first.
///
/// # Errors
///
/// [`ChannelError::Mismatch`] for no layer or more than colours can distinguish, names that make no topic
/// or come twice; [`ChannelError::Container`].
pub fn write_overlay<F: Frame>(
    out: &mut dyn Write,
    file: &OverlayFile<'_, F>,
) -> Result<(), ChannelError> {
    check(file)?;
    let mut metadata = Metadata::default();
    for (key, value) in file.about {
        metadata.add_fact(OVERLAY, key, value.clone());
    }
    metadata.add_fact(OVERLAY, "frame", F::NAME.to_owned());
    metadata.add_provenance(file.provenance);
    let mut streams = Streams::create(out, PACKED, &metadata)?;
    let (first, frame) = (&file.layers[0], Some(F::NAME));
    for (n, layer) in file.layers.iter().enumerate() {
        let topic = |leaf| topic::named(topic::OVERLAY, layer.name, leaf);
        streams.sampled(&topic("fingertips"), frame, layer.samples(), move |at| {
            Some(messages::Fingertips::new(at.unix_nanos, |finger| {
                let track = &layer.tips[finger];
                let position_m = track.get(at.k).map(Position::to_array);
                messages::Fingertip::new(position_m, track.status(at.k))
            }))
        })?;
        if n > 0 {
            let samples = Sampling::all(first.clock, layer.distances_m.len());
            streams.sampled(&topic("distance"), frame, samples, move |at| {
                let distance_m = &layer.distances_m[at.k];
                let known = !distance_m.as_array().iter().all(|metres| metres.is_nan());
                known.then(|| messages::FingerErrors::new(at.unix_nanos, distance_m))
            })?;
        }
    }
    draw_overlay(file, &mut streams)?;
    streams.finish()
}

fn check<F: Frame>(file: &OverlayFile<'_, F>) -> Result<(), ChannelError> {
    let layers = file.layers.len();
    let expected = format!("1 to {MAX_LAYERS}, which colours can distinguish");
    let counts = (1..=MAX_LAYERS).contains(&layers);
    ensure(counts, "layers of an overlay", expected, layers)?;
    for (n, layer) in file.layers.iter().enumerate() {
        topic::check_name("name of a layer", layer.name)?;
        let mut others = file.layers[..n].iter();
        let unique = others.all(|other| other.name != layer.name);
        let found = format!("\"{}\" twice", layer.name);
        ensure(unique, "names of layers", "each one once", found)?;
    }
    for object in file.objects {
        let (n, expected) = (object.layer, format!("one of {layers}"));
        ensure(n < layers, "layer of an object", expected, n)?;
    }
    Ok(())
}
