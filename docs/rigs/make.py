"""Makes the pages of this folder: ten rigs of other people, what `phisindy` says of each, and what their authors found.

    python3 docs/rigs/make.py PROGRAM --data DIR [NAME...]     # PROGRAM is the path of `phisindy`, NAME one or more rigs

DIR holds the data files, which are not part of the project. Words stand in the table below; numbers come from the runs
alone: `result.json`, `report.html` and the sketch of each. Twice gives the same bytes. The index is made with all rigs.
"""

import argparse
import json
import math
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
TOP = HERE.parent.parent

# name: of the page; spec: from the top of the project; gap: `gap` first, then `run` of what it completed; short: for the
# index; rig, source, beside: words. `published` gives the published value of a number of the run.
RIGS = [
    {
        "name": "frame-250g",
        "title": "A frame that sticks and slips",
        "spec": "specs/frame_250g.ron",
        "gap": True,
        "rig": "A frame of one storey stands on a base that moves at 1 Hz. Brass rubs on steel under a disc of 250 g, "
        "so that the mass stops twice in each cycle and stands still for half of the time. Two lasers, 10 s at 250 Hz.",
        "source": "Marino and Cicirello, *A switching Gaussian process latent force model*, Data-Centric Engineering 4 (2023), "
        "github l-marino/switching-GPLFM, licence GPL-3.0.",
        "published": {"k": "1191 N/m", "c": "0.669 N s/m"},
        "short": "k 1191 N/m, c 0.669 N s/m",
        "also": {"words": "With one level of friction, the candidate of the spec", "set": []},
        "beside": "The authors give m = 3.08 kg, k = 1191 N/m and c = 0.669 N s/m. Both intervals hold "
        "their values. With one level of friction alone, the damper comes out higher than theirs: at one frequency a damper, "
        "a late "
        "laser and friction move the mass alike.\n\nFriction that changes along the path is one reading of this record. A spring "
        "that is softer on one side is another ([the newcomer's log](../tutorial-rig.md) ends with it). Two loads together "
        "([results](../results.md#real-rigs)) name Coulomb friction in proportion to the load, a delay between the lasers, and "
        "such a spring. What all readings share: 0.6 to 0.7 N of dry friction, and no elastic contact.",
    },
    {
        "name": "frame-continuous",
        "title": "The same frame, without stops",
        "spec": "docs/rigs/frame-continuous.ron",
        "rig": "The frame of the page before, with another contact, at 2.33 Hz: the mass turns, but it never stops. 10 s at 2 "
        "kHz, "
        "in millimetres, each laser with a zero of its own.",
        "source": "github xristosl0610/PhI-SINDy, by the authors of the paper whose method the program began with; no licence "
        "is stated.",
        "published": {"k": "386.4 1/s²", "c": "0.066 1/s", "1 in v": "0.12 to 0.13 m/s²"},
        "short": "k/m 386.4, c/m 0.066, F/m 0.12 to 0.13",
        "also": {"words": "With c held at the value of the authors", "set": ['constants.c=(0.0658, "1/s")']},
        "beside": "The authors give k/m = 386.4 and c/m = 0.066. With both of them held, the friction was found before as "
        "0.12 to 0.13 m/s². "
        "With c free, damping takes a part of it: the two trade off, which the program warns of, and the interval of the "
        "friction ends below 0.12. With c held, friction agrees with theirs. Who knows c should write it down.",
    },
    {
        "name": "emps",
        "title": "A prismatic drive",
        "spec": "docs/rigs/emps.ron",
        "rig": "EMPS, a carriage on a ball screw in closed loop: position and motor force, 25 s at 500 Hz, seven reversals. "
        "No spring holds it.",
        "source": "Janot, Gautier and Brunot, *Data set and reference models of EMPS* (2019), by way of github "
        "forgi86/sysid-neural-continuous; no licence is noted.",
        "published": {"M": "95.11 kg", "Fv": "203.5 N s/m", "sgn(v) in v": "20.39 N", "1 in v": "−3.16 N"},
        "short": "M 95.1 kg, Fv 203.5 N s/m, Fc 20.4 N, offset −3.16 N",
        "beside": "The authors fit the whole file by least squares: 95.11 kg, 203.5 N s/m, 20.39 N, −3.16 N. All four lie in the "
        "intervals, which come from half of the file. The verdict is no more than *named*: a force of a few newtons is left, "
        "for the offset of this drive changes while it runs. Without a spring a small force adds up, so the free run of the "
        "second half drifts.",
    },
    {
        "name": "pendulum",
        "title": "A pendulum that comes to rest",
        "spec": "docs/rigs/pendulum.ron",
        "rig": "A pendulum swings freely on its bearing until it stops, for more than a minute. An encoder reads the angle at "
        "150 Hz.",
        "source": "github nielsSkov/masterThesisMatlab; no licence is noted.",
        "also": {"words": "Without the viscous part", "set": ['unknown.w.candidates=["sgn(w)", "w*|w|"]']},
        "published": {"gl": "30.99 1/s²", "sgn(w) in w": "0.1825 1/s²", "w in w": "0.0209 1/s"},
        "short": "g/l 30.99, friction 0.1825, viscous 0.0209",
        "beside": "The author finds g/l = 30.99, friction 0.1825 and viscous damping 0.0209, without air. The friction agrees "
        "within "
        "the interval; g/l comes out a little lower than the author's. The viscous part cannot be told from zero here, beside "
        "the drag of the air that the program adds: viscous "
        "damping and constant friction alone cannot meet the decay of both large and small swings.\n\nThe other run has fewer "
        "numbers and "
        "is called identified, though its free run misses far more: that verdict speaks of the force that is left, which is "
        "small, and "
        "a small force adds up over a minute. The first model predicts better.",
    },
    {
        "name": "robot-joint",
        "title": "Joint 1 of a robot arm",
        "spec": "docs/rigs/robot-joint.ron",
        "rig": "The first joint of a UR10e swings to and fro, the other five stand still: angle and motor current, 63 s at "
        "100 Hz. "
        "The file has 31 columns and no heading.",
        "source": "github shamilmamedov/dynamic_calibration; no licence is noted.",
        "published": {},
        "short": "viscous over dry friction 1.69 s/rad",
        "beside": "The authors give torques: 21.3 N m s/rad of viscous friction and 12.6 N m of dry friction. They estimate "
        "the gain "
        "from ampere to torque from other records. The file holds currents, so this page gives rates per inertia, and only "
        "ratios "
        "compare. Viscous over dry friction is 1.69 s/rad for the authors, and {Fv/Fc} s/rad here; the intervals of both "
        "numbers are wide "
        "enough for either. A least-squares fit of torque over acceleration, speed and sign had 5.72 kg m², 22.1 N m s/rad "
        "and 13.6 N m: "
        "3.86 1/s and 2.38 1/s² per inertia. Both lie in the intervals above.",
        "derived": {"Fv/Fc": ("c", "sgn(w) in w")},
    },
    {
        "name": "wrist-joint",
        "title": "The wrist of a manipulator",
        "spec": "docs/rigs/wrist-joint.ron",
        "rig": "The last joint of a manipulator follows torque steps and sticks for seconds. Angle, speed and measured "
        "torque, a NumPy "
        "archive of 31 s, at times that are not uniform.",
        "source": "github YIZHIXIAOCANGSHU/Friction-Identification-MuJoCo-and-Pinocchio; no licence is noted.",
        "published": {"1 in v": "0.055 to 0.063 N m (least squares)", "|v| in v": "0.08 to 0.09 N m s/rad (least squares)"},
        "short": "Fc 0.055 to 0.063 N m, Fv 0.08 to 0.09 (least squares)",
        "beside": "We know of no published numbers for this joint. A least-squares fit of torque over speed gives a dry friction "
        "of 0.055 to 0.063 N m and a viscous part of 0.08 to 0.09 N m s/rad. The intervals hold both and are wide. No spring "
        "brings the joint "
        "back, so a model that lets go a moment too early stays wrong from then on. The verdict is right: this model names a "
        "size of the "
        "friction, and predicts nothing.",
    },
    {
        "name": "motor-steps",
        "title": "A motor under steps of torque",
        "spec": "docs/rigs/motor-steps.ron",
        "rig": "A servo motor turns under a torque that steps up once, from 0.05 N m forward and from 0.03 N m backward. Four "
        "MATLAB files "
        "of 20 s: two are fitted, two are not.",
        "source": "github malik-robert/HSM150-data; no licence is noted.",
        "published": {
            "J": "1.54e-4 kg m² (own simulation)", "sgn(v) in v": "0.028 N m (own simulation)", "b": "1.7e-4 N m s/rad (own simulation)",
        },
        "short": "J 1.54e-4, Fc 0.028 N m, b 1.7e-4 (own simulation)",
        "also": {"words": "With dry friction as the only candidate", "set": ['unknown.v.candidates=["sgn(v)"]']},
        "beside": "We know of no published numbers. A simulation of our own gives J = 1.54e-4 kg m², a dry friction of "
        "0.028 N m, and b = 1.7e-4 N m s/rad. The viscous part agrees.\n\nForward the motor takes more torque than backward "
        "at the "
        "same speed, so dry friction alone contradicts itself, and the program says so. The spec therefore offers a "
        "second candidate, `1`, a torque that the sensor does not show. With it the dry friction is half of what our "
        "simulation had, "
        "and its other half is that torque. J comes out higher than in our simulation. More than half of the acceleration in "
        "the first "
        "second is still not explained.",
    },
    {
        "name": "mr-damper",
        "title": "A magneto-rheological damper",
        "spec": "docs/rigs/mr-damper.ron",
        "gap": True,
        "rig": "A damper with a fluid that stiffens in a magnetic field, moved by a machine: displacement is prescribed, "
        "force is "
        "measured, 30 s at 100 Hz. The MATLAB file holds mm and N and does not say so.",
        "source": "github labcontrol-data/mr-damper, UTFPR; no licence is noted.",
        "published": {"Fc": "57.4 N (Dahl)", "kt": "1.58e6 N/m (Dahl)", "c": "768 N s/m (Dahl)"},
        "short": "Dahl: 57.4 N, 1.58e6 N/m, 768 N s/m, NRMSE 0.137",
        "beside": "A Dahl element with a damper, fitted independently to this file, has 57.4 N, 1.58e6 N/m and 768 N s/m and "
        "misses the "
        "force by 0.137 of its standard deviation. The program finds the same kind of element and adds a weak spring, which "
        "lowers the "
        "miss. The friction of its element is higher than 57.4 N, beyond the interval: the models differ by the spring.",
    },
    {
        "name": "silverbox",
        "title": "The Silverbox",
        "spec": "specs/silverbox.ron",
        "gap": True,
        "rig": "An electronic circuit that behaves as a mass on a hardening spring, with no friction at all, under a "
        "multisine, sampled at "
        "610 Hz. It is here as a trap: who looks for friction must find none.",
        "source": "Wigren and Schoukens, *Three free data sets for development and benchmarking in nonlinear system "
        "identification* "
        "(2013); no licence is noted.",
        "published": {"k": "1.763e5 1/s² (differences)", "c": "39.7 1/s (differences)", "g": "1.604e5 1/s² (differences)", "k3": "5.58e5 (differences)"},
        "short": "a cubic spring, no friction",
        "beside": "A regression on differences gives k = 1.763e5, c = 39.7, g = 1.604e5 and k3 = 5.58e5. With nine samples in "
        "a period such "
        "differences are too small, by 4 % at the first and a third at the third harmonic, so they do not find what a free "
        "run needs: of a simulated record with k = 1.842e5, c = 41.9, g = 1.860e5 and k3 = 7.35e5 they make "
        "1.758e5, 39.7, 1.603e5 and 6.15e5. No friction is found. `gap` says *named*, because the coarse input can be drawn "
        "in more "
        "than one way and something of another form is left.",
    },
    {
        "name": "ball-and-beam",
        "title": "A ball on a beam",
        "spec": "docs/rigs/ball-and-beam.ron",
        "rig": "A ball rolls on a beam that a motor tilts: angle in, position out, 100 s at 10 Hz, no column of time. Nothing "
        "holds the ball, "
        "so a small force adds up.",
        "source": "DaISy, by way of github Rafa7046/Non_Linear_Identification; no licence is noted.",
        "published": {"a": "0.42 to 0.45 (least squares)"},
        "short": "a 0.42 to 0.45 (least squares)",
        "beside": "We know of no published model of this ball. Least squares over two or more segments of the file gives a = "
        "0.42 to 0.45, and one "
        "segment of 50 s gives 0.08. The program agrees with the former, and takes neither of the two friction terms that the "
        "spec offers.\n\n"
        "The force that is left is most of the small acceleration that there is. A few seconds ahead the model predicts "
        "better than the "
        "linear one. Far ahead it is lost, for nothing holds the ball; an integrating plant is not for long predictions.",
    },
]


