//! Schema records: a message's name with the descriptors of its file and everything it imports.

use std::collections::BTreeSet;

use foxglove::messages::{Event, FrameTransforms, Log, PointCloud, SceneUpdate};
use foxglove::{Encode, Schema};
use inhand_container::SchemaFacts;
use prost::{DecodeError, Message};

use crate::messages;

/// Every file of `schemas/inhand` and every import of theirs, imports first.
const DESCRIPTORS: &[u8] = include_bytes!("generated/inhand.binpb");

/// A message that can be written to a channel.
pub(crate) trait Logged: Message + 'static {
    /// The schema record, whose `google.protobuf.FileDescriptorSet` is complete: viewers refuse one without its
    /// imports.
    fn schema() -> Schema;
}

macro_rules! ours {
    ($($message:ident in $file:literal;)*) => {$(
        impl Logged for messages::$message {
            fn schema() -> Schema {
                let descriptors = descriptors_for(concat!("inhand/", $file, ".proto"));
                let name = concat!("inhand.", stringify!($message));
                Schema::new(name, "protobuf", descriptors)
            }
        }
    )*

    /// Schemas of ours, with how their messages are decoded.
    const OURS: &[Writable] =
        &[$((messages::$message::schema, decode::<messages::$message>)),*];
    };
}

ours! {
    Fingertips in "fingertips";
    Bodies in "bodies";
    Markers in "markers";
    Change in "change";
    Plan in "plan";
    FingerErrors in "finger_errors";
    Contacts in "contacts";
    Profile in "profile";
    Dictionary in "dictionary";
}

macro_rules! viewers {
    ($($message:ident),*) => {$(
        impl Logged for $message {
            fn schema() -> Schema {
                <Self as Encode>::get_schema()
                    .expect("every message of the foxglove crate has a schema")
            }
        }
    )*

    /// The same of viewers.
    const VIEWERS: &[Writable] = &[$(($message::schema, decode::<$message>)),*];
    };
}

viewers!(Event, FrameTransforms, Log, PointCloud, SceneUpdate);

/// Decodes a message, and forgets it.
pub(crate) type Decode = fn(&[u8]) -> Result<(), DecodeError>;

/// A schema with how its messages are decoded.
type Writable = (fn() -> Schema, Decode);

fn decode<M: Logged + Default>(data: &[u8]) -> Result<(), DecodeError> {
    M::decode(data).map(drop)
}

/// A schema whose messages this crate writes.
pub(crate) enum KnownSchema {
    /// As this crate writes it.
    Same(Decode),
    /// One of ours with other descriptors: new fields are no error.
    OtherVersion(Decode),
}

impl KnownSchema {
    /// `None` for a schema of another program.
    pub(crate) fn find(schema: &SchemaFacts) -> Option<Self> {
        let find = |known: &[Writable]| {
            let known = known.iter().map(|&(own, decode)| (own(), decode));
            let mut of_name = known.filter(|(own, _)| own.name == schema.name);
            of_name
                .next()
                .map(|(own, decode)| (own.data == schema.data, decode))
        };
        match (find(OURS), find(VIEWERS)) {
            (Some((true, decode)), _) | (_, Some((true, decode))) => Some(Self::Same(decode)),
            (Some((false, decode)), _) => Some(Self::OtherVersion(decode)),
            _ => None,
        }
    }
}

/// A `FileDescriptorSet` whose files stay bytes.
#[derive(Clone, PartialEq, Message)]
struct FileSet {
    #[prost(bytes = "vec", repeated, tag = "1")]
    file: Vec<Vec<u8>>,
}

/// Name and imports of a `FileDescriptorProto`.
#[derive(Clone, PartialEq, Message)]
struct FileHead {
    #[prost(string, tag = "1")]
    name: String,
    #[prost(string, repeated, tag = "3")]
    dependency: Vec<String>,
}

/// The file and everything that it imports, directly or not, imports first.
fn descriptors_for(file: &str) -> Vec<u8> {
    let set =
        FileSet::decode(DESCRIPTORS).expect("the committed descriptors are checked by a test");
    let files: Vec<(FileHead, Vec<u8>)> = (set.file.into_iter())
        .map(|bytes| {
            let head = FileHead::decode(bytes.as_slice())
                .expect("the committed descriptors are checked by a test");
            (head, bytes)
        })
        .collect();
    // Imports come before what imports them, so one pass from the back finds all that is needed.
    let mut needed = BTreeSet::from([file]);
    for (head, _) in files.iter().rev() {
        if needed.contains(head.name.as_str()) {
            needed.extend(head.dependency.iter().map(String::as_str));
        }
    }
    let file = (files.iter())
        .filter(|(head, _)| needed.contains(head.name.as_str()))
        .map(|(_, bytes)| bytes.clone())
        .collect();
    FileSet { file }.encode_to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files_of<M: Logged>() -> Vec<String> {
        let set = FileSet::decode(&*M::schema().data).unwrap();
        set.file
            .iter()
            .map(|file| FileHead::decode(file.as_slice()).unwrap().name)
            .collect()
    }

    #[test]
    fn schemas_carry_their_imports_and_nothing_else() {
        assert_eq!(
            files_of::<messages::Markers>(),
            [
                "google/protobuf/timestamp.proto",
                "inhand/geometry.proto",
                "inhand/markers.proto"
            ]
        );
        assert_eq!(
            files_of::<messages::Dictionary>(),
            [
                "inhand/geometry.proto",
                "inhand/residual.proto",
                "inhand/dictionary.proto"
            ]
        );
        assert!(files_of::<SceneUpdate>().contains(&"google/protobuf/duration.proto".to_owned()));
        assert_eq!(messages::Plan::schema().name, "inhand.Plan");
    }
}
