"""The package against the command, on tables of every kind, and its exceptions."""

import functools
import json
import os
import pickle
import signal
import subprocess
import sys
import threading
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


SPECS = ["case1a", "case1b", "case2a", "case2b", "case3_coulomb", "case3_dr", "case4", "case5", "case6", "case7"]
# Of these `gap` has nothing to find, or takes seconds; with PHISINDY_LONG it searches all ten.
SEARCHED = ["case1a", "case2a"]


# Of measured records, where their files are. A search takes long.
MEASURED = [("run", "emps"), ("run", "frame_250g"), ("run", "servo")]
if os.environ.get("PHISINDY_LONG"):
    MEASURED.append(("gap", "frame_gap"))


def same_but_for(time, ours, theirs):
    for result in (ours, theirs):
        for key in time:
            result.pop(key, None)
    assert ours == theirs


@pytest.mark.parametrize("spec", SPECS)
def test_the_command_identifies_the_same(spec):
    ours = phisindy.run(phisindy.Case.from_file(TOP / f"specs/{spec}.ron")).to_dict()
    theirs = json.loads(command("run", f"specs/{spec}.ron", "--format", "json", "--quiet"))
    same_but_for(["seconds", "spec"], ours, theirs)


@pytest.mark.parametrize("spec", SPECS)
def test_the_command_simulates_the_same(spec):
    (motion,) = phisindy.simulate(phisindy.Case.from_file(TOP / f"specs/{spec}.ron"))
    said = command("simulate", f"specs/{spec}.ron", "--quiet").splitlines()
    names = said[0].split(",")
    for name, values in motion.items():
        at = names.index(name if name == "t" else f"{name}_true")
        assert [float(row.split(",")[at]) for row in said[1:]] == values.tolist()


@pytest.mark.parametrize("spec", SPECS)
def test_the_command_finds_the_same_gap(spec):
    changes = {"unknown": "{}", "data.0.duration": "12.0"}
    if spec not in SEARCHED and not os.environ.get("PHISINDY_LONG"):
        changes |= {"data.0.duration": "4.0", "data.0.truth": "{}"}
    case = phisindy.Case.from_file(TOP / f"specs/{spec}.ron")
    for path, value in changes.items():
        case = case.set(path, value)
    sets = [word for path, value in changes.items() for word in ("--set", f"{path}={value}")]
    said = json.loads(command("gap", f"specs/{spec}.ron", *sets, "--format", "json", "--quiet"))
    same_but_for(["seconds", "spec"], phisindy.gap(case).to_dict(), said)


@pytest.mark.skipif("PHISINDY_DATA" not in os.environ, reason="no data: PHISINDY_DATA names no folder")
@pytest.mark.parametrize(("work", "spec"), MEASURED)
def test_the_command_finds_the_same_in_measured_records(work, spec):
    case = phisindy.Case.from_file(TOP / f"specs/{spec}.ron")
    said = json.loads(command(work, f"specs/{spec}.ron", "--format", "json", "--quiet"))
    same_but_for(["seconds", "spec"], getattr(phisindy, work)(case).to_dict(), said)


def test_tables_of_every_kind_say_the_same(found):
    data = swing()
    case = phisindy.Case(SPEC)
    tables = [np.rec.fromarrays(list(data.values()), names=list(data)), {k: list(v) for k, v in data.items()}]
    # What comes from another process may start at any byte, and may not be written; every second row of a table.
    odd = {k: np.frombuffer(b"." + v.tobytes(), dtype=np.uint8)[1:].view(np.float64) for k, v in data.items()}
    assert not odd["t"].flags.aligned and not odd["t"].flags.writeable
    tables += [odd, {k: np.repeat(v, 2)[::2] for k, v in data.items()}]
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


def test_a_journal_knows_files_by_their_content(tmp_path):
    """A file that changes under its name is another case; so is a law."""
    calls = []

    def run(case, data, **options):
        calls.append(case)
        return phisindy.run(case, data, **options)

    def written(scale):
        rows = "".join(f"{t},{scale * x}\n" for t, x in zip(*swing().values()))
        (tmp_path / "a.csv").write_text("t,x\n" + rows)

    written(1.0)
    record = 'Csv(path: "a.csv", time: "t", columns: { "x": "x" })'
    case = phisindy.Case(SPEC.rstrip().removesuffix(")") + f", data: [{record}])", folder=tmp_path)
    out = tmp_path / "kept.jsonl"
    for change, expected in [(None, 1), (None, 1), (lambda: written(1.1), 2), (lambda: written(1.0), 2)]:
        if change is not None:
            change()
        phisindy.map(run, [case], out=out, jobs=1)
        assert len(calls) == expected
    (tmp_path / "laws").mkdir()
    law = (TOP / "specs/laws/coulomb.ron").read_text()
    (tmp_path / "laws/mine.ron").write_text(law)
    phisindy.map(run, [case], out=out, jobs=1)
    assert len(calls) == 3


