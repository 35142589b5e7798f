//! Scales from data to pixels, and ticks at numbers that people count in.

/// A mark on an axis.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tick {
    pub(crate) value: f64,
    /// Empty where there is a line alone.
    pub(crate) label: String,
}

/// An axis: its name with the unit, and its values.
pub(crate) type Axis<'a> = (&'a str, Scale);

/// Part of a compared axis that one of several things takes up, all in the axis' unit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    /// Beginning of what is to be seen of it.
    pub(crate) low: f64,
    /// Value that must be legible, such as a third quartile.
    pub(crate) typical: f64,
    /// Farthest end of what is drawn.
    pub(crate) high: f64,
}

/// Largest extent over the smallest typical value at which a linear axis still shows both.
const LINEAR_UP_TO: f64 = 10.0;

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

    /// A logarithmic scale whose ends are 1, 2 or 5 times a power of ten. Bounds that are not positive become one decade.
    pub(crate) fn log(low: f64, high: f64) -> Self {
        let usable = |value: f64| value.is_finite() && value > 0.0;
        let low = if usable(low) { round_below(low) } else { 1.0 };
        let high = if usable(high) { round_above(high) } else { low };
        Self {
            log: true,
            low,
            high: if high > low { high } else { 10.0 * low },
            ..Self::default()
        }
    }

    /// The scale for extents that are compared with one another: linear from zero where the farthest reaches at most
    /// [`LINEAR_UP_TO`] times the smallest typical value, else logarithmic, so that none is pressed flat by another.
    /// What is not finite or not positive does not count.
    pub(crate) fn comparing(extents: impl IntoIterator<Item = Extent>, wanted: usize) -> Self {
        let (mut low, mut least, mut most) = (f64::INFINITY, f64::INFINITY, 0.0_f64);
        let counts = |value: f64| value.is_finite() && value > 0.0;
        for extent in extents {
            if counts(extent.typical) {
                least = least.min(extent.typical);
                low = low.min(extent.low);
            }
            if counts(extent.high) {
                most = most.max(extent.high);
            }
        }
        if least.is_finite() && most > LINEAR_UP_TO * least {
            Self::log(low.clamp(least / LINEAR_UP_TO, least), most)
        } else {
            Self::linear(0.0, nice_end(most, wanted))
        }
    }

    /// Whether the scale is logarithmic.
    pub(crate) fn is_log(&self) -> bool {
        self.log
    }

    /// The name of an axis, with a word where it is logarithmic.
    pub(crate) fn name(&self, name: &str) -> String {
        match (self.log && !name.is_empty(), name.strip_suffix(')')) {
            (false, _) => name.to_owned(),
            (true, Some(name)) => format!("{name}, logarithmic)"),
            (true, None) => format!("{name} (logarithmic)"),
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
            true => log_ticks(self.low, self.high, wanted),
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

/// Ticks at 1, 2 and 5 times powers of ten. Where they are many, powers alone have labels; where they are very many, there
/// are powers alone, some left out.
fn log_ticks(low: f64, high: f64, wanted: usize) -> Vec<Tick> {
    let inside =
        |value: f64| value >= low * (1.0 - STEP_ROUNDING) && value <= high * (1.0 + STEP_ROUNDING);
    let powers = decade_below(low)..=decade_below(high);
    let ticks = powers.flat_map(|power| [1, 2, 5].map(|factor| (factor, power)));
    let ticks: Vec<(Tick, bool)> = ticks
        .map(|(factor, power)| {
            let value = f64::from(factor) * 10f64.powi(power);
            let label = log_label(factor, power);
            (Tick { value, label }, factor == 1)
        })
        .filter(|(tick, _)| inside(tick.value))
        .collect();
    if ticks.len() > 3 * wanted {
        let powers: Vec<Tick> = (ticks.into_iter())
            .filter_map(|(tick, power)| power.then_some(tick))
            .collect();
        let stride = powers.len().saturating_sub(1).div_ceil(wanted.max(1));
        return powers.into_iter().step_by(stride.max(1)).collect();
    }
    let all = ticks.len() <= wanted + 2;
    let labelled = |(tick, power): (Tick, bool)| Tick {
        label: if all || power {
            tick.label
        } else {
            String::new()
        },
        ..tick
    };
    ticks.into_iter().map(labelled).collect()
}

/// Numbers that people read at a glance in full, others as powers of ten.
fn log_label(factor: i32, power: i32) -> String {
    if (-3..=3).contains(&power) {
        let digits = usize::try_from(-power).unwrap_or(0);
        return format!("{:.digits$}", f64::from(factor) * 10f64.powi(power));
    }
    const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digits = power.to_string();
    let raised = digits.chars().map(|digit| match digit.to_digit(10) {
        Some(digit) => RAISED[digit as usize],
        None => '⁻',
    });
    let power = format!("10{}", raised.collect::<String>());
    match factor {
        1 => power,
        _ => format!("{factor}×{power}"),
    }
}

/// Factors of powers of ten at which logarithmic axes may end.
const ROUND: [f64; 4] = [1.0, 2.0, 5.0, 10.0];

/// The largest round number not above a positive one.
fn round_below(value: f64) -> f64 {
    let unit = 10f64.powi(decade_below(value));
    let round = ROUND.map(|factor| factor * unit);
    let below = round
        .into_iter()
        .rfind(|&round| round <= value * (1.0 + STEP_ROUNDING));
    below.unwrap_or(unit)
}

/// The smallest round number not below a positive one.
fn round_above(value: f64) -> f64 {
    let unit = 10f64.powi(decade_below(value));
    let round = ROUND.map(|factor| factor * unit);
    let above = round
        .into_iter()
        .find(|&round| round >= value * (1.0 - STEP_ROUNDING));
    above.unwrap_or(10.0 * unit)
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
        let scale = Scale::log(1.3, 9000.0).over(0.0, 400.0);
        for (value, px) in [(1.0, 0.0), (10.0, 100.0), (100.0, 200.0), (10_000.0, 400.0)] {
            assert!((scale.at(value) - px).abs() < 1e-9, "{value}");
        }
        for (low, high, wanted, expected) in [
            (1.0, 10_000.0, 4, &["1", "10", "100", "1000", "10⁴"][..]),
            (1e-4, 1e8, 4, &["10⁻⁴", "0.1", "100", "10⁵", "10⁸"]),
            (0.15, 9.0, 5, &["0.1", "0.2", "0.5", "1", "2", "5", "10"]),
            (0.07, 13.0, 5, &["", "0.1", "", "", "1", "", "", "10", ""]),
            (3e4, 4e4, 5, &["2×10⁴", "5×10⁴"]),
        ] {
            assert_eq!(labels(&Scale::log(low, high).ticks(wanted)), expected);
        }
    }

    #[test]
    fn a_method_ten_times_worse_does_not_squeeze_the_others() {
        let axis = |typical_and_high: &[[f64; 2]]| {
            let extents = typical_and_high.iter().map(|&[typical, high]| Extent {
                low: 0.5 * typical,
                typical,
                high,
            });
            let axis = Scale::comparing(extents, 5);
            (axis.is_log(), axis.ends())
        };
        for (compared, expected) in [
            (&[[1.0, 2.0], [1.5, 9.0]][..], (false, [0.0, 10.0])),
            (&[[1.0, 2.0], [10.0, 10.0]], (false, [0.0, 10.0])),
            (&[[1.0, 2.0], [10.0, 10.5]], (true, [0.5, 20.0])),
            (&[[0.3, 0.9], [2.0, 40.0]], (true, [0.1, 50.0])),
            // What does not exist and what is exact has no say.
            (
                &[[f64::NAN, f64::NAN], [0.0, 0.0], [1.0, 4.0]],
                (false, [0.0, 4.0]),
            ),
            (&[[0.0, 0.0]], (false, [0.0, 1.0])),
            (&[], (false, [0.0, 1.0])),
        ] {
            assert_eq!(axis(compared), expected, "{compared:?}");
        }
        // Of a distribution down to zero a decade below what is typical is shown.
        let deep = Extent {
            low: 1e-9,
            typical: 1.0,
            high: 100.0,
        };
        assert_eq!(Scale::comparing([deep], 5).ends(), [0.1, 100.0]);
    }

    #[test]
    fn logarithmic_axes_are_named_so() {
        let (log, linear) = (Scale::log(1.0, 10.0), Scale::linear(0.0, 1.0));
        assert_eq!(log.name("error (mm)"), "error (mm, logarithmic)");
        assert_eq!(log.name("iteration"), "iteration (logarithmic)");
        assert_eq!(log.name(""), "");
        assert_eq!(linear.name("error (mm)"), "error (mm)");
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
