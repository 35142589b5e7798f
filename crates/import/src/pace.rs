//! Even clocks of stamps: the period, and the sample that each stamp belongs to.
//!
//! Stamps jitter, frames are dropped, clocks of computers and cameras drift apart by parts in a
//! million. The period is the slope of a least-squares line through stamps and sample numbers;
//! samples are numbered along a phase that follows the stamps slowly, so that neither jitter nor
//! drift moves a number.

/// Gain of the phase towards the stamps once it has settled.
const PHASE_GAIN: f64 = 1.0 / 16.0;

/// Rounds of numbering and fitting.
const ROUNDS: usize = 4;

/// A period is proven where stamps are around their instants by at most this share of it, root mean
/// square. Stamps without any period come to 0.29, the spread of a uniform distribution.
const PROVEN_JITTER: f64 = 0.2;

/// Largest relative difference of the clocks of cameras and computers: 200 millionths.
const CLOCK_TOLERANCE: f64 = 2e-4;

/// Largest error of a measured rate, standard errors.
const STANDARD_ERRORS: f64 = 4.0;

/// A rate is only taken as a whole number where the range that it may be in is narrower than this
/// to either side, Hz.
const SNAP_RANGE_HZ: f64 = 0.25;

/// Rates that are no whole numbers and that devices have all the same: those of television.
const OTHER_RATES_HZ: [f64; 5] = [
    24_000.0 / 1001.0,
    30_000.0 / 1001.0,
    60_000.0 / 1001.0,
    120_000.0 / 1001.0,
    240_000.0 / 1001.0,
];

/// The period of a series of stamps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pace {
    pub(crate) period_s: f64,
    /// Standard error of the period.
    pub(crate) error_s: f64,
    /// Distance of stamps from their instants, root mean square.
    pub(crate) jitter_s: f64,
}

impl Pace {
    /// The pace of rising times in seconds, near `period_s` where that is given; `None` for fewer
    /// than two.
    pub(crate) fn new(times_s: &[f64], period_s: Option<f64>) -> Option<Self> {
        let period_s = match period_s {
            Some(period_s) => period_s,
            None => median(times_s.windows(2).map(|pair| pair[1] - pair[0]).collect())?,
        };
        if times_s.len() < 2 || period_s <= 0.0 {
            return None;
        }
        // A first period from rounded stamps can be off too far for a phase to follow.
        let (mut period_s, mut error_s) = slope(times_s, &by_steps(times_s, period_s))?;
        for _ in 1..ROUNDS {
            (period_s, error_s) = slope(times_s, &Phase::numbers(times_s, period_s).0)?;
        }
        let (_, jitter_s) = Phase::numbers(times_s, period_s);
        Some(Self {
            period_s,
            error_s,
            jitter_s,
        })
    }

    pub(crate) fn rate_hz(&self) -> f64 {
        1.0 / self.period_s
    }

    /// Standard error of the rate.
    pub(crate) fn rate_error_hz(&self) -> f64 {
        self.error_s / (self.period_s * self.period_s)
    }

    /// Whether the stamps have this period at all.
    pub(crate) fn is_proven(&self) -> bool {
        self.jitter_s <= PROVEN_JITTER * self.period_s
    }

    /// The rate that devices have and that the stamps single out, if there is one.
    pub(crate) fn device_rate_hz(&self) -> Option<f64> {
        let rate_hz = self.rate_hz();
        let range_hz = CLOCK_TOLERANCE * rate_hz + STANDARD_ERRORS * self.rate_error_hz();
        let off = |candidate: &f64| (candidate - rate_hz).abs();
        let candidates = OTHER_RATES_HZ.into_iter().chain([rate_hz.round()]);
        let nearest = candidates.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        let singled_out = self.is_proven() && range_hz < SNAP_RANGE_HZ && nearest > 0.0;
        (singled_out && off(&nearest) <= range_hz).then_some(nearest)
    }
}

/// Numbers by the whole periods from one time to the next.
fn by_steps(times_s: &[f64], period_s: f64) -> Vec<f64> {
    let mut number = 0.0;
    let steps = times_s.windows(2).map(|pair| {
        number += ((pair[1] - pair[0]) / period_s).round();
        number
    });
    [0.0].into_iter().chain(steps).collect()
}

