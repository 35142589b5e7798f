//! Distances to clouds of points on the object beside exact ones.

use inhand_model::{PointCloud, Statistics};
use maud::{Markup, html};

use super::Body;
use crate::figure::palette::PLAIN_CLASS;
use crate::figure::scale::{Scale, nice_end};
use crate::figure::{Figure, FigureColumn, FigureData, Frame, Panel, Px, axes};
use crate::number::{NARROW_SPACE, count, decimals, percent, to_mm};
use crate::words::{join_words, tied};

const UM_PER_M: f64 = 1e6;
const WIDTH: f64 = 460.0;
const LEFT: f64 = 112.0;
const NUMBERS: f64 = 112.0;
const TOP: f64 = 40.0;
const ROW: f64 = 30.0;
const BOX: f64 = 14.0;

/// The figure and what clouds do to contacts; nothing without clouds.
pub(super) fn part(clouds: &[PointCloud]) -> Body {
    let mut body = Body::default();
    let Some(first) = clouds.first().filter(|cloud| cloud.excess_m.n > 0) else {
        return body;
    };
    let shares: Vec<String> = (clouds.iter())
        .map(|cloud| {
            format!(
                "{} % by {}",
                percent(cloud.three_or_more),
                count(cloud.points, NARROW_SPACE)
            )
        })
        .collect();
    body.prose(html! {
        p {
            "Distances here are to the object's exact surface. By clouds of points on it, as in the paper, three or more recorded \
             fingertips are in contact at " (tied(&join_words(&shares))) " points, against " (percent(first.exact_three_or_more))
            "\u{a0}% by the surface, of the same instants."
        }
    });
    body.figure(Figure {
        id: "point-clouds",
        title: "Distance to a cloud of points less distance to the surface.".to_owned(),
        caption: format!(
            "Over {} distances of recorded fingertips at instants spread over the test segments ({} of them filled), points spread evenly \
             over the surface. A cloud is never nearer than the surface. Boxes: quartiles and median; whiskers: outermost values within \
             1.5 interquartile ranges; dot: 95 % quantile.",
            count(first.excess_m.n, NARROW_SPACE),
            count(first.excess_m.n_filled, NARROW_SPACE),
        ),
        data: data(clouds),
        legend: Vec::new(),
        panels: vec![panel(clouds)],
    });
    body
}

fn um(metres: f64) -> f64 {
    metres * UM_PER_M
}

fn panel(clouds: &[PointCloud]) -> Panel {
    let extents = clouds
        .iter()
        .map(|cloud| um(cloud.excess_m.whisker_high.max(cloud.excess_m.p95)));
    let end_um = nice_end(extents.fold(0.0, f64::max), 5);
    let frame = Frame {
        left: LEFT,
        top: TOP,
        right: WIDTH - NUMBERS,
        bottom: TOP + ROW * clouds.len() as f64,
    };
    let x = Scale::linear(0.0, end_um, frame.left, frame.right);
    let (median_x, max_x) = (WIDTH - 54.0, WIDTH - 1.0);
    let named = |cloud: &PointCloud| format!("{} points", count(cloud.points, NARROW_SPACE));
    let summary: Vec<String> = (clouds.iter())
        .map(|cloud| {
            format!(
                "{}: median {} µm",
                named(cloud),
                decimals(um(cloud.excess_m.p50), 1)
            )
        })
        .collect();
    Panel {
        width: WIDTH,
        height: frame.bottom + axes::BOTTOM_ROOM,
        summary: format!("Box plots of the excess, {}", summary.join(", ")),
        shapes: html! {
            text.title x="0" y="12.5" { "Excess of point clouds" }
            text.tick x=(Px(median_x)) y=(Px(TOP - 6.0)) text-anchor="end" { "median" }
            text.tick x=(Px(max_x)) y=(Px(TOP - 6.0)) text-anchor="end" { "max" }
            (axes::bottom(&frame, &x, 5, "excess (µm)"))
            @for (place, cloud) in clouds.iter().enumerate() {
                @let y = TOP + ROW * (place as f64 + 0.5);
                text.label x=(Px(LEFT - 8.0)) y=(Px(y + 4.0)) text-anchor="end" { (named(cloud)) }
                (glyph(&cloud.excess_m, &x, y))
                text.value x=(Px(median_x)) y=(Px(y + 4.0)) text-anchor="end" { (decimals(um(cloud.excess_m.p50), 1)) }
                text.value.faint x=(Px(max_x)) y=(Px(y + 4.0)) text-anchor="end" { (decimals(um(cloud.excess_m.max), 0)) }
            }
        },
    }
}

fn glyph(s: &Statistics, x: &Scale, y: f64) -> Markup {
    let at = |metres: f64| Px(x.at(um(metres)));
    let (top, half) = (y - 0.5 * BOX, 0.25 * BOX);
    let width = x.at(um(s.p75)) - x.at(um(s.p25));
    html! {
        g.(PLAIN_CLASS) {
            @for (from, to) in [(s.whisker_low, s.p25), (s.p75, s.whisker_high)] {
                line.whisker x1=(at(from)) y1=(Px(y)) x2=(at(to)) y2=(Px(y)) {}
            }
            @for end in [s.whisker_low, s.whisker_high] {
                line.whisker x1=(at(end)) y1=(Px(y - half)) x2=(at(end)) y2=(Px(y + half)) {}
            }
            rect.box x=(at(s.p25)) y=(Px(top)) width=(Px(width.max(0.5))) height=(Px(BOX)) {}
            line.median x1=(at(s.p50)) y1=(Px(top)) x2=(at(s.p50)) y2=(Px(top + BOX)) {}
            circle.dot cx=(at(s.p95)) cy=(Px(y)) r="2.6" {}
        }
    }
}

fn data(clouds: &[PointCloud]) -> FigureData {
    let lengths = |name, of: fn(&Statistics) -> f64| {
        FigureColumn::numbers(name, clouds.iter().map(|cloud| to_mm(of(&cloud.excess_m))))
    };
    let counts =
        |name, of: fn(&PointCloud) -> usize| FigureColumn::counts(name, clouds.iter().map(of));
    let shares = |name, of: fn(&PointCloud) -> f64| {
        FigureColumn::numbers(name, clouds.iter().map(|cloud| 100.0 * of(cloud)))
    };
    FigureData::new([
        counts("points", |cloud| cloud.points),
        counts("n", |cloud| cloud.excess_m.n),
        counts("n_filled", |cloud| cloud.excess_m.n_filled),
        counts("n_left_out", |cloud| cloud.excess_m.n_left_out),
        lengths("mean_mm", |s| s.mean),
        lengths("whisker_low_mm", |s| s.whisker_low),
        lengths("p25_mm", |s| s.p25),
        lengths("p50_mm", |s| s.p50),
        lengths("p75_mm", |s| s.p75),
        lengths("p95_mm", |s| s.p95),
        lengths("whisker_high_mm", |s| s.whisker_high),
        lengths("max_mm", |s| s.max),
        shares("three_or_more_percent", |cloud| cloud.three_or_more),
        shares("exact_three_or_more_percent", |cloud| {
            cloud.exact_three_or_more
        }),
    ])
}
