#!/usr/bin/env python3
"""Formulas of laws that are in no catalogue: makes sets, runs `phisindy gap`, compares the force.

    bench/formula.py PROGRAM FOLDER [NOISE [SEED]]

Each set is a driven mass on a spring that lacks one force; its records are made by the program. The force that is found
(`steps[].force`) is compared with the true one along a motion of 1.0 and of 1.4 times the excitation that is not used.
"""

import json
import math
import pathlib
import re
import subprocess
import sys

LAWS = {
    "power 1.5": "0.35*abs(v)^1.5*sgn(v)",
    "root of v": "0.25*abs(v)^0.5*sgn(v)",
    "root of x": "0.5*abs(x)^0.5*sgn(x)",
    "fifth power": "0.03*x^5 - 0.1*x^3",
    "sine": "0.6*sin(3*x)",
    "|x| v": "0.4*abs(x)*v",
    "rational friction": "0.35*sgn(v)/(1 + abs(v)/0.3)",
    "exponential": "0.2*(exp(1.2*x) - 1)",
    "x |x|": "0.5*x*abs(x)",
    "atan": "0.5*atan(v/0.2)",
    "v exp(-x^2)": "0.6*v*exp(-x^2)",
    "tanh": "0.8*tanh(3*x)",
    "x^2 v": "0.5*x^2*v - 0.15*v",
    "falling damper": "0.9*v/(1 + v^2)",
    "cos x v": "0.3*cos(2*x)*v + 0.1*v",
    "x v^2": "0.3*x*v^2",
    "damper and spring": "0.3*abs(v)^1.5*sgn(v) + 0.1*x^5",
    "nothing": "0",
}


def spec(force, noise, seed, size=1.0):
    def record(seed, role, size, start):
        return (
            f'Synthetic(truth: {{ "v": "-({force})" }}, start: {{ "x": {start}, "v": 0.0 }}, duration: 60.0, step: 0.02, '
            f'noise: {f"Relative({noise})" if noise else "None"}, constants: {{ "A": ({size}, "N") }}, seed: {seed}{role}),'
        )

    return f"""(
    constants: {{ "m": (1.0, "kg"), "d": (0.1, "N*s/m"), "k": (1.0, "N/m") }},
    states: {{ "x": "m", "v": "m/s" }},
    known: {{ "x": "v", "v": "(-d*v - k*x + A*cos(0.7*t) + 0.6*A*sin(1.9*t) + 0.4*A*cos(0.31*t))/m" }},
    inertia: {{ "v": "m" }},
    unknown: {{}},
    data: [
        {record(seed, "", size, 0.3)}
        {record(seed + 1000, ", role: Validate", 0.9 * size, -0.4)}
    ],
)
"""


def value(force, x, v):
    names = {
        "abs": abs, "sgn": lambda a: (a > 0) - (a < 0), "sin": math.sin, "cos": math.cos, "tanh": math.tanh,
        "atan": math.atan, "exp": math.exp, "pos": lambda a: max(a, 0.0), "x": x, "v": v,
        "dead": lambda a, g: math.copysign(max(abs(a) - g, 0.0), a),
    }
    text = re.sub(r"\|([^|]+)\|", r"abs(\1)", force).replace("^", "**")
    return eval(text, {"__builtins__": {}}, names)


def motion(program, folder, force, size):
    path = folder / "motion.ron"
    path.write_text(spec(force, 0, 7, size))
    out = subprocess.run([program, "simulate", str(path), "-q"], capture_output=True, text=True, check=True).stdout
    lines = [line for line in out.splitlines() if line and line[0] not in "#"]
    names = [re.split(r"[ (\[]", name.strip())[0] for name in lines[0].split(",")]
    rows = [line.split(",") for line in lines[1:]]
    return [(float(r[names.index("x")]), float(r[names.index("v")])) for r in rows[::5]]


def error(found, true, points):
    due = [value(true, x, v) for x, v in points]
    got = [value(found, x, v) for x, v in points]
    size = math.sqrt(sum(d * d for d in due))
    return math.sqrt(sum((d - g) ** 2 for d, g in zip(due, got))) / size if size else float("nan")


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    noise, seed = float(sys.argv[3] if len(sys.argv) > 3 else 0.02), int(sys.argv[4] if len(sys.argv) > 4 else 1)
    folder.mkdir(parents=True, exist_ok=True)
    print("| hidden | status | found | error of the force | at 1.4 times | s |\n| --- | --- | --- | --- | --- | --- |")
    for name, force in LAWS.items():
        path = folder / "set.ron"
        path.write_text(spec(force, noise, seed))
        run = subprocess.run([program, "gap", str(path), "--format", "json", "-q"], capture_output=True, text=True)
        found = json.loads(run.stdout)
        forces = [step["force"] for step in found["steps"] if step.get("force")]
        text = " + ".join(f"({f})" for f in forces)
        errors = ["", ""]
        if text and name != "nothing":
            errors = [f"{error(text, force, motion(program, folder, force, s)):.4f}" for s in (1.0, 1.4)]
        print(f"| {name} | {found['status']} | `{text}` | {errors[0]} | {errors[1]} | {found['seconds']:.0f} |", flush=True)


if __name__ == "__main__":
    main()
