//! Box plots lying on their side: one row a distribution, its name at the left, its median and
//! largest value as numbers at the right.

use inhand_model::Statistics;
use maud::{Markup, html};

use super::scale::{Scale, nice_end};
use super::{FigureColumn, FigureData, Frame, Panel, Px, axes};
use crate::number::{NARROW_SPACE, count, decimals, millimetres, to_mm};
use crate::words::shortened;

/// One distribution.
pub(crate) struct Row<'a> {
    /// Name at the left.
    pub(crate) label: &'a str,
    /// Class that colours the box.
    pub(crate) class: &'a str,
    /// Whether the name is stressed.
    pub(crate) stressed: bool,
    /// The distribution, metres.
    pub(crate) statistics: &'a Statistics,
}

/// A figure of several distributions on one axis.
pub(crate) struct BoxPlot<'a> {
    /// What is shown, above the figure.
    pub(crate) title: &'a str,
    /// Class of a swatch before the title.
    pub(crate) swatch: Option<&'a str>,
    /// Name of the axis with its unit.
    pub(crate) axis_name: &'a str,
    /// Where the axis ends, mm; [`shared_end_mm`] chooses it for several figures.
    pub(crate) end_mm: f64,
    /// Distributions from top to bottom.
    pub(crate) rows: Vec<Row<'a>>,
}

const WIDTH: f64 = 380.0;
/// Longest name that is written out; a longer one ends in an ellipsis and is whole in the tooltip.
const LABEL_LETTERS: usize = 20;
/// Width of a letter at the figure's text size, generous enough for bold and for most fonts.
const LETTER_WIDTH: f64 = 7.2;
const LABEL_GAP: f64 = 8.0;
const NUMBERS_WIDTH: f64 = 96.0;
const TOP: f64 = 38.0;
const ROW_HEIGHT: f64 = 26.0;
const BOX_HEIGHT: f64 = 14.0;
const WANTED_TICKS: usize = 5;

/// Multiple of the typical third quartile that an axis may reach; one wild method must not press
/// the others flat.
const REACH: f64 = 6.0;

/// An axis end for all of `distributions`: far enough for their whiskers and 95 % quantiles,
/// unless a few of them are so much wider than the rest that the rest would be unreadable.
pub(crate) fn shared_end_mm<'a>(distributions: impl IntoIterator<Item = &'a Statistics>) -> f64 {
    let shown: Vec<&Statistics> = distributions.into_iter().filter(|s| drawable(s)).collect();
    let widest = shown.iter().map(|s| extent_mm(s)).fold(0.0, f64::max);
    let mut quartiles: Vec<f64> = shown.iter().map(|s| to_mm(s.p75)).collect();
    quartiles.sort_by(f64::total_cmp);
    let limit = quartiles
        .get(quartiles.len() / 2)
        .map_or(widest, |typical| REACH * typical);
    // A limit of zero (most distributions are all zero) would leave no axis.
    let end = if limit > 0.0 {
        widest.min(limit)
    } else {
        widest
    };
    nice_end(end, WANTED_TICKS * 2)
}

/// How many of `distributions` reach past `end_mm` with a whisker or 95 % quantile.
pub(crate) fn cut_off<'a>(
    distributions: impl IntoIterator<Item = &'a Statistics>,
    end_mm: f64,
) -> usize {
    distributions
        .into_iter()
        .filter(|s| drawable(s) && extent_mm(s) > end_mm)
        .count()
}

fn extent_mm(statistics: &Statistics) -> f64 {
    to_mm(statistics.whisker_high.max(statistics.p95))
}

fn drawable(statistics: &Statistics) -> bool {
    let s = statistics;
    s.n > 0
        && [s.whisker_low, s.p25, s.p50, s.p75, s.p95, s.whisker_high]
            .iter()
            .all(|v| v.is_finite())
}

