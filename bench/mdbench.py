#!/usr/bin/env python3
"""The 63 systems of ODEs of MDBench, which are those of ODEBench: phisindy beside PySINDy and PyOperon.

    pip install pysindy pyoperon scipy                   # a peer that is not installed is left out
    bench/mdbench.py PROGRAM FOLDER --write docs/results.md

`mdbench.csv` holds the equations. The protocol is that of MDBench (Bideh et al. 2025, arXiv 2509.20529): 150 samples of 10 s from the first start
values, each times 1 + noise of so many dB; the first 120 are for the tools, the last 30 for the test. Its measure is the normalised square error of the
rates that a model gives at the noisy test samples, against the true rates of the clean ones. The other measure is that of ODEBench: a model runs freely
from the second start values, which no tool has seen, over 10 s.

phisindy and PySINDy get one dictionary, the same for all systems of as many states. PySINDy's threshold is chosen as MDBench does it, by the rates of the
last fifth of what it gets, here held apart, and by how long its formula is; its derivatives are smoothed where there is noise. FOLDER keeps what is
done: the same command goes on after an interruption. Limits are seconds of the clock: use a machine that does nothing else.
"""
import argparse
import csv
import itertools
import json
import multiprocessing
import pathlib
import re
import subprocess
import time
import warnings

import numpy as np
from scipy.integrate import solve_ivp

import tables

STATES, SAMPLES, TRAIN, DURATION = "xyzw", 150, 120, 10.0
NOISES = [None, 40, 30, 20, 10]
THRESHOLDS = [0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0]
# Subdomains of the weak form, and how long one is in seconds.
DOMAINS, DOMAIN = 100, 1.0
WINDOW = 15
FUNCTIONS = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "cot": lambda a: 1 / np.tan(a), "exp": np.exp, "ln": np.log, "log": np.log, "abs": np.abs,
    "tanh": np.tanh, "sqrt": np.sqrt, "sgn": np.sign,
}
TOOLS = ["phisindy", "SINDy", "weak", "PyOperon"]


def systems():
    with open(pathlib.Path(__file__).with_suffix(".csv"), newline="") as file:
        rows = list(csv.DictReader(file))
    number = lambda text: [float(value) for value in text.split()]
    return [
        {"number": int(r["number"]), "name": r["name"], "rates": r["rates"].split("; "), "start": number(r["start"]), "second": number(r["second start"])}
        for r in rows
    ]


def dictionary(states):
    """The terms of every equation: monomials up to the third degree, sines and cosines, and for one state an exponential."""
    powers = [" * ".join(c) for k in (1, 2, 3) for c in itertools.combinations_with_replacement(states, k)]
    return ["1", *powers, *(f"{f}({s})" for f in ("sin", "cos") for s in states), *(["exp(-x)"] if len(states) == 1 else [])]


def rates(texts):
    """The texts as one function of the states, a row for each sample."""
    codes = [compile(text.replace("^", "**"), text, "eval") for text in texts]

    def function(states):
        states = np.asarray(states, float)
        names = {**FUNCTIONS, **{name: states[..., i] for i, name in enumerate(STATES[: states.shape[-1]])}}
        return np.stack([eval(code, {"__builtins__": {}}, names) + 0.0 * states[..., 0] for code in codes], -1)

    return function


def motion(function, start, times, scale=np.inf):
    """A free run, or None where it does not arrive, takes more than ten seconds or leaves a thousand times the scale."""
    end = time.time() + 10

    def slope(_, state):
        if time.time() > end:
            raise TimeoutError
        return function(state)

    far = lambda _, state: 1e3 * scale - np.abs(state).max()
    far.terminal = True
    exact = np.isinf(scale)
    try:
        limits = {"rtol": 1e-11, "atol": 1e-13} if exact else {"rtol": 1e-7, "atol": 1e-9, "events": far}
        run = solve_ivp(slope, (times[0], times[-1]), start, "LSODA", times, **limits)
    except (TimeoutError, ValueError, OverflowError, ArithmeticError):
        return None
    return run.y.T if run.status == 0 and run.y.shape[1] == len(times) and np.isfinite(run.y).all() else None


