#!/usr/bin/env python3
"""Makes session.json: a small session and its evaluation by NumPy, SciPy and quadprog.

    python make_session.py > session.json

Two takes of a hand around a box, cut into segments of 20 samples at 20 Hz; some fingertip and object
samples filled, the object missing for a while, one plan failed. Inputs are rounded to a micrometre, so
that both sides read the same numbers. Everything expected is computed here from the definitions:
distance to the box by clamping (signed; contacts and differences by its size, whatever the side),
hulls by scipy.spatial.ConvexHull, distance to a hull from outside by the projection QP, quantiles by
numpy.percentile (type 7).
"""
import json
import sys

import numpy as np
import quadprog
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

rng = np.random.default_rng(7)
N, RATE = 20, 20.0
TAU, LIMIT, TOLERANCE = 0.005, 0.010, 1e-9
OFFSETS = np.array([0.001, 0.0, 0.0005, 0.0, 0.002])
EDGES = np.array([0.04, 0.05, 0.06])
SWEEP = [k / 1000 for k in range(11)]
ROUNDING = 1e-12


def smooth(n, size, k):
    """Sums of slow waves, n x k."""
    t = np.arange(n)[:, None] / RATE
    out = np.zeros((n, k))
    for _ in range(4):
        out += rng.normal(size=k) * np.sin(2 * np.pi * rng.uniform(0.1, 1.2, size=k) * t + rng.uniform(0, 6.3, size=k))
    return size * out / 2


def take(n):
    rotvec = smooth(n, 0.5, 3)
    pose_q = Rotation.from_rotvec(rotvec).as_quat()
    centre = np.array([0.1, 0.0, -0.03]) + smooth(n, 0.008, 3)
    faces = np.array([[0, -0.026, 0], [-0.01, 0.028, 0.02], [0.005, 0.027, 0.0], [0.012, 0.029, -0.015], [0.023, 0.005, -0.032]])
    rotation = Rotation.from_quat(pose_q)
    tips = np.stack([centre + rotation.apply(f) for f in faces], 1) + smooth(n, 0.003, 15).reshape(n, 5, 3)
    return np.round(tips, 6), np.round(centre, 6), pose_q


def statistics(values, filled, without_gaps):
    values = np.asarray(values, float)
    q = np.percentile(values, [5, 25, 50, 75, 95])
    reach = 1.5 * (q[3] - q[1])
    return dict(
        n=len(values), n_filled=int(np.sum(filled)), n_left_out=int(without_gaps - len(values)), mean=values.mean(),
        rmse=np.sqrt(np.mean(values**2)), min=values.min(), p5=q[0], p25=q[1], p50=q[2], p75=q[3], p95=q[4],
        max=values.max(), whisker_low=values[values >= q[1] - reach].min(), whisker_high=values[values <= q[3] + reach].max(),
    )


def box_distance(p):
    half = EDGES / 2
    outside = np.linalg.norm(p - np.clip(p, -half, half), axis=-1)
    return np.where(outside > 0, outside, -(half - np.abs(p)).min(-1))


def hull_distance(hull, p):
    a, b = hull.equations[:, :3], -hull.equations[:, 3]
    highest = float((a @ p - b).max())
    if highest <= 0:
        return highest
    # In millimetres about a corner, where quadprog's tolerances are small enough.
    c = hull.points[hull.vertices[0]]
    x = quadprog.solve_qp(np.eye(3), (p - c) * 1e3, -a.T, -(b - a @ c) * 1e3)[0]
    return float(np.linalg.norm(x - (p - c) * 1e3)) / 1e3


LENGTHS, PER_TAKE = [125, 90], [6, 4]
takes = [take(n) for n in LENGTHS]
status = [np.zeros((n, 5), int) for n in LENGTHS]  # 0 measured, 1 filled
status[0][10:17, 2] = 1
status[0][38:43, 0] = 1
status[1][3:6, :] = 1
object_status = [np.zeros(n, int) for n in LENGTHS]  # 2 missing
object_status[0][50:58] = 1
object_status[1][30:47] = 2
origins = [(k, s * N + 2) for k, count in enumerate(PER_TAKE) for s in range(count)]
LEFT_OUT = 3  # segments that gaps took away
FAILED = 7

