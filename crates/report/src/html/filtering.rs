//! The filter at work: a few seconds before and after it, and spectra.

use inhand_model::{Filtering, Finger, Spectrum};
use maud::html;

use super::Body;
use super::table::{Line, numbers, table, words};
use crate::figure::line_chart::{self, AxisSpec, LineChart, Series};
use crate::figure::palette::finger_class;
use crate::figure::scale::{nice_end, nice_step};
use crate::figure::{Figure, FigureColumn, FigureData, Key};
use crate::number::{NARROW_SPACE, count, millimetres, plain, to_mm};

const MM2_PER_M2: f64 = 1e6;
const BEFORE_CLASS: &str = "faded";
const AFTER_CLASS: &str = "l0";
const WANTED_TICKS: usize = 6;

/// The stretch, how far positions move, and the spectra; sentences where there is none.
pub(super) fn part(filtering: Option<&Filtering>, spectrum: Option<&Spectrum>) -> Body {
    let mut body = Body::default();
    match filtering {
        Some(filtering) => {
            body.figure(stretch(filtering));
            body.prose(moved(filtering));
        }
        None => {
            body.prose(html! { p { "No test take has a few seconds without a gap, so none are shown before and after the filter." } });
        }
    }
    match spectrum {
        Some(spectrum) => body.figure(density(spectrum)),
        None => body
            .prose(html! { p { "No stretch of the test takes is long enough for a spectrum." } }),
    };
    body
}

fn stretch(filtering: &Filtering) -> Figure {
    let series = |label: &str, class: &str, values_m: &[f64]| Series {
        label: label.to_owned(),
        class: class.to_owned(),
        points: (filtering.time_s.iter().copied())
            .zip(values_m.iter().map(|v| to_mm(*v)))
            .collect(),
    };
    let finger_class = finger_class(filtering.finger);
    let lines = vec![
        series("before the filter", BEFORE_CLASS, &filtering.before_m),
        series("after the filter", finger_class, &filtering.after_m),
    ];
    let values = || {
        lines
            .iter()
            .flat_map(|line| &line.points)
            .map(|point| point.1)
    };
    let (low, high) = range(values().filter(|v| v.is_finite()));
    let name = format!("{} (mm)", filtering.axis);
    let panel = line_chart::draw(&LineChart {
        title: "Before and after filtering",
        x: AxisSpec::linear(
            "time since the take's first sample (s)",
            filtering.time_s.first().copied().unwrap_or(0.0),
            filtering.time_s.last().copied().unwrap_or(1.0),
        ),
        y: AxisSpec::linear(&name, low, high),
        series: lines.clone(),
        dots: false,
        marked_x: None,
    });
    Figure {
        id: "filtering",
        title: "A coordinate before and after filtering.".to_owned(),
        caption: format!(
            "{} of a fingertip ({}) in the hand's frame, {}: the stretch of a test take without gaps in which a coordinate \
             covers most.",
            filtering.axis, filtering.finger, filtering.take
        ),
        data: line_chart::data("time_s", "position_mm", &lines),
        legend: vec![
            Key::line("before the filter", BEFORE_CLASS),
            Key::line("after the filter", finger_class),
        ],
        panels: vec![panel],
    }
}

/// Ends of an axis around values, at multiples of a nice step.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    if low >= high || !low.is_finite() {
        let low = if low.is_finite() { low } else { 0.0 };
        return (low, low + 1.0);
    }
    let step = nice_step(high - low, WANTED_TICKS);
    ((low / step).floor() * step, (high / step).ceil() * step)
}

fn moved(filtering: &Filtering) -> maud::Markup {
    let columns = [
        words("finger"),
        numbers("n", ""),
        numbers("filled", ""),
        numbers("missing", ""),
        numbers("median", "mm"),
        numbers("95 %", "mm"),
        numbers("max", "mm"),
    ];
    let lines = Finger::ALL.map(|finger| {
        let s = &filtering.moved[finger];
        let counts = [s.n, s.n_filled, s.n_left_out].map(|n| count(n, NARROW_SPACE));
        let lengths = [s.p50, s.p95, s.max].map(millimetres);
        Line {
            head: html! { span.swatch.(finger_class(finger)) {} (finger.name()) },
            cells: counts.into_iter().chain(lengths).collect(),
            best: Vec::new(),
            stressed: false,
        }
    });
    html! {
        p { "How far the filter moves fingertips, over all samples of the test takes:" }
        (table("Distance between positions before and after the filter", &columns, lines.into()))
    }
}

fn density(spectrum: &Spectrum) -> Figure {
    // Without the mean nothing is at 0 Hz, which has no place on a logarithmic axis either.
    let of = |values: &[f64]| -> Vec<(f64, f64)> {
        let points = spectrum.frequency_hz.iter().zip(values).skip(1);
        points.map(|(hz, m2)| (*hz, m2 * MM2_PER_M2)).collect()
    };
    let series = |label: &str, class: &str, values: &[f64]| Series {
        label: label.to_owned(),
        class: class.to_owned(),
        points: of(values)
            .into_iter()
            .map(|(hz, v)| (hz, if v > 0.0 { v } else { f64::NAN }))
            .collect(),
    };
    let lines = vec![
        series("before the filter", BEFORE_CLASS, &spectrum.before_m2_hz),
        series("after the filter", AFTER_CLASS, &spectrum.after_m2_hz),
    ];
    let values = || {
        lines
            .iter()
            .flat_map(|line| &line.points)
            .map(|point| point.1)
    };
    let (low, high) = range_of_powers(values().filter(|v| v.is_finite()));
    let rate_hz = spectrum.frequency_hz.last().map_or(0.0, |half| 2.0 * half);
    let panel = line_chart::draw(&LineChart {
        title: "Power spectral density",
        x: AxisSpec::log(
            "frequency (Hz, logarithmic)",
            spectrum.frequency_hz.get(1).copied().unwrap_or(1.0),
            spectrum.frequency_hz.last().copied().unwrap_or(10.0),
        ),
        y: AxisSpec::log("density (mm²/Hz, logarithmic)", low, high),
        series: lines,
        dots: false,
        marked_x: None,
    });
    let mm2 = |values: &[f64]| values.iter().map(|v| v * MM2_PER_M2).collect::<Vec<_>>();
    Figure {
        id: "spectrum",
        title: "Spectrum of fingertip coordinates before and after filtering.".to_owned(),
        caption: format!(
            "One-sided power spectral density by Welch's method over the test takes, all fingers and axes: {} windows \
             of {} samples at {} Hz (Hann, half overlap, mean taken off), from stretches without open gaps; what was filled counts.",
            count(spectrum.windows, NARROW_SPACE),
            spectrum.window,
            plain(rate_hz),
        ),
        data: FigureData::new([
            FigureColumn::numbers("frequency_hz", spectrum.frequency_hz.iter().copied()),
            FigureColumn::numbers("before_mm2_hz", mm2(&spectrum.before_m2_hz)),
            FigureColumn::numbers("after_mm2_hz", mm2(&spectrum.after_m2_hz)),
        ]),
        legend: vec![
            Key::line("before the filter", BEFORE_CLASS),
            Key::line("after the filter", AFTER_CLASS),
        ],
        panels: vec![panel],
    }
}

/// Decades that are shown at most: below is rounding.
const DECADES: f64 = 1e10;

fn range_of_powers(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    (low.max(high / DECADES), nice_end(high, 1).max(high))
}
