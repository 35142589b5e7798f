//! Planning times.

use maud::{Markup, html};

use super::table::{Line, numbers, table, words};
use super::{Body, Method};
use crate::figure::palette::PLAIN_CLASS;
use crate::figure::scale::Scale;
use crate::figure::{Figure, FigureColumn, FigureData, Frame, Panel, Px, axes};
use crate::number::{NARROW_SPACE, count, decimals};
use crate::report::PlanTimes;
use crate::words::shortened;

const WIDTH: f64 = 460.0;
const LABEL_LETTERS: usize = 16;
const LEFT: f64 = 116.0;
const RIGHT: f64 = 18.0;
const TOP: f64 = 28.0;
const ROW: f64 = 28.0;

/// The figure and its table; `None` where no time is known.
pub(super) fn section(times: &[PlanTimes], methods: &[Method<'_>]) -> Option<Body> {
    let known: Vec<&PlanTimes> = (times.iter())
        .filter(|times| {
            times.n > 0
                && [times.p50_ms, times.p95_ms, times.max_ms]
                    .iter()
                    .all(|v| *v > 0.0 && v.is_finite())
        })
        .collect();
    if known.is_empty() {
        return None;
    }
    let mut body = Body::default();
    body.figure(Figure {
        id: "plan-times",
        title: "Time of single plans.".to_owned(),
        caption: "From the median (line) over the 95 % quantile (dot) to the longest (end). Times are those of the machine \
            that made the run, and of other work on it meanwhile."
            .to_owned(),
        data: data(&known),
        legend: Vec::new(),
        panels: vec![panel(&known, methods)],
    });
    body.prose(numbers_of(&known));
    Some(body)
}

fn panel(times: &[&PlanTimes], methods: &[Method<'_>]) -> Panel {
    let low = times
        .iter()
        .map(|times| times.p50_ms)
        .fold(f64::INFINITY, f64::min);
    let high = times.iter().map(|times| times.max_ms).fold(0.0, f64::max);
    let frame = Frame {
        left: LEFT,
        top: TOP,
        right: WIDTH - RIGHT,
        bottom: TOP + ROW * times.len() as f64,
    };
    let x = Scale::log(low, high, frame.left, frame.right);
    let class = |name: &str| {
        let method = methods.iter().find(|method| method.evaluation.name == name);
        method.map_or(PLAIN_CLASS, |method| method.class.as_str())
    };
    let said: Vec<String> = (times.iter())
        .map(|times| format!("{} median {} ms", times.method, decimals(times.p50_ms, 2)))
        .collect();
    Panel {
        width: WIDTH,
        height: frame.bottom + axes::BOTTOM_ROOM,
        summary: format!("Time of plans: {}", said.join(", ")),
        shapes: html! {
            text.title x="0" y="12.5" { "Time of a plan" }
            (axes::bottom(&frame, &x, 6, "time (ms, logarithmic)"))
            @for (place, times) in times.iter().enumerate() {
                @let y = TOP + ROW * (place as f64 + 0.5);
                text.label x=(Px(LEFT - 8.0)) y=(Px(y + 4.0)) text-anchor="end" { (shortened(&times.method, LABEL_LETTERS)) }
                g.(class(&times.method)) {
                    title { (times.method) ": " (count(times.n, NARROW_SPACE)) " plans; median " (decimals(times.p50_ms, 2)) ", 95 % " (decimals(times.p95_ms, 2)) ", longest " (decimals(times.max_ms, 2)) " ms" }
                    line.whisker x1=(Px(x.at(times.p50_ms))) y1=(Px(y)) x2=(Px(x.at(times.max_ms))) y2=(Px(y)) {}
                    line.whisker x1=(Px(x.at(times.max_ms))) y1=(Px(y - 4.0)) x2=(Px(x.at(times.max_ms))) y2=(Px(y + 4.0)) {}
                    line.median x1=(Px(x.at(times.p50_ms))) y1=(Px(y - 7.0)) x2=(Px(x.at(times.p50_ms))) y2=(Px(y + 7.0)) {}
                    circle.dot cx=(Px(x.at(times.p95_ms))) cy=(Px(y)) r="3" {}
                }
            }
        },
    }
}

fn data(times: &[&PlanTimes]) -> FigureData {
    let ms = |name, of: fn(&PlanTimes) -> f64| {
        FigureColumn::numbers(name, times.iter().map(|times| of(times)))
    };
    FigureData::new([
        FigureColumn::words("method", times.iter().map(|times| times.method.as_str())),
        FigureColumn::counts("n", times.iter().map(|times| times.n)),
        ms("p50_ms", |times| times.p50_ms),
        ms("p95_ms", |times| times.p95_ms),
        ms("max_ms", |times| times.max_ms),
    ])
}

fn numbers_of(times: &[&PlanTimes]) -> Markup {
    let columns = [
        words("method"),
        numbers("plans", ""),
        numbers("median", "ms"),
        numbers("95 %", "ms"),
        numbers("longest", "ms"),
    ];
    let lines = times.iter().map(|times| Line {
        head: html! { (times.method) },
        cells: std::iter::once(count(times.n, NARROW_SPACE))
            .chain([times.p50_ms, times.p95_ms, times.max_ms].map(|ms| decimals(ms, 2)))
            .collect(),
        best: Vec::new(),
        stressed: false,
    });
    table("Time of single plans", &columns, lines.collect())
}
