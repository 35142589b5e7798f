//! First pass: the definitions that a damaged file holds anywhere.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

use mcap::records::op;

use super::probe::Known;
use super::scan::{Damage, FoundChunk, Kind, Sum, Visitor};
use crate::error::ContainerError;
use crate::fields::parse_record;
use crate::format::{MessageFacts, Records, id_of, spanned};
use crate::source::{Head, Source};

/// How far a definition is to be trusted; of contradicting ones the best count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Trust {
    /// From a chunk whose checksum differs, or a record that does not end where it says.
    Damaged,
    /// From a summary whose checksum differs or is lost.
    Doubtful,
    /// From bytes without a checksum.
    Unchecked,
    /// Covered by a checksum.
    Checked,
}

/// Messages may be this much earlier or later than all others, nanoseconds.
const MARGIN: u64 = 3_600_000_000_000;

/// A schema or channel of a file: which one of joined ones, opcode, id.
type Key = (usize, u8, u16);

struct Definition {
    body: Arc<[u8]>,
    trust: Trust,
    /// How often it was found.
    times: usize,
}

impl Definition {
    /// What decides between contradicting ones: trust, and without a checksum how often it was found.
    fn rank(&self) -> (Trust, usize) {
        match self.trust {
            Trust::Checked => (Trust::Checked, 0),
            trust => (trust, self.times),
        }
    }
}

/// The definitions of an id, each once, in the order of the file.
#[derive(Default)]
struct Definitions {
    all: Vec<Definition>,
    places: HashMap<Arc<[u8]>, usize>,
    /// The highest rank, and how many have it.
    best: Option<((Trust, usize), usize)>,
}

impl Definitions {
    /// Notes that a definition was found; its rank never falls.
    fn add(&mut self, trust: Trust, body: &[u8]) {
        let place = self.places.get(body).copied().unwrap_or_else(|| {
            let body: Arc<[u8]> = body.into();
            self.places.insert(Arc::clone(&body), self.all.len());
            self.all.push(Definition {
                body,
                trust,
                times: 0,
            });
            self.all.len() - 1
        });
        let definition = &mut self.all[place];
        definition.trust = trust.max(definition.trust);
        definition.times += 1;
        let rank = definition.rank();
        self.best = match self.best {
            Some((best, _)) if best > rank => self.best,
            Some((best, number)) if best == rank => Some((best, number + 1)),
            _ => Some((rank, 1)),
        };
    }

    fn is_best(&self, definition: &Definition) -> bool {
        self.best.is_some_and(|(best, _)| best == definition.rank())
    }

    /// Those that count.
    fn best(&self) -> impl Iterator<Item = (Trust, &[u8])> {
        let best = self.all.iter().filter(|one| self.is_best(one));
        best.map(|one| (one.trust, &one.body[..]))
    }
}

/// What the first pass learns.
#[derive(Default)]
pub(super) struct Survey {
    /// Number of the file at hand, of several that were joined.
    file: usize,
    definitions: BTreeMap<Key, Definitions>,
    /// Opcodes and bodies of those met since the data of the file at hand ended.
    in_summary: Vec<(u8, Vec<u8>)>,
    channels: BTreeSet<u16>,
    /// Whether some of them were met behind all messages, which were not recognised as such then.
    has_late_channels: bool,
    /// Log times of messages.
    span: Option<(u64, u64)>,
    pub(super) unchecked: bool,
    is_damaged: bool,
    messages: u64,
    stated_messages: Option<u64>,
    records: u64,
}

impl Survey {
    /// Whether every record follows the one before and the checksums and counts that there are hold.
    pub(super) fn is_sound(&self) -> bool {
        let counted = self.stated_messages.is_none_or(|n| n == self.messages);
        !self.is_damaged && !self.unchecked && counted
    }

    /// A survey to be made again with the channels that this one found too late.
    pub(super) fn again(&self) -> Option<Self> {
        (self.has_late_channels && !self.is_sound()).then(|| Self {
            channels: self.channels.clone(),
            ..Self::default()
        })
    }

    /// Whether there is anything of an MCAP file.
    pub(super) fn is_empty(&self) -> bool {
        self.records == 0
    }

    /// Whether definitions of an id contradict each other and no checksum says which is right.
    pub(super) fn is_disputed(&self, file: usize, opcode: u8, id: u16) -> bool {
        let all = self.definitions.get(&(file, opcode, id));
        let best = all.and_then(|all| all.best);
        best.is_some_and(|((trust, _), number)| trust < Trust::Checked && number > 1)
    }

