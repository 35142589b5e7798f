//! HALS written down as it stands in the paper, one number after the other: what the tests hold the
//! fast version against, and what the benches compare it with.

use nalgebra::DMatrix;

/// One sweep over the rows of `x` (rank x count) with Gram matrix `g` and linear terms `p`.
pub(crate) fn sweep(g: &DMatrix<f64>, p: &DMatrix<f64>, x: &mut DMatrix<f64>) {
    for column in 0..x.ncols() {
        for j in 0..x.nrows() {
            if g[(j, j)] <= 0.0 {
                continue;
            }
            let mut product = 0.0;
            for l in 0..x.nrows() {
                product += g[(j, l)] * x[(l, column)];
            }
            x[(j, column)] = (x[(j, column)] + (p[(j, column)] - product) / g[(j, j)]).max(0.0);
        }
    }
}

/// One iteration: half of `sweeps`, rounded up, over the primitives (rows x rank), then all over the activations.
pub(crate) fn iterate(v: &DMatrix<f64>, w: &mut DMatrix<f64>, h: &mut DMatrix<f64>, sweeps: usize) {
    let mut w_rows = w.transpose();
    let (gram, cross) = (&*h * h.transpose(), &*h * v.transpose());
    for _ in 0..sweeps.div_ceil(2) {
        sweep(&gram, &cross, &mut w_rows);
    }
    *w = w_rows.transpose();
    let (gram, linear) = (&w_rows * &*w, &w_rows * v);
    for _ in 0..sweeps {
        sweep(&gram, &linear, h);
    }
}

/// Half the squared Frobenius norm of `v - w h`.
pub(crate) fn objective(v: &DMatrix<f64>, w: &DMatrix<f64>, h: &DMatrix<f64>) -> f64 {
    0.5 * (v - w * h).norm_squared()
}
