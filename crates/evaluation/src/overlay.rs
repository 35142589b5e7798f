//! Motions of several takes or methods on one time line, and how far apart they are.

use inhand_model::{Clock, Frame, PerFinger, PointTrack, Position};
use inhand_statistics::quantiles;

/// Times that differ by less than this are the same, seconds: clocks are rounded to nanoseconds, and
/// cuts of takes to a microsecond.
const SAME_TIME_S: f64 = 1e-6;

/// By how much each time line has to be moved, nanoseconds, so that the instants `anchors`, one of
/// each, fall together. Those of the first stay where they are, unless one of the `starts` would come to
/// lie before 1970: then all move on together.
///
/// ```
/// use inhand_evaluation::overlay::offsets_nanos;
///
/// assert_eq!(offsets_nanos(&[100, 700], &[120, 700]), [0, -580]);
/// assert_eq!(offsets_nanos(&[0, 0], &[20, 50]), [30, 0]);
/// ```
pub fn offsets_nanos(starts: &[u64], anchors: &[u64]) -> Vec<i128> {
    let first = anchors.first().copied().unwrap_or_default();
    let offsets: Vec<i128> = (anchors.iter())
        .map(|&anchor| i128::from(first) - i128::from(anchor))
        .collect();
    let moved = starts.iter().zip(&offsets);
    let earliest = moved.map(|(&start, offset)| i128::from(start) + offset);
    let lift = earliest.min().map_or(0, |earliest| (-earliest).max(0));
    offsets.into_iter().map(|offset| offset + lift).collect()
}

/// The clock on a time line that was moved; `None` where no time is left for it.
pub fn moved(clock: Clock, offset_nanos: i128) -> Option<Clock> {
    let start = i128::from(clock.start_unix_nanos()) + offset_nanos;
    Clock::new(
        u64::try_from(start).ok()?,
        clock.start_time(),
        clock.rate_hz(),
    )
    .ok()
}

/// Fingertips on a clock.
#[derive(Clone, Copy, Debug)]
pub struct Tips<'a, F: Frame> {
    /// When samples are.
    pub clock: Clock,
    /// Where fingertips are at each.
    pub tracks: &'a PerFinger<PointTrack<F>>,
}

/// Position of a track at any instant: on the line between two samples that are both there, so that
/// nothing is said of gaps.
pub fn position_at<F: Frame>(
    track: &PointTrack<F>,
    clock: Clock,
    unix_nanos: u64,
) -> Option<Position<F>> {
    let since_nanos = i128::from(unix_nanos) - i128::from(clock.start_unix_nanos());
    let at = since_nanos as f64 * 1e-9 * clock.rate_hz();
    let nearest = at.round();
    if (at - nearest).abs() < SAME_TIME_S * clock.rate_hz() {
        return sample(track, nearest);
    }
    let (before, share) = (at.floor(), at - at.floor());
    let (a, b) = (sample(track, before)?, sample(track, before + 1.0)?);
    Some(Position::from_coords(
        a.coords_m().lerp(&b.coords_m(), share),
    ))
}

fn sample<F: Frame>(track: &PointTrack<F>, k: f64) -> Option<Position<F>> {
    if k < 0.0 || k >= track.len() as f64 {
        return None;
    }
    track.get(k as usize)
}

/// Distance of each fingertip from that of the first motion, metres, at the instants of the first; NaN
/// where one of them is missing.
pub fn distances_m<F: Frame>(first: Tips<'_, F>, other: Tips<'_, F>) -> Vec<PerFinger<f64>> {
    let samples = (first.tracks.iter())
        .map(|(_, track)| track.len())
        .max()
        .unwrap_or_default();
    (0..samples)
        .map(|k| {
            let unix_nanos = first.clock.unix_nanos(k);
            PerFinger::from_fn(|finger| {
                let a = sample(&first.tracks[finger], k as f64);
                let b = position_at(&other.tracks[finger], other.clock, unix_nanos);
                a.zip(b).map_or(f64::NAN, |(a, b)| a.distance_m(b))
            })
        })
        .collect()
}

/// Distance of one fingertip between two motions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Apart {
    /// Instants at which both are there.
    pub n: usize,
    /// Median distance, metres; `None` without such an instant.
    pub median_m: Option<f64>,
    /// Distance that 95 % of instants stay below, metres.
    pub p95_m: Option<f64>,
}

/// Sums up what [`distances_m`] gave.
pub fn apart(distances_m: &[PerFinger<f64>]) -> PerFinger<Apart> {
    PerFinger::from_fn(|finger| {
        let mut sorted: Vec<f64> = (distances_m.iter())
            .map(|distances| distances[finger])
            .filter(|distance| !distance.is_nan())
            .collect();
        sorted.sort_by(f64::total_cmp);
        Apart {
            n: sorted.len(),
            median_m: quantiles::quantile(&sorted, 0.5),
            p95_m: quantiles::quantile(&sorted, 0.95),
        }
    })
}

