//! One motion from a start to a goal, over points on the way.

use std::path::Path;
use std::time::{Duration, Instant};

use inhand_channels::{GeneratedMethod, GeneratedSegment, TakeFile, Views};
use inhand_contact::hull_distance_m;
use inhand_model::{
    Clock, Dictionary, Finger, Hull, ObjectEnds, PerFinger, Plan, Protocol, Provenance, Recording,
    SEGMENT_COORDINATES, SegmentLayout, StartTime, Trajectory,
};
use inhand_planner::{Holding, Knot, Target, Tips, plan_chain};

use crate::error::{SessionError, invalid};
use crate::hand_state::HandState;
use crate::methods::Method;
use crate::settings::Settings;
use crate::steps::{hold_settings, plan_error, planner};
use crate::take_file::write_parts;

/// What to plan.
#[derive(Clone, Debug)]
pub struct PlanRequest {
    /// By which method; a learned one.
    pub method: Method,
    /// Where motion starts.
    pub start: HandState,
    /// Where it ends.
    pub goal: HandState,
    /// What it passes, with times in seconds since the start.
    pub via: Vec<(f64, HandState)>,
    /// How long it takes, seconds; a segment of the dictionary where it is not given.
    pub duration_s: Option<f64>,
    /// Fingers that have to reach what is given; the others follow.
    pub fingers: Vec<Finger>,
}

/// What came out.
#[derive(Clone, Debug)]
pub struct Planned {
    /// The method.
    pub method: Method,
    /// Shape of one segment.
    pub layout: SegmentLayout,
    /// Plan of each segment; one without a trajectory is the last.
    pub plans: Vec<Plan>,
    /// The whole motion; `None` where a segment has none.
    pub trajectory: Option<Trajectory>,
    /// Time for all plans; that of preparing the dictionary for targets that give the same parts is
    /// in it for a single motion.
    pub time: Duration,
    /// The target positions and how the motion meets them; empty without a motion.
    pub targets: Vec<MetTarget>,
}

impl Planned {
    /// The whole motion, to be written into a file.
    pub(crate) fn motion(&self, path: &Path) -> Result<&Trajectory, SessionError> {
        let motion = self.trajectory.as_ref();
        motion.ok_or_else(|| SessionError::usage(path, "the plan has no motion to write"))
    }
}

/// A target position of a finger, and how a motion meets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetTarget {
    /// Time since the start of the motion, seconds.
    pub time_s: f64,
    /// Finger.
    pub finger: Finger,
    /// Distance of the motion from it, metres.
    pub miss_m: f64,
    /// Signed distance of it to the finger's training hull, metres: negative inside.
    pub hull_distance_m: f64,
}

/// Plans a motion: a single segment where it lasts as long as one, else a chain of segments with
/// continuous position and velocity.
///
/// # Errors
///
/// [`SessionError::At`] for targets that cannot be used, [`SessionError::Settings`] for a method
/// that learns nothing or that the dictionary has nothing for.
pub fn plan_motion(
    dictionary: &Dictionary,
    request: &PlanRequest,
    settings: &Settings,
) -> Result<Planned, SessionError> {
    let method = request.method;
    let planner = planner(method, dictionary, Protocol::Published, settings)?.ok_or_else(|| {
        invalid(
            "plan.methods",
            "residual, prior or paper, to plan with",
            &method,
        )
    })?;
    let layout = planner.layout();
    let hulls = &dictionary.demonstrated.hulls;
    let segment_s = layout.duration_s();
    let duration_s = request.duration_s.unwrap_or(segment_s);
    let error = |source| plan_error(method, source);
    if !(duration_s.is_finite() && duration_s > 0.0) {
        return Err(invalid(
            "duration",
            "a positive number of seconds",
            &duration_s,
        ));
    }
    let single = (duration_s - segment_s).abs() * layout.rate_hz < 0.5;
    check_objects(request, !single, layout)?;
    if single {
        let target = target(request, layout, settings)?;
        let begin = Instant::now();
        let plan = planner.plan(&target).map_err(error)?;
        return Ok(Planned {
            method,
            layout,
            time: begin.elapsed(),
            targets: met_targets(request, duration_s, plan.trajectory.as_ref(), hulls),
            trajectory: plan.trajectory.clone(),
            plans: vec![plan],
        });
    }
    if settings.plan.holding {
        let expected = format!("false for motion of more than a segment ({segment_s} s)");
        return Err(invalid("plan.holding", &expected, &true));
    }
    let mut knots = vec![knot(0.0, &request.start)];
    knots.extend(request.via.iter().map(|(time_s, state)| Knot {
        velocity: Tips(via_velocity(state)),
        ..knot(*time_s, state)
    }));
    knots.push(knot(duration_s, &request.goal));
    for knot in &mut knots {
        knot.tips = only(knot.tips, &request.fingers);
        knot.velocity = only(knot.velocity, &request.fingers);
    }
    let begin = Instant::now();
    let chain = plan_chain(&planner, &knots).map_err(error)?;
    Ok(Planned {
        method,
        layout,
        time: begin.elapsed(),
        targets: met_targets(request, duration_s, chain.trajectory.as_ref(), hulls),
        plans: chain.plans,
        trajectory: chain.trajectory,
    })
}

