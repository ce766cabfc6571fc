"""The border drawn by dice: whatever is given, the package answers or raises an exception of its own. PHISINDY_ODD is how often."""

import os
import random
import warnings
from pathlib import Path

import numpy as np
import pytest

import phisindy
from test_phisindy import SPEC, swing

TIMES = int(os.environ.get("PHISINDY_ODD", "0"))
SEED = int(os.environ.get("PHISINDY_SEED", "1"))
SHORT = {name: values[:60] for name, values in swing().items()}
MADE = SPEC[:-1] + ', data: [Synthetic(truth: { "v": "-0.3*sgn(v)" }, start: { "x": 2.0, "v": 0.0 }, duration: 9.0, step: 0.1)])'


class Hostile:
    """Answers every question with an error."""

    def __getattr__(self, name):
        raise AttributeError(name) if name.startswith("__") else RuntimeError(name)

    def __array__(self, *_):
        raise RuntimeError("no array")

    def __len__(self):
        return -1


def scalar(dice):
    """One argument of any kind."""
    return dice.choice([
        None, True, -1, 0, 1, 2**63, 2**64, -(2**70), 10**400, 0.5, -0.0, float("nan"), float("inf"), 1e308, "", "x", "t", "\0", "\ud800", "é" * 999,
        "learn.cutoff", "data.0.noise", "data.99999999999999999999", "Additive(0.02)", "((((", b"x", b"\xff", [], [1], {}, {"x": 1}, (), set(), object(),
        Hostile(), np.float32(1), np.int64(3), np.array(2.0), np.datetime64("NaT"), range(3), iter([1]), lambda *_: 1, 1 + 2j, Path("nowhere"), Path("\0"),
    ])


def column(dice):
    """What may stand for a column."""
    rows = dice.choice([0, 1, 2, 59, 60, 61])
    plain = np.linspace(0.0, 5.9, rows)
    return dice.choice([
        plain, plain[::-1], plain.astype(np.float16), plain.astype(">f8"), plain.astype(object), plain.astype(str), plain.astype("M8[s]"), plain * 1e300,
        plain * np.nan, np.zeros(rows), plain[::2], np.asfortranarray(np.outer(plain, plain)), np.ma.masked_less(plain, 1), plain.tolist(), tuple(plain),
        np.array([None] * rows), np.frombuffer(b"\0" + plain.tobytes(), np.float64, rows, 1), plain > 1, memoryview(plain), "text", 3.0, Hostile(), None,
    ])


def table(dice):
    """What may stand for a table, or for several."""
    good = {name: values.copy() for name, values in SHORT.items()}
    if dice.random() < 0.5:
        good[dice.choice(["t", "x", "v", "", "k", "é", "\0", "\ud800", 3, None])] = column(dice)
    if dice.random() < 0.2:
        del good[dice.choice(list(good))]
    return dice.choice([good, good, good, [good, good], (good,), [], [None], scalar(dice), [scalar(dice)], good.items(), np.array([(1.0, 2.0)], "f8, f8")])


def spec(dice):
    """A spec with up to three damages."""
    text = dice.choice([SPEC, MADE])
    for _ in range(dice.randrange(4)):
        at = dice.randrange(len(text))
        text = text[:at] + dice.choice(["", "\0", '"', "(", "}", "1e999", "é", "-", "x", ","]) + text[at + dice.randrange(9):]
    return text


def case(dice):
    return phisindy.Case(SPEC if dice.random() < 0.5 else MADE)


# Functions of dice; what cost most come least.
CALLS = [
    lambda dice, _: phisindy.Case(dice.choice([spec(dice), scalar(dice)]), folder=dice.choice(["", scalar(dice)])),
    lambda dice, _: phisindy.Case(spec(dice)).check(),
    lambda dice, _: case(dice).set(scalar(dice), scalar(dice)).check(),
    lambda dice, _: phisindy.Case.from_file(scalar(dice)),
    lambda dice, _: phisindy.simulate(case(dice), table(dice), seed=scalar(dice)),
    lambda dice, _: phisindy.simulate(scalar(dice)),
    lambda dice, _: phisindy.laws(scalar(dice)),
    lambda dice, _: phisindy.run(case(dice), table(dice), jobs=1),
    lambda dice, _: phisindy.run(case(dice), SHORT, **{dice.choice(["seed", "method", "jobs", "laws", "progress"]): scalar(dice)}),
    lambda dice, _: phisindy.sweep(case(dice), scalar(dice) if dice.random() < 0.9 else 2, jobs=1),
    lambda dice, _: phisindy.map(dice.choice([phisindy.run, scalar(dice)]), [(case(dice), table(dice))], jobs=1),
    lambda dice, folder: journal(dice, folder),
]


def journal(dice, folder):
    """A sweep that goes on from a damaged file."""
    path = folder / "journal.jsonl"
    path.unlink(missing_ok=True)
    made = phisindy.Case(MADE)
    phisindy.sweep(made, 2, jobs=1, out=path)
    text = bytearray(path.read_bytes())
    for _ in range(dice.randrange(1, 4)):
        at = dice.randrange(len(text))
        text[at : at + dice.randrange(9)] = dice.choice([b"", b"\n", b"\0", b"{", b'"', b"[]\n", b"null\n", b"3\n", b'{"key":1,"result":2}\n', b"\xff"])
    path.write_bytes(text)
    phisindy.sweep(made, 2, jobs=1, out=path).statistics()


@pytest.mark.parametrize("which", range(len(CALLS)))
def test_whatever_is_given_is_answered_or_refused_by_name(which, tmp_path):
    dice = random.Random(SEED * len(CALLS) + which)
    for time in range(TIMES // len(CALLS)):
        state = dice.getstate()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                CALLS[which](dice, tmp_path)
        except phisindy.PhisindyError as error:
            assert str(error), (which, time)
        except BaseException as error:  # A panic of the library is none of `Exception`.
            dice.setstate(state)
            raise AssertionError(f"call {which}, draw {time} (PHISINDY_SEED={SEED}): {type(error).__name__}: {error}") from error
