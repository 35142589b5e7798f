//! Visualisation channels: one connected tree of frames, point clouds, a scene.
//!
//! The tree is `upright` (z up) -> `world` (the source's axes) -> `hand` -> `object`; where there is
//! no processed motion, `object` hangs under `world`. A frame is in the tree only if the take
//! shows it at a sample that views show, and nothing is drawn in a frame that is not in the tree:
//! a single unconnected frame empties a whole view in some viewers.
//!
//! Every message says all there is to draw at its instant, since a viewer that jumps in time sees
//! only the last message of each topic. What holds for the whole take is sent once, on topics of
//! its own.

mod axes;
mod cloud;
mod dictionary;
mod entities;
mod hulls;
mod log;
pub(crate) mod overlay;
mod solid;
mod tips;
mod transforms;

pub(crate) use dictionary::DictionaryView;
pub(crate) use transforms::{UPRIGHT, transform};

use inhand_model::{Clock, Finger, Frame, Hand, MarkerKind, Object, World};

use crate::colour::{FINGER_COLOURS, Rgb, method_colour};
use crate::error::ChannelError;
use crate::outline::Outline;
use crate::output::{ChannelId, Output};
use crate::take::{RECORDED, TakeFile};
use crate::topic::{self, MethodTopics};
use crate::view::cloud::Cloud;
use crate::view::entities::{FingertipScene, Look};
use crate::view::tips::{
    ContactCloud, Contacts, Dot, FingertipCloud, GeneratedTips, Paint, ProcessedTips, RecordedTips,
    Tips,
};
use crate::write::{Instant, Stream, Streams, marker_indices};
use foxglove::messages::{PointCloud, SceneUpdate};

/// Views show at most this many instants a second: more than a screen needs only costs space.
const MAX_RATE_HZ: f64 = 50.0;

/// Scenes show at most this many instants a second: a scene is ten times the size of a cloud.
const MAX_SCENE_RATE_HZ: f64 = 25.0;

/// Every how many samples views show one.
pub(crate) fn stride(rate_hz: f64) -> usize {
    // The quotient of a rate and 50 is far below the largest integer; a tiny slack keeps 100.0001
    // Hz at two.
    ((rate_hz / MAX_RATE_HZ - 1e-3).ceil() as usize).max(1)
}

/// Every how many samples scenes show one: a multiple of [`stride`], so that all views speak of the same
/// instants.
pub(crate) fn scene_stride(rate_hz: f64) -> usize {
    let stride = stride(rate_hz);
    let view_hz = rate_hz / stride as f64;
    stride * ((view_hz / MAX_SCENE_RATE_HZ - 1e-3).ceil() as usize).max(1)
}

/// Adds the views of a take. `file.recording` is the one that is drawn; `measured` is the clock that
/// changes by cleaning are counted by.
pub(crate) fn add_take<'a>(
    file: &TakeFile<'a>,
    measured: Clock,
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
    let mut views = TipViews {
        stride,
        rate_hz,
        output,
        streams,
    };
    let recorded = TipTopics {
        cloud: topic::VIEW_FINGERTIPS,
        scene: Some(topic::VIEW_FINGERTIPS_SCENE),
        balls: Some(topic::VIEW_FINGERTIP_BALLS),
        contacts: Some(topic::VIEW_CONTACTS),
    };
    if let Some(motion) = file.motion.filter(|_| tree.hand) {
        let look = in_hand(Paint::Fingers, true);
        views.add(
            &recorded,
            look,
            ProcessedTips { motion },
            contacts(RECORDED),
        )?;
    } else if let Some(roles) = file.roles {
        let markers = marker_indices(recording, roles);
        let look = Look {
            frame: World::NAME,
            paint: Paint::Fingers,
            links: false,
            shells: false,
        };
        views.add(
            &recorded,
            look,
            RecordedTips { markers },
            contacts(RECORDED),
        )?;
    }
    for (place, method) in file.generated.iter().enumerate().filter(|_| tree.hand) {
        let topics = MethodTopics::new(method.name)?;
        let generated = TipTopics {
            cloud: &topics.view_fingertips,
            // Scenes of all methods on top of each other would show none.
            scene: (place == 0).then_some(&topics.view_scene),
            balls: None,
            contacts: (place == 0).then_some(&topics.view_contacts),
        };
        // Planned motion alone needs telling apart from nothing: its fingers show which is which.
        let alone = file.motion.is_none() && file.roles.is_none() && place == 0;
        let look = if alone {
            in_hand(Paint::Fingers, true)
        } else {
            in_hand(Paint::One(method_colour(place)), false)
        };
        let tips = GeneratedTips::new(method.segments);
        views.add(&generated, look, tips, contacts(method.name))?;
    }
    if let Some(hulls) = file.hulls.filter(|_| tree.hand) {
        hulls::write_outlines(hulls, start, output)?;
    }
    match file.object_shape {
        Some(shape) if tree.object => solid::write(shape, Object::NAME, start, output)?,
        None if tree.object => axes::write(Object::NAME, start, output)?,
        _ => {}
    }
    log::add(file, measured, output, streams)
}

const fn in_hand(paint: Paint, links: bool) -> Look {
    Look {
        frame: Hand::NAME,
        paint,
        links,
        shells: matches!(paint, Paint::One(_)),
    }
}

/// Where views of one set of fingertips go.
struct TipTopics<'t> {
    cloud: &'t str,
    scene: Option<&'t str>,
    balls: Option<&'t str>,
    contacts: Option<&'t str>,
}

/// Adds views of fingertips.
struct TipViews<'s, 'o, 'a> {
    stride: usize,
    rate_hz: f64,
    output: &'s mut Output<'o>,
    streams: &'s mut Streams<'a>,
}

impl<'a> TipViews<'_, '_, 'a> {
    /// A cloud, a scene, and a cloud of those in contact where that is known.
    fn add(
        &mut self,
        topics: &TipTopics<'_>,
        look: Look,
        tips: impl Tips + Clone + 'a,
        contacts: Option<Contacts<'a>>,
    ) -> Result<(), ChannelError> {
        let frame = look.frame;
        let channel = self
            .output
            .channel::<PointCloud>(topics.cloud, Some(frame))?;
        let cloud = FingertipCloud::new(
            channel,
            frame,
            (self.stride, Dot::Point),
            look.paint,
            tips.clone(),
        );
        self.streams.push(Box::new(cloud));
        let scene_stride = scene_stride(self.rate_hz);
        if let Some(topic) = topics.balls {
            let channel = self.output.channel::<PointCloud>(topic, Some(frame))?;
            let balls = FingertipCloud::new(
                channel,
                frame,
                (scene_stride, Dot::Ball),
                look.paint,
                tips.clone(),
            );
            self.streams.push(Box::new(balls));
        }
        let known = contacts.clone().filter(|contacts| !contacts.is_empty());
        if let (Some(topic), Some(contacts)) = (topics.contacts, known) {
            let channel = self.output.channel::<PointCloud>(topic, Some(frame))?;
            let cloud = ContactCloud::new(channel, frame, scene_stride, tips.clone(), contacts);
            self.streams.push(Box::new(cloud));
        }
        if let Some(topic) = topics.scene {
            let channel = self.output.channel::<SceneUpdate>(topic, Some(frame))?;
            let scene = FingertipScene::new(channel, look, self.rate_hz, tips, contacts);
            self.streams.push(Box::new(scene));
        }
        Ok(())
    }
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
