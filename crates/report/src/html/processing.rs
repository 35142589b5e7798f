//! Processing of takes: missing and filled samples over time; the filter at work, a few seconds before and after it, and spectra.

use inhand_model::{Filtering, Finger, Illustrations, Spectrum, TakeGaps, TrackGaps};
use maud::{Markup, html};

use super::Body;
use crate::figure::line_chart::{self, LineChart, Series};
use crate::figure::scale::{Scale, nice_end, whole_steps};
use crate::figure::strips::rectangles;
use crate::figure::{
    Figure, FigureData, Frame, Key, PLAIN_CLASS, Panel, PanelTitle, Px, axes, finger_class,
    finger_keys,
};
use crate::table::{Statistic, Table, UPPER};
use crate::words::{count, decimals, millimetres, plain, shortened, to_mm};

/// Takes that are drawn at most; those with most to show.
const SHOWN: usize = 12;

const WIDTH: f64 = 940.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 4.0;
const ROW: f64 = 14.0;
const HEIGHT: f64 = 9.0;
const HEAD: f64 = 24.0;
const NAME_LETTERS: usize = 60;
const GAP_TICKS: usize = 10;
/// Pixels that a interval takes at least.
const LEAST: f64 = 1.0;

/// The raster; nothing where no take has a gap.
pub(super) fn gaps(gaps: &[TakeGaps]) -> Body {
    let mut worst: Vec<&TakeGaps> = gaps
        .iter()
        .filter(|take| spans(take).next().is_some())
        .collect();
    if worst.is_empty() {
        return Body::default();
    }
    worst.sort_by(|a, b| gaps_s(b).total_cmp(&gaps_s(a)));
    let left_out = worst.len().saturating_sub(SHOWN);
    let whole = gaps.len() - worst.len();
    // The order of the session.
    let least = worst.get(SHOWN).copied();
    worst.truncate(SHOWN);
    let shown: Vec<&TakeGaps> = (gaps.iter())
        .filter(|take| worst.iter().any(|other| std::ptr::eq(*other, *take)))
        .collect();
    let mut caption = "Solid: missing. Pale and half as high: short enough to be filled by interpolation. Where the \
        hand is missing, so is everything in its frame. Intervals narrower than a pixel are drawn one wide."
        .to_owned();
    if let Some(least) = least {
        caption.push_str(&format!(
            " Of the takes with gaps {} are not drawn, with {} s of gaps at most.",
            count(left_out),
            decimals(gaps_s(least), 2)
        ));
    }
    if whole > 0 {
        caption.push_str(&format!(" Takes without any gap: {}.", count(whole)));
    }
    let mut legend = vec![Key::area("hand, object", PLAIN_CLASS)];
    legend.extend(finger_keys(Key::area));
    Body::default().figure(Figure {
        id: "gaps",
        title: "Gaps of each track over each take.".to_owned(),
        caption,
        data: data(gaps),
        legend,
        panels: vec![panel(&shown)],
    })
}

/// A missing or filled interval of a track, seconds, with the word for it.
type Span<'a> = (&'a TrackGaps, &'static str, [f64; 2]);

/// Intervals of a track, with the word for them.
fn track_spans(track: &TrackGaps) -> [(&'static str, &[[f64; 2]]); 2] {
    [("missing", &track.missing_s), ("filled", &track.filled_s)]
}

fn spans(take: &TakeGaps) -> impl Iterator<Item = Span<'_>> {
    take.tracks.iter().flat_map(|track| {
        let all = track_spans(track).into_iter();
        all.flat_map(move |(what, spans)| spans.iter().map(move |&span| (track, what, span)))
    })
}

fn gaps_s(take: &TakeGaps) -> f64 {
    spans(take).map(|(.., [start, end])| end - start).sum()
}

