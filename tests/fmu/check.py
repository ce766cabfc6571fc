"""What FMPy says of an FMU, and how far its motion is from that of `phisindy simulate`.

    python check.py MODEL.fmu MOTION.csv

Both kinds are simulated, with the binary in the archive and with one that FMPy compiles from the sources (that needs
CMake). The exit code is 1 if a problem is found or a deviation is above 1e-6 of the column's largest value.
"""

import csv
import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.build import build_platform_binary
from fmpy.validation import validate_fmu

CLOSE = 1e-6


def deviation(fmu, kind, motion):
    """The largest deviation over all states, as a part of the column's largest value."""
    time = motion["t"]
    states = [name.rsplit("_", 1)[0] for name in motion if name.endswith(("_true", "_model"))]
    variables = {v.name for v in read_model_description(fmu).modelVariables if v.causality == "input"}
    inputs = [name for name in motion if name in variables]
    columns = [("time", np.float64)] + [(name, np.float64) for name in inputs]
    signal = np.array(list(zip(time, *(motion[name] for name in inputs))), dtype=columns) if inputs else None
    result = simulate_fmu(
        fmu,
        fmi_type=kind,
        start_time=time[0],
        stop_time=time[-1],
        output_interval=(time[-1] - time[0]) / (len(time) - 1),
        input=signal,
        output=states,
        record_events=False,
    )
    assert len(result) == len(time) and np.allclose(result["time"], time, atol=1e-9 * time[-1]), "other times"
    ours = {name: next(motion[c] for c in (f"{name}_true", f"{name}_model") if c in motion) for name in states}
    misses = [np.abs(result[name] - ours[name]).max() / np.abs(ours[name]).max() for name in states]
    return max(misses)


def main():
    fmu, table = sys.argv[1:]
    with open(table, newline="") as file:
        rows = list(csv.DictReader(file))
    motion = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
    problems = validate_fmu(fmu)
    print("\n".join(problems) or "no problems")
    failed = bool(problems)
    with tempfile.TemporaryDirectory() as folder:
        own = Path(extract(fmu, unzipdir=folder))
        shutil.rmtree(own / "binaries", ignore_errors=True)
        build_platform_binary(own)
        for which, path in [("its binary", fmu), ("compiled", own)]:
            for kind in ["ModelExchange", "CoSimulation"]:
                miss = deviation(str(path), kind, motion)
                print(f"{which}, {kind}: {miss:.1e}")
                failed |= not miss <= CLOSE
    sys.exit(failed)


if __name__ == "__main__":
    main()
