//! Start times as capture software writes them: local wall-clock time, day halves by locale, no
//! zone.

use inhand_model::{Clock, Finding, StartTime};
use jiff::civil::DateTime;
use jiff::tz::TimeZone;

use crate::error::CaptureError;
use crate::text::excerpt;

/// Words for the two halves of the day, without dots and spaces, upper case.
const BEFORE_NOON: [&str; 5] = ["AM", "DE", "上午", "午前", "오전"];
const AFTER_NOON: [&str; 5] = ["PM", "DU", "下午", "午後", "오후"];

const NO_DATE: &str = "no such date since 1970";

/// A start time as nanoseconds since 1970-01-01 UTC, what is known of it, and what was odd.
#[derive(Debug, PartialEq)]
pub(crate) struct Start {
    pub(crate) unix_nanos: u64,
    pub(crate) known: StartTime,
    pub(crate) finding: Option<Finding>,
}

impl Start {
    /// The clock of a take that starts then.
    pub(crate) fn clock(&self, rate_hz: f64, file: &str) -> Result<Clock, CaptureError> {
        Clock::new(self.unix_nanos, self.known, rate_hz)
            .map_err(|error| CaptureError::in_file(file, error))
    }
}

/// Reads `2023-03-29 06.23.40.520 PM` and its relatives: year, month, day, hour, minute, second,
/// optional fraction, with any separators; the half of the day anywhere in English, Hungarian,
/// Chinese, Japanese or Korean. Without one the hour counts from 0 to 23.
///
/// There is no zone, so the time is taken as UTC. Text that is no time gives
/// [`StartTime::Unknown`] and a finding.
pub(crate) fn parse(key: &str, text: Option<&str>) -> Start {
    let text = text.map_or("", str::trim);
    let parsed = match text {
        "" => Err(Finding::info(
            key,
            "the file states no start time: the take starts at 1970-01-01",
        )),
        text => parse_stated(text).map_err(|what| {
            let found = excerpt(text.as_bytes());
            let message = format!(
                "expected a time such as 2023-03-29 06.23.40.520 PM, found \"{found}\" ({what}): \
                 the take starts at 1970-01-01"
            );
            Finding::warning(key, message)
        }),
    };
    match parsed {
        Ok((unix_nanos, is_clear)) => Start {
            unix_nanos,
            known: StartTime::AssumedUtc,
            finding: (!is_clear).then(|| {
                let message =
                    format!("\"{text}\" names no half of the day: taken as a 24-hour time");
                Finding::info(key, message)
            }),
        },
        Err(finding) => Start {
            unix_nanos: 0,
            known: StartTime::Unknown,
            finding: Some(finding),
        },
    }
}

/// The time, and whether it is clear in which half of the day it is; or what is wrong with it.
fn parse_stated(text: &str) -> Result<(u64, bool), &'static str> {
    let numbers = text.split(|c: char| !c.is_ascii_digit());
    let numbers: Vec<&str> = numbers.filter(|digits| !digits.is_empty()).collect();
    let (numbers, fraction) = match numbers[..] {
        [ref numbers @ .., fraction] if numbers.len() == 6 => (numbers, fraction),
        ref numbers if numbers.len() == 6 => (numbers, "0"),
        ref numbers if numbers.len() > 7 => return Err("more than seven numbers"),
        _ => return Err("not six numbers"),
    };
    if fraction.len() > 9 {
        return Err("a fraction of more than nine digits");
    }
    let [year, month, day, hour, minute, second] = numbers[..] else {
        return Err("not six numbers");
    };
    let hour: u8 = hour.parse().map_err(|_| NO_DATE)?;
    let half = text.chars().filter(|c| c.is_alphabetic());
    let half: String = half.flat_map(char::to_uppercase).collect();
    // Locales without words for the halves of the day write 12-hour times all the same.
    let is_clear = !half.is_empty() || !(1..=12).contains(&hour);
    let hour = match (half.as_str(), hour) {
        (half, 0..12) if AFTER_NOON.contains(&half) => hour + 12,
        (half, 12) if BEFORE_NOON.contains(&half) => 0,
        (half, _) if half.is_empty() || AFTER_NOON.contains(&half) => hour,
        (half, _) if BEFORE_NOON.contains(&half) => hour,
        _ => return Err("a half of the day that is not known here"),
    };
    let time = format!("{year:0>4}-{month}-{day} {hour}:{minute}:{second}.{fraction}");
    let time = DateTime::strptime("%Y-%m-%d %H:%M:%S%.f", time);
    let zoned = time.and_then(|time| time.to_zoned(TimeZone::UTC));
    let nanos = zoned.map_err(|_| NO_DATE)?.timestamp().as_nanosecond();
    Ok((u64::try_from(nanos).map_err(|_| NO_DATE)?, is_clear))
}

