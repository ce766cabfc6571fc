#!/usr/bin/env python3
"""Fuzzes: python3 fuzz/run.py TARGET|all RUNS SEED [SECONDS]

Makes a corpus from specs/, runs libFuzzer on one thread, for so many runs or seconds, and prints a row for docs/robustness.md.
Inputs that fail are kept in fuzz/artifacts/TARGET.
"""

import json
import os
import pathlib
import re
import subprocess
import sys

TOP = pathlib.Path(__file__).resolve().parent.parent
TARGETS = ["expression", "spec", "check", "csv", "format", "splice", "law", "routes", "journal", "gap", "arrays"]
# What cargo-fuzz gives the compiler without a sanitizer: no nightly toolchain is needed for it.
FLAGS = ["--cfg", "fuzzing", "-Cdebug-assertions", "-Coverflow-checks", "-Cpasses=sancov-module"] + [f"-Cllvm-args={flag}" for flag in (
    "-sanitizer-coverage-level=4", "-sanitizer-coverage-inline-8bit-counters", "-sanitizer-coverage-pc-table", "-sanitizer-coverage-trace-compares",
    "-simplifycfg-branch-fold-threshold=0")]
# Bytes of an input: files of HDF5 begin with tables of their own.
LONGEST = {"format": 32768}
# Seconds after which an input hangs: a search is hundreds of fits.
PATIENCE = {"gap": 120}
# One execution takes as long as so many of others, and so many fewer are run.
COST = {"gap": 100}
TOKENS = """( ) [ ] { } , : . | ^ * / + - " ' // /* */ \\0 \\x0a r#" "# 1e308 -1e308 1e-320 0.0 1 NaN inf true
Csv( Table( sheet: Synthetic( Find( Relative( Additive( Sensor( Derivative( Formula( Jonswap( Multisine( File( MaxAbs( Rate( Fit Validate Positive Spline
title: constants: states: inputs: known: inertia: unknown: contacts: data: learn: factor: candidates: within: laws: value: unit: start: sigma: each:
path: time: columns: derive: sensors: offset: gain: delay: window: role: rows: skip: run: separator: decimal: header: interpolate: decimate: detrend:
truth: duration: step: noise: seed: measure: epochs: rates: cutoff: selection: horizon: segments: "m" "m/s" "N" "kg" "s"
sgn( abs( ln( exp( sqrt( sin( cos( tanh( pos( dead( max( min( pi t name: roles: parameters: force: push: internal: rate: screen: grid:
GET POST HTTP/1.1 Host: HOST Content-Length: If-Match: Transfer-Encoding: Origin: /TOKEN/ api/ results/ ?name= &beside=1 &rate= %2e%2e %2f %00 a.ron b.csv link.csv secret.csv
"cell": "seed": "exact": "verdict": "found": "bound": "spurious": "seconds": "design": "first": "seeds": "cells": "coefficients": null 18446744073709551615""".split()


def corpus(target: str) -> pathlib.Path:
    """Files to start from."""
    folder = TOP / "fuzz/corpus" / target
    folder.mkdir(parents=True, exist_ok=True)
    specs = sorted((TOP / "specs").glob("*.ron")) + sorted((TOP / "specs/wrong").glob("*.ron"))
    texts = [p.read_text() for p in specs]
    laws = [p.read_text() for p in sorted((TOP / "specs/laws").glob("*.ron"))]
    quoted = sorted({t for text in texts + laws for t in re.findall(r'"([^"\n]+)"', text)})
    # Comments teach a fuzzer nothing, and short inputs run faster.
    bare = [re.sub(r"//[^\n]*|\s*\n\s*", " ", t) for t in texts]
    tables = [p.read_bytes()[:1500] for p in sorted((TOP / "specs/wrong").glob("*.csv"))]
    fields = ['time: "time_s", columns: { "x": "x_m" }', 'time: ("t", "ms"), columns: { "x": ("x", "mm") }, skip: 2, decimal: \',\'',
              'time: Rate(100.0), columns: { "x": "2" }, header: false, decimate: 2', 'time: "t", columns: { "x": "x" }, rows: { "n": 1.0 }, window: (0.0, 9.0), run: 1']
    fixtures = [p.read_bytes() for p in sorted((TOP / "crates/import/tests/fixtures").glob("*.*")) if p.suffix not in (".py", ".xlsx", ".xls", ".ods") and p.stat().st_size <= LONGEST["format"]]
    bare_laws = [re.sub(r"//[^\n]*|\s*\n\s*", " ", t).encode() for t in laws]
    sets = [("learn.cutoff", "0.1"), ("data.0.noise", "Additive(0.02)"), ("contacts", "[]"), ("unknown.y.candidates", '["1"]'), ('constants."a.b"', "(1.0, \"kg\")")]
    seeds = {
        "expression": [t.encode() for t in quoted],
        "spec": [t.encode() for t in bare],
        "check": [t.encode() for t in bare],
        "csv": [f.encode() + b"\0" + t for f in fields for t in tables],
        "format": fixtures,
        "splice": [f"{p}\0{v}\0{t}".encode() for p, v in sets for t in bare[:12]],
        "law": bare_laws,
        "routes": requests(),
        "journal": journals(),
        "gap": bare_laws,
        "arrays": columns(),
    }[target]
    for k, seed in enumerate(seeds):
        (folder / f"seed-{k}").write_bytes(seed)
    return folder


