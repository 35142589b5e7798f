//! Plan status by method.

use inhand_model::PlanFacts;
use maud::html;

use super::Method;
use crate::figure::scale::Scale;
use crate::figure::{Figure, FigureColumn, FigureData, Frame, Key, Panel, Px, axes};
use crate::number::{NARROW_SPACE, count};
use crate::words::shortened;

const WIDTH: f64 = 460.0;
const TOP: f64 = 26.0;
const ROW_HEIGHT: f64 = 26.0;
const BAR_HEIGHT: f64 = 14.0;
const LETTERS: usize = 16;
const LETTER_WIDTH: f64 = 7.2;
const NUMBERS_WIDTH: f64 = 76.0;

/// Ends of a plan with the class of their colour.
const ENDS: [(&str, &str); 3] = [
    ("solved", "status-solved"),
    ("infeasible", "status-infeasible"),
    ("failed", "status-failed"),
];

/// `None` where no method solved an optimisation.
pub(super) fn figure(methods: &[Method<'_>]) -> Option<Figure> {
    let planned: Vec<(&Method<'_>, [usize; 3])> = methods
        .iter()
        .filter_map(|method| Some((method, ends(method.evaluation.plan.as_ref()?))))
        .filter(|(_, ends)| ends.iter().sum::<usize>() > 0)
        .collect();
    if planned.is_empty() {
        return None;
    }
    let cells = || {
        (planned.iter()).flat_map(|(method, counts)| {
            (ENDS.iter().zip(counts))
                .map(|((end, _), n)| (method.evaluation.name.as_str(), *end, *n))
        })
    };
    Some(Figure {
        id: "plan-status",
        title: "How plans ended.".to_owned(),
        caption: "Share of each method's plans; numbers at the right: solved of all.".to_owned(),
        data: FigureData::new([
            FigureColumn::words("method", cells().map(|cell| cell.0)),
            FigureColumn::words("end", cells().map(|cell| cell.1)),
            FigureColumn::counts("plans", cells().map(|cell| cell.2)),
        ]),
        legend: ENDS.map(|(end, class)| Key::area(end, class)).into(),
        panels: vec![panel(&planned)],
    })
}

fn ends(plan: &PlanFacts) -> [usize; 3] {
    [plan.solved, plan.infeasible, plan.failed]
}

fn panel(planned: &[(&Method<'_>, [usize; 3])]) -> Panel {
    let bottom = TOP + ROW_HEIGHT * planned.len() as f64;
    let longest = planned
        .iter()
        .map(|(method, _)| method.evaluation.name.chars().count())
        .max();
    let frame = Frame {
        left: 8.0 + LETTER_WIDTH * longest.unwrap_or(0).min(LETTERS) as f64,
        top: TOP,
        right: WIDTH - NUMBERS_WIDTH,
        bottom,
    };
    let x = Scale::linear(0.0, 100.0, frame.left, frame.right);
    let shapes = html! {
        text.title x="0" y="12.5" { "How plans ended" }
        (axes::bottom(&frame, &x, 5, "share of plans (%)"))
        @for (place, (method, counts)) in planned.iter().enumerate() {
            @let y = TOP + ROW_HEIGHT * (place as f64 + 0.5);
            @let n = counts.iter().sum::<usize>();
            text.label.stressed[method.default] x=(Px(frame.left - 8.0)) y=(Px(y + 4.0)) text-anchor="end" { (shortened(&method.evaluation.name, LETTERS)) }
            @for (kind, (end, class)) in ENDS.iter().enumerate() {
                @let share = |count: usize| x.at(100.0 * count as f64 / n as f64);
                @let before = counts[..kind].iter().sum::<usize>();
                @if counts[kind] > 0 {
                    g.(class) {
                        rect.area x=(Px(share(before))) y=(Px(y - 0.5 * BAR_HEIGHT)) width=(Px((share(before + counts[kind]) - share(before)).max(1.0))) height=(Px(BAR_HEIGHT)) {
                            title { (method.evaluation.name) ": " (counts[kind]) " of " (n) " " (end) }
                        }
                    }
                }
            }
            text.value x=(Px(WIDTH - 1.0)) y=(Px(y + 4.0)) text-anchor="end" { (count(counts[0], NARROW_SPACE)) " of " (count(n, NARROW_SPACE)) }
        }
    };
    let rows: Vec<String> = (planned.iter())
        .map(|(method, [solved, infeasible, failed])| {
            let name = &method.evaluation.name;
            format!("{name} {solved} solved, {infeasible} infeasible, {failed} failed")
        })
        .collect();
    Panel {
        width: WIDTH,
        height: bottom + axes::BOTTOM_ROOM,
        summary: format!("How plans ended: {}", rows.join("; ")),
        shapes,
    }
}
