//! Content of a take's file beside the take that views need.

use std::collections::BTreeMap;

use inhand_channels::{EvaluatedMethod, GeneratedSegment, Metadata, ReadMethod, UnsolvedPlan};
use inhand_model::{Clock, Configuration, Plan, PlanStatus, SegmentLayout, Shape, Trajectory};

use crate::error::SessionError;

/// What methods generated and how they were judged, and the object's shape.
#[derive(Default)]
pub(super) struct StoredParts {
    pub(super) generated: Vec<StoredMethod>,
    pub(super) evaluated: Vec<EvaluatedMethod>,
    pub(super) shape: Option<Shape>,
}

/// What one method generated.
pub(super) struct StoredMethod {
    pub(super) name: String,
    segments: Vec<StoredSegment>,
    /// Plans without motion and where it would start.
    unsolved: Vec<(usize, Plan)>,
}

/// A stored trajectory, or a piece of one, with its start.
struct StoredSegment {
    start_sample: usize,
    trajectory: Trajectory,
    plan: Option<Plan>,
}

impl StoredParts {
    pub(super) fn read(
        bytes: &[u8],
        name: &str,
        metadata: &Metadata,
        clock: Clock,
        wrong: impl Fn(inhand_channels::ChannelError) -> SessionError,
    ) -> Result<Self, SessionError> {
        let methods = inhand_channels::read_generated(bytes, name).map_err(&wrong)?;
        let methods = methods.into_iter();
        Ok(Self {
            generated: methods.map(|m| StoredMethod::of(m, clock)).collect(),
            evaluated: inhand_channels::read_evaluated(bytes, name).map_err(&wrong)?,
            shape: metadata.shape(name).map_err(&wrong)?,
        })
    }

    /// The motion of each method.
    pub(super) fn segments(&self) -> Vec<Vec<GeneratedSegment<'_>>> {
        let methods = self.generated.iter();
        methods
            .map(|method| {
                let segments = method.segments.iter();
                segments
                    .map(|stored| GeneratedSegment {
                        start_sample: stored.start_sample,
                        trajectory: &stored.trajectory,
                        plan: stored.plan.as_ref(),
                    })
                    .collect()
            })
            .collect()
    }

    /// The plans of each method that found no motion.
    pub(super) fn unsolved(&self) -> Vec<Vec<UnsolvedPlan<'_>>> {
        let methods = self.generated.iter();
        methods
            .map(|method| {
                let unsolved = method.unsolved.iter();
                unsolved
                    .map(|(start_sample, plan)| UnsolvedPlan {
                        start_sample: *start_sample,
                        // Views say where it would start; of the rest nothing is drawn.
                        samples: 0,
                        plan,
                    })
                    .collect()
            })
            .collect()
    }
}

impl StoredMethod {
    /// The trajectories of a method as far as files tell: unbroken motion, which ends where the motion of
    /// another plan starts.
    fn of(method: ReadMethod, clock: Clock) -> Self {
        let failed = |plan: &Plan| match plan.status {
            PlanStatus::Infeasible | PlanStatus::Failed => true,
            PlanStatus::Solved | PlanStatus::AlmostSolved => false,
        };
        let (unsolved, mut solved): (BTreeMap<_, _>, BTreeMap<_, _>) =
            (method.plans.into_iter()).partition(|(_, plan)| failed(plan));
        let mut pieces: Vec<(usize, Vec<Configuration>)> = Vec::new();
        for (&k, &configuration) in &method.configurations_m {
            match pieces.last_mut() {
                Some((start, values)) if *start + values.len() == k && !solved.contains_key(&k) => {
                    values.push(configuration);
                }
                _ => pieces.push((k, vec![configuration])),
            }
        }
        let segments = (pieces.into_iter())
            .filter_map(|(start_sample, values)| {
                let layout = SegmentLayout {
                    samples: values.len(),
                    rate_hz: clock.rate_hz(),
                    object: false,
                };
                Some(StoredSegment {
                    start_sample,
                    // The reader has seen to it that all numbers are there and finite.
                    trajectory: Trajectory::new(layout, values.concat()).ok()?,
                    plan: solved.remove(&start_sample),
                })
            })
            .collect();
        Self {
            name: method.name,
            segments,
            unsolved: unsolved.into_iter().collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use inhand_model::{SEGMENT_COORDINATES, StartTime};

    use super::*;

    #[test]
    fn motion_is_cut_at_gaps_and_nowhere_else() {
        let configurations = [3, 4, 5, 9, 10].map(|k| (k, [k as f64; SEGMENT_COORDINATES]));
        let method = ReadMethod {
            name: "line".to_owned(),
            configurations_m: configurations.into(),
            plans: BTreeMap::new(),
        };
        let clock = Clock::new(0, StartTime::Unknown, 50.0).unwrap();
        let stored = StoredMethod::of(method, clock);
        let pieces: Vec<_> = (stored.segments.iter())
            .map(|s| {
                (
                    s.start_sample,
                    s.trajectory.layout().samples,
                    s.trajectory.values_m()[0],
                )
            })
            .collect();
        assert_eq!(pieces, [(3, 3, 3.0), (9, 2, 9.0)]);
        assert!(stored.unsolved.is_empty());
    }
}
