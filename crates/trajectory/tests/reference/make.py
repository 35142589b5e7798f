"""Reference values for quantiles, whiskers and curves, by NumPy, matplotlib's rule and SciPy.

    python make.py > trajectory.json
"""
import json
import sys

import numpy as np
from scipy.interpolate import BPoly, CubicHermiteSpline

rng = np.random.default_rng(7)


def summary(values):
    v = np.array(values)
    q = np.percentile(v, [5, 25, 50, 75, 95], method="linear")
    reach = 1.5 * (q[3] - q[1])
    return dict(
        values=values,
        mean=v.mean(), rmse=float(np.sqrt((v**2).mean())), min=v.min(), max=v.max(),
        p5=q[0], p25=q[1], p50=q[2], p75=q[3], p95=q[4],
        whisker_low=v[v >= q[1] - reach].min(), whisker_high=v[v <= q[3] + reach].max(),
    )


distributions = [
    [3.0],
    [2.0, 1.0],
    [5.0, 1.0, 4.0],
    [0.0, 100.0, 100.0, 100.0],
    [1.0] * 9,
    [float(k % 7) for k in range(40)],
    [round(x, 6) for x in rng.normal(0, 1, 101)],
    [round(x, 6) for x in rng.lognormal(0, 1.2, 250)],
]

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
json.dump(dict(distributions=[summary(d) for d in distributions], curves=curves), sys.stdout, default=plain)
print()
