#!/usr/bin/env python3
"""What `gap` makes of forty causes: missing bodies, dampers of practice, actuators, unmeasured pushes, walls, sensors, numbers that changed, and pairs of them, on one to three bodies.

    pip install numpy scipy && python3 bench/causes.py PROGRAM FOLDER --seeds 1,2 --write docs/results.md

A mass of 2 kg hangs on a spring of 800 N/m and a damper of 1.5 N s/m; further masses of 1 kg hang on it in a chain, each on 600 N/m and 1 N s/m. A measured force of
fourteen tones drives the first. All positions are known at 200 Hz for 8 s with 1 % noise: five seconds to fit, three to validate. What the model lacks is drawn from the
seed. SciPy's LSODA integrates it, with a steep tanh in the place of a jump; static friction and a wall take steps of 20 us.

An answer is *right* if its laws are the hidden ones at their places, or cannot be told from them, and each number is within 5 % or its interval. It is right too if it tells a push
to 0.05 s, or a turned sign. It is *honest* if it ends with exit code 1, else *wrong*. Answers are kept in FOLDER; the same command goes on from there.
"""
import argparse
import json
import pathlib
import re
import subprocess
import time
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

import tables

M, K, C, TIMES = 2.0, 800.0, 1.5, np.arange(0.0, 8.0, 0.005)
M2, K2, C2 = 1.0, 600.0, 1.0
NOTHING = lambda t, x, v, z, u: 0.0


@dataclass
class Rig:
    """What is hidden: a force taken from the mass (of a chain: from each), inner states and their rates, what acts in place of the drive, what the sensor shows; and
    the answers that are right, each the numbers of its laws. A law may be written with what its place is made of: `coulomb@v1 v2`."""
    answers: list
    force: object = NOTHING
    rates: object = None
    inner: int = 0
    acts: object = lambda u, t: u(t)
    shows: object = lambda x, z: x
    mass: float = M
    stiffness: float = K
    held: bool = False
    told: str = ""
    span: tuple = ()
    levels: tuple = ()
    wall: tuple = ()
    bodies: int = 1


def sign(v):
    return np.tanh(v / 2e-4)


def body(m, f, z):
    k = m * (2 * np.pi * f) ** 2
    c = 2 * z * np.sqrt(k * m)
    pull = lambda x, v, s: k * (x - s[0]) + c * (v - s[1])
    return dict(m=m, k=k), pull, lambda t, x, v, s, u: [s[1], pull(x, v, s) / m]


def dead(u, d):
    return np.sign(u) * max(abs(u) - d, 0.0)


