#!/usr/bin/env python3
"""Oscillators of LLM-SRBench (Shojaee et al. 2025, arXiv 2504.10415) of which nothing is told: phisindy beside PySINDy and PyOperon.

    pip install pysindy pyoperon scipy                       # a peer that is not installed is left out
    bench/llmsrbench.py PROGRAM FOLDER --write docs/results.md --data DATA/llmsr

The benchmark publishes 44 physics problems (PO0 to PO43) as numbers, and their equations without constants. `llmsrbench.csv` holds the five whose
numbers stand in a public repository of text (STRIDE): their constants follow from a linear fit, which leaves less than 2e-12 of the variance. The data
are made from them anew: 40 s from (1, 0) in 5000 samples. The first 36 s are for the tools and for the test in domain (500 samples that no tool gets),
the last 4 s are out of it. With --data come the two oscillators of LLM-SR (see bench/formula.py). There all tools are left to find the drive too.

Tools get positions and velocities, with noise a part of their standard deviation, and no accelerations. `phisindy gap` is told nothing but x' = v.
`phisindy run` and PySINDy get one dictionary: monomials to the third degree, sines and cosines of x, v and t, absolute values. Errors are those of
LLM-SR: the mean square of the acceleration that is missed over its variance. Terms: how many of the true ones the formula has, and how many it has.
"""
import argparse
import csv
import itertools
import json
import pathlib
import subprocess
import time
import warnings

import numpy as np

import formula
import mdbench
import tables

EVERY = 2
DICTIONARY = [
    "1", *("*".join(c) for k in (1, 2, 3) for c in itertools.combinations_with_replacement("xv", k)),
    "sin(t)", "cos(t)", "sin(x)", "cos(x)", "sin(v)", "cos(v)", "abs(x)", "abs(v)", "x*abs(x)", "v*abs(v)",
]
GAP, RUN, SINDY, OPERON = "phisindy gap", "phisindy run", "PySINDy", "PyOperon"


def rate(text, data):
    """The acceleration that a formula gives."""
    names = {**mdbench.FUNCTIONS, "tanh": np.tanh, "atan": np.arctan, **data}
    names |= {"pos": lambda a: np.maximum(a, 0.0), "dead": lambda a, g: np.sign(a) * np.maximum(np.abs(a) - g, 0.0)}
    return eval(text.replace("^", "**"), {"__builtins__": {}}, names) + 0.0 * data["x"]


