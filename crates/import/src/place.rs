//! Messages to samples: which message holds each sample of a series.

use std::collections::BTreeMap;

use inhand_model::Finding;

use crate::pace::median;
use crate::series::{Gathered, Series};
use crate::timing::Timing;

/// Messages further from their samples than this share of a period, in the median, follow another
/// clock.
const OFF_CLOCK: f64 = 0.25;

/// Messages closer together than this were sent together; further from its sample than this a message may belong to the
/// one beside it, periods.
const TOGETHER: f64 = 0.25;

/// Samples within which a message that came late is looked for: waiting is rare, or all messages wait.
const LATE_MESSAGES: usize = 16;

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
    clock_sets: usize,
    outside: usize,
    repeated: usize,
    contradicted: usize,
    late: usize,
    off_clock: Option<f64>,
}

/// Samples of the messages of a stream.
struct StreamSamples {
    /// With the distance in time from it, periods.
    sample: Vec<Option<(usize, f64)>>,
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
        topic.clock_sets += found.clock_sets;
        topic.outside += found.outside;
        if let Some(off) = found.off_clock {
            topic.off_clock = Some(topic.off_clock.unwrap_or(0.0).max(off));
        }
        placed.push(place_series(series, &stream.sample, timing.samples, topic));
    }
    let mut found: Vec<Finding> = (topics.iter())
        .flat_map(|(&topic, oddities)| findings(&gathered.topics[topic].name, oddities))
        .collect();
    let is_empty = |sample: &usize| placed.iter().all(|series| series.get(*sample).is_none());
    let (empty, samples) = ((0..timing.samples).filter(is_empty).count(), timing.samples);
    if empty > 0 {
        let message =
            format!("{empty} of {samples} frames are in no message: taken as missing samples");
        found.insert(0, Finding::warning(timing.place.clone(), message));
    }
    (placed, found)
}

fn stream_samples(gathered: &Gathered<'_>, stream: usize, timing: &Timing) -> StreamSamples {
    let times = timing.times(&gathered.streams[stream]);
    let mut oddities = Oddities {
        clock_sets: timing.clock_sets(&gathered.streams[stream]),
        ..Oddities::default()
    };
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
        sample.push(found);
    }
    oddities.off_clock = median(off).filter(|&periods| periods > OFF_CLOCK);
    StreamSamples { sample, oddities }
}

/// A message of a series: its place there, its sample, and how far from the sample it is in time, periods.
#[derive(Clone, Copy)]
struct Arrival {
    at: usize,
    sample: usize,
    off: f64,
}

fn place_series(
    series: &Series,
    sample_of_message: &[Option<(usize, f64)>],
    samples: usize,
    oddities: &mut Oddities,
) -> Placed {
    let arrivals = (series.message.iter().enumerate()).filter_map(|(at, &message)| {
        let (sample, off) = sample_of_message.get(message as usize).copied()??;
        Some(Arrival { at, sample, off })
    });
    let mut arrivals: Vec<Arrival> = arrivals.collect();
    arrivals.sort_by(|a, b| a.sample.cmp(&b.sample).then(a.off.total_cmp(&b.off)));
    let before = arrivals.len();
    arrivals.dedup_by(|later, first| {
        let same = |values: &[[f64; 3]]| values[later.at] == values[first.at];
        later.sample == first.sample
            && same(&series.position)
            && series.rotation[later.at] == series.rotation[first.at]
    });
    oddities.repeated += before - arrivals.len();
    let late = spread(&mut arrivals, samples);
    oddities.late += late;
    let mut placed = vec![NOWHERE; samples];
    let groups = arrivals.chunk_by(|a, b| a.sample == b.sample);
    for (n, group) in groups.enumerate() {
        oddities.contradicted += group.len() - 1;
        // Where messages wait those before the first sample may have done so.
        let taken = match late > 0 && n == 0 {
            true => group.last(),
            false => (group.iter()).min_by(|a, b| a.off.abs().total_cmp(&b.off.abs())),
        };
        if let Some(taken) = taken {
            placed[taken.sample] = u32::try_from(taken.at).unwrap_or(NOWHERE);
        }
    }
    Placed(placed)
}

/// Moves messages that share a sample with another one to the empty sample that is theirs; returns how many. A message
/// that waits to be sent has the stamp of the next one, and may meet one that waits itself: it goes to the sample before,
/// those between move by one, up to [`LATE_MESSAGES`] samples. One whose stamp jitters by more than half a sample goes to the
/// next sample on its side. Where there are more messages than samples several programs send, and none is moved.
fn spread(arrivals: &mut [Arrival], samples: usize) -> usize {
    let mut count = vec![0_u32; samples];
    for arrival in &*arrivals {
        count[arrival.sample] += 1;
    }
    let filled = count.iter().filter(|&&count| count > 0).count();
    let (Some(first), Some(last)) = (arrivals.first(), arrivals.last()) else {
        return 0;
    };
    let empty = last.sample - first.sample + 1 - filled;
    // Those that waited for the first sample have none to go to.
    let shared = arrivals.len() - filled - (count[first.sample] as usize - 1);
    if shared > empty {
        return 0;
    }
    let mut moved = 0;
    for k in 1..arrivals.len() {
        let (sample, off) = (arrivals[k].sample, arrivals[k].off);
        let before = arrivals[k - 1];
        if before.sample != sample {
            continue;
        }
        let is_last = arrivals.get(k + 1).is_none_or(|next| next.sample > sample);
        if off - before.off <= TOGETHER {
            let nearest = sample.saturating_sub(LATE_MESSAGES);
            let mut run = (nearest..sample).rev().take_while(|&s| count[s] < 2);
            let Some(gap) = run.find(|&s| count[s] == 0) else {
                continue;
            };
            count[gap] += 1;
            count[sample] -= 1;
            // Samples between have one message each.
            for arrival in arrivals[..k].iter_mut().rev().take(sample - gap) {
                arrival.sample -= 1;
            }
            moved += sample - gap;
        } else if off > TOGETHER && is_last && count.get(sample + 1) == Some(&0) {
            count[sample + 1] += 1;
            count[sample] -= 1;
            arrivals[k].sample += 1;
            moved += 1;
        } else if before.off < -TOGETHER && sample > 0 && count[sample - 1] == 0 {
            count[sample - 1] += 1;
            count[sample] -= 1;
            arrivals[k - 1].sample -= 1;
            moved += 1;
        }
    }
    moved
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
            oddities.clock_sets,
            "times between messages at which log times jump and stamps do not, as where the recorder's clock was set: \
             stamps are used",
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
             stamps jitter by more than half a sample: the nearest in time is taken",
        ),
        (
            oddities.late,
            "values come with that of another sample, as where messages wait to be sent or stamps \
             jitter by more than half a sample: put at the empty samples beside it",
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
