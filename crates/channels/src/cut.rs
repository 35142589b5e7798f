//! Adjusts the metadata of a take when its file is cut.

use std::collections::BTreeMap;
use std::ops::Range;

use inhand_container::{ChannelFacts, Interval, Latch, MetadataRecord};
use inhand_model::{Clock, Provenance};

use crate::error::ChannelError;
use crate::metadata::{CLEANED, Metadata, RECORDING, RecordingFacts};
use crate::read::TIME_TOLERANCE_NANOS;
use crate::take::RECORDED;
use crate::topic;

/// A range of a take as a take of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct TakeCut {
    /// Samples that stay.
    pub samples: Range<usize>,
    /// Whether these are all samples of the take.
    pub whole: bool,
    /// Log times of the messages that stay.
    pub keep: Interval,
    /// Metadata records to replace, by name.
    pub replace: BTreeMap<String, BTreeMap<String, String>>,
    /// Metadata records to add.
    pub add: Vec<MetadataRecord>,
}

/// Finds what to change in the file of a take so that its samples in `intervals` are a take again: the
/// number of samples and the start. `made` is added to what made the take. `None` for a file that is
/// no take.
///
/// The samples nearest to the ends of the interval count, as in [`inhand_model::Clock::nearest_sample`].
/// Nothing changes where all samples stay.
///
/// # Errors
///
/// [`ChannelError::Mismatch`] for intervals without a sample, and for several ranges with others
/// between them, which no single take can hold, and for metadata that does not parse.
pub fn cut_take(
    metadata: &Metadata,
    file_name: &str,
    intervals: &[Interval],
    made: &Provenance,
) -> Result<Option<TakeCut>, ChannelError> {
    let Some(facts) = metadata.recording(file_name, RECORDING)? else {
        return Ok(None);
    };
    let (clock, len) = (facts.clock, facts.samples);
    let samples = kept_samples(&facts, file_name, intervals)?;
    let mut cut = TakeCut {
        samples: samples.clone(),
        whole: samples == (0..len),
        keep: Interval::ALL,
        replace: BTreeMap::new(),
        add: Vec::new(),
    };
    if cut.whole {
        return Ok(Some(cut));
    }
    // Times of samples may be off by the rounding of earlier cuts.
    let edge = |k: usize| clock.unix_nanos(k).saturating_sub(TIME_TOLERANCE_NANOS);
    let from = match samples.start {
        0 => 0,
        start => edge(start),
    };
    cut.keep = Interval::new(from, (samples.end < len).then(|| edge(samples.end)));
    let mut replace = |record: &str, clock: Clock, samples: Range<usize>| {
        let start = clock.starting_at(samples.start).start_unix_nanos();
        let facts = metadata.cut_recording(record, samples.len(), start);
        cut.replace.insert(record.to_owned(), facts);
    };
    replace(RECORDING, clock, samples);
    if let Some(cleaned) = metadata.recording(file_name, CLEANED)? {
        // Its clock may be another one: of its samples those with a message in the interval stay.
        let first_from = |unix_nanos: u64| {
            let times = (0..cleaned.samples).map(|k| cleaned.clock.unix_nanos(k));
            times.take_while(|&time| time < unix_nanos).count()
        };
        let first = first_from(cut.keep.from_unix_nanos());
        let end = cut.keep.to_unix_nanos().map_or(cleaned.samples, first_from);
        replace(CLEANED, cleaned.clock, first..end);
    }
    cut.add = (metadata.next_provenance(made).0.into_iter())
        .map(|(name, facts)| MetadataRecord { name, facts })
        .collect();
    Ok(Some(cut))
}

