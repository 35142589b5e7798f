"""Reference values for smooth curves, by SciPy.

    python make.py > curves.json
"""
import json
import sys

import numpy as np
from scipy.interpolate import BPoly, CubicHermiteSpline

rng = np.random.default_rng(7)
# The first draws of this seed belong to the quantiles of the crate `statistics`.
rng.normal(0, 1, 101), rng.lognormal(0, 1.2, 250)

samples, rate = 12, 37.5
T = (samples - 1) / rate
t = np.linspace(0, T, samples)
first, last, v0, v1 = (np.round(rng.normal(0, s, 15), 6) for s in (0.1, 0.1, 0.5, 0.5))
# Minimum jerk is the quintic with zero velocity and acceleration at both ends.
zero = np.zeros(15)
jerk = BPoly.from_derivatives([0, T], [[first, zero, zero], [last, zero, zero]])
curves = dict(
    samples=samples, rate_hz=rate, first=first, last=last, first_velocity=v0, last_velocity=v1,
    line=np.linspace(first, last, samples).ravel(),
    minimum_jerk=jerk(t).ravel(),
    hermite=CubicHermiteSpline([0, T], [first, last], [v0, v1])(t).ravel(),
)

plain = lambda x: x.tolist() if isinstance(x, np.ndarray) else float(x)
json.dump(dict(curves=curves), sys.stdout, default=plain)
print()