def problems(data):
    """Name, true terms, training data and the tests."""
    with open(pathlib.Path(__file__).with_suffix(".csv"), newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        terms = row["terms"].split("; ")
        if row["rate"]:
            from scipy.integrate import solve_ivp

            times = np.linspace(0.0, 40.0, 5000)
            slope = lambda t, s: [s[1], float(rate(row["rate"], {"t": t, "x": s[0], "v": s[1]}))]
            x, v = solve_ivp(slope, (0.0, 40.0), [1.0, 0.0], "LSODA", times, rtol=1e-10, atol=1e-12).y
            all_of_it = {"t": times, "x": x, "v": v, "a": rate(row["rate"], {"t": times, "x": x, "v": v})}
            part = lambda which: {k: c[which] for k, c in all_of_it.items()}
            inside = 1 + EVERY * np.random.default_rng(0).choice(4500 // EVERY, 500, replace=False)
            yield row["problem"], terms, part(slice(0, 4500, EVERY)), part(inside), part(slice(4500, None))
        elif data:
            train, *tests = (formula.table(data / f"oscillator{row['problem'][-1]}_{k}.csv") for k in ("train", "test_id", "test_ood"))
            train.setdefault("t", formula.STEP * np.arange(len(train["x"])))
            order = np.argsort(train["t"])
            for test in tests:
                test.setdefault("t", 0.0 * test["x"])
            yield row["problem"], terms, {k: c[order][:: formula.EVERY] for k, c in train.items()}, *tests


def spec(folder, name, seen, unknown):
    np.savetxt(folder / f"{name}.csv", np.stack([seen[k] for k in "txv"], 1), delimiter=",", header="t,x,v", comments="", fmt="%.12g")
    first, last = seen["t"][0], seen["t"][-1]
    split = first + 0.7 * (last - first)
    record = f'path: "{name}.csv", time: "t", columns: {{ "x": "x", "v": "v" }}'
    (folder / f"{name}.ron").write_text(f"""(
    states: {{ "x": "m", "v": "m/s" }}, constants: {{ "m": (1.0, "kg"), "F": (0.0, "N") }},
    known: {{ "x": "v", "v": "F/m" }}, inertia: {{ "v": "m" }},{unknown}
    data: [
        Csv({record}, name: "first", window: ({first:.6f}, {split:.6f})),
        Csv({record}, name: "second", window: ({split:.6f}, {last:.6f}), role: Validate),
    ],
)
""")
    return folder / f"{name}.ron"


def asked(given, verb, path):
    run = [given.program, verb, str(path), "--format", "json", "-q", "--jobs", "1", "--limit", f"{given.limit}s"]
    done = subprocess.run(run, capture_output=True, text=True)
    return json.loads(done.stdout) if done.stdout.startswith("{") else {"refused": done.stderr.strip().split(": ", 3)[-1]}


def by_gap(given, name, seen):
    found = asked(given, "gap", spec(given.folder, name + "-gap", seen, ""))
    if "refused" in found:
        return f"refused: {found['refused']}", None
    forces = [step["force"] for step in found["steps"]]
    laws = ", ".join(step["law"] for step in found["steps"])
    text = "".join(f" - ({force})" for force in forces).strip() if forces and all(forces) else None
    return found["status"] + (f": {laws}" if laws else ""), text


def by_run(given, name, seen):
    candidates = ", ".join(f'"{term}"' for term in DICTIONARY)
    path = spec(given.folder, name + "-run", seen, f'\n    unknown: {{ "v": (candidates: [{candidates}]) }},')
    # States without units, for terms of all kinds stand beside each other.
    text = path.read_text()
    for old, new in {'"x": "m", "v": "m/s"': '"x": "", "v": ""', ', "F": (0.0, "N")': "", '"F/m"': '"0"', ' inertia: { "v": "m" },': ""}.items():
        text = text.replace(old, new)
    path.write_text(text)
    found = asked(given, "run", path)
    if "refused" in found:
        return f"refused: {found['refused']}", None
    return found["verdict"], next((e["text"] for e in found["equations"] if e["state"] == "v"), None)


def smooth(seen, noise):
    """Position, velocity and acceleration as PySINDy and PyOperon get them."""
    from scipy.signal import savgol_filter

    window = window_of(noise)
    step = (seen["t"][-1] - seen["t"][0]) / (len(seen["t"]) - 1)
    slope = lambda k: savgol_filter(seen["v"], window, 4, deriv=k, delta=step)
    inner = slice(window // 2, -(window // 2))
    return {"t": seen["t"][inner], "x": savgol_filter(seen["x"], window, 4)[inner], "v": slope(0)[inner]}, slope(1)[inner]


def window_of(noise):
    return 101 if noise else 11


def by_sindy(given, name, seen, noise):
    import pysindy

    states, due = smooth(seen, noise)
    columns = np.stack([rate(term, states) for term in DICTIONARY], 1)
    cut = len(due) * 4 // 5

    def fit(threshold, part):
        features = pysindy.CustomLibrary([lambda a: a], [lambda a: a])
        model = pysindy.SINDy(pysindy.STLSQ(threshold=threshold, alpha=1e-5, max_iter=200), features)
        model.fit(columns[part], t=states["t"][part], x_dot=due[part][:, None], feature_names=DICTIONARY)
        return model.coefficients()[0]

    best = (-np.inf, None)
    for threshold in mdbench.THRESHOLDS:
        numbers = fit(threshold, slice(0, cut))
        error = np.sum((columns[cut:] @ numbers - due[cut:]) ** 2) / np.sum(due[cut:] ** 2)
        score = 1 / (1 + error) + np.exp(-4 * np.count_nonzero(numbers) / 200)
        best = max(best, (score, threshold))
    numbers = fit(best[1], slice(None))
    return f"threshold {best[1]:g}", " + ".join(f"({float(c)!r})*{t}" for t, c in zip(DICTIONARY, numbers) if c) or "0"


def by_operon(given, name, seen, noise):
    from pyoperon.sklearn import SymbolicRegressor

    states, due = smooth(seen, noise)
    model = SymbolicRegressor(
        allowed_symbols="add,sub,mul,div,sin,cos,exp,tanh,constant,variable", max_time=given.operon, max_evaluations=1_000_000, optimizer_iterations=10,
        max_length=40, n_threads=1, random_state=given.seed,
    ).fit(np.stack([states[k] for k in "txv"], 1), due)
    return "", model.get_model_string(model.model_, 12, list("txv"))


def parts(text):
    """The terms of a formula, without their coefficients."""
    import sympy

    t, x, v = sympy.symbols("t x v", real=True)
    found = sympy.expand(sympy.sympify(text.replace("^", "**"), {"t": t, "x": x, "v": v, "abs": sympy.Abs, "ln": sympy.log, "sgn": sympy.sign}))
    return {sympy.Mul(*[f for f in sympy.Mul.make_args(term) if not f.is_number]) for term in sympy.Add.make_args(found)}


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("program", help="phisindy")
    arguments.add_argument("folder", type=pathlib.Path, help="where runs are kept")
    arguments.add_argument("--data", type=pathlib.Path, help="the folder of the two oscillators of LLM-SR")
    arguments.add_argument("--noise", default="0,0.01", help="parts of the standard deviation [0,0.01]")
    arguments.add_argument("--seed", type=int, default=5102, help="of the noise")
    arguments.add_argument("--limit", type=int, default=30, help="seconds for phisindy")
    arguments.add_argument("--operon", type=int, default=10, help="seconds for PyOperon")
    arguments.add_argument("--write", help="a document with the marks of the table")
    given = arguments.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    warnings.filterwarnings("ignore")
    np.seterr(all="ignore")
    tools = {GAP: by_gap, RUN: by_run, SINDY: by_sindy, OPERON: by_operon}
    tools = {t: f for t, f in tools.items() if t in (GAP, RUN) or mdbench.installed(t)}
    journal = given.folder / "runs.jsonl"
    key = lambda r: (r["problem"], r["noise"], r["by"])
    known = {key(r): r for r in mdbench.lines(journal) if r["seed"] == given.seed}
    rows = []
    for noise in map(float, given.noise.split(",")):
        for number, (problem, terms, train, *tests) in enumerate(problems(given.data)):
            random = np.random.default_rng([given.seed, number])
            seen = {k: c + (noise * c.std() * random.standard_normal(len(c)) if k in "xv" else 0.0) for k, c in train.items()}
            for tool, by in tools.items():
                if (problem, noise, tool) not in known:
                    begin = time.time()
                    name = f"{problem.replace(' ', '')}-{noise:g}"
                    says, text = by(given, name, seen) if tool in (GAP, RUN) else by(given, name, seen, noise)
                    run = {"problem": problem, "noise": noise, "by": tool, "seed": given.seed, "says": says, "text": text, "seconds": time.time() - begin}
                    known[(problem, noise, tool)] = run
                    with journal.open("a") as file:
                        file.write(json.dumps(run) + "\n")
                run = known[(problem, noise, tool)]
                errors, right = ["-", "-"], "-"
                if run["text"]:
                    errors = [f"{formula.error(rate(run['text'], t), t['a']):.1e}" for t in tests]
                    has = parts(run["text"])
                    true = set().union(*map(parts, terms))
                    right = f"{len(true & has)} of {len(true)}; {len(has)}"
                rows.append([problem, f"{100 * noise:g} %", tool, run["says"], *errors, right, f"{run['seconds']:.0f}"])
                print(*rows[-1], sep=" | ", flush=True)
    head = ["problem", "noise", "by", "verdict", "error in domain", "out of domain", "true terms that it has; its terms", "seconds"]
    text = tables.markdown(head, rows)
    print("\n" + text)
    if given.write:
        tables.write(given.write, "llm-srbench", text)


if __name__ == "__main__":
    main()
