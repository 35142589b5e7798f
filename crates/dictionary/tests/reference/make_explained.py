#!/usr/bin/env python3
"""Writes explained.json: cumulative explained variance by NumPy's singular values, of inputs drawn here.

    python make_explained.py      # NumPy 2.4

Matrices are lists of columns, rounded to five decimals.
"""
import json
import pathlib

import numpy as np

rng = np.random.default_rng(42)
cases = []
# More numbers than segments, and more segments than numbers.
for rows, count in [(30, 12), (15, 40)]:
    v = np.round(0.1 + rng.normal(size=(rows, count)) * np.linspace(0.02, 0.001, rows)[:, None], 5)
    x = v - v.mean(1, keepdims=True)
    squares = np.linalg.svd(x, compute_uv=False) ** 2
    share = np.cumsum(squares) / squares.sum()
    # What a dictionary of rank 4 leaves that misses the mean by one millimetre.
    u = np.linalg.svd(x)[0][:, :4]
    left = x - u @ (u.T @ x) + 0.001
    rms = float(np.sqrt((left**2).mean()))
    learned = 1 - (left**2).mean() / x.var(axis=None)
    cases.append(dict(rows=rows, columns=v.T.tolist(), share=share.tolist(), rms=rms, learned=float(learned)))
path = pathlib.Path(__file__).with_name("explained.json")
path.write_text(json.dumps(cases, separators=(",", ":")) + "\n")
