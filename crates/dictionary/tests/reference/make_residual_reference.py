#!/usr/bin/env python3
"""Writes residual.json: what plain NumPy and SciPy make of the segments described here.

    python make_residual_reference.py      # NumPy 2.4, SciPy 1.17, scikit-learn 1.9

The inputs are not in the file: both sides draw them from the same integer hash. Everything is
computed from the formulas, with loops where those are the plainest: features one by one, distances
pair by pair, the weights with a general minimiser of the sum of distances.
"""
import json
import pathlib

import numpy as np
from scipy.optimize import minimize
from sklearn.covariance import ledoit_wolf

SAMPLES, RATE, PRIMITIVES = 8, 20.0, 5
TAKES, PER_TAKE, QUERIES = 3, 16, 2
DURATION = (SAMPLES - 1) / RATE
LEVER = 0.025
HAND_WIDTHS = (1.4, 2.0, 2.8, 4.0)
FINGER_WIDTHS = (0.35, 0.5, 0.7, 1.0)


def uniform(*key):
    """From -1 to 1."""
    h = 0
    for part in key:
        h = ((h ^ part) * 2654435761 + 1013904223) % 2**32
        h ^= h >> 15
        h = h * 2246822519 % 2**32
        h ^= h >> 13
    return h / 2**31 - 1.0


def end_conditions(i, with_object):
    first = [0.05 * uniform(1, i, c) for c in range(15)]
    last = [first[c] + 0.02 * uniform(2, i, c) for c in range(15)]
    velocities = [0.06 * uniform(3, i, c) for c in range(30)]
    x = first + last + velocities
    if with_object:
        first = [0.1 + 0.02 * uniform(4, i, c) for c in range(3)]
        x += first + [first[c] + 0.03 * uniform(5, i, c) for c in range(3)]
        x += [0.01 * uniform(6, i, c) for c in range(3)]
    return np.array(x)


def coordinates(with_object):
    return 21 if with_object else 15


def smooth(x, with_object):
    """Samples x coordinates."""
    out = np.zeros((SAMPLES, coordinates(with_object)))
    for t in range(SAMPLES):
        s = t / (SAMPLES - 1)
        for c in range(15):
            p0, p1, v0, v1 = x[c], x[15 + c], x[30 + c], x[45 + c]
            a = DURATION * v0
            b = 3 * (p1 - p0) - DURATION * (2 * v0 + v1)
            d = 2 * (p0 - p1) + DURATION * (v0 + v1)
            out[t, c] = p0 + a * s + b * s**2 + d * s**3
        if with_object:
            for a in range(3):
                out[t, 15 + a] = x[60 + a] + s * (x[63 + a] - x[60 + a])
                out[t, 18 + a] = s * x[66 + a]
    return out


