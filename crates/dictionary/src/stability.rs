//! Similarity of two sets of primitives.

use nalgebra::DMatrix;

/// Mean cosine between the primitives of two dictionaries (columns, rows x rank), matched one to one
/// so that the mean is the largest possible. 1 for the same primitives in any order and of any
/// length; where one side has more of them, those left over are not counted. A primitive of zeros has
/// cosine 0 with any other. NaN where a side has no primitives, the rows differ or a number is
/// not finite.
///
/// Cost: `rows * rank²` for the cosines and at most about `rank³` for the assignment.
pub(crate) fn matched_cosine(a: &DMatrix<f64>, b: &DMatrix<f64>) -> f64 {
    if a.nrows() != b.nrows() || a.ncols() == 0 || b.ncols() == 0 {
        return f64::NAN;
    }
    let (few, many) = if a.ncols() <= b.ncols() {
        (a, b)
    } else {
        (b, a)
    };
    let (few, many) = (of_unit_length(few), of_unit_length(many));
    let cosines = few.transpose() * many;
    if cosines.iter().any(|v| !v.is_finite()) {
        return f64::NAN;
    }
    let total: f64 = assignment(&-&cosines)
        .into_iter()
        .enumerate()
        .map(|(i, j)| cosines[(i, j)])
        .sum();
    // Rounding of the lengths must not make primitives more than equal.
    (total / cosines.nrows() as f64).clamp(-1.0, 1.0)
}

/// The columns scaled to unit length; zeros stay.
fn of_unit_length(columns: &DMatrix<f64>) -> DMatrix<f64> {
    let mut scaled = columns.clone();
    for mut column in scaled.column_iter_mut() {
        // Scaled by the largest number first: squares of tiny ones would vanish.
        let largest = column.amax();
        if largest > 0.0 {
            column /= largest;
            column /= column.norm();
        }
    }
    scaled
}

