"""Reference values for gaps, hand frame and filters, by NumPy and SciPy.

    python make.py > motion.json

Lengths in metres, 100 Hz, quaternions x y z w. The median is by brute force, the fill by divided
differences through four samples, the rest is SciPy's: rotations, savgol_filter (edges as its default
mode "interp"), sosfiltfilt (odd extension of its default length) on a Butterworth design whose
cut-off is moved so that both passes together lose 3 dB at the stated one.
"""
import json
import sys

import numpy as np
from scipy.interpolate import KroghInterpolator
from scipy.signal import butter, savgol_filter, sosfiltfilt
from scipy.spatial.transform import Rotation

N, RATE, LIMIT = 80, 100.0, 10
rng = np.random.default_rng(11)
t = np.arange(N) / RATE


def wave(size):
    a, f, p = rng.uniform(0.3, 1, 3), rng.uniform(0.5, 3, 3), rng.uniform(0, 6, 3)
    return size * (a * np.sin(2 * np.pi * f * t[:, None] + p)) + rng.normal(0, 2e-4, (N, 3))


def pose(size, turn):
    q = Rotation.from_rotvec(wave(turn) + rng.uniform(-1.5, 1.5, 3)).as_quat()
    q[rng.random(N) < 0.3] *= -1  # capture software flips signs between frames
    return np.round(wave(size), 6), q / np.linalg.norm(np.round(q, 9), axis=1, keepdims=True)


hand_p, hand_q = pose(0.2, 0.8)
object_p, object_q = pose(0.05, 1.2)
thumb, little = np.round(wave(0.03) + 0.1, 6), np.round(wave(0.03) - 0.1, 6)
offset = np.array([0.001, -0.02, 0.003])

hand_p[50:54] = hand_q[50:54] = np.nan  # short: filled, and with it everything in the hand's frame
thumb[20:27] = np.nan  # short: filled
thumb[28:30] = np.nan  # one sample after it: a parabola here, and one less support there
little[54:66] = np.nan  # long: stays
little[:2] = np.nan  # at the end: stays
inputs = dict(hand_p=hand_p, hand_q=hand_q, object_p=object_p, object_q=object_q, thumb=thumb, little=little)
inputs = {k: v.copy() for k, v in inputs.items()}


def gaps(x):
    missing = np.isnan(x[:, 0])
    edges = np.flatnonzero(np.diff(np.r_[0, missing, 0]))
    return list(zip(edges[::2], edges[1::2])), missing


def supports(x):
    found, missing = gaps(x)
    for a, b in found:
        if a > 0 and b < N and b - a <= LIMIT:
            at = [k for k in (a - 2, a - 1, b, b + 1) if 0 <= k < N and not missing[k]]
            if a >= 2 and missing[a - 2]:
                at = [k for k in at if k != a - 2]
            yield a, b, at


def fill(x):
    out = x.copy()
    for a, b, at in supports(x):
        out[a:b] = KroghInterpolator(at, x[at])(np.arange(a, b))
    return out


def fill_rotation(q):
    out = q.copy()
    for a, b, at in supports(q):
        ref = Rotation.from_quat(q[a - 1])
        turns = (ref.inv() * Rotation.from_quat(q[at])).as_rotvec()
        out[a:b] = (ref * Rotation.from_rotvec(KroghInterpolator(at, turns)(np.arange(a, b)))).as_quat()
    return out


hand_p, hand_q = fill(hand_p), fill_rotation(hand_q)
inverse = Rotation.from_quat(hand_q).inv()
thumb, little = (fill(inverse.apply(tip - hand_p)) for tip in (thumb, little))
centre = object_p + Rotation.from_quat(object_q).apply(offset)
object_p, object_q = inverse.apply(centre - hand_p), (inverse * Rotation.from_quat(object_q)).as_quat()
object_q[0] *= np.sign(object_q[0, 3])
for k in range(1, N):
    object_q[k] *= np.sign(object_q[k] @ object_q[k - 1])


def median(x, n=50):
    before, after = (n // 2, n // 2 - 1) if n % 2 == 0 else (n // 2, n // 2)
    return np.array([np.median(x[max(0, k - before):k + after + 1], axis=0) for k in range(len(x))])


def low_pass(x, cutoff=8.0, order=2):
    w = np.tan(np.pi * cutoff / RATE) / (np.sqrt(2) - 1) ** (1 / (2 * order))
    moved = np.arctan(w) * RATE / np.pi
    sos = butter(order, moved, fs=RATE, output="sos")
    return sosfiltfilt(sos, x, axis=0)


def stretches(x, smooth):
    out = np.full_like(x, np.nan)
    _, missing = gaps(x)
    edges = np.flatnonzero(np.diff(np.r_[0, ~missing, 0]))
    for a, b in zip(edges[::2], edges[1::2]):
        out[a:b] = smooth(x[a:b])
    return out


def unit(q):
    return q / np.linalg.norm(q, axis=1, keepdims=True)


filters = dict(
    none=lambda x: x,
    median_50=median,
    median_7=lambda x: median(x, 7),
    savitzky_golay_9_3=lambda x: savgol_filter(x, 9, 3, axis=0),
    butterworth_8_2=low_pass,
    butterworth_5_3=lambda x: low_pass(x, 5.0, 3),
)
expected = {
    name: dict(thumb=stretches(thumb, f), little=stretches(little, f),
               object_p=stretches(object_p, f), object_q=unit(stretches(object_q, f)))
    for name, f in filters.items()
}


def rounded(x, digits):
    return [[None if np.isnan(v) else float(f"%.{digits}g" % v) for v in row] for row in x]


json.dump(dict(
    rate_hz=RATE, offset=offset.tolist(),
    inputs={k: rounded(v, 17 if k.endswith("q") else 9) for k, v in inputs.items()},
    hand_p=rounded(hand_p, 13), hand_q=rounded(hand_q, 13),
    expected={name: {k: rounded(v, 13) for k, v in tracks.items()} for name, tracks in expected.items()},
), sys.stdout)
print()
