//! Strips over time: when something is true.

use maud::{Markup, html};

use super::Px;
use super::scale::Scale;

/// What is known at one sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum State {
    /// True.
    On,
    /// False.
    Off,
    /// Not known.
    Unknown,
}

/// A run of equal samples: from the first up to but without the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Run {
    /// What is known all along.
    pub(crate) state: State,
    /// First sample.
    pub(crate) begin: usize,
    /// Sample after the last one.
    pub(crate) end: usize,
}

/// Runs of equal neighbours; samples come in rising order, and one that is left out ends a run.
pub(crate) fn runs(samples: impl IntoIterator<Item = (usize, State)>) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for (sample, state) in samples {
        match runs.last_mut() {
            Some(run) if run.end == sample && run.state == state => run.end = sample + 1,
            _ => runs.push(Run {
                state,
                begin: sample,
                end: sample + 1,
            }),
        }
    }
    runs
}

/// Where a strip lies.
pub(crate) struct Strip<'a> {
    /// Name, in the tooltip.
    pub(crate) label: String,
    /// Class of its colour.
    pub(crate) class: &'a str,
    /// Its runs.
    pub(crate) runs: &'a [Run],
    /// Samples a second.
    pub(crate) rate_hz: f64,
    /// Upper edge.
    pub(crate) top: f64,
    /// Height where it is true.
    pub(crate) height: f64,
}

/// Draws a strip; `x` takes seconds. It is pale where it is false; where nothing is known there is a thin
/// grey line.
pub(crate) fn draw(strip: &Strip<'_>, x: &Scale) -> Markup {
    let on = path(strip, x, State::On, strip.top, strip.height);
    let middle = strip.top + 0.5 * strip.height - 0.5;
    let unknown = path(strip, x, State::Unknown, middle, 1.0);
    let off = path(strip, x, State::Off, strip.top, strip.height);
    html! {
        @if !off.is_empty() {
            g.(strip.class) { path.pale d=(off) { title { (strip.label) ": no" } } }
        }
        @if !on.is_empty() {
            g.(strip.class) { path.area d=(on) { title { (strip.label) } } }
        }
        @if !unknown.is_empty() {
            g.missing { path.area d=(unknown) { title { (strip.label) ": not known" } } }
        }
    }
}

/// A strip with more runs than this is drawn without gaps that nobody could see.
pub(crate) const MANY: usize = 2000;
/// Narrowest gap that is drawn there, user units.
const LEAST_GAP: f64 = 0.25;

fn path(strip: &Strip<'_>, x: &Scale, state: State, top: f64, height: f64) -> String {
    let at = |sample: usize| x.at(sample as f64 / strip.rate_hz);
    let gap = if strip.runs.len() > MANY {
        LEAST_GAP
    } else {
        0.0
    };
    let runs = strip.runs.iter().filter(|run| run.state == state);
    rectangles(
        runs.map(|run| [at(run.begin), at(run.end)]),
        0.0,
        gap,
        top,
        height,
    )
}

/// Rectangles over spans in rising order, each at least `least` wide; those no farther apart than `gap` are one.
pub(crate) fn rectangles(
    spans: impl IntoIterator<Item = [f64; 2]>,
    least: f64,
    gap: f64,
    top: f64,
    height: f64,
) -> String {
    let mut drawn: Vec<[f64; 2]> = Vec::new();
    for [left, right] in spans {
        let right = right.max(left + least);
        match drawn.last_mut() {
            Some(last) if left - last[1] <= gap => last[1] = last[1].max(right),
            _ => drawn.push([left, right]),
        }
    }
    let rectangle = |[left, right]: [f64; 2]| {
        let [left, right, top, height] = [left, right, top, height].map(Px);
        format!("M{left} {top}H{right}v{height}H{left}z")
    };
    drawn.into_iter().map(rectangle).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_neighbours_make_one_run() {
        use State::{Off, On, Unknown};
        let samples = [(3, On), (4, On), (5, Off), (6, Unknown), (7, On), (9, On)];
        let found: Vec<_> = (runs(samples).iter())
            .map(|run| (run.state, run.begin, run.end))
            .collect();
        let expected = [
            (On, 3, 5),
            (Off, 5, 6),
            (Unknown, 6, 7),
            (On, 7, 8),
            (On, 9, 10),
        ];
        assert_eq!(found, expected);
        assert!(runs([]).is_empty());
    }

    #[test]
    fn long_strips_are_drawn_in_bounded_room() {
        let lane = |n: usize| {
            let state = |k| if k % 2 == 0 { State::On } else { State::Off };
            let runs = runs((0..n).map(|k| (k, state(k))));
            let x = Scale::linear(0.0, n as f64, 0.0, 800.0);
            let strip = Strip {
                label: String::new(),
                class: "plain",
                runs: &runs,
                rate_hz: 1.0,
                top: 0.0,
                height: 8.0,
            };
            path(&strip, &x, State::On, 0.0, 8.0).matches('M').count()
        };
        assert_eq!(lane(2000), 1000, "every run");
        assert_eq!(lane(3000), 1500, "gaps that can be seen stay");
        assert_eq!(lane(100_000), 1);
    }
}
