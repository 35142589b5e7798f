//! Principal components of each finger's deviation.

use inhand_model::{Finger, SEGMENT_COORDINATES, SegmentLayout};
use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::eigen;
use crate::matrix_view::{View, multiply};
use crate::pca::point_up;
use crate::product::gram;

/// Share of the largest variance below which a component is rounding, not motion.
const SMALLEST_VARIANCE: f64 = 1e-12;
/// Mean square of activations below which a component is rounding, whatever the others are: a
/// nanometre over a whole segment.
const SMALLEST_SQUARE_M2: f64 = 1e-18;

/// Orthonormal primitives, block by block.
#[derive(Clone, Debug)]
pub(super) struct Primitives {
    layout: SegmentLayout,
    /// For each part, primitives as columns (width N x size).
    blocks: Vec<DMatrix<f64>>,
}

/// Everything that is learned from, by segment.
pub(super) struct Demonstrations<'a> {
    pub(super) layout: SegmentLayout,
    pub(super) primitives: &'a Primitives,
    /// Boundary conditions (d x n).
    pub(super) ends: &'a DMatrix<f64>,
    /// Deviations from the cubic Hermite baseline (rows x n), metres.
    pub(super) deviations_m: &'a DMatrix<f64>,
    /// Their activations (r x n), metres.
    pub(super) activations_m: &'a DMatrix<f64>,
}

impl Primitives {
    /// At most `most` components of each part, those with the largest mean square, and the
    /// activations of the deviations (r x n, metres): orthonormal primitives make them scalar
    /// products.
    pub(super) fn of(
        deviations_m: &DMatrix<f64>,
        layout: SegmentLayout,
        most: usize,
    ) -> (Self, DMatrix<f64>) {
        let (blocks, products): (Vec<_>, Vec<_>) = (0..layout.parts())
            .into_par_iter()
            .map(|part| {
                let rows: Vec<usize> = layout.part_rows(part).collect();
                let own_m = deviations_m.select_rows(&rows);
                let block = components(&own_m, most);
                let activations = activations(&block, &own_m);
                (block, activations)
            })
            .unzip();
        let primitives = Self { layout, blocks };
        let mut activations_m = DMatrix::zeros(primitives.rank(), deviations_m.ncols());
        let mut start = 0;
        for product in products {
            activations_m
                .rows_mut(start, product.nrows())
                .copy_from(&product);
            start += product.nrows();
        }
        (primitives, activations_m)
    }

    /// Each finger's primitives (3 N x size), with the number of its first activation.
    pub(super) fn finger_blocks(&self) -> impl Iterator<Item = (usize, &DMatrix<f64>)> {
        let mut start = 0;
        self.blocks[..Finger::COUNT].iter().map(move |block| {
            start += block.ncols();
            (start - block.ncols(), block)
        })
    }

    /// Number of primitives of each part.
    pub(super) fn sizes(&self) -> Vec<usize> {
        self.blocks.iter().map(DMatrix::ncols).collect()
    }

    pub(super) fn rank(&self) -> usize {
        self.blocks.iter().map(DMatrix::ncols).sum()
    }

    /// Mean square of what the primitives leave of the fingertips' deviations, m².
    pub(super) fn unexplained_m2(
        &self,
        deviations_m: &DMatrix<f64>,
        activations_m: &DMatrix<f64>,
    ) -> f64 {
        let sizes = self.sizes();
        let fingers: usize = sizes[..Finger::COUNT].iter().sum();
        let rows = self.layout.finger_rows();
        let all = deviations_m.rows(0, rows).norm_squared();
        let explained = activations_m.rows(0, fingers).norm_squared();
        (all - explained).max(0.0) / (rows * deviations_m.ncols()) as f64
    }

    /// The fingertips' deviations that activations (r x n) stand for at some samples, metres: one
    /// column each, ordered finger, sample, axis.
    pub(super) fn fingertips_m(
        &self,
        activations_m: &DMatrix<f64>,
        samples: &[usize],
    ) -> DMatrix<f64> {
        let rows: Vec<usize> = samples.iter().flat_map(|&t| 3 * t..3 * t + 3).collect();
        let blocks: Vec<_> = self.finger_blocks().collect();
        let products: Vec<_> = blocks
            .into_par_iter()
            .map(|(start, block)| {
                block.select_rows(&rows) * activations_m.rows(start, block.ncols())
            })
            .collect();
        let mut deviations = DMatrix::zeros(rows.len() * Finger::COUNT, activations_m.ncols());
        for (finger, product) in products.into_iter().enumerate() {
            deviations
                .rows_mut(finger * rows.len(), rows.len())
                .copy_from(&product);
        }
        deviations
    }

