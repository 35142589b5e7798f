//! Purpose of each topic, for viewer layouts.

use inhand_model::{Frame, Hand, Object, World};

use crate::error::ChannelError;
use crate::topic::{self, MethodTopics};

/// Whose motion a channel is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Whose<'a> {
    /// The take's.
    Take,
    /// The take's as measured, where views show the processed one.
    Measured,
    /// What a method generated.
    Method(&'a str),
    /// A dictionary's primitives, one after the other.
    Dictionary,
    /// What was laid over a take, by name.
    Overlay(&'a str),
}

/// What a topic shows. Topics are known by their pattern, whether or not a file has messages there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Shown<'a> {
    /// Positions of fingertips, metres, `<finger>.position_m`.
    Positions(Whose<'a>),
    /// Fingertips as points.
    Tips(Whose<'a>),
    /// Fingertips as spheres with trails.
    TipScene(Whose<'a>),
    /// Fingertips that touch the object, as points.
    Touching(Whose<'a>),
    /// Where fingertips can be, as outlines or solids.
    Hulls(Whose<'a>),
    /// Paths of whole primitives.
    Paths,
    /// Points in the place of what a scene draws, for viewers without scenes.
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
    /// What was odd about a take.
    Findings,
    /// Events.
    Events,
    /// Anything else that is made to be looked at.
    View,
    /// Data that is not looked at as it is.
    Data,
}

impl<'a> Shown<'a> {
    /// What a topic shows; `None` for one that is none of ours.
    pub fn of(topic: &'a str) -> Option<Self> {
        Some(match topic {
            topic::PROCESSED_FINGERTIPS => Shown::Positions(Whose::Take),
            topic::RECORDING_FINGERTIPS => Shown::Positions(Whose::Measured),
            topic::DICTIONARY_PRIMITIVES => Shown::Positions(Whose::Dictionary),
            topic::RECORDING_FINDINGS => Shown::Findings,
            topic::ANNOTATIONS => Shown::Events,
            topic::VIEW_FINGERTIPS => Shown::Tips(Whose::Take),
            topic::VIEW_FINGERTIPS_SCENE => Shown::TipScene(Whose::Take),
            topic::VIEW_OBJECT => Shown::Solid,
            topic::VIEW_OBJECT_EDGES => Shown::Edges,
            topic::VIEW_MARKERS => Shown::Markers,
            topic::VIEW_BODIES => Shown::Bodies,
            topic::VIEW_PRIMITIVES => Shown::Tips(Whose::Dictionary),
            topic::VIEW_PRIMITIVES_SCENE => Shown::TipScene(Whose::Dictionary),
            topic::VIEW_FINGERTIP_BALLS | topic::VIEW_PATH_POINTS => Shown::Points,
            topic::VIEW_CONTACTS => Shown::Touching(Whose::Take),
            topic::VIEW_TAKE_HULLS => Shown::Hulls(Whose::Take),
            topic::VIEW_OBJECT_SURFACE => Shown::Surface,
            topic::VIEW_PATHS => Shown::Paths,
            topic::VIEW_HULLS => Shown::Hulls(Whose::Dictionary),
            _ => return Self::of_segments(topic),
        })
    }

    /// Topics that stand for many: of methods, of overlays.
    fn of_segments(topic: &'a str) -> Option<Self> {
        let segments: Vec<&str> = topic.strip_prefix('/')?.split('/').collect();
        Some(match segments[..] {
            ["generated", method, "fingertips"] => Shown::Positions(Whose::Method(method)),
            ["evaluation", method, "error"] => Shown::Error(method),
            ["evaluation", method, "contact"] => Shown::Contact(method),
            ["overlay", name, "fingertips"] => Shown::Positions(Whose::Overlay(name)),
            ["overlay", name, "distance"] => Shown::Distance(name),
            ["dictionary", "profile"] => Shown::Profile,
            ["view", kind @ ("generated" | "overlay"), name, leaf] => {
                let whose = if kind == "overlay" {
                    Whose::Overlay(name)
                } else {
                    Whose::Method(name)
                };
                match leaf {
                    "fingertips" => Shown::Tips(whose),
                    "fingertip_balls" => Shown::Points,
                    "object_edges" => Shown::Edges,
                    "object" => Shown::Solid,
                    "fingertips_scene" => Shown::TipScene(whose),
                    "contacts" => Shown::Touching(whose),
                    "hulls" => Shown::Hulls(whose),
                    _ => Shown::View,
                }
            }
            ["view", ..] => Shown::View,
            [
                "recording" | "cleaned" | "processed" | "generated" | "evaluation" | "dictionary"
                | "overlay",
                _,
                ..,
            ] => Shown::Data,
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
        let of_method = MethodTopics::new(method)?;
        for topic in [
            of_method.error,
            of_method.contact,
            of_method.fingertips,
            of_method.view_fingertips,
            of_method.view_scene,
        ] {
            topics.push((topic, hand));
        }
    }
    let recorded = MethodTopics::new("recorded")?;
    topics.push((recorded.contact, hand));
    Ok(topics)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_of_methods_are_recognised_as_they_are_made() -> Result<(), ChannelError> {
        let topics = MethodTopics::new("a-b_c")?;
        let whose = Whose::Method("a-b_c");
        for (topic, shown) in [
            (&topics.fingertips, Shown::Positions(whose)),
            (&topics.plan, Shown::Data),
            (&topics.error, Shown::Error("a-b_c")),
            (&topics.contact, Shown::Contact("a-b_c")),
            (&topics.view_fingertips, Shown::Tips(whose)),
            (&topics.view_scene, Shown::TipScene(whose)),
        ] {
            assert_eq!(Shown::of(topic), Some(shown), "{topic}");
        }
        Ok(())
    }

    #[test]
    fn every_topic_of_a_take_is_one_of_ours() -> Result<(), ChannelError> {
        for (topic, _) in take_topics(&["residual", "line"])? {
            assert!(
                Shown::of(&topic).is_some_and(|s| s != Shown::View),
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
            assert_eq!(Shown::of(topic), None, "{topic}");
        }
        assert_eq!(Shown::of("/view/tf"), Some(Shown::View));
    }
}