def causes(r):
    """The rigs by name, numbers drawn by `r(low, high)`."""
    def hanging_body():
        numbers, pull, rates = body(r(.15, .5), r(2.5, 4.5), r(.01, .05))
        return Rig([{"hanging-body": numbers}], lambda t, x, v, z, u: pull(x, v, z), rates, 2)

    def body_and_coulomb():
        level, (numbers, pull, rates) = r(.8, 1.6), body(r(.15, .4), r(2.5, 4.5), .03)
        return Rig([{"hanging-body": numbers, "coulomb": {"Fc": level}}], lambda t, x, v, z, u: level * sign(v) + pull(x, v, z), rates, 2)

    def of_speed(law, force, **numbers):
        return Rig([{law: numbers}], lambda t, x, v, z, u: force(v))

    def stribeck():
        low, high, speed = r(.8, 1.6), r(1.5, 2.0), r(.01, .05)
        high *= low
        return of_speed("stribeck", lambda v: (low + (high - low) * np.exp(-(v / speed) ** 2)) * sign(v), Fc=low, Fs=high)

    def lagged(tau):
        return Rig(lag(tau), lambda t, x, v, z, u: u(t) - z[0], lambda t, x, v, z, u: [(u(t) - z[0]) / tau], 1)

    def lag(tau):
        # From rest a linear rig does not tell where the lag is.
        return [{"input-lag": {"tau": tau}}, {"sensor-lag": {"tau": tau}}]

    def tone(a, w):
        return Rig([{"harmonic-force": {"A": a, "w": w}}], lambda t, x, v, z, u: -a * np.cos(w * t + 1.0))

    def push(shape, at, w):
        return Rig([], lambda t, x, v, z, u: -shape(t) * (at < t < at + w), span=(at, at + w))

    def maxwell(k, tau):
        return Rig([{"maxwell": {"km": k, "cm": k * tau}}], lambda t, x, v, z, u: z[0], lambda t, x, v, z, u: [k * v - z[0] / tau], 1)

    def gain(g):
        # The whole rig may as well be lighter.
        return [{"input-gain": {"gain": g}}, {"sensor-gain": {"gain": g}}, {"changed-constant": {"m": M / g}}]

    def chain(bodies, answer, force, rates=None, inner=0):
        """A force `force(x, v, z)` taken from each mass of a chain."""
        return Rig([answer], lambda t, x, v, z, u: force(x, v, z), rates, inner, bodies=bodies)

    def between(force):
        """A force between the first two masses."""
        return lambda x, v, z: np.array([-1.0, 1.0, 0.0][: len(x)]) * force(x[1] - x[0], v[1] - v[0])

    def body_on_second():
        numbers, pull, rates = body(r(.1, .3), r(2.5, 6.0), r(.01, .05))
        return chain(2, {"hanging-body@v2": numbers}, lambda x, v, z: np.array([0.0, pull(x[1], v[1], z)]),
                     lambda t, x, v, z, u: rates(t, x[1], v[1], z, u), 2)

    def bouc_wen(k, level):
        rate = lambda t, x, v, z, u: [k * v - k / level * (.5 * abs(v) * z[0] + .5 * v * abs(z[0]))]
        return Rig([{"bouc-wen": {"A": k, "beta": .5 * k / level, "gamma": .5 * k / level}}], lambda t, x, v, z, u: z[0], rate, 1)

    def of(make, *ranges):
        return lambda: make(*[r(*low_high) for low_high in ranges])

    return {
        "a hanging body": hanging_body,
        "a hanging body and friction": body_and_coulomb,
        "a tone": of(tone, (1.5, 4), (12, 38)),
        "a push of half a sine": of(lambda a, at, w: push(lambda t: a * np.sin(np.pi * (t - at) / w), at, w), (4, 8), (1.5, 3.5), (.1, .4)),
        "a push that lasts": of(lambda a, at, w: push(lambda t: a, at, w), (1, 3), (1.0, 3.0), (.5, 1.2)),
        "gain of the drive": of(lambda g: Rig(gain(g), acts=lambda u, t: g * u(t)), (.75, .9)),
        "delay of the drive": of(lambda d: Rig([{"input-delay": {"tau": d}}, {"sensor-delay": {"tau": d}}], acts=lambda u, t: u(t - d)), (.01, .03)),
        "lag of the drive": of(lagged, (.01, .04)),
        "limit of the drive": of(lambda top: Rig([{"input-saturation": {"top": top}}], acts=lambda u, t: np.clip(u(t), -top, top)), (14, 20)),
        "dead band of the drive": of(lambda d: Rig([{"input-dead-band": {"d": d}}], acts=lambda u, t: dead(u(t), d)), (1, 3)),
        "sign of the drive": lambda: Rig([], acts=lambda u, t: -u(t), told="other sign"),
        "Coulomb friction": of(lambda f: of_speed("coulomb", lambda v: f * sign(v), Fc=f), (.5, 3)),
        "Stribeck friction": stribeck,
        "a digressive damper": of(lambda c, s: of_speed("digressive-damping", lambda v: c * v / (1 + abs(v) / s), c=c, vd=s), (10, 25), (.05, .15)),
        "a damper of one direction": of(lambda c: of_speed("bilinear-damping", lambda v: c * max(v, 0), cb=c), (5, 15)),
        "a damper behind a spring": of(maxwell, (200, 600), (.02, .08)),
        "drag": of(lambda d: of_speed("quadratic-drag", lambda v: d * v * abs(v), d=d), (5, 20)),
        "a stop": of(lambda g, k: Rig([{"one-sided-stop": {"gap": g, "ks": k}}], lambda t, x, v, z, u: k * max(x - g, 0)), (.06, .09), (1500, 5000)),
        "a cubic spring": of(lambda k: Rig([{"cubic-stiffness": {"k3": k}}], lambda t, x, v, z, u: k * x**3), (2e5, 6e5)),
        "a softer spring": of(lambda f: Rig([{"stiffness": {"dk": (f - 1) * K}}, {"changed-constant": {"k": f * K}}], stiffness=f * K, held=True), (.8, .92)),
        "a larger mass": of(lambda f: Rig([{"changed-constant": {"m": f * M}}], mass=f * M, held=True), (1.08, 1.2)),
        "a spring that softens": of(lambda f: Rig([{"drifting-stiffness": {"r": -f * K / 8}}], lambda t, x, v, z, u: -f * K * t / 8 * x), (.15, .3)),
        "gain of the sensor": of(lambda g: Rig(gain(g), shows=lambda x, z: g * x, held=True), (1.1, 1.3)),
        "offset of the sensor": of(lambda o: Rig([{"sensor-offset": {"offset": o}}, {"offset": {"f0": o * K}}], shows=lambda x, z: x + o), (.02, .04)),
        "lag of the sensor": of(lambda tau: Rig(lag(tau), rates=lambda t, x, v, z, u: [(x - z[0]) / tau], inner=1, shows=lambda x, z: z[0]), (.01, .03)),
        "friction and a cubic spring": of(lambda f, k: Rig([{"coulomb": {"Fc": f}, "cubic-stiffness": {"k3": k}}], lambda t, x, v, z, u: f * sign(v) + k * x**3), (1, 2), (3e5, 6e5)),
        "friction and a dead band": of(lambda f, d: Rig([{"coulomb": {"Fc": f}, "input-dead-band": {"d": d}}], lambda t, x, v, z, u: f * sign(v), acts=lambda u, t: dead(u(t), d)), (.8, 1.6), (1, 2.5)),
        "nothing": lambda: Rig([{}]),
        "static friction": of(lambda f, more: Rig([{"breakaway": {"Fc": f, "Fs": f * more}}], levels=(f, f * more)), (5, 10), (1.5, 3)),
        "a wall": of(lambda at, e: Rig([{"impact": {"x0": at, "e": e}}], wall=(at, e)), (-.06, -.03), (.4, .9)),
        "friction between two bodies": of(lambda f: chain(2, {"coulomb@v1 v2": {"Fc": f}}, between(lambda d, w: f * sign(w))), (.3, 1)),
        "friction of both bodies": of(lambda f, g: chain(2, {"coulomb@v1": {"Fc": f}, "coulomb@v2": {"Fc": g}}, lambda x, v, z: np.array([f, g]) * sign(v)), (.8, 1.6), (.3, .8)),
        "friction of the second of three": of(lambda f: chain(3, {"coulomb@v2": {"Fc": f}}, lambda x, v, z: np.array([0, f, 0]) * sign(v)), (.3, 1)),
        "a spring between two bodies that hardens": of(lambda k: chain(2, {"cubic-stiffness@v1 v2": {"k3": k}}, between(lambda d, w: k * d**3)), (1e5, 4e5)),
        "a stop between two bodies": of(lambda g, k: chain(2, {"one-sided-stop@v1 v2": {"gap": g, "ks": k}}, between(lambda d, w: k * max(d - g, 0))), (.02, .04), (1500, 5000)),
        "a body on the second of two": body_on_second,
        "an element that yields": of(bouc_wen, (300, 800), (2, 5)),
        "teeth": of(lambda a, n: Rig([{"cogging": {"A": a, "n": n}}], lambda t, x, v, z, u: a * np.sin(n * x + 1.0)), (1, 3), (100, 300)),
        "friction of two directions": of(lambda f, g: Rig([{"asymmetric-coulomb": {"Fp": f * g, "Fm": f}}, {"coulomb": {"Fc": f * (1 + g) / 2}, "offset": {"f0": f * (g - 1) / 2}}],
            lambda t, x, v, z, u: f * (1 + g) / 2 * sign(v) + f * (g - 1) / 2), (1, 2), (1.3, 1.8)),
        "friction and drag": of(lambda f, d: Rig([{"coulomb": {"Fc": f}, "quadratic-drag": {"d": d}}], lambda t, x, v, z, u: f * sign(v) + d * v * abs(v)), (.8, 1.6), (5, 15)),
    }


