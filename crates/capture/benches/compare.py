#!/usr/bin/env python3
"""Reading a Motive CSV, beside pandas on the same file.

    pip install pandas
    cargo bench -p inhand-capture --bench compare --no-run     # prints where the program is
    python compare.py PROGRAM take.csv [--rounds 7] [--cores 1,2]

Each round reads the file with pandas.read_csv, as one line of Python does it (numbers only: header
rows skipped), and with ours, which also tells gaps from samples, checks frames, times, quaternions
and makes tracks in metres; in turn, on the given number of cores. pandas has one thread whatever it
is given. Ratios are formed within a round; medians and ranges over rounds are printed. The first
round of each is thrown away.
"""
import argparse
import json
import os
import statistics
import subprocess
import time

import pandas as pd


def header_rows(path):
    with open(path, encoding="utf-8") as file:
        return next(k for k, line in enumerate(file) if line.startswith("Frame,")) + 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("file")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--cores", default="1,2")
    a = parser.parse_args()
    skip, size = header_rows(a.file), os.path.getsize(a.file)
    cpus = sorted(os.sched_getaffinity(0))
    for cores in map(int, a.cores.split(",")):
        os.sched_setaffinity(0, cpus[:cores])
        theirs, ours = [], []
        for _ in range(a.rounds + 1):
            start = time.perf_counter()
            table = pd.read_csv(a.file, skiprows=skip, header=None)
            theirs.append(time.perf_counter() - start)
            line = subprocess.run([a.program, "read", a.file, "2"], check=True, capture_output=True,
                                  env={**os.environ, "RAYON_NUM_THREADS": str(cores)}).stdout
            # The second of two: files, like pandas here, are read by programs that are warm.
            result = json.loads(line.splitlines()[-1])
            ours.append(result["seconds"])
            assert result["samples"] == len(table), "both read every row"
        theirs, ours = theirs[1:], ours[1:]
        ratios = [t / o for t, o in zip(theirs, ours)]
        t, o = statistics.median(theirs), statistics.median(ours)
        print(f"{cores} cores: pandas {t * 1e3:.1f} ms ({size / t / 1e6:.0f} MB/s), ours {o * 1e3:.1f} ms "
              f"({size / o / 1e6:.0f} MB/s), ratio {statistics.median(ratios):.2f} "
              f"({min(ratios):.2f} to {max(ratios):.2f})")


main()
