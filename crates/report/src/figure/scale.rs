//! Scales from data to pixels, and ticks at numbers that people count in.

/// A mark on an axis.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tick {
    pub(crate) value: f64,
    pub(crate) label: String,
}

/// An axis: its name with the unit, and its values.
pub(crate) type Axis<'a> = (&'a str, Scale);

/// Maps `low..=high` onto `from_px..=to_px`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Scale {
    /// Whether equal ratios are equally far apart, not equal differences.
    log: bool,
    low: f64,
    high: f64,
    from_px: f64,
    to_px: f64,
}

impl Scale {
    /// A linear scale. A range that is empty, reversed or not finite becomes one unit wide, so
    /// that a figure of nothing still has an axis.
    pub(crate) fn linear(low: f64, high: f64) -> Self {
        let low = if low.is_finite() { low } else { 0.0 };
        let high = if high.is_finite() && high > low {
            high
        } else {
            low + 1.0
        };
        Self {
            low,
            high,
            ..Self::default()
        }
    }

    /// A logarithmic scale over whole decades. Bounds that are not positive become one decade.
    pub(crate) fn log(low: f64, high: f64) -> Self {
        let usable = |value: f64| value.is_finite() && value > 0.0;
        let low = if usable(low) { low } else { 1.0 };
        let low = 10f64.powi(decade_below(low));
        let high = if usable(high) { high } else { low };
        let above = decade_above(high).max(decade_below(low) + 1);
        Self {
            log: true,
            low,
            high: 10f64.powi(above),
            ..Self::default()
        }
    }

    /// The scale over these pixels.
    pub(crate) fn over(self, from_px: f64, to_px: f64) -> Self {
        Self {
            from_px,
            to_px,
            ..self
        }
    }

    /// Spread, values and pixels of both ends, for a script that turns pixels back into values.
    pub(crate) fn describe(&self) -> String {
        let spread = if self.log { "log" } else { "linear" };
        format!(
            "{spread} {} {} {} {}",
            self.low, self.high, self.from_px, self.to_px
        )
    }

