"""Calls that make no sense: each raises an exception of the package that says what is wrong and where."""

import concurrent.futures
import copy
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import phisindy
from test_phisindy import SPEC, TOP, swing

class Tensor:
    """Refuses to become an array in its own way, as one of PyTorch that has gradients does."""

    def __array__(self, *_):
        raise RuntimeError("call detach() first")


T = swing()["t"]
X = swing()["x"]
MADE = phisindy.Case.from_file(TOP / "specs/case1a.ron")
FILE = SPEC[:-1] + ', data: [Csv(path: "run.csv", time: ("time", "s"), columns: { "x": ("place", "m") })])'


def hole(values):
    return np.where(T > 5, np.nan, values)


def frame(**columns):
    return pytest.importorskip("pandas").DataFrame(columns)


def pandas_of(values, dtype):
    return pytest.importorskip("pandas").array(values, dtype=dtype)


def clock(zone):
    return pytest.importorskip("pandas").date_range("2024-01-01", periods=900, freq="10ms", tz=zone)


def chunked(values):
    pyarrow = pytest.importorskip("pyarrow")
    half = [pyarrow.array(values[:500], from_pandas=True), pyarrow.array(values[500:], from_pandas=True)]
    return pyarrow.table({"t": pyarrow.chunked_array([T[:500], T[500:]]), "x": pyarrow.chunked_array(half)})


def batch(values):
    pyarrow = pytest.importorskip("pyarrow")
    return pyarrow.record_batch({"t": pyarrow.array(T), "x": pyarrow.array(values)})


def twice(package):
    if package == "pandas":
        table = frame(t=T, x=X, y=X)
        table.columns = ["t", "x", "x"]
        return table
    pyarrow = pytest.importorskip("pyarrow")
    return pyarrow.Table.from_arrays([T, X, X], names=["t", "x", "x"])


