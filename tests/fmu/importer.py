"""A small importer of FMI 3.0, for the tests: the standard library of Python alone.

    python importer.py MODEL.fmu exchange|cosim|misuse < MOTION.csv

`exchange` integrates by the classical method of Runge and Kutta and halves a step until it ends at a state event; `cosim`
steps from row to row. Both print the states at the times of the CSV and take inputs from its columns, joined by straight
lines or held (columns `NAME_held`). `misuse` calls what a good importer would not.
"""

import csv
import ctypes
import platform
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
import zipfile
from ctypes import POINTER, byref, c_bool, c_char_p, c_double, c_int32, c_size_t, c_uint32, c_ubyte, c_void_p
from pathlib import Path

PARTS = 20  # steps between two rows


class Unit:
    """An instance of a model, and its variables by name."""

    def __init__(self, path, kind, folder):
        with zipfile.ZipFile(path) as archive:
            archive.extractall(folder)
        tree = ElementTree.parse(Path(folder) / "modelDescription.xml").getroot()
        identifier = tree.find("ModelExchange" if kind == "exchange" else "CoSimulation").get("modelIdentifier")
        system = {"Linux": ("linux", "so"), "Darwin": ("darwin", "dylib"), "Windows": ("windows", "dll")}[platform.system()]
        machine = {"arm64": "aarch64", "AMD64": "x86_64"}.get(platform.machine(), platform.machine())
        self.library = ctypes.CDLL(str(Path(folder) / f"binaries/{machine}-{system[0]}/{identifier}.{system[1]}"))
        self.variables = {v.get("name"): v for v in tree.find("ModelVariables")}
        self.token, self.kind, self.said = tree.get("instantiationToken").encode(), kind, []
        logger = ctypes.CFUNCTYPE(None, c_void_p, ctypes.c_int, c_char_p, c_char_p)
        self.logger = logger(lambda _, status, category, message: self.said.append(message.decode()))
        self.instance = self.made(self.token)

    def made(self, token):
        name = "fmi3InstantiateModelExchange" if self.kind == "exchange" else "fmi3InstantiateCoSimulation"
        function = getattr(self.library, name)
        function.restype = c_void_p
        middle = [] if self.kind == "exchange" else [c_bool(False), c_bool(False), None, c_size_t(0)]
        end = [] if self.kind == "exchange" else [None]
        instance = function(b"one", token, None, c_bool(False), c_bool(False), *middle, None, self.logger, *end)
        return c_void_p(instance)

    def raw(self, name, *arguments):
        return getattr(self.library, f"fmi3{name}")(self.instance, *arguments)

    def call(self, name, *arguments):
        status = self.raw(name, *arguments)
        assert status == 0, (name, status, self.said)

    def reference(self, name):
        return int(self.variables[name].get("valueReference"))

    def get(self, names):
        values = (c_double * len(names))()
        references = (c_uint32 * len(names))(*map(self.reference, names))
        self.call("GetFloat64", references, c_size_t(len(names)), values, c_size_t(len(names)))
        return list(values)

    def set(self, names, values):
        n = c_size_t(len(names))
        self.call("SetFloat64", (c_uint32 * len(names))(*map(self.reference, names)), n, (c_double * len(names))(*values), n)

    def numbers(self, name, count):
        values = (c_double * count)()
        self.call(name, values, c_size_t(count))
        return list(values)

    def begin(self, start):
        self.call("EnterInitializationMode", c_bool(False), c_double(0.0), c_double(start), c_bool(False), c_double(0.0))
        self.call("ExitInitializationMode")


