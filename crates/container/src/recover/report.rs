//! Report of a recovery: saved and lost data.

use std::collections::{BTreeMap, BTreeSet};

use crate::writer::Written;

/// Most losses that are listed one by one.
const MOST_LISTED: usize = 1000;

/// Bytes of a file that could not be used.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Loss {
    /// Where they start.
    pub offset: u64,
    /// How many they are.
    pub bytes: u64,
    /// What they were.
    pub what: String,
    /// Log times of the messages in them where the file states them, else of those saved before and
    /// after them.
    pub span: Option<(u64, u64)>,
}

/// What was saved of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Recovered {
    /// What the output holds.
    pub written: Written,
    /// Names of the metadata records in it.
    pub metadata: BTreeSet<String>,
    /// What could not be used, in the file's order; the first thousand.
    pub losses: Vec<Loss>,
    /// Losses that are not listed.
    pub losses_unlisted: u64,
    /// Bytes of all losses.
    pub lost_bytes: u64,
    /// Messages that were left out since nothing says of which channel they are, by channel id.
    pub without_channel: BTreeMap<u16, u64>,
    /// Topics whose schema is lost; they are written without one.
    pub without_schema: BTreeSet<String>,
    /// Schemas and channels without a checksum that contradict one with it, and were left out.
    pub contradictions: u64,
    /// Topics and schemas that only damaged bytes define: a chunk or summary whose checksum differs.
    pub doubtful: BTreeSet<String>,
    /// Messages of chunks whose checksum differs that are kept, under topics that start with
    /// `/unverified`.
    pub unverified: u64,
    /// Wrong bytes that cost nothing, by their place.
    pub mended: BTreeMap<u64, String>,
    /// Messages that the file's own summary counts.
    pub stated_messages: Option<u64>,
    /// Whether the file ends before its data do, or its writer never finished it.
    pub unfinished: bool,
    /// Whether records outside chunks may hold other bytes than were written: the checksum over all
    /// data does not hold though every record looks sound, or they were found behind damage.
    pub unchecked: bool,
    /// Parts that say nothing new and were made anew.
    pub repaired: BTreeSet<String>,
}

impl Recovered {
    /// Whether the output holds less than what was once written, or may hold something else.
    pub fn is_lossy(&self) -> bool {
        !self.losses.is_empty()
            || !self.without_channel.is_empty()
            || !self.without_schema.is_empty()
            || self.contradictions > 0
            || !self.doubtful.is_empty()
            || !self.mended.is_empty()
            || self.unfinished
            || self.unchecked
            || self
                .stated_messages
                .is_some_and(|stated| stated > self.written.messages - self.unverified)
    }

    /// Whether another loss is listed.
    pub(super) fn has_room(&self) -> bool {
        self.losses.len() < MOST_LISTED
    }

    pub(super) fn lose(&mut self, loss: Loss) {
        self.lost_bytes += loss.bytes;
        if self.has_room() {
            self.losses.push(loss);
        } else {
            self.losses_unlisted += 1;
        }
    }
}
