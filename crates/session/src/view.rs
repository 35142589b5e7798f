//! View channels for files that are there already.

use std::io::Cursor;
use std::path::Path;

use inhand_channels::{
    ChannelError, GeneratedMethod, Metadata, RECORDED, StoredMethod, TakeFile, Views,
};
use inhand_container::{ChannelFacts, MetadataRecord, Selection, Source};
use inhand_model::{Finding, Hull, InputHash, PerFinger, Protocol};

use crate::dictionary_file::DictionaryFile;
use crate::error::{Located, SessionError};
use crate::files::{FileSource, filter, hash_file, name_of, open_take, refuse_folder};
use crate::ros2;
use crate::settings::Settings;
use crate::take_file::recorded_contacts;

/// Topic of a dictionary's own message.
const DICTIONARY: &str = "/dictionary/model";

/// Topic of the training hulls, which are in no other channel of a take.
const HULLS: &str = "/view/hulls";

/// What kind of file was given views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ViewedKind {
    /// A take of ours.
    Take,
    /// A third-party recording.
    Foreign,
    /// A dictionary.
    Dictionary,
}

/// What was done to a file.
#[derive(Clone, Debug)]
pub struct Viewed {
    /// What kind of file it is.
    pub kind: ViewedKind,
    /// The topic of the views of a ROS 2 bag, which are `visualization_msgs/msg/MarkerArray`.
    pub ros2_topic: Option<&'static str>,
    /// Messages of earlier views that were taken out.
    pub replaced: u64,
    /// Messages for viewers that the output has.
    pub messages: u64,
    /// What was odd about the file.
    pub findings: Vec<Finding>,
}

/// Writes `input` with the channels that viewers draw: those that the step which made it would have
/// written, or those of more or none of the methods. Views of an earlier version are taken out first; every other record stays byte for byte.
/// A step `view` is added to the provenance. Training hulls are drawn if the `dictionary` is given that was
/// learned there; those that the file has stay otherwise.
///
/// Memory is taken for the take in the file and for the packed views.
///
/// # Errors
///
/// [`SessionError::Data`] for a file that is no MCAP; [`SessionError::At`] for one without
/// motion that can be read; what reading and writing can find.
pub fn add_views(
    input: &Path,
    output: &Path,
    dictionary: Option<&DictionaryFile>,
    views: Views,
    settings: &Settings,
) -> Result<Viewed, SessionError> {
    refuse_folder(input)?;
    let name = name_of(input);
    let Some(source) = open_take(input, &name)? else {
        return Err(SessionError::data(
            input,
            "not an MCAP file: views are channels of one; `inhand convert` makes one of a \
                      take, with views",
        ));
    };
    let mut file = File::of(input, source)?;
    let kind = file.kind;
    let hulls = dictionary.map(|dictionary| &dictionary.dictionary.demonstrated.hulls);
    let (added, findings) = match kind {
        _ if views == Views::None => Default::default(),
        ViewedKind::Dictionary => (file.dictionary_views().in_file(input)?, Vec::new()),
        ViewedKind::Take | ViewedKind::Foreign => file.take_views(hulls, views, settings)?,
    };
    let of_dictionary = dictionary.map(|dictionary| dictionary.hash.clone());
    let made = crate::run::provenance(
        "view",
        settings,
        [file.hash.clone()].into_iter().chain(of_dictionary),
    );
    let is_view = file.is_view();
    let keeps_hulls = kind == ViewedKind::Take && hulls.is_none() && views != Views::None;
    let stays =
        |channel: &ChannelFacts| !is_view(channel) || (keeps_hulls && channel.topic == HULLS);
    let step = file.metadata.next_provenance(&made).0.into_iter();
    let selection = Selection {
        channels: Some(&stays),
        add: step
            .map(|(name, facts)| MetadataRecord { name, facts })
            .collect(),
        append: (views != Views::None).then_some(&*added),
        ..Selection::default()
    };
    let selected = filter(input, output, &selection)?;
    Ok(Viewed {
        kind,
        ros2_topic: file.ros2.then_some(ros2::VIEW_MARKERS),
        replaced: selected.left_out,
        messages: selected.appended,
        findings,
    })
}

/// The file as it is.
struct File<'a> {
    path: &'a Path,
    source: FileSource,
    name: String,
    hash: InputHash,
    kind: ViewedKind,
    /// Whether it is a third-party bag of ROS 2.
    ros2: bool,
    metadata: Metadata,
}