TABLES = [
    (lambda: {"x": X}, "no column `t`"),
    (lambda: {"t": T}, "measures a state"),
    (lambda: {"t": T, "x": X[:-1]}, "899 rows"),
    (lambda: {"t": T, "x": X, "y": X}, "`y` is neither"),
    (lambda: {"t": T, "x": hole(X)}, "row 501 .* `x`"),
    (lambda: {"t": hole(T), "x": X}, "row 501 .* `t`"),
    (lambda: {"t": T, "x": np.where(T > 5, np.inf, X)}, "row 501"),
    (lambda: {"t": T, "x": np.where(T < 1, -np.inf, X)}, "row 0 .* not a finite number"),
    (lambda: {"t": T, "x": ["a"] * 900}, "`x` holds no numbers"),
    (lambda: {"t": T, "x": X.astype(complex)}, "`x` holds no numbers: it holds the type complex128"),
    (lambda: {"t": T, "x": np.c_[X, X]}, "`x` has 2 dimensions"),
    (lambda: {"t": T, "x": np.asfortranarray(np.c_[X, X])}, "`x` has 2 dimensions"),
    (lambda: {"t": 0.0, "x": 1.0}, "0 dimensions"),
    (lambda: {"t": T, "x": [[1.0], [1.0, 2.0]]}, "`x` holds no numbers"),
    (lambda: {"t": T, "x": [None] * 900}, "`x` holds no numbers: it holds objects, among them None"),
    (lambda: {"t": T, "x": [2**70] * 900}, "`x` holds no numbers: it holds objects"),
    (lambda: {"t": T, "x": np.array([object()] * 900)}, "`x` holds no numbers: it holds objects, among them <object"),
    (lambda: {"t": T[::-1], "x": X}, "row 1 is not later"),
    (lambda: {"t": np.zeros(900), "x": X}, "row 1 is not later"),
    (lambda: {"t": T.round(1), "x": X}, "is not later"),
    (lambda: {"t": T[:0], "x": X[:0]}, "only 0 samples"),
    (lambda: {"t": T[:1], "x": X[:1]}, "only 1 samples"),
    (lambda: {"t": np.ma.masked_where(T > 5, T), "x": X}, "row 501 .* `t`"),
    (lambda: {"t": T, "x": np.ma.masked_where(T > 5, X)}, "row 501 .* `x`"),
    (lambda: {"t": T.astype("M8[ms]"), "x": X}, "`t` holds no numbers: .* give seconds"),
    (lambda: {"t": (1e3 * T).astype("m8[ms]"), "x": X}, "`t` holds no numbers: .* give seconds"),
    (lambda: frame(t=clock(None), x=X), "`t` holds no numbers: .* give seconds"),
    (lambda: frame(t=clock("Europe/Berlin"), x=X), "`t` holds no numbers: .* give seconds"),
    (lambda: frame(t=T, x=pandas_of([*X[:-1], None], "Float64")), "row 899 .* `x`"),
    (lambda: frame(t=T, x=pandas_of([1, None] * 450, "Int64")), "row 1 .* `x`"),
    (lambda: frame(t=T, x=pandas_of(["a"] * 900, "string")), "`x` holds no numbers"),
    (lambda: frame(t=T, x=pandas_of(["a"] * 900, "category")), "`x` holds no numbers"),
    (lambda: twice("pandas"), "`x` is given twice"),
    (lambda: twice("pyarrow"), "`x` is given twice"),
    (lambda: chunked(np.where(T > 5, None, X)), "row 501 .* `x`"),
    (lambda: batch([*X[:-1], None]), "row 899 .* `x`"),
    (lambda: batch(["a"] * 900), "`x` holds no numbers: it holds objects, among them 'a'"),
    (lambda: {"t": T, "x": Tensor()}, "`x` holds no numbers: call detach"),
    (lambda: {"t": T, "x": X, "\ud800": X}, "the name of a column is no text in Unicode"),
    (lambda: {"t": T[:9], "x": X[:9]}, "(?s)only 9 samples.*a record needs at least 10"),
    (lambda: pytest.importorskip("polars").DataFrame({"t": T, "x": [*X[:-1], None]}), "row 899 .* `x`"),
    (lambda: pytest.importorskip("polars").DataFrame({"t": T, "x": X}).lazy(), "no table"),
    (lambda: frame(t=T, x=X)["x"], "no table"),
    (lambda: 3, "no table"),
    (lambda: "run.csv", "no table"),
    (lambda: np.c_[T, X], "no table"),
    (lambda: {1: X}, "name the columns"),
    (lambda: [], "a list without tables"),
    (lambda: [{"t": T, "x": X}, None], "no table"),
    (lambda: {}, "no column `t`"),
]


@pytest.mark.parametrize(("table", "says"), TABLES)
def test_tables_that_are_none(table, says):
    with pytest.raises(phisindy.DataError, match=says):
        phisindy.run(phisindy.Case(SPEC), table())


@pytest.mark.parametrize(
    ("table", "says"),
    [
        (lambda: frame(time=T), "no column `place`"),
        (lambda: frame(time=T, place=hole(X)), "column `place` is `NaN` in line 503"),
        (lambda: frame(time=T, place=["a"] * 900), "`place` holds no numbers"),
        (lambda: frame(time=clock(None), place=X), "`time` holds no numbers: .* give seconds"),
        (lambda: frame(time=T[::-1], place=X), "the time goes back"),
        (lambda: [frame(time=T, place=X)] * 2, "2 tables are given"),
    ],
)
def test_tables_in_the_place_of_a_file(table, says):
    with pytest.raises(phisindy.DataError, match=says):
        phisindy.run(phisindy.Case(FILE), table())


@pytest.mark.parametrize(
    ("spec", "table", "says"),
    [
        (SPEC, lambda: frame(t=T, x=X).set_index("t"), r"no column `t`, .* give table\.reset_index\(\)"),
        (SPEC, lambda: frame(x=X).set_index(T), r"no column `t`, .*rename_axis\('t'\)\.reset_index\(\)"),
        (FILE, lambda: frame(time=T, place=X).set_index("time"), r"no column `time`, .*table\.reset_index\(\)"),
        (SPEC, lambda: frame(x=X), "no column `t`, the time in seconds"),
    ],
)
def test_an_index_that_holds_the_time_is_no_column(spec, table, says):
    with pytest.raises(phisindy.DataError, match=says):
        phisindy.run(phisindy.Case(spec), table())


