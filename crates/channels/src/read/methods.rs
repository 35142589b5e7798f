//! Trajectories and plans of each method, and how they compare with the recorded motion.

use std::collections::BTreeMap;
use std::io::Cursor;

use inhand_container::{Depth, Record, Source, walk_source};
use inhand_model::{
    Certificate, Configuration, ConstraintFamily, Plan, PlanChecks, Pose, Protocol, Relaxation,
    SEGMENT_COORDINATES, SegmentLayout, Trajectory,
};
use nalgebra::DVector;
use prost::Message;

use super::tracks::{Entry, FromEntry, Place};
use super::{metadata_of_source, no_recording};
use crate::error::ChannelError;
use crate::messages;
use crate::take::{EvaluatedMethod, EvaluatedSample};
use crate::topic;

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

/// Reads what methods generated for a take under a protocol, in the order of the file's channels.
///
/// # Errors
///
/// As for [`read_take`](crate::read_take).
pub fn read_generated(
    bytes: &[u8],
    file_name: &str,
    protocol: Protocol,
) -> Result<Vec<ReadMethod>, ChannelError> {
    generated_of_source(&mut Source::open(file_name, Cursor::new(bytes))?, protocol)
}

/// As [`read_generated`] for a file of any size.
///
/// # Errors
///
/// As for [`read_generated`].
pub fn generated_of_source(
    source: &mut Source<'_>,
    protocol: Protocol,
) -> Result<Vec<ReadMethod>, ChannelError> {
    type Parts = (BTreeMap<usize, Configuration>, BTreeMap<usize, Plan>);
    let parts = ["fingertips", "plan"];
    let read = |(configurations_m, plans): &mut Parts, part: &str, at: Place<'_>, data: &[u8]| {
        if part == "plan" {
            let message = at.decoded(messages::Plan::decode(data))?;
            plans.insert(message.start_sample as usize, plan(&message, &at)?);
        } else {
            configurations_m.insert(sample(&at)?, configuration(data, &at)?);
        }
        Ok(())
    };
    let prefix = format!("{}/", topic::generated(protocol));
    let methods = read_methods(source, &prefix, parts, read)?;
    let method = |(name, (configurations_m, plans))| ReadMethod {
        name,
        configurations_m,
        plans,
    };
    Ok(methods.into_iter().map(method).collect())
}

/// What one method generated for segments of a take.
#[derive(Clone, Debug)]
pub struct ReadSegments {
    /// Name of the method.
    pub name: String,
    /// The motion over each segment; `None` where a sample of it has none. Where trajectories overlap, the one that
    /// starts last counts.
    pub trajectories: Vec<Option<Trajectory>>,
    /// The plan that starts with each segment, without its trajectory.
    pub plans: Vec<Option<Plan>>,
}

/// Reads what methods generated for segments of a take under a protocol, in the order of the file's channels. `starts` are
/// the first samples of the segments, ascending.
///
/// # Errors
///
/// As for [`read_generated`].
pub fn segments_of_source(
    source: &mut Source<'_>,
    protocol: Protocol,
    starts: &[usize],
    layout: SegmentLayout,
) -> Result<Vec<ReadSegments>, ChannelError> {
    type Parts = (BTreeMap<usize, Vec<f64>>, BTreeMap<usize, Plan>);
    let read = |(motions, plans): &mut Parts, part: &str, at: Place<'_>, data: &[u8]| {
        if part == "plan" {
            let message = at.decoded(messages::Plan::decode(data))?;
            let (start, plan) = (message.start_sample as usize, plan(&message, &at)?);
            if let Ok(segment) = starts.binary_search(&start) {
                plans.insert(segment, plan);
            }
            return Ok(());
        }
        let (k, configuration) = (sample(&at)?, configuration(data, &at)?);
        let end = starts.partition_point(|&start| start <= k);
        let first = starts.partition_point(|&start| start + layout.samples <= k);
        for (segment, start) in starts.iter().enumerate().take(end).skip(first) {
            let motion = motions.entry(segment);
            let motion = motion.or_insert_with(|| vec![f64::NAN; layout.finger_rows()]);
            let row = SEGMENT_COORDINATES * (k - start);
            motion[row..row + SEGMENT_COORDINATES].copy_from_slice(&configuration);
        }
        Ok(())
    };
    let prefix = format!("{}/", topic::generated(protocol));
    let methods = read_methods(source, &prefix, ["fingertips", "plan"], read)?;
    let method = |(name, (mut motions, mut plans)): (_, Parts)| ReadSegments {
        name,
        trajectories: (0..starts.len())
            .map(|segment| Trajectory::new(layout, motions.remove(&segment)?).ok())
            .collect(),
        plans: (0..starts.len())
            .map(|segment| plans.remove(&segment))
            .collect(),
    };
    Ok(methods.into_iter().map(method).collect())
}

/// Reads errors and contacts of a take's methods, in the order of the file's channels; the instants of each
/// are sorted by time.
///
/// # Errors
///
/// As for [`read_take`](crate::read_take).
pub fn read_evaluated(bytes: &[u8], file_name: &str) -> Result<Vec<EvaluatedMethod>, ChannelError> {
    evaluated_of_source(&mut Source::open(file_name, Cursor::new(bytes))?)
}

