#!/usr/bin/env python3
"""Makes events.json: contacts, states, phases and slip of random takes, by regular expressions and NumPy.

    python make_events.py > events.json

Contacts of a finger are a string: 1 in contact, 0 not, ? not known.
"""
import json
import re
import sys
from collections import Counter

import numpy as np

rng = np.random.default_rng(5)


def finger(n, stay):
    """Holds for long and lets go for short times, with chatter and gaps."""
    out = ""
    while len(out) < n:
        out += "1" * rng.integers(3, stay) + "0" * rng.integers(1, 9)
        out += rng.choice(["", "", "10", "101", "?", "??"])
    return out[:n]


def debounced(s, least):
    """Within what is known a run that is too short is drawn to the value before it, from the left."""
    def part(known):
        pieces = [m.group() for m in re.finditer(r"0+|1+", known)]
        done = pieces[0]
        for k, piece in enumerate(pieces[1:], 1):
            keep = len(piece) >= least or k == len(pieces) - 1
            done += piece if keep else done[-1] * len(piece)
        return done
    return re.sub(r"[01]+", lambda m: part(m.group()), s)


def contacts(s):
    return [
        [m.start(), m.end(), s[m.start() - 1:m.start()] == "0", s[m.end():m.end() + 1] == "0"]
        for m in re.finditer("1+", s)
    ]


def runs(keys):
    edges = [0] + [k for k in range(1, len(keys)) if keys[k] != keys[k - 1]] + [len(keys)]
    return [(keys[a], a, b) for a, b in zip(edges, edges[1:])]


def bits(columns, k):
    c = [s[k] for s in columns]
    return None if "?" in c else sum(1 << f for f in range(5) if c[f] == "1")


count = lambda state: bin(state).count("1")


def common(states):
    return int(np.bitwise_and.reduce(np.array(states)))


def phases(columns, pads, rate, needed, min_s, max_s):
    steady = [debounced(s, round(min_s * rate)) for s in columns]
    states = [bits(steady, k) for k in range(len(steady[0]))]
    gaits, gaiting = [], set()
    for f, s in enumerate(steady):
        for m in re.finditer(r"(?<=1)0+(?=1)", s):
            a, b = m.span()
            if b - a > round(max_s * rate) or any(x is None or count(x) < needed for x in states[a:b]):
                continue
            d = np.linalg.norm(pads[b, f] - pads[a - 1, f])
            gaits.append([a, f, b, common(states[a:b]), None if np.isnan(d) else d])
            gaiting |= set(range(a, b))
    keys = [
        None if x is None else ("none", 0) if count(x) < needed else ("gaiting", 0) if k in gaiting else ("grasp", x)
        for k, x in enumerate(states)
    ]
    all_runs = runs(keys)
    found = []
    for i, (key, a, b) in enumerate(all_runs):
        if key is None:
            continue
        kind = {"gaiting": "finger_gaiting", "grasp": "in_grasp", "none": "no_grasp"}[key[0]]
        around = all_runs[i - 1][0] if i else None, all_runs[i + 1][0] if i + 1 < len(all_runs) else None
        if kind == "no_grasp" and None not in around:
            kind = "regrasp"
        found.append([kind, a, b, common(states[a:b])])
    return dict(phases=found, gaits=sorted(gaits, key=lambda g: g[:2]))


def on_box(p, half):
    """Nearest point of a box's surface."""
    q = np.clip(p, -half, half)
    if (np.abs(p) < half).all():
        axis = np.argmin(half - np.abs(p))
        q[axis] = np.copysign(half[axis], p[axis])
    return q


def slip(pad, a, b, half):
    q = np.array([on_box(p, half) if np.isfinite(p).all() else [np.nan] * 3 for p in pad[a:b]])
    seen = np.isfinite(q[:, 0])
    if not (seen[1:] & seen[:-1]).any():
        return None
    known = q[seen]
    return np.linalg.norm(known[-1] - known[0])


def take(n, rate, needed, min_s, max_s):
    columns = [finger(n, stay) for stay in (60, 30, 40, 30, 50)]
    pads = np.round(np.cumsum(rng.normal(0, 4e-4, (n, 5, 3)), 0) + rng.normal(0, 0.02, (5, 3)), 6)
    pads[rng.random((n, 5)) < 0.02] = np.nan
    states = [bits(columns, k) for k in range(n)]
    state_runs = runs(states)
    half = np.array([0.02, 0.025, 0.03])
    return dict(
        rate_hz=rate, fingers=columns, min_fingers=needed, min_duration_s=min_s, max_lift_s=max_s,
        pads_m=[[None if np.isnan(p).any() else p for p in sample] for sample in pads],
        debounced=[debounced(s, round(min_s * rate)) for s in columns],
        contacts=[contacts(s) for s in columns],
        slip=[[slip(pads[:, f], a, b, half) for a, b, *_ in contacts(s)] for f, s in enumerate(columns)],
        edges_m=2 * half,
        state_samples=sorted([k, v] for k, v in Counter(x for x in states if x is not None).items()),
        transitions=sorted([a, b, v] for (a, b), v in Counter(
            (a[0], b[0]) for a, b in zip(state_runs, state_runs[1:]) if None not in (a[0], b[0])).items()),
        **phases(columns, pads, rate, needed, min_s, max_s),
    )


takes = [take(300, 100.0, 3, 0.03, 0.06), take(250, 120.0, 2, 0.0, 1.0), take(200, 60.0, 4, 0.05, 0.2)]
plain = lambda x: x.tolist() if isinstance(x, np.ndarray) else x.item()
json.dump(takes, sys.stdout, default=plain)
print()
