#!/usr/bin/env python3
"""Writes reference.json: what scikit-learn and SciPy make of inputs drawn here.

    python make_reference.py      # scikit-learn 1.9, SciPy 1.17, NumPy 2.4

Matrices are lists of columns. Inputs are rounded to four decimals so that the file stays small and
both sides read the very same numbers.
"""
import json
import pathlib

import numpy as np
from scipy.optimize import nnls
from sklearn.covariance import ledoit_wolf
from sklearn.decomposition import NMF, PCA
from sklearn.decomposition._nmf import _initialize_nmf

rng = np.random.default_rng(20230830)


def columns(matrix):
    return np.asarray(matrix).T.tolist()


def positive(*shape):
    return np.round(rng.uniform(0.05, 1.0, shape), 4)


def multiplicative():
    rows, count, rank, iterations = 20, 13, 4, 30
    v, w, h = positive(rows, count), positive(rows, rank), positive(rank, count)

    # scikit-learn factorises the transpose and updates its first factor (our activations) first.
    def run(n):
        model = NMF(rank, init="custom", solver="mu", max_iter=n, tol=0)
        first = model.fit_transform(v.T.copy(), W=h.T.copy(), H=w.T.copy())
        return model.components_, first.T

    # Ours ends with a half step of the activations: they are one update ahead.
    return dict(
        data=columns(v), start_primitives=columns(w), start_activations=columns(h),
        iterations=iterations, primitives=run(iterations)[0].tolist(),
        activations=columns(run(iterations + 1)[1]),
    )


def penalised(reference):
    """Multiplicative updates with penalties, from the start of `multiplicative`."""
    v, w, h = (np.array(reference[part]).T for part in ("data", "start_primitives", "start_activations"))
    out = []
    for alpha_primitives, alpha_activations, l1_ratio in [(0.02, 0.0, 1.0), (0.0, 0.03, 0.0), (0.01, 0.02, 0.4)]:

        # Its W are our activations, its H our primitives.
        def run(n):
            model = NMF(h.shape[0], init="custom", solver="mu", max_iter=n, tol=0, alpha_W=alpha_activations,
                        alpha_H=alpha_primitives, l1_ratio=l1_ratio)
            first = model.fit_transform(v.T.copy(), W=h.T.copy(), H=w.T.copy())
            return model.components_, first.T

        n = reference["iterations"]
        out.append(dict(alpha_primitives=alpha_primitives, alpha_activations=alpha_activations, l1_ratio=l1_ratio,
                        primitives=run(n)[0].tolist(), activations=columns(run(n + 1)[1])))
    return out


def singular_start(reference):
    v = np.array(reference["data"]).T
    _, h = _initialize_nmf(v.T, 4, init="nndsvda", random_state=0)
    # Rows of numbers, one for each primitive: `columns` of the primitives as rows (rank x rows).
    return dict(data=columns(v), primitives_as_rows=columns(h))


def shrinkage():
    out = []
    for count, rank in [(5, 9), (40, 6), (400, 3)]:
        x = np.round(rng.normal(size=(count, rank)) * np.linspace(0.3, 3.0, rank) + 1.0, 4)
        covariance, weight = ledoit_wolf(x)
        out.append(dict(vectors=x.tolist(), mean=x.mean(0).tolist(), covariance=columns(covariance), weight=float(weight)))
    return out


def non_negative():
    a = positive(15, 6)
    b = np.round(a @ np.array([0.5, -0.8, 0.9, 0.0, 1.2, -0.3]) + rng.normal(size=15) * 0.05, 4)
    h, norm = nnls(a, b)
    return dict(primitives=columns(a), segment=b.tolist(), activations=h.tolist(), residual=float(norm))


def components():
    v = np.round(rng.normal(size=(15, 8)) * np.linspace(2.0, 0.5, 15)[:, None], 4)
    model = PCA(3, svd_solver="full").fit(v.T)
    w = model.components_
    w = w * np.sign(w[np.arange(3), np.abs(w).argmax(1)])[:, None]
    return dict(data=columns(v), mean=model.mean_.tolist(), primitives=w.tolist(),
                variances=(model.explained_variance_ * 7 / 8).tolist())


plain = multiplicative()
reference = dict(multiplicative=plain, penalised=penalised(plain), nndsvd=singular_start(plain), ledoit_wolf=shrinkage(), nnls=non_negative(), pca=components())
path = pathlib.Path(__file__).with_name("reference.json")
path.write_text(json.dumps(reference, separators=(",", ":")) + "\n")
