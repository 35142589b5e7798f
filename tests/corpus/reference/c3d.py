"""Values of the C3D file of the corpus by ezc3d.

    python c3d.py CORPUS > c3d.json

with ezc3d 1.7.
"""

import json
import math
import sys

import ezc3d


def read(path):
    file = ezc3d.c3d(path)
    point = file["parameters"]["POINT"]
    unit = {"mm": 1000.0, "m": 1.0}[point["UNITS"]["value"][0].strip()]
    points = file["data"]["points"][:3] / unit
    markers = {}
    for number, label in enumerate(point["LABELS"]["value"]):
        track = points[:, number, :]
        seen = [k for k in range(track.shape[1]) if not math.isnan(track[0, k])]
        markers[label.strip()] = {
            "seen": len(seen),
            "first": [seen[0], *track[:, seen[0]]],
            "middle": [seen[len(seen) // 2], *track[:, seen[len(seen) // 2]]],
            "last": [seen[-1], *track[:, seen[-1]]],
        }
    return {
        "frames": points.shape[2],
        "rate_hz": float(point["RATE"]["value"][0]),
        "markers": markers,
    }


if __name__ == "__main__":
    path = sys.argv[1] + "/real/c3d/walkingOptiTrack.c3d"
    print(json.dumps(read(path), indent=1))