    /// The fingertips of whole columns at some samples, in the order of
    /// [`Primitives::fingertips_m`].
    pub(super) fn fingertips_of(
        columns_m: &DMatrix<f64>,
        segments: &[usize],
        samples: &[usize],
    ) -> DMatrix<f64> {
        let rows: Vec<usize> = (0..Finger::COUNT)
            .flat_map(|finger| {
                (samples.iter()).flat_map(move |t| {
                    let first = t * SEGMENT_COORDINATES + finger * 3;
                    first..first + 3
                })
            })
            .collect();
        DMatrix::from_fn(rows.len(), segments.len(), |i, j| {
            columns_m[(rows[i], segments[j])]
        })
    }

    /// `profiles` over time (N x k) of one coordinate, as activations (r x k): `coordinate` counts
    /// the 15 of the fingertips, then the 6 of the object.
    pub(super) fn coordinate_activations(
        &self,
        coordinate: usize,
        profiles: &DMatrix<f64>,
    ) -> DMatrix<f64> {
        let mut activations = DMatrix::zeros(self.rank(), profiles.ncols());
        let (index, axis) = if coordinate < SEGMENT_COORDINATES {
            (coordinate / 3, coordinate % 3)
        } else {
            (Finger::COUNT, coordinate - SEGMENT_COORDINATES)
        };
        let start: usize = self.blocks[..index].iter().map(DMatrix::ncols).sum();
        let block = &self.blocks[index];
        let width = block.nrows() / self.layout.samples;
        for (j, primitive) in block.column_iter().enumerate() {
            for (k, profile) in profiles.column_iter().enumerate() {
                activations[(start + j, k)] = (profile.iter().enumerate())
                    .map(|(t, value)| value * primitive[t * width + axis])
                    .sum();
            }
        }
        activations
    }

    /// All primitives as columns of whole segments (rows x r).
    pub(super) fn matrix(&self) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(self.layout.rows(), self.rank());
        let mut start = 0;
        for (part, block) in self.blocks.iter().enumerate() {
            for (j, primitive) in block.column_iter().enumerate() {
                for (row, value) in self.layout.part_rows(part).zip(primitive.iter()) {
                    matrix[(row, start + j)] = *value;
                }
            }
            start += block.ncols();
        }
        matrix
    }
}

/// `blockᵀ own` (size x n), without nalgebra's slow product of transposes.
fn activations(block: &DMatrix<f64>, own_m: &DMatrix<f64>) -> DMatrix<f64> {
    let (rows, size) = block.shape();
    let mut activations = DMatrix::zeros(size, own_m.ncols());
    multiply(
        View::columns(block.as_slice(), rows).transposed(),
        View::columns(own_m.as_slice(), rows),
        activations.as_mut_slice(),
    );
    activations
}

/// Leading eigenvectors of `M Mᵀ`, each with its largest number positive.
fn components(own_m: &DMatrix<f64>, most: usize) -> DMatrix<f64> {
    let rows = own_m.nrows();
    let squares = gram(own_m.as_slice(), rows);
    let (values, mut components) = eigen::leading(&squares, rows, most.min(own_m.ncols()));
    let smallest = (SMALLEST_VARIANCE * values.first().copied().unwrap_or(0.0))
        .max(SMALLEST_SQUARE_M2 * own_m.ncols() as f64);
    let count = values.partition_point(|value| *value > smallest);
    components.truncate(count * rows);
    point_up(&mut components, rows);
    let mut components = DMatrix::from_vec(rows, count, components);
    // What never deviates, as both ends, does so exactly: rounding must not move it.
    for row in 0..rows {
        if squares[row * rows + row] == 0.0 {
            components.row_mut(row).fill(0.0);
        }
    }
    components
}
