"""Reference values for quantiles and whiskers, by NumPy and matplotlib's rule.

    python make_quantiles.py > quantiles.json
"""
import json
import sys

import numpy as np

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

plain = lambda x: x.tolist() if isinstance(x, np.ndarray) else float(x)
json.dump(dict(distributions=[summary(d) for d in distributions]), sys.stdout, default=plain)
print()
