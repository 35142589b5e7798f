//! Progress line of long work on a terminal, with an estimate of the time left.

use std::fmt::Display;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::visible::visible;

/// Work that takes less gets no line.
const SHOWN_AFTER: Duration = Duration::from_secs(2);

/// Share of the work that must be done before a time left is shown.
const LEAST_SHARE: f64 = 0.03;

/// Time left of a part that takes longer than its weight says, as a share of the time that it is late.
const LATE_SHARE: f64 = 0.5;

/// Most that the time shown may rise in a second, as a share of it and in seconds.
const RISE: (f64, f64) = (0.1, 1.0);

/// The work that goes on, where its line may be shown. A process has one terminal.
static WORK: Mutex<Option<Work>> = Mutex::new(None);

/// Whether the process ends by a signal: nothing more is printed then.
static ENDING: AtomicBool = AtomicBool::new(false);

/// Work that goes on.
struct Work {
    begin: Instant,
    name: String,
    unit: String,
    left: TimeLeft,
    /// The line, once it is shown.
    bar: Option<ProgressBar>,
}

/// Work that goes on until this is dropped.
#[must_use = "the work ends where this is dropped"]
#[derive(Debug)]
pub(crate) struct Task(());

impl Task {
    /// Begins work of a number of units; `shown` says whether there is a terminal to show it on.
    pub(crate) fn begin(name: impl Display, total: f64, shown: bool) -> Self {
        clear();
        *work() = shown.then(|| Work {
            begin: Instant::now(),
            name: name.to_string(),
            unit: String::new(),
            left: TimeLeft::new(total),
            bar: None,
        });
        Self(())
    }

    /// Begins the next part of the work, of a weight in units. The part before is done.
    pub(crate) fn part(&self, name: impl Display, weight: f64) {
        if let Some(work) = &mut *work() {
            work.unit = format!("  {name}");
            work.left.part(work.begin.elapsed().as_secs_f64(), weight);
        }
    }

    /// Corrects the units that are left, with those of the part that goes on.
    pub(crate) fn rest(&self, units: f64) {
        if let Some(work) = &mut *work() {
            work.left.total = work.left.done + units;
        }
    }
}

impl Drop for Task {
    fn drop(&mut self) {
        clear();
    }
}

/// Draws the line again; called a few times a second.
pub(crate) fn tick() {
    let mut work = work();
    let Some(work) = work.as_mut() else { return };
    let elapsed = work.begin.elapsed();
    if elapsed < SHOWN_AFTER {
        return;
    }
    let time = match work.left.left_s(elapsed.as_secs_f64()) {
        Some(left_s) => format!("about {} left", rounded(left_s)),
        None => format!("for {} s", elapsed.as_secs()),
    };
    let bar = work.bar.get_or_insert_with(|| {
        let style = ProgressStyle::with_template("{spinner} {wide_msg}");
        let style = style.unwrap_or_else(|_| ProgressStyle::default_spinner());
        ProgressBar::no_length().with_style(style)
    });
    let line = format!("{}{}  {time}", visible(&work.name), work.unit);
    match bar.message() == line {
        true => bar.tick(),
        false => bar.set_message(line),
    }
}

/// Ends the work and removes its line.
fn clear() {
    let bar = work().take().and_then(|work| work.bar);
    if let Some(bar) = bar {
        bar.finish_and_clear();
    }
}

/// Prints, on stderr or stdout, above the line.
pub(crate) fn suspended<T>(print: impl FnOnce() -> T) -> T {
    wait_if_ending();
    let bar = work().as_ref().and_then(|work| work.bar.clone());
    match bar {
        Some(bar) => bar.suspend(print),
        None => print(),
    }
}

/// Removes the line for the last words of a process that a signal ends.
pub(crate) fn end() {
    ENDING.store(true, Ordering::SeqCst);
    clear();
}

/// Waits for the end where a signal ends the process: what fails now fails because its files are removed.
pub(crate) fn wait_if_ending() {
    while ENDING.load(Ordering::SeqCst) {
        thread::park();
    }
}

/// A line on stderr.
pub(crate) fn as_it_is(line: &str) {
    // There is no place to report a lost stderr.
    let _ = suspended(|| writeln!(io::stderr().lock(), "{}", visible(line)));
}

