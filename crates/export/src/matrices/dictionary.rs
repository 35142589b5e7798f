//! Dictionaries as named matrices.

use inhand_model::{Dictionary, DictionaryKind, Hull, Residual};
use nalgebra::{DMatrix, DVector};

use super::Variable;

/// Named matrices in the order in which they are written.
pub type Matrices = Vec<(String, Variable)>;

/// Every number of a dictionary as named matrices; vectors are columns, indices count from 0.
///
/// | name | size | what |
/// | --- | --- | --- |
/// | `primitives` | rows x rank | unit-length columns, no unit |
/// | `offset_m` | rows | metres |
/// | `activation_mean_m`, `activation_covariance_m2` | rank, rank x rank | metres, m² |
/// | `covariance_shrinkage` | 1 | 0 to 1 |
/// | `samples`, `rate_hz`, `object`, `non_negative` | 1 | shape of a segment; 1 for yes |
/// | `training_segments`, `iterations`, `rms_m`, `relative_error` | 1 | how learning went |
/// | `objective_history_m2` | sweeps + 1 | m² |
/// | `seed` | 2 | the lower and the upper 32 bits, since a float does not hold 64 |
/// | `restart_rms_m`, `restart_objective_m2`, `restart_matched_cosine` | starts | where several were made |
/// | `velocity_min_m_s`, `velocity_max_m_s` | 15 | finger, then axis |
/// | `hull_<finger>_vertices_m`, `_triangles`, `_normals`, `_offsets_m` | n x 3, n x 3, n x 3, n | where it has been |
/// | `residual_...` | | the learned deviation from the smooth curve, where there is one |
pub fn export_dictionary(dictionary: &Dictionary) -> Matrices {
    let learning = &dictionary.learning;
    let restarts =
        |number: fn(&inhand_model::Restart) -> f64| column(learning.restarts.iter().map(number));
    let yes = |holds: bool| Variable::from(if holds { 1.0 } else { 0.0 });
    let velocity = &dictionary.demonstrated.velocity;
    let halves = [learning.seed & u64::from(u32::MAX), learning.seed >> 32];
    let mut matrices: Matrices = [
        ("primitives", Variable::from(dictionary.primitives.clone())),
        ("offset_m", Variable::from(&dictionary.offset_m)),
        (
            "activation_mean_m",
            Variable::from(&dictionary.activation_mean_m),
        ),
        (
            "activation_covariance_m2",
            Variable::from(dictionary.activation_covariance_m2.clone()),
        ),
        (
            "covariance_shrinkage",
            Variable::from(dictionary.covariance_shrinkage),
        ),
        ("samples", Variable::from(dictionary.layout.samples as f64)),
        ("rate_hz", Variable::from(dictionary.layout.rate_hz)),
        ("object", yes(dictionary.layout.object)),
        ("non_negative", yes(dictionary.kind == DictionaryKind::Nmf)),
        (
            "training_segments",
            Variable::from(learning.segments as f64),
        ),
        ("iterations", Variable::from(learning.iterations as f64)),
        ("rms_m", Variable::from(learning.rms_m)),
        ("relative_error", Variable::from(learning.relative_error)),
        (
            "objective_history_m2",
            column(learning.objective_history_m2.iter().copied()),
        ),
        ("seed", column(halves.map(|half| half as f64))),
        ("restart_rms_m", restarts(|restart| restart.rms_m)),
        (
            "restart_objective_m2",
            restarts(|restart| restart.objective_m2),
        ),
        (
            "restart_matched_cosine",
            restarts(|restart| restart.matched_cosine),
        ),
        ("velocity_min_m_s", column(velocity.min_m_s)),
        ("velocity_max_m_s", column(velocity.max_m_s)),
    ]
    .map(|(name, variable)| (name.to_owned(), variable))
    .into();
    for (finger, hull) in dictionary.demonstrated.hulls.iter() {
        matrices.extend(hull_matrices(finger.name(), hull));
    }
    if let Some(residual) = &dictionary.residual {
        matrices.extend(residual_matrices(residual));
    }
    matrices
}

fn hull_matrices(finger: &str, hull: &Hull) -> [(String, Variable); 4] {
    let triangles: Vec<_> = (hull.triangles.iter())
        .map(|triangle| triangle.map(f64::from))
        .collect();
    [
        ("vertices_m", rows_of_three(&hull.vertices_m)),
        ("triangles", rows_of_three(&triangles)),
        ("normals", rows_of_three(&hull.normals)),
        ("offsets_m", column(hull.offsets_m.iter().copied())),
    ]
    .map(|(part, variable)| (format!("hull_{finger}_{part}"), variable))
}

fn residual_matrices(residual: &Residual) -> Matrices {
    let expectation = &residual.expectation;
    let (bandwidths, weights) = (expectation.bandwidths(), expectation.weights());
    let blocks = expectation.blocks().iter().map(|&count| count as f64);
    [
        ("primitives", Variable::from(residual.primitives.clone())),
        ("primitives_of_each_part", column(blocks)),
        (
            "covariance_m2",
            Variable::from(residual.covariance_m2.clone()),
        ),
        ("unexplained_m2", Variable::from(residual.unexplained_m2)),
        ("ends_mean", Variable::from(&residual.ends_mean)),
        (
            "ends_covariance",
            Variable::from(residual.ends_covariance.clone()),
        ),
        ("profile", Variable::from(expectation.profile().clone())),
        (
            "demonstration_ends",
            Variable::from(expectation.ends().clone()),
        ),
        (
            "demonstration_answers_m",
            Variable::from(expectation.answers_m().clone()),
        ),
        (
            "bandwidths_hand_finger",
            column([bandwidths.hand, bandwidths.finger]),
        ),
        (
            "weights_profile_hand_finger",
            column([weights.profile, weights.hand, weights.finger]),
        ),
    ]
    .map(|(name, variable)| (format!("residual_{name}"), variable))
    .into()
}

fn column(numbers: impl IntoIterator<Item = f64>) -> Variable {
    Variable::from(&DVector::from_vec(numbers.into_iter().collect()))
}

fn rows_of_three(rows: &[[f64; 3]]) -> Variable {
    Variable::from(DMatrix::from_row_slice(rows.len(), 3, rows.as_flattened()))
}
