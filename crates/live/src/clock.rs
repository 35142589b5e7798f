//! Playback clock: log time as a function of elapsed time.

use std::time::Duration;

/// The slowest that can be played.
pub const SLOWEST: f64 = 0.01;

/// The fastest that can be played.
pub const FASTEST: f64 = 100.0;

/// Log time that passes at a speed, or is paused.
///
/// It asks no clock: `now` is the time since any fixed instant, and must not go back.
///
/// ```
/// use std::time::Duration;
///
/// use inhand_live::Clock;
///
/// let second = Duration::from_secs(1);
/// let mut clock = Clock::new((0, 60_000_000_000));
/// clock.set_speed(Duration::ZERO, 2.0);
/// clock.play(Duration::ZERO);
/// assert_eq!(clock.at(3 * second), 6_000_000_000);
/// clock.pause(3 * second);
/// assert_eq!(clock.at(10 * second), 6_000_000_000);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Clock {
    span: (u64, u64),
    /// Log time at the last change.
    anchor: u64,
    /// Time of that change; `None` while paused.
    since: Option<Duration>,
    speed: f64,
}

impl Clock {
    /// Paused at the first of two log times, nanoseconds since 1970-01-01 UTC, at speed 1.
    pub fn new(span: (u64, u64)) -> Self {
        Self {
            span,
            anchor: span.0,
            since: None,
            speed: 1.0,
        }
    }

    /// Log time now, never outside the span.
    pub fn at(&self, now: Duration) -> u64 {
        let Some(since) = self.since else {
            return self.anchor;
        };
        let passed = now.saturating_sub(since).as_nanos() as f64 * self.speed;
        // As a cast it stops at the largest number.
        self.anchor.saturating_add(passed as u64).min(self.span.1)
    }

    /// Whether log time passes. It does not pass the end.
    pub fn is_playing(&self) -> bool {
        self.since.is_some()
    }

    /// Whether the end is reached.
    pub fn is_at_end(&self, now: Duration) -> bool {
        self.at(now) >= self.span.1
    }

    /// Seconds of log time a second.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Lets log time pass.
    pub fn play(&mut self, now: Duration) {
        self.anchor = self.at(now);
        self.since = Some(now);
    }

    /// Pauses log time.
    pub fn pause(&mut self, now: Duration) {
        self.anchor = self.at(now);
        self.since = None;
    }

    /// Goes to a log time, or to the end of the span that is nearest.
    pub fn seek(&mut self, now: Duration, log_time: u64) {
        self.anchor = log_time.clamp(self.span.0, self.span.1);
        self.since = self.since.map(|_| now);
    }

    /// Changes the speed from now on, kept within [`SLOWEST`] and [`FASTEST`]. What is no number
    /// changes nothing.
    pub fn set_speed(&mut self, now: Duration, speed: f64) {
        if speed.is_nan() {
            return;
        }
        self.anchor = self.at(now);
        self.since = self.since.map(|_| now);
        self.speed = speed.clamp(SLOWEST, FASTEST);
    }

    /// Time until a log time is reached: nothing where it is past, `None` where it is later
    /// and the clock is paused.
    pub fn until(&self, now: Duration, log_time: u64) -> Option<Duration> {
        let left = log_time.saturating_sub(self.at(now));
        if left == 0 {
            return Some(Duration::ZERO);
        }
        self.since?;
        // Rounded up: waking before the time has come would be in vain.
        Some(Duration::from_nanos(
            (left as f64 / self.speed).ceil() as u64
        ))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SPAN: (u64, u64) = (1_000, 2_000_000_000_000);

    fn ms(n: u64) -> Duration {
        Duration::from_millis(n)
    }

    #[test]
    fn log_time_is_the_sum_of_what_passed_at_each_speed() {
        let mut clock = Clock::new(SPAN);
        assert_eq!(clock.at(ms(500)), SPAN.0);
        clock.play(ms(1_000));
        clock.set_speed(ms(2_000), 0.5);
        clock.pause(ms(6_000));
        clock.set_speed(ms(7_000), 4.0);
        clock.play(ms(8_000));
        // 1 s at 1, 4 s at 0.5, 2 s not at all, 1 s at 4.
        assert_eq!(clock.at(ms(9_000)), SPAN.0 + 7_000_000_000);
        assert_eq!(
            clock.until(ms(9_000), SPAN.0 + 9_000_000_000),
            Some(ms(500))
        );
    }

    #[test]
    fn playing_on_while_playing_changes_nothing() {
        let mut clock = Clock::new(SPAN);
        clock.play(ms(0));
        clock.play(ms(10));
        assert_eq!(clock.at(ms(30)), SPAN.0 + 30_000_000);
    }

    #[test]
    fn a_seek_ends_within_the_span_and_leaves_the_rest() {
        let mut clock = Clock::new((10, 90));
        clock.seek(ms(0), 5);
        assert_eq!((clock.at(ms(9)), clock.is_playing()), (10, false));
        clock.play(ms(10));
        clock.seek(ms(20), 100);
        assert_eq!((clock.at(ms(20)), clock.is_playing()), (90, true));
        assert!(clock.is_at_end(ms(20)));
        clock.seek(ms(30), 50);
        assert_eq!(clock.at(ms(30)), 50);
    }

    #[test]
    fn a_time_is_reached_at_once_or_never() {
        let mut clock = Clock::new((10, 90));
        assert_eq!(clock.until(ms(1), 10), Some(Duration::ZERO));
        assert_eq!(clock.until(ms(1), 11), None);
        clock.play(ms(1));
        assert_eq!(clock.until(ms(1), 11), Some(Duration::from_nanos(1)));
    }

    #[test]
    fn speeds_that_cannot_be_are_not_taken() {
        let mut clock = Clock::new(SPAN);
        for (asked, got) in [(0.0, SLOWEST), (-3.0, SLOWEST), (1e9, FASTEST), (2.0, 2.0)] {
            clock.set_speed(ms(0), asked);
            assert_eq!(clock.speed(), got);
        }
        clock.set_speed(ms(0), f64::NAN);
        assert_eq!(clock.speed(), 2.0);
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(200) })]

        #[test]
        fn without_a_seek_log_time_never_goes_back(
            changes in prop::collection::vec((0..3_u8, 0..5_000_u64, 0.01..100.0_f64), 1..30),
        ) {
            let mut clock = Clock::new((7, 60_000_000_000));
            let (mut now, mut last) = (0, 7);
            for (what, wait, speed) in changes {
                now += wait;
                let before = clock.at(ms(now));
                match what {
                    0 => clock.play(ms(now)),
                    1 => clock.pause(ms(now)),
                    _ => clock.set_speed(ms(now), speed),
                }
                // A change does not jump.
                prop_assert_eq!(clock.at(ms(now)), before);
                prop_assert!(last <= before && before <= 60_000_000_000);
                last = before;
            }
        }

        #[test]
        fn waiting_as_long_as_it_says_is_long_enough(
            speed in 0.01..100.0_f64,
            ahead in 1..1_000_000_000_000_u64,
        ) {
            let mut clock = Clock::new(SPAN);
            clock.set_speed(ms(0), speed);
            clock.play(ms(3));
            let time = SPAN.0 + ahead;
            let wait = clock.until(ms(3), time).expect("it plays");
            let reached = clock.at(ms(3) + wait);
            // To the precision of the product.
            prop_assert!(reached + 1 >= time, "{reached} {time}");
        }
    }
}