def requests() -> list[bytes]:
    """Requests of the page, which knows HOST and TOKEN."""
    spec = '(states: { "x": "m" }, known: { "x": "-x" }, data: [Csv(path: "PATH", time: "t", columns: { "x": "x" })])'
    written = "// What `phisindy run a.ron` found.\n// Data files in: ..\n" + spec.replace("PATH", "secret.csv")
    gets = ["", "page.js", "api/state", "api/now?name=a.ron", "api/spec?name=a.ron", "api/export?result=a-gap-1&to=python", "results/a-gap-1/report.html",
            "results/a-gap-1/result.json?keep=1", "results/%2e%2e/a.ron", "api/spec?name=..%2fa.ron", "api/nothing"]
    posts = [("api/data?name=c.csv", "t,x\n0,1\n1,2\n"), ("api/data?name=link.csv", "t,x\n"), ("api/look?name=b.csv", "null"), ("api/look?name=b.csv&rate=100", '[{"role":"x"}]'),
             ("api/look?name=link.csv", "null"), ("api/spec?name=a.ron", spec), ("api/spec?name=a.ron&beside=1", "()"), ("api/new-spec?name=b.ron", spec), ("api/stop", ""),
             ("api/check?name=a.ron", spec.replace("PATH", "b.csv")), ("api/check?name=a.ron", spec.replace("PATH", "../secret.csv")),
             ("api/check?name=a.ron", spec.replace("PATH", "link.csv")), ("api/check?name=a.ron", written)]
    texts = [f"GET /TOKEN/{path} HTTP/1.1\r\nHost: HOST\r\n\r\n" for path in gets]
    texts += [f"POST /TOKEN/{path} HTTP/1.1\r\nHost: HOST\r\nContent-Length: {len(body)}\r\n\r\n{body}" for path, body in posts]
    texts += [f"POST /TOKEN/{path} HTTP/1.1\r\nHost: HOST\r\nIf-Match: \"0\"\r\nContent-Length: 1000000\r\n\r\n{body}" for path, body in posts]
    texts += ["GET / HTTP/1.1\r\nHost: evil\r\nOrigin: null\r\nSec-Fetch-Site: cross-site\r\n\r\n", "POST /TOKEN/api/data?name=c.csv HTTP/1.1\r\nHost: HOST\r\nTransfer-Encoding: chunked\r\n\r\n5\r\n"]
    return [text.encode() for text in texts]


def journals() -> list[bytes]:
    """Journals of a sweep of two cells, one or two of them."""
    term = {"state": "y", "candidate": "1"}
    cells = [{"label": "", "names": [term], "coefficients": [0.5]}, {"label": "noise=Additive(0.1)", "names": [term, term | {"candidate": "|y|"}], "coefficients": [0.5, -1e-3]},
             {"label": "c", "names": [], "coefficients": [], "error": "no truth"}]
    design = {"title": "a rig", "step": False, "first": 42, "seeds": 3, "cells": cells}
    header = {"journal": "phisindy sweep", "spec": "a.ron", "version": "0.2.0", "fingerprint": "0123456789abcdef", "design": design}
    found = {"value": 0.51, "low": 0.4, "high": None}
    runs = [{"cell": cell, "seed": seed, "exact": seed != 43, "verdict": verdict, "found": [found, None], "bound": [0.01, None], "spurious": ["y:|y|"], "seconds": 0.1}
            for cell in ("", "noise=Additive(0.1)") for seed, verdict in ((42, "identified"), (43, {"doubted": "rejected: why"}), (44, {"failed": "why"}))]

    def text(lines: list[dict[str, object]]) -> bytes:
        return "".join(json.dumps(line, separators=(",", ":")) + "\n" for line in lines).encode()

    one = text([header, *runs])
    return [one, one[:-20], text([header, *runs[::2]]) + b"\0" + text([header, *runs[1::2]]), text([header | {"design": design | {"seeds": 1}}, runs[0], header, *runs[1:]])]


