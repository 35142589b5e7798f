//! The clock that the messages of a file follow, the take's rate, and its samples.

use std::collections::BTreeSet;

use inhand_model::{Clock, Finding, StartTime};

use crate::pace::{Grid, Pace, median, seconds};
use crate::series::{Gathered, Times};
use crate::topics::ImportSettings;
use inhand_channels::ChannelError;

/// A stamp whose distance to its log time is this far from that of the others is no stamp: the zero
/// of a first message, the clock of another computer.
const STRAY_STAMP_S: f64 = 60.0;

/// Streams whose rates differ by less than this share follow one clock.
const SAME_RATE: f64 = 0.02;

/// Samples that jumps of the stamps may leave out, for each one that there is, beside
/// [`FREE_GAPS`]: a bound on memory.
const LEFT_OUT_PER_SAMPLE: u64 = 10;
const FREE_GAPS: u64 = 1 << 20;

/// Stamps before this, the year 2001, are seconds since a simulation or computer started.
const CALENDAR_NANOS: u64 = 978_307_200_000_000_000;

/// Source of the time of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TimeSource {
    Stamp,
    Publish,
    Log,
}

/// The samples of a take, and how messages find theirs.
pub(crate) struct Timing {
    pub(crate) clock: Clock,
    pub(crate) samples: usize,
    pub(crate) grid: Grid,
    source: TimeSource,
    /// From stamps to log times, seconds: least, median and most.
    latency_s: Option<[f64; 3]>,
    /// The topic that the clock is taken from.
    pub(crate) place: String,
    pub(crate) findings: Vec<Finding>,
}

/// A stream that the clock may be taken from.
struct Candidate {
    stream: usize,
    /// Values of all its series.
    values: usize,
    pace: Pace,
}

impl Timing {
    /// The clock of the messages of the highest priority.
    pub(crate) fn new(
        gathered: &Gathered<'_>,
        used: &[usize],
        settings: &ImportSettings,
    ) -> Result<Self, ChannelError> {
        let rank = |series: usize| gathered.topics[gathered.series[series].topic].rank();
        let ranks: BTreeSet<u8> = used.iter().map(|&series| rank(series)).collect();
        for wanted in ranks {
            let series = used
                .iter()
                .copied()
                .filter(|&series| rank(series) == wanted);
            let mut streams: Vec<usize> = series.map(|s| gathered.series[s].stream).collect();
            streams.sort_unstable();
            let source = source(gathered, &streams);
            let candidates = candidates(gathered, &streams, source, settings);
            if let Some(reference) = most_values(candidates) {
                return Self::from_streams(gathered, &reference, source, used.len(), settings);
            }
        }
        let topic = used
            .first()
            .map_or(0, |&series| gathered.series[series].topic);
        Err(gathered.unclear(
            topic,
            "at least two messages at different times".to_owned(),
            format!("{} messages at one time", gathered.topics[topic].messages),
            "a take has to hold motion over time",
        ))
    }

    fn from_streams(
        gathered: &Gathered<'_>,
        reference: &[Candidate],
        source: TimeSource,
        series: usize,
        settings: &ImportSettings,
    ) -> Result<Self, ChannelError> {
        let messages = |c: &&Candidate| gathered.streams[c.stream].frames.len();
        // The first of those with most messages.
        let best = reference.iter().rev().max_by_key(messages);
        let Some(&Candidate { stream, pace, .. }) = best else {
            return Err(gathered.unclear(0, "messages".to_owned(), "none".to_owned(), ""));
        };
        let topic = topic_of(gathered, stream);
        let rate_hz = rate(gathered, topic, pace, settings)?;
        let latency_s = match source {
            TimeSource::Stamp => latency(gathered, reference),
            TimeSource::Publish | TimeSource::Log => None,
        };
        let mut times: Vec<u64> = (reference.iter())
            .flat_map(|c| frame_times(&gathered.streams[c.stream], source, pace.period_s))
            .collect();
        times.sort_unstable();
        let unclear = |found: String| {
            gathered.unclear(
                topic,
                "stamps that follow each other".to_owned(),
                found,
                "cut the recording into takes, or set this topic to \"ignore\" under [topics]",
            )
        };
        let grid = Grid::new(&times, pace.period_s).ok_or_else(|| unclear("none".to_owned()))?;
        let messages = gathered.streams[stream].frames.len();
        if settings.rate_hz.is_none() && grid.is_mostly_empty(messages) {
            return Err(mostly_empty(gathered, topic, &grid, rate_hz));
        }
        let stored: usize = gathered.series.iter().map(|s| s.message.len()).sum();
        let limit = LEFT_OUT_PER_SAMPLE
            .saturating_mul(stored as u64)
            .saturating_add(FREE_GAPS);
        let samples = usize::try_from(grid.len()).ok();
        let samples = samples.filter(|&n| (n as u64).saturating_mul(series as u64) <= limit);
        let Some(samples) = samples else {
            return Err(unclear(format!(
                "jumps: {} samples from the first stamp to the last, {} of them with a stamp",
                grid.len(),
                grid.stamped()
            )));
        };
        let start_nanos = grid.start_nanos();
        let start_time = if start_nanos >= CALENDAR_NANOS {
            StartTime::Stated
        } else {
            StartTime::Unknown
        };
        let clock = Clock::new(start_nanos, start_time, rate_hz)
            .map_err(|error| unclear(error.to_string()))?;
        let mut timing = Self {
            clock,
            samples,
            grid,
            source,
            latency_s,
            place: gathered.topics[topic].name.clone(),
            findings: Vec::new(),
        };
        timing.findings = timing.clock_findings(pace, settings);
        Ok(timing)
    }

