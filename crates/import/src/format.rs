//! The registry of message kinds that can be read.

use crate::foxglove;
use crate::reading::{Fault, Reading};
use crate::ros::{self, Cdr};

/// Rank of messages made for motion capture.
pub(crate) const MOTION_CAPTURE: u8 = 0;
/// Rank of poses and points.
pub(crate) const POSES: u8 = 1;
/// Rank of clouds of points.
pub(crate) const CLOUDS: u8 = 2;
/// Rank of transforms, which robots send of all their parts.
pub(crate) const TRANSFORMS: u8 = 3;

type Readings<'a> = Result<Vec<Reading<'a>>, Fault>;

/// Decoder of a message.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Decode {
    Cdr(for<'a> fn(&mut Cdr<'a>) -> Readings<'a>),
    Protobuf(fn(&[u8]) -> Readings<'static>),
    Json(fn(&serde_json::Value) -> Readings<'static>),
}

/// A message type in one encoding.
#[derive(Debug)]
pub(crate) struct MessageKind {
    /// Names of its schema.
    pub(crate) schemas: &'static [&'static str],
    pub(crate) decode: Decode,
    /// How much a topic of this kind says about a take, 0 most.
    pub(crate) rank: u8,
}

impl MessageKind {
    /// The kind of a channel, by the name of its schema and its encoding.
    pub(crate) fn find(schema: &str, encoding: &str) -> Option<&'static Self> {
        let name = schema.replacen("/msg/", "/", 1);
        let mut kinds = (ros::PACKAGES.into_iter().chain([foxglove::KINDS])).flatten();
        kinds.find(|kind| kind.encoding() == encoding && kind.schemas.contains(&name.as_str()))
    }

    fn encoding(&self) -> &'static str {
        match self.decode {
            Decode::Cdr(_) => "cdr",
            Decode::Protobuf(_) => "protobuf",
            Decode::Json(_) => "json",
        }
    }

    /// Decodes a message.
    pub(crate) fn read<'a>(&self, message: &'a [u8]) -> Readings<'a> {
        match self.decode {
            Decode::Cdr(read) => {
                let cdr = &mut Cdr::new(message)?;
                let readings = read(cdr)?;
                cdr.end()?;
                Ok(readings)
            }
            Decode::Protobuf(read) => read(message),
            Decode::Json(read) => read(&foxglove::parse_json(message)?),
        }
    }

    pub(crate) fn is_cloud(&self) -> bool {
        self.rank == CLOUDS
    }
}
