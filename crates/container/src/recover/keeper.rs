//! Second pass: writes recovered records in a readable order, channels before their messages, schemas
//! before their channels.

use std::collections::BTreeSet;
use std::io::Write;

use mcap::records::{Record, op};

use super::probe::Known;
use super::report::{Loss, Recovered};
use super::scan::{Damage, FoundChunk, Kind, Sum, Visitor};
use super::survey::{Survey, Trust};
use crate::attachment::pass_attachment;
use crate::chunk::Packing;
use crate::error::{ContainerError, Place};
use crate::fields::{parse_record, stated_bytes};
use crate::format::{MessageFacts, Records, id_of, push_record, set_id, to_bytes};
use crate::ids::Ids;
use crate::overview::MetadataRecord;
use crate::source::{Head, Source};
use crate::writer::Writer;

/// What the topics of messages start with whose checksum differs.
const UNVERIFIED: &str = "/unverified";

/// Where the numbers of files start that stand for the unverified messages of others.
const UNVERIFIED_FILES: usize = usize::MAX / 2;

pub(super) struct Keeper<'a> {
    file: String,
    writer: Writer<'a>,
    report: Recovered,
    survey: Survey,
    keep_unverified: bool,
    /// Number of the file at hand, of several that were joined.
    number: usize,
    ids: Ids,
    /// Opcodes and new ids of the schemas and channels that are written.
    defined: BTreeSet<(u8, u16)>,
    /// Records that are kept and not written yet.
    kept: Vec<u8>,
    /// Log time of the last message.
    last_time: Option<u64>,
    /// Listed losses that still lack log times.
    without_span: Vec<usize>,
}

impl<'a> Keeper<'a> {
    pub(super) fn create(
        file: &str,
        out: &'a mut dyn Write,
        header: &[u8],
        survey: Survey,
        keep_unverified: bool,
    ) -> Result<Self, ContainerError> {
        Ok(Self {
            file: file.to_owned(),
            writer: Writer::with_header(out, header, Packing::Zstd)?,
            report: Recovered::default(),
            survey,
            keep_unverified,
            number: 0,
            ids: Ids::new(true),
            defined: BTreeSet::new(),
            kept: Vec::new(),
            last_time: None,
            without_span: Vec::new(),
        })
    }

    /// Keeps a record, after what it needs.
    fn keep(&mut self, opcode: u8, body: &[u8]) -> Result<(), ContainerError> {
        match opcode {
            op::SCHEMA | op::CHANNEL => {
                let counts = self.survey.counts(self.number, opcode, body);
                let disputed =
                    id_of(body).is_some_and(|id| self.survey.is_disputed(self.number, opcode, id));
                self.report.contradictions += u64::from(!counts || disputed);
                if counts {
                    return self.define(self.number, opcode, body);
                }
            }
            op::MESSAGE => self.message(self.number, body)?,
            _ => push_record(&mut self.kept, opcode, body),
        }
        Ok(())
    }

    /// Keeps a schema or channel of a file, a channel after its schema.
    fn define(&mut self, file: usize, opcode: u8, body: &[u8]) -> Result<(), ContainerError> {
        let mut body = body.to_vec();
        // Zeroed bytes are short texts and what is left over, which some readers take for the next record.
        if let Some(bytes) = stated_bytes(opcode, &body)
            && let Some(trimmed) = body.get(..bytes as usize)
            && parse_record(opcode, trimmed).is_ok()
        {
            body.truncate(bytes as usize);
        }
        if let Ok(Record::Channel(channel)) = parse_record(opcode, &body)
            && channel.schema_id != 0
            && self.ids.schema(file, channel.schema_id).is_none()
            && !self.define_from_survey(file, op::SCHEMA, channel.schema_id)?
        {
            self.report.without_schema.insert(channel.topic);
            // Number 0 means none.
            set_id(&mut body[2..], 0);
        }
        let name = self.file.clone();
        let place = Place {
            file: &name,
            offset: 0,
        };
        let body = self.ids.define(file, place, opcode, &body)?;
        self.defined.extend(id_of(&body).map(|id| (opcode, id)));
        push_record(&mut self.kept, opcode, &body);
        Ok(())
    }

