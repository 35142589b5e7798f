//! Dictionaries and their file.

mod residual;

use std::fmt::Display;
use std::io::{Cursor, Write};

use inhand_container::{Depth, Record, Source, walk_source};
use inhand_model::{
    Clock, Demonstrated, Dictionary, Finger, Frame, Hand, Hull, Learning, MethodCandidate,
    MethodChoice, OBJECT_COORDINATES, PerFinger, Provenance, Restart, SEGMENT_COORDINATES,
    SegmentLayout, StartTime, Status, VelocityBounds, stored,
};
use nalgebra::{DMatrix, DVector};
use prost::{DecodeError, Message};

use crate::error::ChannelError;
use crate::messages;
use crate::metadata::Metadata;
use crate::read::{absent, exact_fault};
use crate::streams::{PACKED, Sampling, Streams};
use crate::take::scene_stride;
use crate::topic;
use crate::view::draw_dictionary;
use crate::wire::{Point, Timestamp};

/// A dictionary has no time of its own: its file starts at the epoch.
const START_UNIX_NANOS: u64 = 0;

/// Distance of a playable second from the mean motion, in standard deviations of the
/// activation: enough to see, within what training has shown.
const PLAYED_DEVIATIONS: f64 = 2.0;

/// Writes a dictionary as an MCAP file that plays: the dictionary itself as one message on
/// `/dictionary/model`, and one second for each primitive on `/dictionary/primitives`, in order, 25 instants of it.
///
/// Second `i` shows the mean training motion with the activation of primitive `i` raised by two of
/// its standard deviations, frame `hand`: its fingertips, whether or not the dictionary has the object.
/// The same dictionary gives the same bytes.
///
/// # Errors
///
/// [`ChannelError::Mismatch`] for a dictionary that is none ([`Dictionary::validate`]);
/// [`ChannelError::Container`] when writing fails.
pub fn write_dictionary(
    out: &mut dyn Write,
    dictionary: &Dictionary,
    provenance: &[Provenance],
) -> Result<(), ChannelError> {
    (dictionary.validate())
        .map_err(|error| ChannelError::mismatch("dictionary", "one that fits together", error))?;
    let layout = dictionary.layout;
    let clock = Clock::new(START_UNIX_NANOS, StartTime::Unknown, layout.rate_hz)
        .map_err(|error| ChannelError::mismatch("dictionary", "a rate", error))?;
    let samples = Sampling::all(clock, dictionary.rank() * layout.samples);
    let played = samples.every(scene_stride(layout.rate_hz));
    let mean = &dictionary.offset_m + &dictionary.primitives * &dictionary.activation_mean_m;
    let deviations_m: Vec<f64> = (dictionary.activation_covariance_m2.diagonal().iter())
        .map(|variance_m2| PLAYED_DEVIATIONS * variance_m2.max(0.0).sqrt())
        .collect();
    let position_m = |t, finger, value_m: &dyn Fn(usize) -> f64| {
        [0, 1, 2].map(|axis| value_m(SegmentLayout::row(t, finger, axis)))
    };
    let mean_m = |t, finger| position_m(t, finger, &|row| mean[row]);
    let played_m = |k: usize, finger| {
        let (i, t) = (k / layout.samples, k % layout.samples);
        position_m(t, finger, &|row| {
            mean[row] + dictionary.primitives[(row, i)] * deviations_m[i]
        })
    };

    let mut metadata = Metadata::default();
    metadata.add_provenance(provenance);
    let mut streams = Streams::create(out, PACKED, &metadata)?;
    let hand = Some(Hand::NAME);
    let message = to_message(dictionary);
    streams.once(topic::DICTIONARY, hand, START_UNIX_NANOS, &message)?;
    streams.sampled(topic::DICTIONARY_PRIMITIVES, hand, played, |at| {
        Some(messages::Fingertips::new(at.unix_nanos, |finger| {
            let position_m = played_m(at.k, finger).map(stored);
            messages::Fingertip::new(Some(position_m), Status::Measured)
        }))
    })?;
    streams.sampled(topic::DICTIONARY_PROFILE, hand, played, |at| {
        let (i, t) = (at.k / layout.samples, at.k % layout.samples);
        let [thumb_m, index_m, middle_m, ring_m, little_m] = Finger::ALL.map(|finger| {
            let (played, mean) = (played_m(at.k, finger), mean_m(t, finger));
            let square = |axis: usize| (played[axis] - mean[axis]).powi(2);
            stored((square(0) + square(1) + square(2)).sqrt())
        });
        Some(messages::Profile {
            timestamp: Some(Timestamp::from_unix_nanos(at.unix_nanos)),
            // A dictionary has far fewer primitives than 32 bits count.
            primitive: i as u32,
            thumb_m,
            index_m,
            middle_m,
            ring_m,
            little_m,
        })
    })?;
    draw_dictionary(dictionary, samples, mean_m, played_m, &mut streams)?;
    streams.finish()
}

