//! Errors and explained variance against rank, as an SVG file of its own.

use inhand_model::RankPoint;
use maud::{Markup, PreEscaped, html};

use crate::figure::line_chart::{self, Series};
use crate::figure::scale::{Scale, nice_end};
use crate::figure::{Frame, Px, axes};
use crate::words::{decimals, percent, to_mm};

const STYLE: &str = include_str!("rank_figure.css");

/// Narrow enough for a phone to show its text in full size.
const WIDTH: f64 = 372.0;
const HEIGHT: f64 = 530.0;
/// Around everything: the file has no page that would keep its edges free.
const EDGE: f64 = 12.0;
const LEFT: f64 = 44.0;
const RIGHT: f64 = 10.0;
/// Frames of the two panels.
const ERRORS: (f64, f64) = (106.0, 306.0);
const VARIANCE: (f64, f64) = (376.0, 486.0);
const WANTED_TICKS: usize = 6;
/// Half the width of an error bar's ends.
const CAP: f64 = 3.0;
/// Length of a line in the legend.
const KEY: f64 = 22.0;

/// Errors of dictionaries against their rank.
#[derive(Clone, Debug, PartialEq)]
pub struct RankFigure {
    /// Session and method of learning, such as `cube, nmf`.
    pub title: String,
    /// One for each rank, smallest first.
    pub points: Vec<RankPoint>,
    /// The rank suggested.
    pub suggested: usize,
    /// Largest prediction error that counts as good as the smallest, metres.
    pub limit_m: f64,
    /// Why this rank, in a sentence.
    pub reason: String,
}

/// A line of the upper panel: class, label and error, metres.
type ErrorLine = (&'static str, &'static str, fn(&RankPoint) -> f64);

/// Lines, the last one on top.
const LINES: [ErrorLine; 3] = [
    ("b1", "training segments, reconstructed", |point| {
        point.training_rms_m
    }),
    ("b0", "left-out segments, reconstructed", |point| {
        point.reconstructed.rms_m
    }),
    (
        "l0",
        "left-out segments, hidden middle predicted",
        |point| point.predicted.rms_m,
    ),
];

/// The figure as one SVG file that needs no other: two panels, errors in millimetres and the share of
/// variance not explained in percent, both against rank, the suggested rank marked. Colours
/// follow the reader's light or dark scheme; title and description say what is shown to those who do
/// not see it. Same figure, same bytes.
pub fn rank_figure_svg(figure: &RankFigure) -> String {
    let ranks = || figure.points.iter().map(|point| point.rank as f64);
    let (first, last) = (
        ranks().fold(f64::INFINITY, f64::min),
        ranks().fold(f64::NEG_INFINITY, f64::max),
    );
    // A single rank is in the middle.
    let around = if first < last { 0.0 } else { 1.0 };
    let x = Scale::linear(first - around, last + around).over(LEFT, WIDTH - RIGHT);
    let markup = html! {
        svg.page xmlns="http://www.w3.org/2000/svg" viewBox={ (Px(-EDGE)) " " (Px(-EDGE)) " " (Px(WIDTH + 2.0 * EDGE)) " " (Px(HEIGHT + 2.0 * EDGE)) } role="img" aria-labelledby="title desc" {
            title id="title" { "Errors against rank: " (figure.title) }
            desc id="desc" { (description(figure)) }
            style { (PreEscaped(STYLE)) }
            rect.paper x=(Px(-EDGE)) y=(Px(-EDGE)) width="100%" height="100%" {}
            text.title x="0" y="12.5" { "Errors against rank: " (figure.title) }
            @for (place, (class, label, _)) in LINES.iter().rev().enumerate() {
                @let y = 34.0 + 18.0 * place as f64;
                g.(class) { path.line d={ "M0 " (Px(y - 4.0)) "h" (Px(KEY)) } {} }
                text x=(Px(KEY + 7.0)) y=(Px(y)) { (label) }
            }
            (errors(figure, &x))
            (variance(figure, &x))
        }
    };
    format!("{}\n", markup.into_string())
}

fn errors(figure: &RankFigure, x: &Scale) -> Markup {
    let frame = frame(ERRORS);
    let series = LINES.map(|(class, label, of)| {
        let points = figure.points.iter();
        Series::new(
            label,
            class,
            points.map(|point| (point.rank as f64, to_mm(of(point)))),
        )
    });
    let bars = figure.points.iter().filter_map(|point| {
        Some(to_mm(
            point.predicted.rms_m + point.predicted.standard_error_m?,
        ))
    });
    let known = line_chart::heights(&series).chain(bars.filter(|top| top.is_finite()));
    let top = nice_end(known.fold(0.0, f64::max), WANTED_TICKS);
    let y = Scale::linear(0.0, top).over(frame.bottom, frame.top);
    let at = |error_m: f64| y.at(to_mm(error_m));
    let suggested = x.at(figure.suggested as f64);
    let chosen = (figure.points.iter()).find(|point| point.rank == figure.suggested);
    html! {
        (axes::left(&frame, &y, WANTED_TICKS, "error (rms), mm"))
        (axes::bottom(&frame, x, WANTED_TICKS, ""))
        @if at(figure.limit_m).is_finite() {
            line.limit x1=(Px(frame.left)) y1=(Px(at(figure.limit_m))) x2=(Px(frame.right)) y2=(Px(at(figure.limit_m))) {}
        }
        (frame.mark(suggested))
        (mark_label(suggested, &frame, figure.suggested))
        (line_chart::lines(&series, x, &y, true))
        g.l0 {
            @for point in &figure.points {
                @if let Some(error_m) = point.predicted.standard_error_m {
                    (error_bar(x.at(point.rank as f64), at(point.predicted.rms_m + error_m), at(point.predicted.rms_m - error_m)))
                }
            }
        }
        @if let Some(point) = chosen {
            circle.chosen cx=(Px(suggested)) cy=(Px(at(point.predicted.rms_m))) r="6" {}
        }
    }
}

