#!/usr/bin/env python3
"""Makes contact.json: hulls and distances by SciPy, NumPy and quadprog, on inputs made here.

    python make_contact.py > contact.json

Hull corners, volume and area come from scipy.spatial.ConvexHull (Qhull). Distance to a hull from
inside is the largest value of Qhull's plane equations; from outside it is the solution of the
projection QP `min |x - p|^2, A x <= b` by quadprog. Distance to box and cylinder goes by clamping.
"""
import json
import sys

import numpy as np
import quadprog
from scipy.spatial import ConvexHull

rng = np.random.default_rng(20240817)


def blob(n):
    """General position, about the size of a fingertip's workspace in metres."""
    return rng.normal(size=(n, 3)) * [0.012, 0.008, 0.02] + [0.1, -0.02, 0.03]


def sphere(n):
    p = rng.normal(size=(n, 3))
    return 0.03 * p / np.linalg.norm(p, axis=1)[:, None]


def path(n):
    """A slow path in steps of 0.1 mm, so that many points repeat or share a plane."""
    t = np.arange(n) * 0.05
    f = np.array([0.9, 1.31, 0.7]), np.array([2.3, 1.9, 2.9])
    p = 0.012 * np.sin(np.outer(t, f[0]) + [0, 1, 2]) + 0.006 * np.sin(np.outer(t, f[1]) + [2, 0, 1])
    return np.round(p, 4)


def slab(n):
    """Twenty micrometres thick."""
    return rng.uniform(-1, 1, size=(n, 3)) * [0.02, 0.03, 0.00001]


def project(a, b, p):
    x = quadprog.solve_qp(np.eye(3), p, -a.T, -b)[0]
    return float(np.linalg.norm(x - p))


def hull_case(name, points, general_position):
    hull = ConvexHull(points)
    # In millimetres and about the centre, where quadprog's tolerances are small enough.
    centre = points.mean(0)
    a, b = hull.equations[:, :3], -hull.equations[:, 3]
    low, high = points.min(0), points.max(0)
    span = high - low
    queries = np.concatenate([
        rng.uniform(low, high, size=(40, 3)),
        rng.uniform(low - 0.5 * span, high + 0.5 * span, size=(40, 3)),
    ])
    distances = []
    for q in queries:
        highest = float((a @ q - b).max())
        outside = highest > 0
        distances.append(project(a, (b - a @ centre) * 1e3, (q - centre) * 1e3) / 1e3 if outside else highest)
    return dict(
        name=name, points_m=points.tolist(), volume_m3=float(hull.volume), area_m2=float(hull.area),
        corners=sorted(int(v) for v in hull.vertices) if general_position else None,
        queries_m=queries.tolist(), distance_m=distances,
    )


def box_distance(p, half):
    beyond = p - np.clip(p, -half, half)
    outside = np.linalg.norm(beyond, axis=1)
    depth = (half - np.abs(p)).min(1)
    return np.where(outside > 0, outside, -depth)


def cylinder_distance(p, radius, half):
    flat = np.stack([np.hypot(p[:, 0], p[:, 1]), p[:, 2]], 1)
    return box_distance(flat, np.array([radius, half]))


def shape_case(shape, distance):
    p = rng.uniform(-0.06, 0.06, size=(60, 3))
    return dict(shape=shape, queries_m=p.tolist(), distance_m=distance(p).tolist())


out = dict(
    hulls=[
        hull_case("blob", blob(300), True),
        hull_case("sphere", sphere(150), True),
        hull_case("path", path(900), False),
        hull_case("slab", slab(120), True),
    ],
    shapes=[
        shape_case("cube:0.05", lambda p: box_distance(p, np.full(3, 0.025))),
        shape_case("box:0.04x0.06x0.08", lambda p: box_distance(p, np.array([0.02, 0.03, 0.04]))),
        shape_case("cylinder:0.05x0.07", lambda p: cylinder_distance(p, 0.025, 0.035)),
    ],
)
json.dump(out, sys.stdout)
print()
