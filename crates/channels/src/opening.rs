//! Quick preview of a file: channels, frames, first pose of the hand.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read, Seek};

use foxglove::messages::{FrameTransform, FrameTransforms};
use inhand_container::{
    ChannelFacts, ContainerError, Depth, Record, Source, channels, walk_source,
};
use inhand_model::{Frame, Hand, World};
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use prost::Message as _;

use crate::error::ChannelError;
use crate::messages;
use crate::shown::{Shown, Whose};
use crate::topic;
use crate::view::UPRIGHT;

/// Bytes of messages that are looked at before the search for frames and fingertips is given up:
/// some seconds of any take, more than a second of a bag with pictures.
const MOST_BYTES: usize = 32 << 20;

/// What can be told of a file quickly.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Opening {
    /// Its channels, in the order of their ids.
    pub channels: Vec<ChannelFacts>,
    /// Frames that its first transforms and its channels name.
    pub frames: BTreeSet<String>,
    /// Where fingertips, or else markers, are first seen, by frame: in `hand` where that is placed, and
    /// what is in `world` in `upright`, in which z is up.
    pub seen: BTreeMap<String, Seen>,
}

/// Where points lie.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Seen {
    /// Their mean, metres.
    pub centre_m: [f64; 3],
    /// The least of their third coordinates, metres.
    pub lowest_m: f64,
    /// Distance of the farthest from the mean, metres.
    pub radius_m: f64,
}

impl Seen {
    fn of(points: &[Point3<f64>]) -> Option<Self> {
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
pub fn opening<R: Read + Seek>(source: &mut Source<R>) -> Result<Opening, ChannelError> {
    let channels = channels(source)?;
    let mut search = Search::new(&channels);
    let walked = walk_source(source, |record| search.visit(&record));
    if let Err(Stop::Failed(error)) = walked {
        return Err(error.into());
    }
    let Search {
        mut frames,
        upright_from_world,
        world_from_hand,
        mut points,
        ..
    } = search;
    let named = channels.iter().filter_map(|c| c.metadata.get("frame"));
    frames.extend(named.filter(|frame| !frame.is_empty()).cloned());
    if let Some(pose) = world_from_hand
        && !points.contains_key(Hand::NAME)
        && let Some(in_world) = points.get(World::NAME)
    {
        let in_hand = in_world
            .iter()
            .map(|point| pose.inverse_transform_point(point));
        points.insert(Hand::NAME.to_owned(), in_hand.collect());
    }
    let mut seen = BTreeMap::new();
    for (frame, points) in points {
        let turned: Vec<_> = points.iter().map(|p| upright_from_world * p).collect();
        let (frame, points) = if frame == World::NAME {
            (UPRIGHT.to_owned(), turned)
        } else {
            (frame, points)
        };
        seen.extend(Seen::of(&points).map(|points| (frame, points)));
    }
    Ok(Opening {
        channels,
        frames,
        seen,
    })
}

/// Why the walk through a file ends early.
enum Stop {
    Enough,
    Failed(ContainerError),
}

impl From<ContainerError> for Stop {
    fn from(error: ContainerError) -> Self {
        Stop::Failed(error)
    }
}

/// What a channel is looked at for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Looked {
    Transforms,
    Transform,
    /// Fingertips, by the number of their frame.
    Fingertips(usize),
    /// Markers, by the number of their frame.
    Markers(usize),
}

struct Search<'a> {
    looked: BTreeMap<u16, Looked>,
    /// Names of the frames that points are in.
    point_frames: Vec<&'a str>,
    /// Channels of which nothing has been found yet.
    wanted: BTreeSet<u16>,
    frames: BTreeSet<String>,
    upright_from_world: UnitQuaternion<f64>,
    world_from_hand: Option<Isometry3<f64>>,
    points: BTreeMap<String, Vec<Point3<f64>>>,
    bytes: usize,
}

