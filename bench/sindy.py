#!/usr/bin/env python3
"""How often exactly the true terms are found in noisy records of systems of which nothing is known: phisindy beside PySINDy.

    pip install pysindy                                   # without it phisindy stands alone
    bench/sindy.py PROGRAM FOLDER --seeds 32 --write docs/results.md

The protocols are those of ODR-BINDy (Lorenz63, Van der Pol) and of E-SINDy (Lorenz63 with 55 terms): see the first lines of the specs. PROGRAM is
`phisindy`. FOLDER keeps what is done, so that the same command goes on after an interruption, with more seeds, or with peers.

Nobody is told the noise. PySINDy gets the same records. Its threshold must be chosen: each of the listed ones is tried, and in each cell the one that
finds the truth in most seeds counts, which nobody who does not know the truth can choose. phisindy has nothing to choose. `told` counts
runs that name another choice of terms which describes the data as well.
"""
import argparse
import json
import pathlib
import subprocess
import warnings

import tables

SPECS = pathlib.Path(__file__).resolve().parent.parent / "specs"
# Noise in per cent of `scale`, in the unit of all columns alike, and durations in seconds.
PROTOCOLS = {
    "Lorenz63, 10 terms": {
        "spec": "lorenz63", "columns": "xyz", "scale": 12.753, "degree": 2, "constant": True,
        "cells": {T: [2.5, 5, 10, 20, 30] for T in (10, 8, 6, 4)},
        "truth": [{"x", "y"}, {"x", "y", "x z"}, {"z", "x y"}],
    },
    "Van der Pol, 10 terms": {
        "spec": "vanderpol", "columns": "xy", "scale": 1.4479, "degree": 3, "constant": True,
        "cells": {T: [10, 20, 30, 40] for T in (8, 12)},
        "truth": [{"y"}, {"x", "y", "x^2 y"}],
    },
    "Lorenz63, 55 terms": {
        "spec": "lorenz63_quintic", "columns": "xyz", "scale": 15.97, "degree": 5, "constant": False,
        "cells": {10: [2.5, 5]},
        "peer_seeds": 4,  # a weak form of 55 terms takes a minute for each threshold
        "truth": [{"x", "y"}, {"x", "y", "x z"}, {"z", "x y"}],
    },
}
THRESHOLDS = [0.05, 0.1, 0.2, 0.4, 0.8]
# Models of an ensemble and the part of them that a term must be in (E-SINDy).
MODELS, INCLUSION = 50, 0.6
# Subdomains of the weak form, and how long one is.
DOMAINS, DOMAIN = 200, 0.4
PEERS = ["SINDy", "ensemble", "weak"]


def noise(protocol, per_cent):
    """The noise as a spec says it."""
    each = ", ".join(f'"{c}": ({per_cent / 100 * protocol["scale"]:.9g}, "1")' for c in protocol["columns"])
    return "Sensor({" + each + "})"


def lines(path):
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def swept(given, protocol, duration):
    """The truth and the runs of each noise, by `phisindy sweep`."""
    out = given.folder / f"{protocol['spec']}-{duration}"
    noises = protocol["cells"][duration]
    command = [given.program, "sweep", SPECS / f"{protocol['spec']}.ron", "--noise", ", ".join(noise(protocol, n) for n in noises)]
    command += ["--set", f"data.0.duration={duration}.0", "--seeds", given.seeds, "--seed", given.first, "--out", out, "--quiet"]
    command += ["--jobs", given.jobs]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if done.returncode > 1:
        raise SystemExit(done.stderr)
    journal = lines(out / "sweep.jsonl")
    truths = [line["design"]["cells"] for line in journal if "design" in line][-1]
    seeds = range(given.first, given.first + given.seeds)
    runs = [r for r in journal if r.get("seed") in seeds and "cell" in r]
    labels = [cell["label"] for cell in truths]
    return {n: (truths[k]["coefficients"], [r for r in runs if r["cell"] == labels[k]]) for k, n in enumerate(noises)}


def told(given, protocol, duration, per_cent, seed):
    """Whether a run says that other terms describe its data as well."""
    command = [given.program, "run", SPECS / f"{protocol['spec']}.ron", "--format", "json", "--quiet", "--seed", seed, "--jobs", given.jobs]
    done = subprocess.run(list(map(str, command + settings(protocol, duration, per_cent))), capture_output=True, text=True)
    return any("described just as well" in warning for warning in json.loads(done.stdout)["warnings"])


def ours(given, protocol, duration, per_cent, truth, runs):
    """Cells of the table: how often exact, how often identified with other terms, how many intervals hold, seconds."""
    wrong = [r["seed"] for r in runs if r["verdict"] == "identified" and not r["exact"]]
    known = sum(told(given, protocol, duration, per_cent, seed) for seed in wrong)
    found = [(f, t) for r in runs if r["exact"] for f, t in zip(r["found"], truth)]
    holds = sum((f["low"] is None or f["low"] <= t) and (f["high"] is None or t <= f["high"]) for f, t in found)
    seconds = sorted(r["seconds"] for r in runs)[len(runs) // 2]
    coverage = f"{100 * holds / len(found):.0f} %" if found else "-"
    return [f"{sum(r['exact'] for r in runs)} of {len(runs)}", f"{len(wrong)}, told of {known}" if wrong else 0, coverage, f"{seconds:.2g}"]


def settings(protocol, duration, per_cent):
    """The spec of one cell."""
    return ["--set", f"data.0.duration={duration}.0", "--set", f"data.0.noise={noise(protocol, per_cent)}"]


def record(given, protocol, duration, per_cent, seed):
    """Times and noisy columns of one seed, as `phisindy simulate` prints them."""
    command = [given.program, "simulate", SPECS / f"{protocol['spec']}.ron", "--quiet", "--seed", seed]
    command += settings(protocol, duration, per_cent)
    text = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=True).stdout
    head, *rows = [line.split(",") for line in text.splitlines() if line and line[0] != "#"]
    names = [name.split()[0] for name in head]
    import numpy

    values = numpy.array(rows, float)
    return values[:, names.index("t")], values[:, [names.index(c) for c in protocol["columns"]]]


