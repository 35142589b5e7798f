//! Box plots of distributions of lengths, lying on their side.

use inhand_model::{Finger, Statistics};

use super::data::STATISTICS;
use super::row_plot::{self, Mark, MarkShape, PlotRow, RowPlot, WANTED_TICKS};
use super::scale::{Axis, Extent, Scale};
use super::{FigureData, Panel, finger_class};
use crate::words::{count, decimals};

/// Parts of a box, explained under every figure of them.
pub(crate) const BOX_WORDS: &str = "Box: first to third quartile; line: median; whiskers: farthest value within 1.5 interquartile \
    ranges of the box; ring: 95 % quantile; the largest value is the number at the right.";

/// A distribution in metres, and the name and colour of its row.
pub(crate) type BoxRow<'a> = (PlotRow<'a>, &'a Statistics);

/// A unit of an axis of lengths.
pub(crate) struct LengthUnit {
    name: &'static str,
    per_m: f64,
    /// Decimals of numbers.
    digits: usize,
}

/// Millimetres, with a tenth of what cameras resolve.
pub(crate) const MILLIMETRES: LengthUnit = LengthUnit {
    name: "mm",
    per_m: 1e3,
    digits: 2,
};

/// Micrometres.
pub(crate) const MICROMETRES: LengthUnit = LengthUnit {
    name: "µm",
    per_m: 1e6,
    digits: 1,
};

impl LengthUnit {
    /// An axis for all of `distributions`, up to the farthest whisker or 95 % quantile; third quartiles are legible.
    pub(crate) fn axis(&self, distributions: &[&Statistics]) -> Scale {
        let shown = distributions.iter().filter(|s| drawable(s));
        let extents = shown.map(|s| Extent {
            low: self.per_m * s.p5,
            typical: self.per_m * s.p75,
            high: self.per_m * s.whisker_high.max(s.p95),
        });
        Scale::comparing(extents, WANTED_TICKS * 2)
    }

    /// Draws boxes, with median and largest value as numbers at the right. `swatch` is a finger before the title.
    pub(crate) fn boxes<'a>(
        &self,
        title: &str,
        swatch: Option<Finger>,
        (axis_name, scale): Axis<'_>,
        rows: impl IntoIterator<Item = BoxRow<'a>>,
    ) -> Panel {
        row_plot::draw(&RowPlot {
            title,
            swatch: swatch.map(finger_class),
            axis: (axis_name, scale),
            numbers: &["median", "max"],
            rows: rows.into_iter().map(|row| self.row(title, row)).collect(),
            ..RowPlot::default()
        })
    }

    fn row<'a>(&self, title: &str, (row, s): BoxRow<'a>) -> PlotRow<'a> {
        let label = row.label;
        if !drawable(s) {
            let tooltip = format!("{label}, {title}: nothing to evaluate");
            return PlotRow { tooltip, ..row };
        }
        let at = |metres: f64| self.per_m * metres;
        let text = |metres: f64| decimals(at(metres), self.digits);
        PlotRow {
            tooltip: format!(
                "{label}, {title}: n {}; whiskers {} to {}; 5 % {}, 25 % {}, median {}, 75 % {}, 95 % {}, max {} {}",
                count(s.n),
                text(s.whisker_low),
                text(s.whisker_high),
                text(s.p5),
                text(s.p25),
                text(s.p50),
                text(s.p75),
                text(s.p95),
                text(s.max),
                self.name,
            ),
            marks: vec![
                Mark::over(MarkShape::Whisker, [at(s.p25), at(s.whisker_low)]),
                Mark::over(MarkShape::Whisker, [at(s.p75), at(s.whisker_high)]),
                Mark::over(MarkShape::Box, [at(s.p25), at(s.p75)]),
                Mark::at(MarkShape::Median, at(s.p50)),
                Mark::at(MarkShape::Ring, at(s.p95)),
            ],
            numbers: vec![text(s.p50), decimals(at(s.max), self.digits - 1)],
            ..row
        }
    }
}

/// What logarithmic axes leave out, in a sentence with a space before it; empty where none is.
pub(crate) fn axis_words(scales: &[Scale]) -> &'static str {
    match scales.iter().any(Scale::is_log) {
        true => " On a logarithmic axis a whisker without an end mark goes on below it.",
        false => "",
    }
}

/// The row of a finger.
pub(crate) fn finger_row(finger: Finger) -> PlotRow<'static> {
    PlotRow::new(finger.name(), finger_class(finger))
}

fn drawable(s: &Statistics) -> bool {
    s.n > 0
        && [s.whisker_low, s.p25, s.p50, s.p75, s.p95, s.whisker_high]
            .iter()
            .all(|v| v.is_finite())
}

/// The table behind boxes: finger, motion and distribution of each.
pub(crate) fn data(boxes: &[(&str, &str, &Statistics)]) -> FigureData {
    FigureData::about(boxes)
        .words("finger", |row| row.0)
        .words("motion", |row| row.1)
        .lengths(&STATISTICS.map(|(name, _)| name), |row| row.2)
        .done()
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

    fn axis(all: &[Statistics]) -> (bool, [f64; 2]) {
        let axis = MILLIMETRES.axis(&all.iter().collect::<Vec<_>>());
        (axis.is_log(), axis.ends())
    }

    #[test]
    fn the_axis_reaches_the_widest_whisker() {
        let all = [distribution(0.001, 0.002_9), distribution(0.002, 0.004_1)];
        assert_eq!(axis(&all), (false, [0.0, 4.5]));
    }

    #[test]
    fn one_wild_method_does_not_press_the_others_flat() {
        let all = [distribution(0.001, 0.002), distribution(0.1, 0.3)];
        assert_eq!(axis(&all), (true, [0.1, 500.0]));
    }

    #[test]
    fn nothing_gives_an_axis_all_the_same() {
        let broken = Statistics {
            n: 3,
            p50: f64::NAN,
            ..Statistics::default()
        };
        for all in [vec![], vec![Statistics::default()], vec![broken]] {
            assert_eq!(axis(&all), (false, [0.0, 1.0]));
        }
    }
}
