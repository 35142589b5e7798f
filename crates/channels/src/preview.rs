//! Quick preview of a file: channels, frames, first pose of the hand.

use std::collections::{BTreeMap, BTreeSet};

use foxglove::messages::{FrameTransform, FrameTransforms};
use inhand_container::{
    ChannelFacts, ContainerError, Depth, Record, Source, channels, walk_source,
};
use inhand_model::{Frame, Hand, World};
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use prost::Message as _;

use crate::error::ChannelError;
use crate::messages;
use crate::topic;
use crate::topic_role::{TopicRole, TopicSource};
use crate::view::UPRIGHT;

/// Bytes of messages that are looked at before the search for frames and fingertips is given up:
/// some seconds of any take, more than a second of a bag with pictures.
const MOST_BYTES: usize = 32 << 20;

/// Content of a file, as far as its first messages show it.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Preview {
    /// Its channels, in the order of their ids.
    pub channels: Vec<ChannelFacts>,
    /// Frames that its first transforms and its channels name.
    pub frames: BTreeSet<String>,
    /// Where fingertips, or else markers, are first seen, by frame: in `hand` where that is placed, and
    /// what is in `world` in `upright`, in which z is up.
    pub seen: BTreeMap<String, PointExtent>,
}

/// Place and size of a set of points.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PointExtent {
    /// Their mean, metres.
    pub centre_m: [f64; 3],
    /// The least of their third coordinates, metres.
    pub lowest_m: f64,
    /// Distance of the farthest from the mean, metres.
    pub radius_m: f64,
}

impl PointExtent {
    /// The extent of the points that are finite, if there are any.
    fn new(points: &[Point3<f64>]) -> Option<Self> {
        let points: Vec<_> = (points.iter())
            .filter(|p| p.coords.iter().all(|c| c.is_finite()))
            .collect();
        if points.is_empty() {
            return None;
        }
        let sum: Vector3<f64> = points.iter().map(|p| p.coords).sum();
        let centre = Point3::from(sum / points.len() as f64);
        let farthest = |most: f64, p: &&Point3<f64>| most.max(nalgebra::distance(p, &centre));
        Some(Self {
            centre_m: centre.into(),
            lowest_m: points.iter().map(|p| p.z).fold(f64::INFINITY, f64::min),
            radius_m: points.iter().fold(0.0, farthest),
        })
    }
}

/// Looks at the channels of a file, and at its messages only up to the first that show frames and
/// fingertips.
///
/// # Errors
///
/// [`ChannelError::Container`] where the records that are looked at do not follow each other.
pub fn preview(source: &mut Source<'_>) -> Result<Preview, ChannelError> {
    let channels = channels(source)?;
    let mut search = Search::new(&channels);
    // An error of `None` ends the walk early.
    if let Err(Some(error)) = walk_source(source, |record| search.visit(&record).ok_or(None)) {
        return Err(ContainerError::into(error));
    }
    let (mut frames, mut points) = (search.frames, search.points);
    let named = channels.iter().filter_map(|c| c.metadata.get("frame"));
    frames.extend(named.filter(|frame| !frame.is_empty()).cloned());
    if let Some(pose) = search.world_from_hand
        && !points.contains_key(Hand::NAME)
        && let Some(in_world) = points.get(World::NAME)
    {
        let in_hand = in_world.iter().map(|p| pose.inverse_transform_point(p));
        points.insert(Hand::NAME, in_hand.collect());
    }
    if let Some(in_world) = points.remove(World::NAME) {
        let upright = in_world.iter().map(|p| search.upright_from_world * p);
        points.insert(UPRIGHT, upright.collect());
    }
    let seen = (points.into_iter())
        .filter_map(|(frame, points)| Some((frame.to_owned(), PointExtent::new(&points)?)))
        .collect();
    Ok(Preview {
        channels,
        frames,
        seen,
    })
}

/// Content of a channel that is searched for; points have a frame.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Wanted<'a> {
    Transforms,
    Transform,
    Fingertips(&'a str),
    Markers(&'a str),
}

struct Search<'a> {
    /// Channels of which nothing has been found yet.
    wanted: BTreeMap<u16, Wanted<'a>>,
    frames: BTreeSet<String>,
    upright_from_world: UnitQuaternion<f64>,
    world_from_hand: Option<Isometry3<f64>>,
    points: BTreeMap<&'a str, Vec<Point3<f64>>>,
    bytes: usize,
}

