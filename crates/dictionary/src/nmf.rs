//! Non-negative matrix factorisation of training segments.

use inhand_model::{Demonstrated, Dictionary, DictionaryKind, Learning, Segments};
use nalgebra::{DMatrix, DVector};

use crate::block::{Basis, Block};
use crate::covariance::moments;
use crate::data::{at_every_sample, check_rank, checked_range, shifted_blocks};
use crate::error::LearnError;
use crate::factorise::{factorise, normalise};
use crate::settings::NmfSettings;
use crate::start;

/// Learns a dictionary of non-negative primitives from training segments.
///
/// Problem: with the segments as columns of `V` (rows x n, metres; 15 N rows, with the object 21 N),
/// minimise `1/2 |V - offset - W H|²` (Frobenius, m²) over `W >= 0` (rows x rank) and `H >= 0`
/// (rank x n). `offset` is each coordinate's training minimum minus
/// [`offset_margin_m`](NmfSettings::offset_margin_m), the same at every sample, so that the shifted
/// data are positive. The object's rotation counts as the length it moves a point at
/// [`ROTATION_LEVER_M`](inhand_model::ROTATION_LEVER_M), so that one objective measures all rows. The columns of `W` come out with unit length, the scale in `H`; the activations
/// described by mean and covariance are those of the last half step, for the very `W` returned.
///
/// Updates: HALS with several sweeps per product with the data (Cichocki and Phan, "Fast local
/// algorithms for large scale nonnegative matrix and tensor factorizations", IEICE Trans. 2009;
/// Gillis and Glineur, "Accelerated multiplicative updates and hierarchical ALS algorithms for
/// nonnegative matrix factorization", Neural Computation 2012), or multiplicative updates (Lee and
/// Seung 2001). The problem is not convex: a seed gives a local minimum, and the iteration limit
/// usually ends learning before that is reached, with
/// [`StopReason::IterationLimit`](inhand_model::StopReason::IterationLimit) in the result.
///
/// Cost of an iteration: about `4 * rows * n * rank` operations in matrix products, in parallel over
/// fixed chunks. On one machine the result has the same bits whatever the number of threads; between
/// CPUs with and without fused multiply-add the last digits differ.
///
/// The covariance of the activations is always shrunk (Ledoit and Wolf 2004), so that it is positive
/// definite and can be inverted by a planner.
///
/// # Errors
///
/// [`LearnError`] for no segments, rank 0, a rank above the number of segments or of numbers in a
/// segment, a number that is not finite, a fingertip's coordinate that never changes, a setting out
/// of range.
pub fn learn_nmf(
    segments: &Segments,
    demonstrated: Demonstrated,
    settings: &NmfSettings,
) -> Result<Dictionary, LearnError> {
    check_settings(settings)?;
    let range = checked_range(segments)?;
    let (layout, rank) = (segments.layout(), settings.rank);
    let rows = layout.rows();
    check_rank(rank, segments.len().min(rows), segments, "nmf")?;

    let lowest: Vec<f64> = (range.min_m.iter())
        .map(|min| min - settings.offset_margin_m)
        .collect();
    let offset = at_every_sample(layout, &lowest);
    let mut blocks = shifted_blocks(segments, &offset);
    let mut basis = Basis::new(
        start::primitives(settings.start, &blocks, rows, rank, settings.seed),
        rank,
    );
    let mut first = 0;
    for block in &mut blocks {
        block.start_activations(&basis, settings.seed, first);
        first += block.count();
    }
    let course = factorise(&mut blocks, &mut basis, settings);
    normalise(&mut blocks, &mut basis);

    let data: f64 = blocks.iter().map(Block::squared_norm).sum();
    let residual: f64 = blocks.iter().map(|block| block.residual(&basis)).sum();
    let activations: Vec<&[f64]> = blocks
        .iter()
        .map(|block| block.activations.as_slice())
        .collect();
    let moments = moments(&activations, rank);
    Ok(Dictionary {
        kind: DictionaryKind::Nmf,
        layout,
        offset_m: DVector::from_vec(offset),
        primitives: DMatrix::from_row_slice(rows, rank, &basis.rows_of),
        activation_mean_m: moments.mean,
        activation_covariance_m2: moments.covariance,
        covariance_shrinkage: moments.shrinkage,
        learning: Learning {
            segments: segments.len(),
            rms_m: (residual / (rows * segments.len()) as f64).sqrt(),
            relative_error: (residual / data).sqrt(),
            iterations: course.iterations,
            stop_reason: course.stop_reason,
            objective_history_m2: course.objective_history,
            seed: settings.seed,
            restarts: Vec::new(),
        },
        demonstrated,
        residual: None,
        choice: None,
    })
}

/// Checks the numbers of the settings that do not depend on data.
fn check_settings(settings: &NmfSettings) -> Result<(), LearnError> {
    let checks = [
        (
            "relative_change",
            "a number from 0 to below 1",
            settings.relative_change,
            (0.0..1.0).contains(&settings.relative_change),
        ),
        (
            "offset_margin_m",
            "a length of at least 0 m",
            settings.offset_margin_m,
            (0.0..f64::INFINITY).contains(&settings.offset_margin_m),
        ),
        (
            "stop_rms_m",
            "a length above 0 m",
            settings.stop_rms_m.unwrap_or_default(),
            settings
                .stop_rms_m
                .is_none_or(|rms| rms > 0.0 && rms.is_finite()),
        ),
    ];
    for (name, expected, found, fits) in checks {
        if !fits {
            return Err(LearnError::Setting {
                name,
                expected,
                found,
            });
        }
    }
    Ok(())
}