def columns() -> list[bytes]:
    """Inputs of fuzz/src/arrays.rs: a case, records of columns (name, rows, kind of numbers), and what is set in them."""
    time, x, v, force = bytes([0, 30, 0]), bytes([1, 30, 1]), bytes([2, 30, 1]), bytes([3, 30, 1])
    plain = [bytes([3]) + time + x + v, bytes([4]) + time + x + v + force, bytes([2]) + time + x, bytes([3]) + time + x + bytes([4, 30, 2, 9]), bytes([2]) + bytes([0, 30, 3, 29, 8]) + x]
    dress = [bytes([0, 0, 0]), bytes([1, 5, 1, 1, 0]) + b'{ "x": 1.0, "v": 0.0 }\0', bytes([0, 0, 2, 1]) + b'{ "x": (gain: Find(start: 1.0, within: (0.5, 2.0))) }\0' + bytes([7]) + b'noise\0Additive(0.1)\0']
    return [bytes([case, 0]) + columns + how for case in range(4) for columns in plain for how in dress]


def built() -> pathlib.Path:
    """The folder of the programs, one for each target."""
    host = re.search(r"host: (.*)", subprocess.run(["rustc", "-vV"], cwd=TOP, check=True, capture_output=True, text=True).stdout)[1]
    # With --target the flags are not those of build scripts and macros.
    environment = os.environ | {"CARGO_ENCODED_RUSTFLAGS": "\x1f".join(FLAGS), "CARGO_TARGET_DIR": str(TOP / "fuzz/target")}
    subprocess.run(["cargo", "build", "--release", "--locked", "--manifest-path", TOP / "fuzz/Cargo.toml", "--target", host], cwd=TOP, env=environment, check=True)
    return TOP / "fuzz/target" / host / "release"


def fuzz(program: pathlib.Path, target: str, runs: int, seed: int, seconds: int) -> bool:
    """One target; prints its row."""
    words = TOP / "fuzz/corpus/tokens.dict"
    folder = corpus(target)
    quoted = (t.replace("\\0", "\\x00").replace('"', '\\"') for t in TOKENS)
    words.write_text("".join(f'"{t if t.startswith(chr(92) + "x") else t}"\n' for t in quoted))
    failures = TOP / "fuzz/artifacts" / target
    failures.mkdir(parents=True, exist_ok=True)
    command = [program, str(folder), f"-artifact_prefix={failures}/", f"-runs={max(1, runs // COST.get(target, 1))}", f"-max_total_time={seconds}", f"-seed={seed}",
               f"-max_len={LONGEST.get(target, 4096)}", f"-timeout={PATIENCE.get(target, 10)}", f"-report_slow_units={PATIENCE.get(target, 10)}", "-rss_limit_mb=4096", f"-dict={words}", "-print_final_stats=1", "-verbosity=1", "-reload=0"]
    said = subprocess.run(command, cwd=TOP, env=os.environ | {"RAYON_NUM_THREADS": "1"}, stderr=subprocess.PIPE, text=True, errors="replace").stderr
    (TOP / "fuzz/corpus" / f"{target}.log").write_text(said)

    def last(pattern: str) -> str:
        return (re.findall(pattern, said) or ["?"])[-1]

    failed = "Test unit written to" in said or "number_of_executed_units" not in said
    print(f"| {target} | {last(r'number_of_executed_units: *([0-9]+)')} | {last(r'cov: ([0-9]+)')} | {last(r'worst time ([0-9.]+)')} ms "
          f"| {last(r'worst memory ([0-9.]+)')} MB | {'fails: see fuzz/artifacts/' + target if failed else 'none'} |", flush=True)
    return failed


def main() -> None:
    """As the command line says."""
    which, runs, seed = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    seconds = int(sys.argv[4]) if len(sys.argv) > 4 else 0
    programs = built()
    print("| target | executions | edges covered | worst time | worst memory | failures |\n| --- | --- | --- | --- | --- | --- |", flush=True)
    failed = [fuzz(programs / target, target, runs, seed, seconds) for target in (TARGETS if which == "all" else [which])]
    sys.exit(any(failed))


if __name__ == "__main__":
    main()
