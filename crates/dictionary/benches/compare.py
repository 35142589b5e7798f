#!/usr/bin/env python3
"""Time to a given reconstruction error, beside scikit-learn's solvers on the same matrix.

    pip install numpy scikit-learn
    cargo bench -p inhand-dictionary --bench compare --no-run     # prints where the program is
    python compare.py PROGRAM [--segments FILE | --session DIR] [--stride 100] [--rounds 3]

PROGRAM is the bench `compare` (target/release/deps/compare-...). FILE holds segments of 1500 doubles one
after the other, metres; DIR holds Motive CSV exports train/*.csv as the whole job reads them (that
needs pandas and SciPy); without either, smooth motion is made up. Each round runs, one after the
other on all cores: scikit-learn's multiplicative solver (nndsvdar, 200 iterations), ours to its error,
scikit-learn's coordinate descent (10 iterations), ours to its error, and NumPy's matrix products of as many
iterations as ours took. Ratios are formed within a round; the medians over rounds are printed.
"""
import argparse
import glob
import json
import os
import pathlib
import statistics
import subprocess
import tempfile
import time
import warnings

# As many threads as there are cores to run on. Set before the import, which reads it; more threads
# than cores make NumPy several times slower.
os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = str(len(os.sched_getaffinity(0)))

import numpy as np
from sklearn.decomposition import NMF

ROWS, RANK = 1500, 200


def session(folder, stride):
    """Training segments of a session, one a row, as `inhand` cuts them at 100 Hz."""
    import pandas as pd
    from scipy.ndimage import median_filter
    from scipy.spatial.transform import Rotation

    rows = []
    for path in sorted(glob.glob(f"{folder}/train/*.csv")):
        take = pd.read_csv(path, skiprows=2, header=[0, 1, 2, 3, 4], index_col=0, low_memory=False)
        take.columns = pd.MultiIndex.from_tuples([(c[0], c[1], c[3], c[4]) for c in take.columns])

        def block(kind, name, what, axes):
            return np.stack([take[(kind, name, what, axis)].to_numpy(float) for axis in axes], 1)

        inverse = Rotation.from_quat(block("Rigid Body", "Hand", "Rotation", "XYZW")).inv()
        hand = block("Rigid Body", "Hand", "Position", "XYZ")
        tips = np.stack([
            inverse.apply(block("Marker", name, "Position", "XYZ") - hand)
            for name in ("Thumb", "Index", "Middle", "Ring", "Little")
        ], 1)
        tips = median_filter(tips, size=(50, 1, 1), mode="nearest")
        rows += [tips[i:i + 100].reshape(-1) for i in range(4, len(tips) - 103, stride)]
    return np.array(rows)


def shifted_mm(segments):
    x = 1000 * segments
    lowest = x.reshape(len(x), -1, 15).min(axis=(0, 1)) - 5.0
    return x - np.tile(lowest, ROWS // 15)


def scikit_learn(x, **settings):
    model = NMF(RANK, tol=0, random_state=0, **settings)
    start = time.perf_counter()
    activations = model.fit_transform(x)
    seconds = time.perf_counter() - start
    return seconds, float(np.sqrt(np.mean((x - activations @ model.components_) ** 2)))


def ours(program, path, rms_mm):
    line = subprocess.run(
        [program, "learn", path, f"{rms_mm:.6f}", "200", "3"], check=True, capture_output=True, text=True
    ).stdout.splitlines()[-1]
    return json.loads(line)


def products(x, iterations):
    """NumPy's time for what `iterations` updates of both factors must multiply, and one of the activations."""
    rng = np.random.default_rng(0)
    w, h = rng.random((ROWS, RANK)), rng.random((len(x), RANK))
    start = time.perf_counter()
    for iteration in range(iterations + 1):
        w.T @ x.T, w.T @ w
        if iteration < iterations:
            h.T @ x, h.T @ h
    return time.perf_counter() - start


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--segments")
    parser.add_argument("--session")
    parser.add_argument("--stride", type=int, default=100)
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    rounds = []
    with tempfile.TemporaryDirectory() as folder:
        path = arguments.segments
        if arguments.session:
            path = str(pathlib.Path(folder, "segments.f64"))
            session(arguments.session, arguments.stride).astype("<f8").tofile(path)
        elif not path:
            path = str(pathlib.Path(folder, "segments.f64"))
            subprocess.run([arguments.program, "write", path, str(59500 // arguments.stride)], check=True)
        x = shifted_mm(np.fromfile(path, "<f8").reshape(-1, ROWS))
        for _ in range(arguments.rounds):
            row = {}
            for name, settings in (
                ("mu", dict(init="nndsvdar", solver="mu", max_iter=200)),
                ("cd", dict(init="nndsvdar", solver="cd", max_iter=10)),
            ):
                theirs, rms_mm = scikit_learn(x, **settings)
                mine = ours(arguments.program, path, rms_mm)
                row |= {
                    f"{name}_rms_mm": rms_mm, f"{name}_s": theirs, f"ours_to_{name}_s": mine["seconds"],
                    f"ours_to_{name}_iterations": mine["iterations"], f"ours_to_{name}_rms_mm": mine["rms_mm"],
                    f"{name}_ratio": theirs / mine["seconds"],
                    f"{name}_of_products": mine["seconds"] / products(x, mine["iterations"]),
                }
            print(json.dumps(row), flush=True)
            rounds.append(row)
    for key in rounds[0]:
        print(f"{key:24} {statistics.median(row[key] for row in rounds):9.4f}")


if __name__ == "__main__":
    main()
