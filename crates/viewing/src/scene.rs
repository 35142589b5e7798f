//! The 3D panel: topics that are drawn, camera, grid.
//!
//! The camera goes with the hand: fingertips keep to their place in the view while the object turns
//! between them. A viewer that follows only where a frame is keeps the camera as it was towards the
//! frame at first, so nothing would be gained for what is up.

use inhand_channels::{PointExtent, TopicRole, TopicSource};
use inhand_model::{Frame, Hand, Object, World};
use serde_json::{Map, Value, json};

use crate::content::{Content, Topic};
use crate::panels::Panel;

/// Length of a frame's axes, metres.
const AXIS_M: f64 = 0.02;
/// Height of a frame's name, metres, once it is switched on.
const NAME_M: f64 = 0.008;
/// Labels of scenes, against their own size.
const LABELS: f64 = 1.0;
/// Transforms that are read ahead, so that a jump in time finds the hand: half an hour at 50 Hz.
const TRANSFORMS_AHEAD: u32 = 100_000;
/// Root of our trees of frames, z up.
const UPRIGHT: &str = "upright";
/// Least distance from fingertips around an object, metres.
const FINGERTIPS_M: f64 = 0.18;
/// Distance from a hand whose frame is on its back, metres: fingertips are a hand's breadth away.
const HAND_M: f64 = 0.5;
/// Least distance from fingertips that move about in the room, metres.
const ROOM_M: f64 = 0.5;
/// Distance in radii of what is looked at, and the most of it, metres.
const RADII: f64 = 3.0;
const MOST_M: f64 = 10.0;
/// Distance where nothing is known, metres.
const UNKNOWN_M: f64 = 2.0;
/// Width of a cell, metres.
const CELL_M: f64 = 0.01;
/// Width of the grid, metres.
const WIDTH_M: f64 = 0.3;
/// Distance of the grid below the lowest fingertip, metres.
const BELOW_M: f64 = 0.05;
/// Faint, so that it is seen only when it is looked for.
const GRID_COLOUR: &str = "#8888884d";
/// Pixels of a fingertip: 5 mm, seen from a third of a metre in a window of usual size.
const TIP_PX: f64 = 10.0;
/// Of one that touches the object.
const TOUCHING_PX: f64 = 15.0;
const BODY_PX: f64 = 8.0;
const MARKER_PX: f64 = 5.0;
/// Of points that show a shape together.
const SHAPE_PX: f64 = 2.5;
/// Third-party schemas that a 3D panel draws, by their names without package.
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

/// The 3D panel and whether there is anything in it.
pub(crate) fn panel(content: &Content) -> (Panel, bool) {
    let drawn: Map<String, Value> = topic_settings(content).collect();
    let draws = drawn.values().any(|topic| topic["visible"] == json!(true));
    let camera = Camera::new(content);
    // The object turns: a camera that turned with it would show a still object.
    let follow_mode = match camera.frame {
        Some(Object::NAME) => "follow-position",
        _ => "follow-pose",
    };
    let mut settings = json!({
        "scene": {
            "enableStats": false,
            "labelScaleFactor": LABELS,
            "transforms": {
                "showLabel": false,
                "labelSize": NAME_M,
                "axisScale": AXIS_M,
                "lineWidth": 0,
                "enablePreloading": true,
                "maxPreloadMessages": TRANSFORMS_AHEAD,
            },
        },
        "topics": drawn,
        "layers": { "grid": grid(&camera) },
        "transforms": {},
        "publish": {},
        "imageMode": {},
        "followMode": follow_mode,
        "cameraState": {
            "perspective": true,
            "distance": camera.distance_m,
            "phi": 60,
            "thetaOffset": 45,
            "fovy": 45,
            // By default nothing nearer than half a metre is drawn.
            "near": 0.01,
            "far": 100,
            "target": [0, 0, 0],
            "targetOffset": camera.seen.map_or([0.0; 3], |seen| seen.centre_m),
            "targetOrientation": [0, 0, 0, 1],
        },
    });
    if let Some(frame) = camera.frame {
        settings["followTf"] = json!(frame);
    }
    (Panel::new("3D", "hand", "Hand", settings), draws)
}

/// Frame that a view follows, and its target there.
struct Camera {
    /// Frame to follow; the viewer's choice where none is known.
    frame: Option<&'static str>,
    /// Where fingertips are in that frame, if that is known.
    seen: Option<PointExtent>,
    distance_m: f64,
}

