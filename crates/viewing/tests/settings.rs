//! The settings that the panels read, as a schema: names and types of `RendererConfig`, `PlotConfig`,
//! `StateTransitionConfig`, `RawMessagesPanelConfig` and the log panel's `Config` in Lichtblick, which
//! Foxglove shares. A name that is written wrongly would be passed over by the viewers in silence.

use inhand_viewing::layout;
use serde_json::{Value, json};

use crate::{TAKE, content};

fn closed(properties: Value, required: &[&str]) -> Value {
    let mut schema = json!({
        "type": "object",
        "required": required,
        "additionalProperties": false,
    });
    schema["properties"] = properties;
    schema
}

fn with_title(mut properties: Value, required: &[&str]) -> Value {
    for title in ["foxglovePanelTitle", "lichtblickPanelTitle"] {
        properties[title] = json!({ "type": "string", "minLength": 1 });
    }
    closed(properties, required)
}

fn vector(length: usize) -> Value {
    json!({ "type": "array", "items": { "type": "number" }, "minItems": length, "maxItems": length })
}

fn schema() -> Value {
    let (text, number, flag) = (
        json!({ "type": "string" }),
        json!({ "type": "number" }),
        json!({ "type": "boolean" }),
    );
    let colour = json!({ "type": "string", "pattern": "^#([0-9A-Fa-f]{6}|[0-9A-Fa-f]{8})$" });
    let path = closed(
        json!({
            "value": { "type": "string", "pattern": r"^(/[A-Za-z0-9_-]+)+(\.[a-z_]+(\[0\])?)+$" },
            "label": text, "enabled": flag, "color": colour, "showLine": flag, "lineSize": number,
            "timestampMethod": { "const": "receiveTime" },
        }),
        &["value", "enabled", "timestampMethod"],
    );
    let paths = json!({ "type": "array", "items": path, "minItems": 1 });
    let camera = closed(
        json!({
            "perspective": flag, "distance": number, "phi": number, "thetaOffset": number,
            "fovy": number, "near": { "type": "number", "exclusiveMaximum": 0.1 }, "far": number,
            "target": vector(3), "targetOffset": vector(3), "targetOrientation": vector(4),
        }),
        &[
            "distance",
            "near",
            "far",
            "phi",
            "thetaOffset",
            "targetOffset",
        ],
    );
    let transforms = closed(
        json!({
            "showLabel": flag, "labelSize": number, "axisScale": number, "lineWidth": number,
            "enablePreloading": flag, "maxPreloadMessages": number,
        }),
        &["axisScale"],
    );
    let topic = closed(
        json!({
            "visible": flag, "pointSize": number, "pointShape": { "enum": ["circle", "square"] },
            "colorMode": { "enum": ["flat", "gradient", "colormap", "rgb", "rgba", "rgba-fields"] },
            "decayTime": number,
        }),
        &["visible"],
    );
    let grid = closed(
        json!({
            "layerId": { "const": "foxglove.Grid" }, "instanceId": { "const": "grid" },
            "label": text, "visible": flag, "frameLocked": flag, "frameId": text, "size": number,
            "divisions": { "type": "integer", "maximum": 4096 }, "lineWidth": number,
            "color": colour, "position": vector(3), "rotation": vector(3),
        }),
        &["layerId", "instanceId", "visible", "size", "divisions"],
    );
    let scene = closed(
        json!({ "enableStats": flag, "labelScaleFactor": number, "transforms": transforms }),
        &["transforms"],
    );
    let three_d = with_title(
        json!({
            "cameraState": camera,
            "followMode": { "enum": ["follow-pose", "follow-position", "follow-none"] },
            "followTf": text,
            "scene": scene,
            "topics": { "type": "object", "additionalProperties": topic },
            "layers": closed(json!({ "grid": grid }), &["grid"]),
            "transforms": closed(json!({}), &[]),
            "publish": closed(json!({}), &[]),
            "imageMode": closed(json!({}), &[]),
        }),
        &["cameraState", "followMode", "scene", "topics", "layers"],
    );
    let plot = with_title(
        json!({
            "paths": paths, "xAxisVal": { "const": "timestamp" }, "isSynced": flag,
            "showLegend": flag, "legendDisplay": { "enum": ["floating", "top", "left", "none"] },
            "showPlotValuesInLegend": flag, "showXAxisLabels": flag, "showYAxisLabels": flag,
            "sidebarDimension": number, "minYValue": number, "maxYValue": number,
        }),
        &["paths", "xAxisVal"],
    );
    let transitions = with_title(json!({ "isSynced": flag, "paths": paths }), &["paths"]);
    let log = with_title(
        json!({
            "searchTerms": { "type": "array", "maxItems": 0 }, "minLogLevel": { "const": 1 },
            "topicToRender": text,
        }),
        &["searchTerms", "minLogLevel", "topicToRender"],
    );
    let raw = with_title(
        json!({
            "diffEnabled": flag, "diffMethod": { "enum": ["custom", "previous message"] },
            "diffTopicPath": text, "showFullMessageForDiff": flag,
            "expansion": { "enum": ["all", "none"] }, "topicPath": text,
        }),
        &["diffEnabled", "diffMethod", "diffTopicPath", "topicPath"],
    );
    let panels = json!({
        "type": "object",
        "patternProperties": {
            "^3D!": three_d, "^Plot!": plot, "^StateTransitions!": transitions, "^RosOut!": log,
            "^RawMessages!": raw,
        },
        "additionalProperties": false,
        "minProperties": 1,
    });
    let node = closed(
        json!({
            "direction": { "enum": ["row", "column"] },
            "splitPercentage": { "type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 100 },
            "first": { "$ref": "#/$defs/node" }, "second": { "$ref": "#/$defs/node" },
        }),
        &["direction", "first", "second", "splitPercentage"],
    );
    let mut schema = closed(
        json!({
            "configById": panels,
            "globalVariables": closed(json!({}), &[]),
            "userNodes": closed(json!({}), &[]),
            "playbackConfig": closed(json!({ "speed": number }), &["speed"]),
            "layout": { "$ref": "#/$defs/node" },
        }),
        &[
            "configById",
            "globalVariables",
            "userNodes",
            "playbackConfig",
            "layout",
        ],
    );
    schema["$defs"] = json!({ "node": { "anyOf": [text, node] } });
    schema
}

/// Fails unless the panels would read every setting of the layout, and each panel has one place.
pub(crate) fn check(layout: &Value) {
    let validator = jsonschema::validator_for(&schema()).expect("the schema is a schema");
    let errors: Vec<_> = validator
        .iter_errors(layout)
        .map(|error| format!("{}: {error}", error.instance_path()))
        .collect();
    assert!(errors.is_empty(), "{errors:#?}");
    let mut placed = Vec::new();
    collect(&layout["layout"], &mut placed);
    placed.sort_unstable();
    let panels = layout["configById"]
        .as_object()
        .expect("panels have settings");
    assert_eq!(
        placed,
        panels.keys().map(String::as_str).collect::<Vec<_>>()
    );
}

fn collect<'a>(node: &'a Value, placed: &mut Vec<&'a str>) {
    match node.as_str() {
        Some(panel) => placed.push(panel),
        None => {
            collect(&node["first"], placed);
            collect(&node["second"], placed);
        }
    }
}

#[test]
fn the_schema_finds_what_is_written_wrongly() {
    let good = layout(&content(&TAKE)).expect("a take can be shown");
    check(&good);
    let validator = jsonschema::validator_for(&schema()).expect("the schema is a schema");
    for (place, wrong) in [
        ("/configById/3D!hand/followMode", json!("follow")),
        ("/configById/3D!hand/cameraState/near", json!(0.5)),
        (
            "/configById/Plot!error/paths/0/timestampMethod",
            json!("headerStamp"),
        ),
        ("/configById/Plot!error/paths/0/value", json!("/a b.c")),
        ("/layout/direction", json!("rows")),
    ] {
        let mut bad = good.clone();
        *bad.pointer_mut(place).expect("the setting is there") = wrong;
        assert!(!validator.is_valid(&bad), "{place}");
    }
}
