//! A trajectory for every segment, from a dictionary.

use std::sync::Arc;
use std::time::Duration;

use inhand_contact::FingerOffsets;
use inhand_model::{
    Calibration, Configuration, Dictionary, EndConditions, Finger, ObjectEnds, PerFinger, Plan,
    Protocol, Residual, SEGMENT_COORDINATES, SegmentLayout, Segments, Shape, Trajectory,
    VelocityBounds,
};
use inhand_planner::{
    AccelerationBounds, Constraints, Ends, Holding, PlanError, Planner, PlannerSettings, Target,
    held_fingers, object_between, plan_all, widened,
};

use crate::error::{SessionError, invalid};
use crate::methods::Method;
use crate::settings::{EndsKind, Settings};

/// What one method made of every test segment.
#[derive(Clone, Debug)]
pub struct Generated {
    /// The method.
    pub method: Method,
    /// A trajectory for each segment; `None` where planning failed.
    pub trajectories: Vec<Option<Trajectory>>,
    /// A plan for each segment, of learned methods.
    pub plans: Option<Vec<Plan>>,
    /// Time of each plan, of learned methods.
    pub plan_times: Vec<Duration>,
    /// How far the recorded motion lies from the planned one by the method's own measure.
    pub corridors: Option<SegmentCorridors>,
}

/// Recorded motion against a method's prediction regions.
#[derive(Clone, Debug)]
pub struct SegmentCorridors {
    /// Mahalanobis distance at each instant of each segment; `None` where the plan failed.
    pub mahalanobis: Vec<Option<Vec<PerFinger<f64>>>>,
    /// Widths of the prediction regions.
    pub widths: Vec<Calibration>,
}

/// Generates a trajectory for every segment, under the protocol of the segments.
///
/// # Errors
///
/// [`SessionError::At`] for settings or a dictionary that cannot be used;
/// [`SessionError::Settings`] for a method that the dictionary has nothing for. A plan that is
/// infeasible is data, not an error.
pub fn generate(
    method: Method,
    dictionary: &Dictionary,
    segments: &Segments,
    settings: &Settings,
) -> Result<Generated, SessionError> {
    let protocol = segments.protocol();
    let Some(planner) = planner(method, dictionary, protocol, settings)? else {
        let layout = segments.layout();
        let curves = segments
            .ends()
            .iter()
            .map(|ends| method.curve(ends, layout));
        return Ok(Generated {
            method,
            trajectories: curves.collect(),
            plans: None,
            plan_times: Vec::new(),
            corridors: None,
        });
    };
    check_layout(dictionary.layout, segments.layout())?;
    let hold = hold_settings(settings)?;
    let targets = (segments.ends().iter())
        .map(|ends| target(&planner, ends, hold.as_ref()))
        .collect::<Result<Vec<_>, _>>()
        .map_err(|source| plan_error(method, source))?;
    let (mut plans, mut plan_times) = (Vec::new(), Vec::new());
    for (plan, time) in plan_all(&planner, &targets) {
        plans.push(plan.map_err(|source| plan_error(method, source))?);
        plan_times.push(time);
    }
    let corridors = match (method, dictionary.residual(protocol)) {
        (Method::Residual, Some(residual)) => Some(
            corridors(&planner, residual, &targets, &plans, segments)
                .map_err(|source| plan_error(method, source))?,
        ),
        _ => None,
    };
    Ok(Generated {
        method,
        trajectories: plans.iter().map(|plan| plan.trajectory.clone()).collect(),
        plans: Some(plans),
        plan_times,
        corridors,
    })
}