impl Camera {
    /// The camera for the content: on fingertips in the hand's frame, else where fingertips or markers
    /// are first seen in the room, else on the object or the hand.
    fn new(content: &Content) -> Self {
        let hand = content.frames.contains(Hand::NAME);
        let in_hand = content.seen.get(Hand::NAME).copied().filter(|_| hand);
        let in_room = content.seen.get(UPRIGHT).copied();
        let (frame, seen, distance_m) = if let Some(seen) = in_hand.or(in_room) {
            let (frame, least_m) = match in_hand {
                Some(_) => (Hand::NAME, FINGERTIPS_M),
                None => (UPRIGHT, ROOM_M),
            };
            let distance_m = (RADII * seen.radius_m).clamp(least_m, MOST_M);
            (Some(frame), Some(seen), distance_m)
        } else if content.frames.contains(Object::NAME) {
            (Some(Object::NAME), None, FINGERTIPS_M)
        } else if hand {
            (Some(Hand::NAME), None, HAND_M)
        } else {
            let world = content.frames.contains(World::NAME);
            (world.then_some(UPRIGHT), None, UNKNOWN_M)
        };
        Self {
            frame,
            seen,
            distance_m,
        }
    }
}

/// The grid as a layer: a floor under what the camera looks at.
fn grid(camera: &Camera) -> Value {
    let position_m = camera.seen.map_or([0.0, 0.0, -BELOW_M], |seen| {
        let [x, y, _] = seen.centre_m;
        [x, y, seen.lowest_m - BELOW_M]
    });
    let mut layer = json!({
        "layerId": "foxglove.Grid",
        "instanceId": "grid",
        "label": "Centimetres",
        "visible": true,
        "frameLocked": true,
        "size": WIDTH_M,
        "divisions": (WIDTH_M / CELL_M).round() as u32,
        "lineWidth": 1,
        "color": GRID_COLOUR,
        // Lines on whole centimetres of the frame.
        "position": position_m.map(|c| (c / CELL_M).round() / (1.0 / CELL_M)),
        "rotation": [0, 0, 0],
    });
    // Under an object it would turn with it.
    let frame = camera.frame.map(|frame| match frame {
        Object::NAME => Hand::NAME,
        other => other,
    });
    if let Some(frame) = frame {
        layer["frameId"] = json!(frame);
    }
    layer
}

/// Settings of each topic that can be drawn. What would be drawn twice is off.
fn topic_settings(content: &Content) -> impl Iterator<Item = (String, Value)> {
    let ours = content.is_ours();
    (content.topics.iter()).filter_map(move |topic| {
        let settings = match TopicRole::from_topic(&topic.name) {
            Some(shown) => of_ours(content, topic, shown)?,
            // Beside views of inhand, third-party ones are the same motion once more.
            None if is_drawn(topic) => json!({ "visible": !ours }),
            None => return None,
        };
        Some((topic.name.clone(), settings))
    })
}

fn of_ours(content: &Content, topic: &Topic, shown: TopicRole<'_>) -> Option<Value> {
    let has = |shown| content.find(shown).is_some();
    let first = |whose| match whose {
        TopicSource::Method(name) => content.method() == Some(name),
        _ => true,
    };
    // Scenes have sizes of their own, points are of so many pixels.
    let (pixels, visible) = match shown {
        TopicRole::TipScene(whose) => (None, first(whose)),
        TopicRole::Tips(whose) => {
            let visible = first(whose) && !has(TopicRole::TipScene(whose));
            (Some(TIP_PX), visible)
        }
        // Scenes have lights around what touches.
        TopicRole::Touching(whose) => {
            let visible = first(whose) && !has(TopicRole::TipScene(whose));
            (Some(TOUCHING_PX), visible)
        }
        TopicRole::Hulls(whose) => (
            None,
            whose == TopicSource::Dictionary && !has(TopicRole::Paths),
        ),
        TopicRole::Points => (Some(SHAPE_PX), false),
        TopicRole::Paths | TopicRole::Solid => (None, true),
        TopicRole::Edges | TopicRole::Surface => {
            let solid =
                has(TopicRole::Solid) || (shown == TopicRole::Surface && has(TopicRole::Edges));
            (Some(SHAPE_PX), !solid)
        }
        TopicRole::Markers => {
            let tips = has(TopicRole::Tips(TopicSource::Take))
                || has(TopicRole::TipScene(TopicSource::Take));
            (Some(MARKER_PX), !tips)
        }
        TopicRole::Bodies => (Some(BODY_PX), !has(TopicRole::Solid)),
        TopicRole::View if is_drawn(topic) => (None, true),
        _ => return None,
    };
    Some(match pixels {
        None => json!({ "visible": visible }),
        Some(pixels) => json!({
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
