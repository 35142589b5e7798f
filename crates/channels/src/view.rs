//! What viewers draw: one connected tree of frames, point clouds, a scene.
//!
//! The tree is `upright` (z up) -> `world` (the source's axes) -> `hand` -> `object`; where there is
//! no processed motion, `object` hangs under `world`. A frame is in the tree only if the take
//! shows it at a sample that views show, and nothing is drawn in a frame that is not in the tree:
//! a single unconnected frame empties a whole view in some viewers.
//!
//! Every message says all there is to draw at its instant, since a viewer that jumps in time sees
//! only the last message of each topic. What holds for the whole take is sent once, on topics of
//! its own.

mod cloud;
mod dictionary;
mod entities;
mod solid;
mod tips;
mod transforms;

pub(crate) use dictionary::DictionaryView;

use inhand_model::{Finger, Frame, Hand, MarkerKind, Object, World};

use crate::colour::{FINGER_COLOURS, Rgb};
use crate::error::ChannelError;
use crate::outline::Outline;
use crate::output::{ChannelId, Output};
use crate::take::TakeFile;
use crate::topic::{self, MethodTopics};
use crate::view::cloud::Cloud;
use crate::view::entities::FingertipScene;
use crate::view::tips::{
    Contacts, FingertipCloud, GeneratedTips, ProcessedTips, RecordedTips, Tips,
};
use crate::write::{Instant, Stream, Streams, marker_indices};
use foxglove::messages::PointCloud;

/// Views show at most this many instants a second: more than a screen needs only costs space.
const MAX_RATE_HZ: f64 = 50.0;

/// Every how many samples views show one.
pub(crate) fn stride(rate_hz: f64) -> usize {
    // The quotient of a rate and 50 is far below the largest integer; a tiny slack keeps 100.0001
    // Hz at two.
    ((rate_hz / MAX_RATE_HZ - 1e-3).ceil() as usize).max(1)
}

pub(crate) fn add_take<'a>(
    file: &TakeFile<'a>,
    outline: &Outline,
    output: &mut Output,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    let recording = file.recording;
    let rate_hz = recording.clock.rate_hz();
    let stride = stride(rate_hz);
    let start = recording.clock.unix_nanos(0);
    let tree = transforms::add(file, outline, stride, output, streams)?;

    if !recording.markers.is_empty() {
        streams.push(Box::new(MarkerCloud::new(file, stride, output)?));
    }
    if !recording.bodies.is_empty() {
        let channel = output.channel::<PointCloud>(topic::VIEW_BODIES, Some(World::NAME))?;
        streams.push(Box::new(BodyCloud {
            channel,
            stride,
            cloud: Cloud::new(World::NAME, "body"),
        }));
    }

    let contacts = |method: &str| {
        (file.evaluated.iter())
            .find(|evaluated| evaluated.name == method)
            .map(|evaluated| Contacts::new(&evaluated.samples))
    };
    if let Some(motion) = file.motion.filter(|_| tree.hand) {
        let tips = ProcessedTips { motion };
        add_tips(
            (topic::VIEW_FINGERTIPS, topic::VIEW_FINGERTIPS_SCENE),
            Hand::NAME,
            (tips, contacts("recorded")),
            (stride, rate_hz),
            output,
            streams,
        )?;
    } else if let Some(roles) = file.roles {
        let tips = RecordedTips {
            markers: marker_indices(recording, roles),
        };
        add_tips(
            (topic::VIEW_FINGERTIPS, topic::VIEW_FINGERTIPS_SCENE),
            World::NAME,
            (tips, contacts("recorded")),
            (stride, rate_hz),
            output,
            streams,
        )?;
    }
    if let Some(method) = file.generated.first().filter(|_| tree.hand) {
        let topics = MethodTopics::new(method.name)?;
        add_tips(
            (&topics.view_fingertips, &topics.view_scene),
            Hand::NAME,
            (GeneratedTips::new(method.segments), contacts(method.name)),
            (stride, rate_hz),
            output,
            streams,
        )?;
    }
    if let Some(shape) = file.object_shape.filter(|_| tree.object) {
        solid::write(shape, Object::NAME, start, output)?;
    }
    Ok(())
}

