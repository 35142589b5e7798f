//! Motions of several takes or methods in one file, each on its own clock.

use std::collections::BTreeMap;
use std::io::Write;

use inhand_model::{
    Clock, Finger, Frame, Hand, Object, PerFinger, PointTrack, PoseTrack, Position, Provenance,
    Shape, UpAxis, World,
};

use crate::colour::Rgb;
use crate::error::ChannelError;
use crate::messages;
use crate::metadata::Metadata;
use crate::output::{ChannelId, Output, PACKED};
use crate::topic::LayerTopics;
use crate::view::overlay as view;
use crate::wire::Timestamp;
use crate::write::{fingertip, fingertips};

/// Metadata record that makes a file an overlay.
const OVERLAY: &str = "inhand.overlay";

/// As many layers as colours can tell apart: eight, and a darker shade of each.
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

/// Several motions over each other, in the frame `F`: `hand`, where hands coincide, or `world`.
#[derive(Clone, Copy, Debug)]
pub struct OverlayFile<'a, F: Frame> {
    /// The motions; the others are compared with the first.
    pub layers: &'a [OverlayLayer<'a, F>],
    /// Where the hand of the first layer is in the world, on its clock; for motions in the hand's frame.
    pub hand: Option<(Clock, &'a PoseTrack<World, Hand>)>,
    /// The objects that are turned.
    pub objects: &'a [OverlayObject<'a, F>],
    /// Axis of `world` that points up.
    pub up_axis: UpAxis,
    /// What else the record `inhand.overlay` says.
    pub about: &'a BTreeMap<String, String>,
    /// What made the file.
    pub provenance: &'a [Provenance],
}

/// One motion.
#[derive(Clone, Debug)]
pub struct OverlayLayer<'a, F: Frame> {
    /// Name; becomes part of topics.
    pub name: &'a str,
    /// When samples are, on the time line of the file.
    pub clock: Clock,
    /// Fingertips.
    pub tips: &'a PerFinger<PointTrack<F>>,
    /// Distances to the first layer at its samples, metres, NaN where one is missing; none for the first.
    pub distances_m: &'a [PerFinger<f64>],
}

/// An object.
#[derive(Clone, Copy, Debug)]
pub struct OverlayObject<'a, F: Frame> {
    /// Number of the layer that it belongs to; the frame of the first layer's is `object`, others have
    /// the layer's name behind it.
    pub layer: usize,
    /// When samples are.
    pub clock: Clock,
    /// Where it is.
    pub track: &'a PoseTrack<F, Object>,
    /// Its shape, where it is known.
    pub shape: Option<Shape>,
}

/// Messages of one layer or object, sample by sample on its own clock.
pub(crate) trait Source {
    /// When its samples are.
    fn clock(&self) -> Clock;
    /// How many there are.
    fn samples(&self) -> usize;
    /// Writes what there is to say at sample `k`.
    fn sample(
        &mut self,
        k: usize,
        unix_nanos: u64,
        output: &mut Output<'_>,
    ) -> Result<(), ChannelError>;
}

