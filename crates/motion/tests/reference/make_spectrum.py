"""Reference values for the power spectral density, by SciPy's welch.

    python make_spectrum.py > spectrum.json      # SciPy 1.17, NumPy 2.4
"""
import json
import sys

import numpy as np
from scipy.signal import welch

rng = np.random.default_rng(7)
cases = []
# Even and odd windows, stretches that do not end with a window, one of a single window.
for samples, window, rate in [(400, 64, 100.0), (333, 51, 240.0), (64, 64, 60.0)]:
    t = np.arange(samples) / rate
    x = np.round(0.08 + 0.01 * np.sin(2 * np.pi * 3.7 * t) + 0.002 * t + rng.normal(0, 3e-4, samples), 7)
    f, p = welch(x, rate, window="hann", nperseg=window, noverlap=window // 2, detrend="constant", scaling="density")
    cases.append(dict(rate_hz=rate, window=window, signal=x.tolist(), frequency_hz=f.tolist(), density=p.tolist()))
json.dump(cases, sys.stdout, separators=(",", ":"))
print()
