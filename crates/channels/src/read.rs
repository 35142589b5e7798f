//! A take's nouns from its file.

mod methods;
mod pieces;
mod tracks;

use std::collections::BTreeMap;
use std::io::{self, Cursor, Read};

use foxglove::messages::{Log, log};
use inhand_container::{Depth, Record, Source, channels, metadata, parse_record, walk_source};
use inhand_model::{
    Annotations, Body, Change, ChangeKind, Finding, Finger, Hand, Marker, Motion, Object,
    PerFinger, Pose, Position, Recording, Severity, TrackedBody, World,
};
use mcap::records::{MessageHeader, op};
use prost::Message;

use crate::annotations::EventReader;
use crate::error::ChannelError;
use crate::messages;
use crate::metadata::{CLEANED, Metadata, RECORDING, RecordingFacts};
use crate::take::{ReadCleaned, ReadTake};
use crate::topic;
pub use methods::{
    ReadMethod, ReadSegments, evaluated_of_source, generated_of_source, read_evaluated,
    read_generated, segments_of_source,
};
pub use pieces::StoredMethod;
pub(crate) use tracks::TIME_TOLERANCE_NANOS;
use tracks::{Place, TrackReader};

/// Reads a take that [`write_take`](crate::write_take) wrote.
///
/// Only channels that a recording or motion is made of are decoded; all chunks are unpacked and
/// their CRCs checked. `file_name` is what errors call the file.
///
/// # Errors
///
/// [`ChannelError::Container`] for bytes that are no intact MCAP file, [`ChannelError::Absent`] for one
/// without a recording, [`ChannelError::Mismatch`] where one contradicts itself.
pub fn read_take(bytes: &[u8], file_name: &str) -> Result<ReadTake, ChannelError> {
    take_of_source(&mut Source::open(file_name, Cursor::new(bytes))?)
}

/// As [`read_take`] for a file of any size.
///
/// # Errors
///
/// As for [`read_take`].
pub fn take_of_source(source: &mut Source<'_>) -> Result<ReadTake, ChannelError> {
    let metadata = metadata_of_source(source)?;
    let file_name = &*source.file().to_owned();
    let Some(facts) = metadata.recording(file_name, RECORDING)? else {
        return Err(no_recording(source));
    };
    let recorded = [topic::RECORDING_MARKERS, topic::RECORDING_BODIES];
    let cleaned = [topic::CLEANED_MARKERS, topic::CLEANED_BODIES];
    let mut reader = TakeReader {
        measured: RecordingReader::new(RECORDING, facts, recorded),
        cleaned: (metadata.recording(file_name, CLEANED)?)
            .map(|facts| RecordingReader::new(CLEANED, facts, cleaned)),
        motion: metadata.motion_name(file_name)?.map(MotionReader::new),
        findings: Vec::new(),
        changes: Vec::new(),
    };
    let mut topics: BTreeMap<u16, String> = BTreeMap::new();
    let mut events = EventReader::default();
    walk_source(source, |record| {
        events.record(&record, file_name)?;
        match record {
            Record::Channel(channel) => {
                if let (topic::PROCESSED_OBJECT, Some(motion)) =
                    (&*channel.topic, &mut reader.motion)
                {
                    motion.has_object = true;
                }
                topics.insert(channel.id, channel.topic);
            }
            Record::Message { header, data } => {
                if let Some(topic) = topics.get(&header.channel_id) {
                    reader.message(topic, &header, &data, file_name)?;
                }
            }
            _ => {}
        }
        Ok::<_, ChannelError>(Depth::Everything)
    })?;
    reader.findings.extend(events.findings());
    let annotations = events.finish(&metadata, file_name)?;
    reader.into_take(&metadata, annotations, file_name)
}

/// The metadata records of any MCAP file.
///
/// # Errors
///
/// As for [`read_take`], where the bytes are no intact MCAP file outside its chunks.
pub fn read_metadata(bytes: &[u8], file_name: &str) -> Result<Metadata, ChannelError> {
    metadata_of_source(&mut Source::open(file_name, Cursor::new(bytes))?)
}

