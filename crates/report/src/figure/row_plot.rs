//! Named rows on one axis: boxes, intervals, shares, each with its numbers at the right.

use inhand_model::Finger;
use maud::{Markup, html};

use super::scale::{Axis, Scale};
use super::{Frame, Panel, PanelTitle, Px, axes, finger_class};
use crate::words::shortened;

/// Rows on one axis.
#[derive(Default)]
pub(crate) struct RowPlot<'a> {
    /// Title above the panel; empty where the figure's own says it all.
    pub(crate) title: &'a str,
    /// Class of a swatch before the title.
    pub(crate) swatch: Option<&'static str>,
    /// The axis.
    pub(crate) axis: Axis<'a>,
    /// A value on the axis to mark, with its name.
    pub(crate) marked: Option<(f64, &'a str)>,
    /// Headings of the numbers at the right.
    pub(crate) numbers: &'a [&'a str],
    /// Rows from top to bottom.
    pub(crate) rows: Vec<PlotRow<'a>>,
}

/// A row of a plot.
#[derive(Default)]
pub(crate) struct PlotRow<'a> {
    /// Name of the rows from this one on, written once at their left, such as a method; empty without.
    pub(crate) group: &'a str,
    /// Name at the left.
    pub(crate) label: &'a str,
    /// Class that colours its marks.
    pub(crate) class: &'a str,
    /// Whether the name is stressed.
    pub(crate) stressed: bool,
    /// Everything in words, shown under the pointer; empty where the marks have words of their own.
    pub(crate) tooltip: String,
    /// Marks from the lowest to the one on top; without any nothing was evaluated.
    pub(crate) marks: Vec<Mark>,
    /// Numbers at the right.
    pub(crate) numbers: Vec<String>,
}

impl<'a> PlotRow<'a> {
    /// A row without marks.
    pub(crate) fn new(label: &'a str, class: &'a str) -> Self {
        Self {
            label,
            class,
            ..Self::default()
        }
    }
}

/// A shape on the axis.
pub(crate) struct Mark {
    shape: MarkShape,
    /// From where to where; twice the same for a shape at one value.
    ends: [f64; 2],
    class: &'static str,
    /// Distance below the middle of the row.
    down: f64,
    tooltip: String,
}

/// Look of a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MarkShape {
    /// A thin line with a short bar at its second end.
    Whisker,
    /// A box.
    Box,
    /// A heavy line across the box.
    Median,
    /// A ring.
    Ring,
    /// A thick line.
    Bar,
    /// A filled dot.
    Dot,
    /// A line across the row.
    Across,
}

impl Mark {
    /// A mark that reaches over a range.
    pub(crate) fn over(shape: MarkShape, ends: [f64; 2]) -> Self {
        Self {
            shape,
            ends,
            class: "",
            down: 0.0,
            tooltip: String::new(),
        }
    }

    /// A mark at a value.
    pub(crate) fn at(shape: MarkShape, value: f64) -> Self {
        Self::over(shape, [value; 2])
    }

    /// In another colour than the row, with words of its own.
    pub(crate) fn coloured(self, class: &'static str, tooltip: String) -> Self {
        Self {
            class,
            tooltip,
            ..self
        }
    }

    /// In the colour and at the height of a finger.
    pub(crate) fn of_finger(self, finger: Finger, tooltip: String) -> Self {
        Self {
            down: FINGER_STEP * (finger.index() as f64 - 2.0),
            ..self.coloured(finger_class(finger), tooltip)
        }
    }

    fn draw(&self, scale: &Scale, middle: f64) -> Markup {
        let [low, high] = scale.ends();
        let [from, to] = self.ends.map(|end| scale.at(end.clamp(low, high)));
        let past = self.ends[1] > high || self.ends[1] < low;
        let y = middle + self.down;
        let top = y - 0.5 * BOX_HEIGHT;
        // A box without width is still a box.
        let width = (to - from).max(0.5);
        let line = |class: &str, x: f64, half: f64| html! { line class=(class) x1=(Px(x)) y1=(Px(y - half)) x2=(Px(x)) y2=(Px(y + half)) {} };
        let along = |class: &str| html! { line class=(class) x1=(Px(from)) y1=(Px(y)) x2=(Px(to)) y2=(Px(y)) {} };
        let [near, far] = self.ends;
        let visible = near.min(far) <= high && near.max(far) >= low;
        html! {
            g class=[(!self.class.is_empty()).then_some(self.class)] {
                @if !self.tooltip.is_empty() { title { (self.tooltip) } }
                @if visible {
                    @match self.shape {
                        MarkShape::Whisker => {
                            (along("whisker"))
                            @if !past { (line("whisker", to, 0.25 * BOX_HEIGHT)) }
                        }
                        MarkShape::Bar => (along("bar")),
                        MarkShape::Box => rect.box x=(Px(from)) y=(Px(top)) width=(Px(width)) height=(Px(BOX_HEIGHT)) {},
                        MarkShape::Median => (line("median", to, 0.5 * BOX_HEIGHT)),
                        MarkShape::Across => (line("pooled", to, 0.9 * BOX_HEIGHT)),
                        MarkShape::Ring => circle.dot cx=(Px(to)) cy=(Px(y)) r="2.6" {},
                        MarkShape::Dot => circle.point cx=(Px(to)) cy=(Px(y)) r="3" {},
                    }
                }
            }
        }
    }
}

