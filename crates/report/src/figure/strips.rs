//! Strips over time: when something is true.

use maud::{Markup, html};

use super::Px;

/// Truth at one sample.
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
    /// The same at each of its samples.
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

/// A strip with more runs than this is drawn without gaps that nobody could see.
pub(crate) const MANY: usize = 2000;
/// Narrowest gap that is drawn there, user units.
const LEAST_GAP: f64 = 0.25;

/// Draws a strip from `top` down; `x` is the place of a sample. It is pale where it is false; where nothing is known
/// there is a thin grey line.
pub(crate) fn draw(
    label: &str,
    class: &str,
    runs: &[Run],
    x: impl Fn(usize) -> f64,
    [top, height]: [f64; 2],
) -> Markup {
    let middle = top + 0.5 * height - 0.5;
    let gap = if runs.len() > MANY { LEAST_GAP } else { 0.0 };
    let path = |state: State, top: f64, height: f64| {
        let runs = runs.iter().filter(|run| run.state == state);
        rectangles(
            runs.map(|run| [x(run.begin), x(run.end)]),
            0.0,
            gap,
            top,
            height,
        )
    };
    let strips = [
        (class, "pale", ": no", path(State::Off, top, height)),
        (class, "area", "", path(State::On, top, height)),
        (
            "missing",
            "area",
            ": not known",
            path(State::Unknown, middle, 1.0),
        ),
    ];
    html! {
        @for (class, shape, words, path) in strips {
            @if !path.is_empty() {
                g.(class) { path.(shape) d=(path) { title { (label) (words) } } }
            }
        }
    }
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
            let state = |k| {
                if k % 2 == 0 {
                    State::On
                } else {
                    State::Unknown
                }
            };
            let runs = runs((0..n).map(|k| (k, state(k))));
            let x = |sample: usize| 800.0 * sample as f64 / n as f64;
            let strip = draw("", "plain", &runs, x, [0.0, 8.0]).into_string();
            strip.matches("v8").count()
        };
        assert_eq!(lane(2000), 1000, "every run");
        assert_eq!(lane(3000), 1500, "gaps that can be seen stay");
        assert_eq!(lane(100_000), 1);
    }
}