/// A dictionary plans at its own rate and length.
fn check_layout(dictionary: SegmentLayout, segments: SegmentLayout) -> Result<(), SessionError> {
    let same = dictionary.samples == segments.samples && dictionary.rate_hz == segments.rate_hz;
    if same {
        return Ok(());
    }
    let of = |layout: SegmentLayout| format!("{} samples at {} Hz", layout.samples, layout.rate_hz);
    Err(SessionError::data(
        "the dictionary",
        format!(
            "expected segments of {}, as the takes have, found {}; learn one from takes of this rate",
            of(segments),
            of(dictionary)
        ),
    ))
}

/// The planner of a learned method under a protocol; `None` for one that learns nothing.
pub(crate) fn planner(
    method: Method,
    dictionary: &Dictionary,
    protocol: Protocol,
    settings: &Settings,
) -> Result<Option<Planner>, SessionError> {
    let planner_settings = plan_settings(dictionary, settings);
    let planner = match method {
        Method::Prior => Planner::new(dictionary, inhand_planner::Method::Prior, &planner_settings),
        Method::Paper => Planner::new(dictionary, inhand_planner::Method::Paper, &planner_settings),
        Method::Residual => {
            let residual = dictionary.residual(protocol).ok_or_else(|| {
                let expected = "a method that the dictionary has something for (learn it anew for \
                                deviations from the smooth curve)";
                invalid("plan.methods", expected, &method)
            })?;
            Planner::residual(residual, &planner_settings)
        }
        Method::Auto => {
            let expected = "a method by name: `auto` is settled when a dictionary is learned";
            return Err(invalid("plan.methods", expected, &method));
        }
        Method::Hold | Method::Line | Method::MinimumJerk | Method::Hermite => return Ok(None),
    };
    planner
        .map(Some)
        .map_err(|source| plan_error(method, source))
}

pub(crate) fn plan_error(method: Method, source: PlanError) -> SessionError {
    SessionError::at(format_args!("planning with {method}"), source)
}

/// What fingers that hold need to be known by.
pub(crate) struct Hold {
    shape: Shape,
    offsets: FingerOffsets,
    tau_m: f64,
}

impl Hold {
    /// The fingers in contact at both ends, held to their contact points.
    pub(crate) fn holding(
        &self,
        first_m: &Configuration,
        last_m: &Configuration,
        object: &ObjectEnds,
        samples: usize,
    ) -> Result<Holding, PlanError> {
        Ok(Holding {
            hand_from_object: object_between(object, samples),
            contacts: held_fingers(
                &self.shape,
                &self.offsets,
                self.tau_m,
                first_m,
                last_m,
                object,
            )?,
            tau_m: self.tau_m,
        })
    }
}

/// `None` where fingers need not hold.
pub(crate) fn hold_settings(settings: &Settings) -> Result<Option<Hold>, SessionError> {
    if !settings.plan.holding {
        return Ok(None);
    }
    let shape = settings.shape()?.ok_or_else(|| {
        let expected = "a shape such as cube:0.05, for fingers to hold (plan.holding)";
        invalid("object.shape", expected, &"none")
    })?;
    Ok(Some(Hold {
        shape,
        offsets: FingerOffsets(settings.pad_offsets_m()?),
        tau_m: settings.evaluate.tau_mm / 1000.0,
    }))
}

/// What a method is given of a segment. Fingers hold where three or more are in contact at both
/// ends; elsewhere there is nothing to hold on to. A method that does not know the start must not
/// learn of it from what fingers hold.
fn target(
    planner: &Planner,
    ends: &EndConditions,
    hold: Option<&Hold>,
) -> Result<Target, PlanError> {
    let target = match planner.method() {
        Some(method) => method.target(ends),
        None => Target::from(ends),
    };
    let knows_start = planner.method() != Some(inhand_planner::Method::Paper);
    let (Some(hold), Some(object), true) = (hold, ends.object, knows_start) else {
        return Ok(target);
    };
    let samples = planner.layout().samples;
    match hold.holding(&ends.first_m, &ends.last_m, &object, samples) {
        Ok(holding) => Ok(target.holding(holding)),
        Err(PlanError::TooFewHold { .. }) => Ok(target),
        Err(error) => Err(error),
    }
}

