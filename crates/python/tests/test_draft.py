"""From data to a spec and to a law; tables and plots of what was found."""

import builtins
import pickle

import numpy as np
import pytest

import phisindy


def driven():
    """A slider of 1 kg with a damper of 4 N s/m and friction of 0.6 N, driven by a force."""
    step, every = 2e-4, 20
    v = x = 0.0
    rows = []
    for k in range(60_000):
        t = k * step
        force = 2.0 * np.sin(7.0 * t) + 1.5 * np.sin(2.3 * t + 1.0)
        if k % every == 0:
            rows.append((t, x, force))
        free = v + step * (force - 4.0 * v - 30.0 * x)
        v = np.sign(free) * max(abs(free) - step * 0.6, 0.0)
        x += step * v
    t, x, force = np.array(rows).T
    rng = np.random.default_rng(1)
    return {"t (s)": t, "x (m)": x + 2e-5 * rng.standard_normal(x.size), "F (N)": force}


@pytest.fixture(scope="module")
def table():
    return driven()


def test_the_kind_of_rig_is_said(table):
    free = phisindy.new(table, rig="free")
    assert "inputs: {}" in free.text and any("`F`" in note or "F (N)" in note for note in free.notes)
    with pytest.raises(phisindy.DataError, match="rig: give one of slider"):
        phisindy.new(table, rig="crane")


@pytest.fixture(scope="module")
def found():
    case = phisindy.Case("""(
        states: { "x": "m", "v": "m/s" }, constants: { "k": (value: 1.05, unit: "1/s^2", within: (0.5, 2.0)) },
        known: { "x": "v", "v": "-k*x" }, contacts: ["v"],
        unknown: { "v": (factor: "-sgn(v)", candidates: ["1"]) })""")
    t = np.arange(0.0, 9.0, 0.01)
    half = np.floor(t / np.pi)
    x = 0.3 * (-1.0) ** half + (1.7 - 0.6 * half) * np.cos(t)
    return phisindy.run(case, {"t": t, "x": x.round(3)})


def test_a_table_in_memory_gets_the_draft_of_its_file(table, tmp_path):
    pandas = pytest.importorskip("pandas")
    drafts = [phisindy.new(table), phisindy.new(pandas.DataFrame(table))]
    path = tmp_path / "table.csv"
    pandas.DataFrame(table).to_csv(path, index=False)
    drafts.append(phisindy.new(path))
    texts = {draft.text for draft in drafts}
    assert len(texts) == 1
    text = texts.pop()
    assert '"table.csv"' in text and "EDIT" in text
    assert drafts[0].questions == [] and any("motion" in note for note in drafts[0].notes)
    assert drafts[0].case.inputs and str(drafts[0]) == text
    saved = drafts[0].save(tmp_path / "rig.ron")
    assert saved.read_text(encoding="utf-8") == text
    with pytest.raises(phisindy.DataError, match="edits"):
        drafts[0].save(saved)


def test_what_a_draft_has_to_know_can_be_said(table):
    bare = {"t (s)": table["t (s)"], "b": 1e3 * table["x (m)"], "c": table["F (N)"]}
    assert phisindy.new(bare).questions
    with pytest.raises(phisindy.DataError, match="--columns|columns"):
        phisindy.go(bare)
    said = phisindy.new(bare, columns=["t (s)", "x (mm)", "F (N)"])
    assert said.questions == [] and '"mm"' in said.text


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"counts": "4096/kg"}, "4096/rev"),
        ({"counts": 4096}, "4096/rev"),
        ({"rate": "fast"}, "rate is no number"),
        ({"rate": -1.0}, "rate"),
        ({"time_unit": "kg"}, "unit of time"),
    ],
)
def test_what_says_nothing_is_refused(table, given, says):
    with pytest.raises(phisindy.DataError, match=says):
        phisindy.new(table, **given)
    with pytest.raises(phisindy.DataError, match="length"):
        phisindy.new({"t": [0.0, 1.0], "x": [1.0]})
    with pytest.raises(phisindy.DataError, match="nowhere"):
        phisindy.new("nowhere.csv")


def test_go_leads_from_a_table_to_a_law(table, tmp_path):
    found = phisindy.go(table, out=tmp_path / "found")
    assert found.status in {"explained", "described", "undetermined", "named", "unexplained"}
    assert (tmp_path / "found" / "report.html").is_file()
    numbers = found._numbers()
    assert numbers and {"of", "name", "value", "low", "high"} <= set(numbers[0])


def test_the_numbers_are_a_table(found):
    pytest.importorskip("pandas")
    table = found.table()
    assert list(table.columns) == ["of", "name", "value", "unit", "std_error", "low", "high"]
    assert list(table["of"]) == ["v", "constant"] and list(table["name"]) == ["1", "k"]
    assert abs(table["value"][0] - 0.3) < 0.01 and table["low"][0] < 0.3 < table["high"][0]


def test_the_motion_is_plotted(found):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    figure = found.plot()
    (axis,) = figure.axes
    measured, model = (line.get_xydata() for line in axis.get_lines())
    assert len(measured) == 900 and np.abs(measured - model).max() < 0.01
    assert axis.get_ylabel() == "x (m)" and axis.get_xlabel() == "time (s)"
    # A result that has travelled shows the same.
    again = pickle.loads(pickle.dumps(found)).plot()
    assert np.array_equal(again.axes[0].get_lines()[1].get_xydata(), model)
    with pytest.raises(phisindy.DataError, match="no record 'other'"):
        found.plot("other")


@pytest.mark.parametrize(("package", "ask"), [("pandas", "table"), ("matplotlib", "plot")])
def test_a_package_that_lacks_is_named(found, monkeypatch, package, ask):
    true = builtins.__import__

    def without(name, *rest):
        if name.split(".")[0] == package:
            raise ImportError(name)
        return true(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(phisindy.DataError, match=f"pip install {package}"):
        getattr(found, ask)()