/// As [`read_metadata`] for a file of any size, of which nothing else is read; the source is then at its first record.
///
/// # Errors
///
/// As for [`read_metadata`].
pub fn metadata_of_source(source: &mut Source<'_>) -> Result<Metadata, ChannelError> {
    match metadata(source) {
        Ok(records) => Ok(records.into_iter().collect()),
        Err(error) => Err(exact_fault(source, error.into())),
    }
}

/// The fault of a file: reading every chunk may find its place more exactly.
pub(crate) fn exact_fault(source: &mut Source<'_>, fault: ChannelError) -> ChannelError {
    let read = |source: &mut Source<'_>| {
        source.rewind()?;
        walk_source(source, |_| Ok::<_, ChannelError>(Depth::Everything))
    };
    read(source).err().unwrap_or(fault)
}

fn no_recording(source: &mut Source<'_>) -> ChannelError {
    absent(
        source,
        &format!("recording (metadata record \"{RECORDING}\")"),
        "give a file that inhand convert or inhand run wrote, or convert the source again",
    )
}

/// The error for an intact file without `what` was looked for: lists the topics that it has.
pub fn absent(source: &mut Source<'_>, what: &str, hint: &str) -> ChannelError {
    let topics = match channels(source) {
        Ok(channels) => channels.into_iter().map(|channel| {
            let schema = channel.schema_name().unwrap_or("no schema");
            format!("{} ({schema}, {})", channel.topic, channel.message_encoding)
        }),
        Err(error) => return error.into(),
    };
    let topics: Vec<String> = topics.take(20).collect();
    let found = match &*topics {
        [] => "no channel".to_owned(),
        topics => format!("the topics {}", topics.join(", ")),
    };
    ChannelError::Absent(format!(
        "{}: no {what}: the file has {found}; {hint}",
        source.file()
    ))
}

/// A recording as far as it has been read.
struct RecordingReader {
    record: &'static str,
    facts: RecordingFacts,
    markers: TrackReader<Position<World>>,
    bodies: TrackReader<Pose<World, Body>>,
}

impl RecordingReader {
    fn new(
        record: &'static str,
        facts: RecordingFacts,
        [markers, bodies]: [&'static str; 2],
    ) -> Self {
        let qualities = facts.markers.iter().map(|marker| marker.has_quality);
        let errors = facts.bodies.iter().map(|body| body.has_marker_error);
        Self {
            record,
            markers: TrackReader::new(markers, tracks::markers, qualities),
            bodies: TrackReader::new(bodies, tracks::bodies, errors),
            facts,
        }
    }

    /// Samples up to the last one that has a message.
    fn read(&self) -> usize {
        self.markers.read.max(self.bodies.read)
    }

    fn end_at(&mut self, samples: usize) {
        self.facts.samples = samples;
        self.markers.end_at(samples);
        self.bodies.end_at(samples);
    }

    fn into_recording(self, findings: Vec<Finding>, file: &str) -> Result<Recording, ChannelError> {
        let facts = self.facts;
        let samples = facts.samples;
        let markers = self.markers.into_tracks(samples, file)?;
        let markers = (facts.markers.into_iter().zip(markers))
            .map(|(facts, (track, quality))| Marker {
                name: facts.name,
                id: facts.id,
                kind: facts.kind,
                track,
                quality,
            })
            .collect();
        let bodies = self.bodies.into_tracks(samples, file)?;
        let bodies = (facts.bodies.into_iter().zip(bodies))
            .map(|(facts, (track, marker_error_m))| TrackedBody {
                name: facts.name,
                id: facts.id,
                kind: facts.kind,
                track,
                marker_error_m,
            })
            .collect();
        let recording = Recording::new(
            facts.name,
            facts.clock,
            facts.source,
            samples,
            markers,
            bodies,
        );
        let mut recording = recording.map_err(|error| {
            let record = self.record;
            let what = format!("{file}: metadata record \"{record}\", key \"samples\"");
            ChannelError::mismatch(
                what,
                "the number of samples of every marker and body",
                error,
            )
        })?;
        recording.findings = findings;
        Ok(recording)
    }
}

/// A motion as far as it has been read.
struct MotionReader {
    name: String,
    fingertips: TrackReader<Position<Hand>>,
    object: TrackReader<Pose<Hand, Object>>,
    /// An object that was never tracked has no channel; one in an empty take has.
    has_object: bool,
    hand: TrackReader<Pose<World, Hand>>,
}

impl MotionReader {
    fn new(name: String) -> Self {
        let tips = [false; Finger::COUNT];
        Self {
            name,
            fingertips: TrackReader::new(topic::PROCESSED_FINGERTIPS, tracks::fingertips, tips),
            object: TrackReader::new(topic::PROCESSED_OBJECT, tracks::bodies, [false]),
            has_object: false,
            hand: TrackReader::new(topic::PROCESSED_HAND, tracks::bodies, [false]),
        }
    }

