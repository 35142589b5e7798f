//! Layouts for Foxglove and Lichtblick: a hand that turns an object, and plots under it.
//!
//! What to show comes from the topics that files have, so that every output has a layout that fits it:
//! recordings, takes with generated motion, dictionaries, plans, overlays. Nothing here reads a file.
//!
//! ```
//! use inhand_viewing::{Content, layout};
//!
//! let topics = ["/view/fingertips_scene", "/view/object", "/evaluation/line/error"];
//! let content = Content::of_topics(topics.map(|topic| (topic.to_owned(), None)));
//! let layout = layout(&content).expect("there is something to show");
//! let panels = layout["configById"].as_object().expect("panels have settings");
//! assert!(panels["3D!hand"]["topics"]["/view/object"]["visible"].as_bool() == Some(true));
//! assert_eq!(
//!     panels["Plot!error"]["paths"][0]["value"],
//!     "/evaluation/line/error.thumb_m"
//! );
//! ```
//!
//! The same content gives the same layout, to the byte. Sizes are those of a hand: the viewers' own
//! defaults are those of a car.

mod content;
mod panels;
mod scene;

use serde_json::{Value, json};
use thiserror::Error;

pub use content::{Content, Topic};

use crate::panels::Panel;

/// Why there is no layout.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LayoutError {
    /// No channel can be drawn, plotted or listed.
    #[error(
        "expected a channel that a viewer can draw or plot, found {found}; `inhand convert` makes a recording of a take, `inhand run` all there is to see"
    )]
    NothingToShow {
        /// What there is instead, in words.
        found: String,
    },
}

/// Part of the height that the view of the hand takes where plots are under it, per cent.
const SCENE_SHARE: f64 = 66.0;
/// Part of the width that the view of the hand takes where lists are beside it, per cent.
const SCENE_WIDTH: f64 = 76.0;

/// The layout that suits the content, as viewers import it.
///
/// # Errors
///
/// [`LayoutError::NothingToShow`].
pub fn layout(content: &Content) -> Result<Value, LayoutError> {
    let (scene, draws) = scene::panel(content);
    let lists = panels::lists(content);
    let plots = panels::plots(content);
    if !draws && lists.is_empty() && plots.is_empty() {
        return Err(LayoutError::NothingToShow {
            found: content.describe(),
        });
    }
    let ids = |panels: &[Panel]| panels.iter().map(|p| json!(p.id)).collect();
    let mut arranged = json!(scene.id);
    if let Some(lists) = evenly(ids(&lists), stacked) {
        arranged = beside(arranged, lists, SCENE_WIDTH);
    }
    if let Some(plots) = evenly(ids(&plots), beside) {
        arranged = stacked(arranged, plots, SCENE_SHARE);
    }
    let panels = [scene].into_iter().chain(lists).chain(plots);
    let settings: serde_json::Map<String, Value> =
        panels.map(|panel| (panel.id, panel.settings)).collect();
    Ok(json!({
        "configById": settings,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": { "speed": 1 },
        "layout": arranged,
    }))
}

/// Two parts side by side; the first takes `percent` of the width.
fn beside(first: Value, second: Value, percent: f64) -> Value {
    split("row", first, second, percent)
}

/// Two parts one above the other; the upper takes `percent` of the height.
fn stacked(first: Value, second: Value, percent: f64) -> Value {
    split("column", first, second, percent)
}

fn split(direction: &str, first: Value, second: Value, percent: f64) -> Value {
    let mut split = json!({ "direction": direction, "splitPercentage": percent });
    (split["first"], split["second"]) = (first, second);
    split
}

/// All parts, each with the same share; `None` for none.
fn evenly(parts: Vec<Value>, join: fn(Value, Value, f64) -> Value) -> Option<Value> {
    let mut joined: Option<(Value, u32)> = None;
    for part in parts.into_iter().rev() {
        joined = Some(match joined {
            None => (part, 1),
            Some((others, n)) => (join(part, others, 100.0 / f64::from(n + 1)), n + 1),
        });
    }
    joined.map(|(parts, _)| parts)
}
