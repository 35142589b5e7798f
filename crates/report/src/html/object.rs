//! Object error of methods that plan the object too.

use maud::html;

use super::{Body, Method, method_table};
use crate::number::{NONE, decimals, millimetres};
use crate::table::UPPER;

/// The section's content; `None` where no method plans the object.
pub(super) fn section(methods: &[Method<'_>]) -> Option<Body> {
    let planned = methods
        .iter()
        .filter_map(|method| Some((method, method.evaluation.object_error?)));
    let caption =
        "Object: distance between the origins (mm), and angle between the orientations (°)";
    let degrees = |angle: f64| decimals(angle.to_degrees(), 2);
    let table = method_table(caption, planned, |row| row.0)
        .sizes(|(_, error)| {
            [
                error.position.n,
                error.position.n_filled,
                error.position.n_left_out,
            ]
        })
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