    /// Samples up to the last one that has a message.
    fn read(&self) -> usize {
        (self.fingertips.read)
            .max(self.object.read)
            .max(self.hand.read)
    }

    fn end_at(&mut self, samples: usize) {
        self.fingertips.end_at(samples);
        self.object.end_at(samples);
        self.hand.end_at(samples);
    }

    /// The motion of a take with these facts, those of the cleaned one where it was cleaned.
    fn into_motion(self, facts: &RecordingFacts, file: &str) -> Result<Motion, ChannelError> {
        let samples = facts.samples;
        let fingertips = self.fingertips.into_array(samples, file)?;
        let [hand] = self.hand.into_array(samples, file)?;
        let object = (self.has_object).then(|| self.object.into_array(samples, file));
        Ok(Motion {
            name: self.name,
            clock: facts.clock,
            fingertips: PerFinger::new(fingertips),
            object: object.transpose()?.map(|[object]| object),
            hand,
            selected: None,
        })
    }
}

/// A take as far as it has been read.
struct TakeReader {
    measured: RecordingReader,
    cleaned: Option<RecordingReader>,
    motion: Option<MotionReader>,
    findings: Vec<Finding>,
    /// With their sequence numbers: the order of the steps.
    changes: Vec<(u32, Change)>,
}

impl TakeReader {
    fn message(
        &mut self,
        topic: &str,
        header: &MessageHeader,
        data: &[u8],
        file: &str,
    ) -> Result<(), ChannelError> {
        let place = |facts: &RecordingFacts| Place::new(file, topic, facts, header);
        let measured = place(&self.measured.facts);
        match topic {
            topic::RECORDING_MARKERS => return self.measured.markers.message(measured, data),
            topic::RECORDING_BODIES => return self.measured.bodies.message(measured, data),
            topic::RECORDING_FINDINGS => {
                let number = self.findings.len();
                let at = Place { number, ..measured };
                let log: Log = at.decoded(Log::decode(data))?;
                self.findings.push(Finding {
                    severity: match log.level() {
                        log::Level::Info => Severity::Info,
                        _ => Severity::Warning,
                    },
                    place: log.name,
                    message: log.message,
                });
            }
            topic::CLEANED_CHANGES if self.cleaned.is_some() => {
                let number = self.changes.len();
                let change = change(data, &Place { number, ..measured })?;
                self.changes.push((header.sequence, change));
            }
            _ => {}
        }
        // The motion is of the cleaned recording where there is one.
        let used = (self.cleaned.as_ref()).map_or(measured, |cleaned| place(&cleaned.facts));
        if let Some(cleaned) = &mut self.cleaned {
            match topic {
                topic::CLEANED_MARKERS => return cleaned.markers.message(used, data),
                topic::CLEANED_BODIES => return cleaned.bodies.message(used, data),
                _ => {}
            }
        }
        if let Some(motion) = &mut self.motion {
            match topic {
                topic::PROCESSED_FINGERTIPS => return motion.fingertips.message(used, data),
                topic::PROCESSED_OBJECT => return motion.object.message(used, data),
                topic::PROCESSED_HAND => return motion.hand.message(used, data),
                _ => {}
            }
        }
        Ok(())
    }

