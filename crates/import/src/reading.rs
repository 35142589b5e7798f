//! Kinds of messages, and the contents of one message, independent of its encoding.

use std::borrow::Cow;
use std::fmt;

/// Most markers, bodies or transforms in one message: more are no motion capture.
const MAX_ITEMS: usize = 10_000;

/// Reason why a message cannot be used.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fault {
    pub(crate) expected: String,
    pub(crate) found: String,
}

impl Fault {
    pub(crate) fn new(expected: impl Into<String>, found: impl Into<String>) -> Self {
        Self {
            expected: expected.into(),
            found: found.into(),
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "expected {}, found {}", self.expected, self.found)
    }
}

/// Identification of an item of a message.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Label<'a> {
    /// By nothing: it is the only one of its topic.
    Topic,
    /// By a name, and a number where it has one too.
    Name(Cow<'a, str>, Option<i64>),
    /// By a number that the source gives it.
    Number(i64),
    /// By its place in the message.
    Place(usize),
}

/// Kind of an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A point.
    Marker,
    /// A point of a rigid body.
    BodyMarker,
    /// A pose with an orientation.
    Pose,
    /// A pose in a frame that may move itself.
    Transform,
}

/// A point or pose, in the unit of the source.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Item<'a> {
    pub(crate) label: Label<'a>,
    pub(crate) kind: Kind,
    pub(crate) position: [f64; 3],
    /// x, y, z, w; all zero where there is none.
    pub(crate) rotation: [f64; 4],
}

/// Items of one instant in one frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Reading<'a> {
    /// Nanoseconds since 1970-01-01 UTC as the message states them; 0 where it states none.
    pub(crate) stamp_nanos: u64,
    pub(crate) frame: Cow<'a, str>,
    pub(crate) items: Vec<Item<'a>>,
}

/// Rank of messages made for motion capture.
pub(crate) const MOTION_CAPTURE: u8 = 0;
/// Rank of poses and points.
pub(crate) const POSES: u8 = 1;
/// Rank of clouds of points.
pub(crate) const CLOUDS: u8 = 2;
/// Rank of transforms, which robots send of all their parts.
pub(crate) const TRANSFORMS: u8 = 3;

/// A message as it is stored.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stored<'a> {
    pub(crate) encoding: &'static str,
    pub(crate) bytes: &'a [u8],
}

/// The contents of a message.
pub(crate) type Readings<'a> = Result<Vec<Reading<'a>>, Fault>;

/// A message type in the encodings in which it is read alike.
#[derive(Debug)]
pub(crate) struct MessageKind {
    /// Names of its schema, without the folder `msg` that ROS 2 puts in.
    pub(crate) schemas: &'static [&'static str],
    pub(crate) encodings: &'static [&'static str],
    /// Priority of topics of this kind, 0 highest.
    pub(crate) rank: u8,
    /// Decodes a message.
    pub(crate) read: for<'a> fn(Stored<'a>) -> Readings<'a>,
}

impl MessageKind {
    pub(crate) const fn new(
        encodings: &'static [&'static str],
        schemas: &'static [&'static str],
        rank: u8,
        read: for<'a> fn(Stored<'a>) -> Readings<'a>,
    ) -> Self {
        Self {
            schemas,
            encodings,
            rank,
            read,
        }
    }

    pub(crate) fn is_cloud(&self) -> bool {
        self.rank == CLOUDS
    }
}

/// A count of items of a message, refused where motion capture has none of so many.
pub(crate) fn limited(count: usize, items: &str) -> Result<usize, Fault> {
    if count <= MAX_ITEMS {
        return Ok(count);
    }
    Err(Fault::new(
        format!("at most {MAX_ITEMS} {items} in a message"),
        count.to_string(),
    ))
}

/// Seconds and nanoseconds as nanoseconds; 0 for times before 1970.
pub(crate) fn nanos(seconds: i64, nanos: i64) -> u64 {
    let seconds = u64::try_from(seconds).unwrap_or(0);
    seconds
        .saturating_mul(1_000_000_000)
        .saturating_add(u64::try_from(nanos).unwrap_or(0))
}