/// Start, goal and what lies between, against the motion and the training hulls.
fn met_targets(
    request: &PlanRequest,
    duration_s: f64,
    trajectory: Option<&Trajectory>,
    hulls: &PerFinger<Hull>,
) -> Vec<MetTarget> {
    let Some(trajectory) = trajectory else {
        return Vec::new();
    };
    let layout = trajectory.layout();
    let given = [(0.0, &request.start), (duration_s, &request.goal)];
    let via = request.via.iter().map(|(time_s, state)| (*time_s, state));
    let met = (given.into_iter().chain(via)).flat_map(|(time_s, state)| {
        let sample = ((time_s * layout.rate_hz).round() as usize).min(layout.samples - 1);
        request.fingers.iter().filter_map(move |&finger| {
            let wanted = state.fingertips_m[finger]?;
            Some(MetTarget {
                time_s,
                finger,
                miss_m: (trajectory.position(sample, finger)).distance_m(wanted.into()),
                hull_distance_m: hull_distance_m(&hulls[finger], wanted),
            })
        })
    });
    met.collect()
}

/// Objects can be given only where there is a place for them; those of takes are a bonus.
fn check_objects(
    request: &PlanRequest,
    chain: bool,
    layout: SegmentLayout,
) -> Result<(), SessionError> {
    let states = [
        ("start", &request.start, true),
        ("goal", &request.goal, true),
    ];
    let via = request
        .via
        .iter()
        .map(|(_, state)| ("point on the way", state, false));
    for (what, state, end) in states.into_iter().chain(via) {
        let usable = layout.object && !chain && end;
        if state.object.is_some() && state.sample.is_none() && !usable {
            let reason = match (chain, end) {
                (_, false) => "the object at start and goal only",
                (true, _) => "no object in motion of another length than a segment",
                _ => "no object: the dictionary was learned without it",
            };
            return Err(SessionError::data(
                &state.path,
                format!("expected {reason}, found the object at the {what}"),
            ));
        }
    }
    Ok(())
}

fn knot(time_s: f64, state: &HandState) -> Knot {
    Knot {
        time_s,
        tips: Tips(state.fingertips_m),
        velocity: Tips(state.velocity_m_s),
    }
}

/// Velocity at a point on the way: as a file gives it. That of a take is an average over the
/// samples after it, too coarse to be passed with exactly.
fn via_velocity(state: &HandState) -> PerFinger<Option<[f64; 3]>> {
    match state.sample {
        None => state.velocity_m_s,
        Some(_) => PerFinger::default(),
    }
}

fn only(mut tips: Tips, fingers: &[Finger]) -> Tips {
    for finger in Finger::ALL {
        if !fingers.contains(&finger) {
            tips.0[finger] = None;
        }
    }
    tips
}

