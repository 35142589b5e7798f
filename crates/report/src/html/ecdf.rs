//! Distribution of errors, one curve per method.

use inhand_model::EvaluationRows;

use super::Method;
use crate::figure::line_chart::{self, AxisSpec, LineChart, Series};
use crate::figure::{Figure, Key};
use crate::number::{NARROW_SPACE, count, to_mm};

/// Points that are drawn of a curve. All of them are exact; between them a reader sees no difference.
const POINTS: usize = 300;
/// Where the axis starts, mm: smaller errors are below what any camera resolves.
const LEAST_MM: f64 = 0.01;

/// `None` without rows of any method.
pub(super) fn figure(rows: &EvaluationRows, methods: &[Method<'_>]) -> Option<Figure> {
    let mut sizes = Vec::new();
    let curves: Vec<(&Method<'_>, Series)> = methods
        .iter()
        .filter_map(|method| {
            let own = rows
                .methods
                .iter()
                .find(|own| own.name == method.evaluation.name)?;
            let errors = own.error_m.iter().flat_map(|fingers| *fingers.as_array());
            let points = exact_points(errors, POINTS);
            sizes.push(
                own.error_m
                    .iter()
                    .flat_map(|f| *f.as_array())
                    .filter(|e| e.is_finite())
                    .count(),
            );
            (!points.is_empty()).then(|| (method, series(method, &points)))
        })
        .collect();
    let largest = (curves.iter())
        .filter_map(|(_, series)| series.points.last())
        .map(|point| point.0)
        .fold(LEAST_MM, f64::max);
    if curves.is_empty() {
        return None;
    }
    let data: Vec<Series> = curves.iter().map(|(_, series)| series.clone()).collect();
    // The default method is drawn last, on top.
    let mut drawn = curves.clone();
    drawn.sort_by_key(|(method, _)| method.default);
    let n = match (sizes.iter().min(), sizes.iter().max()) {
        (Some(low), Some(high)) if low < high => format!(
            "{} to {}",
            count(*low, NARROW_SPACE),
            count(*high, NARROW_SPACE)
        ),
        (low, _) => count(low.copied().unwrap_or(0), NARROW_SPACE),
    };
    Some(Figure {
        id: "error-ecdf",
        title: "Share of errors up to a size.".to_owned(),
        caption: format!(
            "Empirical distribution of the errors of all fingers at all instants, n = {n}, on a logarithmic axis; \
             {POINTS} points of each curve are drawn, all exact. Of two curves the one farther left has the smaller errors. Errors \
             below {LEAST_MM} mm lie left of the axis."
        ),
        data: line_chart::data("error_mm", "share_percent", &data),
        legend: curves
            .iter()
            .map(|(method, _)| Key::line(&method.evaluation.name, &method.class))
            .collect(),
        panels: vec![line_chart::draw(&LineChart {
            title: "Distribution of errors",
            x: AxisSpec::log("error (mm, logarithmic)", LEAST_MM, largest),
            y: AxisSpec::linear("share of errors up to it (%)", 0.0, 100.0),
            series: drawn.into_iter().map(|(_, series)| series).collect(),
            dots: false,
            marked_x: None,
        })],
    })
}

fn series(method: &Method<'_>, points: &[(f64, f64)]) -> Series {
    Series {
        label: method.evaluation.name.clone(),
        class: method.class.clone(),
        points: points
            .iter()
            .map(|&(error_m, share)| (to_mm(error_m), 100.0 * share))
            .collect(),
    }
}

/// At most `wanted` points of the empirical distribution of the values that are finite: the smallest, the
/// largest, and others at even shares. Each is a value with the share of values up to it.
fn exact_points(values: impl Iterator<Item = f64>, wanted: usize) -> Vec<(f64, f64)> {
    let mut sorted: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let (n, drawn) = (sorted.len(), sorted.len().min(wanted));
    (0..drawn)
        .map(|k| k * (n - 1) / drawn.saturating_sub(1).max(1))
        .map(|place| {
            // Of equal values the last one says how many are up to it.
            let up_to = sorted.partition_point(|value| *value <= sorted[place]);
            (sorted[place], up_to as f64 / n as f64)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_those_of_the_distribution() {
        // Of 1, 2, .. 1000 a share of k / 1000 is up to k.
        let points = exact_points((1..=1000).rev().map(f64::from), 37);
        assert_eq!(points.len(), 37);
        assert_eq!((points[0], points[36]), ((1.0, 0.001), (1000.0, 1.0)));
        assert!(points.iter().all(|&(value, share)| share == value / 1000.0));
        assert!(points.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }

    #[test]
    fn few_equal_and_missing_values_have_their_points_too() {
        let values = [2.0, f64::NAN, 1.0, 2.0, f64::INFINITY];
        assert_eq!(
            exact_points(values.into_iter(), 10),
            [(1.0, 1.0 / 3.0), (2.0, 1.0), (2.0, 1.0)]
        );
        assert_eq!(exact_points([3.0].into_iter(), 10), [(3.0, 1.0)]);
        assert!(exact_points([f64::NAN].into_iter(), 10).is_empty());
    }
}