impl<'a> File<'a> {
    fn of(path: &'a Path, mut source: FileSource) -> Result<Self, SessionError> {
        let metadata = inhand_channels::metadata_of_source(&mut source).in_file(path)?;
        let channels = inhand_container::channels(&mut source);
        let kind = if metadata.is_take() {
            ViewedKind::Take
        } else if (channels.in_file(path)?.iter()).any(|c| c.topic == DICTIONARY) {
            ViewedKind::Dictionary
        } else {
            ViewedKind::Foreign
        };
        let is_bag = inhand_channels::is_ros2(&mut source).in_file(path)?;
        Ok(Self {
            path,
            source,
            name: name_of(path),
            hash: hash_file(path)?,
            kind,
            ros2: kind == ViewedKind::Foreign && is_bag,
            metadata,
        })
    }

    /// Which channels only show what others hold.
    fn is_view(&self) -> impl Fn(&ChannelFacts) -> bool + use<> {
        let dictionary = self.kind == ViewedKind::Dictionary;
        inhand_channels::view_channels(&self.metadata, dictionary)
    }

    /// The views of a dictionary alone: its file is small, and is its views for the greater part.
    fn dictionary_views(&mut self) -> Result<Vec<u8>, ChannelError> {
        let (dictionary, _) = inhand_channels::dictionary_of_source(&mut self.source)?;
        let (mut whole, mut views) = (Vec::new(), Vec::new());
        inhand_channels::write_dictionary(&mut whole, &dictionary, &[])?;
        let selection = Selection {
            channels: Some(&self.is_view()),
            ..Selection::default()
        };
        let mut source = Source::open(&self.name, Cursor::new(whole))?;
        inhand_container::select(&mut source, &mut views, &selection)?;
        Ok(views)
    }

    /// The views of a take alone, and what was odd about a third-party recording.
    fn take_views(
        &mut self,
        hulls: Option<&PerFinger<Hull>>,
        views: Views,
        settings: &Settings,
    ) -> Result<(Vec<u8>, Vec<Finding>), SessionError> {
        let take = crate::take::read(self.path, settings)?;
        let (mut methods, mut evaluated, mut stated) = (Vec::new(), Vec::new(), None);
        let shape = settings.shape()?;
        if self.kind == ViewedKind::Take {
            let clock = take.recording.clock;
            let source = &mut self.source;
            let read = inhand_channels::generated_of_source(source, Protocol::Published);
            let read = read.in_file(self.path)?.into_iter();
            methods.extend(read.map(|method| StoredMethod::new(method, clock)));
            let read = inhand_channels::evaluated_of_source(source);
            evaluated = read.in_file(self.path)?;
            stated = self.metadata.shape(&self.name).in_file(self.path)?;
        }
        let import = settings.import_settings()?;
        let views_for = inhand_import::views_for(&mut self.source, &import).in_file(self.path)?;
        let segments: Vec<_> = methods.iter().map(StoredMethod::segments).collect();
        let generated: Vec<_> = (methods.iter().zip(&segments))
            .map(|(method, segments)| GeneratedMethod {
                name: &method.name,
                plans: true,
                segments,
            })
            .collect();
        // Contacts were measured with the shape that the file states.
        if let (true, Some(motion)) = (shape != stated, &take.stored_motion) {
            evaluated.retain(|method| method.name != RECORDED);
            let samples = evaluated.iter_mut().flat_map(|method| &mut method.samples);
            samples.for_each(|sample| sample.contact = None);
            evaluated.push(recorded_contacts(motion, 0..motion.len(), settings)?);
        }
        let file = TakeFile {
            motion: take.stored_motion.as_ref(),
            generated: &generated,
            evaluated: &evaluated,
            object_shape: shape,
            hulls,
            annotations: None,
            ..take.file(&[])
        };
        let mut added = Vec::new();
        // ROS tools read no file of profile ros2 in which a channel is in another encoding.
        match self.ros2 {
            true => added = ros2::views(&take, file.object_shape, &views_for)?,
            false => {
                inhand_channels::write_views(&mut added, &file, views, &views_for)
                    .in_file(self.path)?;
            }
        }
        let findings = match self.kind {
            // What was odd about the source of a take of ours is in it.
            ViewedKind::Foreign => take.measured().findings.clone(),
            ViewedKind::Take | ViewedKind::Dictionary => Vec::new(),
        };
        Ok((added, findings))
    }
}