def stepped(rig, u):
    """The motion in short steps: static friction acts at rest, and a body that turns is at rest for an instant; a wall turns the speed."""
    h, every = 2e-5, 250
    slide, hold = rig.levels or (0.0, 0.0)
    at, left = rig.wall or (-np.inf, 0.0)
    x = v = 0.0
    shown = []
    for step, push in enumerate(u(np.arange(len(TIMES) * every) * h).tolist()):
        if step % every == 0:
            shown.append(x)
        most = h * (hold if v == 0.0 else slide) / rig.mass
        free = v + h * (push - C * v - rig.stiffness * x) / rig.mass
        after = free - min(max(free, -most), most)
        v = 0.0 if hold > 0.0 and v * after < 0.0 else after
        x += h * v
        if x < at and v < 0.0:
            v = -left * v
    return np.array(shown)


def record(rig, rng):
    """The drive and the noisy column."""
    tones, phases = np.linspace(.4, 7, 14) + rng.uniform(-.05, .05, 14), rng.uniform(0, 2 * np.pi, 14)
    u = lambda t: 20 * np.sqrt(2 / 14) * np.sum(np.cos(2 * np.pi * tones * np.asarray(t)[..., None] + phases), -1)

    n = rig.bodies

    def rate(t, y):
        x, v, z = y[:n], y[n:2 * n], y[2 * n:]
        # What acts in each link of the chain, the first of which hangs on the ground.
        link = np.array([rig.stiffness, K2, K2])[:n] * np.diff(x, prepend=0.0) + np.array([C, C2, C2])[:n] * np.diff(v, prepend=0.0)
        if n == 1:
            x, v = x[0], v[0]
        push = np.append(rig.acts(u, t), np.zeros(n - 1)) - rig.force(t, x, v, z, u) - link + np.append(link[1:], 0.0)
        return np.concatenate([np.atleast_1d(v), push / np.array([rig.mass, M2, M2])[:n], rig.rates(t, x, v, z, u) if rig.inner else []])

    if rig.levels or rig.wall:
        columns = [stepped(rig, u)]
    else:
        y = solve_ivp(rate, (0, TIMES[-1]), np.zeros(2 * n + rig.inner), t_eval=TIMES, method="LSODA", rtol=1e-7, atol=1e-10, max_step=.005).y
        columns = [rig.shows(x, y[2 * n:]) for x in y[:n]]
    return u(TIMES), [column + .01 * np.std(column) * rng.standard_normal(len(column)) for column in columns]