def test_a_file_that_is_not_found_is_sought_where_python_can_name_a_folder(tmp_path):
    with pytest.raises(phisindy.SpecError, match="no data file") as raised:
        phisindy.run(phisindy.Case(FILE, folder=tmp_path))
    said = str(raised.value)
    assert "PHISINDY_DATA" in said and "the folder of the spec" in said and "--data" not in said


def test_other_columns_of_a_table_in_the_place_of_a_file_may_hold_anything():
    table = frame(time=T, place=X, note=["a"] * 900, clock=clock("Europe/Berlin"), load=hole(X))
    table[7] = X
    assert phisindy.run(phisindy.Case(FILE), table).terms == phisindy.run(phisindy.Case(SPEC), swing()).terms


def test_layouts_and_types_of_numbers_make_no_difference():
    case, found = phisindy.Case(SPEC), phisindy.run(phisindy.Case(SPEC), swing())
    wide = np.zeros((900, 7))
    wide[:, 3], wide[:, 5] = T, X
    readonly = X.copy()
    readonly.flags.writeable = False
    tables = [
        {"t": wide[:, 3], "x": wide[:, 5]},
        {"t": np.asfortranarray(wide)[:, 3], "x": np.asfortranarray(wide)[:, 5]},
        {"t": T[::-1][::-1], "x": readonly},
        {"t": T.astype(np.longdouble), "x": X.astype(">f8")},
        {"t": memoryview(T), "x": tuple(X)},
        chunked(X),
        batch(X),
        frame(t=pandas_of(T, "Float64"), x=pandas_of(X, "Float64")).set_index(np.arange(900)[::-1]),
        {"t": np.ma.array(T), "x": np.ma.array(X)},
    ]
    for table in tables:
        assert phisindy.run(case, table).terms == found.terms


