//! Lines over a quantity: error over time, contact share over threshold, objective over iterations.

use maud::{Markup, html};

use super::scale::{Axis, Extent, Scale};
use super::{FigureData, Frame, Key, Panel, Px, axes};
use crate::words::{plain, short};

/// One line. Points that are not finite break it.
#[derive(Clone)]
pub(crate) struct Series {
    /// Name, in the tooltip.
    pub(crate) label: String,
    /// Class that colours and dashes it.
    pub(crate) class: String,
    /// Points in data units.
    pub(crate) points: Vec<(f64, f64)>,
    /// Whether it is drawn above the others.
    pub(crate) on_top: bool,
}

impl Series {
    /// A line of points.
    pub(crate) fn new(
        label: impl Into<String>,
        class: impl Into<String>,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        Self {
            label: label.into(),
            class: class.into(),
            points: points.into_iter().collect(),
            on_top: false,
        }
    }
}

/// Entries of a legend for the lines.
pub(crate) fn keys(series: &[Series]) -> Vec<Key> {
    (series.iter())
        .map(|line| Key::line(&line.label, &line.class))
        .collect()
}

/// Those of the second values of all points that are finite.
pub(crate) fn heights(series: &[Series]) -> impl Iterator<Item = f64> {
    let points = series.iter().flat_map(|line| &line.points);
    points.map(|point| point.1).filter(|y| y.is_finite())
}

/// A vertical axis on which half the highest point of each line is legible: most of a line is below its maximum.
pub(crate) fn comparing(series: &[Series]) -> Scale {
    let extents = series.iter().map(|line| {
        let own = std::slice::from_ref(line);
        let high = heights(own).fold(0.0, f64::max);
        Extent {
            low: heights(own).fold(f64::INFINITY, f64::min),
            typical: 0.5 * high,
            high,
        }
    });
    Scale::comparing(extents, WANTED_TICKS)
}

/// A figure of lines.
#[derive(Default)]
pub(crate) struct LineChart<'a> {
    /// Title above the panel; empty where the figure's own says it all.
    pub(crate) title: &'a str,
    /// Horizontal axis.
    pub(crate) x: Axis<'a>,
    /// Vertical axis.
    pub(crate) y: Axis<'a>,
    /// Lines; later ones are drawn above earlier ones.
    pub(crate) series: &'a [Series],
    /// Whether each point gets a dot with its values as tooltip.
    pub(crate) dots: bool,
    /// A value on the horizontal axis to mark, with its name.
    pub(crate) marked_x: Option<(f64, String)>,
}

const WIDTH: f64 = 460.0;
const HEIGHT: f64 = 268.0;
const LEFT: f64 = 50.0;
const RIGHT: f64 = 18.0;
const TOP: f64 = 26.0;
/// Radius of a dot and a half-pixel.
const MARGIN: f64 = 3.0;
const WANTED_TICKS: usize = 6;

/// Draws the figure. Lines that leave the axes are cut at the frame.
pub(crate) fn draw(chart: &LineChart<'_>) -> Panel {
    let frame = Frame::new([LEFT, WIDTH - RIGHT], [TOP, HEIGHT - axes::BOTTOM_ROOM]);
    let x = chart.x.1.over(frame.left, frame.right);
    let y = chart.y.1.over(frame.bottom, frame.top);
    // A nested svg cuts what leaves it, without the id that a clip path would need. It is a little
    // larger than the frame, so that lines and dots on the frame stay whole.
    let cut = Frame::new(
        [frame.left - MARGIN, frame.right + MARGIN],
        [frame.top - MARGIN, frame.bottom + MARGIN],
    );
    let inner_x = chart.x.1.over(MARGIN, MARGIN + frame.width());
    let inner_y = chart.y.1.over(MARGIN + frame.height(), MARGIN);
    let mut series: Vec<&Series> = chart.series.iter().collect();
    series.sort_by_key(|line| line.on_top);
    let shapes = html! {
            (axes::left(&frame, &y, WANTED_TICKS, chart.y.0))
            (axes::bottom(&frame, &x, WANTED_TICKS, chart.x.0))
            svg.plot x=(Px(cut.left)) y=(Px(cut.top)) width=(Px(cut.width())) height=(Px(cut.height()))
                data-x=(inner_x.describe()) data-y=(inner_y.describe()) data-x-name=(chart.x.0) data-y-name=(chart.y.0) {
                @if let Some((value, name)) = &chart.marked_x {
                    @let at = inner_x.at(*value);
                    line.mark x1=(Px(at)) y1=(Px(MARGIN)) x2=(Px(at)) y2=(Px(MARGIN + frame.height())) {}
                    text.tick x=(Px(at + 5.0)) y=(Px(frame.height() - 7.0)) { (name) }
                }
                (lines(series, &inner_x, &inner_y, chart.dots))
            }
    };
    Panel {
        title: chart.title.into(),
        width: WIDTH,
        height: HEIGHT,
        summary: summary(chart),
        shapes,
    }
}

/// Lines on these scales, with a dot at each point where wanted.
pub(crate) fn lines<'s>(
    series: impl IntoIterator<Item = &'s Series>,
    x: &Scale,
    y: &Scale,
    dots: bool,
) -> Markup {
    let known = |&&(px, py): &&(f64, f64)| dots && px.is_finite() && py.is_finite();
    html! {
        @for line in series {
            g.(line.class) {
                path.line d=(path(line.points.iter().map(|&(a, b)| (x.at(a), y.at(b))))) { title { (line.label) } }
                @for &(px, py) in line.points.iter().filter(known) {
                    circle.point cx=(Px(x.at(px))) cy=(Px(y.at(py))) r="2.4" {
                        title { (line.label) ": " (plain(px)) ", " (short(py)) }
                    }
                }
            }
        }
    }
}

/// The table behind lines: a row for each point, `x` and `y` naming the columns.
pub(crate) fn data(x: &str, y: &str, series: &[Series]) -> FigureData {
    let points: Vec<(&str, &(f64, f64))> = (series.iter())
        .flat_map(|line| line.points.iter().map(|point| (line.label.as_str(), point)))
        .collect();
    FigureData::about(&points)
        .words("line", |point| point.0)
        .numbers(x, |point| point.1.0)
        .numbers(y, |point| point.1.1)
        .done()
}

/// A line through points in pixels; one that is not finite breaks it.
pub(crate) fn path(points: impl IntoIterator<Item = (f64, f64)>) -> String {
    let mut path = String::new();
    let mut pen_down = false;
    for (px, py) in points {
        if px.is_finite() && py.is_finite() {
            path.push(if pen_down { 'L' } else { 'M' });
            path.push_str(&format!("{} {}", Px(px), Px(py)));
            pen_down = true;
        } else {
            pen_down = false;
        }
    }
    path
}

fn summary(chart: &LineChart<'_>) -> String {
    let names: Vec<&str> = chart.series.iter().map(|s| s.label.as_str()).collect();
    let (title, y, x) = (chart.title, chart.y.0, chart.x.0);
    let title = match title {
        "" => String::new(),
        title => format!("{title}: "),
    };
    format!("{title}{y} over {x}, lines {}", names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_point_breaks_the_line() {
        let points = [
            (0.0, 10.0),
            (10.0, 0.0),
            (20.0, f64::NAN),
            (30.0, 0.0),
            (40.0, 10.0),
        ];
        assert_eq!(path(points), "M0 10L10 0M30 0L40 10");
    }
}