def chain_spec(rig, file):
    """The chain, each number of a link free within bounds."""
    n = rig.bodies
    free = lambda name, value, unit, low, high: f'"{name}": (value: {value}, unit: "{unit}", within: ({low}, {high}))'
    constants = ['"m1": (2.0, "kg")', *[f'"m{i}": (1.0, "kg")' for i in range(2, n + 1)], free("k1", K, "N/m", .8 * K, 1.2 * K), free("c1", C, "N*s/m", 0.0, 6.0)]
    constants += [free(f"k{i}", K2, "N/m", .8 * K2, 1.2 * K2) for i in range(2, n + 1)] + [free(f"c{i}", C2, "N*s/m", 0.0, 4.0) for i in range(2, n + 1)]
    link = lambda i: f"k{i}*(x{i}-x{i-1}) + c{i}*(v{i}-v{i-1})" if i > 1 else "k1*x1 + c1*v1"
    rates = [f'"x{i}": "v{i}", "v{i}": "({"F" if i == 1 else "0"} - ({link(i)}){f" + {link(i + 1)}" if i < n else ""})/m{i}"' for i in range(1, n + 1)]
    columns = "".join(f'"x{i}": ("x{i}", "m"), ' for i in range(1, n + 1))
    part = lambda name, low, high, role: f'Csv(path: "{file}", name: "{name}", time: ("t", "s"), columns: {{ {columns}"F": ("F", "N") }}, window: ({low}, {high}), role: {role})'
    states = ", ".join(f'"x{i}": "m", "v{i}": "m/s"' for i in range(1, n + 1))
    inertia = ", ".join(f'"v{i}": "m{i}"' for i in range(1, n + 1))
    return f"""(constants: {{ {", ".join(constants)} }}, states: {{ {states} }}, inputs: {{ "F": "N" }},
    known: {{ {", ".join(rates)} }}, inertia: {{ {inertia} }}, unknown: {{}},
    data: [{part("a", 0.0, 5.0, "Fit")}, {part("b", 5.0, 8.0, "Validate")}])
"""