fn data(gaps: &[TakeGaps]) -> FigureData {
    let rows: Vec<(&TakeGaps, Span<'_>)> = (gaps.iter())
        .flat_map(|take| spans(take).map(move |span| (take, span)))
        .collect();
    FigureData::about(&rows)
        .words("take", |row| &*row.0.take)
        .words("role", |row| &*row.0.role)
        .words("track", |row| &*row.1.0.track)
        .words("status", |row| row.1.1)
        .numbers("start_s", |row| row.1.2[0])
        .numbers("end_s", |row| row.1.2[1])
        .done()
}

fn panel(takes: &[&TakeGaps]) -> Panel {
    let longest_s = takes.iter().map(|take| take.duration_s).fold(0.0, f64::max);
    let mut tops = Vec::with_capacity(takes.len());
    let mut bottom = TOP;
    for take in takes {
        tops.push(bottom);
        bottom += HEAD + ROW * take.tracks.len() as f64;
    }
    let frame = Frame::new([LEFT, WIDTH - RIGHT], [TOP, bottom + 4.0]);
    let x = Scale::linear(0.0, longest_s).over(frame.left, frame.right);
    let names: Vec<&str> = takes.iter().map(|take| take.take.as_str()).collect();
    Panel {
        title: PanelTitle::default(),
        width: WIDTH,
        height: frame.bottom + axes::BOTTOM_ROOM,
        summary: format!("Gaps over time in {}", names.join(", ")),
        shapes: html! {
            (axes::bottom(&frame, &x, GAP_TICKS, "time since the take's first sample (s)"))
            @for (take, top) in takes.iter().zip(tops) {
                text.stressed x="0" y=(Px(top + 16.0)) {
                    (shortened(&take.take, NAME_LETTERS)) ", " (take.role) ", " (decimals(take.duration_s, 1)) " s"
                }
                @for (place, track) in take.tracks.iter().enumerate() {
                    (row(track, take.duration_s, &x, top + HEAD + ROW * place as f64))
                }
            }
        },
    }
}

fn row(track: &TrackGaps, duration_s: f64, x: &Scale, top: f64) -> Markup {
    let finger = Finger::ALL
        .into_iter()
        .find(|finger| finger.name() == track.track);
    let class = finger.map_or(PLAIN_CLASS, finger_class);
    let (from, to) = (x.at(0.0), x.at(duration_s));
    let say = |what: &str, spans: &[[f64; 2]]| {
        let sum_s: f64 = spans.iter().map(|[a, b]| b - a).sum();
        let (n, sum) = (count(spans.len()), decimals(sum_s, 2));
        format!("{}, {what}: {n} intervals, {sum} s", track.track)
    };
    let shapes = [("area", 0.0, HEIGHT), ("half", 0.25 * HEIGHT, 0.5 * HEIGHT)];
    html! {
        text.tick x=(Px(LEFT - 6.0)) y=(Px(top + HEIGHT)) text-anchor="end" { (track.track) }
        line.grid x1=(Px(from)) y1=(Px(top + 0.5 * HEIGHT)) x2=(Px(to)) y2=(Px(top + 0.5 * HEIGHT)) {}
        g.(class) {
            @for ((what, spans), (shape, down, height)) in track_spans(track).into_iter().zip(shapes) {
                @if !spans.is_empty() {
                    path.(shape) d=(strip(spans, x, top + down, height)) { title { (say(what, spans)) } }
                }
            }
        }
    }
}

/// Rectangles over intervals, those in the same pixels as one.
fn strip(intervals_s: &[[f64; 2]], x: &Scale, top: f64, height: f64) -> String {
    let spans = intervals_s.iter().map(|ends_s| ends_s.map(|s| x.at(s)));
    rectangles(spans, LEAST, 0.0, top, height)
}

const MM2_PER_M2: f64 = 1e6;
const BEFORE_CLASS: &str = "faded";
const AFTER_CLASS: &str = "l0";
const WANTED_TICKS: usize = 6;

/// The interval, how far positions move, and the spectra; sentences where there is none.
pub(super) fn filter(all: &Illustrations) -> Body {
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

fn moved(filtering: &Filtering) -> Table<Finger> {
    const SHOWN: [Statistic; 3] = [UPPER[0], UPPER[2], UPPER[3]];
    let caption = "Distance between positions before and after the filter";
    let of = |finger: &Finger| filtering.moved[*finger];
    Table::new(caption, Finger::ALL, "finger", |finger| *finger)
        .counts("n", "", |finger| of(finger).n)
        .counts("filled", "", |finger| of(finger).n_filled)
        .counts("missing", "", |finger| of(finger).n_left_out)
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
            x: (
                "frequency (Hz)",
                Scale::log(first_hz, last_hz.unwrap_or(10.0)),
            ),
            y: ("density (mm²/Hz)", Scale::log(y_low, y_high)),
            series: &series,
            ..LineChart::default()
        })],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_in_the_same_pixel_are_one() {
        let x = Scale::linear(0.0, 100.0).over(0.0, 100.0);
        let intervals = [[1.0, 1.1], [1.5, 1.6], [10.0, 30.0], [50.0, 50.01]];
        let path = strip(&intervals, &x, 0.0, 8.0);
        assert_eq!(path, "M1 0H2.5v8H1zM10 0H30v8H10zM50 0H51v8H50z");
    }
}