const WIDTH: f64 = 380.0;
/// Longest name that is written out; a longer one ends in an ellipsis and is whole in the tooltip.
const LABEL_LETTERS: usize = 20;
/// Width of a letter at the figure's text size, generous enough for bold and for most fonts.
const LETTER_WIDTH: f64 = 7.2;
const GAP: f64 = 8.0;
/// Before each number: room for the arrow head of what is past the axis.
const NUMBER_GAP: f64 = 12.0;
/// Above the first row, with headings and without.
const TOP: [f64; 2] = [20.0, 4.0];
const ROW_HEIGHT: f64 = 26.0;
/// Height of a row with a mark for each finger.
const FINGERS_HEIGHT: f64 = 36.0;
/// Height of a row of a group, and the room between groups.
const GROUP_HEIGHT: f64 = 19.0;
const GROUP_GAP: f64 = 6.0;
/// From one finger's mark down to the next one's, so that equal values do not hide one another.
const FINGER_STEP: f64 = 5.6;
const BOX_HEIGHT: f64 = 14.0;
/// Ticks wanted on the axis.
pub(crate) const WANTED_TICKS: usize = 5;

/// Places of everything in a plot.
struct Layout {
    frame: Frame,
    /// Right edge of the names of groups.
    group_end: f64,
    /// Height of a row.
    height: f64,
    /// Middle of each row.
    middles: Vec<f64>,
    /// Right end of each column of numbers, and its width.
    numbers: Vec<(f64, f64)>,
}

impl Layout {
    fn new(plot: &RowPlot<'_>) -> Self {
        let widest = |of: for<'r> fn(&'r PlotRow<'_>) -> &'r str| {
            let letters = plot.rows.iter().map(|row| of(row).chars().count()).max();
            LETTER_WIDTH * letters.unwrap_or(0).min(LABEL_LETTERS) as f64
        };
        let (groups, labels) = (widest(|row| row.group), widest(|row| row.label));
        let mut marks = plot.rows.iter().flat_map(|row| &row.marks);
        let height = if marks.any(|mark| mark.down != 0.0) {
            FINGERS_HEIGHT
        } else if groups > 0.0 {
            GROUP_HEIGHT
        } else {
            ROW_HEIGHT
        };
        let headed = plot.marked.is_some() || plot.numbers.iter().any(|name| !name.is_empty());
        let top = TOP[usize::from(!headed)];
        let mut bottom = top;
        let mut middles = Vec::with_capacity(plot.rows.len());
        for row in &plot.rows {
            if !row.group.is_empty() && !middles.is_empty() {
                bottom += GROUP_GAP;
            }
            middles.push(bottom + 0.5 * height);
            bottom += height;
        }
        let numbers = number_ends(plot);
        let right = numbers
            .first()
            .map_or(WIDTH - 12.0, |first| first.0 - first.1);
        let group_room = if groups > 0.0 { groups + GAP } else { 0.0 };
        Self {
            frame: Frame::new([GAP + group_room + labels, right], [top, bottom]),
            group_end: groups,
            height,
            middles,
            numbers,
        }
    }
}

/// Draws the figure. What is past an end of the axis is replaced by an arrow head there; its number is at the right.
pub(crate) fn draw(plot: &RowPlot<'_>) -> Panel {
    let layout = Layout::new(plot);
    let frame = layout.frame;
    let scale = plot.axis.1.over(frame.left, frame.right);
    let above = frame.top - 6.0;
    let shapes = html! {
        @for (name, (end, _)) in plot.numbers.iter().zip(&layout.numbers) {
            text.tick x=(Px(*end)) y=(Px(above)) text-anchor="end" { (name) }
        }
        (axes::bottom(&frame, &scale, WANTED_TICKS, plot.axis.0))
        @if let Some((value, name)) = plot.marked {
            text.tick x=(Px(scale.at(value))) y=(Px(above)) text-anchor="middle" { (name) }
            (frame.mark(scale.at(value)))
        }
        @for (row, y) in plot.rows.iter().zip(&layout.middles) { (draw_row(row, *y, &layout, &scale)) }
    };
    Panel {
        title: PanelTitle::from(plot.title).swatch(plot.swatch),
        width: WIDTH,
        height: frame.bottom + axes::BOTTOM_ROOM,
        summary: summary(plot),
        shapes,
    }
}

