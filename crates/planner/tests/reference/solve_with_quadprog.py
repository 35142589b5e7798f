#!/usr/bin/env python3
"""Optima of small planning problems by quadprog, every row present.

    python solve_with_quadprog.py > quadprog.json        (numpy 2.4, quadprog 0.1.14)

The dictionary and the targets are the formulas of tests/suite/support.rs (`smooth`, `target`).
Units: metres in the file, millimetres in the problem.
"""
import json

import numpy as np
import quadprog

SAMPLES, RANK, SIGMA_MM, RIDGE = 20, 16, 0.1, 1e-4
ROWS = 15 * SAMPLES


def smooth():
    row, k = np.arange(ROWS)[:, None], np.arange(RANK)[None, :]
    t, c = (row // 15) / SAMPLES, row % 15
    w = (1 + np.sin(2 * np.pi * (0.3 + 0.11 * k) * t + 0.7 * k + c)) * (1.1 + np.cos(0.9 * c * (k + 1)))
    w /= np.linalg.norm(w, axis=0)
    offset = 0.01 * np.sin(np.arange(ROWS) % 15 + 1.0)
    k = np.arange(RANK)
    mean = 0.03 + 0.02 * np.sin(1.7 * k)
    covariance = (2e-4 * np.eye(RANK) + 3e-4 * np.outer(np.sin(0.5 * k), np.sin(0.5 * k))
                  + 2e-4 * np.outer(np.cos(1.3 * k), np.cos(1.3 * k)))
    return w, offset, mean, covariance


def solve(method, nonnegative, case, reach, size):
    w, offset, mean, covariance = smooth()
    c = np.arange(15)
    nominal = offset + w @ mean
    first = nominal[:15] + reach * np.sin(1.3 * c + 0.0 + case)
    last = nominal[-15:] + reach * np.sin(1.3 * c + 2.0 + case)
    if method == "paper":
        observed, wanted = np.arange(ROWS - 15, ROWS), last
        weight, precision, mu = 1.0, RIDGE * np.eye(RANK), np.zeros(RANK)
    else:
        observed, wanted = np.r_[0:15, ROWS - 15:ROWS], np.r_[first, last]
        weight, precision, mu = SIGMA_MM**-2, np.linalg.inv(covariance * 1e6), mean * 1e3
    a, y = w[observed], (wanted - offset[observed]) * 1e3
    p, q = precision + weight * a.T @ a, precision @ mu + weight * a.T @ y
    steps = w[15:] - w[:-15]
    base = (offset[15:] - offset[:-15]) * 1e3
    limit = size * 1e3 / SAMPLES
    g = [steps, -steps] + ([np.eye(RANK)] if nonnegative else [])
    b = [-limit - base, -limit + base] + ([np.zeros(RANK)] if nonnegative else [])
    h = quadprog.solve_qp(p, q, np.vstack(g).T.copy(), np.concatenate(b))[0]
    miss, away = a @ h - y, h - mu
    objective = 0.5 * (weight * miss @ miss + away @ precision @ away)
    return dict(method=method, kind="nmf" if nonnegative else "pca", case=case, reach_m=reach,
                velocity_m_s=size, activations_m=(h / 1e3).tolist(), objective=objective)


cases = [solve(method, nonnegative, case, reach, size)
         for method in ("paper", "prior") for nonnegative in (True, False)
         for case, reach, size in ((0, 0.01, 10.0), (1, 0.02, 0.2), (2, 0.03, 0.08))]
print(json.dumps(dict(samples=SAMPLES, rank=RANK, cases=cases), indent=1))