    /// Smallest and largest value on the axis.
    pub(crate) fn ends(&self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// Pixel of a value; outside the axis for values outside the range.
    pub(crate) fn at(&self, value: f64) -> f64 {
        let share = match self.log {
            true => (value / self.low).log10() / (self.high / self.low).log10(),
            false => (value - self.low) / (self.high - self.low),
        };
        self.from_px + share * (self.to_px - self.from_px)
    }

    /// At most about `wanted` + 1 ticks, all inside the range.
    pub(crate) fn ticks(&self, wanted: usize) -> Vec<Tick> {
        match self.log {
            true => decade_ticks(decade_below(self.low), decade_below(self.high), wanted),
            false => linear_ticks(self.low, self.high, wanted),
        }
    }
}

/// The smallest of 1, 2, 5 times a power of ten that divides `span` into at most `wanted` steps.
pub(crate) fn nice_step(span: f64, wanted: usize) -> f64 {
    let rough = span / wanted.max(1) as f64;
    let unit = 10f64.powi(decade_below(rough));
    [1.0, 2.0, 5.0]
        .into_iter()
        .map(|factor| factor * unit)
        .find(|&step| step * (1.0 + STEP_ROUNDING) >= rough)
        .unwrap_or(10.0 * unit)
}

/// A span that is a whole number of steps up to rounding errors still counts as one.
const STEP_ROUNDING: f64 = 1e-9;

/// The next multiple of a nice step at or above `value`; 1 where there is nothing to show.
pub(crate) fn nice_end(value: f64, wanted: usize) -> f64 {
    if !(value.is_finite() && value > 0.0) {
        return 1.0;
    }
    let step = nice_step(value, wanted);
    (value / step - STEP_ROUNDING).ceil() * step
}

/// Ends on whole steps around those of the values that are finite, at least `shortest` apart; 0 to 1 where there
/// are none.
pub(crate) fn whole_steps(
    values: impl IntoIterator<Item = f64>,
    shortest: f64,
    wanted: usize,
) -> [f64; 2] {
    let values = values.into_iter().filter(|value| value.is_finite());
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    if low > high {
        return [0.0, 1.0];
    }
    let missing = 0.5 * (shortest - (high - low)).max(0.0);
    let (low, high) = (low - missing, high + missing);
    if low == high {
        return [low, low + 1.0];
    }
    let step = nice_step(high - low, wanted);
    [(low / step).floor() * step, (high / step).ceil() * step]
}

fn linear_ticks(low: f64, high: f64, wanted: usize) -> Vec<Tick> {
    let step = nice_step(high - low, wanted);
    let digits = usize::try_from(-decade_below(step * (1.0 + STEP_ROUNDING))).unwrap_or(0);
    let first = (low / step - STEP_ROUNDING).ceil() as i64;
    let last = (high / step + STEP_ROUNDING).floor() as i64;
    (first..=last)
        .map(|multiple| {
            let value = multiple as f64 * step;
            Tick {
                value,
                label: format!("{value:.digits$}"),
            }
        })
        .collect()
}

fn decade_ticks(low: i32, high: i32, wanted: usize) -> Vec<Tick> {
    let stride = usize::try_from(high - low)
        .unwrap_or(0)
        .div_ceil(wanted.max(1))
        .max(1);
    (low..=high)
        .step_by(stride)
        .map(|exponent| Tick {
            value: 10f64.powi(exponent),
            label: power_label(exponent),
        })
        .collect()
}

/// Powers of ten that people read at a glance in full, others with an exponent.
fn power_label(exponent: i32) -> String {
    match exponent {
        -3..0 => format!(
            "{:.*}",
            exponent.unsigned_abs() as usize,
            10f64.powi(exponent)
        ),
        0..=3 => format!("{}", 10f64.powi(exponent)),
        _ => {
            const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
            let digits = exponent.to_string();
            let raised = digits.chars().map(|digit| match digit.to_digit(10) {
                Some(digit) => RAISED[digit as usize],
                None => '⁻',
            });
            format!("10{}", raised.collect::<String>())
        }
    }
}

/// Exponent of the largest power of ten not above `value`, exact at powers of ten.
fn decade_below(value: f64) -> i32 {
    if !(value.is_finite() && value > 0.0) {
        return 0;
    }
    let exponent = value.log10().floor() as i32;
    // The logarithm of a power of ten may come out a hair below the whole number.
    if 10f64.powi(exponent + 1) <= value {
        exponent + 1
    } else {
        exponent
    }
}

fn decade_above(value: f64) -> i32 {
    let below = decade_below(value);
    if 10f64.powi(below) < value {
        below + 1
    } else {
        below
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ticks: &[Tick]) -> Vec<&str> {
        ticks.iter().map(|tick| tick.label.as_str()).collect()
    }

    #[test]
    fn linear_scale_is_affine() {
        let scale = Scale::linear(2.0, 12.0).over(100.0, 300.0);
        for (value, px) in [(2.0, 100.0), (7.0, 200.0), (12.0, 300.0), (17.0, 400.0)] {
            assert_eq!(scale.at(value), px);
        }
        let downwards = Scale::linear(0.0, 1.0).over(200.0, 0.0);
        assert_eq!(downwards.at(0.25), 150.0);
    }

    #[test]
    fn log_scale_gives_equal_room_to_equal_ratios() {
        let scale = Scale::log(3.0, 2000.0).over(0.0, 400.0);
        for (value, px) in [(1.0, 0.0), (10.0, 100.0), (100.0, 200.0), (10_000.0, 400.0)] {
            assert!((scale.at(value) - px).abs() < 1e-9, "{value}");
        }
        assert_eq!(labels(&scale.ticks(5)), ["1", "10", "100", "1000", "10⁴"]);
        assert_eq!(
            labels(&Scale::log(1e-4, 1e8).over(0.0, 1.0).ticks(4)),
            ["10⁻⁴", "0.1", "100", "10⁵", "10⁸"]
        );
    }

    #[test]
    fn steps_are_one_two_five() {
        for (span, wanted, step) in [
            (10.0, 5, 2.0),
            (10.0, 10, 1.0),
            (13.0, 5, 5.0),
            (0.3, 3, 0.1),
            (0.7, 5, 0.2),
            (99.0, 5, 20.0),
            (100.0, 5, 20.0),
            (101.0, 5, 50.0),
            (6.0, 1, 10.0),
        ] {
            assert!(
                (nice_step(span, wanted) / step - 1.0).abs() < 1e-12,
                "{span} in {wanted}"
            );
        }
    }

    #[test]
    fn ticks_are_whole_multiples_with_matching_digits() {
        let ticks = |low, high| Scale::linear(low, high).over(0.0, 1.0).ticks(5);
        assert_eq!(
            labels(&ticks(0.0, 1.0)),
            ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]
        );
        assert_eq!(labels(&ticks(0.0, 14.0)), ["0", "5", "10"]);
        assert_eq!(
            labels(&ticks(0.0, 0.05)),
            ["0.00", "0.01", "0.02", "0.03", "0.04", "0.05"]
        );
        assert_eq!(
            labels(&ticks(90.0, 100.0)),
            ["90", "92", "94", "96", "98", "100"]
        );
        assert_eq!(labels(&ticks(-3.0, 3.0)), ["-2", "0", "2"]);
    }

    #[test]
    fn ends_are_next_multiple_of_the_step() {
        for (value, end) in [
            (13.0, 14.0),
            (2.9, 3.0),
            (3.0, 3.0),
            (0.31, 0.35),
            (11.3, 12.0),
        ] {
            assert!(
                (nice_end(value, 8) - end).abs() < 1e-9,
                "{value}: {}",
                nice_end(value, 8)
            );
        }
        assert_eq!(nice_end(f64::NAN, 5), 1.0);
        assert_eq!(nice_end(0.0, 5), 1.0);
    }

    #[test]
    fn axes_hold_all_values_and_are_no_drama_of_rounding() {
        assert_eq!(whole_steps([-12.0, -18.0, 0.0], 10.0, 4), [-20.0, 0.0]);
        assert_eq!(
            whole_steps([52.0, 44.0, 61.0, f64::NAN], 10.0, 5),
            [40.0, 65.0]
        );
        assert_eq!(whole_steps([95.0], 10.0, 5), [90.0, 100.0]);
        assert_eq!(whole_steps([2.0], 0.0, 5), [2.0, 3.0]);
        assert_eq!(whole_steps([f64::NAN], 10.0, 5), [0.0, 1.0]);
    }

    #[test]
    fn empty_and_broken_ranges_still_make_an_axis() {
        for (low, high) in [
            (0.0, 0.0),
            (5.0, 1.0),
            (f64::NAN, f64::NAN),
            (0.0, f64::INFINITY),
        ] {
            let scale = Scale::linear(low, high).over(0.0, 100.0);
            assert!(scale.at(scale.ends()[1]).is_finite());
            assert!(!scale.ticks(5).is_empty());
            let scale = Scale::log(low, high).over(0.0, 100.0);
            assert_eq!(scale.at(scale.ends()[1]), 100.0);
            assert!(scale.ticks(5).len() >= 2);
        }
    }
}