impl<'a> Search<'a> {
    fn new(channels: &'a [ChannelFacts]) -> Self {
        let mut wanted: BTreeMap<u16, Wanted<'a>> = BTreeMap::new();
        for channel in channels.iter().filter(|c| c.message_encoding == "protobuf") {
            let frame = channel.metadata.get("frame").map_or("", String::as_str);
            let role = TopicRole::from_topic(&channel.topic);
            let content = match (channel.schema_name(), role) {
                (Some("foxglove.FrameTransforms"), _) => Wanted::Transforms,
                (Some("foxglove.FrameTransform"), _) => Wanted::Transform,
                (Some("inhand.Fingertips"), Some(TopicRole::Positions(source))) => {
                    let known = |w: &Wanted<'_>| matches!(w, Wanted::Fingertips(f) | Wanted::Markers(f) if *f == frame);
                    // Plans and overlays may begin much later than the take beside them.
                    if matches!(source, TopicSource::Method(_) | TopicSource::Overlay(_))
                        && wanted.values().any(known)
                    {
                        continue;
                    }
                    Wanted::Fingertips(frame)
                }
                (Some("inhand.Markers"), Some(_)) if channel.topic == topic::RECORDING_MARKERS => {
                    Wanted::Markers(frame)
                }
                _ => continue,
            };
            wanted.insert(channel.id, content);
        }
        Self {
            wanted,
            frames: BTreeSet::new(),
            upright_from_world: UnitQuaternion::identity(),
            world_from_hand: None,
            points: BTreeMap::new(),
            bytes: 0,
        }
    }

    /// How deep to go on; `None` once enough was seen.
    fn visit(&mut self, record: &Record<'_>) -> Option<Depth> {
        if self.wanted.is_empty() || self.bytes > MOST_BYTES {
            return None;
        }
        if let Record::Message { header, data } = record {
            self.bytes += data.len();
            if let Some(&wanted) = self.wanted.get(&header.channel_id)
                && self.message(wanted, data)
            {
                self.wanted.remove(&header.channel_id);
            }
        }
        Some(Depth::Everything)
    }

    /// Whether the message shows what its channel is searched for. One that does not decode is passed
    /// over.
    fn message(&mut self, wanted: Wanted<'a>, data: &[u8]) -> bool {
        let points: Vec<_> = match wanted {
            Wanted::Transforms => {
                let message = FrameTransforms::decode(data).unwrap_or_default();
                return self.transforms(message.transforms);
            }
            Wanted::Transform => {
                return self.transforms(FrameTransform::decode(data).into_iter().collect());
            }
            Wanted::Fingertips(_) => {
                let tips = messages::Fingertips::decode(data)
                    .unwrap_or_default()
                    .tips();
                let tips = tips.into_array().into_iter();
                tips.filter_map(|tip| tip?.position_m).collect()
            }
            Wanted::Markers(_) => {
                let markers = messages::Markers::decode(data).unwrap_or_default().markers;
                markers.into_iter().filter_map(|m| m.position_m).collect()
            }
        };
        let points: Vec<_> = points.iter().map(|p| Point3::new(p.x, p.y, p.z)).collect();
        let found = !points.is_empty();
        match wanted {
            // Better than markers, of which some may be about anywhere.
            Wanted::Fingertips(frame) if found => {
                self.points.insert(frame, points);
            }
            Wanted::Markers(frame) if found => {
                self.points.entry(frame).or_insert(points);
            }
            _ => {}
        }
        found
    }

    fn transforms(&mut self, transforms: Vec<FrameTransform>) -> bool {
        let found = !transforms.is_empty();
        for transform in transforms {
            let rotation = (transform.rotation)
                .and_then(|q| UnitQuaternion::try_new(Quaternion::new(q.w, q.x, q.y, q.z), 1e-6));
            let edge = (&*transform.parent_frame_id, &*transform.child_frame_id);
            match (edge, rotation) {
                ((UPRIGHT, World::NAME), Some(rotation)) => self.upright_from_world = rotation,
                ((World::NAME, Hand::NAME), Some(rotation)) => {
                    let origin = transform.translation;
                    self.world_from_hand = origin
                        .map(|t| Isometry3::from_parts(Translation3::new(t.x, t.y, t.z), rotation));
                }
                _ => {}
            }
            self.frames.insert(transform.parent_frame_id);
            self.frames.insert(transform.child_frame_id);
        }
        found
    }
}