def spec(rig, file):
    if rig.bodies > 1:
        return chain_spec(rig, file)
    k, c = ('(800.0, "N/m")', '(1.5, "N*s/m")') if rig.held else ('(value: 800.0, unit: "N/m", within: (640.0, 960.0))', '(value: 1.5, unit: "N*s/m", within: (0.0, 6.0))')
    part = lambda name, low, high, role: f'Csv(path: "{file}", name: "{name}", time: ("t", "s"), columns: {{ "x": ("x", "m"), "F": ("F", "N") }}, window: ({low}, {high}), role: {role})'
    return f"""(constants: {{ "m": (2.0, "kg"), "k": {k}, "c": {c} }}, states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "F": "N" }},
    known: {{ "x": "v", "v": "(F - c*v - k*x)/m" }}, inertia: {{ "v": "m" }}, contacts: ["v"], unknown: {{}},
    data: [{part("a", 0.0, 5.0, "Fit")}, {part("b", 5.0, 8.0, "Validate")}])
"""


def judged(rig, code, answer):
    pushes = answer.get("pushes") or []
    if rig.span and len(pushes) == 1 and np.allclose([pushes[0]["from"], pushes[0]["to"]], rig.span, atol=.05):
        return "right"
    if rig.told and any(rig.told in warning for warning in answer["warnings"]):
        return "right"
    steps = [(step["law"], " ".join(sorted(re.findall(r"[a-z]\w*", step["at"] or ""))), step["parameters"]) for step in answer["steps"]]

    def near(p, due):
        low, high = p["ci95"]
        return low <= due <= high or abs(p["value"] - due) <= .05 * abs(due)

    def is_there(name, numbers):
        law, _, place = name.partition("@")
        return any(law == found and place in ("", at) and all(near(has[n], value) for n, value in numbers.items() if n in has) for found, at, has in steps)

    same = lambda due: len(due) == len(steps) and all(is_there(name, numbers) for name, numbers in due.items())
    if code == 0:
        return "right" if any(same(due) for due in rig.answers) else "wrong"
    return "honest, with the right laws" if any(same(due) for due in rig.answers if due) else "honest"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--seeds", default="1,2")
    parser.add_argument("--write")
    args = parser.parse_args()
    seeds = [int(s) for s in args.seeds.split(",")]
    args.folder.mkdir(parents=True, exist_ok=True)
    rows, counts = [], {}
    for number, name in enumerate(causes(lambda low, high: low)):
        row, seconds = [], []
        for seed in seeds:
            rng = np.random.default_rng([seed, number])
            rig = causes(rng.uniform)[name]()
            drive, columns = record(rig, rng)
            stem = args.folder / f"{number:02}_{seed}"
            result = stem.with_suffix(".json")
            if not result.exists():
                names = ["x"] if rig.bodies == 1 else [f"x{i + 1}" for i in range(rig.bodies)]
                np.savetxt(stem.with_suffix(".csv"), np.array([TIMES, *columns, drive]).T, delimiter=",", header=",".join(["t", *names, "F"]), comments="", fmt="%.9g")
                stem.with_suffix(".ron").write_text(spec(rig, stem.with_suffix(".csv").name))
                began = time.time()
                done = subprocess.run([args.program, "gap", str(stem.with_suffix(".ron")), "--format", "json", "--quiet"], capture_output=True, text=True)
                answer = json.loads(done.stdout)
                result.write_text(json.dumps({"code": done.returncode, "seconds": time.time() - began, "answer": answer}))
            kept = json.loads(result.read_text())
            verdict = judged(rig, kept["code"], kept["answer"])
            said = ", ".join(step["law"] for step in kept["answer"]["steps"]) or kept["answer"]["status"]
            print(f"{name} (seed {seed}): {verdict}: {kept['answer']['status']}, {said}, due {rig.answers or rig.told or rig.span}", flush=True)
            counts[verdict] = counts.get(verdict, 0) + 1
            row.append(f"{verdict} ({said})" if verdict != "right" else "right")
            seconds.append(kept["seconds"])
        rows.append([name, *row, f"{np.mean(seconds):.0f}"])
    head = ["hidden", *[f"seed {s}" for s in seeds], "seconds"]
    all_of = ", ".join(f"{count} {verdict}" for verdict, count in sorted(counts.items(), key=lambda c: -c[1]))
    text = tables.markdown(head, rows) + f"\nAll: {all_of}.\n"
    print(text)
    if args.write:
        tables.write(args.write, "causes", text)


if __name__ == "__main__":
    main()
