#!/usr/bin/env python3
"""Makes the matrices and the record of specs/beam/beam.ron: a cantilever of Bernoulli beams with dry friction at its tip.

The motion is that of SciPy's Radau with located events: slip with the full friction, stick with the force that holds the tip.
"""
import numpy as np
import scipy.io
import scipy.linalg
from scipy.integrate import solve_ivp

ELEMENTS, BENDING, MASS, FRICTION = 5, 20.0, 1.0, 2.0
h = 1.0 / ELEMENTS
k = BENDING / h**3 * np.array([[12, 6*h, -12, 6*h], [6*h, 4*h*h, -6*h, 2*h*h], [-12, -6*h, 12, -6*h], [6*h, 2*h*h, -6*h, 4*h*h]])
m = MASS * h / 420 * np.array([[156, 22*h, 54, -13*h], [22*h, 4*h*h, 13*h, -3*h*h], [54, 13*h, 156, -22*h], [-13*h, -3*h*h, -22*h, 4*h*h]])
n = 2 * ELEMENTS
K, M = np.zeros((n + 2, n + 2)), np.zeros((n + 2, n + 2))
for e in range(ELEMENTS):
    s = slice(2 * e, 2 * e + 4)
    K[s, s] += k
    M[s, s] += m
K, M = K[2:, 2:], M[2:, 2:]
C = 1.0 * M + 2e-4 * K
scipy.io.mmwrite("M.mtx", M)
scipy.io.mmwrite("K.mtx", K, symmetry="symmetric")
np.savetxt("C.csv", C, delimiter=",", fmt="%.17g")

w2, modes = scipy.linalg.eigh(K, M)
damping = np.diag(modes.T @ C @ modes)
points = {"root": 2, "mid": 4, "tip": n - 2}
tip = modes[points["tip"]]
drive = lambda t: 5*np.cos(2*np.pi*1.3*t) + 4*np.cos(2*np.pi*2.1*t + 1) + 4*np.cos(2*np.pi*3.7*t + 2)
free = lambda y, f: -w2 * y[:n] - damping * y[n:] + tip * f


def friction(mode, t, y):
    return -FRICTION * mode if mode else -tip @ free(y, drive(t)) / (tip @ tip)


def jacobian(mode):
    rates = np.hstack([-np.diag(w2), -np.diag(damping)])
    if not mode:
        rates = rates - np.outer(tip, tip @ rates) / (tip @ tip)
    return np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), rates])


def next_mode(t, y):
    holds = friction(0, t, y)
    return 0 if abs(holds) < FRICTION - 1e-9 else int(np.sign(-holds))


times = np.linspace(0, 6, 3001)
t, y, motion = 0.0, np.zeros(2 * n), []
mode = next_mode(t, y)
while len(motion) < len(times):
    if mode:
        event = lambda t, y: mode * (tip @ y[n:])
    else:
        event = lambda t, y: FRICTION - abs(friction(0, t, y))
    event.terminal, event.direction = True, -1
    rates = lambda t, y: np.concatenate([y[n:], free(y, drive(t) + friction(mode, t, y))])
    run = solve_ivp(rates, (t, times[-1]), y, method="Radau", rtol=1e-8, atol=1e-11, events=event, jac=lambda t, y: jacobian(mode), dense_output=True)
    motion += [run.sol(s) for s in times[len(motion):] if s <= run.t[-1] + 1e-13]
    t, y = run.t[-1], run.y[:, -1].copy()
    y[n:] -= tip * (tip @ y[n:]) / (tip @ tip)
    mode = next_mode(t, y)
columns = np.array(motion)[:, :n] @ modes[list(points.values())].T
noise = np.random.default_rng(1)
columns = np.column_stack([x + noise.normal(size=len(x)) * 0.003 * x.std() for x in columns.T])
np.savetxt("record.csv", np.column_stack([times, columns, drive(times)])[::2], delimiter=",", header="t,root,mid,tip,F", comments="", fmt="%.8g")