def places(value, digits):
    """A number with so many places, never as 1e-05 or -0."""
    value = float(f"{value:.{digits}g}")
    text = f"{value:.{10 if 1e-4 <= abs(value) < 1e7 else digits}g}"
    mantissa, _, power = text.partition("e")
    return f"{mantissa}e{int(power)}" if power else text


def percent(part):
    return f"{places(100 * float(f'{part:.1e}'), 6)} %"


def code(text):
    """A code span that may stand in a table."""
    return "`" + text.replace("|", "\\|") + "`"


def prose(text):
    """What the program says, as text of a page: its stars, bars and brackets are no marks."""
    parts = text.split("`")
    parts[::2] = [re.sub(r"([*|\[\]_<>])", r"\\\1", part) for part in parts[::2]]
    return "`".join(parts)


def sentence(text):
    text = text.strip()
    return text[:1].upper() + text[1:] + ("" if text.endswith((".", "!", "?")) else ".")


def wrapped(text, prefix="", width=124):
    """Paragraphs of a page, in lines of this width."""
    out = []
    for paragraph in text.split("\n\n"):
        line, lines = prefix, []
        # A line that begins with such a word would be a list, a heading or a quotation.
        for word in re.sub(r"\s+([-+=>#*]|\d+[.)])(?=\s)", "\N{NO-BREAK SPACE}\\1", " ".join(paragraph.split())).split(" "):
            if len(line) + 1 + len(word) > width and line.strip():
                lines.append(line)
                line = ("  " if prefix == "- " else prefix) + word
            else:
                line = line + word if line == prefix else f"{line} {word}"
        out.append("\n".join(lines + [line]).replace("\N{NO-BREAK SPACE}", " "))
    return "\n\n".join(out)


