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


reference = dict(multiplicative=multiplicative(), ledoit_wolf=shrinkage(), nnls=non_negative(), pca=components())
path = pathlib.Path(__file__).with_name("reference.json")
path.write_text(json.dumps(reference, separators=(",", ":")) + "\n")
