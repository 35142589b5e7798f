//! Search among the message kinds that can be read.

use crate::reading::MessageKind;
use crate::{foxglove, ros};

/// The kind of a channel, by the name of its schema and its encoding.
pub(crate) fn find_kind(schema: &str, encoding: &str) -> Option<&'static MessageKind> {
    kinds_of(schema).find(|kind| kind.encodings.contains(&encoding))
}

/// The kinds of a schema in every encoding.
pub(crate) fn kinds_of(schema: &str) -> impl Iterator<Item = &'static MessageKind> {
    let name = schema.replacen("/msg/", "/", 1);
    let kinds = (ros::PACKAGES.iter().copied().chain([foxglove::KINDS])).flatten();
    kinds.filter(move |kind| kind.schemas.contains(&name.as_str()))
}
