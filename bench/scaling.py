#!/usr/bin/env python3
"""How time and memory grow with samples, candidates and bodies: `cargo bench -p phisindy-learn --bench scaling`, each case in a process of its own.

    taskset -c 0,1 python3 bench/scaling.py                    # a Markdown table, the last four rows take minutes
    python3 bench/scaling.py --kind fit --most 100000          # one kind only, up to a size
    python3 bench/scaling.py --svg scaling.svg                 # the same as a figure

The exponent is that of time between this row and the one before: 1 is linear, 2 quadratic. Memory is the peak of the process, with its data.
"""
import argparse
import math
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
KINDS = {
    "loss": ("one-step loss and gradient", "samples", [10**k for k in range(3, 8)]),
    "chain": ("one-step loss and gradient, 2000 samples", "bodies", [1, 2, 5, 10, 20, 50]),
    "fit": ("trajectory fit of one free run", "samples", [10**k for k in range(3, 7)]),
    "candidates": ("identification from 2000 samples", "candidates", [5, 10, 20, 50, 100]),
    "run": ("simulation with all derivatives, 2000 samples", "bodies", [1, 2, 5, 10, 20, 50]),
    "bodies": ("trajectory fit of all friction levels, 2000 samples", "bodies", [1, 2, 5, 10, 20, 50]),
}
COLOURS = ["#1f77b4", "#8c564b", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e"]


def program():
    """The bench program, built."""
    command = ["cargo", "bench", "-p", "phisindy-learn", "--bench", "scaling", "--no-run"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    found = re.search(r"\((.*scaling-\w+)\)", done.stderr)
    return ROOT / found[1] if found else sys.exit(done.stderr)


def measured(program, kind, size):
    """Seconds and peak bytes of one case; nothing if it failed."""
    child = subprocess.Popen([program, kind, str(size)], stdout=subprocess.PIPE, text=True)
    text = child.stdout.read()
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    found = re.search(r"seconds=(\S+)", text)
    return (float(found[1]), 1024 * used.ru_maxrss) if child.returncode == 0 and found else None


def show(seconds):
    return f"{1e6 * seconds:.3g} us" if seconds < 1e-3 else f"{1e3 * seconds:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"


def figure(results):
    """Time against size, both logarithmic, as SVG."""
    points = [(math.log10(n), math.log10(s)) for rows in results.values() for n, s, _ in rows]
    low, high = [[f(p[i] for p in points) for i in (0, 1)] for f in (min, max)]
    wide, tall, left, top = 620, 360, 60, 20
    x = lambda v: left + wide * (v - math.floor(low[0])) / max(math.ceil(high[0]) - math.floor(low[0]), 1)
    y = lambda v: top + tall * (math.ceil(high[1]) - v) / max(math.ceil(high[1]) - math.floor(low[1]), 1)
    out = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 960 430" font-family="sans-serif" font-size="13">']
    for v in range(math.floor(low[0]), math.ceil(high[0]) + 1):
        out.append(f'<path d="M{x(v):.1f} {top}v{tall}" stroke="#ddd"/><text x="{x(v):.1f}" y="{top + tall + 20}" text-anchor="middle">10<tspan dy="-5" font-size="10">{v}</tspan></text>')
    for v in range(math.floor(low[1]), math.ceil(high[1]) + 1):
        out.append(f'<path d="M{left} {y(v):.1f}h{wide}" stroke="#ddd"/><text x="{left - 8}" y="{y(v) + 4:.1f}" text-anchor="end">10<tspan dy="-5" font-size="10">{v}</tspan></text>')
    out.append(f'<text x="{left + wide / 2}" y="{top + tall + 42}" text-anchor="middle">size</text><text x="8" y="14">seconds</text>')
    for k, (colour, (kind, rows)) in enumerate(zip(COLOURS, results.items())):
        line = " ".join(f"{x(math.log10(n)):.1f},{y(math.log10(s)):.1f}" for n, s, _ in rows)
        out.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="2"/>')
        what, of, _ = KINDS[kind]
        out.append(f'<text x="{left + wide + 14}" y="{40 + 44 * k}" fill="{colour}">{what.split(",")[0]}<tspan x="{left + wide + 14}" dy="16" fill="#666">against {of}</tspan></text>')
    return "\n".join(out + ["</svg>\n"])


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--kind", choices=KINDS, action="append", help="one of the tables (may be repeated); without it all")
    arguments.add_argument("--most", type=int, default=10**9, help="largest size")
    arguments.add_argument("--svg", type=pathlib.Path, help="where the figure goes")
    given = arguments.parse_args()
    bench, results = program(), {}
    for kind in given.kind or KINDS:
        what, of, sizes = KINDS[kind]
        print(f"| {of}: {what} | time | each of them | exponent | peak memory |\n|---|---|---|---|---|", flush=True)
        rows = results.setdefault(kind, [])
        for size in (size for size in sizes if size <= given.most):
            found = measured(bench, kind, size)
            if found is None:
                print(f"| {size} | failed | | | |", flush=True)
                continue
            seconds, memory = found
            exponent = f"{math.log(seconds / rows[-1][1]) / math.log(size / rows[-1][0]):.2f}" if rows else ""
            rows.append((size, seconds, memory))
            print(f"| {size} | {show(seconds)} | {show(seconds / size)} | {exponent} | {memory / 1e6:.0f} MB |", flush=True)
        print()
    if given.svg and any(results.values()):
        given.svg.write_text(figure(results))


main()
