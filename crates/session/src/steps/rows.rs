//! Every judged instant of an evaluation, for tables, figures and intervals.

use inhand_evaluation::Rows;
use inhand_model::{EvaluationRows, Finger, MethodRows};

use super::{Comparison, Generated};

/// The rows of all methods beside what the recording itself does. `rows` are those that
/// [`evaluate`](super::evaluate) gave for `generated`, in its order.
pub fn evaluation_rows(
    comparison: &Comparison<'_>,
    generated: &[Generated],
    rows: Vec<Rows>,
) -> EvaluationRows {
    let (data, recorded) = (&comparison.data, &comparison.recorded);
    let takes = data.motions.iter().map(|motion| motion.name.clone());
    let nearest_m = |pairs: &[(f64, Finger, Finger)]| -> Vec<f64> {
        pairs.iter().map(|(nearest_m, ..)| *nearest_m).collect()
    };
    let methods = (generated.iter().zip(rows)).map(|(generated, rows)| MethodRows {
        name: generated.method.name().to_owned(),
        error_m: rows.error_m,
        distance_m: rows.distance_m,
        hull_distance_m: rows.hull_distance_m,
        nearest_pair_m: nearest_m(&rows.nearest_pair),
        object_position_error_m: rows.object.as_ref().map(|errors| errors.position_m.clone()),
        object_angle_error_rad: rows.object.map(|errors| errors.angle_rad),
        mahalanobis: rows.mahalanobis,
    });
    EvaluationRows {
        layout: data.segments.layout(),
        takes: takes.collect(),
        segments: data.segments.origins().to_vec(),
        filled: recorded.filled.clone(),
        object_filled: recorded.object_filled.clone(),
        recorded_distance_m: recorded.distance_m.clone(),
        recorded_hull_distance_m: recorded.hull_distance_m.clone(),
        recorded_nearest_pair_m: nearest_m(&recorded.nearest_pair),
        methods: methods.collect(),
    }
}