/// Draws the figure.
pub(crate) fn draw(plot: &BoxPlot<'_>) -> Panel {
    let bottom = TOP + ROW_HEIGHT * plot.rows.len() as f64;
    let height = bottom + axes::BOTTOM_ROOM;
    let frame = Frame {
        left: label_width(plot),
        top: TOP,
        right: WIDTH - NUMBERS_WIDTH,
        bottom,
    };
    let scale = Scale::linear(0.0, plot.end_mm, frame.left, frame.right);
    let (median_x, max_x) = (WIDTH - 46.0, WIDTH - 1.0);
    let shapes = html! {
            @if let Some(class) = plot.swatch {
                g.(class) { rect.key x="0.5" y="2.5" width="11" height="11" rx="2" {} }
                text.title x="18" y="12.5" { (plot.title) }
            } @else {
                text.title x="0" y="12.5" { (plot.title) }
            }
            text.tick x=(Px(median_x)) y=(Px(TOP - 6.0)) text-anchor="end" { "median" }
            text.tick x=(Px(max_x)) y=(Px(TOP - 6.0)) text-anchor="end" { "max" }
            (axes::bottom(&frame, &scale, WANTED_TICKS, plot.axis_name))
            @for (place, row) in plot.rows.iter().enumerate() {
                @let y = TOP + ROW_HEIGHT * (place as f64 + 0.5);
                g.row {
                    title { (tooltip(plot.title, row)) }
                    rect.hover x="0" y=(Px(y - 0.5 * ROW_HEIGHT)) width=(Px(WIDTH)) height=(Px(ROW_HEIGHT)) {}
                    text.label.stressed[row.stressed] x=(Px(frame.left - LABEL_GAP)) y=(Px(y + 4.0)) text-anchor="end" { (shortened(row.label, LABEL_LETTERS)) }
                    @if drawable(row.statistics) {
                        (glyph(row, &frame, &scale, y))
                        text.value x=(Px(median_x)) y=(Px(y + 4.0)) text-anchor="end" { (millimetres(row.statistics.p50)) }
                        text.value.faint x=(Px(max_x)) y=(Px(y + 4.0)) text-anchor="end" { (decimals(to_mm(row.statistics.max), 1)) }
                    } @else {
                        text.tick x=(Px(frame.left + 8.0)) y=(Px(y + 4.0)) { "nothing to judge" }
                    }
                }
            }
    };
    Panel {
        width: WIDTH,
        height,
        summary: summary(plot),
        shapes,
    }
}

/// The table behind boxes: a row for each, told apart by words.
pub(crate) fn data<'a>(
    boxes: impl IntoIterator<Item = (&'a str, &'a str, &'a Statistics)>,
) -> FigureData {
    let boxes: Vec<_> = boxes.into_iter().collect();
    let counts = |name, of: fn(&Statistics) -> usize| {
        FigureColumn::counts(name, boxes.iter().map(|(_, _, s)| of(s)))
    };
    let lengths = |name, of: fn(&Statistics) -> f64| {
        let length = |s: &Statistics| if s.n == 0 { f64::NAN } else { to_mm(of(s)) };
        FigureColumn::numbers(name, boxes.iter().map(|(_, _, s)| length(s)))
    };
    FigureData::new([
        FigureColumn::words("finger", boxes.iter().map(|(finger, ..)| *finger)),
        FigureColumn::words("motion", boxes.iter().map(|(_, motion, _)| *motion)),
        counts("n", |s| s.n),
        counts("n_filled", |s| s.n_filled),
        counts("n_left_out", |s| s.n_left_out),
        lengths("mean_mm", |s| s.mean),
        lengths("rmse_mm", |s| s.rmse),
        lengths("min_mm", |s| s.min),
        lengths("whisker_low_mm", |s| s.whisker_low),
        lengths("p5_mm", |s| s.p5),
        lengths("p25_mm", |s| s.p25),
        lengths("p50_mm", |s| s.p50),
        lengths("p75_mm", |s| s.p75),
        lengths("p95_mm", |s| s.p95),
        lengths("whisker_high_mm", |s| s.whisker_high),
        lengths("max_mm", |s| s.max),
    ])
}

fn label_width(plot: &BoxPlot<'_>) -> f64 {
    let longest = plot
        .rows
        .iter()
        .map(|row| row.label.chars().count())
        .max()
        .unwrap_or(0);
    LABEL_GAP + LETTER_WIDTH * longest.min(LABEL_LETTERS) as f64
}