#[cfg(test)]
mod tests {
    use inhand_model::{Finger, Hand, StartTime};

    use super::*;

    fn clock(start: u64, rate_hz: f64) -> Clock {
        Clock::new(start, StartTime::Unknown, rate_hz).unwrap()
    }

    /// Fingertips that move along x at so many metres a second, from x = 0 at the time 0.
    fn line(clock: Clock, samples: usize, m_s: f64) -> PerFinger<PointTrack<Hand>> {
        let track = PointTrack::from_measured((0..samples).map(|k| {
            let t_s = clock.unix_nanos(k) as f64 * 1e-9;
            Some(Position::new(m_s * t_s, 0.01, 0.0))
        }));
        PerFinger::from_fn(|_| track.clone())
    }

    #[test]
    fn lines_are_as_far_apart_as_their_speeds_whatever_the_rates() {
        let (a, b) = (clock(0, 100.0), clock(35_000_000, 60.0));
        let (first, other) = (line(a, 300, 0.1), line(b, 120, 0.3));
        let distances = distances_m(
            Tips {
                clock: a,
                tracks: &first,
            },
            Tips {
                clock: b,
                tracks: &other,
            },
        );
        assert_eq!(distances.len(), 300);
        let last_s = b.unix_nanos(119) as f64 * 1e-9;
        for (k, of_sample) in distances.iter().enumerate() {
            let t_s = k as f64 / 100.0;
            for (_, &distance) in of_sample.iter() {
                if t_s < 0.035 || t_s > last_s {
                    assert!(distance.is_nan(), "{k}: {distance}");
                } else {
                    assert!((distance - 0.2 * t_s).abs() < 1e-9, "{k}: {distance}");
                }
            }
        }
    }

    #[test]
    fn a_gap_is_not_bridged_and_an_end_of_one_counts() {
        let clock_hz = clock(0, 10.0);
        let at = |x| Some(Position::<Hand>::new(x, 0.0, 0.0));
        let track = PointTrack::from_measured([at(0.0), at(1.0), None, at(3.0)]);
        let x = |t_s: f64| {
            let nanos = (t_s * 1e9).round() as u64;
            position_at(&track, clock_hz, nanos).map(|p| p.to_array()[0])
        };
        assert_eq!(x(0.1), Some(1.0));
        assert!((x(0.05).unwrap() - 0.5).abs() < 1e-12);
        for t_s in [0.15, 0.2, 0.25, 0.31, 5.0] {
            assert_eq!(x(t_s), None, "{t_s}");
        }
        assert_eq!(x(0.3), Some(3.0));
        assert_eq!(
            position_at(&track, clock(900, 10.0), 0),
            Some(track.get(0).unwrap())
        );
        assert_eq!(position_at(&track, clock(2_000_000, 10.0), 0), None);
    }

    #[test]
    fn anchors_fall_together_and_nothing_starts_before_time() {
        let starts = [5_000, 900, 70_000];
        let anchors = [6_000, 8_000, 70_500];
        let offsets = offsets_nanos(&starts, &anchors);
        let moved_to: Vec<i128> = (anchors.iter().zip(&offsets))
            .map(|(&anchor, offset)| i128::from(anchor) + offset)
            .collect();
        assert!(moved_to.iter().all(|&at| at == moved_to[0]));
        // The second would begin 1100 ns before 1970.
        assert_eq!(offsets, [1_100, -900, -63_400]);
        assert_eq!(moved(clock(900, 50.0), offsets[1]), Some(clock(0, 50.0)));
        assert_eq!(moved(clock(900, 50.0), -901), None);
    }

    #[test]
    fn sums_are_of_what_is_there() {
        let distances: Vec<PerFinger<f64>> = (0..=100)
            .map(|n| {
                PerFinger::from_fn(|finger| match finger {
                    Finger::Thumb => f64::from(n) * 1e-3,
                    Finger::Index if n < 3 => 0.5,
                    _ => f64::NAN,
                })
            })
            .collect();
        let apart = apart(&distances);
        assert_eq!(apart[Finger::Thumb].n, 101);
        assert!((apart[Finger::Thumb].median_m.unwrap() - 0.050).abs() < 1e-12);
        assert!((apart[Finger::Thumb].p95_m.unwrap() - 0.095).abs() < 1e-12);
        assert_eq!(
            (apart[Finger::Index].n, apart[Finger::Index].p95_m),
            (3, Some(0.5))
        );
        assert_eq!(
            (apart[Finger::Ring].n, apart[Finger::Ring].median_m),
            (0, None)
        );
    }
}
