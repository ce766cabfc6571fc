"""Draws film.svg, the first picture of the README: the carriage of the tutorial, moving and sticking.

    python3 docs/tutorial/film.py PROGRAM        # PROGRAM is the path of `phisindy`

Everything that moves comes from rig.csv and from `phisindy simulate`: the laser, the model without friction, and the model
with the law that `phisindy gap` finds. The part shown was not fitted. Twice gives the same bytes.
"""

import csv
import io
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
RECORD, FROM, UNTIL = "second half", 6.0, 9.6  # what the film shows, in seconds of the rig
SLOWER, HOLD = 2.0, 0.8  # the film is slower than the rig, and holds its last frame for so many seconds
EVERY = 2  # samples of the rig from frame to frame

WALL, CENTRE, GROUND, SCALE = 56.0, 372.0, 136.0, 7.5  # places in the picture; pixels of a millimetre
WIDE, TALL = 104.0, 54.0  # the carriage
LEFT, RIGHT, TOP, BOTTOM, REACH = 70.0, 742.0, 182.0, 306.0, 18.0  # the curve; its axis reaches so many millimetres

STYLE = """
svg { --paper: #ffffff; --ink: #1b1f24; --soft: #57606a; --line: #d5dae0; --body: #c9d1d9; --law: #0072b2; --bare: #c04f00;
  --laser: #7b838c; --stick: #e69f00; font: 13px system-ui, -apple-system, "Segoe UI", "DejaVu Sans", Arial, sans-serif; }
@media (prefers-color-scheme: dark) {
  svg { --paper: #10151b; --ink: #e6edf3; --soft: #a3adb8; --line: #323a43; --body: #3d4752; --law: #56b4e9; --bare: #f0814a;
    --laser: #949da7; --stick: #e69f00; }
}
text { fill: var(--ink); }
.soft { fill: var(--soft); font-size: 12px; }
.end { text-anchor: end; }
.middle { text-anchor: middle; }
.paper { fill: var(--paper); }
.body { fill: var(--body); }
.strip { fill: var(--stick); }
.word { font-weight: 600; }
.thin { stroke: var(--soft); stroke-width: 1.2; fill: none; }
.grid { stroke: var(--line); stroke-width: 1; fill: none; }
.piece { stroke: var(--ink); stroke-width: 1.8; fill: none; stroke-linejoin: round; vector-effect: non-scaling-stroke; }
.arrow { fill: var(--soft); }
.laser, .law, .bare { fill: none; stroke-linejoin: round; stroke-linecap: round; }
.laser { stroke: var(--laser); stroke-width: 4; }
.law { stroke: var(--law); stroke-width: 1.8; }
.bare { stroke: var(--bare); stroke-width: 1.8; stroke-dasharray: 7 4; }
.beam { stroke: var(--laser); stroke-width: 1.4; stroke-dasharray: 2 3; }
circle.laser { fill: var(--laser); stroke: none; }
circle.law { fill: var(--law); stroke: none; }
circle.bare { fill: var(--bare); stroke: none; }
.still { display: none; }
@media (prefers-reduced-motion: reduce) { .live { display: none; } .still { display: inline; } }
"""


def number(value, digits=1):
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".") if digits else f"{value:.0f}"
    return "0" if text in ("", "-0") else text