/// Slope of a line through times over their numbers, and its standard error.
fn slope(times_s: &[f64], numbers: &[f64]) -> Option<(f64, f64)> {
    let n = times_s.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / n;
    let (mean_time, mean_number) = (mean(times_s), mean(numbers));
    let (mut squares, mut products) = (0.0, 0.0);
    for (time_s, number) in times_s.iter().zip(numbers) {
        squares += (number - mean_number).powi(2);
        products += (number - mean_number) * (time_s - mean_time);
    }
    let slope_s = products / squares;
    if !(slope_s.is_finite() && slope_s > 0.0) {
        return None;
    }
    let residual = |(time_s, number): (&f64, &f64)| {
        (time_s - mean_time - slope_s * (number - mean_number)).powi(2)
    };
    let variance = times_s.iter().zip(numbers).map(residual).sum::<f64>() / (n - 2.0).max(1.0);
    Some((slope_s, (variance / squares).sqrt()))
}

/// The instant of the newest sample, as the stamps so far have it.
struct Phase {
    time_s: f64,
    number: u64,
    period_s: f64,
    seen: f64,
}

impl Phase {
    fn start(time_s: f64, period_s: f64) -> Self {
        Self {
            time_s,
            number: 0,
            period_s,
            seen: 1.0,
        }
    }

    /// Goes on to the sample that a later time belongs to; returns the distance of the time from it.
    fn follow(&mut self, time_s: f64) -> f64 {
        let steps = ((time_s - self.time_s) / self.period_s).round().max(0.0);
        let instant_s = self.time_s + steps * self.period_s;
        let off_s = time_s - instant_s;
        self.seen += 1.0;
        self.time_s = instant_s + off_s * PHASE_GAIN.max(1.0 / self.seen);
        self.number = self.number.saturating_add(steps as u64);
        off_s
    }

    /// The sample of each time, and the distance of times from their samples, root mean square.
    fn numbers(times_s: &[f64], period_s: f64) -> (Vec<f64>, f64) {
        let Some((&first_s, later)) = times_s.split_first() else {
            return (Vec::new(), 0.0);
        };
        let mut phase = Phase::start(first_s, period_s);
        let mut numbers = vec![0.0];
        let mut squares = 0.0;
        for &time_s in later {
            squares += phase.follow(time_s).powi(2);
            numbers.push(phase.number as f64);
        }
        (numbers, (squares / times_s.len() as f64).sqrt())
    }
}

/// The samples of a take and their times.
pub(crate) struct Grid {
    base_nanos: u64,
    period_s: f64,
    /// Instant and number of every sample that has a stamp.
    knots: Vec<(f64, u64)>,
}

/// Stamps further apart than this are those before and after a pause.
const PAUSE_S: f64 = 1.0;

/// First stamps that the start of the take is taken from.
const START_STAMPS: usize = 100;

impl Grid {
    /// The samples of rising times; `None` without any.
    pub(crate) fn new(times_nanos: &[u64], period_s: f64) -> Option<Self> {
        let &base_nanos = times_nanos.first()?;
        let mut phase = Phase::start(0.0, period_s);
        let mut knots = vec![(0.0, 0)];
        for &time in &times_nanos[1..] {
            phase.follow(seconds(base_nanos, time));
            let knot = (phase.time_s, phase.number);
            match knots.last_mut() {
                Some(last) if last.1 == phase.number => *last = knot,
                _ => knots.push(knot),
            }
        }
        Some(Self {
            base_nanos,
            period_s,
            knots,
        })
    }

    /// Samples from the first to the last stamp.
    pub(crate) fn len(&self) -> u64 {
        self.knots.last().map_or(0, |&(_, number)| number + 1)
    }

    /// Samples at which there is a stamp.
    pub(crate) fn stamped(&self) -> u64 {
        self.knots.len() as u64
    }

    /// Whether most samples are empty between stamps that are less than [`PAUSE_S`] apart: a pause says nothing of
    /// the clock, and messages that waited share samples now and fill others later.
    pub(crate) fn is_mostly_empty(&self, messages: usize) -> bool {
        let steps = self.knots.windows(2).map(|pair| pair[1].1 - pair[0].1);
        let short = steps.filter(|&steps| steps as f64 * self.period_s < PAUSE_S);
        let empty: u64 = short.map(|steps| steps - 1).sum();
        empty > self.stamped().max(messages as u64)
    }