/// As [`read_evaluated`] for a file of any size.
///
/// # Errors
///
/// As for [`read_evaluated`].
pub fn evaluated_of_source(source: &mut Source<'_>) -> Result<Vec<EvaluatedMethod>, ChannelError> {
    type Samples = BTreeMap<usize, EvaluatedSample>;
    let parts = ["error", "contact"];
    let read = |samples: &mut Samples, part: &str, at: Place<'_>, data: &[u8]| {
        let sample = sample(&at)?;
        let judged = samples.entry(sample).or_insert(EvaluatedSample {
            sample,
            error_m: None,
            contact: None,
        });
        if part == "error" {
            let message = at.decoded(messages::FingerErrors::decode(data))?;
            judged.error_m = Some(message.to_model());
        } else {
            let message = at.decoded(messages::Contacts::decode(data))?;
            judged.contact = Some(message.to_model());
        }
        Ok(())
    };
    let methods = read_methods(source, "/evaluation/", parts, read)?;
    let method = |(name, samples): (String, Samples)| EvaluatedMethod {
        name,
        samples: samples.into_values().collect(),
    };
    Ok(methods.into_iter().map(method).collect())
}

/// Reads channels of methods of a take, `<prefix><method>/<part>`, in the order of the file's channels.
fn read_methods<T: Default>(
    source: &mut Source<'_>,
    prefix: &str,
    parts: [&str; 2],
    mut read: impl FnMut(&mut T, &str, Place<'_>, &[u8]) -> Result<(), ChannelError>,
) -> Result<Vec<(String, T)>, ChannelError> {
    let metadata = metadata_of_source(source)?;
    let file = &*source.file().to_owned();
    let Some(facts) = metadata.used_recording(file)? else {
        return Err(no_recording(source));
    };
    let mut methods: Vec<(String, T)> = Vec::new();
    let mut channels: BTreeMap<u16, (usize, &str, String)> = BTreeMap::new();
    walk_source(source, |record| {
        match record {
            Record::Channel(channel) => {
                let split = |topic: &str| {
                    let (name, part) = topic.strip_prefix(prefix)?.split_once('/')?;
                    let part = parts.into_iter().find(|known| *known == part)?;
                    Some((name.to_owned(), part))
                };
                if let Some((name, part)) = split(&channel.topic) {
                    let place = methods.iter().position(|(method, _)| *method == name);
                    let index = place.unwrap_or_else(|| {
                        methods.push((name, T::default()));
                        methods.len() - 1
                    });
                    channels.insert(channel.id, (index, part, channel.topic));
                }
            }
            Record::Message { header, data } => {
                if let Some((index, part, topic)) = channels.get(&header.channel_id) {
                    let mut at = Place::new(file, topic, &facts, &header);
                    at.number = at.nearest_sample().0;
                    read(&mut methods[*index].1, part, at, &data)?;
                }
            }
            _ => {}
        }
        Ok::<_, ChannelError>(Depth::Everything)
    })?;
    Ok(methods)
}

fn sample(at: &Place<'_>) -> Result<usize, ChannelError> {
    match at.nearest_sample() {
        (sample, true) => Ok(sample),
        _ => Err(at.error(
            "the time of a sample of the take",
            format!("{} ns", at.log_time),
        )),
    }
}

fn configuration(data: &[u8], at: &Place<'_>) -> Result<Configuration, ChannelError> {
    let message = at.decoded(messages::Fingertips::decode(data))?;
    let mut configuration = [0.0; SEGMENT_COORDINATES];
    let places = configuration.chunks_exact_mut(3);
    for (tip, place) in message.tips().into_array().into_iter().zip(places) {
        let position = tip.and_then(|tip| tip.position_m);
        let position = position.ok_or_else(|| at.error("five positions", "fewer"))?;
        place.copy_from_slice(&position.to_array());
    }
    at.finite(&configuration)?;
    Ok(configuration)
}

fn plan(message: &messages::Plan, at: &Place<'_>) -> Result<Plan, ChannelError> {
    let family = |number| {
        messages::ConstraintFamily::to_model(number)
            .ok_or_else(|| at.error("a family of constraints", number))
    };
    let mut checks = PlanChecks {
        rows: message.rows as usize,
        rows_taken_up: message.rows_taken_up as usize,
        hull_distance_m: message.hull_distance_m,
        ..PlanChecks::default()
    };
    for check in &message.families {
        let family = family(check.family)?;
        checks.active[family] = check.active as usize;
        checks.violation[family] = check.violation;
    }
    // Files from before families were listed have these two alone.
    if message.families.is_empty() {
        checks.active[ConstraintFamily::Velocity] = message.active_velocity_bounds as usize;
        checks.active[ConstraintFamily::Activations] = message.active_activation_bounds as usize;
    }
    let relaxations = message.relaxations.iter().map(|relaxation| {
        Ok(Relaxation {
            family: family(relaxation.family)?,
            by: relaxation.by,
            joint: relaxation.joint,
        })
    });
    let poses = message.hand_from_object.iter().map(|pose| {
        let entry = Entry {
            position_m: pose.position_m,
            orientation: pose.orientation,
            ..Entry::default()
        };
        Pose::from_entry(&entry, at)?
            .ok_or_else(|| at.error("a position and a unit quaternion", "none"))
    });
    Ok(Plan {
        status: messages::PlanStatus::to_model(message.status)
            .ok_or_else(|| at.error("a status of a plan", message.status))?,
        trajectory: None,
        activations_m: DVector::from_vec(message.activations_m.clone()),
        objective: message.objective,
        certificate: Certificate {
            stationarity: message.stationarity,
            primal: message.primal,
            dual: message.dual,
            complementarity: message.complementarity,
        },
        object: poses.collect::<Result<_, ChannelError>>()?,
        checks,
        relaxations: relaxations.collect::<Result<_, ChannelError>>()?,
        rounds: message.rounds as usize,
        iterations: message.iterations as usize,
    })
}
