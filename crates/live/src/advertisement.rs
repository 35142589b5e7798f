//! The channels of a file as they are advertised to clients.

use std::collections::{BTreeMap, BTreeSet};

use inhand_container::{ChannelFacts, Latch, latch};

use crate::protocol::{advertise, check_schema};

/// The channels that clients can subscribe to.
#[derive(Default)]
pub(crate) struct Advertisement {
    /// By number; channels that differ in nothing that a viewer sees are one.
    channels: BTreeMap<u64, ChannelFacts>,
    /// Numbers of the channels of the file.
    numbers: BTreeMap<u16, u64>,
    /// Topics that cannot be advertised, and why.
    pub(crate) left_out: Vec<(String, &'static str)>,
}

impl Advertisement {
    pub(crate) fn new<'a>(channels: impl IntoIterator<Item = &'a ChannelFacts>) -> Self {
        let mut advertisement = Self::default();
        for channel in channels {
            if let Err(why) = check_schema(channel) {
                advertisement.left_out.push((channel.topic.clone(), why));
                continue;
            }
            let same = |other: &ChannelFacts| {
                other.topic == channel.topic
                    && other.message_encoding == channel.message_encoding
                    && other.schema == channel.schema
            };
            let known = (advertisement.channels.iter()).find(|(_, other)| same(other));
            let number = match known {
                Some((&number, _)) => number,
                None => {
                    let number = advertisement.channels.len() as u64 + 1;
                    advertisement.channels.insert(number, channel.clone());
                    number
                }
            };
            advertisement.numbers.insert(channel.id, number);
        }
        advertisement
    }

    /// The number of a channel of the file.
    pub(crate) fn number(&self, channel: u16) -> Option<u64> {
        self.numbers.get(&channel).copied()
    }

    pub(crate) fn has(&self, number: u64) -> bool {
        self.channels.contains_key(&number)
    }

    /// Those on which each message adds to those before.
    pub(crate) fn adding(&self) -> BTreeSet<u64> {
        (self.channels.iter())
            .filter(|(_, channel)| latch(channel) == Some(Latch::All))
            .map(|(&number, _)| number)
            .collect()
    }

    pub(crate) fn advertise(&self) -> String {
        advertise(
            self.channels
                .iter()
                .map(|(&number, channel)| (number, channel)),
        )
    }
}
