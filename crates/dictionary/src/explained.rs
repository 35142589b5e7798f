//! Largest share of the segments' variance that a dictionary of each rank can explain.

use inhand_model::ExplainedVariance;

use crate::data::{Columns, survey};
use crate::error::LearnError;
use crate::pca::Centred;
use crate::singular::leading;

/// Size of the smaller side of the data up to which all variances are computed, exactly; beyond it only
/// those asked for, by subspace iteration.
const EXACT: usize = 1024;

/// Passes of the subspace iteration: variances of leading components settle far quicker than their
/// directions.
const POWERS: usize = 3;

/// Share of the segments' variance about their mean that the best dictionary of each rank explains: the
/// principal components (Eckart and Young), beside the share that a dictionary of `learned.0` primitives
/// explains which leaves a root mean square of `learned.1` metres.
///
/// Shares are of squared metres over all of a segment's numbers: 1 less the mean squared error over the
/// mean squared deviation from the mean segment. A dictionary worse than the mean has a share below 0.
/// Ranks beyond what the segments have are left out, and so is 0.
///
/// With up to 1024 segments or numbers in a segment variances are exact; with more of both they come from a
/// subspace iteration, which makes none too large, and the last of those asked for too small by about a
/// thousandth of itself.
///
/// # Errors
///
/// [`LearnError`] for no segments, a number that is missing or not finite, a fingertip's coordinate that never
/// changes.
pub fn explained_variance(
    columns: &dyn Columns,
    ranks: &[usize],
    learned: (usize, f64),
) -> Result<ExplainedVariance, LearnError> {
    explained(columns, ranks, learned, EXACT)
}

/// [`explained_variance`], exact up to this size.
fn explained(
    columns: &dyn Columns,
    ranks: &[usize],
    learned: (usize, f64),
    exact: usize,
) -> Result<ExplainedVariance, LearnError> {
    survey(columns, false)?;
    let (rows, segments) = (columns.layout().rows(), columns.count());
    let centred = Centred::new(columns)?;
    let total = centred.squared_norm()?;
    let largest = rows.min(segments.saturating_sub(1));
    let ranks: Vec<usize> = (ranks.iter().copied())
        .filter(|rank| (1..=largest).contains(rank))
        .collect();
    let wanted = ranks.iter().copied().max().unwrap_or(0);
    let mut squares = if rows.min(segments) <= exact {
        centred.eigenvalues()?
    } else {
        let pass = |see: &mut dyn FnMut(&[f64])| centred.each_block(see);
        leading(rows, segments, wanted, POWERS, 0, pass)?.1
    };
    squares.sort_by(|a, b| b.total_cmp(a));
    let share = |rank: usize| {
        let explained: f64 = squares.iter().take(rank).sum();
        (explained / total).min(1.0)
    };
    let (rank, rms_m) = learned;
    let left = rms_m * rms_m * (rows * segments) as f64;
    Ok(ExplainedVariance {
        principal: ranks.iter().map(|&rank| (rank, share(rank))).collect(),
        learned: (rank, 1.0 - left / total),
        segments,
    })
}

#[cfg(test)]
mod tests {
    use inhand_model::{EndConditions, SegmentLayout, SegmentOrigin, Segments};
    use nalgebra::DMatrix;

    use super::*;

    /// Segments whose variances fall slowly, as those of motion with noise do.
    fn segments(samples: usize, count: usize) -> Segments {
        let layout = SegmentLayout {
            samples,
            rate_hz: 100.0,
            object: false,
        };
        let columns_m = DMatrix::from_fn(layout.rows(), count, |row, column| {
            let (r, c) = (row as f64 + 1.0, column as f64 + 1.0);
            let waves = (1..40).map(|k| {
                let k = f64::from(k);
                (0.37 * k * r).sin() * (0.71 * k * k * c + k).sin() / k.powi(2)
            });
            0.02 * waves.sum::<f64>() + 1e-5 * (r * r * 1.7 + c * c * 2.3).sin()
        });
        let zero = [0.0; 15];
        let ends = EndConditions {
            first_m: zero,
            last_m: zero,
            first_velocity_m_s: zero,
            last_velocity_m_s: zero,
            object: None,
        };
        let origins = (0..count).map(|start| SegmentOrigin { take: 0, start });
        Segments::new(layout, columns_m, origins.collect(), vec![ends; count], 0)
            .expect("an origin and ends for each column")
    }

    #[test]
    fn subspace_iteration_is_close_and_never_above() {
        let ranks = [1, 2, 3, 5, 10, 20];
        for (samples, count) in [(5, 90), (6, 50)] {
            let segments = segments(samples, count);
            let of = |exact| {
                let explained = explained(&segments, &ranks, (1, 0.0), exact);
                explained.expect("segments teach").principal
            };
            for ((rank, found), (_, expected)) in of(0).into_iter().zip(of(usize::MAX)) {
                let missed = expected - found;
                assert!((-1e-12..1e-6).contains(&missed), "{rank}: {missed:e}");
            }
        }
    }
}
