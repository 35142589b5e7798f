//! View channels for files that are there already.

mod stored;

use std::path::Path;

use inhand_channels::{GeneratedMethod, TakeFile};
use inhand_container::{ChannelFacts, Merge, MetadataRecord, Packing, Selected, Selection};
use inhand_model::{Finding, Hull, InputHash, PerFinger, Provenance};

use self::stored::StoredParts;
use crate::containers::{self, container};
use crate::dictionary_file::DictionaryFile;
use crate::error::SessionError;
use crate::output::{scratch_folder, write_atomic};
use crate::settings::Settings;
use crate::take::hex_sha256;
use crate::take_file::recorded_contacts;

/// Topic of a dictionary's own message.
const DICTIONARY: &str = "/dictionary/model";

/// What kind of file was given views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ViewedKind {
    /// A take of ours.
    Take,
    /// A recording of others.
    Foreign,
    /// A dictionary.
    Dictionary,
}

/// What was done to a file.
#[derive(Clone, Debug)]
pub struct Viewed {
    /// What kind of file it is.
    pub kind: ViewedKind,
    /// Messages of earlier views that were taken out.
    pub replaced: u64,
    /// Messages for viewers that the output has.
    pub messages: u64,
    /// What was odd about the file.
    pub findings: Vec<Finding>,
}

/// Writes `input` with the channels that viewers draw: those that the step which made it would have
/// written. Views of an earlier version are taken out first; every other record stays byte for byte.
/// A step `view` is added to the provenance. Where fingertips have been in training is drawn if the
/// `dictionary` is given that was learned there.
///
/// Memory is taken for the file's bytes and for the take in them.
///
/// # Errors
///
/// [`SessionError::Data`] for a file that is no MCAP; [`SessionError::At`] for one without
/// motion that can be read; what reading and writing can find.
pub fn add_views(
    input: &Path,
    output: &Path,
    dictionary: Option<&DictionaryFile>,
    settings: &Settings,
) -> Result<Viewed, SessionError> {
    let bytes = std::fs::read(input).map_err(SessionError::io("read", input))?;
    if !inhand_channels::is_mcap(&bytes) {
        return Err(SessionError::data(
            input,
            "not an MCAP file: views are channels of one; `inhand convert` makes one of a \
                      take, with views",
        ));
    }
    let scratch = scratch_folder(output)?;
    let [rest, views] = ["rest.mcap", "views.mcap"].map(|name| scratch.path().join(name));
    let file = File::of(input, &bytes)?;
    let kind = file.kind;
    let hulls = dictionary.map(|dictionary| &dictionary.dictionary.demonstrated.hulls);
    let findings = match kind {
        ViewedKind::Dictionary => {
            file.write_dictionary_views(&views, scratch.path())?;
            Vec::new()
        }
        ViewedKind::Take | ViewedKind::Foreign => file.write_take_views(&views, hulls, settings)?,
    };
    let of_dictionary = dictionary.map(|dictionary| dictionary.hash.clone());
    let inputs = std::iter::once(file.hash.clone()).chain(of_dictionary);
    let made = crate::run::provenance("view", settings, inputs);
    let facts = (file.library.clone(), file.packing());
    let kept = file.write_rest(&rest, &made)?;
    // Both parts are on disk and are joined chunk by chunk.
    drop(bytes);
    let all = join([&rest, &views], output, facts)?;
    Ok(Viewed {
        kind,
        replaced: kept.left_out,
        messages: all.saturating_sub(kept.written.messages),
        findings,
    })
}

/// The file as it is.
struct File<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    name: String,
    hash: InputHash,
    kind: ViewedKind,
    profile: String,
    library: String,
    metadata: inhand_channels::Metadata,
}

impl<'a> File<'a> {
    fn of(path: &'a Path, bytes: &'a [u8]) -> Result<Self, SessionError> {
        let name = containers::name_of(path);
        let info = inhand_channels::info(bytes, &name).map_err(channels(path))?;
        if let Some(problem) = info.problem {
            return Err(channels(path)(problem));
        }
        let kind = if info.metadata.0.contains_key(containers::RECORDING) {
            ViewedKind::Take
        } else if info.channels.iter().any(|c| c.topic == DICTIONARY) {
            ViewedKind::Dictionary
        } else {
            ViewedKind::Foreign
        };
        let hash = InputHash {
            name: name.clone(),
            sha256: hex_sha256(bytes),
        };
        Ok(Self {
            path,
            bytes,
            name,
            hash,
            kind,
            profile: info.profile,
            library: info.library,
            metadata: info.metadata,
        })
    }