    /// Time of sample 0.
    pub(crate) fn start_nanos(&self) -> u64 {
        let early = self.knots.iter().take(START_STAMPS);
        let off = early.map(|&(time_s, number)| time_s - number as f64 * self.period_s);
        let off_s = median(off.collect()).unwrap_or(0.0);
        (self.base_nanos).saturating_add_signed((off_s * 1e9).round() as i64)
    }

    /// The sample that a time belongs to, and its distance in periods; `None` outside the
    /// take.
    pub(crate) fn sample(&self, time_nanos: u64) -> Option<(usize, f64)> {
        let time_s = seconds(self.base_nanos, time_nanos);
        let after = self.knots.partition_point(|&(knot_s, _)| knot_s <= time_s);
        let &(knot_s, number) = self.knots.get(after.saturating_sub(1))?;
        let steps = ((time_s - knot_s) / self.period_s).round();
        // The instant of the next sample with a stamp is known better.
        let next = (self.knots.get(after)).filter(|_| after > 0);
        let (number, instant_s) = match next {
            Some(&(next_s, next)) if number as f64 + steps >= next as f64 => (next as f64, next_s),
            _ => (number as f64 + steps, knot_s + steps * self.period_s),
        };
        let inside = number >= 0.0 && number < self.len() as f64;
        inside.then(|| (number as usize, (time_s - instant_s) / self.period_s))
    }
}

/// Seconds from one time to another, which may be before it.
pub(crate) fn seconds(base_nanos: u64, time_nanos: u64) -> f64 {
    let magnitude = time_nanos.abs_diff(base_nanos) as f64 / 1e9;
    if time_nanos < base_nanos {
        -magnitude
    } else {
        magnitude
    }
}

