#!/usr/bin/env python3
"""The oscillators of LLM-SR (Shojaee et al. 2025): the right side as a formula, by `phisindy gap` and by symbolic regression.

    bench/formula.py PROGRAM DATA FOLDER [NOISE [SEED]]

DATA holds `oscillator{1,2}_{train,test_id,test_ood}.csv` of github.com/deep-symbolic-mathematics/LLM-SR. The program gets positions with
noise (a part of their standard deviation; with 0, positions and velocities), and no more of the equation than the drive that depends on time.
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

STEP = 0.002000040000800016
EVERY = 4
DRIVES = {1: 0.0, 2: 0.3}


def table(path):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def drive(number, data):
    return DRIVES[number] * np.sin(data["t"]) if "t" in data else 0.0 * data["x"]


def value(force, x, v):
    names = {
        "abs": np.abs, "sgn": np.sign, "sin": np.sin, "cos": np.cos, "tanh": np.tanh, "atan": np.arctan, "exp": np.exp, "ln": np.log,
        "pos": lambda a: np.maximum(a, 0.0), "dead": lambda a, g: np.sign(a) * np.maximum(np.abs(a) - g, 0.0), "x": x, "v": v,
    }
    return eval(re.sub(r"\^", "**", force), {"__builtins__": {}}, names)


def error(found, due):
    return float(np.mean((found - due) ** 2) / np.var(due))


def spec(number, name, times, noise):
    columns = '{ "x": "x" }' if noise else '{ "x": "x", "v": "v" }'
    split = times[0] + 0.7 * (times[-1] - times[0])
    force, constants = ("0", "") if number == 1 else ("F*sin(W*t)", ', "F": (0.3, "N"), "W": (1.0, "rad/s")')
    return f"""(
    states: {{ "x": "m", "v": "m/s" }}, constants: {{ "m": (1.0, "kg"){constants} }},
    known: {{ "x": "v", "v": "({force})/m" }}, inertia: {{ "v": "m" }}, unknown: {{}},
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
    run = [program, "gap", str(folder / f"{name}.ron"), "--data", str(folder), "--format", "json", "-q"]
    found = json.loads(subprocess.run(run, capture_output=True, text=True).stdout)
    steps = found["steps"] + found["partial"]
    forces = [step["force"] for step in steps]
    text = " + ".join(f"({f})" for f in forces) if forces and all(forces) else ""
    return found["status"], text, found["seconds"]


def by_operon(x, noise):
    """A model of the acceleration without its drive, from positions alone."""
    from pyoperon.sklearn import SymbolicRegressor
    from scipy.signal import savgol_filter

    # The window that the noise asks for: a fiftieth of the record, or the shortest.
    window = 201 if noise else 11
    smooth = [savgol_filter(x, window, 4, deriv=k, delta=EVERY * STEP) for k in range(3)]
    return SymbolicRegressor, smooth, slice(window, -window)


def main():
    program, data, folder = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    noise, seed = float(sys.argv[4] if len(sys.argv) > 4 else 0.01), int(sys.argv[5] if len(sys.argv) > 5 else 1)
    folder.mkdir(parents=True, exist_ok=True)
    print("| oscillator | noise | by | status, formula | error in domain | out of domain | s |\n| --- | --- | --- | --- | --- | --- | --- |")
    for number in DRIVES:
        train = table(data / f"oscillator{number}_train.csv")
        tests = [table(data / f"oscillator{number}_test_{kind}.csv") for kind in ("id", "ood")]
        random = np.random.default_rng(seed)
        noisy = [train[k] + noise * train[k].std() * random.standard_normal(len(train[k])) for k in ("x", "v")]
        times = train["t"] if "t" in train else STEP * np.arange(len(train["x"]))
        times, x, v = (column[::EVERY] for column in (times, *noisy))

        def row(by, what, model, seconds):
            errors = [f"{error(model(t) + drive(number, t), t['a']):.1e}" for t in tests] if model else ["-", "-"]
            print(f"| {number} | {noise:g} | {by} | {what} | {errors[0]} | {errors[1]} | {seconds:.0f} |", flush=True)

        status, force, seconds = by_program(program, folder, number, times, x, v, noise)
        model = (lambda t: -value(force, t["x"], t["v"])) if force else None
        row("phisindy gap", f"{status}: `{force}`", model, seconds)
        try:
            regressor, (xs, vs, accelerations), inner = by_operon(x, noise)
        except ImportError:
            continue
        begin = time.time()
        due = accelerations - (DRIVES[number] * np.sin(times))
        fitted = regressor(
            allowed_symbols="add,sub,mul,div,sin,cos,exp,tanh,constant,variable", max_time=60, max_evaluations=1_000_000,
            optimizer_iterations=10, max_length=40, n_threads=1, random_state=seed,
        ).fit(np.stack([xs, vs], 1)[inner], due[inner])
        formula = fitted.get_model_string(fitted.model_, 4, ["x", "v"]) if hasattr(fitted, "model_") else ""
        row("PyOperon", f"`{formula}`", lambda t: fitted.predict(np.stack([t["x"], t["v"]], 1)), time.time() - begin)


if __name__ == "__main__":
    main()
