"""Reference values for bootstrap intervals: draws by ChaCha8 written out here, statistics by NumPy on the
rows of each draw put together.

    python make_bootstrap.py > bootstrap.json
"""
import json
import sys

import numpy as np

MEASURES = [
    lambda v: v.mean(),
    lambda v: np.sqrt((v**2).mean()),
    lambda v: np.quantile(v, 0.5),
    lambda v: np.quantile(v, 0.75),
    lambda v: np.quantile(v, 0.95),
]


def chacha8(seed, stream, words):
    """The first 64-bit words of the stream, by Bernstein's definition with four double rounds."""
    mask = 0xFFFFFFFF
    low_high = lambda x: [x & mask, x >> 32]
    out, counter = [], 0
    while len(out) < 2 * words:
        start = [0x61707865, 0x3320646E, 0x79622D32, 0x6B206574] + low_high(seed) + [0] * 6
        start += low_high(counter) + low_high(stream)
        x = list(start)

        def quarter(a, b, c, d):
            for into, other, target, turn in ((a, b, d, 16), (c, d, b, 12), (a, b, d, 8), (c, d, b, 7)):
                x[into] = (x[into] + x[other]) & mask
                v = x[target] ^ x[into]
                x[target] = ((v << turn) | (v >> (32 - turn))) & mask

        for _ in range(4):
            for k in range(4):
                quarter(k, 4 + k, 8 + k, 12 + k)
            for k in range(4):
                quarter(k, 4 + (k + 1) % 4, 8 + (k + 2) % 4, 12 + (k + 3) % 4)
        out += [(a + b) & mask for a, b in zip(x, start)]
        counter += 1
    return [out[2 * k] | out[2 * k + 1] << 32 for k in range(words)]


def taken(seed, draw, clusters):
    return [word * clusters >> 64 for word in chacha8(seed, draw, clusters)]


def estimate(value, drawn, confidence):
    drawn = np.array(drawn)
    tail = (1 - confidence) / 2
    return dict(
        value=value, standard_error=drawn.std(ddof=1), percentile=np.quantile(drawn, [tail, 1 - tail])
    )


def case(first, second, draws, seed, confidence):
    n = len(first)
    picks = [list(range(n))]
    picks += [taken(seed, d, n) for d in range(draws)]
    pooled = lambda rows, pick: np.concatenate([rows[c] for c in pick])
    result = dict(first=first, second=second, draws=draws, seed=str(seed), confidence=confidence,
                  intervals=[], differences=[], relative=[])
    for measure in MEASURES:
        a, b = (np.array([measure(pooled(rows, pick)) for pick in picks]) for rows in (first, second))
        for key, v in (("intervals", a), ("differences", a - b), ("relative", (a - b) / b)):
            result[key].append(estimate(v[0], v[1:], confidence))
    return result


rng = np.random.default_rng(11)


def sample(clusters, low, high):
    """One-sided rows whose level differs from cluster to cluster, and others on the same clusters."""
    level = rng.lognormal(0, 0.5, clusters)
    rows = [np.round(l * rng.gamma(2, 1, rng.integers(low, high)), 4) for l in level]
    others = [np.round(l * rng.gamma(2, 1.3, rng.integers(low, high)), 4) for l in level]
    return rows, others


cases = [
    case(*sample(12, 5, 9), 400, 7, 0.95),
    case(*sample(70, 3, 6), 300, 2**63 + 12345, 0.9),
    case(*sample(30, 20, 21), 500, 0, 0.99),
]
draws = [
    dict(clusters=c, seed=str(s), draw=d, times=np.bincount(taken(s, d, c), minlength=c))
    for c, s, d in [(1, 0, 0), (5, 1, 0), (5, 1, 1), (119, 2024, 1999), (40, 2**64 - 1, 3), (300, 77, 2**33)]
]
plain = lambda x: x.tolist() if isinstance(x, np.ndarray) else float(x)
json.dump(dict(cases=cases, draws=draws), sys.stdout, default=plain)
print()
