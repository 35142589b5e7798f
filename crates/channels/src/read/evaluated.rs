//! Reads the evaluation channels of a take's file.

use std::collections::BTreeMap;

use inhand_model::Clock;
use mcap::records::Record;
use prost::Message;

use super::read_metadata;
use crate::error::ChannelError;
use crate::messages;
use crate::records::{Depth, walk};
use crate::take::{EvaluatedMethod, EvaluatedSample};

/// Reads errors and contacts of a take's methods, in the order of the file's channels.
///
/// # Errors
///
/// As for [`read_take`](crate::read_take).
pub fn read_evaluated(bytes: &[u8], file_name: &str) -> Result<Vec<EvaluatedMethod>, ChannelError> {
    let metadata = read_metadata(bytes, file_name)?;
    let Some(facts) = metadata.used_recording(file_name)? else {
        return Err(super::no_recording(bytes, file_name));
    };
    let mut methods: Vec<(String, BTreeMap<usize, EvaluatedSample>)> = Vec::new();
    let mut channels: BTreeMap<u16, (usize, Part, String)> = BTreeMap::new();
    walk(file_name, bytes, Depth::Everything, |record| match record {
        Record::Channel(channel) => {
            if let Some((name, part)) = method_of(&channel.topic) {
                let known = methods.iter().position(|(method, _)| method == name);
                let index = known.unwrap_or_else(|| {
                    methods.push((name.to_owned(), BTreeMap::new()));
                    methods.len() - 1
                });
                channels.insert(channel.id, (index, part, channel.topic));
            }
            Ok(())
        }
        Record::Message { header, data } => {
            let Some((index, part, topic)) = channels.get(&header.channel_id) else {
                return Ok(());
            };
            let sample = sample_at(facts.clock, header.log_time);
            let wrong = |expected: &str, found: String| ChannelError::Message {
                file: file_name.to_owned(),
                topic: topic.clone(),
                message: sample,
                expected: expected.to_owned(),
                found,
            };
            if facts.clock.unix_nanos(sample).abs_diff(header.log_time)
                > super::TIME_TOLERANCE_NANOS
                || sample >= facts.samples
            {
                let found = format!("{} ns", header.log_time);
                return Err(wrong("the time of a sample of the take", found));
            }
            let protobuf = |error: prost::DecodeError| wrong("protobuf", error.to_string());
            let judged = (methods[*index].1)
                .entry(sample)
                .or_insert(EvaluatedSample {
                    sample,
                    error_m: None,
                    contact: None,
                });
            match part {
                Part::Error => {
                    let message = messages::FingerErrors::decode(&*data).map_err(protobuf)?;
                    judged.error_m = Some(message.to_model());
                }
                Part::Contact => {
                    let message = messages::Contacts::decode(&*data).map_err(protobuf)?;
                    judged.contact = Some(message.to_model());
                }
            }
            Ok(())
        }
        _ => Ok(()),
    })?;
    Ok((methods.into_iter())
        .map(|(name, samples)| EvaluatedMethod {
            name,
            samples: samples.into_values().collect(),
        })
        .collect())
}

#[derive(Clone, Copy)]
enum Part {
    Error,
    Contact,
}

/// Name and part of a topic: `/evaluation/<name>/error` or `.../contact`.
fn method_of(topic: &str) -> Option<(&str, Part)> {
    let (name, part) = topic.strip_prefix("/evaluation/")?.split_once('/')?;
    match part {
        "error" => Some((name, Part::Error)),
        "contact" => Some((name, Part::Contact)),
        _ => None,
    }
}

fn sample_at(clock: Clock, log_time: u64) -> usize {
    let since_start = log_time.saturating_sub(clock.start_unix_nanos());
    clock.nearest_sample(since_start as f64 / 1e9)
}