def test_a_folder_is_saved(found, tmp_path):
    found.save(tmp_path / "out")
    names = {p.name for p in (tmp_path / "out").iterdir()}
    assert {"report.html", "result.json", "identified.ron", "equation.tex"} <= names
    again = phisindy.Case.from_file(tmp_path / "out/identified.ron")
    assert again.check() == []


def test_a_folder_is_never_mixed(found, tmp_path):
    out = tmp_path / "out"
    found.save(out)
    (out / "notes.txt").write_text("mine")
    with pytest.raises(phisindy.DataError, match="holds what is no result: `notes.txt`.*force=True"):
        found.save(out)
    found.save(out, force=True)
    assert (out / "notes.txt").read_text() == "mine" and (tmp_path / "out.1/result.json").is_file()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out", "out.1"]


def test_gap_names_a_law():
    case = phisindy.Case.from_file(TOP / "specs/case1a.ron").set("unknown", "{}")
    told = []
    found = phisindy.gap(case, jobs=2, progress=lambda fraction, what: told.append((fraction, what)))
    assert found.status == "explained"
    assert [step["law"] for step in found.steps] == ["coulomb"]
    assert told and all(0 <= fraction <= 1 for fraction, _ in told)
    assert r"\operatorname{sgn}" in found.latex and r"\dot{y}" in found.latex and "coulomb" in repr(found).lower()


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
    assert pickle.loads(pickle.dumps(case)).text == case.text


def test_the_statistics_of_a_sweep_are_those_of_the_command():
    case = phisindy.Case.from_file(TOP / "specs/case7.ron").set("data.0.duration", "20.0")
    sweep = phisindy.sweep(case, range(42, 47), jobs=2)
    ours = sweep.statistics()
    words = ["sweep", "specs/case7.ron", "--set", "data.0.duration=20.0", "--seeds", "5", "--format", "json", "--quiet"]
    theirs = json.loads(command(*words))
    for coefficient in theirs["coefficients"].values():
        del coefficient["bound"]
    assert ours == {key: theirs[key] for key in ours} and ours["runs"] == 5
    # A term too many, and one too few.
    terms = sweep[0]["equations"][0]["terms"]
    terms.append(terms[0] | {"candidate": "x1"})
    assert sweep.statistics()["exact_support"] == ours["exact_support"] - 1
    del terms[-1], terms[0]
    assert sweep.statistics()["exact_support"] == ours["exact_support"] - 1
    broken = phisindy.Sweep(case, [phisindy.Failed("why", "DataError")])
    assert broken.statistics()["exact_support"] == 0


def test_a_fleet_goes_on_from_what_is_kept(tmp_path):
    out, calls = tmp_path / "kept/fleet.jsonl", []

    def run(case, data, **options):
        calls.append(options)
        return phisindy.run(case, data, **options)

    good, bad = (phisindy.Case(SPEC), swing()), (phisindy.Case(SPEC), {"x": [1.0]})
    other = (phisindy.Case(SPEC), swing() | {"x": 2.0 * swing()["x"]})
    first = phisindy.map(run, [good, bad], out=out, jobs=1)
    assert first[0]["verdict"] == "identified"
    assert isinstance(first[1], phisindy.Failed) and first[1].kind == "DataError" and "`t`" in first[1].error
    # What failed is tried again, and what is new is done.
    again = phisindy.map(run, [good, other, bad], out=out, jobs=1)
    assert len(calls) == 2 + 2 and [again[0], again[2]] == first and again[1]["verdict"] == "identified"
    # Killed in the middle of a line: that run is done again, and the file is whole.
    out.write_bytes(out.read_bytes().rstrip(b"\n")[:-20])
    assert phisindy.map(run, [good, other], out=out, jobs=1) == again[:2] and len(calls) == 4
    assert all(json.loads(line)["key"] for line in out.read_text().splitlines())
    # A line that is torn in the middle of the file is told by its number.
    kept = out.read_bytes()
    for torn in (b"{\"key\"", b"[" * 100_000):
        out.write_bytes(kept.replace(b"\n", b"\n" + torn + b"\n", 1))
        with pytest.raises(phisindy.DataError, match="fleet.jsonl` holds no results .*line 2: .*remove that line"):
            phisindy.map(run, [good], out=out)
    out.write_bytes(kept)
    # Other options are another run.
    phisindy.map(run, [good], out=out, jobs=1, method="step")
    assert calls[-1] == {"jobs": 1, "method": "step"}
    out.write_text("a,b\n1,2\n")
    with pytest.raises(phisindy.DataError, match="holds no results"):
        phisindy.map(run, [good], out=out)
    assert out.read_text() == "a,b\n1,2\n"


