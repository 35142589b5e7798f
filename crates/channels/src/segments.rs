//! Segments of a take that were generated and evaluated, as they go into its file.

use std::ops::Range;

use inhand_model::{MethodRows, PerFinger, Plan, SegmentOrigin, Trajectory};

use crate::take::{ContactSample, EvaluatedMethod, EvaluatedSample, GeneratedSegment};

/// Segments with any of these samples of one take.
#[derive(Clone, Debug)]
pub struct TakeSegments<'a> {
    /// Where segments of all takes are.
    pub origins: &'a [SegmentOrigin],
    /// Samples of a segment.
    pub length: usize,
    /// The take.
    pub take: usize,
    /// The samples.
    pub samples: Range<usize>,
}

impl<'a> TakeSegments<'a> {
    /// Places of the segments among all, in order.
    pub fn places(&self) -> impl Iterator<Item = usize> + use<'a> {
        let (take, samples, length) = (self.take, self.samples.clone(), self.length);
        let origins = self.origins.iter().enumerate();
        let inside = origins.filter(move |(_, origin)| {
            let has_any = origin.start < samples.end && samples.start < origin.start + length;
            origin.take == take && has_any
        });
        inside.map(|(segment, _)| segment)
    }

    /// What a method made of the segments, given what it made of all.
    pub fn generated<'m>(
        &self,
        trajectories: &'m [Option<Trajectory>],
        plans: Option<&'m [Plan]>,
    ) -> Vec<GeneratedSegment<'m>> {
        let segment = |segment: usize| {
            let trajectory = trajectories[segment].as_ref();
            let plan = plans.map(|plans| &plans[segment]);
            (trajectory.is_some() || plan.is_some()).then_some(GeneratedSegment {
                start_sample: self.origins[segment].start,
                samples: self.length,
                trajectory,
                plan,
            })
        };
        self.places().filter_map(segment).collect()
    }

    /// Number of segments that start in the samples and are without a trajectory.
    pub fn without_trajectory(&self, trajectories: &[Option<Trajectory>]) -> usize {
        let starts = |segment: &usize| self.samples.contains(&self.origins[*segment].start);
        let segments = self.places().filter(starts);
        segments
            .filter(|&segment| trajectories[segment].is_none())
            .count()
    }

    /// Errors and contacts of a method at the samples, from its rows of all segments, sample after sample. `tau_m` is the
    /// distance up to which a fingertip touches.
    pub fn evaluated(&self, rows: &MethodRows, tau_m: f64) -> Vec<EvaluatedSample> {
        let instants = self.places().flat_map(|segment| {
            let (start, first) = (self.origins[segment].start, segment * self.length);
            (0..self.length).map(move |t| (start + t, first + t))
        });
        let is_known = |values: &PerFinger<f64>| values.as_array().iter().all(|v| v.is_finite());
        let contact = |row: usize| {
            let distance_m = rows.distance_m.as_ref()?[row];
            // None of an object that is missing at this instant.
            let distances = distance_m.as_array();
            let is_missing = distances.iter().any(|distance| distance.is_nan());
            (!is_missing).then(|| ContactSample::new(distance_m, tau_m))
        };
        (instants.filter(|&(sample, row)| {
            self.samples.contains(&sample) && is_known(&rows.error_m[row])
        }))
        .map(|(sample, row)| EvaluatedSample {
            sample,
            error_m: Some(rows.error_m[row]),
            contact: contact(row),
        })
        .collect()
    }
}

impl EvaluatedMethod {
    /// Adds samples of another part of the method as far as they show a channel that those so far do not: errors, contacts.
    pub fn add_kinds(&mut self, more: &Self) {
        let kinds: [fn(&EvaluatedSample) -> bool; 2] = [
            |sample| sample.error_m.is_some(),
            |sample| sample.contact.is_some(),
        ];
        for is_kind in kinds {
            if !self.samples.iter().any(is_kind) {
                self.samples
                    .extend(more.samples.iter().copied().find(is_kind));
            }
        }
    }
}