fn draw_row(row: &PlotRow<'_>, y: f64, layout: &Layout, scale: &Scale) -> Markup {
    let (frame, height) = (&layout.frame, layout.height);
    let [low, high] = scale.ends();
    let past = |beyond: fn(&Mark, f64) -> bool, end: f64| row.marks.iter().any(|m| beyond(m, end));
    // A whisker that goes on below the axis has no end mark there, which is enough.
    let below = |mark: &Mark, low| mark.ends[0] < low && mark.shape != MarkShape::Whisker;
    html! {
        g.row {
            @if !row.tooltip.is_empty() { title { (row.tooltip) } }
            rect.hover x="0" y=(Px(y - 0.5 * height)) width=(Px(WIDTH)) height=(Px(height)) {}
            @if !row.group.is_empty() {
                text.label.stressed[row.stressed] x=(Px(layout.group_end)) y=(Px(y + 4.0)) text-anchor="end" { (shortened(row.group, LABEL_LETTERS)) }
            }
            text.label.stressed[row.stressed && layout.group_end == 0.0].faint[layout.group_end > 0.0] x=(Px(frame.left - GAP)) y=(Px(y + 4.0)) text-anchor="end" { (shortened(row.label, LABEL_LETTERS)) }
            g.(row.class) {
                @for mark in &row.marks { (mark.draw(scale, y)) }
                @if past(|mark, high| mark.ends[1] > high, high) {
                    path.past d={ "M" (Px(frame.right - 1.0)) " " (Px(y - 4.0)) "l6 4l-6 4z" } {}
                }
                @if past(below, low) {
                    path.past d={ "M" (Px(frame.left + 1.0)) " " (Px(y - 4.0)) "l-6 4l6 4z" } {}
                }
            }
            @if row.marks.is_empty() { text.tick x=(Px(frame.left + GAP)) y=(Px(y + 4.0)) { "nothing to evaluate" } }
            @for (place, (number, (end, _))) in row.numbers.iter().zip(&layout.numbers).enumerate() {
                text.value.faint[place > 0] x=(Px(*end)) y=(Px(y + 4.0)) text-anchor="end" { (number) }
            }
        }
    }
}

/// Right end of each column of numbers, and its width.
fn number_ends(plot: &RowPlot<'_>) -> Vec<(f64, f64)> {
    let letters = |column: usize| {
        let cells = plot.rows.iter().filter_map(|row| row.numbers.get(column));
        let cells = cells.map(|cell| cell.chars().count());
        cells.chain([plot.numbers[column].chars().count()]).max()
    };
    let widths = (0..plot.numbers.len()).map(|column| letters(column).unwrap_or(0));
    let widths: Vec<f64> = widths
        .map(|n| NUMBER_GAP + LETTER_WIDTH * n as f64)
        .collect();
    let ends = widths.iter().enumerate();
    ends.map(|(place, &width)| (WIDTH - 1.0 - widths[place + 1..].iter().sum::<f64>(), width))
        .collect()
}

/// Description for readers who do not see it.
fn summary(plot: &RowPlot<'_>) -> String {
    let row = |row: &PlotRow<'_>| {
        let numbers = plot.numbers.iter().zip(&row.numbers);
        let numbers = numbers.map(|(name, number)| format!("{name} {number}"));
        let words = row.marks.iter().map(|mark| mark.tooltip.clone());
        let mut said: Vec<String> = numbers.chain(words.filter(|w| !w.is_empty())).collect();
        said.dedup();
        if said.is_empty() && !row.tooltip.is_empty() {
            return row.tooltip.clone();
        }
        match said.is_empty() {
            true => format!("{} nothing to evaluate", row.label),
            false => format!("{} {}", row.label, said.join(", ")),
        }
    };
    let rows: Vec<String> = plot.rows.iter().map(row).collect();
    let title = match plot.title {
        "" => String::new(),
        title => format!("{title}, "),
    };
    format!("{title}{}: {}", plot.axis.0, rows.join("; "))
}