CALLS = [
    (lambda: phisindy.Case(3), "no text of a spec"),
    (lambda: phisindy.Case("rig.ron"), "is a path"),
    (lambda: phisindy.Case.from_file("nowhere.ron"), "cannot read the spec"),
    (lambda: phisindy.Case.from_file(TOP), "cannot read the spec"),
    (lambda: phisindy.Case.from_file(None), "cannot read the spec"),
    (lambda: phisindy.Case(""), "ends where a value"),
    (lambda: phisindy.Case("\0"), "neither a number nor a name"),
    (lambda: phisindy.Case("\ud800"), "the spec is no text in Unicode"),
    (lambda: phisindy.Case(SPEC, folder=3), "folder is no path: 3"),
    (lambda: phisindy.Case("(" * 100000), "64 levels"),
    (lambda: phisindy.Case(SPEC.replace("-k*x", "(" * 100000)), "20000 tokens"),
    (lambda: phisindy.Case(SPEC.replace("-k*x", "-" * 100000 + "x")), "20000 tokens"),
    (lambda: phisindy.Case(SPEC).set("nothing.there", 1.0), "nothing"),
    (lambda: phisindy.Case(SPEC).set(3, 1.0), "no path of a field"),
    (lambda: phisindy.Case(SPEC).set("\ud800", 1.0), "the path of a field is no text in Unicode"),
    (lambda: phisindy.Case(SPEC).set("title", "\ud800"), "the value of a field is no text in Unicode"),
    (lambda: phisindy.Case(SPEC).set("constants.k", object()), "no number"),
    (lambda: phisindy.Case(SPEC).set("constants.k", float("nan")), "finite"),
    (lambda: phisindy.Case(SPEC).set("constants.k", ")"), "closes nothing"),
    (lambda: phisindy.run("rig.ron", swing()), "no case: phisindy.Case.from_file"),
    (lambda: phisindy.gap(None, swing()), "a NoneType is no case"),
    (lambda: phisindy.simulate(swing()), "a dict is no case"),
    (lambda: phisindy.run(phisindy.Case(SPEC), swing(), seed=-1), "seed is -1"),
    (lambda: phisindy.run(phisindy.Case(SPEC), swing(), seed=2**64), "seed is"),
    (lambda: phisindy.run(phisindy.Case(SPEC), swing(), seed=1.5), "seed is no whole number"),
    (lambda: phisindy.run(phisindy.Case(SPEC), swing(), jobs=0), "jobs is 0"),
    (lambda: phisindy.run(phisindy.Case(SPEC), swing(), jobs=10**9), "jobs is"),
    (lambda: phisindy.run(phisindy.Case(SPEC), swing(), jobs="all"), "jobs is no whole number"),
    (lambda: phisindy.run(phisindy.Case(SPEC), swing(), method="magic"), "no method 'magic'"),
    (lambda: phisindy.run(phisindy.Case(SPEC), swing(), laws=3), "laws is no path: 3"),
    (lambda: phisindy.run(phisindy.Case(SPEC), swing(), laws="nowhere"), "nowhere"),
    (lambda: phisindy.run(phisindy.Case(SPEC), swing(), progress="yes"), "progress"),
    (lambda: phisindy.run(phisindy.Case(SPEC)), "there are no records: give a table"),
    (lambda: phisindy.gap(phisindy.Case(SPEC)), "there are no records: give a table"),
    (lambda: phisindy.simulate(phisindy.Case(SPEC), swing()), "unknown part: identify it first, then simulate what was found"),
    (lambda: phisindy.laws("nowhere"), "nowhere"),
    (lambda: phisindy.laws(3), "laws is no path: 3"),
    (lambda: phisindy.sweep(phisindy.Case(SPEC), 3), "no record of this case is `Synthetic`"),
    (lambda: phisindy.sweep(MADE, 3.5), "seeds is 3.5"),
    (lambda: phisindy.sweep(MADE, 0), "seeds is 0"),
    (lambda: phisindy.sweep(MADE, "12"), "seeds is '12'"),
    (lambda: phisindy.sweep(MADE, [-1]), "seed is -1"),
    (lambda: phisindy.sweep(MADE, [None]), "seed is no whole number: None"),
    (lambda: phisindy.sweep(MADE, 3, method="magic"), "no method 'magic'"),
    (lambda: phisindy.sweep(MADE, 3, progress="yes"), "progress is neither true nor a function"),
    (lambda: phisindy.sweep(MADE, 3, client="tcp://127.0.0.1:8786"), "client is a str: give a dask.distributed.Client"),
    (lambda: phisindy.sweep(MADE, 3, out=3), "out is no path: 3"),
    (lambda: phisindy.sweep(None, 3), "no case"),
    (lambda: phisindy.map("run", [phisindy.Case(SPEC)]), "no function"),
    (lambda: phisindy.map(phisindy.run, [3]), "no case"),
    (lambda: phisindy.map(phisindy.run, 3), "map: a int is given: give a list of cases"),
    (lambda: phisindy.map(phisindy.run, MADE), "map: a Case is given: give a list of cases"),
    (lambda: phisindy.map(phisindy.run, [MADE], metod="step"), "run cannot be called .* 'metod'"),
    (lambda: phisindy.map(phisindy.simulate, [MADE]), "simulate cannot be called .* 'jobs'"),
    (lambda: phisindy.map(phisindy.run, [(phisindy.Case(SPEC),)]), "a tuple of 1"),
    (lambda: phisindy.PhisindyRegressor(SPEC).fit([["a"]], [1.0]), "X holds no numbers"),
    (lambda: phisindy.PhisindyRegressor(SPEC).fit(np.c_[T, T], X), "X has the shape"),
    (lambda: phisindy.PhisindyRegressor(SPEC).fit(T[:, None], X[:-1]), "899"),
    (lambda: phisindy.PhisindyRegressor("").fit(T[:, None], X), "ends where a value"),
    (lambda: phisindy.PhisindyRegressor(SPEC).predict(T[:, None]), "not fitted yet"),
    (lambda: phisindy.PhisindyRegressor(SPEC).score(T[:, None], X), "not fitted yet"),
]


