//! The part of a deviation that all coordinates share.
//!
//! Least squares for the profile: the deviation of a fingertip coordinate `c` at sample `t` is
//! `p_1(t) (last - first)_c + T p_2(t) v_first,c + T p_3(t) v_last,c`, with the same three functions
//! for every finger and axis. The object's position and rotation have one function each, of the
//! displacement and of the rotation.

use inhand_model::{OBJECT_COORDINATES, SEGMENT_COORDINATES, ends_len};
use nalgebra::{DMatrix, DVector};

use super::validation::Demonstrations;

/// Ridge relative to the mean of the inputs' squares: enough to make the answer unique.
const RIDGE: f64 = 1e-3;

/// One input of a coordinate, as a combination of end conditions: (index, factor).
type Input = Vec<(usize, f64)>;

/// Coordinates that share their profiles, each with its inputs.
struct Shared {
    coordinates: Vec<(usize, Vec<Input>)>,
    inputs: usize,
}

/// The profile as activations: `L` (r x d), fitted to some of the demonstrations.
pub(super) fn fit(demonstrations: &Demonstrations<'_>, used: &[usize]) -> DMatrix<f64> {
    let layout = demonstrations.layout;
    let rank = demonstrations.primitives.rank();
    let mut profile = DMatrix::zeros(rank, ends_len(layout));
    for shared in groups(demonstrations) {
        let profiles = profiles(demonstrations, &shared, used);
        for (coordinate, inputs) in &shared.coordinates {
            let activations =
                (demonstrations.primitives).coordinate_activations(*coordinate, &profiles);
            for (activation, input) in activations.column_iter().zip(inputs) {
                for &(index, factor) in input {
                    profile.column_mut(index).axpy(factor, &activation, 1.0);
                }
            }
        }
    }
    profile
}

fn groups(demonstrations: &Demonstrations<'_>) -> Vec<Shared> {
    let layout = demonstrations.layout;
    let duration_s = layout.duration_s();
    let part = |part: usize, c: usize| part * SEGMENT_COORDINATES + c;
    let finger = |c: usize| {
        let displacement = vec![(part(1, c), 1.0), (part(0, c), -1.0)];
        let velocity = |at: usize| vec![(part(at, c), duration_s)];
        (c, vec![displacement, velocity(2), velocity(3)])
    };
    let mut groups = vec![Shared {
        coordinates: (0..SEGMENT_COORDINATES).map(finger).collect(),
        inputs: 3,
    }];
    if layout.object {
        let object = part(4, 0);
        let moved = |a: usize| {
            let displacement = vec![(object + 3 + a, 1.0), (object + a, -1.0)];
            (SEGMENT_COORDINATES + a, vec![displacement])
        };
        let turned = |a: usize| {
            (
                SEGMENT_COORDINATES + 3 + a,
                vec![vec![(object + 6 + a, 1.0)]],
            )
        };
        groups.push(Shared {
            coordinates: (0..3).map(moved).collect(),
            inputs: 1,
        });
        groups.push(Shared {
            coordinates: (0..3).map(turned).collect(),
            inputs: 1,
        });
    }
    groups
}

/// The profiles over time (N x inputs).
fn profiles(demonstrations: &Demonstrations<'_>, shared: &Shared, used: &[usize]) -> DMatrix<f64> {
    let layout = demonstrations.layout;
    let (samples, inputs) = (layout.samples, shared.inputs);
    let mut squares = DMatrix::zeros(inputs, inputs);
    let mut products = DMatrix::zeros(samples, inputs);
    for &segment in used {
        let ends = demonstrations.ends.column(segment);
        let deviation = demonstrations.deviations_m.column(segment);
        for (coordinate, terms) in &shared.coordinates {
            let input = DVector::from_iterator(
                inputs,
                terms
                    .iter()
                    .map(|term| term.iter().map(|&(i, factor)| factor * ends[i]).sum()),
            );
            squares.ger(1.0, &input, &input, 1.0);
            let (start, stride) = if *coordinate < SEGMENT_COORDINATES {
                (*coordinate, SEGMENT_COORDINATES)
            } else {
                let first = layout.finger_rows() + coordinate - SEGMENT_COORDINATES;
                (first, OBJECT_COORDINATES)
            };
            let over_time = (deviation.as_slice()[start..].iter().step_by(stride)).take(samples);
            for (t, value) in over_time.enumerate() {
                for k in 0..inputs {
                    products[(t, k)] += value * input[k];
                }
            }
        }
    }
    let ridge = RIDGE * squares.trace() / inputs as f64;
    for k in 0..inputs {
        squares[(k, k)] += ridge;
    }
    match squares.cholesky() {
        Some(factor) => factor.solve(&products.transpose()).transpose(),
        // Nothing moved in any demonstration.
        None => DMatrix::zeros(samples, inputs),
    }
}