    /// Capture times of the messages of a stream; `None` for those whose stamps mean nothing.
    pub(crate) fn times(&self, stream: &Times) -> Vec<Option<u64>> {
        capture_times(stream, self.source, self.latency_s)
    }

    /// How often the clock of the recorder was set between messages of a stream, where that shows.
    pub(crate) fn clock_sets(&self, stream: &Times) -> usize {
        match self.source {
            TimeSource::Stamp => steady_log(stream).1,
            TimeSource::Publish | TimeSource::Log => 0,
        }
    }

    /// Findings about the clock that is used, and how it was found.
    fn clock_findings(&self, pace: Pace, settings: &ImportSettings) -> Vec<Finding> {
        let place = self.place.as_str();
        let (measured, rate_hz) = (pace.rate_hz(), self.clock.rate_hz());
        let numbers = format!(
            "{measured:.4} Hz measured (± {:.4}), jitter {:.2} ms",
            pace.rate_error_hz(),
            pace.jitter_s * 1e3
        );
        let rate = match (settings.rate_hz, pace.device_rate_hz()) {
            (Some(given), _) => {
                let message = format!("{given} Hz as set: {numbers}");
                match (measured / given - 1.0).abs() > SAME_RATE {
                    true => Finding::warning(place, message),
                    false => Finding::info(place, message),
                }
            }
            (None, Some(_)) => {
                let message = format!("{rate_hz} Hz: {numbers}, which singles it out");
                Finding::info(place, message)
            }
            (None, None) => {
                let message = format!(
                    "the rate stays as measured, {numbers}: it singles out no rate that devices \
                     have; source.rate_hz sets it"
                );
                Finding::warning(place, message)
            }
        };
        let source = match (self.source, self.latency_s) {
            (TimeSource::Stamp, Some(latency_s)) => {
                let [least, middle, most] = latency_s.map(|seconds| seconds * 1e3);
                let message = format!(
                    "times are capture times, the stamps of the messages; they were logged \
                     {least:.1} to {most:.1} ms later (median {middle:.1} ms)"
                );
                Finding::info(place, message)
            }
            (source, _) => {
                let (when, delay) = match source {
                    TimeSource::Publish => ("sent", ""),
                    _ => ("logged", " that varies"),
                };
                let message = format!(
                    "the messages carry no stamps that distinguish them: times are when they were \
                     {when}, which is later than capture by an unknown delay{delay}"
                );
                Finding::warning(place, message)
            }
        };
        vec![rate, source]
    }
}

fn topic_of(gathered: &Gathered<'_>, stream: usize) -> usize {
    let series = gathered
        .series
        .iter()
        .find(|series| series.stream == stream);
    series.map_or(0, |series| series.topic)
}