/// The middle value; the lower one of two.
pub(crate) fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len().checked_sub(1)? / 2;
    let (_, &mut median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    Some(median)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Noise from -1 to 1 that is the same at every call.
    fn noise(n: usize) -> f64 {
        let mut x = (n as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        ((x >> 11) as f64 / (1_u64 << 52) as f64) - 1.0
    }

    fn pace(times_s: &[f64]) -> Pace {
        Pace::new(times_s, None).unwrap()
    }

    #[test]
    fn exact_stamps_give_the_exact_rate() {
        for rate_hz in [25.0, 100.0, 120.0, 240.0, 360.0] {
            let times_s: Vec<f64> = (0..500).map(|k| f64::from(k) / rate_hz).collect();
            let pace = pace(&times_s);
            assert_eq!(pace.device_rate_hz(), Some(rate_hz));
            assert!(pace.jitter_s < 1e-12);
        }
    }

    #[test]
    fn rounded_and_jittered_stamps_with_drops_still_do() {
        // 120 Hz to the millisecond: steps of 8 and 9 ms.
        let rounded: Vec<f64> = (0..600)
            .map(|k| (f64::from(k) / 120.0 * 1e3).round() / 1e3)
            .collect();
        assert_eq!(pace(&rounded).device_rate_hz(), Some(120.0));
        // 100 Hz, every seventh frame dropped, 2 ms of jitter.
        let jittered: Vec<f64> = (0..3000)
            .filter(|k| k % 7 != 3)
            .map(|k| k as f64 / 100.0 + 2e-3 * noise(k))
            .collect();
        let pace = pace(&jittered);
        assert_eq!(pace.device_rate_hz(), Some(100.0));
        assert!(
            (pace.jitter_s - 2e-3 / 3_f64.sqrt()).abs() < 2e-4,
            "{pace:?}"
        );
    }

    #[test]
    fn rates_between_whole_numbers_stay() {
        let rate_hz = 99.5;
        let times_s: Vec<f64> = (0..2000).map(|k| f64::from(k) / rate_hz).collect();
        let pace = pace(&times_s);
        assert_eq!(pace.device_rate_hz(), None);
        assert!((pace.rate_hz() - rate_hz).abs() < 1e-9);
        let television: Vec<f64> = (0..2000)
            .map(|k| f64::from(k) * 1001.0 / 60_000.0)
            .collect();
        let rate_hz = Pace::new(&television, None).unwrap().device_rate_hz();
        assert_eq!(rate_hz, Some(60_000.0 / 1001.0));
    }

    #[test]
    fn few_jittered_stamps_prove_no_whole_number() {
        let times_s: Vec<f64> = (0..12)
            .map(|k| k as f64 / 100.0 + 1e-3 * noise(k))
            .collect();
        assert_eq!(pace(&times_s).device_rate_hz(), None);
        assert!(pace(&times_s).is_proven());
    }

    #[test]
    fn stamps_without_a_period_prove_none() {
        let mut times_s = vec![0.0];
        for k in 0..2000 {
            // Steps of 0.1 to 20 ms, all alike likely.
            times_s.push(times_s[k] + 10.05e-3 + 9.95e-3 * noise(k));
        }
        assert!(!pace(&times_s).is_proven());
        assert!(Pace::new(&[0.0], None).is_none());
        assert!(Pace::new(&[], None).is_none());
    }

    #[test]
    fn numbers_follow_a_drifting_clock_and_skip_dropped_frames() {
        // 100 Hz by a clock that is 150 millionths slow: over ten minutes nine samples.
        let nanos: Vec<u64> = (0..60_000_u64)
            .filter(|k| k % 1000 != 17)
            .map(|k| 1_700_000_000_000_000_000 + k * 10_001_500)
            .collect();
        let times_s: Vec<f64> = nanos.iter().map(|&t| seconds(nanos[0], t)).collect();
        let pace = pace(&times_s);
        assert_eq!(pace.device_rate_hz(), Some(100.0));
        let grid = Grid::new(&nanos, pace.period_s).unwrap();
        assert_eq!((grid.len(), grid.stamped()), (60_000, 59_940));
        assert_eq!(grid.start_nanos(), nanos[0]);
        let (sample, off) = grid.sample(nanos[0] + 59_999 * 10_001_500).unwrap();
        assert_eq!(sample, 59_999);
        assert!(off.abs() < 1e-3);
        assert_eq!(grid.sample(nanos[0] - 20_000_000), None);
        assert_eq!(grid.sample(nanos[0] + 601_000_000_000), None);
        let dropped = grid.sample(nanos[0] + 17 * 10_001_500);
        assert_eq!(dropped.map(|(sample, _)| sample), Some(17));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn any_stamps_are_numbered_in_order(
            mut nanos in prop::collection::vec(any::<u64>(), 2..60),
            period_s in 1e-6..1e3_f64,
        ) {
            nanos.sort_unstable();
            let times_s: Vec<f64> = nanos.iter().map(|&t| seconds(nanos[0], t)).collect();
            let _ = Pace::new(&times_s, None).map(|pace| pace.device_rate_hz());
            let grid = Grid::new(&nanos, period_s).unwrap();
            let mut last = 0;
            for &time in &nanos {
                if let Some((sample, _)) = grid.sample(time) {
                    prop_assert!(sample >= last && (sample as u64) < grid.len());
                    last = sample;
                }
            }
        }

        #[test]
        fn jitter_and_drops_move_no_number(
            rate_hz in 30.0..400.0_f64,
            jitter in 0.0..0.2_f64,
            dropped in prop::collection::vec(1_u64..400, 0..80),
        ) {
            let kept: Vec<u64> = (0..400).filter(|k| !dropped.contains(k)).collect();
            let nanos: Vec<u64> = kept
                .iter()
                .map(|&k| {
                    let off = jitter * noise(k as usize);
                    1_000_000_000 + ((k as f64 + off) / rate_hz * 1e9) as u64
                })
                .collect();
            let times_s: Vec<f64> = nanos.iter().map(|&t| seconds(nanos[0], t)).collect();
            let pace = Pace::new(&times_s, None).unwrap();
            prop_assert!((pace.rate_hz() / rate_hz - 1.0).abs() < 1e-3);
            let grid = Grid::new(&nanos, pace.period_s).unwrap();
            for (k, time) in kept.iter().zip(&nanos) {
                prop_assert_eq!(grid.sample(*time).map(|(k, _)| k as u64), Some(*k));
            }
        }
    }
}