training = [np.round(np.concatenate([t[0][:, i] for t in takes])[::3] + rng.normal(size=(72, 3)) * 0.002, 6) for i in range(5)]
hulls = [ConvexHull(p) for p in training]
recorded = np.array([takes[k][0][s:s + N] for k, s in origins])
noise = np.array([smooth(N, 0.002, 15).reshape(N, 5, 3) for _ in origins])
planned = np.round(recorded + noise, 6)
planned[4, 7, 3] = planned[4, 7, 2] + [0.004, 0.003, 0.0]  # a collision
speed = np.diff(recorded.reshape(len(origins), N, 15), axis=1) * RATE
bounds = np.round(speed.min((0, 1)) * 1.02, 4), np.round(speed.max((0, 1)) * 1.02, 4)

ok = np.array([s != FAILED for s in range(len(origins))])
n_without_gaps = (len(origins) + LEFT_OUT) * N
filled = np.array([status[k][s:s + N] == 1 for k, s in origins])
object_at = np.array([object_status[k][s:s + N] for k, s in origins])
centre = np.array([takes[k][1][s:s + N] for k, s in origins])
quaternion = np.array([takes[k][2][s:s + N] for k, s in origins])


def to_object(tips):
    inverse = Rotation.from_quat(quaternion.reshape(-1, 4)).inv()
    flat, c = tips.reshape(-1, 5, 3), centre.reshape(-1, 3)
    return np.stack([inverse.apply(flat[:, i] - c) for i in range(5)], 1).reshape(tips.shape)


error = np.linalg.norm(planned - recorded, axis=3)
distance = {name: box_distance(to_object(tips)) - OFFSETS for name, tips in (("planned", planned), ("recorded", recorded))}
to_hull = {
    name: np.array([[[hull_distance(hulls[i], p) for i, p in enumerate(tips)] for tips in segment] for segment in all_tips])
    for name, all_tips in (("planned", planned), ("recorded", recorded))
}
pairs = {name: np.min([np.linalg.norm(tips[:, :, i] - tips[:, :, j], axis=2) for i in range(5) for j in range(i + 1, 5)], axis=0)
         for name, tips in (("planned", planned), ("recorded", recorded))}
judged = ok[:, None] & (object_at != 2)
by_finger = lambda values: [values[ok][:, :, i].ravel() for i in range(5)]
contact = {name: np.abs(d[judged]) <= TAU + ROUNDING for name, d in distance.items()}
three = lambda name, tau: float(((np.abs(distance[name][judged]) <= tau + ROUNDING).sum(1) >= 3).mean())
step = np.diff(planned[ok].reshape(-1, N, 15), axis=1) * RATE
outside = (step > bounds[1] + 1e-6 * np.abs(bounds[1]) + ROUNDING) | (step < bounds[0] - 1e-6 * np.abs(bounds[0]) - ROUNDING)
difference = np.abs(np.abs(distance["planned"]) - np.abs(distance["recorded"]))
either_filled = filled | (object_at == 1)[:, :, None]

