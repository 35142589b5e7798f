//! A trajectory for every segment, from a dictionary.

use std::sync::Arc;
use std::time::Duration;

use inhand_contact::FingerOffsets;
use inhand_model::{
    Calibration, Dictionary, PerFinger, Plan, Protocol, SEGMENT_COORDINATES, SegmentLayout,
    Segments, Trajectory, VelocityBounds,
};
use inhand_planner::{
    AccelerationBounds, Constraints, Ends, Hold, PlanError, Planner, PlannerSettings, plan_all,
    widened,
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

impl Generated {
    /// Nothing yet.
    pub(crate) fn new(method: Method) -> Self {
        Self {
            method,
            trajectories: Vec::new(),
            plans: None,
            plan_times: Vec::new(),
            corridors: None,
        }
    }
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
    let generator = Generator::new(method, dictionary, segments.protocol(), settings)?;
    let mut generated = generator.generate(segments)?;
    if let Some(plans) = &generated.plans {
        generated.corridors = generator.corridors(segments, plans)?;
    }
    Ok(generated)
}

/// A method that is ready to generate trajectories under a protocol.
#[derive(Debug)]
pub struct Generator<'d> {
    /// The method.
    pub method: Method,
    dictionary: &'d Dictionary,
    protocol: Protocol,
    /// `None` for a method that learns nothing.
    planner: Option<Planner>,
    hold: Option<Hold>,
}

impl<'d> Generator<'d> {
    /// Prepares a method.
    ///
    /// # Errors
    ///
    /// As [`generate`].
    pub fn new(
        method: Method,
        dictionary: &'d Dictionary,
        protocol: Protocol,
        settings: &Settings,
    ) -> Result<Self, SessionError> {
        let planner = planner(method, dictionary, protocol, settings)?;
        let hold = planner
            .is_some()
            .then(|| hold_settings(settings))
            .transpose()?;
        Ok(Self {
            method,
            dictionary,
            protocol,
            planner,
            hold: hold.flatten(),
        })
    }

    /// Whether trajectories are planned, and so have plans.
    pub fn plans(&self) -> bool {
        self.planner.is_some()
    }

    /// Generates a trajectory for each of these segments; their recorded motion is not looked at.
    ///
    /// # Errors
    ///
    /// As [`generate`].
    pub fn generate(&self, segments: &Segments) -> Result<Generated, SessionError> {
        let (method, layout) = (self.method, segments.layout());
        let mut generated = Generated::new(method);
        let Some(planner) = &self.planner else {
            let curves = segments
                .ends()
                .iter()
                .map(|ends| method.curve(ends, layout));
            generated.trajectories = curves.collect();
            return Ok(generated);
        };
        check_layout(self.dictionary.layout, layout)?;
        let targets = (segments.ends().iter())
            .map(|ends| planner.target(ends, self.hold.as_ref()))
            .collect::<Result<Vec<_>, _>>()
            .map_err(|source| plan_error(method, source))?;
        let mut plans = Vec::with_capacity(targets.len());
        for (plan, time) in plan_all(planner, &targets) {
            plans.push(plan.map_err(|source| plan_error(method, source))?);
            generated.plan_times.push(time);
        }
        generated.trajectories = plans.iter().map(|plan| plan.trajectory.clone()).collect();
        generated.plans = Some(plans);
        Ok(generated)
    }

    /// Recorded motion against the prediction regions of its plans, of a method that states any.
    ///
    /// # Errors
    ///
    /// As [`generate`].
    pub(crate) fn corridors(
        &self,
        segments: &Segments,
        plans: &[Plan],
    ) -> Result<Option<SegmentCorridors>, SessionError> {
        let residual = self.dictionary.residual(self.protocol);
        let (Method::Residual, Some(residual), Some(planner)) =
            (self.method, residual, &self.planner)
        else {
            return Ok(None);
        };
        let of_segment = |segment: usize| -> Result<_, PlanError> {
            let Some(trajectory) = &plans[segment].trajectory else {
                return Ok(None);
            };
            planner.distances(trajectory, segments, segment).map(Some)
        };
        let mahalanobis = inhand_parallel::try_up_to(plans.len(), of_segment);
        Ok(Some(SegmentCorridors {
            mahalanobis: mahalanobis.map_err(|source| plan_error(self.method, source))?,
            widths: residual.calibration.clone(),
        }))
    }
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
