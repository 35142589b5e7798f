//! The records of an MCAP file, with what is wrong with one as an error of this crate.

mod leading;

use inhand_container::{ContainerError, Record};
pub(crate) use inhand_container::{Depth, is_mcap, walk_in_place};

use crate::error::ChannelError;
pub use leading::read_leading_metadata;

/// As [`inhand_container::walk`].
pub(crate) fn walk(
    file: &str,
    bytes: &[u8],
    depth: Depth,
    visit: impl FnMut(Record<'_>) -> Result<(), ChannelError>,
) -> Result<(), ChannelError> {
    inhand_container::walk(file, bytes, depth, visit)
}

/// As [`inhand_container::walk_while`].
pub(crate) fn walk_while(
    file: &str,
    bytes: &[u8],
    visit: impl FnMut(Record<'_>) -> Result<Depth, ChannelError>,
) -> Result<(), ChannelError> {
    inhand_container::walk_while(file, bytes, visit)
}

impl From<ContainerError> for ChannelError {
    fn from(error: ContainerError) -> Self {
        match error {
            ContainerError::NotMcap { file, found } => ChannelError::NotMcap { file, found },
            ContainerError::Truncated {
                file,
                offset,
                record,
                expected,
                found,
            } => ChannelError::Truncated {
                file,
                offset,
                record,
                expected,
                found,
            },
            ContainerError::Damaged {
                file,
                offset,
                record,
                expected,
                found,
            } => ChannelError::Damaged {
                file,
                offset,
                record,
                expected,
                found,
            },
            ContainerError::Write { source } => ChannelError::Write { source },
            other => ChannelError::Container {
                source: Box::new(other),
            },
        }
    }
}