/// The error that a clock leaves most samples empty.
fn mostly_empty(gathered: &Gathered<'_>, topic: usize, grid: &Grid, rate_hz: f64) -> ChannelError {
    gathered.unclear(
        topic,
        "a clock at which most samples have a message".to_owned(),
        format!(
            "{rate_hz:.2} Hz by the distances of stamps, at which {} of {} samples have none: the messages come in \
             bursts",
            grid.len() - grid.stamped(),
            grid.len()
        ),
        "set source.rate_hz to the rate of the cameras, or set this topic to \"ignore\" under [topics]",
    )
}

/// Capture times of the frames of a stream: of the messages of its fullest series, and of those that are further than
/// half a period from any of them. Where a frame has a message for each marker its time is that of one marker.
fn frame_times(stream: &Times, source: TimeSource, period_s: f64) -> Vec<u64> {
    let all = capture_times(stream, source, None);
    let frames = stream.of_frames(&all).into_iter().flatten();
    let mut frames: Vec<u64> = frames.collect();
    frames.sort_unstable();
    let half_ns = (period_s * 5e8) as u64;
    let is_apart = |time: &u64| {
        let after = frames.partition_point(|frame| frame < time);
        let near = [after.checked_sub(1), Some(after)];
        let mut near = near.into_iter().flatten().filter_map(|k| frames.get(k));
        !near.any(|frame| frame.abs_diff(*time) <= half_ns)
    };
    let mut others: Vec<u64> = all.into_iter().flatten().filter(is_apart).collect();
    others.extend(frames);
    others
}

/// The rate as set, as stamps single it out, or as measured.
fn rate(
    gathered: &Gathered<'_>,
    topic: usize,
    pace: Pace,
    settings: &ImportSettings,
) -> Result<f64, ChannelError> {
    if let Some(rate_hz) = settings.rate_hz {
        return Ok(rate_hz);
    }
    if !pace.is_proven() {
        return Err(gathered.unclear(
            topic,
            "stamps at an even rate".to_owned(),
            format!(
                "stamps about {:.3} ms apart that are {:.3} ms off an even clock",
                pace.period_s * 1e3,
                pace.jitter_s * 1e3
            ),
            "set source.rate_hz, or set this topic to \"ignore\" under [topics]",
        ));
    }
    Ok(pace.device_rate_hz().unwrap_or(pace.rate_hz()))
}

/// The stamps, where those of most series distinguish their messages; else when messages were sent,
/// where that differs from when they were logged.
fn source(gathered: &Gathered<'_>, streams: &[usize]) -> TimeSource {
    let share = |usable: &dyn Fn(&Times) -> bool| {
        let usable = streams.iter().filter(|&&s| usable(&gathered.streams[s]));
        2 * usable.count() > streams.len()
    };
    let distinct = |times: &Times, of: &[u64]| are_distinct(&times.of_frames(of));
    if share(&|times| distinct(times, &times.stamp)) {
        TimeSource::Stamp
    } else if share(&|times| times.publish != times.log && distinct(times, &times.publish)) {
        TimeSource::Publish
    } else {
        TimeSource::Log
    }
}

/// Whether at least half of the times are there and differ from each other.
fn are_distinct(times: &[u64]) -> bool {
    let mut present: Vec<u64> = times.iter().copied().filter(|&time| time > 0).collect();
    present.sort_unstable();
    present.dedup();
    2 * present.len() >= times.len()
}

fn candidates(
    gathered: &Gathered<'_>,
    streams: &[usize],
    source: TimeSource,
    settings: &ImportSettings,
) -> Vec<Candidate> {
    let mut candidates: Vec<Candidate> = Vec::new();
    for &stream in streams {
        let times = &gathered.streams[stream];
        let messages = times.frames.len();
        if let Some(known) = candidates.last_mut().filter(|known| known.stream == stream) {
            known.values += messages;
            continue;
        }
        let captured = times.of_frames(&capture_times(times, source, None));
        let mut times: Vec<u64> = captured.into_iter().flatten().collect();
        times.sort_unstable();
        times.dedup();
        let base = times.first().copied().unwrap_or(0);
        let times_s: Vec<f64> = times.iter().map(|&time| seconds(base, time)).collect();
        if let Some(pace) = Pace::new(&times_s, settings.rate_hz.map(|rate_hz| 1.0 / rate_hz)) {
            candidates.push(Candidate {
                stream,
                values: messages,
                pace,
            });
        }
    }
    candidates
}

