//! Which topics are drawn, and how large.

use inhand_channels::{Shown, Whose};
use serde_json::{Value, json};

use crate::content::{Content, Topic};

/// How a topic is drawn.
enum Drawn {
    /// Spheres, solids and lines, which have sizes of their own.
    Scene,
    /// Points of so many pixels.
    Points(f64),
}

/// Pixels of a fingertip: 5 mm, seen from a third of a metre in a window of usual size.
const TIP_PX: f64 = 10.0;
/// Of one that touches the object.
const TOUCHING_PX: f64 = 15.0;
const BODY_PX: f64 = 8.0;
const MARKER_PX: f64 = 5.0;
/// Of points that show a shape together.
const SHAPE_PX: f64 = 2.5;

/// Schemas of others that a 3D panel draws, whatever they are called in ROS.
const DRAWN: [&str; 9] = [
    "PointCloud",
    "PointCloud2",
    "SceneUpdate",
    "PoseInFrame",
    "PosesInFrame",
    "PoseStamped",
    "PoseArray",
    "Marker",
    "MarkerArray",
];

/// Settings of each topic that can be drawn. What would be drawn twice is off.
pub(crate) fn settings(content: &Content) -> impl Iterator<Item = (String, Value)> {
    let ours = content.is_ours();
    (content.topics().iter()).filter_map(move |topic| {
        let settings = match Shown::of(&topic.name) {
            Some(shown) => of_ours(content, topic, shown)?,
            // Beside ours, those of others are the same motion once more.
            None if is_drawn(topic) => json!({ "visible": !ours }),
            None => return None,
        };
        Some((topic.name.clone(), settings))
    })
}

fn of_ours(content: &Content, topic: &Topic, shown: Shown<'_>) -> Option<Value> {
    let has = |shown| content.find(shown).is_some();
    let first = |whose| match whose {
        Whose::Method(name) => content.method() == Some(name),
        _ => true,
    };
    let (drawn, visible) = match shown {
        Shown::TipScene(whose) => (Drawn::Scene, first(whose)),
        Shown::Tips(whose) => {
            let visible = first(whose) && !has(Shown::TipScene(whose));
            (Drawn::Points(TIP_PX), visible)
        }
        // Scenes have lights around what touches.
        Shown::Touching(whose) => {
            let visible = first(whose) && !has(Shown::TipScene(whose));
            (Drawn::Points(TOUCHING_PX), visible)
        }
        Shown::Hulls(whose) => (
            Drawn::Scene,
            whose == Whose::Dictionary && !has(Shown::Paths),
        ),
        Shown::Points => (Drawn::Points(SHAPE_PX), false),
        Shown::Paths | Shown::Solid => (Drawn::Scene, true),
        Shown::Edges | Shown::Surface => {
            let solid = has(Shown::Solid) || (shown == Shown::Surface && has(Shown::Edges));
            (Drawn::Points(SHAPE_PX), !solid)
        }
        Shown::Markers => {
            let tips = has(Shown::Tips(Whose::Take)) || has(Shown::TipScene(Whose::Take));
            (Drawn::Points(MARKER_PX), !tips)
        }
        Shown::Bodies => (Drawn::Points(BODY_PX), !has(Shown::Solid)),
        Shown::View if is_drawn(topic) => (Drawn::Scene, true),
        _ => return None,
    };
    Some(match drawn {
        Drawn::Scene => json!({ "visible": visible }),
        Drawn::Points(pixels) => json!({
            "visible": visible,
            "pointSize": pixels,
            "pointShape": "circle",
            "colorMode": "rgba-fields",
            "decayTime": 0,
        }),
    })
}

fn is_drawn(topic: &Topic) -> bool {
    let name = |schema: &String| {
        let name = schema.rsplit(['.', '/', ':']).next();
        name.is_some_and(|name| DRAWN.contains(&name))
    };
    topic.schema.as_ref().is_some_and(name)
}
