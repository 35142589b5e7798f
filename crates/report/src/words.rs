//! Numbers, lists and names as people read them: a fixed number of digits, never a rounding that turns "almost"
//! into "all" or "hardly" into "none".

/// Stands for a number that does not exist: nothing was evaluated, or the result was not finite.
pub(crate) const NONE: &str = "–";

/// Narrow no-break space, the SI separator between groups of three digits.
pub(crate) const NARROW_SPACE: char = '\u{202f}';

const MM_PER_M: f64 = 1e3;

/// Metres as millimetres.
pub(crate) fn to_mm(metres: f64) -> f64 {
    metres * MM_PER_M
}

/// A length in metres printed in millimetres with two decimals, a tenth of what cameras resolve.
pub(crate) fn millimetres(metres: f64) -> String {
    decimals(to_mm(metres), 2)
}

/// A number with fixed decimals; a positive one too small for them is shown as such, not as zero.
pub(crate) fn decimals(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    let step = 10f64.powi(-(digits as i32));
    if value > 0.0 && value < step / 2.0 {
        return format!("< {step:.digits$}");
    }
    let text = format!("{value:.digits$}");
    // A negative number that rounds to zero would print as "-0.00".
    if text
        .trim_start_matches('-')
        .bytes()
        .all(|b| matches!(b, b'0' | b'.'))
    {
        return text.trim_start_matches('-').to_owned();
    }
    text
}

/// A share (0 to 1) in percent with one decimal. Only all is 100.0 and only none is 0.0.
pub(crate) fn percent(share: f64) -> String {
    if !share.is_finite() {
        return NONE.to_owned();
    }
    let value = 100.0 * share;
    if share < 1.0 && value >= 99.95 {
        return "> 99.9".to_owned();
    }
    if share > 0.0 && value < 0.05 {
        return "< 0.1".to_owned();
    }
    // Adding zero turns the negative zero, which is what an empty sum is, into the positive one.
    format!("{:.1}", value + 0.0)
}

/// A count with its digits in groups of three; four digits stay together.
pub(crate) fn count(n: usize) -> String {
    let digits = n.to_string();
    if digits.len() <= 4 {
        return digits;
    }
    let mut text = String::with_capacity(digits.len() + digits.len());
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(NARROW_SPACE);
        }
        text.push(digit);
    }
    text
}

/// `3 of 119`.
pub(crate) fn part_of(part: usize, n: usize) -> String {
    format!("{} of {}", count(part), count(n))
}

/// `1 take`, `2 takes`: a count with a noun whose plural ends in s.
pub(crate) fn counted(n: usize, noun: &str) -> String {
    format!("{} {noun}{}", count(n), if n == 1 { "" } else { "s" })
}

/// The range of the counts there are: `12`, or `3 to 12`.
pub(crate) fn count_range(counts: &[usize]) -> String {
    match (counts.iter().min(), counts.iter().max()) {
        (Some(&low), Some(&high)) if low < high => format!("{} to {}", count(low), count(high)),
        (low, _) => count(low.copied().unwrap_or(0)),
    }
}

/// A number whose order of magnitude matters, such as a residual: two digits and an exponent.
pub(crate) fn scientific(value: f64) -> String {
    if !value.is_finite() {
        NONE.to_owned()
    } else if value == 0.0 {
        "0".to_owned()
    } else {
        format!("{value:.1e}")
    }
}

/// A difference in percent or points with its sign, whole where it is large, and its unit.
pub(crate) fn signed(value: f64, unit: &str) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    let digits = usize::from(value.abs() < 99.95);
    let text = format!("{:.digits$}", value.abs());
    if text.bytes().all(|b| matches!(b, b'0' | b'.')) {
        return text + unit;
    }
    format!("{}{text}{unit}", if value < 0.0 { '−' } else { '+' })
}

/// A number with three decimals at most.
pub(crate) fn short(value: f64) -> String {
    plain((value * 1e3).round() / 1e3)
}

/// A setting or rate: as few digits as needed, six at most.
pub(crate) fn plain(value: f64) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".to_owned()
    } else {
        text.to_owned()
    }
}

