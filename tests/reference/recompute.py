"""Recomputes the statistics of evaluation.json from the tables beside it, with NumPy and pandas alone.

    python tests/reference/recompute.py OUT [-v]

OUT is a folder that `inhand run` wrote. Needs numpy, pandas and pyarrow. Nothing of inhand is used: quantiles are
numpy.quantile, the draws of the bootstrap are made here from their description (ChaCha with 8 rounds). Prints how
many numbers were compared and the largest relative deviation, lists those beyond 1e-9, and ends with 1 if there are
any; -v also lists the numbers that no table has the rows of.
"""

import json
import os
import sys
import warnings
from collections import Counter, defaultdict

import numpy as np
import pandas as pd

warnings.simplefilter("ignore")

F = ["thumb", "index", "middle", "ring", "little"]
OUT = sys.argv[1]
V = "-v" in sys.argv
R = lambda n: (
    pd.read_parquet(os.path.join(OUT, n + ".parquet"))
    if os.path.exists(os.path.join(OUT, n + ".parquet"))
    else None
)
E = json.load(open(os.path.join(OUT, "evaluation.json")))
rows, segs, cons, phas = R("rows"), R("segments"), R("contacts"), R("phases")
count, dev, fails, touched = Counter(), defaultdict(float), [], set()
where = {}


def eq(path, said, mine, tol=1e-9):
    sec = path.split(".")[0]
    touched.add(path)
    count[sec] += 1
    if said is None or mine is None or (isinstance(mine, float) and not np.isfinite(mine)):
        none = mine is None or not np.isfinite(mine)
        if (said is None) != none:
            fails.append((path, said, mine))
        return
    d = abs(said - mine)
    d = d / max(abs(said), abs(mine)) if d else 0.0
    if d > 1e-9 and abs(said - mine) < 1e-6:
        d = 0.0  # rows are stored to a nanometre, 1e-6 mm
    if d > dev[sec]:
        dev[sec] = d
        where[sec] = path
    if d > tol:
        fails.append((path, said, float(mine)))


def dist(path, said, v, filled=None, left=None):
    v = np.asarray(v, float)
    ok = np.isfinite(v)
    eq(path + ".n", said["n"], int(ok.sum()))
    if filled is not None:
        eq(path + ".n_filled", said["n_filled"], int(np.asarray(filled)[ok].sum()))
    if left is not None:
        eq(path + ".n_left_out", said["n_left_out"], left)
    v = v[ok]
    if not len(v):
        for k in (
            "mean",
            "rmse",
            "min",
            "p5",
            "p25",
            "p50",
            "p75",
            "p95",
            "max",
            "whisker_low",
            "whisker_high",
        ):
            eq(path + "." + k, said[k], None)
        return
    q = np.quantile(v, [0.05, 0.25, 0.5, 0.75, 0.95])
    iqr = q[3] - q[1]
    lo = v[v >= q[1] - 1.5 * iqr]
    hi = v[v <= q[3] + 1.5 * iqr]
    for k, m in dict(
        mean=v.mean(),
        rmse=np.sqrt((v**2).mean()),
        min=v.min(),
        p5=q[0],
        p25=q[1],
        p50=q[2],
        p75=q[3],
        p95=q[4],
        max=v.max(),
        whisker_low=lo.min(),
        whisker_high=hi.max(),
    ).items():
        eq(path + "." + k, said[k], m)


