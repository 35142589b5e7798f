//! The views of a take alone, for a file that has the rest.

use std::collections::BTreeMap;
use std::io::Write;

use foxglove::messages::FrameTransforms;
use inhand_container::ChannelFacts;
use inhand_model::{Frame, World};
use nalgebra::Isometry3;

use super::check;
use crate::error::ChannelError;
use crate::metadata::Metadata;
use crate::outline::Outline;
use crate::output::PACKED;
use crate::streams::Streams;
use crate::take::TakeFile;
use crate::topic;
use crate::view::{UPRIGHT, draw_take, transform};

/// Owner of the file that the views of a take are for.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum ViewsFor {
    /// A take that inhand wrote: the tree of frames is on `/tf` and `/tf_static`.
    #[default]
    Take,
    /// A third-party recording, which may have a tree of frames of its own: that of the views is on `/view/tf` and
    /// `/view/tf_static`, and the roots of their trees are placed in its `world`.
    ThirdParty {
        /// Poses of the roots: `world_from_root`, metres.
        roots: BTreeMap<String, Isometry3<f64>>,
    },
}

/// Selects the channels that inhand added for viewers: without them the file has the same data.
/// `dictionary` tells whether the file is one.
pub fn view_channels(
    metadata: &Metadata,
    dictionary: bool,
) -> impl Fn(&ChannelFacts) -> bool + use<> {
    let tree = dictionary || metadata.is_take();
    let ours = tree || metadata.has_added_views();
    move |channel: &ChannelFacts| {
        let shown = channel.topic.starts_with(topic::VIEW)
            || tree && [topic::TF, topic::TF_STATIC].contains(&channel.topic.as_str());
        let foxglove = (channel.schema_name()).is_some_and(|s| s.starts_with("foxglove."));
        ours && shown && foxglove && channel.message_encoding == "protobuf"
    }
}

/// Writes the views of a take as an MCAP file of its own: the same messages that
/// [`write_take`](crate::write_take) adds to the rest.
///
/// # Errors
///
/// As for [`write_take`](crate::write_take).
pub fn write_views(
    mut out: impl Write,
    file: &TakeFile<'_>,
    views_for: &ViewsFor,
) -> Result<(), ChannelError> {
    let used = file.used();
    let outline = Outline::new(used);
    check::parts(file, outline.samples)?;
    let mut streams = Streams::create(&mut out, PACKED, &Metadata::default())?;
    if let ViewsFor::ThirdParty { roots } = views_for {
        streams.output.rename_topics(beside_others);
        place_roots(roots, used.clock.unix_nanos(0), &mut streams)?;
    }
    let drawn = TakeFile {
        recording: used,
        ..file.clone()
    };
    draw_take(&drawn, file.recording.clock, &outline, &mut streams)?;
    streams.write_until(u64::MAX, Some((used, 0)))?;
    streams.finish()
}

fn beside_others(ours: &str) -> &str {
    match ours {
        topic::TF => topic::VIEW_TF,
        topic::TF_STATIC => topic::VIEW_TF_STATIC,
        other => other,
    }
}

/// Places third-party trees in the world: a viewer shows nothing that no tree connects.
fn place_roots(
    roots: &BTreeMap<String, Isometry3<f64>>,
    unix_nanos: u64,
    streams: &mut Streams<'_>,
) -> Result<(), ChannelError> {
    // A frame without a name is no frame, and those of inhand have their place already.
    let ours = [World::NAME, UPRIGHT];
    let named = |root: &str| !root.is_empty() && !ours.contains(&root);
    let transforms: Vec<_> = (roots.iter().filter(|(root, _)| named(root)))
        .map(|(root, &world_from_root)| transform(World::NAME, root, world_from_root, unix_nanos))
        .collect();
    if transforms.is_empty() {
        return Ok(());
    }
    let message = FrameTransforms { transforms };
    streams.once(topic::VIEW_FRAMES, None, unix_nanos, &message)
}
