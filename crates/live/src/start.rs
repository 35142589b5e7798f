//! Starts playback when the first client subscribes.

use std::time::Duration;

/// Time that a viewer may take, after the first topic, to ask for the others.
const SETTLE: Duration = Duration::from_millis(250);

/// Open while a client is subscribed, or always.
pub(crate) struct StartOnSubscribe {
    always: bool,
    /// Since when a client is subscribed.
    since: Option<Duration>,
}

impl StartOnSubscribe {
    pub(crate) fn new(always: bool) -> Self {
        Self {
            always,
            since: None,
        }
    }

    /// Notes whether a client is subscribed now.
    pub(crate) fn watch(&mut self, now: Duration, watching: bool) {
        self.since = match (watching, self.since) {
            (true, None) => Some(now),
            (true, since) => since,
            (false, _) => None,
        };
    }

    pub(crate) fn is_open(&self, now: Duration) -> bool {
        self.always || self.since.is_some_and(|since| now >= since + SETTLE)
    }

    /// Time until it opens; `None` where it is open or no client is subscribed.
    pub(crate) fn opens_in(&self, now: Duration) -> Option<Duration> {
        let since = self.since.filter(|_| !self.is_open(now))?;
        Some((since + SETTLE).saturating_sub(now))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(n: u64) -> Duration {
        Duration::from_millis(n)
    }

    #[test]
    fn it_opens_a_moment_after_the_first_one_watches_and_shuts_after_the_last() {
        let mut start = StartOnSubscribe::new(false);
        assert_eq!((start.is_open(ms(9)), start.opens_in(ms(9))), (false, None));
        start.watch(ms(10), true);
        start.watch(ms(110), true);
        assert_eq!(
            (start.is_open(ms(110)), start.opens_in(ms(110))),
            (false, Some(ms(150)))
        );
        assert_eq!(
            (start.is_open(ms(260)), start.opens_in(ms(260))),
            (true, None)
        );
        start.watch(ms(300), false);
        assert!(!start.is_open(ms(900)));
        assert!(StartOnSubscribe::new(true).is_open(ms(0)));
    }
}