def test_what_a_function_of_the_user_raises_is_the_failure_of_its_case():
    def run(case, path, **options):
        return phisindy.run(case, {"t": np.loadtxt(path)} if path else swing(), **options)

    case = phisindy.Case(SPEC)
    missing, good = phisindy.map(run, [(case, "nowhere.csv"), (case, None)])
    assert missing.kind == "FileNotFoundError" and good["verdict"] == "identified"
    (number,) = phisindy.map(lambda case, data, jobs: jobs, [case])
    assert number.kind == "DataError" and "returned a int" in number.error


def test_options_of_a_partial_function_are_part_of_its_name(tmp_path):
    case, kept = (phisindy.Case(SPEC), swing()), tmp_path / "kept.jsonl"
    for method in ("step", "trajectory"):
        (found,) = phisindy.map(functools.partial(phisindy.run, method=method), [case], out=kept)
        assert found["method"] == method


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no full disk")
def test_a_full_disk_is_told():
    with pytest.raises(phisindy.DataError, match="cannot write `/dev/full`"):
        phisindy.map(phisindy.run, [(phisindy.Case(SPEC), swing())], out="/dev/full")


def test_the_progress_of_many_runs_goes_to_a_function():
    told = []
    phisindy.map(phisindy.run, [(phisindy.Case(SPEC), swing())] * 4, progress=lambda *at: told.append(at))
    assert told == [(k / 4, "map") for k in range(1, 5)]


def test_a_worker_that_is_killed_loses_nothing(tmp_path):
    distributed = pytest.importorskip("distributed")
    case, seeds = phisindy.Case.from_file(TOP / "specs/case1a.ron").set("data.0.duration", "20.0"), 60
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        victim = next(iter(client.run(os.getpid).values()))
        killer = threading.Timer(0.3, os.kill, (victim, signal.SIGKILL))
        killer.start()
        found = phisindy.sweep(case, seeds, client=client, out=tmp_path / "sweep.jsonl")
        assert not killer.is_alive(), "it was killed while the others worked"
        assert victim not in client.run(os.getpid).values(), "it was killed"
    assert found == phisindy.sweep(case, seeds) and not any(isinstance(one, phisindy.Failed) for one in found)
    assert len((tmp_path / "sweep.jsonl").read_text().splitlines()) == seeds


def test_an_estimator_works_in_cross_validation():
    model_selection = pytest.importorskip("sklearn.model_selection")
    data = swing()
    X, y = data["t"][:, None], data["x"]
    model = phisindy.PhisindyRegressor(spec=SPEC)
    scores = model_selection.cross_val_score(model, X, y, cv=model_selection.TimeSeriesSplit(2))
    assert min(scores) > 0.99
    assert model.set_params(method="trajectory").get_params()["method"] == "trajectory"
    prediction = model.fit(X, y).predict(X)
    assert prediction.shape == y.shape and model.score(X, y) > 0.999
    assert model.score(X, y) > model.score(X, 1.3 * y), "another motion is predicted worse"
    with pytest.raises(ValueError, match="no parameter `depth`"):
        model.set_params(depth=3)


def test_an_estimator_has_the_units_of_the_spec():
    data = swing()
    millimetres = SPEC.replace('"x": "m", "v": "m/s"', '"x": "mm", "v": "mm/s"')
    X, y = data["t"][:, None], 1e3 * data["x"]
    model = phisindy.PhisindyRegressor(phisindy.Case(millimetres)).fit(X, y)
    assert np.abs(model.predict(X) - y).max() < 1.0 and abs(model.start_["x"] - 2000.0) < 1.0
    assert repr(model) == "PhisindyRegressor(spec=Case(states x, v))"


def test_a_grid_search_prefers_the_right_dictionary():
    model_selection = pytest.importorskip("sklearn.model_selection")
    data = swing()
    wrong = SPEC.replace('candidates: ["1", "|v|"]', 'candidates: ["|v|"]')
    search = model_selection.GridSearchCV(
        phisindy.PhisindyRegressor(), {"spec": [wrong, SPEC]}, cv=model_selection.TimeSeriesSplit(2)
    )
    search.fit(data["t"][:, None], data["x"])
    assert search.best_params_ == {"spec": SPEC} and search.best_score_ > 0.99
    (term,) = search.best_estimator_.result_.terms
    assert term["candidate"] == "1" and abs(term["coefficient"] - 0.3) < 0.001