class Runs:
    """The runs of one rig, in a folder of their own."""

    def __init__(self, program, data, rig, folder):
        self.rig = rig
        self.folder = folder
        self.spec = TOP / rig["spec"]
        shown, file = rig["spec"], self.spec
        self.commands, self.gap = [], None
        if rig.get("gap"):
            self.gap = self.play(program, data, "gap", str(file), shown, "found")
            shown = "found/completed.ron"
            file = folder / shown
        self.run = self.play(program, data, "run", str(file), shown, "last" if self.gap else "found")
        self.also = None
        if "also" in rig:
            self.also = self.play(program, data, "run", str(self.spec), rig["spec"], "other", rig["also"]["set"])

    def play(self, program, data, command, file, shown, out, changes=()):
        words = [word for change in changes for word in ("--set", change)]
        done = subprocess.run(
            [program, command, file, "--data", data, "--out", str(self.folder / out), "--quiet", *words],
            capture_output=True, text=True, check=False,
        )
        if done.returncode not in (0, 1):
            sys.exit(f"{command} {file}\n{done.stderr}")
        said = "".join(f" --set '{change}'" for change in changes)
        self.commands.append(f"phisindy {command} {shown} --data DIR --out {out}{said}")
        return json.loads((self.folder / out / "result.json").read_text())

    def spec_that_ran(self):
        return (self.folder / ("last" if self.gap else "found") / "spec.ron").read_text()

    def unknown(self):
        """The state and the factor of what the spec offers; none without candidates."""
        found = re.search(r'unknown:\s*\{\s*"(\w+)":\s*\(factor:\s*"([^"]*)"', self.spec_that_ran())
        return found.groups() if found and not self.gap else None

    def finding(self, out):
        """The sentence at the head of a report."""
        report = (self.folder / out / "report.html").read_text()
        found = re.search(r'<p id="finding" class="finding">(.*?)</p>', report, re.S)
        text = re.sub(r"<[^>]*>", "", found.group(1))
        for mark, sign in (("&lt;", "<"), ("&gt;", ">"), ("&quot;", '"'), ("&#39;", "'"), ("&amp;", "&")):
            text = text.replace(mark, sign)
        return text.replace("?.", "?")

    def sketch(self):
        """The sketch of the first report, with its style, as a file of its own; none where the report has none."""
        report = (self.folder / "found" / "report.html").read_text()
        if 'id="model-sketch"' not in report:
            return None
        return (self.folder / "found" / "figures" / "model-sketch.svg").read_text()

    def laws(self):
        """The laws that `gap` added, those that help and do not explain included."""
        return self.gap["steps"] + self.gap["partial"]

    def numbers(self):
        """Rows of (number, unit, value, interval, published)."""
        rows, published = [], self.rig["published"]
        for equation in self.run["equations"]:
            for term in equation["terms"]:
                name = f"{term['candidate']} in {equation['state']}"
                rows.append((f"{term['candidate']} in {equation['state']}'", term["unit"], term["coefficient"], term, published.get(name, "")))
        for of in self.run["parameters"]:
            rows.append((of["name"], of["unit"], of["value"], of, published.get(of["name"], "")))
        missing = set(published) - {r[0] for r in rows} - {r[0].rstrip("'") for r in rows}
        assert not missing, f"{self.rig['name']}: published, but not in the run: {missing}"
        return rows

    def unseen(self):
        """The horizons of the record that was not fitted and that is predicted worst so far ahead."""
        seen = {r["name"] for r in self.run["records"] if r["role"] != "validate"}
        all_of = [h for h in self.run["horizon"] if h["record"] not in seen]
        if not all_of:
            return []
        farthest = max(h["seconds"] for h in all_of)
        worst = max((h for h in all_of if h["seconds"] == farthest), key=lambda h: h["nrmse"])
        return [h for h in all_of if (h["record"], h["column"]) == (worst["record"], worst["column"])]

    def not_fitted(self):
        """The largest NRMSE of the records that were not fitted."""
        all_of = [v for r in self.run["records"] if r["role"] == "validate" for v in r["nrmse"].values() if v is not None]
        return max(all_of) if all_of else None


