//! The part of a deviation that all coordinates share.
//!
//! Least squares for the profile: the deviation of a fingertip coordinate `c` at sample `t` is
//! `p_1(t) (last - first)_c + T p_2(t) v_first,c + T p_3(t) v_last,c`, with the same three functions
//! for every finger and axis. The object's position and rotation have one function each, of the
//! displacement and of the rotation.

use inhand_model::{OBJECT_COORDINATES, SEGMENT_COORDINATES, SegmentLayout, ends_len};
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::primitives::Demonstrations;

/// Ridge relative to the mean of the inputs' squares: enough to make the answer unique.
const RIDGE: f64 = 1e-3;
/// Smallest ridge for each segment, m²: inputs of a micrometre are noise, and what follows from
/// them must not grow beyond bounds.
const SMALLEST_RIDGE_M2: f64 = 1e-12;

/// One input of a coordinate, as a combination of boundary conditions: (index, factor).
type Input = Vec<(usize, f64)>;

/// Coordinates that share their profiles.
struct Shared {
    /// Row of a column at which they stand at the first sample.
    start: usize,
    /// Rows from one sample to the next.
    stride: usize,
    /// For each coordinate (side by side in the rows) its inputs.
    inputs: Vec<Vec<Input>>,
}

impl Shared {
    /// Inputs of each coordinate (k).
    fn size(&self) -> usize {
        self.inputs[0].len()
    }
}

/// Sums of the least squares by segment, so that those of any choice of segments can be added up.
pub(super) struct Sums {
    groups: Vec<(Shared, Vec<SegmentSums>)>,
    samples: usize,
}

/// Sums of one segment over its coordinates.
struct SegmentSums {
    /// Products of inputs (k x k), m².
    squares: DMatrix<f64>,
    /// Products of inputs and deviation over time (k x N), m².
    products: DMatrix<f64>,
}

impl Sums {
    pub(super) fn of(demonstrations: &Demonstrations<'_>) -> Self {
        let samples = demonstrations.layout.samples;
        let groups = groups(demonstrations.layout)
            .into_iter()
            .map(|shared| {
                let sums = (0..demonstrations.ends.ncols())
                    .into_par_iter()
                    .map(|segment| segment_sums(demonstrations, &shared, segment))
                    .collect();
                (shared, sums)
            })
            .collect();
        Self { groups, samples }
    }

    /// The profile as activations: `L` (r x d), fitted to some of the segments.
    pub(super) fn fit(&self, demonstrations: &Demonstrations<'_>, used: &[usize]) -> DMatrix<f64> {
        let layout = demonstrations.layout;
        let rank = demonstrations.primitives.rank();
        let mut profile = DMatrix::zeros(rank, ends_len(layout));
        let mut coordinate = 0;
        for (shared, sums) in &self.groups {
            let profiles = profiles(sums, shared.size(), self.samples, used);
            for inputs in &shared.inputs {
                let activations =
                    (demonstrations.primitives).coordinate_activations(coordinate, &profiles);
                for (activation, input) in activations.column_iter().zip(inputs) {
                    for &(index, factor) in input {
                        profile.column_mut(index).axpy(factor, &activation, 1.0);
                    }
                }
                coordinate += 1;
            }
        }
        profile
    }
}

/// The groups in the order of the coordinates: fingertips, the object's position, its rotation.
fn groups(layout: SegmentLayout) -> Vec<Shared> {
    let duration_s = layout.duration_s();
    let part = |part: usize, c: usize| part * SEGMENT_COORDINATES + c;
    let finger = |c: usize| {
        let displacement = vec![(part(1, c), 1.0), (part(0, c), -1.0)];
        let velocity = |at: usize| vec![(part(at, c), duration_s)];
        vec![displacement, velocity(2), velocity(3)]
    };
    let mut groups = vec![Shared {
        start: 0,
        stride: SEGMENT_COORDINATES,
        inputs: (0..SEGMENT_COORDINATES).map(finger).collect(),
    }];
    if layout.object {
        let object = part(4, 0);
        let moved = |a: usize| vec![vec![(object + 3 + a, 1.0), (object + a, -1.0)]];
        let turned = |a: usize| vec![vec![(object + 6 + a, 1.0)]];
        for (first, inputs) in [
            (0, (0..3).map(moved).collect()),
            (3, (0..3).map(turned).collect()),
        ] {
            groups.push(Shared {
                start: layout.object_row(0, first),
                stride: OBJECT_COORDINATES,
                inputs,
            });
        }
    }
    groups
}

fn segment_sums(
    demonstrations: &Demonstrations<'_>,
    shared: &Shared,
    segment: usize,
) -> SegmentSums {
    let ends = demonstrations.ends.column(segment);
    let value = |input: &Input| {
        (input.iter())
            .map(|&(i, factor)| factor * ends[i])
            .sum::<f64>()
    };
    let (size, coordinates) = (shared.size(), shared.inputs.len());
    let inputs = DMatrix::from_fn(coordinates, size, |c, k| value(&shared.inputs[c][k]));
    let deviation = demonstrations.deviations_m.column(segment);
    let over_time = deviation.as_slice()[shared.start..].chunks(shared.stride);
    let samples = demonstrations.layout.samples;
    let mut products = DMatrix::zeros(size, samples);
    for (mut products, deviations) in products.column_iter_mut().zip(over_time) {
        for (product, inputs) in products.iter_mut().zip(inputs.column_iter()) {
            *product = (inputs.iter().zip(deviations)).map(|(i, d)| i * d).sum();
        }
    }
    SegmentSums {
        squares: inputs.tr_mul(&inputs),
        products,
    }
}

/// The profiles over time (N x k).
fn profiles(sums: &[SegmentSums], size: usize, samples: usize, used: &[usize]) -> DMatrix<f64> {
    let mut squares = DMatrix::zeros(size, size);
    let mut products = DMatrix::zeros(size, samples);
    for &segment in used {
        squares += &sums[segment].squares;
        products += &sums[segment].products;
    }
    let ridge = (RIDGE * squares.trace() / size as f64).max(SMALLEST_RIDGE_M2 * used.len() as f64);
    for k in 0..size {
        squares[(k, k)] += ridge;
    }
    match squares.cholesky() {
        Some(factor) => factor.solve(&products).transpose(),
        // Without a segment there is no ridge either.
        None => DMatrix::zeros(samples, size),
    }
}
