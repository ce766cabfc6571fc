#!/usr/bin/env python3
"""The same fit by phisindy and by others: a driven Duffing oscillator of which 2000 noisy positions are known, smooth and with Coulomb friction.

    pip install scipy casadi "jax[cpu]" diffrax optimistix "mujoco[sysid]"      # what is missing is left out, by name
    bench/fit.py PROGRAM --write docs/speed.md

PROGRAM is `phisindy`; it makes the data, too. All get the same positions and start values; the start state is unknown to all of them. Each tool runs in
a process of its own: `first` is from its start to the first result (imports, compilation, and for phisindy reading the files and the whole report with error
bars), `best` the shortest of three fits that follow in the same process (for phisindy, which is a program: the shortest of three such processes; what takes
minutes is repeated once). Times are those of a clock, then of all cores together: where the machine does other work, the latter can be compared, and are.
`error` is the largest error of a parameter in its standard errors, those of the least squares at the truth: below 2 or 3 is what the noise allows. `beside`
is the largest distance from the best least squares, in the same unit: what a tool adds to the noise.
"""
import argparse
import json
import math
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

import tables

SAMPLES, STEP, NOISE = 2000, 0.02, 0.02
FORCE, DRIVE = 1.5, 1.2
# True value and where the search starts.
SMOOTH = {"d": (0.1, 0.2), "k": (1.0, 1.5), "c": (0.5, 0.25)}
CASES = {"smooth": SMOOTH, "Coulomb": SMOOTH | {"F": (0.3, 0.15)}}
UNITS = {"d": "N*s/m", "k": "N/m", "c": "N/m^3", "F": "N"}
START = (0.5, 0.0)
# Of the integration, relative and absolute, and of the fit, where a tool has one.
TOLERANCE = 1e-8
# Speed over which friction is drawn out by the tools that know no sticking: as little as they bear.
SMOOTHING = {"CasADi": 1e-2, "diffrax": 1e-3}
# Steps between two samples.
SUBSTEPS = {"CasADi": {"smooth": 1, "Coulomb": 2}, "MuJoCo": {"smooth": 10, "Coulomb": 20}}


def spec(case, values, data):
    """The model as phisindy reads it; `values` are numbers or movable constants."""
    constants = ", ".join(f'"{n}": {v}' for n, v in values.items())
    friction, contacts = (" - F*sgn(v)", ' contacts: ["v"],') if "F" in values else ("", "")
    return f"""(
    constants: {{ "m": (1.0, "kg"), "A": ({FORCE}, "N"), "w": ({DRIVE}, "rad/s"), {constants} }},
    states: {{ "x": "m", "v": "m/s" }},
    known: {{ "x": "v", "v": "(A*cos(w*t) - d*v - k*x - c*x^3{friction})/m" }},
    unknown: {{}},{contacts}
    data: [{data}],
)
"""


def made(program, case, folder, noise):
    """Times and positions, as `phisindy simulate` makes them."""
    path = folder / "truth.ron"
    values = {n: f'({true}, "{UNITS[n]}")' for n, (true, _) in CASES[case].items()}
    x, v = START
    data = f'Synthetic(truth: {{}}, start: {{ "x": {x}, "v": {v} }}, duration: {SAMPLES * STEP}, step: {STEP}, noise: Additive({noise}), seed: 1)'
    path.write_text(spec(case, values, data))
    text = subprocess.run([program, "simulate", path, "--quiet"], capture_output=True, text=True, check=True).stdout
    head, *rows = [line.split(",") for line in text.splitlines() if line and line[0] != "#"]
    return [[float(r[head.index(n)]) for r in rows] for n in ("t", "x")]


def phisindy(program, case, folder):
    """Parameters and seconds of the first and of three more runs."""
    values = {n: f'(value: {start}, unit: "{UNITS[n]}", within: (0.0, 10.0))' for n, (_, start) in CASES[case].items()}
    path = folder / "fit.ron"
    path.write_text(spec(case, values, 'Csv(path: "data.csv", time: "t", columns: { "x": "x" })'))
    times = []
    for _ in range(4):
        begin, worked = time.perf_counter(), cores()
        done = subprocess.run([program, "run", path, "--format", "json", "--quiet"], capture_output=True, text=True)
        times.append((time.perf_counter() - begin, cores() - worked))
    found = {p["name"]: p["value"] for p in json.loads(done.stdout)["parameters"]}
    return [found[n] for n in CASES[case]], times[0], least(times[1:])


