//! Object error of methods that plan the object too.

use maud::html;

use super::{Body, Method, known_of, method_table};
use crate::table::{UPPER, sizes};
use crate::words::{NONE, decimals, millimetres};

/// The section's content; `None` where no method plans the object.
pub(super) fn section(methods: &[Method<'_>]) -> Option<Body> {
    let planned = known_of(methods, |own| own.object_error);
    let caption =
        "Object: distance between the origins (mm), and angle between the orientations (°)";
    let degrees = |angle: f64| decimals(angle.to_degrees(), 2);
    let table = method_table(caption, planned, |row| row.0)
        .sizes(|(_, error)| sizes(&error.position))
        .statistics(&UPPER, "mm", millimetres, |(_, error)| error.position)
        .statistics(&UPPER, "°", degrees, |(_, error)| error.angle)
        .smallest_marked();
    (!table.is_empty()).then(|| {
        Body::from(html! {
            p {
                "Planned against recorded pose of the object in the hand's frame, at every sample of every test segment where both are known."
            }
        })
        .prose(table)
        .prose(html! {
            p.note {
                "n: instants compared. Filled: those among them at which the object rests on an interpolated sample. Left out: object not tracked, \
                 a gap, or a plan that failed. Angle: of the one rotation from the recorded to the planned orientation, 0 to 180°. Bold: smallest of \
                 its column among the methods. " (NONE) ": nothing to evaluate."
            }
        })
    })
}
