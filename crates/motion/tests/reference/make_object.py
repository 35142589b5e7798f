"""Reference rows of the object in a segment, by SciPy.

    python make_object.py > object.json

Poses at 100 Hz, metres, quaternions x y z w with whatever sign. The object turns by 1.5 pi about an
axis that wobbles, so that the shortest rotation vector would jump. The continuous one is found another
way than by comparing neighbours: the quaternions since the first sample, signs made continuous, have a
logarithm whose angle runs to a whole turn.
"""
import json
import sys

import numpy as np
from scipy.spatial.transform import Rotation

N, LEVER = 60, 0.025
rng = np.random.default_rng(5)
s = np.linspace(0, 1, N)
axis = np.c_[0.3 + 0.2 * np.sin(3 * s), 0.8 * np.ones(N), 0.4 + 0.2 * np.cos(4 * s)]
axis /= np.linalg.norm(axis, axis=1, keepdims=True)
turn = Rotation.from_rotvec(axis * (1.5 * np.pi * s**1.3)[:, None])
start = Rotation.from_rotvec([0.4, -1.1, 2.0])
q = (turn * start).as_quat()
q[rng.random(N) < 0.3] *= -1
p = np.round(np.c_[0.1 + 0.01 * np.sin(5 * s), 0.02 * s, -0.03 * s**2], 6)

since = (Rotation.from_quat(q) * Rotation.from_quat(q[0]).inv()).as_quat()
since[0] *= np.sign(since[0, 3])
for k in range(1, N):
    since[k] *= np.sign(since[k] @ since[k - 1])
length = np.linalg.norm(since[:, :3], axis=1)
angle = 2 * np.arctan2(length, since[:, 3])
vector = np.divide(since[:, :3], length[:, None], where=length[:, None] > 0, out=np.zeros((N, 3)))
rows = np.c_[p, LEVER * vector * angle[:, None]]
assert angle.max() > 1.4 * np.pi

json.dump(dict(position_m=p.tolist(), quaternion_xyzw=q.tolist(), rows_m=rows.tolist()), sys.stdout)
print()
