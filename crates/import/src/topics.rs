//! Settings and names of third-party topics.

use std::collections::BTreeMap;
use std::str::FromStr;

use inhand_model::{LengthUnit, UpAxis};
use thiserror::Error;

/// Facts that a file leaves open and the user may state.
#[derive(Clone, Debug)]
pub struct ImportSettings {
    /// Uses of topics, by topic, or by `topic#name` for one of several things on a topic: a
    /// marker, a rigid body, a child frame, or the place or number of one without a name. The more
    /// exact key counts.
    pub topics: BTreeMap<String, TopicUse>,
    /// Unit of lengths; metres where it is not given, as ROS and Foxglove have it.
    pub length_unit: Option<LengthUnit>,
    /// Axis that points up; z where it is not given, as ROS has it.
    pub up_axis: Option<UpAxis>,
    /// Samples per second, where the stamps do not prove a rate.
    pub rate_hz: Option<f64>,
    /// Whether a pose of that name serves as a marker too, as one called like a fingertip does.
    pub is_point: fn(&str) -> bool,
}

impl Default for ImportSettings {
    fn default() -> Self {
        Self {
            topics: BTreeMap::new(),
            length_unit: None,
            up_axis: None,
            rate_hz: None,
            is_point: |_| false,
        }
    }
}

/// Use of a topic, as users write it: `ignore`, `body`, `marker`, `body:Hand`,
/// `marker:Thumb,Index,Middle` (names by place in the message).
///
/// ```
/// use inhand_import::TopicUse;
///
/// assert_eq!("body:Hand".parse(), Ok(TopicUse::Body(vec!["Hand".to_owned()])));
/// assert_eq!("marker".parse(), Ok(TopicUse::Marker(vec![])));
/// assert!("cheese".parse::<TopicUse>().is_err());
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TopicUse {
    /// It is not read.
    Ignore,
    /// Rigid bodies of these names, by place in the message; without names those of the source.
    Body(Vec<String>),
    /// Markers of these names, by place in the message; without names those of the source.
    Marker(Vec<String>),
}

/// A word that says nothing about a topic.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("\"{text}\": expected ignore, body, marker, body:NAME or marker:NAME[,NAME...]")]
pub struct TopicUseError {
    /// The word.
    pub text: String,
}

impl FromStr for TopicUse {
    type Err = TopicUseError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let error = || TopicUseError {
            text: text.to_owned(),
        };
        let (word, names) = match text.split_once(':') {
            None => (text.trim(), Vec::new()),
            Some((word, names)) => {
                let names: Vec<String> = names.split(',').map(|n| n.trim().to_owned()).collect();
                if names.iter().any(String::is_empty) {
                    return Err(error());
                }
                (word.trim(), names)
            }
        };
        match word {
            "ignore" if names.is_empty() => Ok(TopicUse::Ignore),
            "body" => Ok(TopicUse::Body(names)),
            "marker" => Ok(TopicUse::Marker(names)),
            _ => Err(error()),
        }
    }
}

impl TopicUse {
    /// Names given to the things on the topic, by place in a message.
    pub(crate) fn names(&self) -> &[String] {
        match self {
            TopicUse::Ignore => &[],
            TopicUse::Body(names) | TopicUse::Marker(names) => names,
        }
    }
}

/// Last parts of topics that say what is sent and not whose it is.
const GENERIC_PARTS: [&str; 7] = [
    "pose",
    "poses",
    "pose_stamped",
    "point",
    "position",
    "transform",
    "tf",
];

/// The name of the one thing on a topic: `/natnet_ros/Hand/pose` is `Hand`,
/// `/natnet_ros/Hand/marker0/pose` is `Hand:marker0`.
pub(crate) fn name_of_topic(topic: &str) -> String {
    let mut parts: Vec<&str> = topic.split('/').filter(|part| !part.is_empty()).collect();
    while parts.len() > 1
        && (parts.last()).is_some_and(|last| GENERIC_PARTS.contains(&last.to_lowercase().as_str()))
    {
        parts.pop();
    }
    match parts[..] {
        [] => topic.to_owned(),
        [.., body, marker] if is_numbered_marker(marker) => format!("{body}:{marker}"),
        [.., name] => name.to_owned(),
    }
}

fn is_numbered_marker(part: &str) -> bool {
    let number = part.to_lowercase();
    let number = number.strip_prefix("marker").map(|n| n.trim_matches('_'));
    number.is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_of_drivers_say_whose_pose_they_carry() {
        for (topic, name) in [
            ("/natnet_ros/Hand/pose", "Hand"),
            ("/natnet_ros/Hand/marker0/pose", "Hand:marker0"),
            ("/vrpn_mocap/right_hand/pose", "right_hand"),
            ("/mocap/rigid_bodies/Cube/pose", "Cube"),
            ("/vicon/Hand/Hand", "Hand"),
            ("Hand", "Hand"),
            ("/pose", "pose"),
            ("/Hand/pose_stamped", "Hand"),
            ("/marker3", "marker3"),
            ("/", "/"),
        ] {
            assert_eq!(name_of_topic(topic), name, "{topic}");
        }
    }

    #[test]
    fn uses_are_read_and_what_is_none_is_refused() {
        let names = |names: &[&str]| names.iter().map(|&n| n.to_owned()).collect();
        for (text, expected) in [
            ("ignore", TopicUse::Ignore),
            ("body", TopicUse::Body(vec![])),
            (" marker : a, b ", TopicUse::Marker(names(&["a", "b"]))),
        ] {
            assert_eq!(text.parse(), Ok(expected), "{text}");
        }
        for text in ["", "Body", "body:", "marker:a,,b", "ignore:x", "bodies"] {
            assert!(text.parse::<TopicUse>().is_err(), "{text}");
        }
    }
}