/// A stated share in percent, with as few digits as it was stated.
pub(crate) fn stated_percent(share: f64) -> String {
    // The product of a share such as 0.95 with 100 may end in a rounding error.
    plain((share * 1e8).round() / 1e6)
}

/// `a`, `a and b`, `a, b and c`.
pub(crate) fn join_words(items: &[String]) -> String {
    match items {
        [] => String::new(),
        [only] => only.clone(),
        [start @ .., last] => format!("{} and {last}", start.join(", ")),
    }
}

/// At most `letters` characters; what is cut leaves an ellipsis.
pub(crate) fn shortened(text: &str, letters: usize) -> String {
    if text.chars().count() <= letters {
        return text.to_owned();
    }
    text.chars()
        .take(letters.saturating_sub(1))
        .chain(['…'])
        .collect()
}

/// Keeps numbers and their units on one line.
pub(crate) fn tied(sentence: &str) -> String {
    const NO_BREAK: &str = "\u{a0}";
    [" mm", " %", "> ", "< "]
        .into_iter()
        .fold(sentence.to_owned(), |text, unit| {
            text.replace(unit, &unit.replace(' ', NO_BREAK))
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_two_decimals() {
        assert_eq!(millimetres(0.000_79), "0.79");
        assert_eq!(millimetres(0.018_2), "18.20");
        assert_eq!(millimetres(0.0), "0.00");
        assert_eq!(millimetres(-1e-9), "0.00");
        assert_eq!(millimetres(-0.001), "-1.00");
        assert_eq!(millimetres(f64::NAN), NONE);
        assert_eq!(millimetres(f64::INFINITY), NONE);
    }

    #[test]
    fn almost_all_is_not_all() {
        assert_eq!(percent(1.0), "100.0");
        assert_eq!(percent(0.999_9), "> 99.9");
        assert_eq!(percent(0.999), "99.9");
        assert_eq!(percent(0.0), "0.0");
        assert_eq!(percent(-0.0), "0.0");
        assert_eq!(percent(0.000_1), "< 0.1");
        assert_eq!(percent(f64::NAN), NONE);
        assert_eq!(millimetres(1e-6), "< 0.01");
    }

    #[test]
    fn counts_are_grouped() {
        let spaced = |n| count(n).replace(NARROW_SPACE, " ");
        assert_eq!(spaced(0), "0");
        assert_eq!(spaced(9999), "9999");
        assert_eq!(spaced(12_000), "12 000");
        assert_eq!(spaced(1_234_567), "1 234 567");
        assert_eq!(spaced(123_456), "123 456");
    }

    #[test]
    fn differences_have_signs() {
        for (value, text) in [
            (-12.34, "−12.3 %"),
            (5.0, "+5.0 %"),
            (0.01, "0.0 %"),
            (340.4, "+340 %"),
            (f64::NAN, NONE),
        ] {
            assert_eq!(signed(value, " %"), text);
        }
    }

    #[test]
    fn magnitudes_and_settings() {
        assert_eq!(scientific(3.14e-9), "3.1e-9");
        assert_eq!(scientific(0.0), "0");
        assert_eq!(scientific(f64::NAN), NONE);
        assert_eq!(plain(100.0), "100");
        assert_eq!(plain(59.94), "59.94");
        assert_eq!(plain(-0.0), "0");
    }

    #[test]
    fn words_are_joined_as_people_do() {
        let words = |n: usize| join_words(&["a", "b", "c"].map(str::to_owned)[..n]);
        assert_eq!(
            [words(0), words(1), words(2), words(3)],
            ["", "a", "a and b", "a, b and c"]
        );
    }

    #[test]
    fn long_names_are_shortened_by_letters() {
        assert_eq!(shortened("minimum_jerk", 20), "minimum_jerk");
        assert_eq!(shortened(&"é".repeat(20), 20), "é".repeat(20));
        assert_eq!(
            shortened(&"é".repeat(21), 20),
            format!("{}…", "é".repeat(19))
        );
    }
}