def held(system, function, clean):
    """The true terms of each equation, where the dictionary holds them all: the rates at random states are exact sums of terms."""
    random = np.random.default_rng(0)
    states = random.uniform(clean.min(0) - 0.1, clean.max(0) + 0.1, (400, clean.shape[1]))
    states = np.abs(states) if "ln" in system["rates"][0] else states
    terms = dictionary(STATES[: clean.shape[1]])
    matrix = rates(terms)(states)
    scale = np.abs(matrix).max(0)
    due = function(states)
    with np.errstate(all="ignore"):
        numbers, *_ = np.linalg.lstsq(matrix / scale, due, rcond=None)
    if not np.isfinite(due).all() or np.abs(matrix / scale @ numbers - due).max() > 1e-9 * np.abs(due).max():
        return None
    return [sorted(t for t, c in zip(terms, column) if abs(c) > 1e-6 * np.abs(due).max()) for column in numbers.T]


def sums(terms, coefficients):
    """A linear model as what the score needs: texts, terms, their number."""
    texts = [" + ".join(f"({c!r})*{t}" for t, c in zip(terms, map(float, row)) if c) or "0" for row in coefficients]
    support = [sorted(t for t, c in zip(terms, row) if c) for row in coefficients]
    return {"texts": texts, "support": support, "size": sum(map(len, support))}


def by_phisindy(given, folder, times, seen):
    states = STATES[: seen.shape[1]]
    stem = folder / "record"
    np.savetxt(f"{stem}.csv", np.column_stack([times, seen]), delimiter=",", header="t," + ",".join(states), comments="", fmt="%.12g")
    each = lambda write: ", ".join(f'"{s}": {write(s)}' for s in states)
    candidates = ", ".join(f'"{term}"' for term in dictionary(states))
    pathlib.Path(f"{stem}.ron").write_text(f"""(
    states: {{ {each(lambda _: '""')} }}, known: {{ {each(lambda _: '"0"')} }},
    unknown: {{ {each(lambda _: f"(candidates: [{candidates}])")} }},
    data: [Csv(path: "record.csv", time: "t", columns: {{ {each(lambda s: f'"{s}"')} }})],
)
""")
    run = [given.program, "run", f"{stem}.ron", "--format", "json", "--quiet", "--jobs", "1", "--limit", f"{given.limit}s"]
    done = subprocess.run(run, capture_output=True, text=True, timeout=given.limit + 30)
    if not done.stdout.strip().startswith("{"):
        return {"failed": f"exit {done.returncode}: {done.stderr.strip()[-300:]}"}
    found = json.loads(done.stdout)
    texts = {e["state"]: e["text"] for e in found["equations"]}
    support = {e["state"]: sorted(t["candidate"].replace(" ", "").replace("*", " * ") for t in e["terms"]) for e in found["equations"]}
    return {
        "texts": [texts.get(s, "0") for s in states], "support": [support.get(s, []) for s in states], "size": sum(map(len, support.values())),
        "verdict": found["verdict"], "reason": found["reason"], "told": len(found["warnings"] + found["doubts"]), "stopped": found["stopped"],
    }


def symbols(text):
    return len(re.findall(r"[a-z]+|[-+*/^]|[0-9.]+(?:e[-+]?[0-9]+)?", text))


def by_pysindy(form, times, seen, noise):
    import pysindy

    states = STATES[: seen.shape[1]]
    terms = dictionary(states)
    smooth = {"smoother_kws": {"window_length": WINDOW}}
    differ = lambda: pysindy.SmoothedFiniteDifference(**smooth) if noise else pysindy.FiniteDifference()
    columns = [eval(f"lambda {', '.join(states)}: {term} + 0 * x", dict(FUNCTIONS)) for term in terms]
    library = lambda: pysindy.CustomLibrary(columns, [lambda *_, term=term: term for term in terms])

    def fit(threshold, times, seen):
        np.random.seed(0)
        optimizer, features = pysindy.STLSQ(threshold=threshold, alpha=1e-5, max_iter=200), library()
        if form == "weak":
            features = pysindy.WeakPDELibrary(function_library=features, spatiotemporal_grid=times, K=DOMAINS, H_xt=[DOMAIN / 2])
        model = pysindy.SINDy(optimizer, features, differ())
        model.fit(seen, t=times, feature_names=list(states))
        return sums(terms, model.coefficients())

    cut = len(times) - len(times) // 5
    due = differ()._differentiate(seen, times)[cut:]
    best = (-np.inf, None)
    for threshold in THRESHOLDS:
        try:
            model = fit(threshold, times[:cut], seen[:cut])
        except (ValueError, np.linalg.LinAlgError):
            continue
        error = np.sum((rates(model["texts"])(seen[cut:]) - due) ** 2) / np.sum(due**2)
        score = 1 / (1 + error) + np.exp(-sum(map(symbols, model["texts"])) / 200)
        best = max(best, (score, threshold), key=lambda b: b[0] if np.isfinite(b[0]) else -np.inf)
    return {**fit(best[1], times, seen), "threshold": best[1]} if best[1] else {"failed": "no threshold fits"}


