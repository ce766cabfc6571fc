#!/usr/bin/env python3
"""The stick-slip cycle of case 1a simulated by phisindy, by diffsol (Rust) and by scipy, each with the tolerance that it needs for the same error.

    pip install scipy
    python3 bench/stick_slip.py

All three locate each stop and each departure. phisindy reads them off the text of the model; for the others the modes are written by hand, here and in
`bench/diffsol`. The error is the largest of displacement and velocity at 5000 times, against phisindy at its tightest tolerance; that reference is itself
compared with scipy at its tightest one. The tolerance is the largest of 10^(-k/4) that meets the error. The shortest of many runs counts.
"""
import math
import pathlib
import subprocess
import time

import numpy
from scipy.integrate import solve_ivp

HERE = pathlib.Path(__file__).resolve().parent
PROGRAM = HERE / "diffsol" / "target" / "release" / "phisindy-bench-diffsol"
M, C, K, F, W, MU = 1.0, 0.1, 1.0, 1.0, 0.3, 0.5
START, END, SAMPLES = [0.1, 0.1], 50.0, 5000
TIMES = END / SAMPLES * numpy.arange(SAMPLES)
TOLERANCES = [10 ** (-k / 4) for k in range(16, 53)]


def load(x, t):
    """What pulls at a mass that stands still."""
    return F * math.cos(W * t) - K * x


def scipy_run(method, tolerance):
    """States at the samples, and the number of steps."""
    states, steps = numpy.empty((SAMPLES, 2)), 0
    t, x, direction, done = 0.0, START, 1.0, 0
    while done < SAMPLES:
        if direction:
            rates = lambda t, x: [x[1], (load(x[0], t) - C * x[1] - MU * direction) / M]
            stop = lambda t, x: x[1]
            stop.direction = -direction
        else:
            rates = lambda t, x: [0.0, 0.0]
            stop = lambda t, x: MU - abs(load(x[0], t))
            stop.direction = -1
        stop.terminal = True
        part = solve_ivp(rates, (t, END), x, method, events=stop, dense_output=True, rtol=tolerance, atol=tolerance)
        steps += len(part.t) - 1
        ends = int(numpy.searchsorted(TIMES, part.t[-1], "right"))
        if ends > done:
            states[done:ends] = part.sol(TIMES[done:ends]).T
        done = ends
        t, x = part.t[-1], [part.y[0, -1], 0.0]
        direction = 0.0 if direction and abs(load(x[0], t)) <= MU else math.copysign(1.0, load(x[0], t))
    return states, steps


def with_scipy(method):
    def run(tolerance):
        best = math.inf
        for _ in range(10):
            begin = time.perf_counter()
            states, steps = scipy_run(method, tolerance)
            best = min(best, time.perf_counter() - begin)
        return states, steps, 1e6 * best

    return run


def with_program(*which):
    def run(*tolerance):
        done = subprocess.run([PROGRAM, *which, *map(repr, tolerance)], capture_output=True, text=True, check=True)
        head, *rows = done.stdout.splitlines()
        steps, microseconds = head.split()
        return numpy.array([row.split() for row in rows], float), int(steps), float(microseconds)

    return run


def main():
    subprocess.run(["cargo", "build", "-q", "--release"], cwd=HERE / "diffsol", check=True)
    reference = with_program("reference")()[0]
    error = lambda states: float(numpy.abs(states - reference).max())
    print(f"reference: within {error(scipy_run('DOP853', 1e-13)[0]):.0e} of scipy's DOP853 at its tightest tolerance\n")
    tools = {
        "phisindy": with_program("phisindy"),
        "diffsol, Tsitouras 5(4), modes by hand": with_program("diffsol"),
        "scipy, DOP853, modes by hand": with_scipy("DOP853"),
        "scipy, RK45, modes by hand": with_scipy("RK45"),
    }
    print("| 50 s of stick-slip, 5000 samples | error asked | tolerance | error | steps | time | beside phisindy |")
    print("|---|---|---|---|---|---|---|")
    for asked in (1e-6, 1e-9):
        ours = None
        for name, run in tools.items():
            found = next(((t, *r) for t, r in ((t, run(t)) for t in TOLERANCES) if error(r[0]) < asked), None)
            if found is None:
                print(f"| {name} | {asked:.0e} | - | not met | - | - | - |")
                continue
            tolerance, states, steps, microseconds = found
            ours = ours or microseconds
            print(
                f"| {name} | {asked:.0e} | {tolerance:.0e} | {error(states):.1e} | {steps} | {microseconds / 1e3:.2f} ms "
                f"| {microseconds / ours:.1f} times |"
            )


main()
