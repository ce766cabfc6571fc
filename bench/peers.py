#!/usr/bin/env python3
"""The training loop of the step method as other tools run it (Algorithm 2 of the paper, eqs. (17)-(19), (33)).

One epoch is the forward and the backward Runge-Kutta step of all samples with the event condition in every stage, the mean squared error
of the standardised states, its gradient with respect to the coefficients, and one update of RAdam (as plain gradient steps where the tool
has no RAdam: the update costs nothing beside the rest).

    peers.py jax EPOCHS      one compiled scan, double precision
    peers.py torch EPOCHS    eager, single precision, as the paper's authors train

The data need not be the paper's: the cost does not depend on them. They are 5000 samples of a swing with 10 % relative noise.
"""
import sys
import time

import numpy as np

SAMPLES, STEP, STICK, DRIVE = 5000, 0.01, 1e-3, 0.3
CASES = {
    "case1a": lambda m, x, v: [x * 0 + 1, x, v, x * x, x * v, v * v],
    "case1b": lambda m, x, v: [x * 0 + 1, x, v, m.log((m.abs(v) + 1e-6) / 3e-3), m.log(0.022 + 3e-3 / (m.abs(v) + 1e-6))],
}


def swing():
    """States and times."""
    t = np.arange(SAMPLES) * STEP
    clean = np.stack([np.sin(0.3 * t), 0.3 * np.cos(0.3 * t)], axis=1)
    noise = np.random.default_rng(42).standard_normal(clean.shape)
    return clean * (1 + 0.1 * noise), t


def loss(m, case, xi, states, t, scale):
    """Mean squared one-step error, forward and backward."""

    def rates(x, v, time_):
        friction = sum(c * f for c, f in zip(xi, CASES[case](m, x, v)))
        a = -x - 0.1 * v + m.cos(DRIVE * time_) - m.sign(v) * friction
        stuck = m.abs(v) <= STICK
        return m.where(stuck, v * 0, v), m.where(stuck, a * 0, a)

    def step(state, time_, h):
        x, v = state[:, 0], state[:, 1]
        a1, b1 = rates(x, v, time_)
        a2, b2 = rates(x + h / 2 * a1, v + h / 2 * b1, time_ + h / 2)
        a3, b3 = rates(x + h / 2 * a2, v + h / 2 * b2, time_ + h / 2)
        a4, b4 = rates(x + h * a3, v + h * b3, time_ + h)
        return x + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4), v + h / 6 * (b1 + 2 * b2 + 2 * b3 + b4)

    def error(to, prediction):
        return sum((((p - to[:, i]) / scale[i]) ** 2).mean() / 2 for i, p in enumerate(prediction))

    forward = error(states[1:], step(states[:-1], t[:-1], STEP))
    return forward + error(states[:-1], step(states[1:], t[1:], -STEP))


def jax_loop(case, epochs):
    import jax
    import jax.numpy as jn

    jax.config.update("jax_enable_x64", True)
    states, t = (jn.asarray(a) for a in swing())
    scale = states.std(0)
    gradient = jax.value_and_grad(lambda xi: loss(jn, case, xi, states, t, scale))

    def epoch(carry, k):
        xi, mean, square = carry
        value, g = gradient(xi)
        k = k + 1.0
        mean, square = 0.9 * mean + 0.1 * g, 0.999 * square + 0.001 * g * g
        length = 1999.0 - 2 * k * 0.999**k / (1 - 0.999**k)
        root = jn.sqrt((length - 4) * (length - 2) * 1999.0 / (1995.0 * 1997.0 * jn.maximum(length, 5.0)))
        direction = mean / (1 - 0.9**k)
        scaled = root * direction / (jn.sqrt(square / (1 - 0.999**k)) + 1e-8)
        return (xi - 0.1 * jn.where(length > 5, scaled, direction), mean, square), value

    zero = jn.zeros(len(CASES[case](jn, jn.ones(1), jn.ones(1))))
    scan = jax.jit(lambda xi: jax.lax.scan(epoch, (xi, xi * 0, xi * 0), jn.arange(epochs) * 1.0))
    jax.block_until_ready(scan(zero))
    return lambda: jax.block_until_ready(scan(zero))


def torch_loop(case, epochs):
    import torch

    states, t = (torch.tensor(a).float() for a in swing())
    scale = states.std(0)
    xi = torch.zeros(len(CASES[case](torch, torch.ones(1), torch.ones(1))), requires_grad=True)
    optimiser = torch.optim.RAdam([xi], lr=0.1)

    def run():
        for _ in range(epochs):
            optimiser.zero_grad()
            loss(torch, case, xi, states, t, scale).backward()
            optimiser.step()

    return run


def main():
    tool, epochs = sys.argv[1], int(sys.argv[2])
    for case in CASES:
        run = {"jax": jax_loop, "torch": torch_loop}[tool](case, epochs)
        best = min(timed(run) for _ in range(5))
        print(f"{tool} {case} samples={SAMPLES} us_per_epoch={1e6 * best / epochs:.0f}", flush=True)


def timed(run):
    begin = time.perf_counter()
    run()
    return time.perf_counter() - begin


main()
