//! Retained messages: those that a client needs when it subscribes.

use std::collections::{BTreeMap, BTreeSet};

/// Most messages that are retained of a channel on which each adds to those before.
const MOST_ADDED: usize = 4096;

/// The last message of each channel; of some channels all different ones.
#[derive(Default)]
pub(crate) struct Retained {
    /// Channels on which each message adds to those before.
    adding: BTreeSet<u64>,
    /// Log time and data.
    messages: BTreeMap<u64, Vec<(u64, Vec<u8>)>>,
}

impl Retained {
    pub(crate) fn new(adding: BTreeSet<u64>) -> Self {
        Self {
            adding,
            messages: BTreeMap::new(),
        }
    }

    pub(crate) fn clear(&mut self) {
        self.messages.clear();
    }

    /// Takes a message that is not earlier than those before.
    pub(crate) fn take(&mut self, channel: u64, log_time: u64, data: &[u8]) {
        let retained = self.messages.entry(channel).or_default();
        if self.adding.contains(&channel) {
            let known = retained.iter().any(|(_, other)| other == data);
            if !known && retained.len() < MOST_ADDED {
                retained.push((log_time, data.to_vec()));
            }
        } else if let Some(last) = retained.last_mut() {
            // Into the memory of the one before.
            last.0 = log_time;
            last.1.clear();
            last.1.extend_from_slice(data);
        } else {
            retained.push((log_time, data.to_vec()));
        }
    }

    /// Channel, log time and data of the messages, by log time.
    pub(crate) fn all(&self) -> Vec<(u64, u64, &[u8])> {
        let mut all: Vec<_> = (self.messages.iter())
            .flat_map(|(&channel, retained)| {
                (retained.iter()).map(move |(log_time, data)| (channel, *log_time, &data[..]))
            })
            .collect();
        all.sort_by_key(|&(_, log_time, _)| log_time);
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_is_held_or_all_different_ones() {
        let mut retained = Retained::new(BTreeSet::from([2]));
        for (channel, log_time, data) in [
            (1, 10, b"a"),
            (2, 11, b"x"),
            (1, 12, b"b"),
            (2, 13, b"y"),
            (2, 14, b"x"),
        ] {
            retained.take(channel, log_time, data);
        }
        let expected: [(u64, u64, &[u8]); 3] = [(2, 11, b"x"), (1, 12, b"b"), (2, 13, b"y")];
        assert_eq!(retained.all(), expected);
        retained.clear();
        assert_eq!(retained.all(), []);
    }
}