@pytest.mark.parametrize(("call", "says"), CALLS)
def test_calls_that_make_no_sense(call, says):
    with pytest.raises(phisindy.PhisindyError, match=says):
        call()


@pytest.fixture(scope="module")
def found():
    return phisindy.run(phisindy.Case(SPEC), swing())


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda f: f.simulate(T, start={"x": "far"}), "the start of `x` is no number"),
        (lambda f: f.simulate(T, start={"x": np.nan}), "the start of `x` is nan"),
        (lambda f: f.simulate(T, start={"z": 1.0}), "`z` is no state; there is: x, v"),
        (lambda f: f.simulate(T, start=[1.0, 0.0]), "start is a list"),
        (lambda f: f.simulate(T, [1.0]), "a list is no table"),
        (lambda f: f.simulate(T, {"F": T}), "inputs: `F` is no input; there is: none"),
        (lambda f: f.simulate(T, {"t": T + 5.0}), "inputs: `t` is no input"),
        (lambda f: f.simulate(T, {"x": X}), "inputs: `x` is no input"),
        (lambda f: f.simulate(T[::-1]), "not later"),
        (lambda f: f.simulate([]), "(?s)only 0 samples.*at least 1"),
        (lambda f: f.simulate(None), "`t`"),
        (lambda f: f.rates(0.0, {"x": 1.0, "v": 1.0}), "0 dimensions"),
        (lambda f: f.rates([0.0], {"x": [1.0]}), "`v`"),
        (lambda f: f.rates([0.0], {"x": [1.0], "v": [1.0, 2.0]}), "`v` has 2 rows"),
        (lambda f: f.rates([0.0], 3), "a int is no table"),
        (lambda f: f.rates([0.0], {"x": [1.0], "v": [1.0], "t": [2.0]}), "x: `t` is no state; there is: x, v"),
        (lambda f: phisindy.simulate(f), "there are no records: give a table"),
        (lambda f: f.save("\0"), "cannot write"),
        (lambda f: f.save(__file__), "cannot write"),
    ],
)
def test_calls_of_a_result_that_make_no_sense(found, call, says):
    with pytest.raises(phisindy.DataError, match=says):
        call(found)


def test_numbers_of_numpy_are_numbers(found):
    case = phisindy.Case(SPEC)
    assert '(4.0, "1/s^2")' not in case.text and "4.0" in case.set("constants.k.0", np.float64(4.0)).text
    assert "learn: (events: true)" not in case.text
    assert phisindy.run(case, swing(), seed=np.int64(3), jobs=np.int32(1)).terms == found.terms
    assert found.simulate(T, start={"x": np.float32(2.0)})["x"][0] == 2.0


def test_a_result_looks_for_its_data_where_its_case_does(tmp_path):
    (tmp_path / "run.csv").write_text("\n".join(["time,place", *(f"{t!r},{x!r}" for t, x in zip(T.tolist(), X.tolist()))]))
    (tmp_path / "rig.ron").write_text(FILE)
    found = phisindy.run(phisindy.Case.from_file(tmp_path / "rig.ron"))
    (motion,) = phisindy.simulate(pickle.loads(pickle.dumps(found)))
    assert found.case.folder == tmp_path and np.abs(motion["x"] - X).max() < 1e-3


def test_a_prediction_needs_no_more_times_than_are_asked_for(found):
    along = found.simulate(T, start={"x": 2.0})["x"]
    assert found.simulate([0.0], start={"x": 2.0})["x"].tolist() == [2.0]
    # The steps have other lengths; the tolerance of each is 1e-8 of the motion.
    assert found.simulate([0.0, 4.0, 8.0], start={"x": 2.0})["x"] == pytest.approx(along[[0, 400, 800]], abs=1e-7)