impl<'a> Search<'a> {
    fn new(channels: &'a [ChannelFacts]) -> Self {
        let mut search = Self {
            looked: BTreeMap::new(),
            point_frames: Vec::new(),
            wanted: BTreeSet::new(),
            frames: BTreeSet::new(),
            upright_from_world: UnitQuaternion::identity(),
            world_from_hand: None,
            points: BTreeMap::new(),
            bytes: 0,
        };
        for channel in channels.iter().filter(|c| c.message_encoding == "protobuf") {
            let frame = channel.metadata.get("frame").map_or("", String::as_str);
            let looked = match (channel.schema_name(), Shown::of(&channel.topic)) {
                (Some("foxglove.FrameTransforms"), _) => Looked::Transforms,
                (Some("foxglove.FrameTransform"), _) => Looked::Transform,
                (Some("inhand.Fingertips"), Some(Shown::Positions(whose))) => {
                    // Plans and overlays may begin much later than the take beside them.
                    if matches!(whose, Whose::Method(_) | Whose::Overlay(_))
                        && search.point_frames.contains(&frame)
                    {
                        continue;
                    }
                    Looked::Fingertips(search.frame(frame))
                }
                (Some("inhand.Markers"), Some(_)) if channel.topic == topic::RECORDING_MARKERS => {
                    Looked::Markers(search.frame(frame))
                }
                _ => continue,
            };
            search.looked.insert(channel.id, looked);
            search.wanted.insert(channel.id);
        }
        search
    }

    fn frame(&mut self, name: &'a str) -> usize {
        let known = self.point_frames.iter().position(|&frame| frame == name);
        known.unwrap_or_else(|| {
            self.point_frames.push(name);
            self.point_frames.len() - 1
        })
    }

    fn visit(&mut self, record: &Record<'_>) -> Result<Depth, Stop> {
        if self.wanted.is_empty() || self.bytes > MOST_BYTES {
            return Err(Stop::Enough);
        }
        if let Record::Message { header, data } = record {
            self.bytes += data.len();
            if let Some(&looked) = self.looked.get(&header.channel_id)
                && self.wanted.contains(&header.channel_id)
                && self.message(looked, data)
            {
                self.wanted.remove(&header.channel_id);
            }
        }
        Ok(Depth::Everything)
    }

    /// Whether the message shows what its channel is looked at for. One that does not decode is
    /// passed over.
    fn message(&mut self, looked: Looked, data: &[u8]) -> bool {
        match looked {
            Looked::Transforms => {
                let decoded = FrameTransforms::decode(data).map(|message| message.transforms);
                self.transforms(decoded.unwrap_or_default())
            }
            Looked::Transform => {
                self.transforms(FrameTransform::decode(data).into_iter().collect())
            }
            Looked::Fingertips(frame) => {
                let Ok(tips) = messages::Fingertips::decode(data) else {
                    return false;
                };
                let points = tips
                    .tips()
                    .into_array()
                    .into_iter()
                    .flatten()
                    .filter_map(|tip| tip.position_m);
                // Better than markers, of which some may lie about anywhere.
                self.add_points(frame, points.map(|p| Point3::new(p.x, p.y, p.z)).collect())
            }
            Looked::Markers(frame) => {
                let markers = messages::Markers::decode(data).unwrap_or_default().markers;
                let points = markers.into_iter().filter_map(|marker| marker.position_m);
                let points: Vec<_> = points.map(|p| Point3::new(p.x, p.y, p.z)).collect();
                let known = self.points.contains_key(self.point_frames[frame]);
                !points.is_empty() && (known || self.add_points(frame, points))
            }
        }
    }

    fn add_points(&mut self, frame: usize, points: Vec<Point3<f64>>) -> bool {
        let found = !points.is_empty();
        if found {
            let frame = self.point_frames[frame].to_owned();
            self.points.insert(frame, points);
        }
        found
    }

    fn transforms(&mut self, transforms: Vec<FrameTransform>) -> bool {
        for transform in &transforms {
            let rotation = transform
                .rotation
                .and_then(|q| UnitQuaternion::try_new(Quaternion::new(q.w, q.x, q.y, q.z), 1e-6));
            let edge = (&*transform.parent_frame_id, &*transform.child_frame_id);
            match (edge, rotation) {
                ((UPRIGHT, World::NAME), Some(rotation)) => self.upright_from_world = rotation,
                ((World::NAME, Hand::NAME), Some(rotation)) => {
                    let origin = transform
                        .translation
                        .map(|t| Translation3::new(t.x, t.y, t.z));
                    self.world_from_hand =
                        origin.map(|origin| Isometry3::from_parts(origin, rotation));
                }
                _ => {}
            }
        }
        let found = !transforms.is_empty();
        for transform in transforms {
            self.frames.insert(transform.parent_frame_id);
            self.frames.insert(transform.child_frame_id);
        }
        found
    }
}