fn work() -> MutexGuard<'static, Option<Work>> {
    WORK.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Estimate of the time left, from the time that the units done so far took. Times are seconds since the work began.
#[derive(Debug, Default)]
struct TimeLeft {
    total: f64,
    done: f64,
    /// Units of the part that goes on.
    current: f64,
    /// When it began.
    begin_s: f64,
    /// When an estimate was last shown, and which.
    shown: Option<(f64, f64)>,
}

impl TimeLeft {
    fn new(total: f64) -> Self {
        Self {
            total,
            ..Self::default()
        }
    }

    /// Begins a part; the one before is done.
    fn part(&mut self, now_s: f64, weight: f64) {
        self.done += self.current;
        self.current = weight;
        self.begin_s = now_s;
    }

    /// Seconds left; `None` before enough is done to tell.
    fn left_s(&mut self, now_s: f64) -> Option<f64> {
        if self.done <= LEAST_SHARE * self.total {
            return None;
        }
        let (per_unit_s, in_part_s) = (self.begin_s / self.done, now_s - self.begin_s);
        let rest_s = (self.total - self.done - self.current).max(0.0) * per_unit_s;
        let part_s = self.current * per_unit_s - in_part_s;
        let estimate_s = rest_s + part_s.max(-LATE_SHARE * part_s);
        let left_s = self.shown.map_or(estimate_s, |(at_s, left_s)| {
            let rise_s = (RISE.0 * left_s + RISE.1) * (now_s - at_s);
            estimate_s.min(left_s + rise_s)
        });
        self.shown = Some((now_s, left_s));
        Some(left_s)
    }
}

/// A time as exact as an estimate can be; never 0.
pub(crate) fn rounded(s: f64) -> String {
    let to = |step: f64| (s / step).ceil().max(1.0) as u64 * step as u64;
    match s {
        ..10.0 => format!("{} s", to(1.0)),
        ..60.0 => format!("{} s", to(5.0)),
        ..600.0 => format!("{}:{:02} min", to(10.0) / 60, to(10.0) % 60),
        ..3600.0 => format!("{} min", to(60.0) / 60),
        _ => format!("{}:{:02} h", to(300.0) / 3600, to(300.0) % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Estimates each tenth of a second while parts of these weights take these times.
    fn estimates(total: f64, parts: &[(f64, f64)]) -> Vec<(f64, Option<f64>)> {
        let (mut left, mut now_s, mut found) = (TimeLeft::new(total), 0.0, Vec::new());
        for &(weight, duration_s) in parts {
            left.part(now_s, weight);
            for _ in 0..(duration_s * 10.0).round() as usize {
                now_s += 0.1;
                found.push((now_s, left.left_s(now_s)));
            }
        }
        found
    }

    #[test]
    fn work_at_an_even_rate_ends_when_it_was_said_to() {
        let found = estimates(20.0, &[(4.0, 8.0), (1.0, 2.0), (15.0, 30.0)]);
        assert_eq!(found[0].1, None);
        for (now_s, left_s) in found {
            if let Some(left_s) = left_s {
                assert!((now_s + left_s - 40.0).abs() < 0.2, "{now_s} {left_s}");
            }
        }
    }

    #[test]
    fn a_part_that_takes_long_neither_jumps_nor_stands_at_zero() {
        // Its weight says 4 s, it takes 40.
        let found = estimates(10.0, &[(4.0, 4.0), (4.0, 40.0), (2.0, 2.0)]);
        let left: Vec<_> = found.iter().filter_map(|(_, left_s)| *left_s).collect();
        for pair in left.windows(2) {
            assert!(pair[1] - pair[0] < 1.0, "{pair:?}");
        }
        let in_part = &left[..400];
        assert!(in_part.iter().all(|&left_s| left_s > 1.99), "{in_part:?}");
    }

    #[test]
    fn times_are_as_exact_as_they_are_long() {
        for (s, words) in [
            (0.0, "1 s"),
            (7.2, "8 s"),
            (11.0, "15 s"),
            (61.0, "1:10 min"),
            (1000.0, "17 min"),
            (4000.0, "1:10 h"),
        ] {
            assert_eq!(rounded(s), words);
        }
    }
}