/// Recorded motion against the prediction regions of plans that an earlier step made.
///
/// # Errors
///
/// As [`generate`].
pub(crate) fn corridors_of(
    method: Method,
    dictionary: &Dictionary,
    segments: &Segments,
    plans: &[Plan],
    settings: &Settings,
) -> Result<Option<SegmentCorridors>, SessionError> {
    let protocol = segments.protocol();
    let (Method::Residual, Some(residual)) = (method, dictionary.residual(protocol)) else {
        return Ok(None);
    };
    let Some(planner) = planner(method, dictionary, protocol, settings)? else {
        return Ok(None);
    };
    let targets: Vec<_> = segments.ends().iter().map(Target::from).collect();
    corridors(&planner, residual, &targets, plans, segments)
        .map(Some)
        .map_err(|source| plan_error(method, source))
}

fn corridors(
    planner: &Planner,
    residual: &Residual,
    targets: &[Target],
    plans: &[Plan],
    segments: &Segments,
) -> Result<SegmentCorridors, PlanError> {
    let mahalanobis = inhand_parallel::try_up_to(plans.len(), |segment| -> Result<_, PlanError> {
        let Some(trajectory) = &plans[segment].trajectory else {
            return Ok(None);
        };
        let corridor = planner.corridor(&targets[segment])?;
        let distances = (0..segments.layout().samples)
            .map(|t| {
                PerFinger::from_fn(|finger: Finger| {
                    let recorded = segments.position(segment, t, finger);
                    corridor.mahalanobis(trajectory, t, finger, recorded)
                })
            })
            .collect();
        Ok(Some(distances))
    })?;
    Ok(SegmentCorridors {
        mahalanobis,
        widths: residual.calibration.clone(),
    })
}

/// Velocity bounds of plans, m/s: as the settings give them, else what the training takes showed,
/// widened; without bounds, what the evaluation compares with.
pub(crate) fn velocity_bounds(dictionary: &Dictionary, settings: &Settings) -> VelocityBounds {
    match settings.plan.velocity_m_s {
        Some(bound) => VelocityBounds {
            min_m_s: [-bound; SEGMENT_COORDINATES],
            max_m_s: [bound; SEGMENT_COORDINATES],
        },
        None => {
            let factor = match settings.plan.velocity_factor {
                0.0 => PlannerSettings::VELOCITY_FACTOR,
                factor => factor,
            };
            widened(&dictionary.demonstrated.velocity, factor)
        }
    }
}

/// The planner's settings.
pub fn plan_settings(dictionary: &Dictionary, settings: &Settings) -> PlannerSettings {
    let section = &settings.plan;
    let velocity = velocity_bounds(dictionary, settings);
    let bounded = section.velocity_m_s.is_some() || section.velocity_factor > 0.0;
    PlannerSettings {
        ends: match section.ends {
            EndsKind::Hard => Ends::Hard,
            EndsKind::Soft => Ends::Soft {
                sigma_m: section.sigma_mm / 1000.0,
            },
        },
        object_sigma_m: section.object_sigma_mm / 1000.0,
        object_sigma_rad: section.object_sigma_deg.to_radians(),
        ridge: section.ridge,
        constraints: Constraints {
            velocity: bounded.then_some(velocity),
            acceleration: section.acceleration_m_s2.map(|bound| AccelerationBounds {
                min_m_s2: [-bound; SEGMENT_COORDINATES],
                max_m_s2: [bound; SEGMENT_COORDINATES],
            }),
            reachability_margin_m: (section.reachability)
                .then_some(section.reachability_margin_mm / 1000.0),
            separation_m: section.separation_mm.map(|mm| mm / 1000.0),
        },
        hulls: Some(Arc::new(dictionary.demonstrated.hulls.clone())),
        ..PlannerSettings::new(velocity)
    }
}