/// For each row of `costs` (m x n with m <= n) a column of its own, so that the sum of the costs is
/// smallest (Kuhn 1955; by shortest augmenting paths with potentials, Jonker and Volgenant 1987).
///
/// Written here because it is short, and the crates that have it want integers or matrices of yet
/// another library.
fn assignment(costs: &DMatrix<f64>) -> Vec<usize> {
    let (rows, columns) = costs.shape();
    // Potentials keep all reduced costs non-negative, and zero along what is assigned. The last
    // column is a stand-in: the row to be assigned holds it while its path is sought.
    let (mut of_row, mut of_column) = (vec![0.0; rows], vec![0.0; columns + 1]);
    let mut row_of: Vec<Option<usize>> = vec![None; columns + 1];
    for start in 0..rows {
        let mut reached = columns;
        row_of[reached] = Some(start);
        let mut distance = vec![f64::INFINITY; columns];
        let mut before = vec![columns; columns];
        let mut done = vec![false; columns + 1];
        // Dijkstra's search from the row to the nearest free column.
        while let Some(row) = row_of[reached] {
            done[reached] = true;
            let (mut nearest, mut step) = (reached, f64::INFINITY);
            for column in 0..columns {
                if done[column] {
                    continue;
                }
                let reduced = costs[(row, column)] - of_row[row] - of_column[column];
                if reduced < distance[column] {
                    distance[column] = reduced;
                    before[column] = reached;
                }
                if distance[column] < step {
                    (nearest, step) = (column, distance[column]);
                }
            }
            if nearest == reached {
                // Costs that are not finite: no column can be told from another.
                break;
            }
            for column in 0..=columns {
                if done[column] {
                    if let Some(row) = row_of[column] {
                        of_row[row] += step;
                    }
                    of_column[column] -= step;
                } else {
                    distance[column] -= step;
                }
            }
            reached = nearest;
        }
        // Along the path, each column takes the row of the one before.
        while reached != columns {
            row_of[reached] = row_of[before[reached]];
            reached = before[reached];
        }
    }
    let mut assigned = vec![0; rows];
    for (column, row) in row_of.iter().take(columns).enumerate() {
        if let Some(row) = row {
            assigned[*row] = column;
        }
    }
    assigned
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    use super::{assignment, matched_cosine};

    fn matrix(rows: usize, columns: usize, seed: f64) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |r, c| {
            ((3 * r + 7 * c) as f64 * seed).sin().abs()
        })
    }

    /// Smallest sum of costs over all ways to give each row from `row` on a column of its own.
    fn smallest(costs: &DMatrix<f64>, row: usize, taken: &mut Vec<usize>) -> f64 {
        if row == costs.nrows() {
            return 0.0;
        }
        let mut best = f64::INFINITY;
        for column in 0..costs.ncols() {
            if !taken.contains(&column) {
                taken.push(column);
                best = best.min(costs[(row, column)] + smallest(costs, row + 1, taken));
                taken.pop();
            }
        }
        best
    }

    #[test]
    fn order_and_length_do_not_matter() {
        let a = matrix(30, 9, 0.37);
        let turned = DMatrix::from_fn(30, 9, |r, c| (c + 1) as f64 * a[(r, (c * 4 + 2) % 9)]);
        assert!((matched_cosine(&a, &turned) - 1.0).abs() < 1e-14);
        assert!((matched_cosine(&a, &(&a * 1e-200)) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn known_angles() {
        let a = DMatrix::from_columns(&[
            DVector::from_vec(vec![1.0, 0.0, 0.0]),
            DVector::from_vec(vec![0.0, 1.0, 0.0]),
        ]);
        // 60 degrees from the second, orthogonal to the first; and orthogonal to both.
        let b = DMatrix::from_columns(&[
            DVector::from_vec(vec![0.0, 0.5, 0.75_f64.sqrt()]),
            DVector::from_vec(vec![0.0, 0.0, 4.0]),
        ]);
        assert!((matched_cosine(&a, &b) - 0.25).abs() < 1e-15);
        // Those left over are not counted.
        let one = a.columns(1, 1).clone_owned();
        assert!((matched_cosine(&one, &b) - 0.5).abs() < 1e-15);
        assert_eq!(matched_cosine(&one, &b), matched_cosine(&b, &one));
    }

    #[test]
    fn what_cannot_be_compared_is_said() {
        let a = matrix(4, 2, 0.3);
        assert!(matched_cosine(&a, &matrix(5, 2, 0.3)).is_nan());
        assert!(matched_cosine(&a, &DMatrix::zeros(4, 0)).is_nan());
        assert!(matched_cosine(&a, &(&a * f64::NAN)).is_nan());
        assert_eq!(matched_cosine(&a, &DMatrix::zeros(4, 2)), 0.0);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn no_assignment_is_better(
            rows in 1_usize..7,
            more in 0_usize..2,
            numbers in prop::collection::vec(
                prop_oneof![3 => -1.0..1.0, 1 => Just(0.0), 1 => Just(1.0)], 42,
            ),
        ) {
            let columns = (rows + more).min(6).max(rows);
            let costs = DMatrix::from_column_slice(rows, columns, &numbers[..rows * columns]);
            let mut assigned = assignment(&costs);
            let found: f64 = assigned.iter().enumerate().map(|(i, j)| costs[(i, *j)]).sum();
            prop_assert!((found - smallest(&costs, 0, &mut Vec::new())).abs() < 1e-12);
            assigned.sort_unstable();
            assigned.dedup();
            prop_assert_eq!(assigned.len(), rows);
        }

        #[test]
        fn alike_is_between_none_and_all(a in 0.01..3.0, b in 0.01..3.0, rank in 1_usize..9) {
            let (a, b) = (matrix(12, rank, a), matrix(12, rank, b));
            let found = matched_cosine(&a, &b);
            prop_assert!((0.0..=1.0).contains(&found));
            prop_assert!((found - matched_cosine(&b, &a)).abs() < 1e-12);
        }
    }
}
