"""Recomputes boundary conditions and errors of the held-out protocol from recordings, with NumPy alone.

    python tests/reference/held_out.py SESSION OUT

SESSION is a folder of Motive CSV files in metres with quaternions whose hand is a rigid body named Hand and whose
fingertips are markers named by finger, OUT what `inhand run --take-methods all` wrote for it. Needs numpy, pandas, pyarrow and mcap.
Nothing of inhand is used. Of every test segment: the window of the lines, values and slopes, the straight line and the
cubic between them against the motion in `/held_out`, and the error of every method at every instant against
`rows.held_out.parquet`. Segments with missing samples in reach are left out. Prints the largest deviations and
ends with 1 where one is beyond 1e-9 m.
"""

import csv
import glob
import json
import os
import struct
import sys

import numpy as np
import pandas as pd
from mcap.reader import make_reader

FINGERS = ["Thumb", "Index", "Middle", "Ring", "Little"]
TOLERANCE_M = 1e-9


def take(path):
    """Fingertips in the hand's frame (samples, 5, 3), metres, and the rate."""
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    facts = dict(zip(rows[0][::2], rows[0][1::2]))
    kinds, names, what, axes = rows[2], rows[3], rows[5], rows[6]
    data = np.array([[float(c) if c else np.nan for c in row] for row in rows[7:] if row])

    def columns(kind, name, number, order):
        found = {
            axes[j]: j
            for j in range(2, len(kinds))
            if kinds[j] == kind and names[j] == name and what[j] == number
        }
        return data[:, [found[axis] for axis in order]]

    q = columns("Rigid Body", "Hand", "Rotation", "XYZW")
    x, y, z, w = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    ).transpose(2, 0, 1)
    origin = columns("Rigid Body", "Hand", "Position", "XYZ")
    tips = [
        np.einsum("tji,tj->ti", rotation, columns("Marker", finger, "Position", "XYZ") - origin)
        for finger in FINGERS
    ]
    return np.stack(tips, 1), float(facts["Export Frame Rate"])


def line(x, at, rate):
    """Value at sample `at` of the window and slope of the least-squares line."""
    t = (np.arange(len(x)) - at) / rate
    slope = np.tensordot(t - t.mean(), x, axes=1) / ((t - t.mean()) ** 2).sum()
    return x.mean(0) - slope * t.mean(), slope


def varint(data, at):
    value = shift = 0
    while True:
        byte = data[at]
        value |= (byte & 0x7F) << shift
        at, shift = at + 1, shift + 7
        if byte < 0x80:
            return value, at


def fields(data):
    """Numbers and values of a protobuf message."""
    at = 0
    while at < len(data):
        key, at = varint(data, at)
        if key & 7 == 2:
            size, at = varint(data, at)
            yield key >> 3, data[at : at + size]
            at += size
        elif key & 7 == 1:
            yield key >> 3, struct.unpack("<d", data[at : at + 8])[0]
            at += 8
        else:
            value, at = varint(data, at)
            yield key >> 3, value


def generated(path):
    """Fingertips of each method by sample of the take."""
    methods = {}
    with open(path, "rb") as file:
        reader = make_reader(file)
        start = None
        for _, channel, message in reader.iter_messages():
            start = message.log_time if start is None else min(start, message.log_time)
            parts = channel.topic.split("/")
            if parts[1] == "held_out" and parts[3] == "fingertips":
                tips = np.zeros((5, 3))
                for number, value in fields(message.data):
                    if 2 <= number <= 6:
                        point = dict(fields(dict(fields(value))[1]))
                        tips[number - 2] = [point.get(axis, 0.0) for axis in (1, 2, 3)]
                methods.setdefault(parts[2], []).append((message.log_time, tips))
    return start, methods


def main(session, out):
    said = json.load(open(os.path.join(out, "evaluation.json")))["held_out"]
    rows = pd.read_parquet(os.path.join(out, "rows.held_out.parquet"))
    worst = {"ends": 0.0, "errors": 0.0}
    compared = {"segments": 0, "errors": 0}
    for path in sorted(glob.glob(os.path.join(session, "test", "*.csv"))):
        name = os.path.splitext(os.path.basename(path))[0]
        tips, rate = take(path)
        count = round(said["ends_s"] * rate)
        assert count == said["ends_samples"]
        start, methods = generated(os.path.join(out, name + ".mcap"))
        motion = {}
        for method, samples in methods.items():
            motion[method] = np.full_like(tips, np.nan)
            for time, configuration in samples:
                motion[method][round((time - start) * 1e-9 * rate)] = configuration
        of_take = rows[rows["take"] == name]
        size = int(of_take["sample"].max()) + 1
        s = (np.arange(size) / (size - 1))[:, None, None]
        duration = (size - 1) / rate
        for first in sorted(of_take["start_sample"].unique()):
            last = first + size - 1
            inside = slice(first, last + 1)
            if not np.isfinite(tips[first - count - 12 : last + count + 12]).all():
                continue
            p0, v0 = line(tips[first - count + 1 : first + 1], count - 1, rate)
            p1, v1 = line(tips[last : last + count], 0, rate)
            curves = {
                "line": p0 + (p1 - p0) * s,
                "hermite": (2 * s**3 - 3 * s**2 + 1) * p0
                + (s**3 - 2 * s**2 + s) * duration * v0
                + (3 * s**2 - 2 * s**3) * p1
                + (s**3 - s**2) * duration * v1,
            }
            for method, curve in curves.items():
                apart = np.abs(motion[method][inside] - curve).max()
                worst["ends"] = max(worst["ends"], apart)
            compared["segments"] += 1
            for method, planned in motion.items():
                here = of_take[
                    (of_take["start_sample"] == first) & (of_take["method"] == method)
                ].sort_values("sample")
                errors = np.linalg.norm(planned[inside] - tips[inside], axis=2)
                table = here[[f"{finger.lower()}.error_m" for finger in FINGERS]].to_numpy()
                assert np.isfinite(errors).all() and np.isfinite(table).all(), (method, first)
                worst["errors"] = max(worst["errors"], np.abs(errors - table).max())
                compared["errors"] += errors.size
    print(
        f"{compared['segments']} segments, {compared['errors']} errors; largest deviation of boundary conditions "
        f"{worst['ends']:.3g} m, of errors {worst['errors']:.3g} m"
    )
    return int(compared["segments"] == 0 or max(worst.values()) > TOLERANCE_M)


sys.exit(main(*sys.argv[1:]))
