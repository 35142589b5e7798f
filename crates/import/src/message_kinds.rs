//! Search among the message kinds that can be read.

use crate::reading::MessageKind;
use crate::{foxglove, ros};

/// The kind of a channel, by the name of its schema and its encoding.
pub(crate) fn find_kind(schema: &str, encoding: &str) -> Option<&'static MessageKind> {
    let name = schema.replacen("/msg/", "/", 1);
    let mut kinds = (ros::PACKAGES.iter().copied().chain([foxglove::KINDS])).flatten();
    kinds.find(|kind| kind.encoding == encoding && kind.schemas.contains(&name.as_str()))
}
