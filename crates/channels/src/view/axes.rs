//! An object of which only the pose is known: its axes, so that its turning shows.

use foxglove::messages::{Point3, PointCloud, SceneUpdate};

use super::cloud::Cloud;
use super::entities::{entity, strip};
use crate::colour::Rgb;
use crate::error::ChannelError;
use crate::output::Output;
use crate::topic;

/// x, y and z, as in most viewers.
const COLOURS: [Rgb; 3] = [[0xE0, 0x3C, 0x31], [0x3F, 0xA3, 0x4D], [0x3A, 0x6F, 0xD8]];
/// Length of an axis, metres: about half of what a hand turns.
const LENGTH_M: f64 = 0.025;
/// Thickness of an axis, metres.
const THICKNESS_M: f64 = 0.001;
/// Points along an axis.
const POINTS: usize = 10;

/// Sends the axes once, at the start, on the topics of the object: they move with its frame.
pub(crate) fn write(frame: &str, unix_nanos: u64, output: &mut Output) -> Result<(), ChannelError> {
    let mut axes = entity(frame, "object", unix_nanos);
    let mut cloud = Cloud::new(frame, "edge");
    for (axis, colour) in COLOURS.into_iter().enumerate() {
        let along = |share: f64| {
            let mut point = [0.0; 3];
            point[axis] = LENGTH_M * share;
            point
        };
        let [x, y, z] = along(1.0);
        let ends = vec![Point3::default(), Point3 { x, y, z }];
        axes.lines.push(strip(ends, THICKNESS_M, (colour, 1.0)));
        for n in 0..=POINTS {
            cloud.push(along(n as f64 / POINTS as f64), axis, colour);
        }
    }
    let update = SceneUpdate {
        deletions: Vec::new(),
        entities: vec![axes],
    };
    let channel = output.channel::<SceneUpdate>(topic::VIEW_OBJECT, Some(frame))?;
    output.message(channel, 0, unix_nanos, &update)?;
    let channel = output.channel::<PointCloud>(topic::VIEW_OBJECT_EDGES, Some(frame))?;
    output.message(channel, 0, unix_nanos, cloud.message(unix_nanos))
}