def page(runs):
    rig, run, gap = runs.rig, runs.run, runs.gap
    out = [f"# {rig['title']}", "", wrapped(rig["rig"]), ""]
    out += [wrapped("Source: " + rig["source"] + " The data are not part of this project."), ""]
    if not runs.sketch():
        out += ["There is no sketch: the program draws bodies, and a model of a prescribed motion has none.", ""]
    else:
        out += [f"![The model as a sketch; what was found is blue]({rig['name']}-sketch.svg)", ""]
    spec = rig["spec"]
    where = f"[`{spec}`]({pathlib.Path(spec).name})" if spec.startswith("docs/rigs/") else f"`{spec}`"
    out += [f"The spec is {where}. `DIR` is the folder of the data.", "", "```sh", *runs.commands, "```", ""]
    out += ["## What the program says", ""]
    if gap:
        out += [wrapped(f"**{gap['status'].capitalize()}**, says `gap`. " + prose(sentence(runs.finding("found")))), ""]
        if gap["status"] == "unexplained":
            out += ["These laws help, and do not explain all of it:", ""]
        if runs.laws():
            out += ["| step | law | gap on data not used, in units of the noise |", "|---|---|---|"]
            out += [f"| | the model as it is | {places(gap['initial']['validate'], 3)} |"]
            for k, step in enumerate(runs.laws()):
                out += [f"| {k + 1} | {step['name']} at {code(step['at'])} | {places(step['validate']['after'], 3)} |"]
            out += [""]
        near = {r["law"]: r["delta_bic"] for step in runs.laws() for r in step["rivals"] if r["delta_bic"] < 10.0}
        if near:
            names = ", ".join(code(law) for law in sorted(near, key=lambda law: near[law]))
            out += [wrapped(f"In their place the data do not exclude: {names}."), ""]
        out += ["The completed model, fitted once more:", ""]
    reason = run["reason"]
    said = f"**{run['verdict'].capitalize()}**" + (f": {prose(reason)}." if reason else ".")
    out += [wrapped(said + " It " + prose(run["basis"]) + "."), ""]
    for equation in run["equations"]:
        out += ["$$" + equation["latex"] + "$$", ""]
    text = runs.spec_that_ran()
    for output, reads in re.findall(r'"(\w+)": \(unit: "[^"]*", reads: "([^"]*)"', text):
        out += [f"It reads `{output} = {reads}`.", ""]
    rows = runs.numbers()
    beside = any(r[4] for r in rows)
    out += ["| number | unit | value | 95 % interval |" + (" found elsewhere |" if beside else "")]
    out += ["|---|---|---|---|" + ("---|" if beside else "")]
    for name, unit, value, of, published in rows:
        low, high = of["ci95"]
        digits, interval = 4, "none"
        if low is not None and high is not None:
            narrow = (high - low) / max(abs(low), abs(high), 1e-300)
            digits = min(max(4, 2 - math.floor(math.log10(narrow))), 8) if narrow > 0.0 else 8
            interval = f"[{places(low, digits)}, {places(high, digits)}]"
        interval += ", at its bound" if of["at_bound"] else ""
        out += [f"| {code(name)} | {prose(unit or '1')} | {places(value, digits)} | {interval} |" + (f" {published} |" if beside else "")]
    out += [""]
    if runs.unknown() and any(e["terms"] for e in run["equations"]):
        state, factor = runs.unknown()
        out += [wrapped(f"A number in {code(state + chr(39))} is that of a candidate: the rate has {code(factor)} times their sum."), ""]
    out += ["### The force that is left", ""]
    if run["remainder"]:
        for left in run["remainder"]:
            low, high = left["where"]
            text = (
                f"On {code(left['at'])} of {left['record']}: {places(left['rms'], 3)} {prose(left['unit'])} (rms), {percent(left['share'])} of the "
                f"whole, strongest from {places(low, 4)} to {places(high, 4)} s. What of it follows the motion is {percent(left['of_motion'])} of the whole."
            )
            out += [wrapped(text), ""]
    else:
        out += ["No force of a size that the program would tell.", ""]
    out += ["### How far it predicts", ""]
    horizon = runs.unseen()
    if horizon:
        first = horizon[0]
        linear = (
            "The linear model is an autoregression on all columns and inputs, and starts from measured samples."
            if any(h["baseline"] is not None for h in horizon)
            else "There is no linear model beside it: an autoregression needs times that are uniform."
        )
        start = (
            "This model starts from what a filter makes of the samples up to there."
            if run["remainder"]
            else "This model starts from where its free run is, not from a measured sample, so the first line is no better than the others."
        )
        out += [wrapped(
            f"{code(first['column'])} of {first['record']}, which was not fitted; errors in parts of its standard deviation. {start} {linear}"
        ), ""]
        both = any(h["baseline"] is not None for h in horizon)
        out += ["| seconds ahead | this model |" + (" linear model |" if both else ""), "|---|---|" + ("---|" if both else "")]
        for h in horizon:
            base = "-" if h["baseline"] is None else percent(h["baseline"])
            out += [f"| {places(h['seconds'], 3)} | {percent(h['nrmse'])} |" + (f" {base} |" if both else "")]
        out += [""]
    else:
        out += ["The program gives no horizon for this run.", ""]
    said = [w for w in run["warnings"] if "is the derivative of" not in w and not w.endswith("(decimate)")]
    if said:
        out += ["### It warns", ""]
        out += [wrapped(prose(w), "- ") for w in said]
        out += [""]
    if runs.also:
        text = f"{rig['also']['words']}: **{runs.also['verdict']}**. " + prose(runs.finding("other"))
        out += ["### Another run", "", wrapped(text), ""]
    beside = rig["beside"]
    values = {name.rstrip("'"): value for name, _, value, _, _ in rows}
    for name, (above, below) in rig.get("derived", {}).items():
        beside = beside.replace("{" + name + "}", places(values[above] / values[below], 3))
    out += ["## What others found", "", wrapped(beside), ""]
    return "\n".join(out)