    /// Dictionaries are kept unpacked, so that they load at once.
    fn packing(&self) -> Packing {
        match self.kind {
            ViewedKind::Dictionary => Packing::None,
            ViewedKind::Take | ViewedKind::Foreign => Packing::Zstd,
        }
    }

    /// Which channels only show what others hold.
    fn is_view(&self) -> impl Fn(&ChannelFacts) -> bool + use<> {
        let dictionary = self.kind == ViewedKind::Dictionary;
        inhand_channels::view_channels(&self.metadata, dictionary)
    }

    /// The file without views.
    fn write_rest(&self, path: &Path, made: &Provenance) -> Result<Selected, SessionError> {
        let is_view = self.is_view();
        let stays = |channel: &ChannelFacts| !is_view(channel);
        let step = self.metadata.next_provenance(made).0.into_iter();
        let selection = Selection {
            channels: Some(&stays),
            add: step
                .map(|(name, facts)| MetadataRecord { name, facts })
                .collect(),
            ..Selection::default()
        };
        containers::filter(self.path, path, &selection)
    }

    /// The views of a dictionary alone.
    fn write_dictionary_views(&self, path: &Path, scratch: &Path) -> Result<(), SessionError> {
        let (dictionary, _) = inhand_channels::read_dictionary(self.bytes, &self.name)
            .map_err(channels(self.path))?;
        // A dictionary's file is small, and is its views for the greater part.
        let whole = scratch.join("dictionary.mcap");
        crate::dictionary_file::write(&whole, &dictionary, &[])?;
        let is_view = self.is_view();
        let views = Selection {
            channels: Some(&is_view),
            metadata: false,
            ..Selection::default()
        };
        containers::filter(&whole, path, &views)?;
        Ok(())
    }

    /// The views of a take alone; gives what was odd about a recording of others.
    fn write_take_views(
        &self,
        path: &Path,
        hulls: Option<&PerFinger<Hull>>,
        settings: &Settings,
    ) -> Result<Vec<Finding>, SessionError> {
        let take = crate::take::read(self.path, settings)?;
        let parts = match self.kind {
            ViewedKind::Take => {
                let clock = take.recording.clock;
                let wrong = channels(self.path);
                StoredParts::read(self.bytes, &self.name, &self.metadata, clock, wrong)?
            }
            ViewedKind::Foreign | ViewedKind::Dictionary => StoredParts::default(),
        };
        let import = settings.import_settings()?;
        let views_for = inhand_import::views_for(self.bytes, &self.name, &import)
            .map_err(channels(self.path))?;
        let (segments, unsolved) = (parts.segments(), parts.unsolved());
        let generated: Vec<_> = (parts.generated.iter().zip(&segments).zip(&unsolved))
            .map(|((method, segments), unsolved)| GeneratedMethod {
                name: &method.name,
                segments,
                unsolved,
            })
            .collect();
        let mut evaluated = parts.evaluated.clone();
        // Nobody could say what touches an object whose shape was not known.
        if let (None, Some(motion)) = (parts.shape, &take.stored_motion) {
            evaluated.extend(recorded_contacts(motion, settings)?);
        }
        let file = TakeFile {
            cleaned: take.cleaned(),
            roles: take.roles.as_ref().ok(),
            motion: take.stored_motion.as_ref(),
            generated: &generated,
            evaluated: &evaluated,
            object_shape: parts.shape.or(settings.shape()?),
            hulls,
            ..TakeFile::new(take.measured())
        };
        write_atomic(path, |out| {
            inhand_channels::write_views(out, &file, &views_for, &self.profile)
                .map_err(channels(self.path))
        })?;
        Ok(match self.kind {
            // What was odd about the source of a take of ours is in it.
            ViewedKind::Foreign => take.measured().findings.clone(),
            ViewedKind::Take | ViewedKind::Dictionary => Vec::new(),
        })
    }
}

fn channels(path: &Path) -> impl Fn(inhand_channels::ChannelError) -> SessionError {
    let path = path.to_owned();
    move |source| SessionError::at(path.display(), source)
}

/// Both parts as one file; gives its messages.
fn join(
    parts: [&Path; 2],
    output: &Path,
    (library, packing): (String, Packing),
) -> Result<u64, SessionError> {
    let [rest, views] = parts;
    let sources = [containers::open(rest)?, containers::open(views)?].into();
    let settings = Merge {
        library: &library,
        keep_both: false,
        metadata: &|_, record| record,
        packing,
    };
    let mut messages = 0;
    write_atomic(output, |out| {
        let merged = inhand_container::merge(sources, out, &settings).map_err(container(output))?;
        messages = merged.written.messages;
        Ok(())
    })?;
    Ok(messages)
}