/// Whiskers, box, median and the dot of the 95 % quantile; what lies past the axis is replaced by
/// an arrow head at its end.
fn glyph(row: &Row<'_>, frame: &Frame, scale: &Scale, y: f64) -> Markup {
    let s = row.statistics;
    let x = |metres: f64| scale.at(to_mm(metres).clamp(0.0, scale.high()));
    let past = |metres: f64| to_mm(metres) > scale.high();
    let (top, half) = (y - 0.5 * BOX_HEIGHT, 0.25 * BOX_HEIGHT);
    html! {
        g.(row.class) {
            line.whisker x1=(Px(x(s.whisker_low))) y1=(Px(y)) x2=(Px(x(s.p25))) y2=(Px(y)) {}
            line.whisker x1=(Px(x(s.whisker_low))) y1=(Px(y - half)) x2=(Px(x(s.whisker_low))) y2=(Px(y + half)) {}
            line.whisker x1=(Px(x(s.p75))) y1=(Px(y)) x2=(Px(x(s.whisker_high))) y2=(Px(y)) {}
            @if !past(s.whisker_high) {
                line.whisker x1=(Px(x(s.whisker_high))) y1=(Px(y - half)) x2=(Px(x(s.whisker_high))) y2=(Px(y + half)) {}
            }
            // Half a pixel at least: a box without width is still a box.
            rect.box x=(Px(x(s.p25))) y=(Px(top)) width=(Px((x(s.p75) - x(s.p25)).max(0.5))) height=(Px(BOX_HEIGHT)) {}
            @if !past(s.p50) {
                line.median x1=(Px(x(s.p50))) y1=(Px(top)) x2=(Px(x(s.p50))) y2=(Px(top + BOX_HEIGHT)) {}
            }
            @if !past(s.p95) {
                circle.dot cx=(Px(x(s.p95))) cy=(Px(y)) r="2.6" {}
            }
            @if past(s.whisker_high) || past(s.p95) {
                path.past d={
                    "M" (Px(frame.right - 1.0)) " " (Px(y - 4.0))
                    "l6 4l-6 4z"
                } {}
            }
        }
    }
}

fn tooltip(title: &str, row: &Row<'_>) -> String {
    let s = row.statistics;
    if !drawable(s) {
        return format!("{}, {title}: nothing to judge", row.label);
    }
    let mm = |metres: f64| decimals(to_mm(metres), 2);
    format!(
        "{}, {title}: n {}; whiskers {} to {}; 5 % {}, 25 % {}, median {}, 75 % {}, 95 % {}, max {} mm",
        row.label,
        count(s.n, NARROW_SPACE),
        mm(s.whisker_low),
        mm(s.whisker_high),
        mm(s.p5),
        mm(s.p25),
        mm(s.p50),
        mm(s.p75),
        mm(s.p95),
        mm(s.max),
    )
}

/// What the figure says, for those who do not see it.
fn summary(plot: &BoxPlot<'_>) -> String {
    let rows: Vec<String> = plot
        .rows
        .iter()
        .map(|row| match drawable(row.statistics) {
            true => format!(
                "{} median {} mm",
                row.label,
                millimetres(row.statistics.p50)
            ),
            false => format!("{} nothing to judge", row.label),
        })
        .collect();
    format!("Box plots, {}: {}", plot.title, rows.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distribution(p75: f64, whisker_high: f64) -> Statistics {
        Statistics {
            n: 4,
            p25: 0.5 * p75,
            p50: 0.7 * p75,
            p75,
            p95: whisker_high,
            whisker_high,
            max: 2.0 * whisker_high,
            ..Statistics::default()
        }
    }

    #[test]
    fn the_axis_reaches_the_widest_whisker() {
        let all = [distribution(0.001, 0.002_9), distribution(0.002, 0.004_1)];
        assert!((shared_end_mm(&all) - 4.5).abs() < 1e-9);
        assert_eq!(cut_off(&all, 4.5), 0);
    }

    #[test]
    fn one_wild_method_does_not_press_the_others_flat() {
        let all = [
            distribution(0.001, 0.002),
            distribution(0.001, 0.002),
            distribution(0.1, 0.3),
        ];
        let end = shared_end_mm(&all);
        assert!((end - 6.0).abs() < 1e-9, "{end}");
        assert_eq!(cut_off(&all, end), 1);
    }

    #[test]
    fn nothing_gives_an_axis_all_the_same() {
        assert_eq!(shared_end_mm(&[]), 1.0);
        assert_eq!(shared_end_mm(&[Statistics::default()]), 1.0);
        let broken = Statistics {
            n: 3,
            p50: f64::NAN,
            ..Statistics::default()
        };
        assert_eq!(shared_end_mm(&[broken]), 1.0);
    }
}
