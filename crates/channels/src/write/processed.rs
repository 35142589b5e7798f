//! A take in the hand's frame: fingertips, object, and the hand itself in the world.

use inhand_model::{Frame, Hand, Motion, Object, Pose, PoseTrack, Position, World};

use super::{Instant, Stream, Streams, fingertip, fingertips};
use crate::error::ChannelError;
use crate::messages;
use crate::output::{ChannelId, Output};
use crate::topic;
use crate::wire::{Point, Quaternion, Timestamp};

pub(super) fn add<'a>(
    motion: &'a Motion,
    output: &mut Output,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    streams.push(Box::new(Fingertips {
        channel: output
            .channel::<messages::Fingertips>(topic::PROCESSED_FINGERTIPS, Some(Hand::NAME))?,
        motion,
    }));
    if let Some(object) = &motion.object {
        let channel =
            output.channel::<messages::Bodies>(topic::PROCESSED_OBJECT, Some(Hand::NAME))?;
        streams.push(Box::new(OnePose::<Hand, Object>::new(channel, object)));
    }
    let channel = output.channel::<messages::Bodies>(topic::PROCESSED_HAND, Some(World::NAME))?;
    streams.push(Box::new(OnePose::<World, Hand>::new(channel, &motion.hand)));
    Ok(())
}

struct Fingertips<'a> {
    channel: ChannelId,
    motion: &'a Motion,
}

impl Stream for Fingertips<'_> {
    fn sample(&mut self, at: &Instant<'_>, output: &mut Output) -> Result<(), ChannelError> {
        let &Instant { k, unix_nanos, .. } = at;
        let message = fingertips(unix_nanos, |finger| {
            let track = &self.motion.fingertips[finger];
            fingertip(track.get(k).map(Position::to_array), track.status(k))
        });
        output.message(self.channel, k, unix_nanos, &message)
    }
}

/// One frame's pose as an `inhand.Bodies` of one.
struct OnePose<'a, To: Frame, From: Frame> {
    channel: ChannelId,
    track: &'a PoseTrack<To, From>,
    message: messages::Bodies,
}

impl<'a, To: Frame, From: Frame> OnePose<'a, To, From> {
    fn new(channel: ChannelId, track: &'a PoseTrack<To, From>) -> Self {
        Self {
            channel,
            track,
            message: messages::Bodies {
                timestamp: None,
                bodies: vec![messages::Body {
                    name: From::NAME.to_owned(),
                    ..messages::Body::default()
                }],
            },
        }
    }
}

impl<To: Frame, From: Frame> Stream for OnePose<'_, To, From> {
    fn sample(&mut self, at: &Instant<'_>, output: &mut Output) -> Result<(), ChannelError> {
        let &Instant { k, unix_nanos, .. } = at;
        self.message.timestamp = Some(Timestamp::from_unix_nanos(unix_nanos));
        let pose: Option<Pose<To, From>> = self.track.get(k);
        for body in &mut self.message.bodies {
            body.position_m = pose.map(|pose| Point::from(pose.origin().to_array()));
            body.orientation = pose.map(|pose| Quaternion::from(pose.quaternion_xyzw()));
            body.status = messages::Status::from(self.track.status(k)).into();
        }
        output.message(self.channel, k, unix_nanos, &self.message)
    }
}
