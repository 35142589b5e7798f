//! Role of each topic in viewer layouts.

use inhand_model::{Frame, Hand, Object, World};

use crate::error::ChannelError;
use crate::take::RECORDED;
use crate::topic;

/// Source of the motion in a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum TopicSource<'a> {
    /// The take's motion.
    Take,
    /// The take's motion as measured, where views show the processed one.
    Measured,
    /// Motion that a method generated.
    Method(&'a str),
    /// A dictionary's primitives, one after the other.
    Dictionary,
    /// A layer of an overlay, by name.
    Overlay(&'a str),
}

/// Role of a topic for viewers. Topics are known by their pattern, whether or not a file has messages there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum TopicRole<'a> {
    /// Positions of fingertips, metres, `<finger>.position_m`.
    Positions(TopicSource<'a>),
    /// Fingertips as points.
    Tips(TopicSource<'a>),
    /// Fingertips as spheres with trails.
    TipScene(TopicSource<'a>),
    /// Fingertips that touch the object, as points.
    Touching(TopicSource<'a>),
    /// Hulls of fingertips, as outlines or solids.
    Hulls(TopicSource<'a>),
    /// Paths of whole primitives.
    Paths,
    /// Points instead of a scene, for viewers without scenes.
    Points,
    /// The object as a solid.
    Solid,
    /// The object's edges as points.
    Edges,
    /// The object's surface as points.
    Surface,
    /// All markers as points.
    Markers,
    /// All rigid bodies as points.
    Bodies,
    /// Errors of a method, metres, `<finger>_m`.
    Error(&'a str),
    /// Distances to the object and contacts, `<finger>_distance_m`, `count`.
    Contact(&'a str),
    /// Distances of an overlay from the first take, metres, `<finger>_m`.
    Distance(&'a str),
    /// Distances of a primitive from the mean motion, metres, `<finger>_m`, and its number,
    /// `primitive`.
    Profile,
    /// Findings about a take.
    Findings,
    /// Events.
    Events,
    /// Anything else that viewers draw.
    View,
    /// Data that viewers do not draw.
    Data,
}

impl<'a> TopicRole<'a> {
    /// The role of a topic; `None` for one that inhand does not write.
    pub fn from_topic(topic: &'a str) -> Option<Self> {
        Some(match topic {
            topic::PROCESSED_FINGERTIPS => TopicRole::Positions(TopicSource::Take),
            topic::RECORDING_FINGERTIPS => TopicRole::Positions(TopicSource::Measured),
            topic::DICTIONARY_PRIMITIVES => TopicRole::Positions(TopicSource::Dictionary),
            topic::RECORDING_FINDINGS => TopicRole::Findings,
            topic::ANNOTATIONS => TopicRole::Events,
            topic::VIEW_FINGERTIPS => TopicRole::Tips(TopicSource::Take),
            topic::VIEW_FINGERTIPS_SCENE => TopicRole::TipScene(TopicSource::Take),
            topic::VIEW_OBJECT => TopicRole::Solid,
            topic::VIEW_OBJECT_EDGES => TopicRole::Edges,
            topic::VIEW_MARKERS => TopicRole::Markers,
            topic::VIEW_BODIES => TopicRole::Bodies,
            topic::VIEW_PRIMITIVES => TopicRole::Tips(TopicSource::Dictionary),
            topic::VIEW_PRIMITIVES_SCENE => TopicRole::TipScene(TopicSource::Dictionary),
            topic::VIEW_PATH_POINTS | topic::VIEW_HULL_POINTS => TopicRole::Points,
            topic::VIEW_CONTACTS => TopicRole::Touching(TopicSource::Take),
            topic::VIEW_TAKE_HULLS => TopicRole::Hulls(TopicSource::Take),
            topic::VIEW_OBJECT_SURFACE => TopicRole::Surface,
            topic::VIEW_PATHS => TopicRole::Paths,
            topic::VIEW_HULLS => TopicRole::Hulls(TopicSource::Dictionary),
            _ => return Self::of_segments(topic),
        })
    }

    /// Topics of methods and of overlays.
    fn of_segments(topic: &'a str) -> Option<Self> {
        let segments: Vec<&str> = topic.strip_prefix('/')?.split('/').collect();
        Some(match segments[..] {
            ["generated", method, "fingertips"] => {
                TopicRole::Positions(TopicSource::Method(method))
            }
            ["evaluation", method, "error"] => TopicRole::Error(method),
            ["evaluation", method, "contact"] => TopicRole::Contact(method),
            ["overlay", name, "fingertips"] => TopicRole::Positions(TopicSource::Overlay(name)),
            ["overlay", name, "distance"] => TopicRole::Distance(name),
            ["dictionary", "profile"] => TopicRole::Profile,
            ["view", kind @ ("generated" | "overlay"), name, leaf] => {
                let whose = if kind == "overlay" {
                    TopicSource::Overlay(name)
                } else {
                    TopicSource::Method(name)
                };
                match leaf {
                    "fingertips" => TopicRole::Tips(whose),
                    "fingertip_balls" | "path_points" => TopicRole::Points,
                    "object_edges" => TopicRole::Edges,
                    "object" => TopicRole::Solid,
                    "fingertips_scene" => TopicRole::TipScene(whose),
                    "contacts" => TopicRole::Touching(whose),
                    "hulls" => TopicRole::Hulls(whose),
                    _ => TopicRole::View,
                }
            }
            ["view", ..] => TopicRole::View,
            [
                "recording" | "cleaned" | "processed" | "generated" | "held_out" | "evaluation"
                | "dictionary" | "overlay",
                _,
                ..,
            ] => TopicRole::Data,
            _ => return None,
        })
    }
}

/// Topics that a take may have once everything was done with it, with these methods, each with the
/// frame that its coordinates are in.
///
/// # Errors
///
/// [`ChannelError::Mismatch`] for a method whose name cannot be part of a topic.
pub fn take_topics(methods: &[&str]) -> Result<Vec<(String, Option<&'static str>)>, ChannelError> {
    let (world, hand, object) = (Some(World::NAME), Some(Hand::NAME), Some(Object::NAME));
    let mut topics: Vec<(String, Option<&str>)> = [
        (topic::RECORDING_FINGERTIPS, world),
        (topic::RECORDING_FINDINGS, None),
        (topic::ANNOTATIONS, None),
        (topic::PROCESSED_FINGERTIPS, hand),
        (topic::VIEW_MARKERS, world),
        (topic::VIEW_BODIES, world),
        (topic::VIEW_FINGERTIPS, hand),
        (topic::VIEW_FINGERTIPS_SCENE, hand),
        (topic::VIEW_OBJECT, object),
        (topic::VIEW_OBJECT_EDGES, object),
    ]
    .map(|(topic, frame)| (topic.to_owned(), frame))
    .into();
    for method in methods {
        topic::check_name("name of a method", method)?;
        for (root, leaf) in [
            (topic::EVALUATION, "error"),
            (topic::EVALUATION, "contact"),
            (topic::GENERATED, "fingertips"),
            (topic::VIEW_GENERATED, "fingertips"),
            (topic::VIEW_GENERATED, "fingertips_scene"),
        ] {
            topics.push((topic::named(root, method, leaf), hand));
        }
    }
    let recorded = topic::named(topic::EVALUATION, RECORDED, "contact");
    topics.push((recorded, hand));
    Ok(topics)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_of_methods_are_recognised_as_they_are_made() {
        let whose = TopicSource::Method("a-b_c");
        for (root, leaf, shown) in [
            (topic::GENERATED, "fingertips", TopicRole::Positions(whose)),
            (topic::GENERATED, "plan", TopicRole::Data),
            (topic::EVALUATION, "error", TopicRole::Error("a-b_c")),
            (topic::EVALUATION, "contact", TopicRole::Contact("a-b_c")),
            (topic::VIEW_GENERATED, "fingertips", TopicRole::Tips(whose)),
            (
                topic::VIEW_GENERATED,
                "fingertips_scene",
                TopicRole::TipScene(whose),
            ),
        ] {
            let topic = topic::named(root, "a-b_c", leaf);
            assert_eq!(TopicRole::from_topic(&topic), Some(shown), "{topic}");
        }
    }

    #[test]
    fn every_topic_of_a_take_is_one_of_ours() -> Result<(), ChannelError> {
        for (topic, _) in take_topics(&["residual", "line"])? {
            assert!(
                TopicRole::from_topic(&topic).is_some_and(|s| s != TopicRole::View),
                "{topic}"
            );
        }
        Ok(())
    }

    #[test]
    fn topics_of_others_are_not_ours() {
        for topic in [
            "",
            "/",
            "/tf",
            "/imu",
            "view/fingertips",
            "/recording",
            "/camera/view",
        ] {
            assert_eq!(TopicRole::from_topic(topic), None, "{topic}");
        }
        assert_eq!(TopicRole::from_topic("/view/tf"), Some(TopicRole::View));
    }
}