    /// Whether a definition counts, or a more trustworthy one says otherwise.
    pub(super) fn counts(&self, file: usize, opcode: u8, body: &[u8]) -> bool {
        let key = id_of(body).map(|id| (file, opcode, id));
        let all = key.and_then(|key| self.definitions.get(&key));
        all.is_some_and(|all| {
            let place = all.places.get(body);
            place.is_some_and(|&place| all.is_best(&all.all[place]))
        })
    }

    /// The first definition of an id that counts, in any of joined files where its own has none.
    pub(super) fn first(&self, file: usize, opcode: u8, id: u16) -> Option<(Trust, &[u8])> {
        let files = std::iter::once(file).chain(0..=self.file);
        let all = files.filter_map(|file| self.definitions.get(&(file, opcode, id)));
        all.flat_map(Definitions::best).next()
    }

    /// All definitions that count, schemas first, each with its file.
    pub(super) fn all(&self) -> impl Iterator<Item = (usize, u8, Trust, &[u8])> {
        (self.definitions.iter()).flat_map(|(&(file, opcode, _), all)| {
            let best = all.best();
            best.map(move |(trust, body)| (file, opcode, trust, body))
        })
    }

    fn define(&mut self, trust: Trust, opcode: u8, body: &[u8]) -> Option<()> {
        parse_record(opcode, body).ok()?;
        let key = (self.file, opcode, id_of(body)?);
        if opcode == op::CHANNEL {
            self.channels.insert(key.2);
        }
        self.definitions.entry(key).or_default().add(trust, body);
        Some(())
    }

    fn message(&mut self, body: &[u8]) {
        self.messages += 1;
        if let Some(message) = MessageFacts::read(body) {
            self.span = Some(spanned(self.span, message.log_time));
        }
    }
}

impl Known for Survey {
    fn knows(&self, message: MessageFacts) -> bool {
        self.channels.contains(&message.channel)
    }

    fn spans(&self, message: MessageFacts) -> Option<bool> {
        self.span.map(|(start, end)| {
            (start.saturating_sub(MARGIN)..=end.saturating_add(MARGIN)).contains(&message.log_time)
        })
    }
}

impl Visitor for Survey {
    fn file(&mut self, number: usize, _header: Option<&[u8]>) -> Result<(), ContainerError> {
        self.file = number;
        self.records += 1;
        Ok(())
    }

    fn chunk(&mut self, chunk: &FoundChunk<'_>, records: &[u8]) -> Result<(), ContainerError> {
        self.records += 1;
        let trust = match chunk.kind {
            Kind::Checked => Trust::Checked,
            Kind::Unchecked | Kind::Open => Trust::Unchecked,
            Kind::Damaged => Trust::Damaged,
        };
        for (opcode, body) in Records(records).flatten() {
            match opcode {
                op::SCHEMA | op::CHANNEL => {
                    self.define(trust, opcode, body);
                }
                op::MESSAGE if trust > Trust::Damaged => self.message(body),
                _ => {}
            }
        }
        Ok(())
    }

    fn record(&mut self, opcode: u8, body: &[u8], is_whole: bool) -> Result<(), ContainerError> {
        let trust = match is_whole {
            true => Trust::Unchecked,
            false => Trust::Damaged,
        };
        match opcode {
            op::SCHEMA | op::CHANNEL => {
                self.define(trust, opcode, body);
            }
            op::MESSAGE => self.message(body),
            _ => {}
        }
        self.records += u64::from(opcode < 0x80);
        Ok(())
    }

    fn attachment(&mut self, _: &mut Source<'_>, _: Head) -> Result<(), ContainerError> {
        self.records += 1;
        Ok(())
    }

    fn in_summary(&mut self, opcode: u8, body: &[u8]) {
        if let (op::CHANNEL, Some(id)) = (opcode, id_of(body)) {
            self.has_late_channels |= self.channels.insert(id);
        }
        self.in_summary.push((opcode, body.to_vec()));
        self.records += 1;
    }

    fn summary_ends(&mut self, sum: Sum, stated_messages: Option<u64>) {
        let trust = match sum {
            Sum::Holds => Trust::Checked,
            Sum::Absent => Trust::Unchecked,
            Sum::Differs => Trust::Doubtful,
        };
        for (opcode, body) in std::mem::take(&mut self.in_summary) {
            self.define(trust, opcode, &body);
        }
        if let Some(stated) = stated_messages {
            *self.stated_messages.get_or_insert(0) += stated;
        }
    }

    fn damage(&mut self, damage: Damage) {
        match damage {
            Damage::Repaired(_) => {}
            Damage::Unchecked => self.unchecked = true,
            _ => self.is_damaged = true,
        }
    }
}