def test_the_laws_are_there():
    laws = {law["id"]: law for law in phisindy.laws()}
    assert "stribeck" in laws and laws["stribeck"]["reference"]


def swinging(folder, name, friction, noise):
    """A swing with friction, measured: its spec, which holds all else."""
    t = np.arange(0.0, 9.0, 0.01)
    swing = np.floor(t / np.pi)
    x = friction * (-1.0) ** swing + (2.0 - friction - 2.0 * friction * swing) * np.cos(t)
    rows = np.column_stack([t, x + 0.002 * noise.standard_normal(t.size)])
    np.savetxt(folder / f"{name}.csv", rows, delimiter=",", header="t,x", comments="", fmt="%.6f")
    (folder / f"{name}.ron").write_text(
        f"""(states: {{ "x": "m", "v": "m/s" }}, constants: {{ "k": (1.0, "1/s^2") }},
        known: {{ "x": "v", "v": "-k*x" }}, contacts: ["v"], unknown: {{ "v": (factor: "-sgn(v)", candidates: ["1"]) }},
        data: [ Csv(path: "{name}.csv", time: "t", columns: {{ "x": "x" }}) ])"""
    )
    return folder / f"{name}.ron"


def test_a_fleet_is_compared_on_a_cluster_to_the_bit(tmp_path):
    """Each machine is a task, and the comparison has the bits of one process; a file that is replaced gives a new number."""
    distributed = pytest.importorskip("distributed")
    noise, out = np.random.default_rng(8), tmp_path / "fleet.jsonl"
    sizes = [0.30, 0.305, 0.295, 0.302, 0.298, 0.45]
    paths = [swinging(tmp_path, f"m{k}", size, noise) for k, size in enumerate(sizes)]
    alone = phisindy.compare(*paths)
    first = alone.to_dict()["machines"][0]
    assert first["name"].endswith("m5.ron") and first["needs_care"], alone
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        assert phisindy.compare(*paths, client=client, out=out).to_dict() == alone.to_dict()
    lines = out.read_text().splitlines()
    assert len(lines) == len(paths)
    # What is kept is not done again.
    assert phisindy.compare(*paths, out=out).to_dict() == alone.to_dict()
    assert out.read_text().splitlines() == lines
    # The sixth machine was mended: its data are others under the same name.
    swinging(tmp_path, "m5", 0.30, noise)
    mended = phisindy.compare(*paths, out=out)
    assert not any(machine["needs_care"] for machine in mended.to_dict()["machines"]), mended
    assert len(out.read_text().splitlines()) == len(paths) + 1
    (tmp_path / "m2.csv").unlink()
    with pytest.raises(phisindy.DataError, match="1 of 6 machines cannot be judged, the first is .*m2.ron.*m2.csv"):
        phisindy.compare(*paths, out=out)
    with pytest.raises(phisindy.DataError, match="for a fleet of three or more"):
        phisindy.compare(*paths[:2], out=out)


def test_records_of_one_machine_are_compared(tmp_path):
    """A swing whose friction fell, by specs that hold all else."""
    noise = np.random.default_rng(5)
    for name, friction in (("old", 0.30), ("new", 0.24)):
        swinging(tmp_path, name, friction, noise)
    found = phisindy.compare(tmp_path / "old.ron", tmp_path / "new.ron")
    assert found.verdict == "changed"
    assert "fell by" in found.sentence, found
    assert (found.save(tmp_path / "kept") / "report.html").is_file()
    assert "<iframe" in found._repr_html_()
    same = phisindy.compare(tmp_path / "old.ron", tmp_path / "old.ron")
    assert same.verdict == "unchanged", same
    with pytest.raises(phisindy.DataError, match="nowhere"):
        phisindy.compare(tmp_path / "old.ron", tmp_path / "nowhere.ron")
    # Nothing drives it: the next run is let go, and narrows the friction.
    plan = phisindy.next(tmp_path / "old.ron")
    assert plan.runs[0]["start"] and len(plan.drive["t_s"]) > 100, plan
    (number,) = plan.runs[0]["numbers"]
    assert number["promised"] < number["half_width"], number
    with pytest.raises(phisindy.DataError, match="no number `Fs`"):
        phisindy.next(tmp_path / "old.ron", narrow="Fs")
