#!/usr/bin/env python3
"""The oscillators of LLM-SR (Shojaee et al. 2025): the right side as a formula, by `phisindy run` and by symbolic regression.

    bench/formula.py PROGRAM DATA FOLDER [NOISE,NOISE [SEED [DOCUMENT]]]

DATA holds `oscillator{1,2}_{train,test_id,test_ood}.csv` of github.com/deep-symbolic-mathematics/LLM-SR. The program gets positions with
noise (a part of their standard deviation; with 0, positions and velocities), and no more of the equation than the drive that depends on time:
`unknown: { "v": (search: ["x", "v"]) }`.
PyOperon (`pip install pyoperon`), if it is there, gets the same positions, differentiated by a Savitzky-Golay filter. The error is that of
LLM-SR: the mean square of the acceleration that is missed over its variance, in and out of the domain of the training data.
"""

import csv
import json
import pathlib
import re
import subprocess
import sys
import time

import numpy as np

import tables

STEP = 0.002000040000800016
EVERY = 4
DRIVES = {1: 0.0, 2: 0.3}


def table(path):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def drive(number, data):
    return DRIVES[number] * np.sin(data["t"]) if "t" in data else 0.0 * data["x"]


def value(rate, data):
    names = {
        "abs": np.abs, "sgn": np.sign, "sin": np.sin, "cos": np.cos, "tanh": np.tanh, "atan": np.arctan, "exp": np.exp, "ln": np.log,
        "pos": lambda a: np.maximum(a, 0.0), "dead": lambda a, g: np.sign(a) * np.maximum(np.abs(a) - g, 0.0),
        "x": data["x"], "v": data["v"], "t": data.get("t", 0.0),
    }
    return eval(re.sub(r"\^", "**", rate), {"__builtins__": {}}, names) + 0.0 * data["x"]


def error(found, due):
    return float(np.mean((found - due) ** 2) / np.var(due))


def spec(number, name, times, noise):
    columns = '{ "x": "x" }' if noise else '{ "x": "x", "v": "v" }'
    split = times[0] + 0.7 * (times[-1] - times[0])
    force, constants = ("0", "") if number == 1 else ("F*sin(W*t)", ', "F": (0.3, "N"), "W": (1.0, "rad/s")')
    return f"""(
    states: {{ "x": "m", "v": "m/s" }}, constants: {{ "m": (1.0, "kg"){constants} }},
    known: {{ "x": "v", "v": "({force})/m" }}, inertia: {{ "v": "m" }}, unknown: {{ "v": (search: ["x", "v"]) }},
    data: [
        Csv(path: "{name}.csv", name: "first", time: "t", columns: {columns}, window: ({times[0]:.6f}, {split:.6f})),
        Csv(path: "{name}.csv", name: "second", time: "t", columns: {columns}, window: ({split:.6f}, {times[-1]:.6f}), role: Validate),
    ],
)
"""


def by_program(program, folder, number, times, x, v, noise):
    name = f"oscillator{number}"
    np.savetxt(folder / f"{name}.csv", np.stack([times, x, v], 1), delimiter=",", header="t,x,v", comments="", fmt="%.12g")
    (folder / f"{name}.ron").write_text(spec(number, name, times, noise))
    run = [program, "run", str(folder / f"{name}.ron"), "--data", str(folder), "--format", "json", "-q"]
    found = json.loads(subprocess.run(run, capture_output=True, text=True).stdout)
    equation = next((e["text"] for e in found["equations"] if e["state"] == "v"), "")
    without = any("no formula" in doubt for doubt in found["warnings"] + found.get("doubts", []))
    return "none found" if without else found["verdict"], equation, found["seconds"]


def by_operon(x, noise):
    """A model of the acceleration without its drive, from positions alone."""
    from pyoperon.sklearn import SymbolicRegressor
    from scipy.signal import savgol_filter

    # The window that the noise asks for: a fiftieth of the record, or the shortest.
    window = 201 if noise else 11
    smooth = [savgol_filter(x, window, 4, deriv=k, delta=EVERY * STEP) for k in range(3)]
    return SymbolicRegressor, smooth, slice(window, -window)


def rows(program, data, folder, noise, seed):
    """A row for each oscillator and tool."""
    for number in DRIVES:
        train = table(data / f"oscillator{number}_train.csv")
        tests = [table(data / f"oscillator{number}_test_{kind}.csv") for kind in ("id", "ood")]
        random = np.random.default_rng(seed)
        noisy = [train[k] + noise * train[k].std() * random.standard_normal(len(train[k])) for k in ("x", "v")]
        times = train["t"] if "t" in train else STEP * np.arange(len(train["x"]))
        times, x, v = (column[::EVERY] for column in (times, *noisy))

        def row(by, what, model, seconds):
            errors = [f"{error(model(t), t['a']):.1e}" for t in tests] if model else ["-", "-"]
            return [number, f"{100 * noise:g} %", by, what, *errors, f"{seconds:.0f}"]

        verdict, equation, seconds = by_program(program, folder, number, times, x, v, noise)
        model = None if verdict == "none found" else (lambda t: value(equation, t))
        yield row("phisindy run", f"{verdict}: `{rounded(equation)}`" if model else verdict, model, seconds)
        try:
            regressor, (xs, vs, accelerations), inner = by_operon(x, noise)
        except ImportError:
            continue
        begin = time.time()
        due = accelerations - DRIVES[number] * np.sin(times)
        fitted = regressor(
            allowed_symbols="add,sub,mul,div,sin,cos,exp,tanh,constant,variable", max_time=60, max_evaluations=1_000_000,
            optimizer_iterations=10, max_length=40, n_threads=1, random_state=seed,
        ).fit(np.stack([xs, vs], 1)[inner], due[inner])
        size = len(re.findall(r"[a-z]+|[-+*/]|[0-9.]+", fitted.get_model_string(fitted.model_, 4, ["x", "v"])))
        found = lambda t: fitted.predict(np.stack([t["x"], t["v"]], 1)) + drive(number, t)
        yield row("PyOperon", f"a formula of {size} symbols", found, time.time() - begin)


def rounded(text):
    """The text with four digits in its numbers."""
    return re.sub(r"[0-9]+[.][0-9]+(e-?[0-9]+)?", lambda m: f"{float(m[0]):.4g}", text)


def main():
    program, data, folder = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    noises = [float(n) for n in (sys.argv[4] if len(sys.argv) > 4 else "0,0.01").split(",")]
    seed = int(sys.argv[5] if len(sys.argv) > 5 else 1)
    folder.mkdir(parents=True, exist_ok=True)
    head = ["oscillator", "noise", "by", "formula of the rate", "error in domain", "out of domain", "seconds"]
    all_rows = []
    for noise in noises:
        for row in rows(program, data, folder, noise, seed):
            all_rows.append(row)
            print(*row, sep=" | ", flush=True)
    if len(sys.argv) > 6:
        tables.write(sys.argv[6], "llm-sr", tables.markdown(head, all_rows))


if __name__ == "__main__":
    main()
