//! Numbers that are missing from a block of columns.

use crate::product::dot;
use crate::real::Real;

/// Places of missing numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Missing {
    /// Column and row of each missing number, in the order of the data.
    places: Vec<(usize, usize)>,
}

impl Missing {
    /// Finds what is missing (NaN) in columns of samples of `width` numbers, the same coordinate at
    /// each, and puts a first guess there: on the line in time between its neighbours, the nearest
    /// one where there is none on one side, zero where there is none at all.
    ///
    /// `parts` are the intervals of a column's rows with the width of their samples.
    pub(crate) fn guess(
        data: &mut [f64],
        rows: usize,
        parts: &[(std::ops::Range<usize>, usize)],
    ) -> Self {
        let mut places = Vec::new();
        for (i, column) in data.chunks_exact_mut(rows.max(1)).enumerate() {
            let missing: Vec<usize> = (0..rows).filter(|&row| column[row].is_nan()).collect();
            if missing.is_empty() {
                continue;
            }
            for (range, width) in parts {
                for coordinate in 0..*width {
                    let along = (range.start + coordinate..range.end).step_by(*width);
                    interpolate(column, &along.collect::<Vec<_>>());
                }
            }
            places.extend(missing.into_iter().map(|row| (i, row)));
        }
        Self { places }
    }

    /// Number of missing numbers.
    #[cfg(test)]
    pub(crate) fn len(&self) -> usize {
        self.places.len()
    }

    /// Sum of the squares of what the data holds in their place.
    pub(crate) fn squared_norm<T: Real>(&self, data: &[T], rows: usize) -> f64 {
        (self.places.iter())
            .map(|&(column, row)| data[column * rows + row].to_f64().powi(2))
            .sum()
    }

    /// Puts `primitives * activations` in their place (primitives as rows, `rank` x rows); returns
    /// the sum of the squares of the changes.
    pub(crate) fn expect<T: Real>(
        &self,
        data: &mut [T],
        rows: usize,
        primitives: &[T],
        activations: &[T],
    ) -> f64 {
        let rank = primitives.len() / rows.max(1);
        let mut squares = 0.0;
        for &(column, row) in &self.places {
            let expected = dot(
                &primitives[row * rank..][..rank],
                &activations[column * rank..][..rank],
            );
            let place = &mut data[column * rows + row];
            let expected = T::of(expected);
            squares += (place.to_f64() - expected.to_f64()).powi(2);
            *place = expected;
        }
        squares
    }
}

/// Fills what is NaN at the given rows of a column, in their order.
fn interpolate(column: &mut [f64], along: &[usize]) {
    let known: Vec<usize> = (0..along.len())
        .filter(|&t| !column[along[t]].is_nan())
        .collect();
    let mut next = 0;
    for t in 0..along.len() {
        if known.get(next) == Some(&t) {
            next += 1;
            continue;
        }
        let before = next.checked_sub(1).map(|i| known[i]);
        let after = known.get(next).copied();
        column[along[t]] = match (before, after) {
            (Some(a), Some(b)) => {
                let share = (t - a) as f64 / (b - a) as f64;
                column[along[a]] * (1.0 - share) + column[along[b]] * share
            }
            (Some(a), None) => column[along[a]],
            (None, Some(b)) => column[along[b]],
            (None, None) => 0.0,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::Missing;

    #[test]
    fn guesses_lie_between_neighbours_in_time() {
        // Four samples of two coordinates, and two of one.
        let nan = f64::NAN;
        let mut column = [nan, 1.0, 4.0, nan, nan, nan, 10.0, 7.0, nan, nan];
        let missing = Missing::guess(&mut column, 10, &[(0..8, 2), (8..10, 1)]);
        let expected = [4.0, 1.0, 4.0, 3.0, 7.0, 5.0, 10.0, 7.0, 0.0, 0.0];
        assert!(
            column
                .iter()
                .zip(expected)
                .all(|(a, b)| (a - b).abs() < 1e-14)
        );
        assert_eq!(missing.len(), 6);
        assert!((missing.squared_norm(&column, 10) - (16.0 + 9.0 + 49.0 + 25.0)).abs() < 1e-12);
    }

    #[test]
    fn what_is_expected_replaces_guesses() {
        let mut data = [1.0, f64::NAN, 3.0, 4.0];
        let missing = Missing::guess(&mut data, 2, &[(0..2, 1)]);
        assert_eq!(data, [1.0, 1.0, 3.0, 4.0]);
        // Two primitives of two rows, two columns.
        let changed = missing.expect(&mut data, 2, &[1.0, 0.0, 2.0, 1.0], &[0.5, 3.0, 9.0, 9.0]);
        assert_eq!(data, [1.0, 4.0, 3.0, 4.0]);
        assert_eq!(changed, 9.0);
    }
}
