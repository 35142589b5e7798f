//! Messages to samples: which message holds each sample of a series.

use std::collections::BTreeMap;

use inhand_model::Finding;

use crate::pace::median;
use crate::series::{Gathered, Series};
use crate::timing::Timing;

/// Messages further from their samples than this share of a period, in the median, follow another
/// clock.
const OFF_CLOCK: f64 = 0.25;

/// For each sample of a series its place in the series, or [`NOWHERE`].
pub(crate) struct Placed(Vec<u32>);

/// No place in a series.
const NOWHERE: u32 = u32::MAX;

impl Placed {
    /// The place of sample `k` in the series.
    pub(crate) fn get(&self, k: usize) -> Option<usize> {
        let at = self.0.get(k).filter(|&&at| at != NOWHERE);
        at.map(|&at| at as usize)
    }
}

/// Oddities in the times of a topic's messages.
#[derive(Default)]
struct Oddities {
    unstamped: usize,
    back_steps: usize,
    outside: usize,
    repeated: usize,
    contradicted: usize,
    off_clock: Option<f64>,
}

/// Samples of the messages of a stream.
struct StreamSamples {
    sample: Vec<Option<usize>>,
    oddities: Oddities,
}

/// The samples of every series that is used, and what was odd.
pub(crate) fn place(
    gathered: &Gathered<'_>,
    used: &[usize],
    timing: &Timing,
) -> (Vec<Placed>, Vec<Finding>) {
    let mut streams: BTreeMap<usize, StreamSamples> = BTreeMap::new();
    let mut topics: BTreeMap<usize, Oddities> = BTreeMap::new();
    let mut placed = Vec::with_capacity(used.len());
    for &index in used {
        let series = &gathered.series[index];
        let stream = (streams.entry(series.stream))
            .or_insert_with(|| stream_samples(gathered, series.stream, timing));
        let topic = topics.entry(series.topic).or_default();
        let found = std::mem::take(&mut stream.oddities);
        topic.unstamped += found.unstamped;
        topic.back_steps += found.back_steps;
        topic.outside += found.outside;
        if let Some(off) = found.off_clock {
            topic.off_clock = Some(topic.off_clock.unwrap_or(0.0).max(off));
        }
        placed.push(place_series(series, &stream.sample, timing.samples, topic));
    }
    let findings = (topics.iter())
        .flat_map(|(&topic, oddities)| findings(&gathered.topics[topic].name, oddities))
        .collect();
    (placed, findings)
}

fn stream_samples(gathered: &Gathered<'_>, stream: usize, timing: &Timing) -> StreamSamples {
    let times = timing.times(&gathered.streams[stream]);
    let mut oddities = Oddities::default();
    let mut last = 0;
    let mut off = Vec::with_capacity(times.len());
    let mut sample = Vec::with_capacity(times.len());
    for time in times {
        let Some(time) = time else {
            oddities.unstamped += 1;
            sample.push(None);
            continue;
        };
        oddities.back_steps += usize::from(time < last);
        last = time;
        let found = timing.grid.sample(time);
        oddities.outside += usize::from(found.is_none());
        off.extend(found.map(|(_, periods)| periods.abs()));
        sample.push(found.map(|(sample, _)| sample));
    }
    oddities.off_clock = median(off).filter(|&periods| periods > OFF_CLOCK);
    StreamSamples { sample, oddities }
}

fn place_series(
    series: &Series,
    sample_of_message: &[Option<usize>],
    samples: usize,
    oddities: &mut Oddities,
) -> Placed {
    let mut at = vec![NOWHERE; samples];
    for (k, &message) in series.message.iter().enumerate() {
        let Some(sample) = sample_of_message.get(message as usize).copied().flatten() else {
            continue;
        };
        let here = u32::try_from(k).unwrap_or(NOWHERE);
        if at[sample] == NOWHERE {
            at[sample] = here;
            continue;
        }
        let before = at[sample] as usize;
        let same = series.position[before] == series.position[k]
            && series.rotation[before] == series.rotation[k];
        oddities.repeated += usize::from(same);
        oddities.contradicted += usize::from(!same);
    }
    Placed(at)
}

fn findings(topic: &str, oddities: &Oddities) -> Vec<Finding> {
    let counted = [
        (
            oddities.unstamped,
            "messages have no stamp, or one far from those of the others: left out",
        ),
        (
            oddities.back_steps,
            "messages come after a later one: put in the order of their times",
        ),
        (
            oddities.outside,
            "messages are before the first or after the last sample of the take's clock: left out",
        ),
        (
            oddities.repeated,
            "values come twice for one sample and are equal: taken once",
        ),
        (
            oddities.contradicted,
            "values come again for a sample and differ, as where two programs send on one topic or \
             stamps jitter by more than half a sample: the first one is taken",
        ),
    ];
    let counted = counted.into_iter().filter(|(count, _)| *count > 0);
    let counted = counted.map(|(count, what)| format!("{count} {what}"));
    let off_clock = oddities.off_clock.map(|off| {
        format!(
            "the times of messages are {off:.2} samples off the take's clock in the median: they \
             follow another clock or rate and are put at the nearest sample; \"ignore\" under \
             [topics] leaves them out"
        )
    });
    let messages = counted.chain(off_clock);
    messages
        .map(|message| Finding::warning(topic, message))
        .collect()
}