/// Reads a dictionary that [`write_dictionary`] wrote, with what made it.
///
/// Chunks are unpacked until the dictionary is found; of the rest the checksum over the whole file is compared.
///
/// # Errors
///
/// As for [`read_take`](crate::read_take); [`ChannelError::Absent`] for a file without a
/// dictionary, [`ChannelError::Mismatch`] for one that does not fit together.
pub fn read_dictionary(
    bytes: &[u8],
    file_name: &str,
) -> Result<(Dictionary, Vec<Provenance>), ChannelError> {
    dictionary_of_source(&mut Source::open(file_name, Cursor::new(bytes))?)
}

/// As [`read_dictionary`] for a file of any size.
///
/// # Errors
///
/// As for [`read_dictionary`].
pub fn dictionary_of_source(
    source: &mut Source<'_>,
) -> Result<(Dictionary, Vec<Provenance>), ChannelError> {
    source.rewind()?;
    let Found {
        metadata, message, ..
    } = find(source)?;
    let file_name = &*source.file().to_owned();
    let Some(message) = message else {
        return Err(absent(
            source,
            &format!("dictionary (topic {})", topic::DICTIONARY),
            "give a file that inhand learn wrote",
        ));
    };
    let provenance = metadata.provenance(file_name)?;
    let decoder = Decoder { file: file_name };
    let message = message.map_err(|error| decoder.error("an inhand.Dictionary", error))?;
    Ok((decoder.dictionary(message)?, provenance))
}

/// Parts of a file with a dictionary.
#[derive(Default)]
struct Found {
    metadata: Metadata,
    channel_id: Option<u16>,
    message: Option<Result<messages::Dictionary, DecodeError>>,
}

impl Found {
    fn visit(&mut self, record: Record<'_>) {
        match record {
            Record::Metadata(facts) => {
                self.metadata.0.insert(facts.name, facts.metadata);
            }
            Record::Channel(channel) if channel.topic == topic::DICTIONARY => {
                self.channel_id = Some(channel.id);
            }
            Record::Message { header, data }
                if self.message.is_none() && Some(header.channel_id) == self.channel_id =>
            {
                self.message = Some(messages::Dictionary::decode(&*data));
            }
            _ => {}
        }
    }
}

/// Searches a file for its dictionary.
fn find(source: &mut Source<'_>) -> Result<Found, ChannelError> {
    let mut found = Found::default();
    let walked = walk_source(source, |record| {
        found.visit(record);
        Ok(match found.message {
            None => Depth::Everything,
            Some(_) => Depth::Outside,
        })
    });
    match walked {
        Ok(()) => Ok(found),
        Err(error) => Err(exact_fault(source, error)),
    }
}

fn to_message(dictionary: &Dictionary) -> messages::Dictionary {
    let Demonstrated { hulls, velocity } = &dictionary.demonstrated;
    let learning = &dictionary.learning;
    let [thumb, index, middle, ring, little] = hulls
        .each_ref()
        .map(|hull| Some(hull_message(hull)))
        .into_array();
    messages::Dictionary {
        kind: messages::DictionaryKind::from(dictionary.kind).into(),
        samples: dictionary.layout.samples as u64,
        rate_hz: dictionary.layout.rate_hz,
        rank: dictionary.rank() as u64,
        offset_m: dictionary.offset_m.as_slice().to_vec(),
        primitives: dictionary.primitives.as_slice().to_vec(),
        activation_mean_m: dictionary.activation_mean_m.as_slice().to_vec(),
        activation_covariance_m2: dictionary.activation_covariance_m2.as_slice().to_vec(),
        covariance_shrinkage: dictionary.covariance_shrinkage,
        learning: Some(messages::Learning {
            segments: learning.segments as u64,
            rms_m: learning.rms_m,
            relative_error: learning.relative_error,
            iterations: learning.iterations as u64,
            stop_reason: messages::StopReason::from(learning.stop_reason).into(),
            objective_history_m2: learning.objective_history_m2.clone(),
            seed: learning.seed,
            restarts: (learning.restarts.iter())
                .map(|restart| messages::Restart {
                    seed: restart.seed,
                    rms_m: restart.rms_m,
                    objective_m2: restart.objective_m2,
                    matched_cosine: restart.matched_cosine,
                })
                .collect(),
        }),
        hulls: Some(messages::Hulls {
            thumb,
            index,
            middle,
            ring,
            little,
        }),
        velocity_min_m_s: velocity.min_m_s.to_vec(),
        velocity_max_m_s: velocity.max_m_s.to_vec(),
        object: dictionary.layout.object,
        residual: dictionary.residual.as_ref().map(residual::to_message),
        choice: dictionary.choice.as_ref().map(choice_message),
        residual_held_out: (dictionary.residual_held_out.as_ref()).map(residual::to_message),
    }
}

