//! Topics, in one place.
//!
//! | root | topics of a method or a layer |
//! | --- | --- |
//! | `/generated/<method>` | `fingertips`, `plan` |
//! | `/held_out/<method>` | the same, planned under the held-out protocol |
//! | `/evaluation/<method>` | `error`, `contact` |
//! | `/view/generated/<method>` | `fingertips`, `fingertips_scene`, `contacts`; of a plan without a recording `path_points` |
//! | `/overlay/<layer>` | `fingertips`, `distance` |
//! | `/view/overlay/<layer>` | `fingertips`, `fingertip_balls`, `fingertips_scene`, `trails`, `tf`, `object`, `object_edges` |

use inhand_model::Protocol;

use crate::error::{ChannelError, ensure};

pub(crate) const ANNOTATIONS: &str = "/annotations";
pub(crate) const RECORDING_FINGERTIPS: &str = "/recording/fingertips";
pub(crate) const RECORDING_BODIES: &str = "/recording/bodies";
pub(crate) const RECORDING_MARKERS: &str = "/recording/markers";
pub(crate) const RECORDING_FINDINGS: &str = "/recording/findings";
pub(crate) const CLEANED_MARKERS: &str = "/cleaned/markers";
pub(crate) const CLEANED_BODIES: &str = "/cleaned/bodies";
pub(crate) const CLEANED_CHANGES: &str = "/cleaned/changes";
pub(crate) const PROCESSED_FINGERTIPS: &str = "/processed/fingertips";
pub(crate) const PROCESSED_OBJECT: &str = "/processed/object";
pub(crate) const PROCESSED_HAND: &str = "/processed/hand";
pub(crate) const DICTIONARY: &str = "/dictionary/model";
pub(crate) const DICTIONARY_PRIMITIVES: &str = "/dictionary/primitives";
pub(crate) const TF: &str = "/tf";
pub(crate) const TF_STATIC: &str = "/tf_static";
/// Prefix of all topics that only viewers need.
pub const VIEW: &str = "/view/";
/// The tree of frames in third-party files, which may have one of their own.
pub(crate) const VIEW_TF: &str = "/view/tf";
pub(crate) const VIEW_TF_STATIC: &str = "/view/tf_static";
/// Places third-party frames in the tree.
pub(crate) const VIEW_FRAMES: &str = "/view/frames";
pub(crate) const VIEW_MARKERS: &str = "/view/markers";
pub(crate) const VIEW_BODIES: &str = "/view/bodies";
pub(crate) const VIEW_FINGERTIPS: &str = "/view/fingertips";
pub(crate) const VIEW_FINGERTIPS_SCENE: &str = "/view/fingertips_scene";
pub(crate) const VIEW_OBJECT: &str = "/view/object";
pub(crate) const VIEW_CONTACTS: &str = "/view/contacts";
pub(crate) const VIEW_OBJECT_SURFACE: &str = "/view/object_surface";
pub(crate) const VIEW_TAKE_HULLS: &str = "/view/hulls";
pub(crate) const VIEW_LOG: &str = "/view/log";
pub(crate) const DICTIONARY_PROFILE: &str = "/dictionary/profile";
pub(crate) const VIEW_PRIMITIVES_SCENE: &str = "/view/dictionary/primitives_scene";
pub(crate) const VIEW_PATH_POINTS: &str = "/view/dictionary/path_points";
pub(crate) const VIEW_PATHS: &str = "/view/dictionary/paths";
pub(crate) const VIEW_OBJECT_EDGES: &str = "/view/object_edges";
pub(crate) const VIEW_PRIMITIVES: &str = "/view/dictionary/primitives";
pub(crate) const VIEW_HULLS: &str = "/view/dictionary/hulls";
pub(crate) const VIEW_HULL_POINTS: &str = "/view/dictionary/hull_points";

pub(crate) const VIEW_LEGEND: &str = "/view/overlay/legend";

// Roots of topics that have the name of a method or of a layer of an overlay as their next part.
pub(crate) const GENERATED: &str = "/generated";
pub(crate) const HELD_OUT: &str = "/held_out";
pub(crate) const EVALUATION: &str = "/evaluation";
pub(crate) const VIEW_GENERATED: &str = "/view/generated";
pub(crate) const OVERLAY: &str = "/overlay";
pub(crate) const VIEW_OVERLAY: &str = "/view/overlay";

/// Root of the topics of motion that methods generated under a protocol.
pub(crate) const fn generated(protocol: Protocol) -> &'static str {
    match protocol {
        Protocol::Published => GENERATED,
        Protocol::HeldOut => HELD_OUT,
    }
}

/// The topic of a method or a layer under one of the roots.
pub(crate) fn named(root: &str, name: &str, leaf: &str) -> String {
    format!("{root}/{name}/{leaf}")
}

/// Whether a topic can have this name as a part.
pub(crate) fn fits_topic(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_' || c == '-'
}

/// Refuses a name that would break topics.
pub(crate) fn check_name(what: &str, name: &str) -> Result<(), ChannelError> {
    let fits = !name.is_empty() && name.chars().all(fits_topic);
    let expected = "letters, digits, '_' and '-', as it becomes part of a topic";
    ensure(fits, what, expected, format!("\"{name}\""))
}

/// The topic of the fingertips that a method planned.
pub fn planned_fingertips_topic(method: &str) -> String {
    named(GENERATED, method, "fingertips")
}