def test_inputs_and_states_may_be_tables(found):
    spec = SPEC.replace(" known:", ' inputs: { "u": "m/s^2" }, known:', 1).replace("-k*x", "-k*x + u")
    pushed = phisindy.run(phisindy.Case(spec), swing() | {"u": 0.0 * T})
    force = frame(u=np.sin(T))
    assert pushed.simulate(T, force)["x"].tolist() == pushed.simulate(T, {"u": np.sin(T)})["x"].tolist()
    rows = frame(x=X[:2], v=X[:2])
    assert pushed.rates(T[:2], rows, force[:2])["v"] == pytest.approx(found.rates(T[:2], rows)["v"] + force["u"][:2])


def test_results_travel_between_processes(found, tmp_path):
    for again in (pickle.loads(pickle.dumps(found)), copy.deepcopy(found)):
        assert again.to_dict() == found.to_dict() and again.latex == found.latex and repr(again) == repr(found)
        assert again.simulate(T, start={"x": 2.0})["x"].tolist() == found.simulate(T, start={"x": 2.0})["x"].tolist()
        assert (again.save(tmp_path / "again") / "report.html").is_file()
    with pytest.raises(phisindy.SpecError) as raised:
        phisindy.Case("(states: {})")
    error = pickle.loads(pickle.dumps(raised.value))
    assert str(error) == str(raised.value) and error.mistakes == raised.value.mistakes


def test_threads_and_calls_within_calls_give_the_same(found):
    case, inner = phisindy.Case(SPEC), []

    def tell(fraction, what):
        if not inner:
            inner.append(phisindy.run(case, swing(), jobs=2).terms)

    assert phisindy.run(case, swing(), progress=tell).terms == found.terms == inner[0]
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        assert all(one.terms == found.terms for one in pool.map(lambda _: phisindy.run(case, swing()), range(16)))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
def test_a_forked_process_works_on(found):
    # The threads of the parent do not live on in the child.
    child = os.fork()
    if child == 0:
        os._exit(0 if phisindy.run(phisindy.Case(SPEC), swing()).terms == found.terms else 1)
    for _ in range(600):
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            assert os.waitstatus_to_exitcode(status) == 0
            return
        time.sleep(0.1)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    pytest.fail("the child waits for ever")


INTERRUPTED = """
import numpy as np, phisindy, sys
from pathlib import Path
case = phisindy.Case.from_file("specs/case7.ron")
calls = {
    "run": lambda: phisindy.run(case),
    "run_jobs": lambda: phisindy.run(case, jobs=2, progress=lambda *_: None),
    "gap": lambda: phisindy.gap(case.set("unknown", "{}")),
    "sweep": lambda: phisindy.sweep(case, 1000, jobs=2),
    "map": lambda: phisindy.map(phisindy.run, [case] * 1000, jobs=2),
    "map_gap": lambda: phisindy.map(phisindy.gap, [case.set("unknown", "{}")] * 10, jobs=2),
}
print("ready", flush=True)
try:
    calls[sys.argv[1]]()
except KeyboardInterrupt:
    phisindy.run(case.set("data.0.duration", "5.0"))
    print("interrupted")
else:
    print("came to its end")
"""


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize("call", ["run", "run_jobs", "gap", "sweep", "map", "map_gap"])
def test_an_interrupt_ends_the_work(call):
    words = [sys.executable, "-c", INTERRUPTED, call]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True, cwd=TOP) as process:
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        limit = threading.Timer(60.0, process.kill)
        limit.start()
        said = process.stdout.read()
        limit.cancel()
    assert said == "interrupted\n"


BEGUN = []


def counted(case, data, **options):
    BEGUN.append(case)
    return phisindy.run(case, data, **options)


def test_an_interrupt_leaves_the_workers_of_a_cluster_free():
    distributed = pytest.importorskip("distributed")

    def enough(fraction, what):
        raise KeyboardInterrupt

    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        # As in a notebook, which keeps the last exception and all that its frames hold.
        with pytest.raises(KeyboardInterrupt) as kept:
            phisindy.map(counted, [MADE] * 80, client=client, progress=enough)
        assert client.submit(abs, -3).result(timeout=60) == 3
        assert kept.value is not None and not [f for f in client.futures.values() if f.status == "pending"]
    # The first of four chunks came back; what was begun meanwhile is not carried through.
    assert 20 < len(BEGUN) < 40
