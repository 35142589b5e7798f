//! Numbers, times and names as people read them.

use std::ops::Range;

use inhand_model::Clock;

/// Times or names listed before the rest is only counted.
const LISTED: usize = 3;

/// `3 gaps`, `1 gap`.
pub(crate) fn count(n: usize, [one, many]: [&str; 2]) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// When ranges start: `12.31 s, 48.02 s, 77.90 s and 4 more`.
pub(crate) fn times(clock: &Clock, ranges: &[Range<usize>]) -> String {
    some_of(
        ranges
            .iter()
            .map(|range| format!("{:.2} s", clock.time_s(range.start))),
    )
}

/// The first few of some things, and how many more there are.
pub(crate) fn names<'a>(names: impl ExactSizeIterator<Item = &'a str>) -> String {
    some_of(names.map(str::to_owned))
}

fn some_of(items: impl ExactSizeIterator<Item = String>) -> String {
    let n = items.len();
    // "and 1 more" is no shorter than the one.
    let shown = if n <= LISTED + 1 { n } else { LISTED };
    let listed = items.take(shown).collect::<Vec<_>>().join(", ");
    match n - shown {
        0 => listed,
        more => format!("{listed} and {more} more"),
    }
}

/// A share in percent with one decimal; only none is 0.0 and only all is 100.0.
pub(crate) fn percent(share: f64) -> String {
    if share > 0.0 && share < 0.0005 {
        return "< 0.1 %".to_owned();
    }
    if (0.9995..1.0).contains(&share) {
        return "> 99.9 %".to_owned();
    }
    format!("{:.1} %", 100.0 * share)
}

/// A length in the unit that keeps it readable: `0.18 mm`, `184 mm`, `1.32 m`, `132 m`.
pub(crate) fn length(metres: f64) -> String {
    let mm = 1e3 * metres;
    match mm.abs() {
        size if size < 10.0 => format!("{mm:.2} mm"),
        size if size < 1000.0 => format!("{mm:.0} mm"),
        size if size < 1e5 => format!("{metres:.2} m"),
        _ => format!("{metres:.0} m"),
    }
}

/// Without control characters: names come from files and are shown on terminals.
pub(crate) fn printable(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_end_with_how_many_are_left() {
        assert_eq!(names(["a", "b", "c", "d"].into_iter()), "a, b, c, d");
        assert_eq!(
            names(["a", "b", "c", "d", "e"].into_iter()),
            "a, b, c and 2 more"
        );
        assert_eq!(names([].into_iter()), "");
    }

    #[test]
    fn shares_and_lengths() {
        assert_eq!(percent(0.0), "0.0 %");
        assert_eq!(percent(1e-6), "< 0.1 %");
        assert_eq!(percent(0.9999), "> 99.9 %");
        assert_eq!(percent(1.0), "100.0 %");
        assert_eq!(length(0.000_18), "0.18 mm");
        assert_eq!(length(0.184), "184 mm");
        assert_eq!(length(1.84), "1.84 m");
        assert_eq!(length(184.0), "184 m");
    }

    #[test]
    fn control_characters_do_not_reach_a_terminal() {
        assert_eq!(printable("a\u{1b}[31mb\n"), "a [31mb ");
    }
}
