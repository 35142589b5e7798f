//! The views of a take alone, for a file that has the rest.

use std::collections::BTreeSet;
use std::io::Write;

use foxglove::messages::{FrameTransform, FrameTransforms, Quaternion, Vector3};
use inhand_container::ChannelFacts;
use inhand_model::{Frame, World};

use super::{Streams, TakeWriter, check};
use crate::error::ChannelError;
use crate::foreign::{ForeignSettings, was_given_views, world_frames};
use crate::metadata::{Metadata, RECORDING};
use crate::outline::Outline;
use crate::output::{Output, PACKED};
use crate::read::read_metadata;
use crate::take::TakeFile;
use crate::topic;
use crate::view;
use crate::wire::viewer_time;

/// Whose file the views of a take are for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum ViewsFor {
    /// A take of ours: the tree of frames lies on `/tf` and `/tf_static`.
    #[default]
    Take,
    /// A recording of others, which may have a tree of frames of its own: ours lies on `/view/tf` and
    /// `/view/tf_static`, and the frames of theirs that coordinates stand in are placed at its `world`.
    Foreign {
        /// Those frames.
        frames: BTreeSet<String>,
    },
}

impl ViewsFor {
    /// Whose file this is.
    ///
    /// # Errors
    ///
    /// As for [`read_foreign`](crate::read_foreign).
    pub fn file(
        bytes: &[u8],
        file_name: &str,
        settings: &ForeignSettings,
    ) -> Result<Self, ChannelError> {
        if is_take(&read_metadata(bytes, file_name)?) {
            return Ok(ViewsFor::Take);
        }
        let frames = world_frames(bytes, file_name, settings)?;
        Ok(ViewsFor::Foreign { frames })
    }
}

fn is_take(metadata: &Metadata) -> bool {
    metadata.0.contains_key(RECORDING)
}

/// Which channels of a file only show what others hold, and were written by us: without them the file
/// says the same. `dictionary` says that the file is one.
pub fn view_channels(
    metadata: &Metadata,
    dictionary: bool,
) -> impl Fn(&ChannelFacts) -> bool + use<> {
    let tree = dictionary || is_take(metadata);
    let ours = tree || was_given_views(metadata);
    move |channel: &ChannelFacts| {
        let shown = channel.topic.starts_with(topic::VIEW)
            || tree && [topic::TF, topic::TF_STATIC].contains(&channel.topic.as_str());
        let foxglove = (channel.schema.as_deref()).is_some_and(|s| s.starts_with("foxglove."));
        ours && shown && foxglove && channel.message_encoding == "protobuf"
    }
}

/// Writes what viewers draw of a take as an MCAP file of its own: the very messages that
/// [`write_take`](crate::write_take) adds to the rest. `profile` is what the file says that it is.
///
/// # Errors
///
/// As for [`write_take`](crate::write_take).
pub fn write_views(
    mut out: impl Write,
    file: &TakeFile<'_>,
    views_for: &ViewsFor,
    profile: &str,
) -> Result<(), ChannelError> {
    let used = file.used();
    let outline = Outline::of(used);
    check::parts(file, outline.samples)?;
    let mut output = Output::create_of(&mut out, PACKED, profile)?;
    if let ViewsFor::Foreign { frames } = views_for {
        output.rename_topics(beside_others);
        place_frames(frames, used.clock.unix_nanos(0), &mut output)?;
    }
    let seen = TakeFile {
        recording: used,
        ..file.clone()
    };
    let mut streams = Streams::new();
    view::add_take(
        &seen,
        file.recording.clock,
        &outline,
        &mut output,
        &mut streams,
    )?;
    let mut writer = TakeWriter {
        output,
        streams,
        clock: used.clock,
        expected: outline.samples,
        written: 0,
    };
    writer.append(used)?;
    writer.finish()
}

fn beside_others(ours: &str) -> &str {
    match ours {
        topic::TF => topic::VIEW_TF,
        topic::TF_STATIC => topic::VIEW_TF_STATIC,
        other => other,
    }
}

/// Hangs frames of others at ours: a viewer shows nothing of what no tree connects.
fn place_frames(
    frames: &BTreeSet<String>,
    unix_nanos: u64,
    output: &mut Output,
) -> Result<(), ChannelError> {
    // A frame without a name is no frame, and ours needs no place in itself.
    let named = |frame: &&String| !frame.is_empty() && *frame != World::NAME;
    let transforms: Vec<_> = (frames.iter().filter(named))
        .map(|frame| FrameTransform {
            timestamp: Some(viewer_time(unix_nanos)),
            parent_frame_id: World::NAME.to_owned(),
            child_frame_id: frame.clone(),
            translation: Some(Vector3::default()),
            rotation: Some(Quaternion {
                w: 1.0,
                ..Quaternion::default()
            }),
        })
        .collect();
    if transforms.is_empty() {
        return Ok(());
    }
    let channel = output.channel::<FrameTransforms>(topic::VIEW_FRAMES, None)?;
    output.message(channel, 0, unix_nanos, &FrameTransforms { transforms })
}