fn variance(figure: &RankFigure, x: &Scale) -> Markup {
    let frame = frame(VARIANCE);
    // What is explained in full has no place on a logarithmic axis.
    let left_percent = |point: &RankPoint| match 100.0 * (1.0 - point.explained_variance) {
        left if left > 0.0 => left,
        _ => f64::NAN,
    };
    let points = figure
        .points
        .iter()
        .map(|point| (point.rank as f64, left_percent(point)));
    let series = [Series::new("variance not explained (%)", "plain", points)];
    let low = line_chart::heights(&series).fold(f64::INFINITY, f64::min);
    let high = line_chart::heights(&series).fold(0.0, f64::max);
    let y = Scale::log(low, high).over(frame.bottom, frame.top);
    html! {
        (axes::left(&frame, &y, 4, "training variance not explained, %"))
        (axes::bottom(&frame, x, WANTED_TICKS, "rank (number of primitives)"))
        (frame.mark(x.at(figure.suggested as f64)))
        (line_chart::lines(&series, x, &y, true))
    }
}

fn frame((top, bottom): (f64, f64)) -> Frame {
    Frame::new([LEFT, WIDTH - RIGHT], [top, bottom])
}

/// The suggested rank at its mark, on the side that has room.
fn mark_label(at: f64, frame: &Frame, rank: usize) -> Markup {
    let (x, anchor) = if at < 0.5 * (frame.left + frame.right) {
        (at + 6.0, "start")
    } else {
        (at - 6.0, "end")
    };
    html! { text x=(Px(x)) y=(Px(frame.top + 11.0)) text-anchor=(anchor) { "suggested: " (rank) } }
}

fn error_bar(x: f64, top: f64, bottom: f64) -> Markup {
    html! {
        path.bar d={ "M" (Px(x)) " " (Px(top)) "V" (Px(bottom)) "M" (Px(x - CAP)) " " (Px(top)) "h" (Px(2.0 * CAP)) "M" (Px(x - CAP)) " " (Px(bottom)) "h" (Px(2.0 * CAP)) } {}
    }
}

/// Description for readers who do not see it.
fn description(figure: &RankFigure) -> String {
    let (Some(first), Some(last)) = (figure.points.first(), figure.points.last()) else {
        return "No rank could be evaluated.".to_owned();
    };
    let from_to = |of: fn(&RankPoint) -> f64| {
        format!(
            "from {} to {} mm",
            decimals(to_mm(of(first)), 2),
            decimals(to_mm(of(last)), 2)
        )
    };
    let [training, reconstructed, predicted] = LINES.map(|(.., of)| from_to(of));
    format!(
        "Two line charts over ranks {} to {}. Root mean square errors: training segments \
         reconstructed {training}, left-out segments reconstructed {reconstructed}, their hidden middle \
         predicted {predicted}. Explained training variance: {} to {} percent. {}",
        first.rank,
        last.rank,
        percent(first.explained_variance),
        percent(last.explained_variance),
        figure.reason
    )
}

#[cfg(test)]
mod tests {
    use inhand_model::HeldOut;

    use super::*;

    fn figure() -> RankFigure {
        let point = |rank: usize, predicted_m: f64| RankPoint {
            rank,
            explained_variance: 1.0 - 0.1 / rank as f64,
            training_rms_m: 0.01 / rank as f64,
            reconstructed: HeldOut {
                rms_m: 0.012 / rank as f64,
                standard_error_m: None,
            },
            predicted: HeldOut {
                rms_m: predicted_m,
                standard_error_m: Some(0.000_1),
            },
        };
        RankFigure {
            title: "a < b, nmf".to_owned(),
            points: vec![point(10, 0.002), point(20, 0.001), point(30, 0.001_2)],
            suggested: 20,
            limit_m: 0.001_1,
            reason: "Rank 20 is enough.".to_owned(),
        }
    }

    #[test]
    fn a_file_of_its_own_that_says_what_it_shows() {
        let svg = rank_figure_svg(&figure());
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
        for part in [
            "xmlns=\"http://www.w3.org/2000/svg\"",
            "aria-labelledby=\"title desc\"",
            "prefers-color-scheme: dark",
            "a &lt; b, nmf",
            "Rank 20 is enough.",
            "suggested: 20",
            "error (rms), mm",
            "rank (number of primitives)",
        ] {
            assert!(svg.contains(part), "{part} in {svg}");
        }
        assert_eq!(svg.matches("class=\"bar\"").count(), 3);
        assert_eq!(svg.matches("class=\"point\"").count(), 12);
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }

    #[test]
    fn what_does_not_exist_is_not_drawn() {
        let mut figure = figure();
        figure.points.truncate(1);
        figure.points[0].predicted.standard_error_m = None;
        figure.points[0].explained_variance = 1.0;
        figure.points[0].training_rms_m = f64::NAN;
        figure.suggested = 10;
        let svg = rank_figure_svg(&figure);
        assert_eq!(svg.matches("class=\"bar\"").count(), 0);
        assert_eq!(svg.matches("class=\"point\"").count(), 2);
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        figure.points.clear();
        assert!(rank_figure_svg(&figure).contains("No rank could be evaluated."));
    }
}