def deviation(i, x, with_object):
    out = np.zeros((SAMPLES, coordinates(with_object)))
    for t in range(SAMPLES):
        s = t / (SAMPLES - 1)
        bump = 16 * s**2 * (1 - s) ** 2
        for c in range(15):
            own = 0.3 * (x[15 + c] - x[c]) + 0.1 * DURATION * (1 - 2 * s) * x[30 + c]
            local = 0.004 * np.sin(60.0 * (x[15 + c // 3 * 3] - x[c // 3 * 3]) + c)
            noise = 0.002 * uniform(7, i, c) + 0.001 * s * uniform(8, i, c)
            out[t, c] = bump * (own + local + noise)
        if with_object:
            for a in range(6):
                moved = x[63 + a] - x[60 + a] if a < 3 else x[63 + a]
                out[t, 15 + a] = bump * (0.2 * moved + 0.001 * uniform(9, i, a))
    return out


def features(x, with_object):
    """Features of each finger's motion, of its place, of the object's motion, of its place."""
    motion, place = [], []
    for f in range(5):
        c = slice(3 * f, 3 * f + 3)
        p0, p1, v0, v1 = x[:15][c], x[15:30][c], x[30:45][c], x[45:60][c]
        motion.append(np.concatenate([p1 - p0 - DURATION * (v0 + v1) / 2, p1 - p0, v0, v1]))
        place.append(p0)
    object_motion, object_place = np.zeros(0), np.zeros(0)
    if with_object:
        object_motion = np.concatenate([x[63:66] - x[60:63], x[66:69]])
        object_place = x[60:63]
    return motion, place, object_motion, object_place


def part_rows(part):
    """Coordinates of a finger, or of the object."""
    return range(3 * part, 3 * part + 3) if part < 5 else range(15, 21)


class Model:
    """Regression over some demonstrations, in the space of deviations projected on primitives."""

    def __init__(self, ends, deviations, project, with_object):
        self.with_object, self.project = with_object, project
        self.ends = ends
        self.phi = self.profiles(ends, deviations)
        self.answers = [project(d) - project(self.profile(x)) for x, d in zip(ends, deviations)]
        all_features = [features(x, with_object) for x in ends]
        flat = np.array([np.concatenate([np.concatenate(m), np.concatenate(p), om, op]) for m, p, om, op in all_features])
        self.mean, self.std = flat.mean(0), flat.std(0)
        self.standard = (flat - self.mean) / self.std

    def inputs(self, x, c):
        if c < 15:
            return 0, [x[15 + c] - x[c], DURATION * x[30 + c], DURATION * x[45 + c]]
        if c < 18:
            return 1, [x[63 + c - 15] - x[60 + c - 15]]
        return 2, [x[66 + c - 18]]

    def profiles(self, ends, deviations):
        """Ridge regression for each group of coordinates and each sample by itself."""
        out = []
        for group in range(3 if self.with_object else 1):
            rows, answers = [], []
            for x, d in zip(ends, deviations):
                for c in range(coordinates(self.with_object)):
                    g, inputs = self.inputs(x, c)
                    if g == group:
                        rows.append(inputs)
                        answers.append(d[:, c])
            a, b = np.array(rows), np.array(answers)
            k = a.shape[1]
            ridge = 1e-3 * (a**2).sum() / k
            # As more rows of the least squares.
            a = np.vstack([a, np.sqrt(ridge) * np.eye(k)])
            b = np.vstack([b, np.zeros((k, SAMPLES))])
            out.append(np.linalg.lstsq(a, b, rcond=None)[0])
        return out

    def profile(self, x):
        out = np.zeros((SAMPLES, coordinates(self.with_object)))
        for c in range(out.shape[1]):
            g, inputs = self.inputs(x, c)
            out[:, c] = np.array(inputs) @ self.phi[g]
        return out

    def kernel_mean(self, squared, width):
        exponents = (squared - squared.min()) / (2 * width**2)
        kernel = np.where(exponents < 16, np.exp(-exponents), 0)
        return sum(k * a for k, a in zip(kernel, self.answers)) / kernel.sum()

    def parts(self, x, hand_width, finger_width):
        m, p, om, op = features(x, self.with_object)
        query = (np.concatenate([np.concatenate(m), np.concatenate(p), om, op]) - self.mean) / self.std
        squares = (self.standard - query) ** 2
        hand = self.kernel_mean(squares.sum(1), hand_width)
        finger = np.zeros_like(hand)
        about_object = squares[:, 75:81].sum(1)
        for f in range(5):
            own = squares[:, 12 * f : 12 * f + 12].sum(1) + about_object
            rows = list(part_rows(f))
            finger[:, rows] = self.kernel_mean(own, finger_width)[:, rows]
        if self.with_object:
            finger[:, 15:] = hand[:, 15:]
        return self.project(self.profile(x)), hand, finger


def blend(wanted, predictions):
    """Weights of least sum of distances, by several starts of a general minimiser."""
    k = len(predictions)
    predictions = np.array(predictions)

    def value(w):
        left = wanted - np.tensordot(w, predictions, 1)
        distance = np.sqrt((left**2).sum(-1)) + 1e-300
        return distance.mean(), np.array([-(left * p).sum(-1) / distance for p in predictions]).reshape(k, -1).mean(1)

    scale = value(np.zeros(k))[0]
    best = (value(np.zeros(k))[0], np.zeros(k))
    for start in (np.zeros(k), np.full(k, 0.5), np.ones(k)):
        found = minimize(lambda w: tuple(v / scale for v in value(w)), start, jac=True, method="L-BFGS-B", bounds=[(0, None)] * k, options=dict(ftol=1e-15, gtol=1e-10, maxiter=2000))
        best = min(best, (value(found.x)[0], found.x), key=lambda pair: pair[0])
    return best[1], best[0]


def points(deviations):
    """Segments x samples x fingers x axes."""
    return np.array([d[:, :15].reshape(SAMPLES, 5, 3) for d in deviations])


def second_moment(vectors):
    covariance, _ = ledoit_wolf(np.array(vectors), assume_centered=True)
    return covariance


def case(with_object):
    count = TAKES * PER_TAKE
    ends = [end_conditions(i, with_object) for i in range(count)]
    deviations = [deviation(i, x, with_object) for i, x in enumerate(ends)]
    for d in deviations:
        d[0] = d[-1] = 0.0

    # Primitives of each part, from the singular vectors of its deviations.
    blocks = []
    for part in range(6 if with_object else 5):
        matrix = np.array([d[:, part_rows(part)].reshape(-1) for d in deviations]).T
        blocks.append(np.linalg.svd(matrix, full_matrices=False)[0][:, :PRIMITIVES])

    def activations(d):
        return np.concatenate([b.T @ d[:, part_rows(p)].reshape(-1) for p, b in enumerate(blocks)])

    def of_activations(z):
        out = np.zeros((SAMPLES, coordinates(with_object)))
        for p, b in enumerate(blocks):
            own = z[PRIMITIVES * p : PRIMITIVES * (p + 1)]
            out[:, part_rows(p)] = (b @ own).reshape(SAMPLES, -1)
        return out

    def project(d):
        return of_activations(activations(d))

    unexplained = np.mean([(points([d]) - points([project(d)])) ** 2 for d in deviations])

    # Leave a take out, predict it from the others.
    predicted = []
    for take in range(TAKES):
        known = [i for i in range(count) if i // PER_TAKE != take]
        model = Model([ends[i] for i in known], [deviations[i] for i in known], project, with_object)
        for i in range(take * PER_TAKE, (take + 1) * PER_TAKE):
            predicted.append([model.parts(ends[i], h, f) for h, f in zip(HAND_WIDTHS, FINGER_WIDTHS)])
    wanted = points(deviations)
    profile = points([p[0][0] for p in predicted])
    by_hand = [points([p[w][1] for p in predicted]) for w in range(4)]
    by_finger = [points([p[w][2] for p in predicted]) for w in range(4)]
    hand = int(np.argmin([blend(wanted, [profile, b])[1] for b in by_hand]))
    finger = int(np.argmin([blend(wanted, [profile, b])[1] for b in by_finger]))
    weights, _ = blend(wanted, [profile, by_hand[hand], by_finger[finger]])

    def errors(w):
        expected = w[0] * profile + w[1] * by_hand[hand] + w[2] * by_finger[finger]
        return np.sqrt(((wanted - expected) ** 2).sum(-1)).mean((1, 2))

    gains = errors(np.zeros(3)) - errors(weights)
    standard_error = gains.std(ddof=1) / np.sqrt(len(gains))
    weights = weights * max(0.0, 1.0 - (standard_error / gains.mean()) ** 2)
    gains = errors(np.zeros(3)) - errors(weights)

    # What is left of the activations, and how far the corridors have to reach.
    left, remainders = [], []
    for i, parts in enumerate(predicted):
        expected = weights[0] * parts[0][0] + weights[1] * parts[hand][1] + weights[2] * parts[finger][2]
        remainders.append(activations(deviations[i] - expected))
        left.append(deviations[i] - expected)
    covariance = second_moment(remainders)
    basis = np.array([of_activations(z).reshape(-1) for z in np.eye(len(covariance))]).T
    spread = basis @ covariance @ basis.T
    distances = []
    for d in left:
        for t in range(SAMPLES):
            for f in range(5):
                rows = [t * coordinates(with_object) + 3 * f + a for a in range(3)]
                local = spread[np.ix_(rows, rows)] + unexplained * np.eye(3)
                error = d[t, 3 * f : 3 * f + 3]
                distances.append(np.sqrt(error @ np.linalg.solve(local, error)))
    widths = [float(np.quantile(distances, share, method="inverted_cdf")) for share in (0.5, 0.95)]

    x = np.array(ends)
    std = x.std(0)
    ends_covariance, _ = ledoit_wolf(x / std)
    whole = Model(ends, deviations, project, with_object)
    queries = []
    for q in range(QUERIES):
        query = end_conditions(1000 + q, with_object)
        parts = whole.parts(query, HAND_WIDTHS[hand], FINGER_WIDTHS[finger])
        expected = sum(w * p for w, p in zip(weights, parts))
        queries.append(dict(
            parts=[column(p) for p in parts], expected=column(expected),
            smooth=column(smooth(query, with_object)),
        ))
    return dict(
        unexplained_m2=float(unexplained), hand_width=HAND_WIDTHS[hand], finger_width=FINGER_WIDTHS[finger],
        weights=weights.tolist(), smooth_error_m=float(errors(np.zeros(3)).mean()), error_m=float(errors(weights).mean()),
        standard_error_m=float(gains.std(ddof=1) / np.sqrt(len(gains))),
        widths=widths, variances_m2=column(np.diag(spread).reshape(SAMPLES, -1)),
        ends_mean=x.mean(0).tolist(), ends_variances=np.diag(ends_covariance * np.outer(std, std)).tolist(),
        queries=queries,
    )


def column(table):
    """Samples x coordinates in the order of a segment's column: fingertips, then object."""
    return [float(f"{v:.12g}") for v in np.concatenate([table[:, :15].reshape(-1), table[:, 15:].reshape(-1)])]


path = pathlib.Path(__file__).with_name("residual.json")
path.write_text(json.dumps(dict(hand=case(False), object=case(True)), separators=(",", ":")) + "\n")
print(path, path.stat().st_size, "bytes")
