//! A grid of centimetres, so that sizes can be told.

use inhand_model::{Frame, Hand, Object};
use serde_json::{Value, json};

use crate::camera::Camera;

/// Width of a cell, metres.
const CELL_M: f64 = 0.01;
/// Width of the grid, metres.
const WIDTH_M: f64 = 0.3;
/// How far below the lowest fingertip it lies, metres.
const BELOW_M: f64 = 0.05;
/// Faint, so that it is seen only when it is looked for.
const COLOUR: &str = "#8888884d";

/// The grid as a layer: a floor under what the camera looks at.
pub(crate) fn layer(camera: &Camera) -> Value {
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
        "color": COLOUR,
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
