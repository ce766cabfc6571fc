"""The package against the command, on tables of every kind, and its exceptions."""

import json
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import phisindy

TOP = Path(__file__).resolve().parents[3]
SPEC = """(
    states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "1/s^2") },
    known: { "x": "v", "v": "-k*x" }, contacts: ["v"],
    unknown: { "v": (factor: "-sgn(v)", candidates: ["1", "|v|"]) })"""


def swing():
    """A mass on a spring with a friction of 0.3 m/s^2, measured to a millimetre."""
    t = np.arange(0.0, 9.0, 0.01)
    half = np.floor(t / np.pi)
    x = 0.3 * (-1.0) ** half + (1.7 - 0.6 * half) * np.cos(t)
    return {"t": t, "x": x.round(3)}


@pytest.fixture(scope="module")
def found():
    return phisindy.run(phisindy.Case(SPEC), swing())


def command(*words):
    said = subprocess.run([sys.executable, "-m", "phisindy", *words], capture_output=True, text=True, cwd=TOP)
    assert said.returncode in (0, 1), said.stderr
    return said.stdout


def test_a_term_is_found_with_its_number(found):
    assert found.verdict == found.status == "identified"
    (term,) = found.terms
    assert term["candidate"] == "1" and abs(term["coefficient"] - 0.3) < 0.001
    assert found.latex == r"\dot{v} = -x - 0.3\,\operatorname{sgn}(v)"
    assert "displaystyle" in found._repr_latex_() and "<iframe" in found._repr_html_()


@pytest.mark.parametrize("spec", ["case1a", "case4", "case6"])
def test_the_command_says_the_same(spec):
    ours = phisindy.run(phisindy.Case.from_file(TOP / f"specs/{spec}.ron")).to_dict()
    theirs = json.loads(command("run", f"specs/{spec}.ron", "--format", "json", "--quiet"))
    for same in (ours, theirs):
        del same["seconds"], same["spec"]
    assert ours == theirs


def test_tables_of_every_kind_say_the_same(found):
    data = swing()
    case = phisindy.Case(SPEC)
    tables = [np.rec.fromarrays(list(data.values()), names=list(data)), {k: list(v) for k, v in data.items()}]
    for package, table in [("pandas", "DataFrame"), ("polars", "DataFrame"), ("pyarrow", "table")]:
        try:
            tables.append(getattr(__import__(package), table)(data))
        except ImportError:
            pass
    for table in tables:
        assert phisindy.run(case, [table]).terms == found.terms


def test_a_table_stands_in_the_place_of_a_file(tmp_path):
    data = swing()
    spec = SPEC[:-1] + ', data: [Csv(path: "run.csv", time: ("time", "ms"), columns: { "x": ("place", "mm") }, window: (0.0, 8000.0))])'
    rows = [f"{float(t)!r},{float(x)!r}" for t, x in zip(1e3 * data["t"], 1e3 * data["x"])]
    (tmp_path / "run.csv").write_text("\n".join(["time,place", *rows]))
    case = phisindy.Case(spec, folder=tmp_path)
    table = {"place": 1e3 * data["x"], "time": 1e3 * data["t"], "more": data["x"]}
    assert phisindy.run(case, table).terms == phisindy.run(case).terms


def test_what_was_found_predicts(found):
    t = swing()["t"]
    motion = found.simulate(t, start={"x": 2.0})
    assert np.abs(motion["x"] - swing()["x"]).max() < 1e-3
    rates = found.rates([0.0, 0.0], {"x": [1.0, 1.0], "v": [0.5, -0.5]})
    friction = found.terms[0]["coefficient"]
    assert rates["v"] == pytest.approx([-1.0 - friction, -1.0 + friction], abs=1e-12)


