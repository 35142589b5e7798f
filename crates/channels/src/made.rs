//! Generated and evaluated motion of methods, by sample.

use inhand_model::{Finger, Protocol, Trajectory};

use crate::take::{EvaluatedSample, GeneratedMethod, GeneratedSegment, TakeFile};

/// What methods made of the samples of a block, in the order of the file's methods.
#[derive(Default)]
pub(crate) struct Made<'a> {
    published: Vec<ByStart<'a>>,
    held_out: Vec<ByStart<'a>>,
    evaluated: Vec<Vec<&'a EvaluatedSample>>,
}

impl<'a> Made<'a> {
    /// The parts of a file that belong to methods.
    pub(crate) fn new(file: &TakeFile<'a>) -> Self {
        let by_start = |method: &GeneratedMethod<'a>| ByStart::new(method.segments);
        let evaluated = file.evaluated.iter().map(|method| {
            let mut samples: Vec<_> = method.samples.iter().collect();
            samples.sort_by_key(|judged| judged.sample);
            samples
        });
        Self {
            published: file.generated.iter().map(by_start).collect(),
            held_out: file.held_out.iter().map(by_start).collect(),
            evaluated: evaluated.collect(),
        }
    }

    /// Segments of the method at a place.
    pub(crate) fn generated(&self, protocol: Protocol, place: usize) -> Option<&ByStart<'a>> {
        match protocol {
            Protocol::Published => self.published.get(place),
            Protocol::HeldOut => self.held_out.get(place),
        }
    }

    /// How the method at a place was judged at sample `k`.
    pub(crate) fn evaluated(&self, place: usize, k: usize) -> &[&'a EvaluatedSample] {
        let samples = self.evaluated.get(place).map_or(&[][..], Vec::as_slice);
        let first = samples.partition_point(|judged| judged.sample < k);
        let count = samples[first..].partition_point(|judged| judged.sample == k);
        &samples[first..first + count]
    }
}

/// Segments of a method in the order in which they start.
pub(crate) struct ByStart<'a> {
    segments: Vec<&'a GeneratedSegment<'a>>,
    /// Samples of the longest trajectory.
    longest: usize,
}

impl<'a> ByStart<'a> {
    pub(crate) fn new(segments: &'a [GeneratedSegment<'a>]) -> Self {
        let mut segments: Vec<_> = segments.iter().collect();
        // Readers keep the last plan of a start: that with a trajectory.
        segments.sort_by_key(|segment| (segment.start_sample, segment.trajectory.is_some()));
        let trajectories = segments.iter().filter_map(|segment| segment.trajectory);
        let longest = trajectories.map(|trajectory| trajectory.layout().samples);
        Self {
            longest: longest.max().unwrap_or(0),
            segments,
        }
    }

    /// Segments that start at sample `k`.
    pub(crate) fn starting(&self, k: usize) -> &[&'a GeneratedSegment<'a>] {
        let first = (self.segments).partition_point(|segment| segment.start_sample < k);
        let segments = &self.segments[first..];
        &segments[..segments.partition_point(|segment| segment.start_sample == k)]
    }

    /// Trajectories that have sample `k`, each with its own number of that sample.
    pub(crate) fn at(&self, k: usize) -> impl DoubleEndedIterator<Item = (usize, &'a Trajectory)> {
        let is_over = |segment: &&GeneratedSegment<'_>| segment.start_sample + self.longest <= k;
        let first = self.segments.partition_point(is_over);
        let end = (self.segments).partition_point(|segment| segment.start_sample <= k);
        let started = self.segments[first..end].iter();
        started.filter_map(move |segment| {
            let (t, trajectory) = (k - segment.start_sample, segment.trajectory?);
            (t < trajectory.layout().samples).then_some((t, trajectory))
        })
    }

    /// Coordinates of a fingertip at sample `k`, metres: where trajectories overlap, the one that started last counts.
    pub(crate) fn position_m(&self, k: usize, finger: Finger) -> Option<[f64; 3]> {
        let (t, trajectory) = self.at(k).next_back()?;
        Some(trajectory.position(t, finger).to_array())
    }
}
