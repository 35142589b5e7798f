//! Trajectories and plans of each method, as they lie in a take's file.

use std::collections::BTreeMap;

use inhand_model::{
    Certificate, Clock, Configuration, ConstraintFamily, Hand, Object, Plan, PlanChecks, Pose,
    Relaxation, SEGMENT_COORDINATES,
};
use nalgebra::{DVector, Isometry3, Quaternion, UnitQuaternion};
use prost::Message;

use super::read_metadata;
use mcap::records::Record;

use crate::error::ChannelError;
use crate::messages;
use crate::records::{Depth, walk};

/// What one method generated for a take.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadMethod {
    /// Name of the method.
    pub name: String,
    /// Generated fingertip positions (hand frame, metres) by sample of the take. Where trajectories
    /// overlap, the one that starts last counts.
    pub configurations_m: BTreeMap<usize, Configuration>,
    /// Plans by the sample at which their trajectory starts, each without that trajectory, which
    /// `configurations_m` holds; empty for methods that solve nothing.
    pub plans: BTreeMap<usize, Plan>,
}

/// Reads what methods generated for a take, in the order of the file's channels.
///
/// # Errors
///
/// As for [`read_take`](crate::read_take).
pub fn read_generated(bytes: &[u8], file_name: &str) -> Result<Vec<ReadMethod>, ChannelError> {
    let metadata = read_metadata(bytes, file_name)?;
    let Some(facts) = metadata.used_recording(file_name)? else {
        return Err(super::no_recording(bytes, file_name));
    };
    let mut methods: Vec<ReadMethod> = Vec::new();
    let mut channels: BTreeMap<u16, (usize, Part, String)> = BTreeMap::new();
    walk(file_name, bytes, Depth::Everything, |record| match record {
        Record::Channel(channel) => {
            if let Some((name, part)) = method_of(&channel.topic) {
                let index = index_of(&mut methods, name);
                channels.insert(channel.id, (index, part, channel.topic));
            }
            Ok(())
        }
        Record::Message { header, data } => {
            let Some((index, part, topic)) = channels.get(&header.channel_id) else {
                return Ok(());
            };
            let at = Place {
                file: file_name,
                topic,
                clock: facts.clock,
                log_time: header.log_time,
            };
            match part {
                Part::Fingertips => at.configuration(&data, &mut methods[*index]),
                Part::Plan => at.plan(&data, &mut methods[*index]),
            }
        }
        _ => Ok(()),
    })?;
    Ok(methods)
}

#[derive(Clone, Copy)]
enum Part {
    Fingertips,
    Plan,
}

/// Name and part of a topic of a method: `/generated/<name>/fingertips` or `.../plan`.
fn method_of(topic: &str) -> Option<(&str, Part)> {
    let (name, part) = topic.strip_prefix("/generated/")?.split_once('/')?;
    match part {
        "fingertips" => Some((name, Part::Fingertips)),
        "plan" => Some((name, Part::Plan)),
        _ => None,
    }
}

fn index_of(methods: &mut Vec<ReadMethod>, name: &str) -> usize {
    let place = methods.iter().position(|method| method.name == name);
    place.unwrap_or_else(|| {
        methods.push(ReadMethod {
            name: name.to_owned(),
            configurations_m: BTreeMap::new(),
            plans: BTreeMap::new(),
        });
        methods.len() - 1
    })
}

/// The message at hand and what it has to agree with.
struct Place<'a> {
    file: &'a str,
    topic: &'a str,
    clock: Clock,
    log_time: u64,
}