class Inputs:
    """The inputs of the CSV."""

    def __init__(self, unit, rows):
        self.unit, self.rows = unit, rows
        named = [n for n, v in unit.variables.items() if v.get("causality") == "input" and not n.startswith("der(")]
        self.held = [n for n in named if f"{n}_held" in rows]
        self.names = [name for n in named for name in (n, f"der({n})")]
        self.columns = [rows[n if n not in self.held else f"{n}_held"] for n in named]
        self.named = named

    def at(self, row, t):
        """Sets what holds from a row to the next one, at a time between them."""
        times, values = self.rows["t"], []
        after = min(row + 1, len(times) - 1)
        for name, column in zip(self.named, self.columns):
            rising = name not in self.held and after > row
            slope = (column[after] - column[row]) / (times[after] - times[row]) if rising else 0.0
            values += [column[row] + slope * (t - times[row]), slope]
        if values:
            self.unit.set(self.names, values)


def cosimulated(unit, inputs, times, states):
    flags = [c_bool() for _ in range(3)]
    last = c_double()
    out = [unit.get(states)]
    for row in range(len(times) - 1):
        inputs.at(row, times[row])
        length = c_double(times[row + 1] - times[row])
        unit.call("DoStep", c_double(times[row]), length, c_bool(True), *map(byref, flags), byref(last))
        out.append(unit.get(states))
    return out


class Exchange:
    """Model exchange along the rows."""

    def __init__(self, unit, inputs, times, states):
        self.unit, self.inputs, self.times, self.states = unit, inputs, times, states
        count = c_size_t()
        unit.call("GetNumberOfEventIndicators", byref(count))
        self.indicators = count.value

    def rates(self, row, t, x):
        self.point(row, t, x)
        return self.unit.numbers("GetContinuousStateDerivatives", len(x))

    def point(self, row, t, x):
        self.unit.call("SetTime", c_double(t))
        self.unit.call("SetContinuousStates", (c_double * len(x))(*x), c_size_t(len(x)))
        self.inputs.at(row, t)

    def step(self, row, t, x, h):
        moved = lambda k, part: [a + part * h * b for a, b in zip(x, k)]
        k1 = self.rates(row, t, x)
        k2 = self.rates(row, t + h / 2, moved(k1, 0.5))
        k3 = self.rates(row, t + h / 2, moved(k2, 0.5))
        k4 = self.rates(row, t + h, moved(k3, 1.0))
        return [a + h / 6 * (p + 2 * q + 2 * r + s) for a, p, q, r, s in zip(x, k1, k2, k3, k4)]

    def failing(self, row, t, x):
        self.point(row, t, x)
        return any(not z > 0 for z in self.unit.numbers("GetEventIndicators", self.indicators))

    def event(self):
        flags = [c_bool() for _ in range(5)]
        self.unit.call("UpdateDiscreteStates", *map(byref, flags), byref(c_double()))
        assert not flags[0].value
        self.unit.call("EnterContinuousTimeMode")
        return self.unit.numbers("GetContinuousStates", len(self.states))

    def run(self):
        x, t = self.event(), self.times[0]
        out = [x]
        for row in range(len(self.times) - 1):
            end, usual, events = self.times[row + 1], (self.times[row + 1] - t) / PARTS, 0
            while t < end:
                h = min(usual, end - t)
                if end - t - h < 1e-3 * usual:
                    h = end - t
                reached = self.step(row, t, x, h)
                found = self.failing(row, t + h, reached)
                if found:
                    events += 1
                    assert events < 100, f"events without end at t = {t}"
                    good, bad = 0.0, h
                    while bad - good > 1e-14 * max(t, 1.0):
                        middle = 0.5 * (good + bad)
                        reached = self.step(row, t, x, middle)
                        good, bad = (good, middle) if self.failing(row, t + middle, reached) else (middle, bad)
                    h = bad
                    reached = self.step(row, t, x, h)
                t, x = (end if h == end - t else t + h), reached
                self.point(row, t, x)
                wanted = c_bool()
                self.unit.call("CompletedIntegratorStep", c_bool(True), byref(wanted), byref(c_bool()))
                if found or wanted.value or t == end:
                    self.unit.call("EnterEventMode")
                    if t == end and row + 2 < len(self.times):
                        self.inputs.at(row + 1, t)
                    x = self.event()
            out.append(x)
        return out


