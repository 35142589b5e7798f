//! The registry of message kinds that can be read.

use crate::reading::{Fault, Reading};
use crate::{foxglove, ros};

/// Rank of messages made for motion capture.
pub(crate) const MOTION_CAPTURE: u8 = 0;
/// Rank of poses and points.
pub(crate) const POSES: u8 = 1;
/// Rank of clouds of points.
pub(crate) const CLOUDS: u8 = 2;
/// Rank of transforms, which robots send of all their parts.
pub(crate) const TRANSFORMS: u8 = 3;

/// The contents of a message.
pub(crate) type Readings<'a> = Result<Vec<Reading<'a>>, Fault>;

/// A message type in one encoding.
#[derive(Debug)]
pub(crate) struct MessageKind {
    /// Names of its schema, without the folder `msg` that ROS 2 puts in.
    pub(crate) schemas: &'static [&'static str],
    pub(crate) encoding: &'static str,
    /// How much a topic of this kind says about a take, 0 most.
    pub(crate) rank: u8,
    /// Decodes a message.
    pub(crate) read: for<'a> fn(&'a [u8]) -> Readings<'a>,
}

impl MessageKind {
    /// The kind of a channel, by the name of its schema and its encoding.
    pub(crate) fn find(schema: &str, encoding: &str) -> Option<&'static Self> {
        let name = schema.replacen("/msg/", "/", 1);
        let mut kinds = (ros::PACKAGES.into_iter().chain([foxglove::KINDS])).flatten();
        kinds.find(|kind| kind.encoding == encoding && kind.schemas.contains(&name.as_str()))
    }

    pub(crate) fn is_cloud(&self) -> bool {
        self.rank == CLOUDS
    }
}