fn choice_message(choice: &MethodChoice) -> messages::MethodChoice {
    messages::MethodChoice {
        method: choice.method.clone(),
        candidates: (choice.candidates.iter())
            .map(|candidate| messages::MethodCandidate {
                name: candidate.name.clone(),
                mean_error_m: candidate.mean_error_m,
            })
            .collect(),
        gain_m: choice.gain_m,
        gain_standard_error_m: choice.gain_standard_error_m,
        folds: choice.folds as u64,
        segments: choice.segments as u64,
        protocol: messages::Protocol::from(choice.protocol).into(),
    }
}

fn choice_from_message(choice: messages::MethodChoice) -> MethodChoice {
    MethodChoice {
        // Older versions knew the published protocol alone, and stated none.
        protocol: messages::Protocol::to_model(choice.protocol).unwrap_or_default(),
        method: choice.method,
        candidates: (choice.candidates.into_iter())
            .map(|candidate| MethodCandidate {
                name: candidate.name,
                mean_error_m: candidate.mean_error_m,
            })
            .collect(),
        gain_m: choice.gain_m,
        gain_standard_error_m: choice.gain_standard_error_m,
        folds: choice.folds as usize,
        segments: choice.segments as usize,
    }
}

fn hull_message(hull: &Hull) -> messages::Hull {
    messages::Hull {
        vertices_m: hull.vertices_m.iter().copied().map(Point::from).collect(),
        triangles: hull.triangles.concat(),
        normals: hull.normals.iter().copied().map(Point::from).collect(),
        offsets_m: hull.offsets_m.clone(),
    }
}

/// Makes a dictionary of its message.
struct Decoder<'a> {
    file: &'a str,
}