def by_operon(given, times, seen, noise, seed):
    from pyoperon.sklearn import SymbolicRegressor
    from scipy.signal import savgol_filter

    step = times[1] - times[0]
    smooth = savgol_filter(seen, WINDOW, 3, axis=0) if noise else seen
    slopes = np.gradient(smooth, step, axis=0, edge_order=2)
    texts = []
    for due in slopes.T:
        model = SymbolicRegressor(
            allowed_symbols="add,sub,mul,div,sin,cos,exp,constant,variable", max_time=given.operon, max_evaluations=1_000_000, optimizer_iterations=10,
            max_length=40, n_threads=1, random_state=seed,
        ).fit(np.asfortranarray(smooth), due)
        texts.append(model.get_model_string(model.model_, 12, list(STATES[: seen.shape[1]])))
    return {"texts": texts, "size": sum(map(symbols, texts))}


def data(system, noise, seed):
    """Times, clean samples and noisy ones."""
    times = np.linspace(0.0, DURATION, SAMPLES)
    clean = motion(rates(system["rates"]), system["start"], times)
    random = np.random.default_rng([seed, system["number"], noise or 0])
    level = 10 ** (-noise / 20) if noise else 0.0
    return times, clean, clean * (1 + level * random.standard_normal(clean.shape))


def scored(system, noise, seed, texts):
    """The measure of MDBench and the R2 of ODEBench."""
    times, clean, seen = data(system, noise, seed)
    function = rates(system["rates"])
    due, model = function(clean[TRAIN:]), rates(texts)
    error = np.sum((model(seen[TRAIN:]) - due) ** 2) / (np.sum(due**2) + 1e-10)
    second = motion(function, system["second"], times)
    run = motion(model, system["second"], times, np.abs(second).max())
    spread = np.sum((second - second.mean(0)) ** 2)
    missed = np.sum((run - second) ** 2) / spread if run is not None else np.inf
    return {"rates": float(error), "free": float(missed)}


def work(job):
    """One tool on one record."""
    given, system, noise, tool = job
    np.seterr(all="ignore")
    warnings.filterwarnings("ignore")
    times, _, seen = data(system, noise, given.seed)
    times, seen = times[:TRAIN], seen[:TRAIN]
    folder = given.folder / f"{system['number']:02}-{noise or 'clean'}"
    folder.mkdir(parents=True, exist_ok=True)
    begin = time.time()
    try:
        if tool == "phisindy":
            found = by_phisindy(given, folder, times, seen)
        elif tool == "PyOperon":
            found = by_operon(given, times, seen, noise, given.seed)
        else:
            found = by_pysindy(tool, times, seen, noise)
    except Exception as why:
        found = {"failed": f"{type(why).__name__}: {why}"[:300]}
    seconds = time.time() - begin
    score = scored(system, noise, given.seed, found["texts"]) if "texts" in found else {}
    return {"number": system["number"], "noise": noise, "tool": tool, "seed": given.seed, **found, **score, "seconds": seconds}


def lines(path):
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def true_terms(system):
    times = np.linspace(0.0, DURATION, SAMPLES)
    function = rates(system["rates"])
    return held(system, function, motion(function, system["start"], times))


def exact(system, run):
    return run.get("support") == system["terms"] if system["terms"] else False


