//! Strips over time: when something holds.

use maud::{Markup, html};

use super::Px;
use super::scale::Scale;

/// What is known at one sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum State {
    /// It holds.
    On,
    /// It does not.
    Off,
    /// Nobody knows.
    Unknown,
}

/// A stretch of equal samples: from the first up to but without the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Run {
    /// What is known all along.
    pub(crate) state: State,
    /// First sample.
    pub(crate) begin: usize,
    /// Sample after the last one.
    pub(crate) end: usize,
}

/// Stretches of equal neighbours; samples come in rising order, and one that is left out ends a stretch.
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
    /// Its stretches.
    pub(crate) runs: &'a [Run],
    /// Samples a second.
    pub(crate) rate_hz: f64,
    /// Upper edge.
    pub(crate) top: f64,
    /// Height where it holds.
    pub(crate) height: f64,
}

/// Draws a strip; `x` takes seconds. It is pale where it does not hold; where nothing is known there is a thin
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

/// A strip with more stretches than this is drawn without gaps that nobody could see.
pub(crate) const MANY: usize = 2000;
/// Narrowest gap that is drawn there, user units.
const LEAST_GAP: f64 = 0.25;

fn path(strip: &Strip<'_>, x: &Scale, state: State, top: f64, height: f64) -> String {
    let at = |sample: usize| x.at(sample as f64 / strip.rate_hz);
    let least = if strip.runs.len() > MANY {
        LEAST_GAP
    } else {
        0.0
    };
    let mut spans: Vec<[f64; 2]> = Vec::new();
    for run in strip.runs.iter().filter(|run| run.state == state) {
        let (left, right) = (at(run.begin), at(run.end));
        match spans.last_mut() {
            Some(last) if left - last[1] < least => last[1] = right,
            _ => spans.push([left, right]),
        }
    }
    (spans.iter())
        .map(|&[left, right]| {
            format!(
                "M{} {}H{}v{}H{}z",
                Px(left),
                Px(top),
                Px(right),
                Px(height),
                Px(left)
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_neighbours_make_one_stretch() {
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
        let lane = |stretches: usize| {
            let state = |k| if k % 2 == 0 { State::On } else { State::Off };
            let runs = runs((0..stretches).map(|k| (k, state(k))));
            let x = Scale::linear(0.0, stretches as f64, 0.0, 800.0);
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
        assert_eq!(lane(2000), 1000, "every stretch");
        assert_eq!(lane(3000), 1500, "gaps that can be seen stay");
        assert_eq!(lane(100_000), 1);
    }
}