/// A cloud and a scene of one set of fingertips.
fn add_tips<'a>(
    (cloud_topic, scene_topic): (&str, &str),
    frame: &'static str,
    (tips, contacts): (impl Tips + Clone + 'a, Option<Contacts<'a>>),
    (stride, rate_hz): (usize, f64),
    output: &mut Output,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    streams.push(Box::new(FingertipCloud::new(
        output.channel::<PointCloud>(cloud_topic, Some(frame))?,
        frame,
        stride,
        tips.clone(),
    )));
    streams.push(Box::new(FingertipScene::new(
        output.channel::<foxglove::messages::SceneUpdate>(scene_topic, Some(frame))?,
        frame,
        (stride, rate_hz),
        tips,
        contacts,
    )));
    Ok(())
}

const LABELLED: Rgb = [0xF0, 0xE4, 0x42];
const OF_BODY: Rgb = [0x00, 0x72, 0xB2];
const UNLABELLED: Rgb = [0x99, 0x99, 0x99];

struct MarkerCloud {
    channel: ChannelId,
    stride: usize,
    colours: Vec<Rgb>,
    cloud: Cloud,
}

impl MarkerCloud {
    fn new(file: &TakeFile<'_>, stride: usize, output: &mut Output) -> Result<Self, ChannelError> {
        let colours = (file.recording.markers.iter())
            .map(|marker| {
                let finger = Finger::ALL.into_iter().find(|&finger| {
                    file.roles.is_some_and(|roles| {
                        (file.recording.marker(&roles.fingers[finger]))
                            .is_some_and(|named| std::ptr::eq(named, marker))
                    })
                });
                match (finger, marker.kind) {
                    (Some(finger), _) => FINGER_COLOURS[finger],
                    (None, MarkerKind::Labelled) => LABELLED,
                    (None, MarkerKind::RigidBodyMarker) => OF_BODY,
                    (None, MarkerKind::Unlabelled) => UNLABELLED,
                }
            })
            .collect();
        Ok(Self {
            channel: output.channel::<PointCloud>(topic::VIEW_MARKERS, Some(World::NAME))?,
            stride,
            colours,
            cloud: Cloud::new(World::NAME, "marker"),
        })
    }
}

impl Stream for MarkerCloud {
    fn sample(&mut self, at: &Instant<'_>, output: &mut Output) -> Result<(), ChannelError> {
        let &Instant { k, unix_nanos, .. } = at;
        if !k.is_multiple_of(self.stride) {
            return Ok(());
        }
        self.cloud.clear();
        for (n, (marker, &colour)) in at.block.markers.iter().zip(&self.colours).enumerate() {
            if let Some(position) = marker.track.get(at.row) {
                self.cloud.push(position.to_array(), n, colour);
            }
        }
        output.message(self.channel, k, unix_nanos, self.cloud.message(unix_nanos))
    }
}

struct BodyCloud {
    channel: ChannelId,
    stride: usize,
    cloud: Cloud,
}

impl Stream for BodyCloud {
    fn sample(&mut self, at: &Instant<'_>, output: &mut Output) -> Result<(), ChannelError> {
        let &Instant { k, unix_nanos, .. } = at;
        if !k.is_multiple_of(self.stride) {
            return Ok(());
        }
        self.cloud.clear();
        for (n, body) in at.block.bodies.iter().enumerate() {
            if let Some(pose) = body.track.get(at.row) {
                self.cloud.push(pose.origin().to_array(), n, OF_BODY);
            }
        }
        output.message(self.channel, k, unix_nanos, self.cloud.message(unix_nanos))
    }
}
