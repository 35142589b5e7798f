//! A file against itself: structure, messages against their schemas, errors against the positions that they compare.

use std::collections::BTreeMap;

use inhand_container::{
    Audit, ChannelFacts, Depth, Differences, MessageHeader, Record, Source, audit, walk_source,
};
use inhand_model::{Finger, PerFinger};
use prost::Message;

use crate::error::ChannelError;
use crate::messages;
use crate::metadata::Metadata;
use crate::schema::{Decode, KnownSchema};
use crate::topic;

/// More than storing errors does to them, metres.
const STORED_ROUNDING_M: f64 = 2e-9;

/// Result of [`verify`].
#[derive(Debug, Default)]
#[non_exhaustive]
pub struct VerifiedFile {
    /// The structure, with all differences.
    pub audit: Audit,
    /// Messages of schemas of this crate that were decoded.
    pub decoded: u64,
    /// Stored errors of fingertips that were computed again from the stored positions.
    pub errors: u64,
    /// The metadata records.
    pub metadata: Metadata,
}

/// Compares all that a file of any origin states twice, decodes every message of a schema of this crate, and computes
/// the errors under `/evaluation` again from `/generated` and `/processed` (within 2 nm). Memory is taken for the
/// largest chunk and the summary.
///
/// # Errors
///
/// [`ChannelError::Container`] for a file that cannot be read.
pub fn verify(source: &mut Source<'_>) -> Result<VerifiedFile, ChannelError> {
    let mut verifier = Verifier::default();
    let mut audit = audit(source, &mut |channel, header, data, differences| {
        verifier.message(channel, header, data, differences);
    })?;
    verifier.settle(&mut audit.differences);
    audit.notes.extend(verifier.notes.into_values());
    let mut verified = VerifiedFile {
        decoded: verifier.decoded,
        errors: verifier.errors,
        audit,
        metadata: Metadata::default(),
    };
    source.rewind()?;
    // A file that is damaged there has said so above.
    let _: Result<(), ChannelError> = walk_source(source, |record| {
        if let Record::Metadata(facts) = record {
            verified.metadata.0.insert(facts.name, facts.metadata);
        }
        Ok(Depth::Outside)
    });
    Ok(verified)
}

/// Messages of one instant that belong together.
#[derive(Default)]
struct Instant {
    log_time: u64,
    processed: Option<Tips>,
    /// By method; `None` where several trajectories are there.
    generated: BTreeMap<String, Option<Tips>>,
    errors: BTreeMap<String, PerFinger<f64>>,
}

type Tips = PerFinger<Option<[f64; 3]>>;

#[derive(Default)]
struct Verifier {
    /// How messages of a channel are decoded.
    decoders: BTreeMap<u16, Option<Decode>>,
    /// Messages decoded of each channel.
    numbers: BTreeMap<u16, u64>,
    decoded: u64,
    errors: u64,
    /// By name of the schema.
    notes: BTreeMap<String, String>,
    instant: Instant,
}

impl Verifier {
    fn message(
        &mut self,
        channel: &ChannelFacts,
        header: &MessageHeader,
        data: &[u8],
        differences: &mut Differences,
    ) {
        let decode = match self.decoders.get(&channel.id) {
            Some(decode) => *decode,
            None => {
                let decode = self.decoder(channel);
                *self.decoders.entry(channel.id).or_insert(decode)
            }
        };
        let Some(decode) = decode else {
            return;
        };
        let number = self.numbers.entry(channel.id).or_default();
        if let Err(error) = decode(data) {
            let schema = channel.schema_name().unwrap_or_default();
            let place = format_args!("{}, message {number}", channel.topic);
            differences.add(place, format_args!("a message {schema}"), error);
        }
        *number += 1;
        self.decoded += 1;
        if header.log_time != self.instant.log_time {
            self.settle(differences);
            self.instant.log_time = header.log_time;
        }
        self.collect(&channel.topic, data);
    }

    /// Only messages of the schemas that this crate writes are decoded.
    fn decoder(&mut self, channel: &ChannelFacts) -> Option<Decode> {
        let schema =
            (channel.schema.as_ref()).filter(|_| channel.message_encoding == "protobuf")?;
        match KnownSchema::find(schema)? {
            KnownSchema::Same(decode) => Some(decode),
            KnownSchema::OtherVersion(decode) => {
                let name = &schema.name;
                let note = format!("the schema {name} is of another version than this program's");
                self.notes.insert(name.clone(), note);
                Some(decode)
            }
        }
    }

    /// Keeps what errors are computed from.
    fn collect(&mut self, topic: &str, data: &[u8]) {
        let tips = |data| {
            let tips = messages::Fingertips::decode(data).ok()?.tips();
            Some(tips.map(|tip| Some(tip?.position_m?.to_array())))
        };
        let part = |root: &str, leaf: &str| {
            let inner = topic.strip_prefix(root)?.strip_prefix('/')?;
            Some(inner.strip_suffix(leaf)?.strip_suffix('/')?.to_owned())
        };
        let instant = &mut self.instant;
        if topic == topic::PROCESSED_FINGERTIPS {
            instant.processed = tips(data);
        } else if let Some(method) = part(topic::GENERATED, "fingertips") {
            let several = instant.generated.contains_key(&method);
            let tips = tips(data).filter(|_| !several);
            instant.generated.insert(method, tips);
        } else if let Some(method) = part(topic::EVALUATION, "error")
            && let Ok(errors) = messages::FingerErrors::decode(data)
        {
            instant.errors.insert(method, errors.to_model());
        }
    }

    /// Computes the errors of the instant that ended.
    fn settle(&mut self, differences: &mut Differences) {
        let instant = std::mem::take(&mut self.instant);
        let Some(recorded) = instant.processed else {
            return;
        };
        for (method, stored) in &instant.errors {
            let Some(Some(generated)) = instant.generated.get(method) else {
                continue;
            };
            for finger in Finger::ALL {
                let (Some(a), Some(b)) = (generated[finger], recorded[finger]) else {
                    continue;
                };
                self.errors += 1;
                let squares = a.iter().zip(b).map(|(a, b)| (a - b).powi(2));
                let (held, stored) = (squares.sum::<f64>().sqrt(), stored[finger]);
                if (held - stored).abs() > STORED_ROUNDING_M {
                    differences.add(
                        format_args!(
                            "{}, {} ns, {finger}",
                            topic::named(topic::EVALUATION, method, "error"),
                            instant.log_time
                        ),
                        format_args!("{:.6} mm, from the positions stored", held * 1e3),
                        format_args!("{:.6} mm", stored * 1e3),
                    );
                }
            }
        }
    }
}