def misused(unit, times):
    """Wrong calls are refused, and a state that was kept leads to the same bits again."""
    states = [n for n, v in unit.variables.items() if v.get("initial") == "exact"]
    assert not unit.made(b"another").value and "token" in unit.said[-1]
    nowhere, number, one = (c_uint32 * 1)(12345), (c_double * 1)(float("nan")), c_size_t(1)
    place = (c_uint32 * 1)(unit.reference(states[0]))
    size = (c_double * 1)(1.0)
    for name, arguments in [
        ("DoStep", [c_double(0.0), c_double(0.1), c_bool(True), None, None, None, None]),
        ("GetFloat64", [nowhere, one, number, one]),
        ("SetFloat64", [nowhere, one, size, one]),
        ("SetFloat64", [place, one, number, one]),
        ("SetFloat64", [place, one, size, c_size_t(2)]),
        ("GetInt32", [place, one, (c_int32 * 1)(), one]),
        ("GetString", [place, one, None, one]),
        ("EnterInitializationMode", [c_bool(False), c_double(0.0), c_double(float("nan")), c_bool(False), c_double(0.0)]),
        ("SetTime", [c_double(1.0)]),
    ]:
        said = len(unit.said)
        assert unit.raw(name, *arguments) == 3 and len(unit.said) > said, name
    unit.begin(times[0])
    assert unit.raw("SetFloat64", place, one, size, one) == 3, "a state is not set while the motion runs"
    assert unit.raw("DoStep", c_double(times[5]), c_double(0.1), c_bool(True), None, None, None, None) == 3
    assert unit.raw("DoStep", c_double(times[0]), c_double(0.0), c_bool(True), None, None, None, None) == 3
    inputs = Inputs(unit, {"t": times})
    half = len(times) // 2
    cosimulated(unit, inputs, times[: half + 1], states)
    kept, size = c_void_p(), c_size_t()
    unit.call("GetFMUState", byref(kept))
    unit.call("SerializedFMUStateSize", kept, byref(size))
    content = (c_ubyte * size.value)()
    unit.call("SerializeFMUState", kept, content, size)
    unit.call("FreeFMUState", byref(kept))
    assert kept.value is None
    first = cosimulated(unit, inputs, times[half:], states)
    other = unit.made(unit.token)
    unit.library.fmi3FreeInstance(unit.instance)
    unit.instance = other
    unit.call("DeserializeFMUState", content, size, byref(kept))
    unit.call("SetFMUState", kept)
    assert cosimulated(unit, inputs, times[half:], states) == first
    unit.call("SetFMUState", kept)
    unit.call("Reset")
    unit.begin(times[0])
    unit.call("Terminate")
    unit.library.fmi3FreeInstance(unit.instance)
    print("fine")


def main():
    path, kind = sys.argv[1:]
    table = list(csv.DictReader(sys.stdin))
    rows = {name: [float(row[name]) for row in table] for name in table[0]}
    with tempfile.TemporaryDirectory() as folder:
        unit = Unit(path, kind, folder)
        if kind == "misuse":
            return misused(unit, rows["t"])
        states = [n for n, v in unit.variables.items() if v.get("initial") == "exact"]
        times, inputs = rows["t"], Inputs(unit, rows)
        inputs.at(0, times[0])
        unit.begin(times[0])
        made = Exchange(unit, inputs, times, states).run() if kind == "exchange" else cosimulated(unit, inputs, times, states)
        unit.call("Terminate")
        unit.library.fmi3FreeInstance(unit.instance)
    out = csv.writer(sys.stdout, lineterminator="\n")
    out.writerow(["t", *states])
    out.writerows([[repr(t), *map(repr, x)] for t, x in zip(times, made)])


if __name__ == "__main__":
    main()