def supports(names, coefficients):
    """The names of the terms of each equation."""
    return [{name for name, c in zip(names, row) if c} for row in coefficients]


def with_peers(protocol, time, columns):
    """For each peer the thresholds at which it finds exactly the true terms."""
    import numpy
    import pysindy

    library = lambda: pysindy.PolynomialLibrary(degree=protocol["degree"], include_bias=protocol["constant"])
    smooth = lambda: pysindy.SmoothedFiniteDifference(smoother_kws={"window_length": 15})

    def fit(optimizer, features, derivative):
        model = pysindy.SINDy(optimizer=optimizer, feature_library=features, differentiation_method=derivative)
        model.fit(columns, t=time, feature_names=list(protocol["columns"]))
        return model.get_feature_names(), model.coefficients()

    def plain(threshold):
        return supports(*fit(pysindy.STLSQ(threshold=threshold, max_iter=50), library(), smooth()))

    def ensemble(threshold):
        numpy.random.seed(0)
        many = pysindy.EnsembleOptimizer(pysindy.STLSQ(threshold=threshold, max_iter=50), bagging=True, n_models=MODELS)
        names, _ = fit(many, library(), smooth())
        inside = numpy.mean(numpy.array(many.coef_list) != 0, axis=0)
        return supports(names, inside >= INCLUSION)

    def weak(threshold):
        numpy.random.seed(0)
        half = [DOMAIN / 2]
        features = pysindy.WeakPDELibrary(
            function_library=library(), spatiotemporal_grid=time, K=DOMAINS, H_xt=half, include_bias=False
        )
        return supports(*fit(pysindy.STLSQ(threshold=threshold, max_iter=50), features, None))

    found = {}
    for name, peer in zip(PEERS, (plain, ensemble, weak)):
        found[name] = []
        for threshold in THRESHOLDS:
            try:
                terms = peer(threshold)
            except (ValueError, numpy.linalg.LinAlgError) as why:
                found.setdefault("failed", []).append(f"{name} {threshold}: {why}")
                continue
            if terms == protocol["truth"]:
                found[name].append(threshold)
    return found


def peers(given, protocol, duration, per_cent):
    """Cells of the table: for each peer how often exact, at the threshold that is best here."""
    journal = given.folder / "peers.jsonl"
    key = {"spec": protocol["spec"], "duration": duration, "noise": per_cent}
    known = {r["seed"]: r for r in lines(journal) if all(r[k] == v for k, v in key.items())}
    seeds = range(given.first, given.first + min(given.peer_seeds, protocol.get("peer_seeds", given.peer_seeds)))
    for seed in seeds:
        if seed not in known:
            time, columns = record(given, protocol, duration, per_cent, seed)
            known[seed] = {**key, "seed": seed, **with_peers(protocol, time, columns)}
            with journal.open("a") as file:
                file.write(json.dumps(known[seed]) + "\n")
    cells = []
    for peer in PEERS:
        count = {h: sum(h in known[seed][peer] for seed in seeds) for h in THRESHOLDS}
        best = max(count, key=count.get)
        cells.append(f"{count[best]} of {len(seeds)}" + (f" ({best})" if count[best] else ""))
    return cells


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("program", help="phisindy")
    arguments.add_argument("folder", type=pathlib.Path, help="where runs are kept")
    arguments.add_argument("--seeds", type=int, default=100, help="of each cell")
    arguments.add_argument("--peer-seeds", type=int, help="of each cell for PySINDy [as many], 0 for none")
    arguments.add_argument("--first", type=int, default=1001, help="first seed")
    arguments.add_argument("--jobs", type=int, default=1, help="threads")
    arguments.add_argument("--only", choices=[p["spec"] for p in PROTOCOLS.values()], action="append", help="these protocols")
    arguments.add_argument("--write", help="a document with the marks of the table")
    given = arguments.parse_args()
    given.peer_seeds = given.seeds if given.peer_seeds is None else given.peer_seeds
    given.folder.mkdir(parents=True, exist_ok=True)
    if given.peer_seeds:
        try:
            import pysindy
        except ImportError:
            print("PySINDy is not installed and left out")
            given.peer_seeds = 0
    warnings.filterwarnings("ignore")
    rows = []
    for name, protocol in PROTOCOLS.items():
        if given.only and protocol["spec"] not in given.only:
            continue
        for duration in protocol["cells"]:
            for per_cent, (truth, runs) in swept(given, protocol, duration).items():
                row = [name, f"{duration} s", f"{per_cent:g} %", *ours(given, protocol, duration, per_cent, truth, runs)]
                if given.peer_seeds:
                    row += peers(given, protocol, duration, per_cent)
                rows.append(row)
                print(*row, sep=" | ", flush=True)
    head = ["system", "duration", "noise", "phisindy: exactly the true terms", "identified with other terms", "intervals that hold the truth", "seconds (median)"]
    if given.peer_seeds:
        import pysindy

        head += [f"PySINDy {pysindy.__version__}, {peer}" for peer in PEERS]
    text = tables.markdown(head, rows)
    print("\n" + text)
    if given.write:
        tables.write(given.write, "sindy", text)


if __name__ == "__main__":
    main()