/// The streams of the rate at which most values come; of two the higher.
fn most_values(mut candidates: Vec<Candidate>) -> Option<Vec<Candidate>> {
    candidates.sort_by(|a, b| b.pace.rate_hz().total_cmp(&a.pace.rate_hz()));
    let mut best: Option<(usize, f64)> = None;
    for (k, candidate) in candidates.iter().enumerate() {
        let rate_hz = candidate.pace.rate_hz();
        let alike = (candidates[k..].iter()).filter(|other| same_rate(other, rate_hz));
        let values = alike.map(|other| other.values).sum();
        if best.is_none_or(|(most, _)| values > most) {
            best = Some((values, rate_hz));
        }
    }
    let (_, rate_hz) = best?;
    candidates.retain(|candidate| same_rate(candidate, rate_hz));
    candidates.sort_by_key(|candidate| candidate.stream);
    Some(candidates)
}

/// Whether a rate is that one, or less by no more than the tolerance.
fn same_rate(candidate: &Candidate, rate_hz: f64) -> bool {
    let share = 1.0 - candidate.pace.rate_hz() / rate_hz;
    (0.0..SAME_RATE).contains(&share)
}

/// From stamps to log times in seconds: least, median, most.
fn latency(gathered: &Gathered<'_>, reference: &[Candidate]) -> Option<[f64; 3]> {
    let all = reference.iter().flat_map(|candidate| {
        let stream = &gathered.streams[candidate.stream];
        let times = capture_times(stream, TimeSource::Stamp, None);
        let late = |(time, log): (Option<u64>, u64)| Some(seconds(time?, log));
        times
            .into_iter()
            .zip(steady_log(stream).0)
            .filter_map(late)
            .collect::<Vec<_>>()
    });
    let all: Vec<f64> = all.collect();
    let least = all.iter().copied().fold(f64::INFINITY, f64::min);
    let most = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Some([least, median(all)?, most])
}

/// Log times by a clock that is not set, and how often it was: where it steps by more than [`STRAY_STAMP_S`] between
/// two messages whose stamps follow each other.
fn steady_log(times: &Times) -> (Vec<u64>, usize) {
    let (mut steady, mut sets, mut ahead) = (Vec::with_capacity(times.log.len()), 0, 0);
    let mut last = None;
    for (&stamp, &log) in times.stamp.iter().zip(&times.log) {
        if let Some((last_stamp, last_log)) = last.replace((stamp, log)) {
            let (of_stamps, of_logs) = (seconds(last_stamp, stamp), seconds(last_log, log));
            let follows = of_stamps > 0.0 && of_stamps <= STRAY_STAMP_S;
            if follows && (of_logs - of_stamps).abs() > STRAY_STAMP_S {
                let change = |from: u64, to: u64| i128::from(to) - i128::from(from);
                ahead += change(last_log, log) - change(last_stamp, stamp);
                sets += 1;
            }
        }
        steady.push(u64::try_from(i128::from(log) - ahead).unwrap_or_default());
    }
    (steady, sets)
}

/// Capture times of messages. Stamps that are not there, or far from where the others of the stream
/// are beside their log times, are none; a stream without stamps beside others that have them
/// follows its log times, less the delay of the others.
fn capture_times(
    times: &Times,
    source: TimeSource,
    latency_s: Option<[f64; 3]>,
) -> Vec<Option<u64>> {
    match source {
        TimeSource::Publish => times.publish.iter().copied().map(Some).collect(),
        TimeSource::Log => times.log.iter().copied().map(Some).collect(),
        TimeSource::Stamp if !are_distinct(&times.of_frames(&times.stamp)) => {
            let Some([_, middle_s, _]) = latency_s else {
                return vec![None; times.log.len()];
            };
            let delay = (middle_s * 1e9).round() as i64;
            let captured = |log: &u64| Some(log.saturating_add_signed(-delay));
            times.log.iter().map(captured).collect()
        }
        TimeSource::Stamp => {
            // A zero is a stamp where a clock starts with it, and stray elsewhere.
            let (log, _) = steady_log(times);
            let both = || times.stamp.iter().zip(&log);
            let late = |(&stamp, &log): (&u64, &u64)| seconds(stamp, log);
            let middle_s = median(both().map(late).collect()).unwrap_or(0.0);
            let captured = |(stamp, log)| {
                let stray = (late((stamp, log)) - middle_s).abs() > STRAY_STAMP_S;
                (!stray).then_some(*stamp)
            };
            both().map(captured).collect()
        }
    }
}