def chacha(seed, streams, words):
    M = np.uint64
    S = len(streams)
    blocks = -(-words * 2 // 16)
    out = []
    for b in range(blocks):
        st = (
            [0x61707865, 0x3320646E, 0x79622D32, 0x6B206574, seed & 0xFFFFFFFF, seed >> 32]
            + [0] * 6
            + [b & 0xFFFFFFFF, b >> 32]
        )
        x = [np.full(S, v, np.uint32) for v in st] + [
            (streams & M(0xFFFFFFFF)).astype(np.uint32),
            (streams >> M(32)).astype(np.uint32),
        ]
        s0 = [a.copy() for a in x]

        def qr(a, b_, c, d):
            for i, o, t, n in ((a, b_, d, 16), (c, d, b_, 12), (a, b_, d, 8), (c, d, b_, 7)):
                x[i] = x[i] + x[o]
                v = x[t] ^ x[i]
                x[t] = (v << np.uint32(n)) | (v >> np.uint32(32 - n))

        for _ in range(4):
            for k in range(4):
                qr(k, 4 + k, 8 + k, 12 + k)
            for k in range(4):
                qr(k, 4 + (k + 1) % 4, 8 + (k + 2) % 4, 12 + (k + 3) % 4)
        out += [a + b_ for a, b_ in zip(x, s0)]
    out = [o.astype(np.uint64) for o in out]
    return np.stack([out[2 * k] | (out[2 * k + 1] << M(32)) for k in range(words)], 1)


_times = {}


def times(seed, draws, n):
    if (seed, draws, n) not in _times:
        w = chacha(seed, np.arange(draws, dtype=np.uint64), n)
        pl = np.array([[int(x) * n >> 64 for x in r] for r in w])
        t = np.zeros((draws, n), np.int64)
        for k in range(n):
            np.add.at(t, (np.arange(draws), pl[:, k]), 1)
        _times[seed, draws, n] = t
    return _times[seed, draws, n]


MEAS = ["mean", "rmse", "p50", "p75", "p95"]
QS = dict(p50=0.5, p75=0.75, p95=0.95)


class Sample:
    """values with cluster numbers; measures for given times, memoised per draw matrix"""

    def __init__(s, v, c, n):
        v, c = np.asarray(v, float), np.asarray(c)
        ok = np.isfinite(v)
        v, c = v[ok], c[ok]
        o = np.argsort(v, kind="stable")
        s.v, s.c, s.n = v[o], c[o], n
        s.size = np.bincount(s.c, minlength=n)
        s.s1 = np.bincount(s.c, s.v, n)
        s.s2 = np.bincount(s.c, s.v**2, n)
        s.m = {}

    def quant(s, w, qs):
        cum = np.cumsum(w[s.c])
        N = cum[-1] if len(cum) else 0
        if not N:
            return [np.nan] * len(qs)
        r = []
        for q in qs:
            h = (N - 1) * q
            b = int(h)
            f = h - b
            a = s.v[np.searchsorted(cum, b, "right")]
            r.append(a if f == 0 else a + f * (s.v[np.searchsorted(cum, b + 1, "right")] - a))
        return r

    def over(s, key, T, meas):
        k = (key, tuple(meas))
        if k not in s.m:
            N = (T * s.size).sum(1).astype(float)
            N[N == 0] = np.nan
            r = {}
            if "mean" in meas:
                r["mean"] = T @ s.s1 / N
            if "rmse" in meas:
                r["rmse"] = np.sqrt(T @ s.s2 / N)
            q = [m for m in meas if m in QS]
            if q:
                a = np.array([s.quant(t, [QS[m] for m in q]) for t in T])
                for j, m in enumerate(q):
                    r[m] = a[:, j]
            s.m[k] = r
        return s.m[k]


def interval(path, said, value, d, n, cl, conf, lone=False):
    if said is None:
        if np.isfinite(value):
            fails.append((path, None, value))
        return
    d = d[np.isfinite(d)]
    t = (1 - conf) / 2
    eq(path + ".value", said["value"], value)
    lo, hi = np.quantile(d, [t, 1 - t]) if len(d) else (np.nan, np.nan)
    # None of few clusters, nor where no draw differs from another.
    if lone or cl < 5 or not lo < hi:
        for k in ("low", "high", "standard_error"):
            eq(path + "." + k, said[k], None)
    else:
        eq(path + ".low", said["low"], lo)
        eq(path + ".high", said["high"], hi)
        eq(path + ".standard_error", said["standard_error"], d.std(ddof=1))
    eq(path + ".n", said["n"], n)
    eq(path + ".clusters", said["clusters"], cl)


def main():
    S = E["session"]
    L = S["segment_samples"]
    rate = S["rate_hz"]
    left_seg = sum(t["left_out"] for t in S["test"])
    n_seg = sum(t["segments"] for t in S["test"])
    col = lambda d, k: np.stack([d[f + "." + k].to_numpy(float) for f in F], 1)
    samp = {}
    stab = {}
    for m in E["methods"]:
        d = rows[rows.method == m["name"]]
        p = "methods." + m["name"]
        if len(d) != n_seg * L:
            fails.append((p + ".rows", len(d), n_seg * L))
        e = col(d, "error_m") * 1e3
        fl = col(d, "filled").astype(bool)
        whole = (n_seg + left_seg) * L
        dist(
            p + ".error.all",
            m["error_mm"]["all"],
            e.ravel(),
            fl.ravel(),
            5 * whole - int(np.isfinite(e).sum()),
        )
        for j, f in enumerate(F):
            dist(
                p + ".error." + f,
                m["error_mm"][f],
                e[:, j],
                fl[:, j],
                whole - int(np.isfinite(e[:, j]).sum()),
            )
        s = d["sample"].to_numpy()
        for nm, k in (("start", 0), ("goal", L - 1)):
            dist(
                p + ".error_at_" + nm,
                m[f"error_at_{nm}_mm"],
                e[s == k].ravel(),
                fl[s == k].ravel(),
                5 * (n_seg + left_seg) - int(np.isfinite(e[s == k]).sum()),
            )
        for k in range(L):
            v = e[s == k]
            v = v[np.isfinite(v)]
            eq(f"{p}.by_sample.{k}", m["median_error_by_sample_mm"][k], np.median(v) if len(v) else None)
        H = m["reachability"]
        if H and "thumb.hull_distance_m" in d:
            h = col(d, "hull_distance_m") * 1e3
            ok = np.isfinite(h).all(1)
            eq(p + ".reach.n", H["n"], int(ok.sum()))
            for j, f in enumerate(F):
                eq(p + ".reach.inside." + f, H["inside"][f], (h[ok, j] <= 1e-6).mean() if ok.any() else None)
                eq(
                    p + ".reach.worst." + f,
                    H["worst_outside_mm"][f],
                    max(h[ok, j].max(), 0) if ok.any() else None,
                )
                dist(p + ".reach.distance." + f, H["distance_mm"][f], h[:, j])
            eq(
                p + ".reach.inside.all", H["inside"]["all"], (h[ok] <= 1e-6).mean() if ok.any() else None
            )  # the mean over fingers, with 1e-9 m allowed
        C = m["collision"]
        np_ = d["nearest_pair_m"].to_numpy(float) * 1e3
        ok = np.isfinite(np_)
        eq(p + ".coll.n", C["n"], int(ok.sum()))
        eq(p + ".coll.instants", C["instants"], int((np_[ok] < C["limit_mm"]).sum()))
        eq(p + ".coll.nearest", C["nearest_mm"], np_[ok].min() if ok.any() else None)
        eq(
            p + ".coll.traj",
            C["trajectories"],
            d["segment"].to_numpy()[ok][np_[ok] < C["limit_mm"]].size
            and len(set(d["segment"].to_numpy()[ok][np_[ok] < C["limit_mm"]])),
        )
        rn = d["recorded_nearest_pair_m"].to_numpy(float) * 1e3
        both_known = ok & np.isfinite(rn)
        eq(p + ".coll.recorded", C["recorded_instants"], int((rn[both_known] < C["limit_mm"]).sum()))
        eq(
            p + ".coll.recorded_nearest",
            C["recorded_nearest_mm"],
            rn[both_known].min() if both_known.any() else None,
        )
        if H and "thumb.recorded_hull_distance_m" in d:
            h, r = col(d, "hull_distance_m"), col(d, "recorded_hull_distance_m")
            judged = np.isfinite(h).all(1)
            for j, f in enumerate(F):
                eq(
                    p + ".reach.recorded." + f,
                    H["recorded_inside"][f],
                    (r[judged, j] <= 1e-9).mean() if judged.any() else None,
                )
        if m["object_error_mm"]:
            filled = d["object_filled"].fillna(0).astype(bool).to_numpy()
            for key, column, unit in (
                ("object_error_mm", "object_position_error_m", 1e3),
                ("object_angle_deg", "object_angle_error_rad", 180 / np.pi),
            ):
                v = d[column].to_numpy(float) * unit
                dist(p + "." + key, m[key], v, filled, whole - int(np.isfinite(v).sum()))
        for c in m["corridors"]:
            v = col(d, "mahalanobis")
            known = ~np.isnan(v)
            inside = known & (v <= c["mahalanobis"])
            q = f"{p}.corridor.{c['share_stated']}"
            eq(q + ".n", c["n"], int(known.sum()))
            eq(q + ".n_filled", c["n_filled"], int((known & fl).sum()))
            eq(q + ".all", c["inside"]["all"], inside.sum() / known.sum() if known.any() else None)
            for j, f in enumerate(F):
                n_known = known[:, j].sum()
                eq(q + "." + f, c["inside"][f], inside[:, j].sum() / n_known if n_known else None)
        seg = d["segment"].to_numpy()
        samp[m["name"]] = {f: Sample(e[:, j], seg, n_seg) for j, f in enumerate(F)}
        samp[m["name"]]["all"] = Sample(e.ravel(), np.repeat(seg, 5), n_seg)
        c = m["contact"]
        if c:
            a, b = np.abs(col(d, "distance_m")), np.abs(col(d, "recorded_distance_m"))
            ok = np.isfinite(a).all(1) & np.isfinite(b).all(1)
            of = d["object_filled"].fillna(0).astype(bool).to_numpy()
            eq(p + ".contact.n", c["n"], int(ok.sum()))
            eq(p + ".contact.n_filled", c["n_filled"], int((of | fl.any(1))[ok].sum()))
            eq(p + ".contact.n_left_out", c["n_left_out"], whole - int(ok.sum()))
            for t in [
                dict(
                    tau_mm=c["tau_mm"],
                    three_or_more=c["three_or_more"],
                    recorded_three_or_more=c["recorded_three_or_more"],
                )
            ] + c["by_tau"]:
                for k, x in (("three_or_more", a), ("recorded_three_or_more", b)):
                    eq(
                        f"{p}.contact.{t['tau_mm']}.{k}",
                        t[k],
                        ((x[ok] <= t["tau_mm"] / 1e3).sum(1) >= 3).mean() if ok.any() else None,
                    )
            for j, f in enumerate(F):
                eq(p + ".contact.by." + f, c["by_finger"][f], (a[ok, j] <= c["tau_mm"] / 1e3).mean())
                eq(
                    p + ".contact.rby." + f,
                    c["recorded_by_finger"][f],
                    (b[ok, j] <= c["tau_mm"] / 1e3).mean(),
                )
                dd = np.abs(a[:, j] - b[:, j]) * 1e3
                dist(
                    p + ".distdiff." + f,
                    m["distance_difference_mm"][f],
                    dd,
                    fl[:, j] | of,
                    whole - int(np.isfinite(dd).sum()),
                )
            stab[m["name"]] = [
                Sample(((x[ok] <= c["tau_mm"] / 1e3).sum(1) >= 3).astype(float), seg[ok], n_seg)
                for x in (a, b)
            ]
    I = E["intervals"]
    if I:
        T = times(I["seed"], I["draws"], n_seg)
        one = np.ones((1, n_seg), np.int64)
        cl = lambda s: int((s.size > 0).sum())
        base = [
            (m["error_mm"]["all"]["mean"], m["name"])
            for m in E["methods"]
            if m["baseline"] and m["error_mm"]["all"]["n"]
        ]
        if (min(base)[1] if base else None) != I["best_baseline"]:
            fails.append(("intervals.best_baseline", I["best_baseline"], base))
        for m in I["methods"]:
            for f in ["all"] + F:
                s = samp[m["name"]][f]
                o, v = s.over("T", T, MEAS), s.over("1", one, MEAS)
                for k in MEAS:
                    interval(
                        f"intervals.{m['name']}.{f}.{k}",
                        (m["error_mm"][f] or {}).get(k),
                        v[k][0],
                        o[k],
                        len(s.v),
                        cl(s),
                        I["confidence"],
                        cl(s) < 2,
                    )
            if m["three_or_more"]:
                a, b = stab[m["name"]]
                oa, ob = a.over("T", T, ["mean"])["mean"], b.over("T", T, ["mean"])["mean"]
                va, vb = a.v.mean(), b.v.mean()
                interval(
                    f"intervals.{m['name']}.three",
                    m["three_or_more"],
                    va,
                    oa,
                    len(a.v),
                    cl(a),
                    I["confidence"],
                    cl(a) < 2,
                )
                interval(
                    f"intervals.{m['name']}.three_less",
                    m["three_or_more_less_recorded"],
                    va - vb,
                    oa - ob,
                    len(a.v),
                    cl(a),
                    I["confidence"],
                    cl(a) < 2,
                )
        eye = np.eye(n_seg, dtype=np.int64)
        for d in I["differences"]:
            a, b = samp[d["method"]][d["finger"]], samp[d["other"]][d["finger"]]
            k = d["measure"]
            p = f"differences.{d['method']}-{d['other']}.{d['finger']}.{k}"
            # Over the segments that both judged: a plan that failed is left out for both.
            both = (a.size == b.size).astype(np.int64)
            key = both.tobytes()
            va, vb, oa, ob = (
                x.over((w, key), t * both, MEAS)[k] for w, t in (("1", one), ("T", T)) for x in (a, b)
            )
            n_both = int((a.size * both).sum())
            cl_both = int(((a.size * both) > 0).sum())
            lone = cl_both < 2
            interval(
                p + ".abs", d["absolute_mm"], va[0] - vb[0], oa - ob, n_both, cl_both, I["confidence"], lone
            )
            with np.errstate(all="ignore"):
                interval(
                    p + ".rel",
                    d["relative"],
                    (va[0] - vb[0]) / abs(vb[0]),
                    (oa - ob) / np.abs(ob),
                    n_both,
                    cl_both,
                    I["confidence"],
                    lone,
                )
            ca, cb = (x.over("I", eye, MEAS)[k] for x in (a, b))
            ok = np.isfinite(ca) & np.isfinite(cb) & (both > 0)
            eq(p + ".share_better", d["share_better"], ((ca < cb) + 0.5 * (ca == cb))[ok].mean())
    M = E["movement"]
    if M:
        for nm, s in [("recorded", M["recorded"])] + [(x["name"], x) for x in M["methods"]]:
            d = segs[segs.motion == nm]
            p = "movement." + nm
            for f in F:
                g = d[d.finger == f]
                fl = g.filled.to_numpy().astype(bool)
                for k, c, u in (
                    ("length_mm", "length_m", 1e3),
                    ("peak_speed_mm_s", "peak_speed_m_s", 1e3),
                    ("static_share", "static_share", 1),
                    ("sparc", "sparc", 1),
                    ("ldlj", "ldlj", 1),
                ):
                    v = g[c].to_numpy(float) * u
                    dist(
                        f"{p}.{f}.{k}",
                        s["by_finger"][f][k],
                        v,
                        fl,
                        n_seg + left_seg - int(np.isfinite(v).sum()),
                    )
            if s["nearest_demonstration_mm"]:
                g = d[d.finger == "thumb"]
                v = g.nearest_demonstration_m.to_numpy(float) * 1e3
                dist(
                    p + ".nearest",
                    s["nearest_demonstration_mm"],
                    v,
                    d.groupby("segment").filled.max().reindex(g.segment).to_numpy().astype(bool),
                    n_seg + left_seg - int(np.isfinite(v).sum()),
                )
    K = E["contacts"]
    if K:
        c = cons[cons.kind == "contact"]

        def finger(p, s, g, known, touching_s, sc):
            eq(p + ".makes", s["makes"], int(g.made.sum()))
            eq(p + ".breaks", s["breaks"], int(g.broken.sum()))
            full = (g.made == 1) & (g.broken == 1)
            eq(p + ".censored", s["censored"], int((~full).sum()))
            dist(p + ".duration", s["duration_s"], (g.samples / sc)[full], g.filled[full].astype(bool))
            dist(p + ".slip", s["slip_mm"], g.slip_m * 1e3, g.filled.astype(bool))
            if known is not None:
                eq(p + ".known_s", s["known_s"], known)
                eq(p + ".duty", s["duty"], g.samples.sum() / sc / known if known else None)

        for t in K["takes"]:
            g = c[(c.scope == "take") & (c["take"] == t["take"])]
            u = cons[(cons.kind == "unknown") & (cons["take"] == t["take"]) & (cons.scope == "take")]
            for f in F:
                uu = u[u.finger == f]
                finger(
                    f"contacts.{t['take']}.{f}",
                    t["by_finger"][f],
                    g[g.finger == f],
                    t["duration_s"] - uu.samples.sum() / t["rate_hz"],
                    None,
                    t["rate_hz"],
                )
                for q, w in zip(t["contacts_s"][f], g[g.finger == f].itertuples()):
                    eq(f"contacts.{t['take']}.{f}.span", q[1], w.end_s)
                eq(f"contacts.{t['take']}.{f}.spans", len(t["contacts_s"][f]), len(g[g.finger == f]))
                eq(f"contacts.{t['take']}.{f}.unk", len(t["unknown_s"][f]), len(uu))
            st = phas[(phas.scope == "take") & (phas["take"] == t["take"]) & (phas.kind == "state")]
            tot = st.samples.sum()
            eq(f"contacts.{t['take']}.states", len(t["states"]), st.what.nunique())
            for s in t["states"]:
                n = "+".join(s["fingers"])
                x = st[st.what.fillna("").isin([n] if n else ["", "none", "no contact"])]
                p = f"contacts.{t['take']}.state.{n}"
                eq(p + ".samples", s["samples"], int(x.samples.sum()))
                eq(p + ".share", s["share"], x.samples.sum() / tot)
                eq(p + ".runs", s["runs"], len(x))
                dist(p + ".duration", s["duration_s"], (x.samples / t["rate_hz"])[x.complete == 1])
            tr = Counter()
            r = list(st.sort_values("start_s").itertuples())
            for a, b in zip(r, r[1:]):
                if abs(a.end_s - b.start_s) < 1e-9:
                    tr[a.what, b.what] += 1
            eq(
                f"contacts.{t['take']}.transitions",
                sum(x.get("count", 0) for x in t["transitions"]),
                sum(tr.values()),
            )
            eq(
                f"contacts.{t['take']}.phases",
                len(t["phases"]),
                int(((phas.kind == "phase") & (phas["take"] == t["take"])).sum()),
            )
            eq(
                f"contacts.{t['take']}.gaits",
                len(t["gaits"]),
                int(((phas.kind == "gait") & (phas["take"] == t["take"])).sum()),
            )
        for nm, s in [("recorded", K["recorded"])] + [(x["name"], x) for x in K["methods"]]:
            g = c[(c.scope == "segment") & (c.motion == nm)]
            for f in F:
                d = segs[(segs.motion == nm) & (segs.finger == f)]
                finger(
                    f"contacts.seg.{nm}.{f}",
                    s["by_finger"][f],
                    g[g.finger == f],
                    float(d.known_s.sum()),
                    None,
                    rate,
                )
                eq(
                    f"contacts.seg.{nm}.{f}.duty2",
                    s["by_finger"][f]["duty"],
                    (d.duty * d.known_s).sum() / d.known_s.sum() if d.known_s.sum() else None,
                )
                eq(f"contacts.seg.{nm}.{f}.makes2", s["by_finger"][f]["makes"], int(d.makes.sum()))
            st = phas[(phas.scope == "segment") & (phas.motion == nm) & (phas.kind == "state")]
            by = Counter()
            [
                by.update(
                    {
                        (
                            0
                            if (w in ("none", "", "no contact") or w is None or w != w)
                            else len(w.split("+"))
                        ): int(n)
                    }
                )
                for w, n in zip(st.what, st.samples)
            ]
            for k in range(6):
                eq(f"contacts.seg.{nm}.by_fingers.{k}", s["by_fingers"][k], by[k])
            eq(f"contacts.seg.{nm}.segments", s["segments"], d.segment[d.known_s > 0].nunique())
    # what no row says
    no = set()

    def walk(x, p):
        if isinstance(x, dict):
            [walk(v, p + "." + k) for k, v in x.items()]
        elif isinstance(x, list):
            [walk(v, p + "[]") for v in x]
        elif isinstance(x, (int, float)) and not isinstance(x, bool):
            no.add(p)

    for m in E["methods"]:
        for k in ("velocity", "plan"):
            walk(m.get(k), k)
    for k in ("dictionary", "quality", "choice"):
        walk(E.get(k), k)
    total = sum(count.values())
    print(
        f"{OUT}: {total} numbers recomputed, worst relative deviation {max(dev.values(), default=0):.3g}; {len(fails)} beyond 1e-9"
    )
    for k in count:
        print(f"  {k:12} {count[k]:6} worst {dev[k]:.3g} at {where.get(k)}")
    g = defaultdict(list)
    for p, a, b in fails:
        g[p.split(".")[0] + "…" + p.split(".")[-1]].append((p, a, b))
    for k, v in g.items():
        print("  FAIL", k, len(v), v[: 4 if not V else 99])
    if V:
        print("no rows for:", sorted(no))
    return bool(fails)


sys.exit(main())