/// Samples of a take in intervals of time, which have to be one range.
fn kept_samples(
    facts: &RecordingFacts,
    file_name: &str,
    intervals: &[Interval],
) -> Result<Range<usize>, ChannelError> {
    let (clock, len) = (facts.clock, facts.samples);
    let nearest = |unix_nanos: u64| {
        let since_start = unix_nanos.saturating_sub(clock.start_unix_nanos()) as f64 * 1e-9;
        clock.nearest_sample(since_start).min(len)
    };
    let mut ranges: Vec<Range<usize>> = (intervals.iter())
        .map(|interval| {
            let end = interval.to_unix_nanos().map_or(len, nearest);
            nearest(interval.from_unix_nanos())..end
        })
        .filter(|range| !range.is_empty())
        .collect();
    ranges.sort_by_key(|range| range.start);
    let mut joined: Vec<Range<usize>> = Vec::new();
    for range in ranges {
        match joined.last_mut() {
            Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
            _ => joined.push(range),
        }
    }
    match &joined[..] {
        [samples] => Ok(samples.clone()),
        // A take without samples has all of them in any interval.
        [] if len == 0 => Ok(0..0),
        _ => Err(ChannelError::mismatch(
            format!("{file_name}: what is kept of the take"),
            format!("one range of its {len} samples ({} s)", clock.time_s(len)),
            match joined.len() {
                0 => "none of them".to_owned(),
                n => format!("{n} ranges with others between them; cut each into a file"),
            },
        )),
    }
}

/// Which messages of a take hold beyond their instant: as [`inhand_container::latch`], and what is said
/// once for the whole take.
pub fn latch(channel: &ChannelFacts) -> Option<Latch> {
    match &*channel.topic {
        topic::RECORDING_FINDINGS => Some(Latch::All),
        // The tree of views beside a third-party tree.
        topic::VIEW_TF_STATIC | topic::VIEW_FRAMES => Some(Latch::All),
        topic if is_sent_once(topic) => Some(Latch::Last),
        _ => inhand_container::latch(channel),
    }
}

/// Whether a single message of the topic holds for the whole file.
fn is_sent_once(topic: &str) -> bool {
    let of_file = [
        topic::VIEW_OBJECT,
        topic::VIEW_OBJECT_EDGES,
        topic::VIEW_OBJECT_SURFACE,
        topic::VIEW_TAKE_HULLS,
        topic::VIEW_HULLS,
        topic::VIEW_LEGEND,
    ];
    let of_layer = |topic: &str| {
        let leaf = topic.strip_prefix("/view/overlay/");
        leaf.is_some_and(|leaf| leaf.ends_with("/object") || leaf.ends_with("/object_edges"))
    };
    of_file.contains(&topic) || of_layer(topic)
}

/// Whether a channel counts samples from the start of the whole take, so that it has no meaning in a
/// range of it: generated trajectories and how they were judged, what cleaning changed.
pub fn is_of_whole_take(channel: &ChannelFacts) -> bool {
    counts_from_start(&channel.topic)
}

fn counts_from_start(topic: &str) -> bool {
    let parts = [
        "/generated/",
        "/held_out/",
        "/evaluation/",
        "/view/generated/",
        topic::CLEANED_CHANGES,
    ];
    // What touched in the recording is said of each instant alone.
    let recorded = format!("/evaluation/{RECORDED}/contact");
    topic != recorded && parts.iter().any(|part| topic.starts_with(part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_sent_once_is_there_after_a_cut() {
        for topic in [
            "/view/object",
            "/view/object_surface",
            "/view/hulls",
            "/view/dictionary/hulls",
            "/view/overlay/legend",
            "/view/overlay/prior/object",
            "/view/overlay/prior/object_edges",
        ] {
            assert!(is_sent_once(topic), "{topic}");
        }
        for topic in [
            "/view/fingertips",
            "/view/overlay/prior/fingertips",
            "/view/overlay/prior/tf",
        ] {
            assert!(!is_sent_once(topic), "{topic}");
        }
    }

    #[test]
    fn contacts_of_the_recording_hold_in_a_stretch_of_it() {
        assert!(!counts_from_start("/evaluation/recorded/contact"));
        for topic in [
            "/evaluation/prior/contact",
            "/evaluation/prior/error",
            "/generated/prior/plan",
        ] {
            assert!(counts_from_start(topic), "{topic}");
        }
    }
}