def law(runs):
    """What was found, for the index."""
    if runs.gap:
        names = [step["name"] for step in runs.laws()]
        return "; ".join(names) if names else "nothing that helps"
    terms = [t["candidate"] for e in runs.run["equations"] for t in e["terms"]]
    if not terms:
        return "no friction"
    factor = runs.unknown()[1]
    return code(factor if terms == ["1"] else f"{factor}*({' + '.join(terms)})")


def index(all_runs):
    out = [
        "# Ten rigs of other people", "",
        wrapped(
            "Ten public records, each with a page: what the rig is, the model as a sketch, the spec, the command, and what comes out, with "
            "intervals and the program's own verdict. Some models are explained, some are not, and some differ from what the authors "
            "found; each page says so."
        ), "",
        "| rig | what was found | verdict | NRMSE, not fitted | found elsewhere |", "|---|---|---|---|---|",
    ]
    for runs in all_runs:
        rig, miss = runs.rig, runs.not_fitted()
        verdict = f"{runs.gap['status']}, then {runs.run['verdict']}" if runs.gap else runs.run["verdict"]
        out += [
            f"| [{rig['title']}]({rig['name']}.md) | {law(runs)} | {verdict} | {'-' if miss is None else places(miss, 2)} | {rig['short']} |"
        ]
    out += [
        "", wrapped(
            "What was found: the law that `gap` named, or the factor of the spec and the candidates that `run` kept. NRMSE: the miss of a free run of "
            "the part that was not fitted, over its standard deviation. Of two verdicts the first is that of `gap` and the second that of "
            "`run` on the completed model. *Named* says that a force is left beside what was found."
        ), "",
        wrapped(
            "The data are other people's and are not part of this project; each page says where they are. `python3 docs/rigs/make.py PROGRAM "
            "--data DIR` makes all pages again."
        ), "",
    ]
    return "\n".join(out)


