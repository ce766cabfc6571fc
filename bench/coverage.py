#!/usr/bin/env python3
"""Which lines of the libraries the tests of the workspace reach: one row for each crate, for docs/robustness.md.

    python3 bench/coverage.py                                # builds, runs all tests (minutes), prints the table
    python3 bench/coverage.py --show sim --show learn        # the lines of these crates, too, that no test reaches
    python3 bench/coverage.py --again --show phys            # reads what the last run has left in target/coverage

A line counts if the compiler put a region on it, and as reached if one of its regions ran; tests themselves do not count, nor do doctests run.
Each test is a process of its own with one thread, because threads that count in the same place wait for each other.
Needs `rustup`, which brings the readers of the compiler's own profiles (`llvm-tools`).
"""
import argparse
import collections
import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
FOLDER = ROOT / "target" / "coverage"
CRATES = ["expr", "phys", "sim", "learn", "gap", "import"]


def output(*command):
    """What a command prints; the end if it fails."""
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    return done.stdout if done.returncode == 0 else sys.exit(f"{' '.join(map(str, command))} failed")


def tool(name):
    """A program of `llvm-tools`, which must be as old as the compiler."""
    host = re.search(r"host: (\S+)", output("rustc", "-vV"))[1]
    return pathlib.Path(output("rustc", "--print", "sysroot").strip(), "lib", "rustlib", host, "bin", name)


def built():
    """All programs, instrumented, and of those that are tests the folder of their crate."""
    command = ["cargo", "test", "--workspace", "--no-run", "--message-format", "json-render-diagnostics"]
    # Only crates of the workspace go through this wrapper: what they depend on keeps its speed.
    os.environ["RUSTC_WORKSPACE_WRAPPER"] = str(pathlib.Path(__file__).resolve())
    messages = [json.loads(line) for line in output(*command).splitlines()]
    made = [m for m in messages if m.get("executable")]
    return [m["executable"] for m in made], {m["executable"]: pathlib.Path(m["manifest_path"]).parent for m in made if m["profile"]["test"]}


def run(test):
    """One test of one program; its name and what it said if it failed."""
    program, home, name = test
    # A profile may be cut off where a test takes the disk away: those of other programs are in other folders.
    profile = FOLDER / "raw" / pathlib.Path(program).name / "%4m.profraw"
    here = {"LLVM_PROFILE_FILE": str(profile), "RAYON_NUM_THREADS": "1", "CARGO_MANIFEST_DIR": str(home), "INSTA_WORKSPACE_ROOT": str(ROOT), "INSTA_UPDATE": "no"}
    done = subprocess.run([program, "--exact", name], cwd=home, env=os.environ | here, capture_output=True, text=True)
    return name, None if done.returncode == 0 else done.stdout + done.stderr


def measure(jobs):
    """Builds, runs, and leaves the counts of all lines in a file."""
    output("rustup", "component", "add", "llvm-tools")
    programs, homes = built()
    shutil.rmtree(FOLDER, ignore_errors=True)
    os.environ["LLVM_PROFILE_FILE"] = "/dev/null"
    tests = [(p, home, line[: -len(": test")]) for p, home in homes.items() for line in output(p, "--list").splitlines() if line.endswith(": test")]
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        running = [pool.submit(run, t) for t in tests]
        for k, done in enumerate(concurrent.futures.as_completed(running), 1):
            name, failure = done.result()
            print(f"\r{k} of {len(tests)} tests", end="", file=sys.stderr)
            if failure:
                print(f"\n{name} failed:\n{failure}", file=sys.stderr)
    print(file=sys.stderr)
    raw = [str(p) for p in FOLDER.rglob("*.profraw")]
    (FOLDER / "raw.list").write_text("\n".join(raw))
    output(tool("llvm-profdata"), "merge", "--sparse", "--failure-mode=warn", "-f", FOLDER / "raw.list", "-o", FOLDER / "all.profdata")
    objects = [a for p in programs for a in ("--object", p)]
    lines = output(tool("llvm-cov"), "export", "--format=lcov", "--skip-functions", "--instr-profile", FOLDER / "all.profdata", *objects)
    (FOLDER / "lines.lcov").write_text(lines)
    shutil.rmtree(FOLDER / "raw")


def test_lines(sources):
    """Files that are tests as a whole, and for the others the line where their tests begin."""
    files, begins = set(), {}
    for path in sources:
        text = path.read_text()
        for found in re.finditer(r"^#\[cfg\(test\)\]\n(?:pub\(crate\) )?mod (\w+)( \{|;)", text, re.M):
            if found[2] == ";":
                inner = path.parent if path.name == "lib.rs" else path.with_suffix("")
                files |= {inner / f"{found[1]}.rs", *(inner / found[1]).rglob("*.rs")}
            else:
                begins[path] = text.count("\n", 0, found.start()) + 1
    return files, begins


def counted():
    """For each crate, file and line how often it ran, tests left out."""
    sources = [p for c in CRATES for p in sorted((ROOT / "crates" / c / "src").rglob("*.rs"))]
    tests, begins = test_lines(sources)
    counts = {p: {} for p in sources if p not in tests}
    of = None
    for line in (FOLDER / "lines.lcov").read_text().splitlines():
        kind, _, rest = line.partition(":")
        if kind == "SF":
            of = pathlib.Path(rest)
        elif kind == "DA" and of in counts:
            number, count = map(int, rest.split(",")[:2])
            if number < begins.get(of, sys.maxsize):
                counts[of][number] = count
    return counts


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--show", action="append", default=[], choices=CRATES, help="a crate whose unreached lines are printed")
    arguments.add_argument("--again", action="store_true", help="do not run, read the last run")
    arguments.add_argument("--jobs", type=int, default=os.cpu_count(), help="tests side by side")
    asked = arguments.parse_args()
    if not asked.again:
        measure(asked.jobs)
    total, reached = collections.Counter(), collections.Counter()
    for path, lines in counted().items():
        crate = path.relative_to(ROOT / "crates").parts[0]
        total[crate] += len(lines)
        reached[crate] += sum(n > 0 for n in lines.values())
        missed = sorted(k for k, n in lines.items() if n == 0)
        if crate in asked.show and missed:
            text = path.read_text().splitlines()
            print(path.relative_to(ROOT), *(f"{k:5} {text[k - 1]}" for k in missed), "", sep="\n")
    print("| crate | lines | reached |\n| --- | --- | --- |")
    for crate in CRATES:
        print(f"| {crate} | {total[crate]} | {reached[crate]} ({100 * reached[crate] / total[crate]:.1f} %) |")


if __name__ == "__main__":
    # Cargo calls this file as the wrapper of the compiler, too: NAME.py rustc ARGUMENTS.
    if len(sys.argv) > 1 and pathlib.Path(sys.argv[1]).stem == "rustc":
        os.execvp(sys.argv[1], [*sys.argv[1:], "-Cinstrument-coverage"])
    main()
