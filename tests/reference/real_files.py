#!/usr/bin/env python3
"""What is in the vendor files of the corpus, by another reader: csv, NumPy, SciPy.

    python3 real_files.py CORPUS > real_files.json

For each file: samples, rate, start, and for each marker and body in the file's order how many of
its samples are there, how many gaps it has, the longest of them, and the first and last sample that
is there, with its value (metres; for a body position and quaternion x, y, z, w).
"""
import csv
import json
import sys
from datetime import datetime, timezone
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

METRES = {"Meters": 1.0, "Centimeters": 0.01, "Millimeters": 0.001, "cm": 0.01}


def number(cell):
    return float(cell) if cell.strip() else np.nan


def nanos(text, afternoon=False):
    """Local time as it stands, in nanoseconds since 1970 UTC; milliseconds are all there is."""
    t = datetime.strptime(text, "%Y-%m-%d %H.%M.%S.%f").replace(tzinfo=timezone.utc)
    t = t.replace(hour=t.hour % 12 + 12) if afternoon else t
    return int(t.timestamp()) * 10**9 + t.microsecond * 1000


def track(name, kind, values):
    """One entity: rows of values, NaN in all columns where it is missing."""
    there = np.isfinite(values).all(axis=1)
    edges = np.flatnonzero(np.diff(np.r_[1, there.astype(int), 1]))
    lengths = edges[1::2] - edges[::2]
    at = np.flatnonzero(there)
    sample = lambda k: [int(k), [float(f"{v:.12g}") for v in values[k]]]
    return {
        "name": name, "kind": kind, "present": int(there.sum()), "gaps": len(lengths),
        "longest_gap": int(lengths.max(initial=0)),
        "first": sample(at[0]) if len(at) else None, "last": sample(at[-1]) if len(at) else None,
    }


def on_grid(frames, values):
    """Rows on the even grid of their frame numbers."""
    grid = np.full((int(frames[-1] - frames[0]) + 1, values.shape[1]), np.nan)
    grid[(frames - frames[0]).astype(int)] = values
    return grid


def motive(path, unit=None, order=None, start=None):
    rows = list(csv.reader(path.open(newline="", encoding="utf-8")))
    facts = dict(zip(rows[0][::2], rows[0][1::2]))
    axes = next(k for k, row in enumerate(rows) if row and row[0] == "Frame")
    types, names, ids, kinds = rows[axes - 4:axes]
    width = len(rows[axes])
    pad = lambda row: row + [""] * (width - len(row))
    types, names, ids, kinds, labels = map(pad, (types, names, ids, kinds, rows[axes]))
    data = np.array([[number(c) for c in pad(row)] for row in rows[axes + 1:] if any(row)])
    grid = on_grid(data[:, 0], data)
    metres = METRES[facts.get("Length Units") or unit] if types[2:] else 1.0
    order = facts.get("Rotation Type") or order

    entities, latest = [], {}
    for c in range(2, width):
        if not types[c]:
            continue
        key, place = (types[c], names[c], ids[c]), (kinds[c], labels[c])
        if key not in latest or place in latest[key]:
            latest[key] = {}
            entities.append((key, latest[key]))
        latest[key][place] = c
    out = {"markers": [], "bodies": []}
    for (kind, name, _), columns in entities:
        position = grid[:, [columns["Position", a] for a in "XYZ"]] * metres
        if kind in ("Rigid Body", "Bone"):
            if order == "Quaternion":
                q = grid[:, [columns["Rotation", a] for a in "XYZW"]]
                q = q / np.linalg.norm(q, axis=1, keepdims=True)
            else:
                angles = grid[:, [columns["Rotation", a] for a in order]]
                q = Rotation.from_euler(order, angles, degrees=True).as_quat()
            what = {"Rigid Body": "rigid_body", "Bone": "bone"}[kind]
            out["bodies"].append(track(name, what, np.c_[position, q]))
        else:
            what = "unlabelled" if name.startswith("Unlabeled") else "labelled"
            what = "rigid_body_marker" if kind == "Rigid Body Marker" else what
            out["markers"].append(track(name, what, position))
    return {"samples": len(grid), "rate_hz": float(facts["Export Frame Rate"]),
            "start_unix_nanos": start, **out}


