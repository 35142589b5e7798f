//! Stored motion of a method as segments again.

use std::collections::BTreeMap;

use inhand_model::{Clock, Configuration, Plan, PlanStatus, SegmentLayout, Trajectory};

use super::ReadMethod;
use crate::take::GeneratedSegment;

/// What one method generated, in pieces that can be written or drawn.
#[derive(Clone, Debug)]
pub struct StoredMethod {
    /// Name of the method.
    pub name: String,
    /// Trajectories, or pieces of ones, with their starts.
    segments: Vec<(usize, Trajectory, Option<Plan>)>,
    /// Plans without motion and where it would start.
    unsolved: BTreeMap<usize, Plan>,
}

impl StoredMethod {
    /// The trajectories of a method as far as files tell: unbroken motion, which ends where the motion of
    /// another plan starts.
    pub fn new(method: ReadMethod, clock: Clock) -> Self {
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
        let segments = (pieces.into_iter()).filter_map(|(start_sample, values)| {
            let layout = SegmentLayout {
                samples: values.len(),
                rate_hz: clock.rate_hz(),
                object: false,
            };
            // The reader has seen to it that all numbers are there and finite.
            let trajectory = Trajectory::new(layout, values.concat()).ok()?;
            Some((start_sample, trajectory, solved.remove(&start_sample)))
        });
        Self {
            name: method.name,
            segments: segments.collect(),
            unsolved,
        }
    }

    /// The motion, and the plans that found none.
    pub fn segments(&self) -> Vec<GeneratedSegment<'_>> {
        let solved = self.segments.iter();
        let solved = solved.map(|(start_sample, trajectory, plan)| GeneratedSegment {
            start_sample: *start_sample,
            samples: trajectory.layout().samples,
            trajectory: Some(trajectory),
            plan: plan.as_ref(),
        });
        let unsolved = self.unsolved.iter();
        let unsolved = unsolved.map(|(&start_sample, plan)| GeneratedSegment {
            start_sample,
            // Views say where it would start; of the rest nothing is drawn.
            samples: 0,
            trajectory: None,
            plan: Some(plan),
        });
        solved.chain(unsolved).collect()
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
        let stored = StoredMethod::new(method, clock);
        let pieces: Vec<_> = (stored.segments.iter())
            .map(|(start, piece, _)| (*start, piece.layout().samples, piece.values_m()[0]))
            .collect();
        assert_eq!(pieces, [(3, 3, 3.0), (9, 2, 9.0)]);
        assert!(stored.unsolved.is_empty());
    }
}
