//! Box plots of distributions of lengths, lying on their side.

use inhand_model::{Finger, Statistics};

use super::data::STATISTICS;
use super::row_plot::{self, Mark, MarkShape, PlotRow, RowPlot, WANTED_TICKS};
use super::scale::{Scale, nice_end};
use super::{FigureData, Panel, finger_class};
use crate::words::{count, decimals, plain};

/// Parts of a box, explained under every figure of them.
pub(crate) const BOX_WORDS: &str = "Box: first to third quartile; line: median; whiskers: farthest value within 1.5 \
    interquartile ranges of the box; dot: 95 % quantile. Values beyond the whiskers are not drawn one by one, the largest is the number at the right. \
    Quantiles interpolate linearly (type 7).";

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

/// Multiple of the typical third quartile that an axis may reach; one wild method must not press
/// the others flat.
const REACH: f64 = 6.0;

impl LengthUnit {
    /// An axis end for all of `distributions`: far enough for their whiskers and 95 % quantiles,
    /// unless a few of them are so much wider than the rest that the rest would be unreadable.
    pub(crate) fn shared_end(&self, distributions: &[&Statistics]) -> f64 {
        let shown = || distributions.iter().filter(|s| drawable(s));
        let widest = shown().map(|s| self.extent(s)).fold(0.0, f64::max);
        let mut quartiles: Vec<f64> = shown().map(|s| self.per_m * s.p75).collect();
        quartiles.sort_unstable_by(f64::total_cmp);
        let typical = quartiles.get(quartiles.len() / 2);
        // A limit of zero (most distributions are all zero) would leave no axis.
        let limit = typical
            .map(|typical| REACH * typical)
            .filter(|&limit| limit > 0.0);
        nice_end(widest.min(limit.unwrap_or(widest)), WANTED_TICKS * 2)
    }

    fn extent(&self, statistics: &Statistics) -> f64 {
        self.per_m * statistics.whisker_high.max(statistics.p95)
    }

    /// Number of `distributions` that reach past the end of the axis with a whisker or 95 % quantile, in a sentence.
    pub(crate) fn cut_words(&self, distributions: &[&Statistics], end: f64) -> String {
        let cut = (distributions.iter()).filter(|s| drawable(s) && self.extent(s) > end);
        let (name, end) = (self.name, plain(end));
        match cut.count() {
            0 => "No box, whisker or dot is cut off.".to_owned(),
            1 => format!("One row reaches past the axis, which ends at {end} {name}; ▸ marks it."),
            n => format!("{n} rows reach past the axis, which ends at {end} {name}; ▸ marks them."),
        }
    }

    /// Draws boxes, with median and largest value as numbers at the right. `swatch` is a finger before the title.
    pub(crate) fn boxes<'a>(
        &self,
        title: &str,
        swatch: Option<Finger>,
        axis_name: &str,
        end: f64,
        rows: impl IntoIterator<Item = BoxRow<'a>>,
    ) -> Panel {
        row_plot::draw(&RowPlot {
            title,
            swatch: swatch.map(finger_class),
            axis: (axis_name, Scale::linear(0.0, end)),
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

    fn end_and_words(all: &[Statistics]) -> (f64, String) {
        let all: Vec<&Statistics> = all.iter().collect();
        let end = MILLIMETRES.shared_end(&all);
        (end, MILLIMETRES.cut_words(&all, end))
    }

    #[test]
    fn the_axis_reaches_the_widest_whisker() {
        let all = [distribution(0.001, 0.002_9), distribution(0.002, 0.004_1)];
        let (end, words) = end_and_words(&all);
        assert!((end - 4.5).abs() < 1e-9);
        assert_eq!(words, "No box, whisker or dot is cut off.");
    }

    #[test]
    fn one_wild_method_does_not_press_the_others_flat() {
        let all = [
            distribution(0.001, 0.002),
            distribution(0.001, 0.002),
            distribution(0.1, 0.3),
        ];
        let (end, words) = end_and_words(&all);
        assert!((end - 6.0).abs() < 1e-9, "{end}");
        assert!(words.starts_with("One row"), "{words}");
    }

    #[test]
    fn nothing_gives_an_axis_all_the_same() {
        assert_eq!(end_and_words(&[]).0, 1.0);
        assert_eq!(end_and_words(&[Statistics::default()]).0, 1.0);
        let broken = Statistics {
            n: 3,
            p50: f64::NAN,
            ..Statistics::default()
        };
        assert_eq!(end_and_words(&[broken]).0, 1.0);
    }
}
