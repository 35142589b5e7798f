//! The 3D panel.

use serde_json::{Map, Value, json};

use crate::camera::Camera;
use crate::content::Content;
use crate::grid;
use crate::panel::Panel;
use crate::topics;

/// Length of a frame's axes, metres.
const AXIS_M: f64 = 0.02;
/// Height of a frame's name, metres, once it is switched on.
const NAME_M: f64 = 0.008;
/// Labels of scenes, against their own size.
const LABELS: f64 = 1.0;
/// Transforms that are read ahead, so that a jump in time finds the hand: half an hour at 50 Hz.
const TRANSFORMS_AHEAD: u32 = 100_000;

/// The 3D panel and whether there is anything in it.
pub(crate) struct Scene {
    pub(crate) panel: Panel,
    pub(crate) draws: bool,
}

pub(crate) fn panel(content: &Content) -> Scene {
    let drawn: Map<String, Value> = topics::settings(content).collect();
    let draws = drawn.values().any(|topic| topic["visible"] == json!(true));
    let camera = Camera::of(content);
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
        "layers": { "grid": grid::layer(&camera) },
        "transforms": {},
        "publish": {},
        "imageMode": {},
    });
    camera.settings(&mut settings);
    Scene {
        panel: Panel::new("3D", "hand", "Hand", settings),
        draws,
    }
}
