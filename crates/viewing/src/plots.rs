//! Plots: errors, distances and contacts, else the fingertips' coordinates.

use inhand_channels::{Shown, Whose, finger_hex};
use inhand_model::Finger;
use serde_json::{Value, json};

use crate::content::Content;
use crate::panel::Panel;

/// What the evaluation calls the take itself.
const RECORDED: &str = "recorded";
/// Lines that are no finger's: of the take, of a method.
const TAKE_COLOUR: &str = "#999999";
const METHOD_COLOUR: &str = "#0072B2";
/// Overlays that are plotted; more would be too small to read.
const MOST_OVERLAYS: usize = 3;

/// Width of a list of colours beside a plot, pixels.
const LEGEND_PX: u32 = 120;

/// A line of a plot.
struct Line {
    path: String,
    label: String,
    colour: String,
}

/// Plots of the content, from left to right.
pub(crate) fn panels(content: &Content) -> Vec<Panel> {
    let mut plots = judged(content);
    plots.extend(overlaid(content));
    if let Some(topic) = content.find(Shown::Profile) {
        plots.push(of_fingers(
            ("profile", "Distance from the mean motion (m)"),
            topic,
            "m",
        ));
        let line = Line {
            path: format!("{topic}.primitive"),
            label: "primitive".to_owned(),
            colour: TAKE_COLOUR.to_owned(),
        };
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
        Shown::Error(method) => Some(method),
        _ => None,
    });
    if let Some((topic, method)) = error {
        let title = format!("Error of {method} (m)");
        plots.push(of_fingers(("error", &title), topic, "m"));
    }
    let recorded = content.find(Shown::Contact(RECORDED));
    let method = error.map(|(_, method)| method).or(content.method());
    let planned = method.and_then(|method| content.find(Shown::Contact(method)));
    if let Some(topic) = recorded.or(planned) {
        let title = "Distance to the object (m)";
        plots.push(of_fingers(("distance", title), topic, "distance_m"));
    }
    let counts: Vec<_> = [
        (recorded, RECORDED, TAKE_COLOUR),
        (planned, method.unwrap_or_default(), METHOD_COLOUR),
    ]
    .into_iter()
    .filter_map(|(topic, label, colour)| {
        Some(Line {
            path: format!("{}.count", topic?),
            label: label.to_owned(),
            colour: colour.to_owned(),
        })
    })
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
            Shown::Distance(name) => Some((topic, name)),
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
        Shown::Positions(whose) => Some(whose),
        _ => None,
    });
    let best = [Whose::Take, Whose::Measured]
        .into_iter()
        .find_map(|whose| content.find(Shown::Positions(whose)));
    let Some(topic) = best.or(first.map(|(topic, _)| topic)) else {
        return Vec::new();
    };
    ["x", "y", "z"]
        .map(|axis| {
            let title = format!("Fingertips, {axis} (m)");
            let lines =
                Finger::ALL.map(|finger| line(topic, finger, &format!(".position_m.{axis}")));
            plot(axis, &title, &lines, None)
        })
        .into()
}

/// A plot of one number a finger, called `<finger>_<what>`.
fn of_fingers((name, title): (&str, &str), topic: &str, what: &str) -> Panel {
    let lines = Finger::ALL.map(|finger| line(topic, finger, &format!("_{what}")));
    plot(name, title, &lines, None)
}

fn line(topic: &str, finger: Finger, field: &str) -> Line {
    let name = finger.name();
    Line {
        path: format!("{topic}.{name}{field}"),
        label: name.to_owned(),
        colour: finger_hex(finger),
    }
}

/// A plot over the time at which messages were logged, which is that of the sample; the viewers take
/// the field `timestamp` for no header stamp.
fn plot(name: &str, title: &str, lines: &[Line], range: Option<(f64, f64)>) -> Panel {
    let paths: Vec<Value> = (lines.iter())
        .map(|line| {
            json!({
                "value": line.path,
                "label": line.label,
                "color": line.colour,
                "enabled": true,
                "showLine": true,
                "lineSize": 1,
                "timestampMethod": "receiveTime",
            })
        })
        .collect();
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