expected = dict(
    error=statistics(error[ok].ravel(), filled[ok].ravel(), n_without_gaps * 5),
    error_by_finger=[statistics(e, f, n_without_gaps) for e, f in zip(by_finger(error), by_finger(filled))],
    error_at_start=statistics(error[ok][:, 0].ravel(), filled[ok][:, 0].ravel(), (len(origins) + LEFT_OUT) * 5),
    error_at_goal=statistics(error[ok][:, -1].ravel(), filled[ok][:, -1].ravel(), (len(origins) + LEFT_OUT) * 5),
    median_error_by_sample_m=np.median(error[ok].transpose(1, 0, 2).reshape(N, -1), axis=1).tolist(),
    reachability=dict(
        n=int(ok.sum()) * N,
        inside=[float((d <= TOLERANCE).mean()) for d in by_finger(to_hull["planned"])],
        recorded_inside=[float((d <= TOLERANCE).mean()) for d in by_finger(to_hull["recorded"])],
        worst_outside_m=[float(max(d.max(), 0)) for d in by_finger(to_hull["planned"])],
        distance=[statistics(d, f, n_without_gaps) for d, f in zip(by_finger(to_hull["planned"]), by_finger(filled))],
    ),
    collision=dict(
        n=int(ok.sum()) * N, instants=int((pairs["planned"][ok] < LIMIT).sum()),
        trajectories=int((pairs["planned"][ok] < LIMIT).any(1).sum()), nearest_m=float(pairs["planned"][ok].min()),
        recorded_instants=int((pairs["recorded"][ok] < LIMIT).sum()), recorded_nearest_m=float(pairs["recorded"][ok].min()),
    ),
    velocity=dict(
        n=int(step.size), outside=int(outside.sum()), trajectories_outside=int(outside.any((1, 2)).sum()),
        worst_ratio=float(np.maximum(step / bounds[1], step / bounds[0]).max()),
    ),
    contact=dict(
        n=int(judged.sum()), n_filled=int((filled.any(2) | (object_at == 1))[judged].sum()), n_left_out=int(n_without_gaps - judged.sum()),
        three_or_more=three("planned", TAU), recorded_three_or_more=three("recorded", TAU),
        by_finger=contact["planned"].mean(0).tolist(), recorded_by_finger=contact["recorded"].mean(0).tolist(),
        by_tau=[dict(tau_m=tau, three_or_more=three("planned", tau), recorded_three_or_more=three("recorded", tau)) for tau in SWEEP],
    ),
    distance_difference=[statistics(difference[judged][:, i], either_filled[judged][:, i], n_without_gaps) for i in range(5)],
)
# Numbers of every instant, for the rows.
expected_rows = dict(error_m=np.where(ok[:, None, None], error, -1).reshape(-1, 5).tolist(),
                     distance_m=np.where(judged[:, :, None], distance["planned"], -1).reshape(-1, 5).tolist(),
                     recorded_distance_m=np.where((object_at != 2)[:, :, None], distance["recorded"], -1).reshape(-1, 5).tolist(),
                     hull_distance_m=np.where(ok[:, None, None], to_hull["planned"], -1).reshape(-1, 5).tolist(),
                     recorded_hull_distance_m=to_hull["recorded"].reshape(-1, 5).tolist())
round_rows = lambda rows: [[float(f"{x:.12g}") for x in row] for row in rows]

out = dict(
    samples=N, rate_hz=RATE, left_out=LEFT_OUT, failed=FAILED, origins=origins, edges_m=EDGES.tolist(), tau_m=TAU,
    collision_limit_m=LIMIT, hull_tolerance_m=TOLERANCE, finger_offsets_m=OFFSETS.tolist(), tau_sweep_m=SWEEP,
    velocity_min_m_s=bounds[0].tolist(), velocity_max_m_s=bounds[1].tolist(),
    takes=[dict(tips_m=t[0].reshape(len(t[0]), 15).tolist(), filled=s.tolist(), centre_m=t[1].tolist(), quaternion_xyzw=t[2].tolist(),
                object_status=o.tolist()) for t, s, o in zip(takes, status, object_status)],
    training_m=[p.tolist() for p in training], planned_m=np.round(planned, 6).reshape(len(origins), -1).tolist(),
    expected=expected, expected_rows={k: round_rows(v) for k, v in expected_rows.items()},
)
json.dump(out, sys.stdout)
print()
for name in ("collision", "velocity", "contact"):
    print(name, expected[name], file=sys.stderr)
print(expected["reachability"]["inside"], expected["reachability"]["recorded_inside"], file=sys.stderr)