def write(path, text):
    path.write_text(text, encoding="utf-8", newline="\n")


def main():
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("program")
    asked.add_argument("--data", required=True, help="folder of the data files")
    asked.add_argument("names", nargs="*")
    asked = asked.parse_intermixed_args()
    program = shutil.which(asked.program)
    if not program:
        sys.exit(f"no program `{asked.program}`")
    program = str(pathlib.Path(program).resolve())
    unknown = set(asked.names) - {rig["name"] for rig in RIGS}
    if unknown:
        sys.exit(f"no rig {unknown}")
    done = []
    with tempfile.TemporaryDirectory() as scratch:
        for rig in RIGS:
            if asked.names and rig["name"] not in asked.names:
                continue
            folder = pathlib.Path(scratch) / rig["name"]
            folder.mkdir()
            runs = Runs(program, str(pathlib.Path(asked.data).resolve()), rig, folder)
            write(HERE / f"{rig['name']}.md", page(runs))
            if runs.sketch():
                write(HERE / f"{rig['name']}-sketch.svg", runs.sketch())
            print(rig["name"], runs.gap["status"] if runs.gap else "", runs.run["verdict"], flush=True)
            done.append(runs)
        if not asked.names:
            write(HERE / "README.md", index(done))


if __name__ == "__main__":
    main()
