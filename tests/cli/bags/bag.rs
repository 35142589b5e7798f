//! ROS 2 bags by hand: the records of MCAP and messages in CDR, as their documents lay them out.

const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// A bag while it is written, without chunks and summary.
pub(crate) struct Bag {
    bytes: Vec<u8>,
    channels: u16,
}

impl Bag {
    pub(crate) fn new() -> Self {
        let mut bag = Self {
            bytes: MAGIC.to_vec(),
            channels: 0,
        };
        bag.record(0x01, &[text("ros2"), text("by hand")].concat());
        bag
    }

    fn record(&mut self, opcode: u8, body: &[u8]) {
        self.bytes.push(opcode);
        self.bytes.extend((body.len() as u64).to_le_bytes());
        self.bytes.extend(body);
    }

    /// A channel with a schema of its own.
    pub(crate) fn channel(&mut self, topic: &str, schema: &str) -> u16 {
        self.channels += 1;
        let id = self.channels.to_le_bytes().to_vec();
        let schema = [id.clone(), text(schema), text("ros2msg"), text("")].concat();
        self.record(0x03, &schema);
        let metadata = 0_u32.to_le_bytes().to_vec();
        let channel = [id.clone(), id, text(topic), text("cdr"), metadata].concat();
        self.record(0x04, &channel);
        self.channels
    }

    pub(crate) fn message(&mut self, channel: u16, log: u64, data: &[u8]) {
        self.message_start(channel, log, data.len() as u64);
        self.bytes.extend(data);
    }

    /// A message up to its data, which have this many bytes.
    pub(crate) fn message_start(&mut self, channel: u16, log: u64, bytes: u64) {
        self.bytes.push(0x05);
        self.bytes.extend((22 + bytes).to_le_bytes());
        self.bytes.extend(channel.to_le_bytes());
        self.bytes.extend(0_u32.to_le_bytes());
        self.bytes.extend(log.to_le_bytes());
        self.bytes.extend(log.to_le_bytes());
    }

    /// The bytes that were not taken before.
    pub(crate) fn take(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.bytes)
    }

    pub(crate) fn end(mut self) -> Vec<u8> {
        self.record(0x0F, &[0; 4]);
        self.record(0x02, &[0; 20]);
        self.bytes.extend(MAGIC);
        self.bytes
    }
}

/// A text as MCAP has it.
fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

/// A message in little-endian CDR.
struct Cdr(Vec<u8>);

impl Cdr {
    fn new(stamp: u64) -> Self {
        let (seconds, nanos) = (stamp / 1_000_000_000, stamp % 1_000_000_000);
        let header = Cdr(vec![0, 1, 0, 0]);
        header.u32(seconds as u32).u32(nanos as u32).text("world")
    }

    fn put(mut self, number: &[u8]) -> Self {
        while !(self.0.len() - 4).is_multiple_of(number.len()) {
            self.0.push(0);
        }
        self.0.extend(number);
        self
    }

    fn u32(self, number: u32) -> Self {
        self.put(&number.to_le_bytes())
    }

    fn f64s(self, numbers: &[f64]) -> Self {
        numbers
            .iter()
            .fold(self, |cdr, n| cdr.put(&n.to_le_bytes()))
    }

    fn text(self, text: &str) -> Self {
        let mut cdr = self.u32(text.len() as u32 + 1);
        cdr.0.extend(text.as_bytes());
        cdr.0.push(0);
        cdr
    }
}

/// `mocap4r2_msgs/msg/Markers`.
pub(crate) fn markers(stamp: u64, seen: &[(&str, [f64; 3])]) -> Vec<u8> {
    let head = Cdr::new(stamp).u32(0).u32(seen.len() as u32);
    let each = |cdr: Cdr, (name, at): &(&str, [f64; 3])| cdr.put(&[0]).u32(0).text(name).f64s(at);
    seen.iter().fold(head, each).0
}

/// `mocap4r2_msgs/msg/RigidBodies` without markers of their own.
pub(crate) fn rigid_bodies(stamp: u64, seen: &[(&str, [f64; 3], [f64; 4])]) -> Vec<u8> {
    let head = Cdr::new(stamp).u32(0).u32(seen.len() as u32);
    let each = |cdr: Cdr, (name, at, rotation): &(&str, [f64; 3], [f64; 4])| {
        cdr.text(name).u32(0).f64s(at).f64s(rotation)
    };
    seen.iter().fold(head, each).0
}

/// `geometry_msgs/msg/PoseStamped`.
pub(crate) fn pose(stamp: u64, at: [f64; 3], rotation: [f64; 4]) -> Vec<u8> {
    Cdr::new(stamp).f64s(&at).f64s(&rotation).0
}