impl Place<'_> {
    fn error(&self, expected: &str, found: impl std::fmt::Display) -> ChannelError {
        ChannelError::Message {
            file: self.file.to_owned(),
            topic: self.topic.to_owned(),
            message: self.sample(),
            expected: expected.to_owned(),
            found: found.to_string(),
        }
    }

    fn sample(&self) -> usize {
        let since_start = self.log_time.saturating_sub(self.clock.start_unix_nanos());
        self.clock.nearest_sample(since_start as f64 / 1e9)
    }

    fn decode<M: Message + Default>(&self, data: &[u8]) -> Result<M, ChannelError> {
        M::decode(data).map_err(|error| self.error("protobuf", error))
    }

    fn configuration(&self, data: &[u8], method: &mut ReadMethod) -> Result<(), ChannelError> {
        if self.clock.unix_nanos(self.sample()) != self.log_time {
            return Err(self.error("the time of a sample", format!("{} ns", self.log_time)));
        }
        let message: messages::Fingertips = self.decode(data)?;
        let tips = message.tips().into_array();
        let mut configuration = [0.0; SEGMENT_COORDINATES];
        for (tip, place) in tips.into_iter().zip(configuration.chunks_exact_mut(3)) {
            let position = tip.and_then(|tip| tip.position_m);
            let position = position.ok_or_else(|| self.error("five positions", "fewer"))?;
            place.copy_from_slice(&position.to_array());
        }
        if !configuration
            .iter()
            .all(|coordinate| coordinate.is_finite())
        {
            return Err(self.error("finite coordinates", format!("{configuration:?}")));
        }
        method.configurations_m.insert(self.sample(), configuration);
        Ok(())
    }

    fn plan(&self, data: &[u8], method: &mut ReadMethod) -> Result<(), ChannelError> {
        let message: messages::Plan = self.decode(data)?;
        let status = messages::PlanStatus::to_model(message.status)
            .ok_or_else(|| self.error("a status of a plan", message.status))?;
        let plan = Plan {
            status,
            trajectory: None,
            activations_m: DVector::from_vec(message.activations_m.clone()),
            objective: message.objective,
            certificate: Certificate {
                stationarity: message.stationarity,
                primal: message.primal,
                dual: message.dual,
                complementarity: message.complementarity,
            },
            object: self.object(&message.hand_from_object)?,
            checks: self.checks(&message)?,
            relaxations: (message.relaxations.iter())
                .map(|relaxation| {
                    Ok(Relaxation {
                        family: self.family(relaxation.family)?,
                        by: relaxation.by,
                        joint: relaxation.joint,
                    })
                })
                .collect::<Result<_, ChannelError>>()?,
            rounds: message.rounds as usize,
            iterations: message.iterations as usize,
        };
        method.plans.insert(message.start_sample as usize, plan);
        Ok(())
    }

    fn checks(&self, message: &messages::Plan) -> Result<PlanChecks, ChannelError> {
        let mut checks = PlanChecks {
            rows: message.rows as usize,
            rows_taken_up: message.rows_taken_up as usize,
            hull_distance_m: message.hull_distance_m,
            ..PlanChecks::default()
        };
        for check in &message.families {
            let family = self.family(check.family)?;
            checks.active[family] = check.active as usize;
            checks.violation[family] = check.violation;
        }
        // Files from before families were listed have these two alone.
        if message.families.is_empty() {
            checks.active[ConstraintFamily::Velocity] = message.active_velocity_bounds as usize;
            checks.active[ConstraintFamily::Activations] =
                message.active_activation_bounds as usize;
        }
        Ok(checks)
    }

    fn family(&self, value: i32) -> Result<ConstraintFamily, ChannelError> {
        messages::ConstraintFamily::to_model(value)
            .ok_or_else(|| self.error("a family of constraints", value))
    }

    fn object(
        &self,
        poses: &[messages::PlannedPose],
    ) -> Result<Vec<Pose<Hand, Object>>, ChannelError> {
        let pose = |pose: &messages::PlannedPose| {
            let position = pose.position_m?.to_array();
            let q = pose.orientation?;
            // Written from a unit quaternion; normalising again would change its last digits.
            let turn = Quaternion::new(q.w, q.x, q.y, q.z);
            let unit = (turn.norm() - 1.0).abs() < 1e-9;
            (unit && position.iter().all(|v| v.is_finite())).then(|| {
                Pose::new(Isometry3::from_parts(
                    position.into(),
                    UnitQuaternion::new_unchecked(turn),
                ))
            })
        };
        (poses.iter())
            .map(|message| {
                pose(message).ok_or_else(|| {
                    self.error("a position and a unit quaternion", format!("{message:?}"))
                })
            })
            .collect()
    }
}
