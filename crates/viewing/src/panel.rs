//! Panels that list: findings, events.

use inhand_channels::Shown;
use serde_json::{Value, json};

use crate::content::Content;

/// A panel and its settings.
pub(crate) struct Panel {
    /// Kind and name, `Plot!error`; viewers tell the kind from it.
    pub(crate) id: String,
    pub(crate) settings: Value,
}

impl Panel {
    /// A panel with a title. The viewers share all settings but the name of this one.
    pub(crate) fn new(kind: &str, name: &str, title: &str, mut settings: Value) -> Self {
        settings["foxglovePanelTitle"] = json!(title);
        settings["lichtblickPanelTitle"] = json!(title);
        Self {
            id: format!("{kind}!{name}"),
            settings,
        }
    }
}

/// Schemas of messages that a log panel lists.
const LOGS: [&str; 3] = [
    "foxglove.Log",
    "rcl_interfaces/msg/Log",
    "rosgraph_msgs/Log",
];
/// The lowest level that a log panel lists, that of all levels.
const LOWEST_LEVEL: u32 = 1;

/// Panels for what is not drawn.
pub(crate) fn lists(content: &Content) -> Vec<Panel> {
    let mut panels = Vec::new();
    let of_others = || {
        let is_log = |schema: &String| LOGS.contains(&schema.as_str());
        let log = |topic: &&crate::Topic| topic.schema.as_ref().is_some_and(is_log);
        content.topics().iter().find(log).map(|t| t.name.as_str())
    };
    if let Some(topic) = content.find(Shown::Findings) {
        panels.push(log(topic, "Findings"));
    } else if let Some(topic) = of_others() {
        panels.push(log(topic, "Log"));
    }
    if let Some(topic) = content.find(Shown::Events) {
        // One label an event: a path of several values is refused.
        let label = json!({
            "value": format!("{topic}.metadata[0].value"),
            "label": "event",
            "enabled": true,
            "timestampMethod": "receiveTime",
        });
        let settings = json!({ "isSynced": true, "paths": [label] });
        panels.push(Panel::new("StateTransitions", "events", "Events", settings));
        let settings = json!({
            "diffEnabled": false,
            "diffMethod": "custom",
            "diffTopicPath": "",
            "showFullMessageForDiff": false,
            "expansion": "all",
            "topicPath": topic,
        });
        panels.push(Panel::new("RawMessages", "event", "Last event", settings));
    }
    panels
}

fn log(topic: &str, title: &str) -> Panel {
    let settings = json!({
        "searchTerms": [],
        "minLogLevel": LOWEST_LEVEL,
        "topicToRender": topic,
    });
    // The name that the panel had before it was called Log.
    Panel::new("RosOut", "findings", title, settings)
}
