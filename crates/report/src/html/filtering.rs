//! The filter at work: a few seconds before and after it, and spectra.

use inhand_model::{Filtering, Finger, Illustrations, Spectrum};
use maud::html;

use super::Body;
use crate::figure::line_chart::{self, LineChart, Series};
use crate::figure::scale::{Scale, nice_end, whole_steps};
use crate::figure::{Figure, FigureData, finger_class};
use crate::table::{Statistic, Table, UPPER};
use crate::words::{count, millimetres, plain, to_mm};

const MM2_PER_M2: f64 = 1e6;
const BEFORE_CLASS: &str = "faded";
const AFTER_CLASS: &str = "l0";
const WANTED_TICKS: usize = 6;

/// The interval, how far positions move, and the spectra; sentences where there is none.
pub(super) fn part(all: &Illustrations) -> Body {
    let body = match &all.filtering {
        Some(filtering) => Body::default()
            .figure(interval(filtering))
            .prose(html! { p { "How far the filter moves fingertips, over all samples of the test takes:" } })
            .prose(moved(filtering)),
        None => Body::from(html! { p { "No test take has a few seconds without a gap, so none are shown before and after the filter." } }),
    };
    match &all.spectrum {
        Some(spectrum) => body.figure(density(spectrum)),
        None => body
            .prose(html! { p { "No interval of the test takes is long enough for a spectrum." } }),
    }
}

/// Lines of the same quantity before and after the filter.
fn before_and_after(
    x: &[f64],
    class: &str,
    [before, after]: [&[f64]; 2],
    y: impl Fn(f64) -> f64 + Copy,
) -> [Series; 2] {
    let points = |values: &[f64]| -> Vec<(f64, f64)> {
        x.iter()
            .zip(values)
            .map(|(x, value)| (*x, y(*value)))
            .collect()
    };
    [
        Series::new("before the filter", BEFORE_CLASS, points(before)),
        Series::new("after the filter", class, points(after)),
    ]
}

fn interval(filtering: &Filtering) -> Figure {
    let Filtering { time_s, axis, .. } = filtering;
    let values = [&*filtering.before_m, &filtering.after_m];
    let series = before_and_after(time_s, finger_class(filtering.finger), values, to_mm);
    let [low, high] = whole_steps(line_chart::heights(&series), 0.0, WANTED_TICKS);
    let first_s = time_s.first().copied().unwrap_or(0.0);
    let last_s = time_s.last().copied().unwrap_or(1.0);
    Figure {
        id: "filtering",
        title: "A coordinate before and after filtering.".to_owned(),
        caption: format!(
            "{axis} of a fingertip ({}) in the hand's frame, {}: the interval of a test take without gaps in which a coordinate \
             covers most.",
            filtering.finger, filtering.take
        ),
        data: line_chart::data("time_s", "position_mm", &series),
        legend: line_chart::keys(&series),
        panels: vec![line_chart::draw(&LineChart {
            title: "Before and after filtering",
            x: (
                "time since the take's first sample (s)",
                Scale::linear(first_s, last_s),
            ),
            y: (&format!("{axis} (mm)"), Scale::linear(low, high)),
            series: &series,
            ..LineChart::default()
        })],
    }
}

fn moved(filtering: &Filtering) -> Table<'_, Finger> {
    const SHOWN: [Statistic; 3] = [UPPER[0], UPPER[2], UPPER[3]];
    let caption = "Distance between positions before and after the filter";
    let of = |finger: &Finger| filtering.moved[*finger];
    Table::new(caption, Finger::ALL, "finger", |finger| *finger)
        .counts("n", "", move |finger| of(finger).n)
        .counts("filled", "", move |finger| of(finger).n_filled)
        .counts("missing", "", move |finger| of(finger).n_left_out)
        .statistics(&SHOWN, "mm", millimetres, of)
}

/// Decades that are shown at most: below is rounding.
const DECADES: f64 = 1e10;

fn density(spectrum: &Spectrum) -> Figure {
    let frequency_hz = &spectrum.frequency_hz;
    // A logarithmic axis has no place for what is not positive; 0 Hz is not drawn, as the mean is removed.
    let drawn = |m2_hz: f64| {
        Some(m2_hz * MM2_PER_M2)
            .filter(|v| *v > 0.0)
            .unwrap_or(f64::NAN)
    };
    let shown = |values: &'_ [f64]| values.get(1..).unwrap_or_default().to_vec();
    let values = [shown(&spectrum.before_m2_hz), shown(&spectrum.after_m2_hz)];
    let series = before_and_after(
        &shown(frequency_hz),
        AFTER_CLASS,
        values.each_ref().map(|v| &**v),
        drawn,
    );
    let lowest = line_chart::heights(&series).fold(f64::INFINITY, f64::min);
    let highest = line_chart::heights(&series).fold(0.0, f64::max);
    let y_low = lowest.max(highest / DECADES);
    let y_high = nice_end(highest, 1).max(highest);
    let first_hz = frequency_hz.get(1).copied().unwrap_or(1.0);
    let last_hz = frequency_hz.last().copied();
    let rows: Vec<(f64, f64, f64)> = (frequency_hz.iter())
        .zip(spectrum.before_m2_hz.iter().zip(&spectrum.after_m2_hz))
        .map(|(hz, (before, after))| (*hz, before * MM2_PER_M2, after * MM2_PER_M2))
        .collect();
    Figure {
        id: "spectrum",
        title: "Spectrum of fingertip coordinates before and after filtering.".to_owned(),
        caption: format!(
            "One-sided power spectral density by Welch's method over the test takes, all fingers and axes: {} windows \
             of {} samples at {} Hz (Hann, half overlap, detrended by the mean), from intervals without open gaps; what was filled counts.",
            count(spectrum.windows),
            spectrum.window,
            plain(last_hz.map_or(0.0, |half| 2.0 * half)),
        ),
        data: FigureData::about(&rows)
            .numbers("frequency_hz", |row| row.0)
            .numbers("before_mm2_hz", |row| row.1)
            .numbers("after_mm2_hz", |row| row.2)
            .done(),
        legend: line_chart::keys(&series),
        panels: vec![line_chart::draw(&LineChart {
            title: "Power spectral density",
            x: (
                "frequency (Hz, logarithmic)",
                Scale::log(first_hz, last_hz.unwrap_or(10.0)),
            ),
            y: ("density (mm²/Hz, logarithmic)", Scale::log(y_low, y_high)),
            series: &series,
            ..LineChart::default()
        })],
    }
}
