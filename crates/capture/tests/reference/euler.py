"""Writes euler.csv: intrinsic Euler angles and the quaternions that scipy makes of them.

Columns: order, angle about x, about y, about z (degrees), quaternion x, y, z, w. The angles are
random with a fixed seed, plus right angles and gimbal lock.
"""

import itertools
import pathlib

import numpy as np
from scipy.spatial.transform import Rotation

rng = np.random.default_rng(20231128)
rows = []
for order in map("".join, itertools.permutations("XYZ")):
    angles = [*rng.uniform(-180.0, 180.0, (4, 3)).round(6), [90.0, 90.0, 0.0], [30.0, 90.0, -45.0]]
    for about in angles:
        in_order = ["XYZ".index(axis) for axis in order]
        # Upper-case letters are intrinsic rotations.
        quaternion = Rotation.from_euler(order, np.array(about)[in_order], degrees=True).as_quat()
        rows.append(",".join([order, *(f"{a!r}" for a in map(float, about)), *(f"{q!r}" for q in map(float, quaternion))]))
pathlib.Path(__file__).with_suffix(".csv").write_text("\n".join(rows) + "\n")