impl Decoder<'_> {
    fn error(&self, expected: impl Display, found: impl Display) -> ChannelError {
        ChannelError::message(self.file, topic::DICTIONARY, 0, expected, found)
    }

    fn size(&self, what: &str, n: u64) -> Result<usize, ChannelError> {
        usize::try_from(n).map_err(|_| self.error(format!("{what} below 2^32"), n))
    }

    fn layout(&self, message: &messages::Dictionary) -> Result<SegmentLayout, ChannelError> {
        if !(message.rate_hz.is_finite() && message.rate_hz > 0.0) {
            return Err(self.error("a positive rate in Hz", message.rate_hz));
        }
        let layout = SegmentLayout {
            samples: self.size("samples", message.samples)?,
            rate_hz: message.rate_hz,
            object: message.object,
        };
        // Only then the layout can count its rows.
        let most = SEGMENT_COORDINATES + OBJECT_COORDINATES;
        if layout.samples > usize::MAX / most {
            return Err(self.error("fewer samples", message.samples));
        }
        Ok(layout)
    }

    fn dictionary(&self, message: messages::Dictionary) -> Result<Dictionary, ChannelError> {
        let layout = self.layout(&message)?;
        let rank = self.size("a rank", message.rank)?;
        let rows = layout.rows();
        let learning = (message.learning).ok_or_else(|| self.error("how learning went", "none"))?;
        let hulls = (message.hulls).ok_or_else(|| self.error("hulls", "none"))?;
        let [thumb, index, middle, ring, little] = [
            hulls.thumb,
            hulls.index,
            hulls.middle,
            hulls.ring,
            hulls.little,
        ]
        .map(|hull| self.hull(hull.unwrap_or_default()));
        let configuration = |what: &str, numbers: Vec<f64>| {
            let found = numbers.len();
            <[f64; SEGMENT_COORDINATES]>::try_from(numbers)
                .map_err(|_| self.error(format!("{SEGMENT_COORDINATES} {what}"), found))
        };
        let covariances = message.activation_covariance_m2;
        let dictionary = Dictionary {
            kind: messages::DictionaryKind::to_model(message.kind)
                .ok_or_else(|| self.error("a kind of dictionary", message.kind))?,
            layout,
            offset_m: DVector::from_vec(message.offset_m),
            primitives: self.matrix("primitives", (rows, rank), message.primitives)?,
            activation_mean_m: DVector::from_vec(message.activation_mean_m),
            activation_covariance_m2: self.matrix("covariances", (rank, rank), covariances)?,
            covariance_shrinkage: message.covariance_shrinkage,
            learning: self.learning(learning)?,
            demonstrated: Demonstrated {
                hulls: PerFinger::new([thumb?, index?, middle?, ring?, little?]),
                velocity: VelocityBounds {
                    min_m_s: configuration("lowest velocities", message.velocity_min_m_s)?,
                    max_m_s: configuration("highest velocities", message.velocity_max_m_s)?,
                },
            },
            // Last: it relies on a layout whose rows were counted above.
            residual: (message.residual)
                .map(|residual| self.residual(residual, layout))
                .transpose()?,
            residual_held_out: (message.residual_held_out)
                .map(|residual| self.residual(residual, layout))
                .transpose()?,
            choice: message.choice.map(choice_from_message),
        };
        (dictionary.validate())
            .map_err(|error| self.error("a dictionary that fits together", error))?;
        Ok(dictionary)
    }

    fn learning(&self, learning: messages::Learning) -> Result<Learning, ChannelError> {
        Ok(Learning {
            segments: self.size("segments", learning.segments)?,
            rms_m: learning.rms_m,
            relative_error: learning.relative_error,
            iterations: self.size("iterations", learning.iterations)?,
            stop_reason: messages::StopReason::to_model(learning.stop_reason)
                .ok_or_else(|| self.error("a reason to stop", learning.stop_reason))?,
            objective_history_m2: learning.objective_history_m2,
            seed: learning.seed,
            restarts: (learning.restarts.into_iter())
                .map(|restart| Restart {
                    seed: restart.seed,
                    rms_m: restart.rms_m,
                    objective_m2: restart.objective_m2,
                    matched_cosine: restart.matched_cosine,
                })
                .collect(),
        })
    }

    /// A matrix by columns.
    fn matrix(
        &self,
        what: &str,
        (rows, columns): (usize, usize),
        numbers: Vec<f64>,
    ) -> Result<DMatrix<f64>, ChannelError> {
        if rows.checked_mul(columns) != Some(numbers.len()) {
            let expected = format!("{rows} x {columns} numbers for the {what}");
            return Err(self.error(expected, numbers.len()));
        }
        match numbers.iter().find(|number| !number.is_finite()) {
            None => Ok(DMatrix::from_vec(rows, columns, numbers)),
            Some(number) => Err(self.error(format!("finite numbers in the {what}"), number)),
        }
    }

    fn hull(&self, hull: messages::Hull) -> Result<Hull, ChannelError> {
        let vertices = hull.vertices_m.len();
        let (triangles, rest) = hull.triangles.as_chunks::<3>();
        let outside = (hull.triangles.iter()).find(|&&corner| corner as usize >= vertices);
        if let Some(corner) = outside {
            return Err(self.error(format!("corners below {vertices}"), corner));
        }
        if !rest.is_empty() {
            return Err(self.error("triangles of three corners", hull.triangles.len()));
        }
        if hull.normals.len() != hull.offsets_m.len() {
            return Err(self.error(
                format!("{} offsets, one for each normal", hull.normals.len()),
                hull.offsets_m.len(),
            ));
        }
        let points = hull.vertices_m.iter().chain(&hull.normals);
        let mut numbers = points
            .flat_map(|point| point.to_array())
            .chain(hull.offsets_m.iter().copied());
        if !numbers.all(f64::is_finite) {
            return Err(self.error("finite numbers in a hull", "others"));
        }
        let arrays = |points: Vec<Point>| points.into_iter().map(Point::to_array).collect();
        Ok(Hull {
            triangles: triangles.to_vec(),
            vertices_m: arrays(hull.vertices_m),
            normals: arrays(hull.normals),
            offsets_m: hull.offsets_m,
        })
    }
}