def rows(chosen, noises, runs):
    """A row for each noise and tool, and the truth itself as the best that can be had."""
    for noise in noises:
        label = f"{noise} dB" if noise else "none"
        for tool in ["the truth", *TOOLS]:
            if tool == "the truth":
                here = [{**scored(s, noise, runs["seed"], s["rates"]), "system": s, "seconds": 0.0} for s in chosen]
            else:
                here = [{**runs[k], "system": s} for s in chosen if (k := (s["number"], noise, tool)) in runs]
            if not here:
                continue
            inside = [r for r in here if r["system"]["terms"]]
            outside = [r for r in here if not r["system"]["terms"]]
            good = lambda part: f"{sum(r.get('rates', np.inf) < 1e-2 for r in part)} of {len(part)}"
            free = lambda part: f"{sum(r.get('free', np.inf) < 0.1 for r in part)} of {len(part)}"
            cells = [good(here), f"{np.median([r.get('rates', np.inf) for r in here]):.1e}", free(inside), free(outside)]
            if tool == "the truth":
                yield [label, tool, *cells, "", "", "", ""]
                continue
            has = tool != "PyOperon"
            right = f"{sum(exact(r['system'], r) for r in inside)} of {len(inside)}" if has else "-"
            wrong = [r for r in inside if r.get("verdict") == "identified" and not exact(r["system"], r)]
            told = f"{len(wrong)}, told of {sum(r['told'] > 0 for r in wrong)}" if tool == "phisindy" else "-"
            size = np.median([r["size"] for r in here if "size" in r])
            yield [label, tool, *cells, right, told, f"{size:g} {'terms' if has else 'symbols'}", f"{np.median([r['seconds'] for r in here]):.2g}"]


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("program", help="phisindy")
    arguments.add_argument("folder", type=pathlib.Path, help="where runs are kept")
    arguments.add_argument("--systems", help="their numbers, as in 1,24,56 [all]")
    arguments.add_argument("--noise", help="in dB, as in clean,20 [clean,40,30,20,10]")
    arguments.add_argument("--tools", default=",".join(TOOLS), help=f"[{','.join(TOOLS)}]")
    arguments.add_argument("--seed", type=int, default=5101, help="of the noise")
    arguments.add_argument("--limit", type=int, default=30, help="seconds for phisindy")
    arguments.add_argument("--operon", type=int, default=2, help="seconds for PyOperon, each equation")
    arguments.add_argument("--processes", type=int, default=2)
    arguments.add_argument("--write", help="a document with the marks of the tables")
    given = arguments.parse_args()
    given.program, given.folder = str(pathlib.Path(given.program).resolve()), given.folder.resolve()
    given.folder.mkdir(parents=True, exist_ok=True)
    numbers = set(map(int, given.systems.split(","))) if given.systems else None
    chosen = [s for s in systems() if not numbers or s["number"] in numbers]
    noises = [None if n == "clean" else int(n) for n in given.noise.split(",")] if given.noise else NOISES
    tools = [t for t in given.tools.split(",") if t in TOOLS and (t == "phisindy" or installed(t))]
    for system in chosen:
        system["terms"] = true_terms(system)
    journal = given.folder / "runs.jsonl"
    key = lambda r: (r["number"], r["noise"], r["tool"])
    runs = {key(r): r for r in lines(journal) if r["seed"] == given.seed}
    jobs = [(given, s, n, t) for n in noises for t in tools for s in chosen if (s["number"], n, t) not in runs]
    with multiprocessing.Pool(given.processes, maxtasksperchild=20) as pool, journal.open("a") as file:
        for run in pool.imap_unordered(work, jobs):
            runs[key(run)] = run
            file.write(json.dumps(run) + "\n")
            file.flush()
            says = f"{run.get('rates', np.inf):.1e} {run.get('free', np.inf):.1e} {run['seconds']:.1f} s {run.get('verdict', run.get('failed', ''))}"
            print(run["number"], run["noise"], run["tool"], says, flush=True)
    runs["seed"] = given.seed
    head = [
        "noise", "by", "error of the rates below 0.01", "its median", "follows a new start (R2 above 0.9): truth in the dictionary", "truth not in it",
        "exactly the true terms", "identified with other terms", "size (median)", "seconds (median)",
    ]
    text = tables.markdown(head, rows(chosen, noises, runs))
    print("\n" + text)
    if given.write:
        tables.write(given.write, "mdbench", text)


def installed(tool):
    try:
        __import__("pyoperon" if tool == "PyOperon" else "pysindy")
    except ImportError:
        print(f"{tool} is not installed and left out")
        return False
    return True


if __name__ == "__main__":
    main()