def measure(program, folder):
    """Plays the tutorial in a folder: samples of both models, and by how much each misses the part that was not fitted."""

    def phisindy(*words, codes=(0, 1)):
        done = subprocess.run([program, *words], cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode not in codes:
            sys.exit(f"phisindy {' '.join(words)}\n{done.stderr}")
        return done.stdout

    shutil.copy(HERE / "rig.csv", folder)
    phisindy("new", "rig.csv", "--out", "rig.ron")
    spec = folder / "rig.ron"
    text, found = re.subn(r'"m": \(value: .*', '"m": (2.0, "kg"),', spec.read_text(), count=1)  # the carriage was weighed
    assert found == 1, "the line of the mass in the draft"
    spec.write_text(text)
    phisindy("gap", "rig.ron", "--out", "found")
    phisindy("run", "found/completed.ron", "--data", ".", "--out", "law")
    phisindy("run", "rig.ron", "--data", ".", "--out", "bare", "--set", "unknown={}", "--set", "contacts=[]")
    samples, misses = {}, {}
    for name in ("law", "bare"):
        rows = csv.DictReader(io.StringIO(phisindy("simulate", f"{name}/identified.ron", "--data", ".")))
        samples[name] = [r for r in rows if r["record"] == RECORD and FROM - 1e-9 <= float(r["t"]) <= UNTIL + 1e-9]
        records = json.loads((folder / name / "result.json").read_text())["records"]
        misses[name] = next(r["nrmse"]["x"] for r in records if r["name"] == RECORD)
    return samples, misses


def hold(frames):
    """The values of an animation, with the last one held at the end."""
    step = EVERY * 0.008 * SLOWER
    return frames + [frames[-1]] * round(HOLD / step)


def animate(frames, duration, attribute=None, kind=None, digits=1):
    values = ";".join(number(v, digits) for v in hold(frames))
    what = f'animateTransform attributeName="transform" type="{kind}"' if kind else f'animate attributeName="{attribute}"'
    return f'<{what} values="{values}" dur="{duration}s" repeatCount="indefinite"/>'


def switch(frames, duration):
    """Opacity that jumps: only the frames where it changes are written."""
    frames = hold(frames)
    at = [k for k in range(len(frames)) if k == 0 or frames[k] != frames[k - 1]]
    times = ";".join(number(k / (len(frames) - 1), 4) for k in at)
    values = ";".join(number(frames[k]) for k in at)
    return (
        f'<animate attributeName="opacity" calcMode="discrete" keyTimes="{times}" values="{values}" dur="{duration}s" '
        'repeatCount="indefinite"/>'
    )


def draw(samples, misses):
    law, bare = samples["law"], samples["bare"]
    times = [float(r["t"]) for r in law]
    motion = {
        "bare": [1e3 * float(r["x_model"]) for r in bare],
        "laser": [1e3 * float(r["x"]) for r in law],
        "law": [1e3 * float(r["x_model"]) for r in law],
    }
    force = [float(r["F"]) for r in law]
    sticks = [float(float(r["v_model"]) == 0.0) for r in law]
    pick = range(0, len(times), EVERY)
    frame = {name: [SCALE * values[k] for k in pick] for name, values in motion.items()}
    duration = number(EVERY * 0.008 * SLOWER * (len(hold(frame["law"])) - 1), 3)

    def across(t):
        return LEFT + (RIGHT - LEFT) * (t - FROM) / (UNTIL - FROM)

    def up(x):
        return (TOP + BOTTOM) / 2 - (BOTTOM - TOP) / 2 * x / REACH

    def moved(frames, inside, live, kind="translate"):
        """Something that follows these values; still, it stands where the last one puts it."""
        last = number(frames[-1], 4 if kind == "scale" else 1)
        made = animate(frames, duration, kind="translate") if live and kind == "translate" else ""
        if live and kind == "scale":
            # `scale` with one number would stretch both ways.
            values = ";".join(f"{number(v, 4)} 1" for v in hold(frames))
            made = (
                f'<animateTransform attributeName="transform" type="scale" values="{values}" dur="{duration}s" '
                'repeatCount="indefinite"/>'
            )
        return f'<g transform="{kind}({last}{" 1" if kind == "scale" else ""})">{made}{inside}</g>'

    rest = CENTRE - WIDE / 2 - WALL
    top, middle = GROUND - TALL, GROUND - TALL / 2
    coils = [(0.0, 0.0), (22.0, 0.0)]
    coils += [(22.0 + (rest - 44.0) * (k + 0.5) / 12, 9.0 * (-1) ** k) for k in range(12)]
    coils += [(rest - 22.0, 0.0), (rest, 0.0)]
    zigzag = "M" + "L".join(f"{number(x)} {number(y)}" for x, y in coils)
    strip, word = ([sticks[k] for k in pick],) * 2
    outline = f'x="{number(CENTRE - WIDE / 2)}" y="{number(top)}" width="{number(WIDE)}" height="{number(TALL)}" rx="4"'
    far = 718.0

    def scene(live):
        jump = switch(strip, duration) if live else ""
        shown = f'opacity="{number(strip[-1])}"'
        out = []
        stretch = [(rest + x) / rest for x in frame["laser"]]
        spring = moved(stretch, f'<path class="piece" d="{zigzag}"/>', live, "scale")
        out.append(f'<g transform="translate({number(WALL)} {number(middle)})">{spring}</g>')
        edge = far - CENTRE - WIDE / 2
        beam = moved([-(edge - x) / edge for x in frame["laser"]], f'<path class="beam" d="M0 0H{number(edge)}"/>', live, "scale")
        out.append(f'<g transform="translate({number(far)} {number(middle)})">{beam}</g>')
        push = [force[k] / 7.0 for k in pick]
        arrow = moved(push, '<path class="arrow" d="M0 -2H52V-7L70 0L52 7V2H0z"/>', live, "scale")
        body = (
            f'<rect class="body" {outline}/><text class="middle" x="{number(CENTRE)}" y="{number(middle + 5)}">2 kg</text>'
            f'<g {shown}>{jump}<rect class="strip" x="{number(CENTRE - WIDE / 2)}" y="{number(GROUND - 4)}" '
            f'width="{number(WIDE)}" height="8"/><text class="word middle" x="{number(CENTRE)}" y="{number(GROUND + 22)}">'
            f'sticks</text></g><g transform="translate({number(CENTRE)} {number(top - 13)})">{arrow}</g>'
            f'<text class="soft middle" x="{number(CENTRE)}" y="{number(top - 26)}">force</text>'
        )
        out.append(moved(frame["laser"], body, live))
        out.append(moved(frame["bare"], f'<rect class="bare" {outline}/>', live))
        out.append(moved(frame["law"], f'<rect class="law" {outline}/>', live))
        for name, values in motion.items():
            there, here = [across(times[k]) for k in pick], [up(values[k]) for k in pick]
            run = animate(there, duration, "cx") + animate(here, duration, "cy") if live else ""
            size = 5 if name == "laser" else 3.5
            out.append(f'<circle class="{name}" r="{size}" cx="{number(there[-1])}" cy="{number(here[-1])}">{run}</circle>')
        return "".join(out)

    percent = {name: f"{100 * value:.2g} %" for name, value in misses.items()}
    says = {
        "laser": "measured by the laser",
        "bare": f"model without friction, off by {percent['bare']}",
        "law": f"with the law found, {percent['law']}",
    }
    out = [
        '<svg xmlns="http://www.w3.org/2000/svg" role="img" viewBox="0 0 760 346" width="760" height="346">'
        "<title>A carriage that sticks and slips</title>"
        "<desc>A carriage on a spring, driven by a force, above the curve of its motion, at half speed. Grey is what the laser "
        f"measured. The model without friction misses it by {percent['bare']} of its standard deviation, the model with the law "
        f"that was found by {percent['law']}. Neither was fitted to this part of the record.</desc>"
        f'<style>{STYLE}</style><rect class="paper" width="760" height="346"/>'
    ]
    at = {"laser": 20, "bare": 214, "law": 512}
    for name, x in at.items():
        out.append(f'<path class="{name}" d="M{x} 18h26"/><text x="{x + 34}" y="22.5">{says[name]}</text>')
    # The ground, the wall, the laser.
    hatch = "".join(f"M{number(WALL + 4 + 12 * k)} {number(GROUND)}l-7 8" for k in range(55))
    out.append(f'<path class="thin" d="{hatch}"/><path class="piece" d="M{number(WALL - 10)} {number(GROUND)}H{number(far)}"/>')
    out.append(f'<rect class="body" x="{number(WALL - 8)}" y="{number(top - 14)}" width="8" height="{number(TALL + 14)}" rx="2"/>')
    out.append(f'<rect class="body" x="{number(far)}" y="{number(middle - 8)}" width="26" height="16" rx="3"/>')
    out.append(f'<text class="soft end" x="{number(far + 26)}" y="{number(middle - 14)}">laser</text>')
    out.append(f'<text class="soft" x="{number(WALL + 6)}" y="{number(top - 8)}">half speed</text>')
    # The curve.
    levels = (-10, 0, 10)
    lines = "".join(f"M{number(LEFT)} {number(up(x))}H{number(RIGHT)}" for x in levels)
    out.append(f'<path class="grid" d="{lines}"/>')
    for x in levels:
        out.append(f'<text class="soft end" x="{number(LEFT - 8)}" y="{number(up(x) + 4)}">{str(x).replace("-", "−")}</text>')
    out.append(
        f'<text class="soft middle" transform="translate(20 {number((TOP + BOTTOM) / 2)}) rotate(-90)">x (mm)</text>'
    )
    last = number(RIGHT - LEFT)
    grow = animate([across(times[k]) - LEFT for k in pick], duration, "width")
    box = f'x="{number(LEFT)}" y="{number(TOP - 8)}" height="{number(BOTTOM - TOP + 16)}" width="{last}"'
    paths = ""
    for name, values in motion.items():
        points = "L".join(f"{number(across(t))} {number(up(x))}" for t, x in zip(times, values))
        paths += f'<path class="{name}" d="M{points}"/>'
    spans, start = [], None
    for k, stuck in enumerate(sticks + [0.0]):
        if stuck and start is None:
            start = k
        if not stuck and start is not None:
            a, b = across(times[start]), across(times[min(k, len(times) - 1)])
            spans.append(f'<rect class="strip" x="{number(a)}" y="{number(BOTTOM + 1)}" width="{number(b - a)}" height="6"/>')
            start = None
    out.append(f'<defs><clipPath id="grown"><rect {box}>{grow}</rect></clipPath><g id="curves">{paths}{"".join(spans)}</g></defs>')
    out.append('<g class="live" clip-path="url(#grown)"><use href="#curves"/></g><use class="still" href="#curves"/>')
    out.append(f'<path class="thin" d="M{number(LEFT)} {number(TOP - 6)}V{number(BOTTOM)}H{number(RIGHT)}"/>')
    ticks = [FROM + 0.5 * k for k in range(int((UNTIL - FROM) / 0.5) + 1)]
    marks = "".join(f"M{number(across(t))} {number(BOTTOM)}v5" for t in ticks)
    out.append(f'<path class="thin" d="{marks}"/>')
    for t in ticks:
        out.append(f'<text class="soft middle" x="{number(across(t))}" y="{number(BOTTOM + 20)}">{t:.1f}</text>')
    out.append(f'<text class="soft middle" x="{number((LEFT + RIGHT) / 2)}" y="{number(BOTTOM + 36)}">time (s)</text>')
    out.append(f'<g class="live">{scene(True)}</g><g class="still">{scene(False)}</g></svg>\n')
    return "".join(out)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    program = shutil.which(sys.argv[1])
    if not program:
        sys.exit(f"no program `{sys.argv[1]}`")
    with tempfile.TemporaryDirectory() as folder:
        svg = draw(*measure(str(pathlib.Path(program).resolve()), pathlib.Path(folder)))
    (HERE / "film.svg").write_text(svg, encoding="utf-8", newline="\n")
    print(f"film.svg: {len(svg.encode()) / 1000:.0f} kB")


if __name__ == "__main__":
    main()
