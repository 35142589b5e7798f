//! Recordings as drivers of others write them, made by hand.

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::MessageHeader;

/// A message in CDR, laid out by the standard and not by the reader under test.
pub(crate) struct Cdr {
    bytes: Vec<u8>,
    little_endian: bool,
}

impl Cdr {
    pub(crate) fn new(little_endian: bool) -> Self {
        Self {
            bytes: vec![0, u8::from(little_endian), 0, 0],
            little_endian,
        }
    }

    fn put(mut self, little: &[u8]) -> Self {
        while !(self.bytes.len() - 4).is_multiple_of(little.len()) {
            self.bytes.push(0xAA); // What stands between numbers does not matter.
        }
        if self.little_endian {
            self.bytes.extend(little);
        } else {
            self.bytes.extend(little.iter().rev());
        }
        self
    }

    pub(crate) fn i8(self, value: i8) -> Self {
        self.put(&value.to_le_bytes())
    }

    pub(crate) fn u32(self, value: u32) -> Self {
        self.put(&value.to_le_bytes())
    }

    pub(crate) fn f64s(self, values: &[f64]) -> Self {
        values.iter().fold(self, |cdr, v| cdr.put(&v.to_le_bytes()))
    }

    pub(crate) fn text(self, text: &str) -> Self {
        let mut cdr = self.u32(text.len() as u32 + 1);
        cdr.bytes.extend(text.as_bytes());
        cdr.bytes.push(0);
        cdr
    }

    pub(crate) fn header(self, stamp_nanos: u64, frame: &str) -> Self {
        let (seconds, nanos) = (stamp_nanos / 1_000_000_000, stamp_nanos % 1_000_000_000);
        self.u32(seconds as u32).u32(nanos as u32).text(frame)
    }

    pub(crate) fn end(self) -> Vec<u8> {
        self.bytes
    }
}

/// `mocap4r2_msgs/msg/Markers` of named markers, or numbered ones where the name is empty.
pub(crate) fn markers(little_endian: bool, stamp: u64, seen: &[(&str, [f64; 3])]) -> Vec<u8> {
    let head = Cdr::new(little_endian).header(stamp, "world").u32(0);
    let each = |cdr: Cdr, (k, (name, at)): (usize, &(&str, [f64; 3]))| {
        let id_type = i8::from(name.is_empty());
        cdr.i8(id_type).u32(k as u32).text(name).f64s(at)
    };
    let all = head.u32(seen.len() as u32);
    seen.iter().enumerate().fold(all, each).end()
}

/// A position and a quaternion.
pub(crate) type Seven = [f64; 7];

/// `mocap4r2_msgs/msg/RigidBodies`, each with one marker of its own.
pub(crate) fn bodies(little_endian: bool, stamp: u64, seen: &[(&str, Seven)]) -> Vec<u8> {
    let head = Cdr::new(little_endian).header(stamp, "world").u32(0);
    let each = |cdr: Cdr, (name, pose): &(&str, Seven)| {
        let cdr = cdr.text(name).u32(1);
        cdr.i8(1).u32(4).text("").f64s(&pose[..3]).f64s(pose)
    };
    seen.iter().fold(head.u32(seen.len() as u32), each).end()
}

/// `geometry_msgs/msg/PoseStamped`.
pub(crate) fn pose(stamp: u64, frame: &str, pose: Seven) -> Vec<u8> {
    Cdr::new(true).header(stamp, frame).f64s(&pose).end()
}

/// `tf2_msgs/msg/TFMessage` of parent, child and pose.
pub(crate) fn transforms(stamp: u64, transforms: &[(&str, &str, Seven)]) -> Vec<u8> {
    let count = Cdr::new(true).u32(transforms.len() as u32);
    let each = |cdr: Cdr, (parent, child, pose): &(&str, &str, Seven)| {
        cdr.header(stamp, parent).text(child).f64s(pose)
    };
    transforms.iter().fold(count, each).end()
}

pub(crate) const MARKERS: (&str, &str) = ("mocap4r2_msgs/msg/Markers", "cdr");
pub(crate) const BODIES: (&str, &str) = ("mocap4r2_msgs/msg/RigidBodies", "cdr");
pub(crate) const POSE: (&str, &str) = ("geometry_msgs/msg/PoseStamped", "cdr");
pub(crate) const POINT: (&str, &str) = ("geometry_msgs/msg/PointStamped", "cdr");
pub(crate) const TRANSFORMS: (&str, &str) = ("tf2_msgs/msg/TFMessage", "cdr");

/// A recording while it is written.
pub(crate) struct Bag {
    writer: mcap::Writer<Cursor<Vec<u8>>>,
    channels: BTreeMap<(String, u16), u16>,
}

impl Bag {
    pub(crate) fn new() -> Self {
        let options = mcap::WriteOptions::new().profile("ros2");
        Self {
            writer: options.create(Cursor::new(Vec::new())).unwrap(),
            channels: BTreeMap::new(),
        }
    }

    /// Adds a message that was logged and sent at `log`.
    pub(crate) fn add(&mut self, topic: &str, kind: (&str, &str), log: u64, data: &[u8]) {
        self.add_by(0, topic, kind, [log, log], data);
    }

    /// Adds a message of one of several programs that send on a topic, with the times at which it
    /// was logged and sent.
    pub(crate) fn add_by(
        &mut self,
        program: u16,
        topic: &str,
        (schema, encoding): (&str, &str),
        [log_time, publish_time]: [u64; 2],
        data: &[u8],
    ) {
        let writer = &mut self.writer;
        let channel_id = *(self.channels.entry((topic.to_owned(), program))).or_insert_with(|| {
            let about = [("program".to_owned(), program.to_string())];
            let schema = writer
                .add_schema(schema, "ros2msg", b"as documented")
                .unwrap();
            writer
                .add_channel(schema, topic, encoding, &about.into())
                .unwrap()
        });
        let header = MessageHeader {
            channel_id,
            sequence: 0,
            log_time,
            publish_time,
        };
        writer.write_to_known_channel(&header, data).unwrap();
    }

    pub(crate) fn end(mut self) -> Vec<u8> {
        self.writer.finish().unwrap();
        self.writer.into_inner().into_inner()
    }
}