def cores():
    """Seconds that processes which have ended worked, on all cores together."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def least(times):
    return [min(t) for t in zip(*times)]


def rates(m, p, x, v, t, smoothing=None):
    """The acceleration, by the functions of `m`."""
    force = FORCE * m.cos(DRIVE * t) - p[0] * v - p[1] * x - p[2] * x**3
    return force - p[3] * m.tanh(v / smoothing) if smoothing else force


def by_scipy(case, t, x):
    """`least_squares` with `solve_ivp`; where there is friction, modes and their ends are written by hand."""
    import numpy
    from scipy.integrate import solve_ivp
    from scipy.optimize import least_squares

    options = {"rtol": TOLERANCE, "atol": TOLERANCE, "method": "DOP853"}

    def smooth(p):
        return solve_ivp(lambda s, y: [y[1], rates(math, p, *y, s)], (t[0], t[-1]), p[-2:], t_eval=t, **options).y[0]

    def sticking(p):
        out, now, y, done = numpy.empty(len(t)), t[0], list(p[-2:]), 0
        direction = math.copysign(1.0, y[1] or rates(math, p, y[0], 0.0, now))
        while done < len(t):
            if direction:
                field = lambda s, y: [y[1], rates(math, p, *y, s) - p[3] * direction]
                stop = lambda s, y: y[1]
                stop.direction = -direction
            else:
                field = lambda s, y: [0.0, 0.0]
                stop = lambda s, y: p[3] - abs(rates(math, p, y[0], 0.0, s))
                stop.direction = -1
            stop.terminal = True
            part = solve_ivp(field, (now, t[-1] + STEP), y, events=stop, dense_output=True, **options)
            ends = int(numpy.searchsorted(t, part.t[-1], "right"))
            if ends > done:
                out[done:ends] = part.sol(t[done:ends])[0]
            # What lets go is a rounding away from what sticks: a moment later it is not.
            done, now, y = ends, part.t[-1] + (0.0 if direction else 1e-9), [part.y[0, -1], 0.0]
            pull = rates(math, p, y[0], 0.0, now)
            direction = 0.0 if direction and abs(pull) <= p[3] else math.copysign(1.0, pull)
        return out

    model = sticking if case == "Coulomb" else smooth
    first = [start for _, start in CASES[case].values()] + [x[0], 0.0]
    bounds = ([0.0] * len(CASES[case]) + [-10.0] * 2, 10.0)
    fit = lambda start: least_squares(lambda p: model(p) - x, start, bounds=bounds, x_scale="jac", xtol=TOLERANCE, ftol=TOLERANCE, gtol=None)
    return lambda start=first: fit(start)


def with_scipy(case, t, x):
    fit = by_scipy(case, t, x)
    return lambda: fit().x


def with_casadi(case, t, x):
    """Multiple shooting: the states at all samples are unknown, IPOPT with the Gauss-Newton Hessian."""
    import casadi
    import numpy

    n = len(CASES[case])
    p, y, s, h = casadi.MX.sym("p", n), casadi.MX.sym("y", 2), casadi.MX.sym("s"), STEP / SUBSTEPS["CasADi"][case]
    smoothing = SMOOTHING["CasADi"] if case == "Coulomb" else None
    field = casadi.Function("f", [y, p, s], [casadi.vertcat(y[1], rates(casadi, casadi.vertsplit(p), y[0], y[1], s, smoothing))])
    now, when = y, s
    for _ in range(SUBSTEPS["CasADi"][case]):
        k1 = field(now, p, when)
        k2 = field(now + h / 2 * k1, p, when + h / 2)
        k3 = field(now + h / 2 * k2, p, when + h / 2)
        k4 = field(now + h * k3, p, when + h)
        now, when = now + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), when + h
    step = casadi.Function("step", [y, p, s], [now]).expand().map(len(t) - 1)
    states = casadi.MX.sym("states", 2, len(t))
    gaps = step(states[:, :-1], casadi.repmat(p, 1, len(t) - 1), casadi.DM(t[:-1]).T) - states[:, 1:]
    left = (states[0, :] - casadi.DM(x).T).T
    unknown = casadi.veccat(p, states)
    jacobian = casadi.jacobian(left, unknown)
    multiplier = casadi.MX.sym("multiplier")
    hessian = multiplier * casadi.triu(jacobian.T @ jacobian)
    gauss = casadi.Function(
        "gauss", [unknown, casadi.MX.sym("none", 0), multiplier, casadi.MX.sym("lambda", 2 * (len(t) - 1))], [hessian],
        ["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"],
    )
    options = {"hess_lag": gauss, "print_time": False, "ipopt": {"print_level": 0, "tol": TOLERANCE, "sb": "yes"}}
    solver = casadi.nlpsol("solver", "ipopt", {"x": unknown, "f": 0.5 * casadi.dot(left, left), "g": casadi.vec(gaps)}, options)
    first = numpy.concatenate([[start for _, start in CASES[case].values()], numpy.column_stack([x, numpy.gradient(x, STEP)]).ravel()])
    return lambda: solver(x0=first, lbg=0, ubg=0)["x"][:n].full().ravel()


def with_diffrax(case, t, x):
    """Levenberg-Marquardt of optimistix through Tsitouras 5(4) of diffrax, forward derivatives, double precision."""
    import jax

    jax.config.update("jax_enable_x64", True)
    import diffrax
    import jax.numpy as jn
    import optimistix

    smoothing = SMOOTHING["diffrax"] if case == "Coulomb" else None
    field = diffrax.ODETerm(lambda s, y, p: jn.stack([y[1], rates(jn, p, y[0], y[1], s, smoothing)]))
    times, positions = jn.asarray(t), jn.asarray(x)

    def left(p, _):
        run = diffrax.diffeqsolve(
            field, diffrax.Tsit5(), times[0], times[-1], None, p[-2:], p, saveat=diffrax.SaveAt(ts=times), max_steps=200000,
            stepsize_controller=diffrax.PIDController(rtol=TOLERANCE, atol=TOLERANCE), adjoint=diffrax.ForwardMode(),
        )
        return run.ys[:, 0] - positions

    solver = optimistix.LevenbergMarquardt(rtol=TOLERANCE, atol=TOLERANCE)
    fit = jax.jit(lambda p: optimistix.least_squares(left, solver, p, max_steps=200, throw=False, options={"jac": "fwd"}).value)
    first = jn.asarray([start for _, start in CASES[case].values()] + [x[0], 0.0])
    return lambda: fit(first).block_until_ready().tolist()


def with_mujoco(case, t, x):
    """The toolbox `mujoco.sysid`: a sliding joint with stiffness, cubic stiffness, damping and, of its own, `frictionloss`."""
    import mujoco
    import numpy
    from absl import logging
    from mujoco import sysid

    logging.set_verbosity(logging.ERROR)
    h = STEP / SUBSTEPS["MuJoCo"][case]
    friction = 'frictionloss="1" solreffriction="0.001 1" solimpfriction="0.999 0.9999 0.001 0.5 2"' if case == "Coulomb" else ""
    integrator = "implicitfast" if case == "Coulomb" else "RK4"
    spec = mujoco.MjSpec.from_string(f"""<mujoco><option timestep="{h}" gravity="0 0 0" integrator="{integrator}"/>
      <worldbody><body name="mass"><joint name="x" type="slide" axis="1 0 0" {friction}/><geom type="sphere" size="0.1" mass="1" contype="0" conaffinity="0"/></body></worldbody>
      <actuator><motor name="push" joint="x"/></actuator><sensor><jointpos name="reading" joint="x"/></sensor></mujoco>""")
    names = list(CASES[case])
    parameters = sysid.ParameterDict()
    for name, (_, start) in CASES[case].items():
        parameters.add(sysid.Parameter(name, start, 0.0, 10.0))
    for name, value in (("x0", x[0]), ("v0", 0.0)):
        parameters.add(sysid.Parameter(name, value, value - 5.0, value + 5.0))

    def build(found, spec):
        model = spec.compile()
        value = lambda name: float(numpy.ravel(found[name].value)[0])
        model.jnt_stiffness[0], model.jnt_stiffnesspoly[0, 1], model.dof_damping[0] = value("k"), value("c"), value("d")
        if "F" in names:
            model.dof_frictionloss[0] = value("F")
        return model

    def rollout(*, models, datas, control_signal, initial_states, param_dicts, **rest):
        each = len(models) // len(param_dicts)
        starts = []
        for k, state in enumerate(initial_states):
            state = numpy.array(state, float).copy()
            found = param_dicts[k // each]
            state[..., 1], state[..., 2] = (float(numpy.ravel(found[n].value)[0]) for n in ("x0", "v0"))
            starts.append(state)
        return sysid.sysid_rollout(models=models, datas=datas, control_signal=control_signal, initial_states=starts, **rest)

    model = build(parameters, spec)
    # A force is held over a step: that of the middle.
    many = t[0] + h * numpy.arange(round((t[-1] - t[0]) / h) + 1)
    force = (FORCE * numpy.cos(DRIVE * (many + h / 2)))[:, None]
    control = sysid.TimeSeries.from_control_names(many, force, model)
    # The reading of a sensor is that of the step before; a state is on time.
    positions = sysid.TimeSeries.from_names(numpy.array(t), numpy.array(x)[:, None], model, [("x", sysid.SignalType.MjStateQPos)])
    start = sysid.create_initial_state(model, numpy.array([x[0]]), numpy.zeros(1))
    sequences = sysid.ModelSequences("race", spec, "race", start, control, positions)
    residual = sysid.build_residual_fn(models_sequences=[sequences], build_model=build, custom_rollout=rollout)

    def fit():
        found, _ = sysid.optimize(parameters.copy(), residual, optimizer="mujoco", verbose=False)
        return [float(numpy.ravel(found[n].value)[0]) for n in names]

    return fit


PEERS = {
    "SciPy": (with_scipy, ["scipy"], "`least_squares`, DOP853", ", modes by hand"),
    "CasADi": (with_casadi, ["casadi"], "multiple shooting, IPOPT", ", smoothed"),
    "diffrax": (with_diffrax, ["diffrax", "optimistix"], "Tsit5, Levenberg-Marquardt", ", smoothed"),
    "MuJoCo": (with_mujoco, ["mujoco"], "sysid", ", its own friction"),
}


def child(name, case, path):
    """One peer in this process: the first fit and three more."""
    begin = float(os.environ["RACE_BEGIN"])
    import numpy

    t, x = numpy.loadtxt(path, delimiter=",", skiprows=1).T
    fit = PEERS[name][0](case, t, x)
    found = list(map(float, fit()))
    first, times = (time.time() - begin, time.process_time()), []
    while not times or len(times) < 3 and first[0] < 60:
        again, worked = time.perf_counter(), time.process_time()
        fit()
        times.append((time.perf_counter() - again, time.process_time() - worked))
    print(json.dumps([found, first, least(times)]))


def against(case, t, x):
    """The best least squares and the standard errors of the parameters, by SciPy from the truth."""
    import numpy

    numpy_t, numpy_x = numpy.array(t), numpy.array(x)
    truth = [true for true, _ in CASES[case].values()] + list(START)
    best = by_scipy(case, numpy_t, numpy_x)(truth)
    deviation = math.sqrt((best.fun**2).mean())
    errors = deviation * numpy.sqrt(numpy.diag(numpy.linalg.inv(best.jac.T @ best.jac)))
    return best.x[: len(CASES[case])], errors[: len(CASES[case])]


def version(packages):
    import importlib.metadata

    return " + ".join(f"{p} {importlib.metadata.version(p)}" for p in packages)


def main():
    if sys.argv[1:2] == ["--child"]:
        return child(*sys.argv[2:])
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("program", help="phisindy")
    arguments.add_argument("--only", choices=PEERS, action="append", help="these peers")
    arguments.add_argument("--case", choices=CASES, action="append", help="these cases")
    arguments.add_argument("--limit", type=float, default=600.0, help="seconds of a peer's four fits")
    arguments.add_argument("--write", help="a document with the marks of the table")
    given = arguments.parse_args()
    head = ["oscillator", "tool", "error", "beside", "best of 3", "times longer", "first", "times longer"]
    rows, missing, failed = [], [], []
    for case in given.case or CASES:
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            t, x = made(given.program, case, folder, NOISE)
            (folder / "data.csv").write_text("t,x\n" + "\n".join(f"{a!r},{b!r}" for a, b in zip(t, x)) + "\n")
            minimum, errors = against(case, t, x)
            truth = [true for true, _ in CASES[case].values()]
            worst = lambda found, due: max(abs(f - d) / e for f, d, e in zip(found, due, errors))
            ours = phisindy(given.program, case, folder)
            results = {"phisindy": ours}
            for name in given.only or PEERS:
                try:
                    version(PEERS[name][1])
                except ImportError:
                    missing.append(name)
                    continue
                environment = os.environ | {"RACE_BEGIN": repr(time.time())}
                command = [sys.executable, __file__, "--child", name, case, folder / "data.csv"]
                try:
                    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=given.limit)
                    why = done.stderr[-1500:] if done.returncode else None
                except subprocess.TimeoutExpired:
                    why = f"no end within {given.limit:g} s"
                if why is not None:
                    print(f"{name}, {case}: {why}", file=sys.stderr, flush=True)
                    failed.append(f"{name} ({case})")
                    continue
                results[name] = json.loads(done.stdout.splitlines()[-1])
            for name, (found, first, best) in results.items():
                _, packages, how, friction = PEERS.get(name, (None, [], "", ""))
                said = f"{version(packages)}: {how}{friction if case == 'Coulomb' else ''}" if packages else "phisindy"
                show = lambda took: f"{took[0]:.2g} s, {took[1]:.2g} s"
                ratio = lambda took, of: f"{took[1] / of[1]:.1f}" if packages else ""
                rows.append([
                    case, said, f"{worst(found, truth):.2f}", f"{worst(found, minimum):.2g}", show(best), ratio(best, ours[2]),
                    show(first), ratio(first, ours[1]),
                ])
                print(*rows[-1], [f"{f:.6g}" for f in found], sep=" | ", flush=True)
    text = tables.markdown(head, rows)
    if missing:
        text += f"\nNot installed, and left out: {', '.join(sorted(set(missing)))}.\n"
    if failed:
        text += f"\nFailed, or no end within {given.limit:g} s: {', '.join(failed)}.\n"
    print("\n" + text)
    if given.write:
        tables.write(given.write, "fit", text)


if __name__ == "__main__":
    main()