/// Writes motions over each other as one MCAP file, by time; the same values give the same bytes.
///
/// Each layer has its own samples and times on `/overlay/<name>/fingertips`; its distances to the first
/// layer, on `/overlay/<name>/distance`, have the times of the first.
///
/// # Errors
///
/// [`ChannelError::Mismatch`] for no layer or more than colours can tell apart, names that make no topic
/// or come twice; [`ChannelError::Write`].
pub fn write_overlay<F: Frame>(
    mut out: impl Write,
    file: &OverlayFile<'_, F>,
) -> Result<(), ChannelError> {
    check(file)?;
    let mut output = Output::create(&mut out, PACKED)?;
    let mut metadata = Metadata::default();
    for (key, value) in file.about {
        metadata.add_fact(OVERLAY, key, value.clone());
    }
    metadata.add_fact(OVERLAY, "frame", F::NAME.to_owned());
    metadata.add_provenance(file.provenance);
    for (name, facts) in &metadata.0 {
        output.metadata(name, facts)?;
    }
    let mut sources: Vec<(usize, Box<dyn Source + '_>)> = Vec::new();
    for (n, layer) in file.layers.iter().enumerate() {
        let topics = LayerTopics::new(layer.name)?;
        let channel = output.channel::<messages::Fingertips>(&topics.fingertips, Some(F::NAME))?;
        sources.push((0, Box::new(Tips { channel, layer })));
        if n > 0
            && let Some(first) = file.layers.first()
        {
            let topic = &topics.distance;
            let channel = output.channel::<messages::FingerErrors>(topic, Some(F::NAME))?;
            let clock = first.clock;
            let distances_m = layer.distances_m;
            sources.push((
                0,
                Box::new(Distances {
                    channel,
                    clock,
                    distances_m,
                }),
            ));
        }
    }
    view::add(file, &mut output, &mut sources)?;
    loop {
        let times = (sources.iter().enumerate())
            .filter(|(_, (k, source))| *k < source.samples())
            .map(|(n, (k, source))| (source.clock().unix_nanos(*k), n));
        let Some((unix_nanos, n)) = times.min() else {
            break;
        };
        let (k, source) = &mut sources[n];
        source.sample(*k, unix_nanos, &mut output)?;
        *k += 1;
    }
    drop(sources);
    output.finish()
}

fn check<F: Frame>(file: &OverlayFile<'_, F>) -> Result<(), ChannelError> {
    let layers = file.layers.len();
    if layers == 0 || layers > MAX_LAYERS {
        return Err(ChannelError::mismatch(
            "layers of an overlay",
            format!("1 to {MAX_LAYERS}, which colours can tell apart"),
            layers,
        ));
    }
    for (n, layer) in file.layers.iter().enumerate() {
        if file.layers[..n]
            .iter()
            .any(|other| other.name == layer.name)
        {
            return Err(ChannelError::mismatch(
                "names of layers",
                "each one once",
                format!("\"{}\" twice", layer.name),
            ));
        }
    }
    match file.objects.iter().find(|object| object.layer >= layers) {
        None => Ok(()),
        Some(object) => Err(ChannelError::mismatch(
            "layer of an object",
            format!("one of {layers}"),
            object.layer,
        )),
    }
}

struct Tips<'a, F: Frame> {
    channel: ChannelId,
    layer: &'a OverlayLayer<'a, F>,
}

impl<F: Frame> Source for Tips<'_, F> {
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
        let message = fingertips(unix_nanos, |finger| {
            let track = &self.layer.tips[finger];
            fingertip(track.get(k).map(Position::to_array), track.status(k))
        });
        output.message(self.channel, k, unix_nanos, &message)
    }
}

/// Samples that every finger has; a track of another length would be no part of the motion.
pub(crate) fn samples_of<F: Frame>(tips: &PerFinger<PointTrack<F>>) -> usize {
    (tips.iter().map(|(_, track)| track.len()).min()).unwrap_or_default()
}

struct Distances<'a> {
    channel: ChannelId,
    clock: Clock,
    distances_m: &'a [PerFinger<f64>],
}

impl Source for Distances<'_> {
    fn clock(&self) -> Clock {
        self.clock
    }

    fn samples(&self) -> usize {
        self.distances_m.len()
    }

    fn sample(
        &mut self,
        k: usize,
        unix_nanos: u64,
        output: &mut Output<'_>,
    ) -> Result<(), ChannelError> {
        let distance_m = &self.distances_m[k];
        if distance_m.as_array().iter().all(|metres| metres.is_nan()) {
            return Ok(());
        }
        let message = messages::FingerErrors {
            timestamp: Some(Timestamp::from_unix_nanos(unix_nanos)),
            thumb_m: distance_m[Finger::Thumb],
            index_m: distance_m[Finger::Index],
            middle_m: distance_m[Finger::Middle],
            ring_m: distance_m[Finger::Ring],
            little_m: distance_m[Finger::Little],
        };
        output.message(self.channel, k, unix_nanos, &message)
    }
}