def row_typed(path, rate_hz):
    rows = list(csv.reader(path.open(newline="", encoding="utf-8")))
    frames = [k for k, row in enumerate(rows) if row and row[0] == "frame"]
    defined = [row for row in rows[:frames[0]] if row[0] in ("rigidbody", "trackable")]
    n = len(frames)
    bodies = {row[2]: np.full((n, 7), np.nan) for row in defined}
    fitted = {row[2]: np.full((n, int(row[3]), 3), np.nan) for row in defined}
    seen = {row[2]: np.full((n, int(row[3]), 3), np.nan) for row in defined}
    others = {}
    for k, (at, end) in enumerate(zip(frames, frames[1:] + [len(rows)])):
        row, claimed = rows[at], set()
        for line in rows[at + 1:end]:
            body, count = line[4], int(line[6])
            each = (len(line) - 8) // count - 5
            cells = np.array(line[7:7 + count * each], float).reshape(count, each)
            places = np.array(line[7 + count * each:7 + count * (each + 3)], float).reshape(count, 3)
            seen[body][k] = places
            claimed |= {tuple(p) for p in places}
            if line[5] == "0":
                fitted[body][k] = cells[:, :3]
        count = int(row[3])
        for b in range(count):
            cells = row[4 + 11 * b:15 + 11 * b]
            bodies[cells[0]][k] = np.array(cells[1:8], float)
        markers = row[4 + 11 * count:]
        each = (len(markers) - 1) // max(int(markers[0]), 1)
        nameless = 0
        for m in range(int(markers[0])):
            cells = markers[1 + each * m:1 + each * (m + 1)]
            position = tuple(map(float, cells[:3]))
            if position in claimed:
                continue
            if each == 4:  # no names, and the same ID everywhere
                nameless += 1
                key = f"Unlabeled {nameless}"
            else:
                key = cells[4]
            others.setdefault(key, np.full((n, 3), np.nan))[k] = position
    out = {"markers": [], "bodies": []}
    for row in defined:
        name, body = row[1], row[2]
        pose = bodies[body]
        pose[:, 3:] /= np.linalg.norm(pose[:, 3:], axis=1, keepdims=True)
        out["bodies"].append(track(name, "rigid_body", pose))
        for m in range(int(row[3])):
            out["markers"].append(track(f"{name}-Marker {m + 1}", "rigid_body_marker", fitted[body][:, m]))
            out["markers"].append(track(f"{name}-Marker {m + 1}", "labelled", seen[body][:, m]))
    for name, values in others.items():
        out["markers"].append(track(name, "unlabelled", values))
    return {"samples": n, "rate_hz": rate_hz, "start_unix_nanos": 0, **out}


def qualisys(path):
    lines = path.read_text().split("\n")
    head = next(k for k, line in enumerate(lines) if line.startswith("Frame\t"))
    facts = dict(line.rstrip("\r").split("\t", 1) for line in lines[:head])
    data = [line.rstrip("\r").split("\t") for line in lines[head + 1:] if line.strip()]
    data = np.array([[number(c) for c in row] for row in data])
    names = facts["MARKER_NAMES"].split("\t")
    stamp = facts["TIME_STAMP"].split("\t")[0]
    start = datetime.strptime(stamp, "%Y-%m-%d, %H:%M:%S.%f").strftime("%Y-%m-%d %H.%M.%S.%f")
    return {"samples": len(data), "rate_hz": float(facts["FREQUENCY"]), "start_unix_nanos": nanos(start),
            "markers": [track(name, "labelled", data[:, 2 + 3 * m:5 + 3 * m] / 1000)
                        for m, name in enumerate(names)], "bodies": []}


def main():
    real = Path(sys.argv[1]) / "real"
    m = real / "motive"
    euler = ["--units", "cm", "--rotation-order", "XYZ"]
    # Start times are local to the recording computer and in its language, so they stand here as a
    # person reads them.
    noon = nanos("2023-11-28 10.27.58.765", afternoon=True)
    files = {
        "motive/v1_olin.csv": ([], row_typed(m / "v1_olin.csv", 250.0)),
        "motive/v1.1_olin.csv": ([], row_typed(m / "v1.1_olin.csv", 120.0)),
        "motive/v1.21_cmuphyscomp.csv": ([], motive(
            m / "v1.21_cmuphyscomp.csv", start=nanos("2016-01-05 03.49.50.755", afternoon=True))),
        "motive/v1.22_euler_rigid-body-motion.csv": (euler, motive(
            m / "v1.22_euler_rigid-body-motion.csv", "cm", "XYZ",
            nanos("2020-06-16 07.51.41.245", afternoon=True))),
        "motive/v1.23_empty_ha5dzs.csv": ([], motive(m / "v1.23_empty_ha5dzs.csv", start=noon)),
        "motive/v1.23_gaps_aolab.csv": ([], motive(
            m / "v1.23_gaps_aolab.csv", start=nanos("2021-04-06 11.47.50.410"))),
        "motive/v1.23_markers_mm_360hz_ha5dzs.csv": ([], motive(
            m / "v1.23_markers_mm_360hz_ha5dzs.csv", start=noon)),
        "motive/v1.23_quality_parse_optitrack_csv.csv": ([], motive(
            m / "v1.23_quality_parse_optitrack_csv.csv", start=nanos("2020-01-16 07.07.59.330"))),
        "motive/v1.23_trimmed_aolab.csv": ([], motive(
            m / "v1.23_trimmed_aolab.csv", start=nanos("2021-04-06 11.51.13.103"))),
        "hand/recording.tsv": ([], qualisys(real / "hand" / "recording.tsv")),
    }
    out = []
    for name, (options, take) in files.items():
        entities = {key: ",\n".join("    " + json.dumps(e) for e in take.pop(key)) for key in ("markers", "bodies")}
        facts = json.dumps({"options": options, **take})[1:-1]
        lists = ",\n".join(f'   "{key}": [\n{text}\n   ]' for key, text in entities.items())
        out.append(f" {json.dumps(name)}: {{\n   {facts},\n{lists}\n }}")
    print("{\n" + ",\n".join(out) + "\n}")


main()
