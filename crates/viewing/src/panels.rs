//! Panels beside and under the scene: findings and events, and plots of errors, distances and contacts, else
//! of the fingertips' coordinates.

use inhand_channels::{RECORDED, TopicRole, TopicSource, finger_hex};
use inhand_model::Finger;
use serde_json::{Value, json};

use crate::content::Content;

/// A panel and its settings.
pub(crate) struct Panel {
    /// Kind and name, `Plot!error`; viewers read the kind from it.
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
        content.topics.iter().find(log).map(|t| t.name.as_str())
    };
    if let Some(topic) = content.find(TopicRole::Findings) {
        panels.push(log(topic, "Findings"));
    } else if let Some(topic) = of_others() {
        panels.push(log(topic, "Log"));
    }
    if let Some(topic) = content.find(TopicRole::Events) {
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

/// Lines that are no finger's: of the take, of a method.
const TAKE_COLOUR: &str = "#999999";
const METHOD_COLOUR: &str = "#0072B2";
/// Overlays that are plotted; more would be too small to read.
const MOST_OVERLAYS: usize = 3;

/// Width of a list of colours beside a plot, pixels.
const LEGEND_PX: u32 = 120;

/// Plots of the content, from left to right.
pub(crate) fn plots(content: &Content) -> Vec<Panel> {
    let mut plots = judged(content);
    plots.extend(overlaid(content));
    if let Some(topic) = content.find(TopicRole::Profile) {
        plots.push(of_fingers(
            ("profile", "Distance from the mean motion (m)"),
            topic,
            "m",
        ));
        let line = line(&format!("{topic}.primitive"), "primitive", TAKE_COLOUR);
        plots.push(plot("primitive", "Primitive", &[line], None));
    }
    if plots.is_empty() {
        plots = coordinates(content);
    }
    // One list of colours is enough for plots of the same fingers.
    let mut listed = false;
    for plot in &mut plots {
        let lines = plot.settings["paths"].as_array().map_or(0, Vec::len);
        if lines == Finger::ALL.len() && std::mem::replace(&mut listed, true) {
            plot.settings["showLegend"] = json!(false);
        }
    }
    plots
}

/// Errors of the first method that was judged, distances to the object, fingers in contact.
fn judged(content: &Content) -> Vec<Panel> {
    let mut plots = Vec::new();
    let error = content.find_map(|shown| match shown {
        TopicRole::Error(method) => Some(method),
        _ => None,
    });
    if let Some((topic, method)) = error {
        let title = format!("Error of {method} (m)");
        plots.push(of_fingers(("error", &title), topic, "m"));
    }
    let recorded = content.find(TopicRole::Contact(RECORDED));
    let method = error.map(|(_, method)| method).or(content.method());
    let planned = method.and_then(|method| content.find(TopicRole::Contact(method)));
    if let Some(topic) = recorded.or(planned) {
        let title = "Distance to the object (m)";
        plots.push(of_fingers(("distance", title), topic, "distance_m"));
    }
    let counts: Vec<_> = [
        (recorded, RECORDED, TAKE_COLOUR),
        (planned, method.unwrap_or_default(), METHOD_COLOUR),
    ]
    .into_iter()
    .filter_map(|(topic, label, colour)| Some(line(&format!("{}.count", topic?), label, colour)))
    .collect();
    if !counts.is_empty() {
        // A line at the very edge could not be seen.
        let most = Finger::ALL.len() as f64 + 0.5;
        let title = "Fingers in contact";
        plots.push(plot("contacts", title, &counts, Some((0.0, most))));
    }
    plots
}

fn overlaid(content: &Content) -> Vec<Panel> {
    (content.shown())
        .filter_map(|(topic, shown)| match shown {
            TopicRole::Distance(name) => Some((topic, name)),
            _ => None,
        })
        .take(MOST_OVERLAYS)
        .map(|(topic, name)| {
            let title = format!("Distance of {name} (m)");
            of_fingers((&format!("overlay-{name}"), &title), topic, "m")
        })
        .collect()
}

/// A plot for each axis.
fn coordinates(content: &Content) -> Vec<Panel> {
    let first = content.find_map(|shown| match shown {
        TopicRole::Positions(whose) => Some(whose),
        _ => None,
    });
    let best = [TopicSource::Take, TopicSource::Measured]
        .into_iter()
        .find_map(|whose| content.find(TopicRole::Positions(whose)));
    let Some(topic) = best.or(first.map(|(topic, _)| topic)) else {
        return Vec::new();
    };
    ["x", "y", "z"]
        .map(|axis| {
            let title = format!("Fingertips, {axis} (m)");
            let field = format!(".position_m.{axis}");
            plot(axis, &title, &finger_lines(topic, &field), None)
        })
        .into()
}

/// A plot of one number a finger, called `<finger>_<what>`.
fn of_fingers((name, title): (&str, &str), topic: &str, what: &str) -> Panel {
    plot(name, title, &finger_lines(topic, &format!("_{what}")), None)
}

fn finger_lines(topic: &str, field: &str) -> [Value; Finger::COUNT] {
    let line = |finger: Finger| {
        let name = finger.name();
        line(&format!("{topic}.{name}{field}"), name, &finger_hex(finger))
    };
    Finger::ALL.map(line)
}

/// A line of a plot.
fn line(path: &str, label: &str, colour: &str) -> Value {
    json!({
        "value": path,
        "label": label,
        "color": colour,
        "enabled": true,
        "showLine": true,
        "lineSize": 1,
        "timestampMethod": "receiveTime",
    })
}

/// A plot over the time at which messages were logged, which is that of the sample; the viewers take
/// the field `timestamp` for no header stamp.
fn plot(name: &str, title: &str, paths: &[Value], range: Option<(f64, f64)>) -> Panel {
    let mut settings = json!({
        "paths": paths,
        "xAxisVal": "timestamp",
        "isSynced": true,
        "showLegend": true,
        "legendDisplay": "left",
        "showPlotValuesInLegend": false,
        "showXAxisLabels": true,
        "showYAxisLabels": true,
        "sidebarDimension": LEGEND_PX,
    });
    if let Some((least, most)) = range {
        settings["minYValue"] = json!(least);
        settings["maxYValue"] = json!(most);
    }
    Panel::new("Plot", name, title, settings)
}
