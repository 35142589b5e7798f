"""Reference values for smoothness and time warping, by NumPy and SciPy from the published definitions.

    python make_motion.py > motion.json

SPARC and LDLJ-V: Balasubramanian, Melendez-Calderon, Roby-Brami and Burdet, J. NeuroEng. Rehabil. 12:112,
2015, with the spectrum of a whole FFT. Time warping: Sakoe and Chiba, 1978, symmetric, P = 0, as a full
table.
"""
import json
import sys

import numpy as np
from scipy.fft import rfft, rfftfreq
from scipy.spatial.distance import cdist

rng = np.random.default_rng(3)


def sparc(v, rate):
    n = 2 ** (int(np.ceil(np.log2(len(v)))) + 4)
    f, m = rfftfreq(n, 1 / rate), np.abs(rfft(v, n))
    m /= m.max()
    m, f = m[f <= 10], f[f <= 10]
    last = np.flatnonzero(m >= 0.05)[-1]
    m, f = m[:last + 1], f[:last + 1]
    return -np.hypot(np.diff(f) / (f[-1] - f[0]), np.diff(m)).sum()


def ldlj(v, rate):
    dt = 1 / rate
    return -np.log((len(v) * dt) ** 3 / v.max() ** 2 * (np.diff(v, 2) ** 2 / dt**4).sum() * dt)


def measures(path, rate, still):
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    v = steps * rate
    return dict(
        path=path.ravel(), rate_hz=rate, static_speed_m_s=still,
        length_m=steps.sum(), peak_speed_m_s=v.max(), static_share=(v < still).mean(),
        sparc=sparc(v, rate), ldlj_v=ldlj(v, rate),
    )


def warped(a, b, band):
    d = cdist(a, b)
    g = np.full((len(a), len(b)), np.inf)
    for i in range(len(a)):
        for j in range(len(b)):
            if band is not None and abs(i - j) > band:
                continue
            if i == j == 0:
                g[0, 0] = 2 * d[0, 0]
                continue
            ways = [g[i - 1, j] + d[i, j]] if i else []
            ways += [g[i, j - 1] + d[i, j]] if j else []
            ways += [g[i - 1, j - 1] + 2 * d[i, j]] if i and j else []
            g[i, j] = min(ways)
    return g[-1, -1] / (len(a) + len(b))


def wander(n, dim, scale=0.02):
    """Smooth, with some noise, in metres."""
    knots = rng.normal(0, scale, (6, dim))
    t = np.linspace(0, 5, n)
    return np.round(np.stack([np.interp(t, range(6), k) for k in knots.T], 1) + rng.normal(0, 2e-4, (n, dim)), 7)


def reach(n, rate):
    """Minimum jerk over 8 cm between two rests."""
    s = np.clip((np.arange(n) / rate - 0.2) / 0.7, 0, 1)
    p = 10 * s**3 - 15 * s**4 + 6 * s**5
    return np.round(np.outer(p, [0.06, -0.04, 0.03]), 9)


paths = [
    measures(reach(121, 100.0), 100.0, 0.005),
    measures(reach(131, 120.0), 120.0, 0.02),
    measures(wander(100, 3), 100.0, 0.05),
    measures(wander(64, 3), 60.0, 0.05),
    measures(wander(18, 3), 240.0, 0.1),
]
warpings = []
for n, m, band in [(40, 40, None), (40, 40, 0), (40, 40, 5), (30, 37, None), (30, 37, 7), (37, 30, 12), (1, 9, None)]:
    a, b = wander(n, 15), wander(m, 15)
    fingers = [warped(a[:, 3 * f:3 * f + 3], b[:, 3 * f:3 * f + 3], band) for f in range(5)]
    warpings.append(dict(a=a.ravel(), b=b.ravel(), band=band, distance_m=warped(a, b, band), by_finger_m=fingers))

plain = lambda x: x.tolist() if isinstance(x, np.ndarray) else float(x)
json.dump(dict(paths=paths, warpings=warpings), sys.stdout, default=plain)
print()