/// A start time in Motive's spelling, English day halves; milliseconds, or as many digits as a
/// finer time needs. `None` past the year 9999.
pub(crate) fn format(unix_nanos: u64) -> Option<String> {
    let timestamp = jiff::Timestamp::from_nanosecond(i128::from(unix_nanos)).ok()?;
    let time = timestamp.to_zoned(TimeZone::UTC).datetime();
    let mut fraction = format!("{:09}", time.subsec_nanosecond());
    while fraction.len() > 3 && fraction.ends_with('0') {
        fraction.pop();
    }
    let (seconds, half) = (time.strftime("%Y-%m-%d %I.%M.%S"), time.strftime("%p"));
    Some(format!("{seconds}.{fraction} {half}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2023-11-28 00:00:00 UTC, from `date -u -d 2023-11-28 +%s`.
    const DAY_S: u64 = 1_701_129_600;

    fn nanos(hour: u64, minute: u64, second: u64, millis: u64) -> u64 {
        (DAY_S + hour * 3600 + minute * 60 + second) * 1_000_000_000 + millis * 1_000_000
    }

    #[test]
    fn every_locale_seen() {
        let morning = nanos(10, 27, 58, 765);
        let evening = nanos(22, 27, 58, 765);
        for (text, expected) in [
            ("2023-11-28 10.27.58.765 AM", morning),
            ("2023-11-28 10.27.58.765 PM", evening),
            ("2023-11-28 10.27.58.765 p.m.", evening),
            ("2023-11-28 10.27.58.765 DU.", evening),
            ("2023-11-28 10.27.58.765 de.", morning),
            ("2023-11-28 10.27.58.765 上午", morning),
            ("2023-11-28 下午 10.27.58.765", evening),
            ("2023-11-28 10.27.58.765 ", morning),
            ("2023-11-28 22.27.58.765", evening),
            ("2023-11-28, 22:27:58.765", evening),
            ("2023-11-28 12.00.00.000 AM", nanos(0, 0, 0, 0)),
            ("2023-11-28 12.00.00.000 PM", nanos(12, 0, 0, 0)),
            ("2023-11-28 00.00.01", nanos(0, 0, 1, 0)),
        ] {
            let start = parse("Capture Start Time", Some(text));
            assert_eq!(start.unix_nanos, expected, "{text}");
            assert_eq!(start.known, StartTime::AssumedUtc, "{text}");
        }
        assert!(parse("", Some("2023-11-28 10.27.58")).finding.is_some());
        assert!(parse("", Some("2023-11-28 22.27.58")).finding.is_none());
        assert!(parse("", Some("2023-11-28 10.27.58 AM")).finding.is_none());
    }

    #[test]
    fn what_is_no_time_is_unknown_with_a_finding() {
        for text in [
            None,
            Some(""),
            Some("yesterday"),
            Some("2023-11-28"),
            Some("2023-13-28 10.27.58.765 AM"),
            Some("2023-11-28 25.27.58.765"),
            Some("2023-11-28 10.27.58.765 XX"),
            Some("2023-11-28 10.27.58.7651234567"),
            Some("1234-11-28 10.27.58.765 PM"),
            Some("99999999999 1 1 1 1 1"),
            Some("1 2 3 4 5 6 7 8"),
        ] {
            let start = parse("Capture Start Time", text);
            assert_eq!(
                (start.unix_nanos, start.known),
                (0, StartTime::Unknown),
                "{text:?}"
            );
            assert!(start.finding.is_some(), "{text:?}");
        }
    }

    #[test]
    fn written_times_read_back() {
        assert_eq!(
            format(nanos(22, 27, 58, 765)).as_deref(),
            Some("2023-11-28 10.27.58.765 PM")
        );
        for hour in [0, 1, 11, 12, 13, 23] {
            for extra_nanos in [0, 1, 500_000, 123_456_789] {
                let time = nanos(hour, 59, 0, 0) + extra_nanos;
                let text = format(time).unwrap();
                assert_eq!(parse("", Some(&text)).unix_nanos, time, "{text}");
            }
        }
    }
}