fn target(
    request: &PlanRequest,
    layout: SegmentLayout,
    settings: &Settings,
) -> Result<Target, SessionError> {
    let (start, goal) = (&request.start, &request.goal);
    let mut target = Target::new()
        .first(start.fingertips_m)
        .first_velocity(start.velocity_m_s)
        .last(goal.fingertips_m)
        .last_velocity(goal.velocity_m_s);
    for (time_s, state) in &request.via {
        target = target
            .waypoint(*time_s, state.fingertips_m)
            .velocity_at(*time_s, via_velocity(state));
    }
    // Segments without the object have no place for it.
    if layout.object {
        if let Some(first) = start.object {
            target = target.object_first(first);
        }
        if let Some(last) = goal.object {
            target = target.object_last(last);
        }
    }
    target = target.only(&request.fingers);
    if let Some(hold) = hold_settings(settings)? {
        target = target.holding(holding(request, layout, &hold)?);
    }
    Ok(target)
}

fn holding(
    request: &PlanRequest,
    layout: SegmentLayout,
    hold: &inhand_planner::Hold,
) -> Result<Holding, SessionError> {
    let known = |state: &HandState| {
        let mut configuration = [0.0; SEGMENT_COORDINATES];
        for (finger, tip) in state.fingertips_m.iter() {
            let row = SegmentLayout::row(0, finger, 0);
            configuration[row..row + 3].copy_from_slice(tip.as_ref()?);
        }
        Some((configuration, state.object?))
    };
    let missing = |state: &HandState, what: &str| {
        SessionError::data(
            format!("{what} ({})", state.source.name),
            "expected all five fingertips and the object, for fingers to hold it, found fewer",
        )
    };
    let (first_m, first) = known(&request.start).ok_or_else(|| missing(&request.start, "start"))?;
    let (last_m, last) = known(&request.goal).ok_or_else(|| missing(&request.goal, "goal"))?;
    hold.holding(
        &first_m,
        &last_m,
        &ObjectEnds { first, last },
        layout.samples,
    )
    .map_err(|source| plan_error(request.method, source))
}

/// Writes a planned motion as a file of its own: generated channels and what viewers draw. Its time
/// starts at the epoch, as it was never recorded.
///
/// # Errors
///
/// [`SessionError::At`], [`SessionError::Io`]; [`SessionError::Usage`] for a plan without
/// a motion.
pub fn write_plan(
    path: &Path,
    planned: &Planned,
    settings: &Settings,
    made: &[Provenance],
    views: Views,
) -> Result<(), SessionError> {
    let whole = planned.motion(path)?;
    let samples = whole.layout().samples;
    let parts = parts(whole, planned);
    let segments: Vec<_> = (parts.iter().zip(&planned.plans))
        .map(|((start_sample, trajectory), plan)| GeneratedSegment {
            start_sample: *start_sample,
            samples: trajectory.layout().samples,
            trajectory: Some(trajectory),
            plan: Some(plan),
        })
        .collect();
    let generated = [GeneratedMethod {
        name: planned.method.name(),
        plans: true,
        segments: &segments,
    }];
    let recording = empty_recording(whole.layout().rate_hz, samples);
    let file = TakeFile {
        generated: &generated,
        object_shape: settings.shape()?,
        provenance: made,
        ..TakeFile::new(&recording)
    };
    write_parts(path, &file, views)
}

/// The pieces of a motion by segment, with the sample at which each starts.
fn parts(whole: &Trajectory, planned: &Planned) -> Vec<(usize, Trajectory)> {
    let steps = planned.layout.samples - 1;
    let last = whole.layout().samples - 1;
    (0..planned.plans.len())
        .map(|segment| {
            // A joint belongs to the segment before.
            let first = if segment == 0 { 0 } else { segment * steps + 1 };
            let end = ((segment + 1) * steps).min(last) + 1;
            (first, whole.slice(first..end))
        })
        .collect()
}

fn empty_recording(rate_hz: f64, samples: usize) -> Recording {
    let clock =
        Clock::new(0, StartTime::Unknown, rate_hz).expect("dictionaries have a positive rate");
    Recording::empty("plan", "inhand plan", clock, samples)
}