def test_a_folder_is_saved(found, tmp_path):
    found.save(tmp_path / "out")
    names = {p.name for p in (tmp_path / "out").iterdir()}
    assert {"report.html", "result.json", "identified.ron", "equation.tex"} <= names
    again = phisindy.Case.from_file(tmp_path / "out/identified.ron")
    assert again.check() == []


def test_gap_names_a_law():
    case = phisindy.Case.from_file(TOP / "specs/case1a.ron").set("unknown", "{}")
    told = []
    found = phisindy.gap(case, jobs=2, progress=lambda fraction, what: told.append((fraction, what)))
    assert found.status == "explained"
    assert [step["law"] for step in found.steps] == ["coulomb"]
    assert told and all(0 <= fraction <= 1 for fraction, _ in told)
    assert "sgn" in found.latex and "coulomb" in repr(found).lower()


def test_mistakes_of_a_spec_have_their_places():
    with pytest.raises(phisindy.SpecError, match="unknown name `w`") as raised:
        phisindy.Case('(\n    states: { "x": "m" },\n    known: { "x": "w" },\n)')
    (mistake,) = raised.value.mistakes
    assert (mistake["line"], mistake["column"], mistake["text"]) == (3, 20, "w")
    assert "^" in str(raised.value)
    assert isinstance(raised.value, phisindy.PhisindyError)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda d: {"x": d["x"]}, "no column `t`"),
        (lambda d: d | {"x": d["x"][:-1]}, "899 rows"),
        (lambda d: d | {"y": d["x"]}, "`y` is neither"),
        (lambda d: d | {"x": np.where(d["t"] > 5, np.nan, d["x"])}, "row 501"),
        (lambda d: d | {"x": ["a"] * 900}, "holds no numbers"),
        (lambda d: d | {"x": d["x"].astype(complex)}, "holds no numbers"),
        (lambda d: d | {"x": np.c_[d["x"], d["x"]]}, "2 dimensions"),
        (lambda d: d | {"t": d["t"][::-1]}, "not later"),
        (lambda d: 3, "no table"),
        (lambda d: {1: d["x"]}, "name the columns"),
    ],
)
def test_bad_tables_are_refused(change, says):
    with pytest.raises(phisindy.DataError, match=says):
        phisindy.run(phisindy.Case(SPEC), change(swing()))


def test_an_exception_of_the_progress_ends_the_work():
    class Enough(Exception):
        pass

    def stop(fraction, what):
        raise Enough

    with pytest.raises(Enough):
        phisindy.run(phisindy.Case(SPEC), swing(), progress=stop)


def test_a_sweep_has_the_results_of_each_seed():
    case = phisindy.Case.from_file(TOP / "specs/case1a.ron")
    all_seeds = phisindy.sweep(case, [3, 4], jobs=2)
    one = phisindy.run(case, seed=4).to_dict()
    assert all_seeds[1]["equations"] == one["equations"] and all_seeds[1]["seed"] == 4
    good, bad = phisindy.map(phisindy.run, [(phisindy.Case(SPEC), swing()), (phisindy.Case(SPEC), {"x": [1.0]})])
    assert good["verdict"] == "identified" and isinstance(bad, phisindy._cluster.Failed) and "`t`" in bad.error
    assert pickle.loads(pickle.dumps(case)).text == case.text


def test_an_estimator_works_in_cross_validation():
    model_selection = pytest.importorskip("sklearn.model_selection")
    data = swing()
    X, y = data["t"][:, None], data["x"]
    model = phisindy.PhisindyRegressor(spec=SPEC)
    scores = model_selection.cross_val_score(model, X, y, cv=model_selection.TimeSeriesSplit(2))
    assert min(scores) > 0.99
    assert model.set_params(method="trajectory").get_params()["method"] == "trajectory"
    prediction = model.fit(X, y).predict(X)
    assert prediction.shape == y.shape


def test_the_laws_are_there():
    laws = {law["id"]: law for law in phisindy.laws()}
    assert "stribeck" in laws and laws["stribeck"]["reference"]