    /// Keeps the definition of an id that has none yet; `false` where there is none anywhere.
    fn define_from_survey(
        &mut self,
        file: usize,
        opcode: u8,
        id: u16,
    ) -> Result<bool, ContainerError> {
        let Some((trust, body)) = self.survey.first(file, opcode, id) else {
            return Ok(false);
        };
        let body = body.to_vec();
        self.note_doubt(trust, opcode, &body);
        self.define(file, opcode, &body)?;
        Ok(true)
    }

    fn note_doubt(&mut self, trust: Trust, opcode: u8, body: &[u8]) {
        // Padding in a sound file is no damage.
        let in_doubt = match trust {
            Trust::Damaged => !self.survey.is_sound(),
            trust => trust == Trust::Doubtful,
        };
        if in_doubt {
            let name = match parse_record(opcode, body) {
                Ok(Record::Channel(channel)) => channel.topic,
                Ok(Record::Schema { header, .. }) => header.name,
                _ => return,
            };
            self.report.doubtful.insert(name);
        }
    }

    fn message(&mut self, file: usize, body: &[u8]) -> Result<(), ContainerError> {
        let Some(message) = MessageFacts::read(body) else {
            return Ok(());
        };
        let known = self.ids.channel(file, message.channel).is_some()
            || self.define_from_survey(file, op::CHANNEL, message.channel)?;
        let Some(id) = (self.ids.channel(file, message.channel)).filter(|_| known) else {
            *(self.report.without_channel)
                .entry(message.channel)
                .or_default() += 1;
            return Ok(());
        };
        let (first, last) = (self.last_time.unwrap_or(message.log_time), message.log_time);
        for loss in self.without_span.drain(..) {
            self.report.losses[loss].span = Some((first.min(last), first.max(last)));
        }
        self.last_time = Some(message.log_time);
        push_record(&mut self.kept, op::MESSAGE, body);
        let start = self.kept.len() - body.len();
        set_id(&mut self.kept[start..], id);
        Ok(())
    }

    /// Keeps a message whose chunk has another checksum than it states, under a topic of its own.
    fn unverified(&mut self, body: &[u8]) -> Result<(), ContainerError> {
        let Some(MessageFacts { channel, .. }) = MessageFacts::read(body) else {
            return Ok(());
        };
        let file = UNVERIFIED_FILES + self.number;
        if self.ids.channel(file, channel).is_none() {
            let number = self.number;
            let Some((_, body)) = self.survey.first(number, op::CHANNEL, channel) else {
                return Ok(());
            };
            let Ok(Record::Channel(mut record)) = parse_record(op::CHANNEL, body) else {
                return Ok(());
            };
            record.topic = format!("{UNVERIFIED}{}", record.topic);
            let schema = self.survey.first(number, op::SCHEMA, record.schema_id);
            if let Some((_, schema)) = schema {
                let schema = schema.to_vec();
                self.define(file, op::SCHEMA, &schema)?;
            }
            self.define(file, op::CHANNEL, &to_bytes(&record))?;
        }
        self.report.unverified += 1;
        self.message(file, body)
    }

    /// Writes what is kept as records that come one by one.
    fn write_loose(&mut self) -> Result<(), ContainerError> {
        let kept = std::mem::take(&mut self.kept);
        for (opcode, body) in Records(&kept).flatten() {
            match opcode {
                op::SCHEMA | op::CHANNEL | op::MESSAGE => self.writer.inside(opcode, body)?,
                _ => {
                    if let Ok(Record::Metadata(record)) = parse_record(opcode, body) {
                        self.report.metadata.insert(record.name);
                    }
                    self.writer.outside(opcode, body)?;
                }
            }
        }
        self.kept = kept;
        self.kept.clear();
        Ok(())
    }

