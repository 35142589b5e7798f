//! Layouts of each kind of output, against the settings that the panels of Foxglove and Lichtblick
//! read.

mod kinds;
mod settings;

use inhand_viewing::Content;

/// A take as `inhand run` leaves it, in the order of its channels.
const TAKE: [(&str, Option<&str>); 20] = [
    ("/recording/markers", Some("world")),
    ("/recording/bodies", Some("world")),
    ("/recording/fingertips", Some("world")),
    ("/recording/findings", None),
    ("/annotations", None),
    ("/processed/fingertips", Some("hand")),
    ("/generated/residual/fingertips", Some("hand")),
    ("/generated/residual/plan", Some("hand")),
    ("/generated/line/fingertips", Some("hand")),
    ("/evaluation/residual/error", Some("hand")),
    ("/evaluation/residual/contact", Some("hand")),
    ("/evaluation/line/error", Some("hand")),
    ("/view/markers", Some("world")),
    ("/view/fingertips", Some("hand")),
    ("/view/fingertips_scene", Some("hand")),
    ("/view/generated/residual/fingertips", Some("hand")),
    ("/view/generated/residual/fingertips_scene", Some("hand")),
    ("/view/generated/line/fingertips", Some("hand")),
    ("/view/object", Some("object")),
    ("/view/object_edges", Some("object")),
];

fn content(topics: &[(&str, Option<&str>)]) -> Content {
    Content::of_topics(topics.iter().map(|&(name, frame)| (name.to_owned(), frame)))
}