    /// Ends a take, some of whose messages may be lost, with its last message.
    fn end_where_messages_do(&mut self) {
        let of_motion = self.motion.as_ref().map_or(0, MotionReader::read);
        let measured = self.measured.read();
        let used = match &mut self.cleaned {
            None => measured.max(of_motion),
            Some(cleaned) => {
                let samples = cleaned.read().max(of_motion);
                cleaned.end_at(samples);
                samples
            }
        };
        (self.measured).end_at(if self.cleaned.is_some() {
            measured
        } else {
            used
        });
        if let Some(motion) = &mut self.motion {
            motion.end_at(used);
        }
    }

    fn into_take(
        mut self,
        metadata: &Metadata,
        annotations: Annotations,
        file: &str,
    ) -> Result<ReadTake, ChannelError> {
        if self.measured.facts.lossy {
            self.end_where_messages_do();
        }
        let used = self.cleaned.as_ref().unwrap_or(&self.measured);
        let motion = (self.motion).map(|motion| motion.into_motion(&used.facts, file));
        let recording = (self.measured).into_recording(self.findings.clone(), file)?;
        let mut changes = self.changes;
        changes.sort_by_key(|(sequence, _)| *sequence);
        let cleaned = self.cleaned.map(|cleaned| {
            Ok::<_, ChannelError>(ReadCleaned {
                recording: cleaned.into_recording(self.findings, file)?,
                changes: changes.into_iter().map(|(_, change)| change).collect(),
            })
        });
        Ok(ReadTake {
            recording,
            cleaned: cleaned.transpose()?,
            roles: metadata.roles(file)?,
            motion: motion.transpose()?,
            annotations,
            provenance: metadata.provenance(file)?,
        })
    }
}

/// A change of the recording as measured.
fn change(data: &[u8], at: &Place<'_>) -> Result<Change, ChannelError> {
    let message = at.decoded(messages::Change::decode(data))?;
    let kind = ChangeKind::from_name(&message.kind).ok_or_else(|| {
        let kinds = ChangeKind::ALL.map(ChangeKind::name).join(", ");
        at.error(format!("one of {kinds}"), format!("\"{}\"", message.kind))
    })?;
    let (first, measured) = (message.first_sample, at.samples);
    let end = first.checked_add(message.samples);
    let end = end.filter(|end| *end <= measured as u64).ok_or_else(|| {
        at.error(
            format!("samples of the take, below {measured}"),
            format!("{} from {first}", message.samples),
        )
    })?;
    Ok(Change {
        kind,
        entity: message.entity,
        samples: first as usize..end as usize,
        message: message.message,
    })
}

/// Longest record that is read; one of a take with a thousand markers has some 100 KB.
const MAX_RECORD_BYTES: u64 = 64 << 20;

/// The metadata records before the first other record of an MCAP file, as
/// [`write_take`](crate::write_take) puts them. Bytes that are no MCAP file, or that are cut there, have none.
///
/// # Errors
///
/// Those of reading.
pub fn read_leading_metadata(mut file: impl Read) -> io::Result<Metadata> {
    let mut metadata = Metadata::default();
    let mut magic = Vec::new();
    file.by_ref()
        .take(mcap::MAGIC.len() as u64)
        .read_to_end(&mut magic)?;
    if magic != mcap::MAGIC {
        return Ok(metadata);
    }
    let mut body = Vec::new();
    loop {
        let mut prefix = [0; 9];
        match file.read_exact(&mut prefix) {
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(metadata),
            result => result?,
        }
        let [opcode, length @ ..] = prefix;
        let length = u64::from_le_bytes(length);
        if !matches!(opcode, op::HEADER | op::METADATA) || length > MAX_RECORD_BYTES {
            return Ok(metadata);
        }
        body.clear();
        file.by_ref().take(length).read_to_end(&mut body)?;
        match parse_record(opcode, &body) {
            Ok(mcap::records::Record::Metadata(facts)) => {
                metadata.0.insert(facts.name, facts.metadata);
            }
            Ok(_) => {}
            Err(_) => return Ok(metadata),
        }
    }
}