    /// Ends the file, after the schemas and channels that no message needed, and a record that says what
    /// was lost.
    pub(super) fn finish(
        mut self,
        add: impl FnOnce(&Recovered) -> Option<MetadataRecord>,
    ) -> Result<Recovered, ContainerError> {
        let all: Vec<_> = (self.survey.all())
            .map(|(file, opcode, trust, body)| (file, opcode, trust, body.to_vec()))
            .collect();
        for (file, opcode, trust, body) in all {
            let kept = self.kept.len();
            let count = self.defined.len();
            self.define(file, opcode, &body)?;
            if self.defined.len() == count {
                self.kept.truncate(kept);
            } else {
                self.note_doubt(trust, opcode, &body);
            }
        }
        self.write_loose()?;
        self.writer.close_chunk()?;
        self.report.written = self.writer.written();
        if let Some(record) = add(&self.report) {
            self.writer.metadata(&record.name, &record.facts)?;
        }
        self.report.written = self.writer.finish()?;
        Ok(self.report)
    }
}

impl Known for Keeper<'_> {
    fn knows(&self, message: MessageFacts) -> bool {
        self.survey.knows(message)
    }

    fn spans(&self, message: MessageFacts) -> Option<bool> {
        self.survey.spans(message)
    }
}

impl Visitor for Keeper<'_> {
    fn file(&mut self, number: usize, _header: Option<&[u8]>) -> Result<(), ContainerError> {
        self.number = number;
        Ok(())
    }

    fn chunk(&mut self, chunk: &FoundChunk<'_>, records: &[u8]) -> Result<(), ContainerError> {
        if chunk.kind == Kind::Damaged && !self.keep_unverified {
            return Ok(());
        }
        self.kept.clear();
        for (opcode, body) in Records(records).flatten() {
            match opcode {
                op::MESSAGE if chunk.kind == Kind::Damaged => self.unverified(body)?,
                _ if chunk.kind == Kind::Damaged => {}
                op::SCHEMA | op::CHANNEL | op::MESSAGE | 0x80.. => self.keep(opcode, body)?,
                _ => {}
            }
        }
        let kept = std::mem::take(&mut self.kept);
        match chunk.packed.filter(|_| kept == records) {
            _ if kept.is_empty() => {}
            Some(packed) => (self.writer).packed_chunk(records, chunk.compression, packed)?,
            None => {
                let packing = Packing::from_name(chunk.compression).unwrap_or(Packing::Zstd);
                self.writer.chunk(&kept, packing)?;
            }
        }
        self.kept = kept;
        self.kept.clear();
        Ok(())
    }

    fn record(&mut self, opcode: u8, body: &[u8], _: bool) -> Result<(), ContainerError> {
        self.kept.clear();
        self.keep(opcode, body)?;
        self.write_loose()
    }

    fn attachment(&mut self, source: &mut Source<'_>, head: Head) -> Result<(), ContainerError> {
        pass_attachment(source, head, &mut self.writer)
    }

    /// They are known from the survey.
    fn in_summary(&mut self, _opcode: u8, _body: &[u8]) {}

    fn summary_ends(&mut self, _: Sum, stated_messages: Option<u64>) {
        if let Some(stated) = stated_messages {
            *self.report.stated_messages.get_or_insert(0) += stated;
        }
    }

    fn damage(&mut self, damage: Damage) {
        match damage {
            Damage::Lost(loss) => self.lose(loss),
            Damage::Mended(offset, what) => {
                self.report.mended.insert(offset, what.to_owned());
            }
            Damage::Unchecked => self.report.unchecked = true,
            Damage::Repaired(what) => {
                self.report.repaired.insert(what);
            }
            Damage::Unfinished => self.report.unfinished = true,
        }
    }
}

impl Keeper<'_> {
    fn lose(&mut self, loss: Loss) {
        if loss.span.is_none() && self.report.has_room() {
            self.without_span.push(self.report.losses.len());
        }
        self.report.lose(loss);
    }
}
