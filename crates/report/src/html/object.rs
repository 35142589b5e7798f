//! Object error of methods that plan the object too.

use inhand_model::{ObjectError, Statistics};
use maud::html;

use super::session::name;
use super::table::{Column, Line, numbers, smallest, table, words};
use super::{Body, Method};
use crate::number::{NARROW_SPACE, NONE, count, decimals, to_mm};

const COLUMNS: [Column<'static>; 12] = [
    words("method"),
    numbers("n", ""),
    numbers("filled", ""),
    numbers("left out", ""),
    numbers("median", "mm"),
    numbers("75 %", "mm"),
    numbers("95 %", "mm"),
    numbers("max", "mm"),
    numbers("median", "°"),
    numbers("75 %", "°"),
    numbers("95 %", "°"),
    numbers("max", "°"),
];
/// Cells of a line before its distances and angles: n, filled, left out.
const COUNTS: usize = 3;

/// The section's content; `None` where no method plans the object.
pub(super) fn section(methods: &[Method<'_>]) -> Option<Body> {
    let planned: Vec<(&Method<'_>, &ObjectError)> = methods
        .iter()
        .filter_map(|method| Some((method, method.evaluation.object_error.as_ref()?)))
        .collect();
    if planned.is_empty() {
        return None;
    }
    let values: Vec<[f64; COLUMNS.len() - 1 - COUNTS]> =
        planned.iter().map(|(_, error)| values(error)).collect();
    let printed = |_: usize, value: f64| decimals(value, 2);
    let lines = planned
        .iter()
        .zip(values.iter().zip(smallest(&values, printed)))
        .map(|((method, error), (own, best))| {
            let s = &error.position;
            let counts = [s.n, s.n_filled, s.n_left_out].map(|n| count(n, NARROW_SPACE));
            Line {
                head: name(method),
                cells: counts
                    .into_iter()
                    .chain(own.map(|value| printed(0, value)))
                    .collect(),
                best: best.into_iter().map(|c| c + COUNTS).collect(),
                stressed: method.default,
            }
        })
        .collect();
    let body = Body::from(html! {
        p {
            "Planned against recorded pose of the object in the hand's frame, at every sample of every test segment where both are known."
        }
        (table("Object: distance between the origins (mm), and angle between the orientations (°)", &COLUMNS, lines))
        p.note {
            "n: instants compared. Filled: those among them at which the object rests on an interpolated sample. Left out: object not tracked, \
             a gap, or a plan that failed. Angle: of the one rotation from the recorded to the planned orientation, 0 to 180°. Bold: smallest of \
             its column among the methods. " (NONE) ": nothing to judge."
        }
    });
    Some(body)
}

fn values(error: &ObjectError) -> [f64; COLUMNS.len() - 1 - COUNTS] {
    let of = |s: &Statistics, unit: fn(f64) -> f64| {
        [s.p50, s.p75, s.p95, s.max].map(|v| if s.n == 0 { f64::NAN } else { unit(v) })
    };
    let [a, b, c, d] = of(&error.position, to_mm);
    let [e, f, g, h] = of(&error.angle, f64::to_degrees);
    [a, b, c, d, e, f, g, h]
}
