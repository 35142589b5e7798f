//! Median error over the time within a segment.

use inhand_model::Evaluation;
use maud::html;

use super::{Body, Method};
use crate::figure::line_chart::{self, AxisSpec, LineChart, Series};
use crate::figure::scale::nice_end;
use crate::figure::{Figure, Key};
use crate::number::{plain, to_mm};

/// The lowest curves are enlarged where the highest is this many times as high.
const ENLARGE_FROM: f64 = 2.5;

/// Curves of all methods, and their lower part enlarged where one method is far above the rest.
pub(super) fn part(evaluation: &Evaluation, methods: &[Method<'_>]) -> Body {
    let rate_hz = evaluation.session.rate_hz;
    let curves: Vec<(&Method<'_>, f64)> = methods
        .iter()
        .map(|method| {
            let peak = method
                .evaluation
                .median_error_by_sample_m
                .iter()
                .copied()
                .filter(|v| v.is_finite())
                .fold(0.0, f64::max);
            (method, to_mm(peak))
        })
        .filter(|(method, _)| !method.evaluation.median_error_by_sample_m.is_empty())
        .collect();
    let highest = curves.iter().map(|(_, peak)| *peak).fold(0.0, f64::max);
    let default = curves
        .iter()
        .find(|(method, _)| method.default)
        .map_or(0.0, |(_, peak)| *peak);
    let enlarged = nice_end(1.5 * default, 6);
    if curves.is_empty() {
        return html! { p { "No method has errors over the time within a segment." } }.into();
    }
    // The default method is drawn last, on top.
    let series: Vec<Series> = curves
        .iter()
        .filter(|(method, _)| !method.default)
        .chain(curves.iter().filter(|(method, _)| method.default))
        .map(|(method, _)| Series {
            label: method.evaluation.name.clone(),
            class: method.class.clone(),
            points: method
                .evaluation
                .median_error_by_sample_m
                .iter()
                .enumerate()
                .map(|(sample, &m)| (sample as f64 / rate_hz, to_mm(m)))
                .collect(),
        })
        .collect();
    let chart = |title: &str, high: f64| {
        line_chart::draw(&LineChart {
            title,
            x: AxisSpec::linear(
                "time in the segment (s)",
                0.0,
                evaluation.session.segment_samples.saturating_sub(1) as f64 / rate_hz,
            ),
            y: AxisSpec::linear("median error (mm)", 0.0, high),
            series: series.clone(),
            dots: false,
            marked_x: None,
        })
    };
    let mut panels = vec![chart(
        "Over the time within a segment",
        nice_end(highest, 6),
    )];
    let mut caption =
        "Median over test segments of the error of all fingers at each sample. Methods that are \
        given both ends are right there and farthest off between them."
            .to_owned();
    if default > 0.0 && highest > ENLARGE_FROM * default {
        panels.push(chart("The same, lower part enlarged", enlarged));
        caption.push_str(&format!(
            " The second axis ends at {} mm; lines that leave it at the top are cut.",
            plain(enlarged)
        ));
    }
    let mut body = Body::default();
    body.figure(Figure {
        id: "error-within-segment",
        title: "Median error against time within the segment.".to_owned(),
        caption,
        data: line_chart::data("time_s", "median_error_mm", &series),
        legend: curves
            .iter()
            .map(|(method, _)| Key::line(&method.evaluation.name, &method.class))
            .collect(),
        panels,
    });
    body
}
