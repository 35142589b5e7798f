//! Coverage of a method's prediction regions by the recorded motion.

use inhand_model::{Calibration, CorridorCoverage, Finger, HandAndFingers, PerFinger};

use crate::known::Counts;
use crate::recorded::Recorded;

/// Coverage of each width over all instants at which the distance is known. `mahalanobis` has one entry
/// for each segment of the recording, `None` where there is no region. On the edge is inside.
pub(crate) fn coverage(
    mahalanobis: &[Option<&[PerFinger<f64>]>],
    widths: &[Calibration],
    recorded: &Recorded,
    counts: Counts,
) -> Vec<CorridorCoverage> {
    // Distances of each finger, the same for all widths.
    let mut n_filled = 0;
    let known: PerFinger<Vec<f64>> = PerFinger::from_fn(|finger| {
        let mut known = Vec::new();
        for (segment, instants) in mahalanobis.iter().enumerate() {
            for (t, distances) in instants.unwrap_or_default().iter().enumerate() {
                if !distances[finger].is_nan() {
                    known.push(distances[finger]);
                    let k = segment * counts.samples + t;
                    n_filled += usize::from(recorded.rows.filled[k][finger]);
                }
            }
        }
        known
    });
    let n: usize = known.iter().map(|(_, known)| known.len()).sum();
    let n_left_out = (Finger::ALL.into_iter())
        .map(|finger| counts.left_out(known[finger].len()))
        .sum();
    (widths.iter())
        .map(|width| {
            let inside = (known.each_ref())
                .map(|known| known.iter().filter(|&&d| d <= width.mahalanobis).count());
            CorridorCoverage {
                share_stated: width.share,
                mahalanobis: width.mahalanobis,
                n,
                n_filled,
                n_left_out,
                share_inside: HandAndFingers {
                    all: inside.as_array().iter().sum::<usize>() as f64 / n as f64,
                    by_finger: PerFinger::from_fn(|finger| {
                        inside[finger] as f64 / known[finger].len() as f64
                    }),
                },
            }
        })
        .collect()
}
