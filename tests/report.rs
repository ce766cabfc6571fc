//! `report.html` of `run` and `gap`: complete, well formed, of one piece, with the numbers of `result.json`;
//! and, where there is a browser, readable in it.

#![allow(missing_docs)]

use crate::common::{Scratch, phisindy, skipped};
use serde_json::Value;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::OnceLock;

/// A report and what else is in its folder.
struct Made {
    scratch: Scratch,
    code: i32,
    html: String,
}

impl Made {
    fn new(name: &str, arguments: &[&str]) -> Made {
        let scratch = Scratch::new(name);
        let said = phisindy(&[arguments, &["--quiet", "--out", &scratch.path("out")]].concat());
        let html = std::fs::read_to_string(scratch.path("out/report.html"));
        Made { html: html.unwrap_or_else(|e| panic!("{e}: {}", said.err)), code: said.code, scratch }
    }

    fn result(&self) -> Value {
        let text = std::fs::read_to_string(self.scratch.path("out/result.json")).expect("result.json");
        serde_json::from_str(&text).expect("JSON")
    }

    fn figures(&self) -> Vec<(String, String)> {
        // Without a figure there is no folder.
        let entries = std::fs::read_dir(self.scratch.path("out/figures")).into_iter().flatten();
        let paths = entries.map(|e| e.expect("an entry").path());
        let name = |p: &Path| p.file_stem().expect("a name").to_string_lossy().into_owned();
        paths.map(|p| (name(&p), std::fs::read_to_string(&p).expect("a figure"))).collect()
    }
}

/// Two masses, two contacts; each test looks at the same report.
fn case7() -> &'static Made {
    static MADE: OnceLock<Made> = OnceLock::new();
    MADE.get_or_init(|| Made::new("report-run", &["run", "specs/case7.ron", "--set", "data.0.duration=30.0"]))
}

/// Friction and a hardening spring that the spec does not know.
fn gap() -> &'static Made {
    static MADE: OnceLock<Made> = OnceLock::new();
    MADE.get_or_init(|| {
        let record = |x: f64, seed: u32, role: &str| {
            format!(
                "Synthetic(truth: {{ \"v\": \"-0.4*sgn(v) - 0.3*x^3\" }}, start: {{ \"x\": {x:?}, \"v\": 0.0 }}, duration: 40.0, step: 0.02, \
                 noise: Additive(0.02), seed: {seed}, role: {role})"
            )
        };
        let spec = format!(
            "(title: \"A & B <gap>\", constants: {{ \"m\": (1.0, \"kg\"), \"c\": (0.1, \"N*s/m\"), \"k\": (1.0, \"N/m\"), \"F0\": (1.0, \"N\") }},\n \
             states: {{ \"x\": \"m\", \"v\": \"m/s\" }}, known: {{ \"x\": \"v\", \"v\": \"(-c*v - k*x + F0*cos(0.7*t))/m\" }}, inertia: {{ \"v\": \"m\" }},\n \
             unknown: {{}}, data: [{}, {}])",
            record(0.0, 1, "Fit"),
            record(0.5, 2, "Validate")
        );
        let scratch = Scratch::new("report-gap-spec");
        std::fs::write(scratch.path("spec.ron"), spec).expect("the spec can be written");
        Made::new("report-gap", &["gap", &scratch.path("spec.ron")])
    })
}

const REJECTED: &[&str] = &[
    "run",
    "specs/case1a.ron",
    "--method",
    "step",
    "--set",
    "data.0.truth={ \"y\": \"2*sin(2*t)\" }",
    "--set",
    "data.0.noise=Relative(0)",
    "--set",
    "data.0.duration=20.0",
    "--set",
    "unknown.y.candidates=[\"1\",\"x\"]",
    "--set",
    "learn.optimiser=GaussNewton",
];

fn rejected() -> &'static Made {
    static MADE: OnceLock<Made> = OnceLock::new();
    MADE.get_or_init(|| Made::new("report-rejected", REJECTED))
}

/// The tags of a text with what stands between them; panics where one is not closed.
#[track_caller]
fn well_formed(text: &str) {
    let (mut open, mut rest): (Vec<&str>, &str) = (Vec::new(), text);
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        let end = rest.find('>').expect("a tag ends");
        let (tag, after) = (&rest[..end], &rest[end + 1..]);
        rest = after;
        if tag.starts_with('!') || tag.ends_with('/') {
            continue;
        }
        assert_eq!(tag.matches('"').count() % 2, 0, "quotes of <{tag}>");
        match tag.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name), "</{name}> closes something else"),
            None => open.push(tag.split_whitespace().next().expect("a name")),
        }
    }
    assert!(open.is_empty(), "not closed: {open:?}");
    let entities = ["amp;", "lt;", "gt;", "quot;", "#"];
    let loose = text.split('&').skip(1).find(|after| !entities.iter().any(|e| after.starts_with(e)));
    assert_eq!(loose, None, "a loose &");
}

/// What holds for every report.
#[track_caller]
fn sound(made: &Made) {
    let html = &made.html;
    // A script is no markup.
    let (before, rest) = html.split_once("<script>").expect("a script");
    let (_, after) = rest.split_once("</script>").expect("its end");
    well_formed(&format!("{before}{after}"));
    for outside in ["http:", "https:", "src=", "@import", "url(", "<link", "<img", "<iframe"] {
        assert!(!html.contains(outside), "{outside} leaves the page");
    }
    for inside in
        ["lang=\"en\"", "name=\"viewport\"", "prefers-color-scheme: dark", "@media print", "To repeat it"]
    {
        assert!(html.contains(inside), "{inside}");
    }
    // One script, in the page itself, at its end: without it everything is there.
    assert_eq!(html.matches("<script>").count(), 1);
    assert!(html.find("</main>") < html.find("<script>"), "the script comes last");
    assert_eq!(html.matches("<h1 ").count(), 1);
    let first = |tag: &str| html.find(tag).unwrap_or(html.len());
    assert!(first("<h1") < first("<h2") && first("<h2") < first("<h3"), "headings in order");
    let mut ids: Vec<&str> = html.split(" id=\"").skip(1).filter_map(|s| s.split('"').next()).collect();
    let all = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), all, "ids are unique");
    let figures = made.figures();
    // Each is drawn for a desk and for a phone; one of them is shown.
    let sketches = html.matches("<svg id=\"model-sketch\"").count();
    for (mark, times) in [("<figure>", 1), ("<figcaption>", 1)] {
        assert_eq!(html.matches(mark).count(), times * figures.len(), "{mark} for each file");
    }
    // But the sketch, which is moved sideways there.
    assert_eq!(html.matches(" role=\"img\"").count(), 2 * figures.len() - sketches);
    for link in html.split("href=\"").skip(1).filter_map(|s| s.split('"').next()) {
        let target = link.strip_prefix('#').unwrap_or_else(|| panic!("{link} leaves the page"));
        assert!(html.contains(&format!(" id=\"{target}\"")), "{link} leads nowhere");
    }
    for (name, svg) in figures {
        well_formed(&svg);
        assert!(html.contains(&format!("aria-labelledby=\"{name}-title {name}-desc\"")), "{name}");
        assert!(svg.contains("xmlns=") && svg.contains("<style>"), "{name} stands alone");
        let description = svg.split("<desc>").nth(1).expect("a description");
        assert!(
            description.split('<').next().is_some_and(|d| d.contains(|c: char| c.is_ascii_digit())),
            "{name} says numbers"
        );
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
    }
}

fn names(made: &Made) -> Vec<String> {
    let mut names: Vec<String> = made.figures().into_iter().map(|f| f.0).collect();
    names.sort();
    names
}

/// Every number of these is in the page in full.
#[track_caller]
fn holds(made: &Made, numbers: impl IntoIterator<Item = f64>) {
    for x in numbers {
        assert!(made.html.contains(&format!("value=\"{x:?}\"")), "{x} is missing");
    }
}

#[test]
fn a_run_is_told_in_full() {
    let (made, result) = (case7(), case7().result());
    assert_eq!(made.code, 0);
    sound(made);
    assert_eq!(
        names(made),
        [
            "correlation",
            "first",
            "friction-y1",
            "friction-y2",
            "horizon",
            "model-sketch",
            "motion-1",
            "residual-1",
            "selection"
        ]
    );
    let equations = result["equations"].as_array().expect("equations");
    assert_eq!(made.html.matches("<math").count(), equations.len());
    let terms: Vec<&Value> = equations.iter().flat_map(|e| e["terms"].as_array().expect("terms")).collect();
    assert_eq!(terms.len(), 4);
    for term in terms {
        let ci = &term["ci95"];
        holds(
            made,
            [&term["coefficient"], &term["std_error"], &ci[0], &ci[1]].map(|v| v.as_f64().expect("a number")),
        );
    }
    for record in result["records"].as_array().expect("records") {
        holds(
            made,
            record["nrmse"].as_object().expect("columns").values().map(|v| v.as_f64().expect("a number")),
        );
    }
    for words in [
        "Identified",
        "truth",
        "95 % band",
        "sticks",
        "Held constant",
        "Seed: 42",
        "phisindy run specs/case7.ron --set data.0.duration=30.0",
    ] {
        assert!(made.html.contains(words), "{words}");
    }
    assert!(made.html.len() < 600_000, "{}", made.html.len());
}

#[test]
fn a_gap_is_told_in_full() {
    let (made, result) = (gap(), gap().result());
    assert_eq!(made.code, 0, "{result}");
    sound(made);
    assert_eq!(
        names(made),
        [
            "effect-1",
            "effect-2",
            "first",
            "force",
            "gap",
            "horizon",
            "map-1",
            "map-2",
            "model-sketch",
            "motion-1",
            "motion-2",
            "residual-1",
            "residual-2"
        ]
    );
    assert!(made.html.contains(">A &amp; B &lt;gap&gt;</h1>"));
    for step in result["steps"].as_array().expect("steps") {
        assert!(made.html.contains(step["name"].as_str().expect("a name")), "{step}");
        for p in step["parameters"].as_object().expect("parameters").values() {
            holds(made, [&p["value"], &p["ci95"][0], &p["ci95"][1]].map(|v| v.as_f64().expect("a number")));
        }
    }
    for record in result["records"].as_array().expect("records") {
        let nrmse = &record["nrmse"];
        holds(made, [&nrmse["before"], &nrmse["after"]].map(|v| v.as_f64().expect("a number")));
    }
    for words in ["Explained", "model as it was", "completed model", "validate: not fitted", "<math"] {
        assert!(made.html.contains(words), "{words}");
    }
}

/// The first sentence has a name, and so has the sketch, in which what was found is lit with its number beside.
#[test]
fn the_answer_and_the_sketch_of_the_model_have_names() {
    for (made, number) in [(case7(), "terms"), (gap(), "Fc = ")] {
        let finding = made.html.split("<p id=\"finding\"").nth(1).expect("the first sentence");
        let sentence = finding.split('>').nth(1).and_then(|s| s.split('<').next()).expect("its words");
        assert!(sentence.len() > 30 && sentence.trim_end().ends_with('.'), "{sentence}");
        let sketch = made.html.split("<svg id=\"model-sketch\"").nth(1).expect("a sketch");
        let sketch = sketch.split("</svg>").next().expect("its end");
        let lit = sketch.split("<text class=\"label middle found\"").skip(1);
        let lit: Vec<&str> = lit.filter_map(|s| s.split('>').nth(1)?.split('<').next()).collect();
        assert!(lit.iter().any(|words| words.contains(number)), "{lit:?}");
        assert!(sketch.contains("found friction") || sketch.contains("found ground"), "{sketch}");
    }
    // What could not be fitted has a sentence too.
    assert!(rejected().html.contains("<p id=\"finding\""));
}

/// The largest force that a picture of the gap's effects tells of, and against what it is drawn.
fn force_told(svg: &str) -> (f64, &str) {
    let said = svg.split("<desc>").nth(1).and_then(|s| s.split("</desc>").next()).expect("a description");
    let (force, rest) = said.split_once(" while ").expect("what it is drawn against");
    let largest = force.split(" to ").nth(1).and_then(|s| s.split(' ').next()).expect("a number");
    (largest.parse().expect("a number"), rest.split(' ').next().expect("a name"))
}

/// The truth is 0.4 N of friction and 0.3 N/m^3 x^3.
#[test]
fn the_forces_of_what_was_missing_are_drawn() {
    let (made, figures) = (gap(), gap().figures());
    let (mut friction, mut spring) = (0, 0);
    for (name, svg) in figures.iter().filter(|(name, _)| name.starts_with("effect")) {
        let (largest, over) = force_told(svg);
        if svg.contains("Coulomb friction") {
            friction += 1;
            assert!(over == "v" && (largest - 0.4).abs() < 0.005, "{name}: {largest} over {over}");
        } else {
            spring += 1;
            let x = svg.split("goes from ").nth(1).and_then(|s| s.split(" to ").nth(1)).expect("a range");
            let x: f64 = x.split(' ').next().and_then(|x| x.parse().ok()).expect("a number");
            assert!(over == "x" && (largest - 0.3 * x.powi(3)).abs() < 0.02, "{name}: {largest} at {x}");
        }
        assert!(svg.contains("resisting force (N)"), "{name}");
    }
    assert_eq!((friction, spring), (1, 1));
    // What was ruled out, or is not excluded, in both rounds stands in the page once.
    let mut lines: Vec<&str> = made.html.split("<li>").skip(1).collect();
    let all = lines.len();
    lines.sort_unstable();
    lines.dedup();
    assert_eq!(lines.len(), all);
}

/// What is drawn high on a page is drawn in pieces on paper, which show the whole between them.
#[test]
fn a_high_figure_may_be_cut_between_its_panels() {
    let html = &case7().html;
    let figure = html.split("<figure>").find(|f| f.contains("id=\"motion-1-all\"")).expect("the motion");
    let pieces: Vec<&str> = figure.split("<svg class=\"chart\" viewBox=\"").skip(1).collect();
    // Left, top, width and height: the attribute with which a piece of the page begins.
    let rectangle = |piece: &str| -> Vec<f64> {
        let attribute = piece.split('"').next().unwrap_or_default();
        attribute.split(' ').map(|x| x.parse().expect("a number")).collect()
    };
    let ends = |piece: &str| -> (f64, f64) {
        let view = rectangle(piece);
        (view[1], view[1] + view[3])
    };
    // Four columns, one to a piece.
    assert_eq!(pieces.len(), 4, "{figure}");
    assert!(pieces.iter().all(|p| p.contains("<use href=\"#motion-1-all\">")), "each shows the same drawing");
    assert!(ends(pieces[0]).0 == 0.0 && pieces.windows(2).all(|p| ends(p[0]).1 == ends(p[1]).0));
    let panels = figure.split("data-place=\"").skip(1).take(4);
    for (panel, piece) in panels.zip(&pieces) {
        let place = rectangle(panel);
        assert!(ends(piece).0 < place[1] && place[1] + place[3] < ends(piece).1, "{place:?}");
    }
}

#[test]
fn method_step_has_a_band_and_correlations_too() {
    let sets = ["--set", "unknown.y.candidates=[\"1\",\"y^2\"]", "--set", "learn.cutoff=0.0"];
    let step = ["run", "specs/case1a.ron", "--method", "step", "--set", "learn.optimiser=GaussNewton"];
    let made = Made::new("report-step", &[&step[..], &sets].concat());
    sound(&made);
    let names = names(&made);
    assert!(["correlation", "friction-y"].iter().all(|n| names.iter().any(|m| m == n)), "{names:?}");
    assert!(made.html.contains("95 % band") && made.html.contains("Correlations of the estimates"));
}

/// A mistake in the spec, a file that is not there, a spec that is none: all have a report with what was said
/// of them.
#[test]
fn the_policy_lets_only_the_script_of_the_report_run() {
    let made = case7();
    let script =
        made.html.split("<script>").nth(1).and_then(|s| s.split("</script>").next()).expect("a script");
    let hash = "import base64, hashlib, sys; print(base64.b64encode(hashlib.sha256(sys.stdin.buffer.read()).digest()).decode())";
    let mut python = Command::new("python3")
        .args(["-c", hash])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("python3 starts");
    python.stdin.take().expect("its input").write_all(script.as_bytes()).expect("written");
    let out = python.wait_with_output().expect("it ends");
    let own = format!("script-src 'sha256-{}'", String::from_utf8_lossy(&out.stdout).trim());
    let (before, _) = made.html.split_once("<style>").expect("a style");
    assert!(before.contains("default-src 'none'") && before.contains(&own), "the policy wants {own}");
}

#[test]
fn what_cannot_be_run_has_a_report_too() {
    let missing = ["run", "specs/frame_250g.ron", "--data", "specs"];
    for (arguments, said, shown) in [
        (&["run", "specs/wrong/unknown_name.ron"][..], "unknown name", "known: {"),
        (&["gap", "specs/wrong/unknown_name.ron"], "unknown name", "known: {"),
        (&missing, "there is no data file `frame_stickslip_250g.csv`", "F/m = 0.215"),
        (&["run", "specs/nowhere.ron"], "cannot read the spec", "phisindy run specs/nowhere.ron"),
    ] {
        let made = Made::new(&format!("report-refused-{}", said.len() + arguments[0].len()), arguments);
        assert_eq!(made.code, 2, "{arguments:?}");
        sound(&made);
        for words in ["class=\"banner bad\"", "Not run", "What to do next", said, shown, "help: "] {
            assert!(made.html.contains(words), "{arguments:?}: {words}");
        }
        assert!(!made.html.contains('\u{1b}'), "no colours of a terminal");
    }
}

#[test]
fn a_rejected_model_says_why() {
    let made = rejected();
    assert_eq!(made.code, 1);
    sound(made);
    let reason = made.result()["reason"].as_str().expect("a reason").to_owned();
    // Its first letter is large there.
    assert!(
        made.html.contains("class=\"banner bad\"") && made.html.replace('\u{a0}', " ").contains(&reason[1..]),
        "{reason}"
    );
}

#[test]
fn a_failed_run_shows_what_was_measured_and_a_long_record_is_drawn_short() {
    let scratch = Scratch::new("report-long");
    let rows: String = (0..150_000)
        .map(|k| format!("{},{},0\n", f64::from(k) * 1e-3, (f64::from(k) * 0.013).sin()))
        .collect();
    std::fs::write(scratch.path("long.csv"), format!("t,x,v\n{rows}")).expect("the data can be written");
    let spec = "(title: \"long\", states: { \"x\": \"m\", \"v\": \"m/s\" }, known: { \"x\": \"v\", \"v\": \"-x\" }, unknown: { \"v\": (candidates: [\"sgn(v)\"]) },\n \
                data: [Csv(path: \"long.csv\", time: \"t\", columns: { \"x\": (\"x\", \"m\"), \"v\": (\"v\", \"m/s\") })])";
    std::fs::write(scratch.path("spec.ron"), spec).expect("the spec can be written");
    let made = Made::new("report-failed", &["run", &scratch.path("spec.ron")]);
    assert_eq!(made.code, 2);
    sound(&made);
    assert!(made.html.contains("the column of v is constant"));
    assert_eq!(names(&made), ["motion-1"]);
    assert!(made.html.len() < 200_000, "{}", made.html.len());
}

/// A browser, if this machine has one.
fn browser() -> Option<&'static str> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    names
        .into_iter()
        .find(|name| Command::new(name).arg("--version").output().is_ok_and(|o| o.status.success()))
}

/// Looks at a page of the folder with the browser; what it printed and what it complained of.
fn look(browser: &str, made: &Made, page: &str, options: &[&str]) -> (String, String) {
    let out = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-dev-shm-usage",
            "--no-first-run",
            "--disable-background-networking",
        ])
        .args(["--allow-file-access-from-files", "--virtual-time-budget=10000", "--enable-logging=stderr"])
        .arg(format!("--user-data-dir={}", made.scratch.path("profile")))
        .args(options)
        .arg(format!("file://{}", made.scratch.path(&format!("out/{page}"))))
        .output()
        .expect("the browser starts");
    (String::from_utf8_lossy(&out.stdout).into_owned(), String::from_utf8_lossy(&out.stderr).into_owned())
}

/// Shows the report in frames as wide as a phone and a desk, and says what it measures there.
const PROBE: &str = r#"<!DOCTYPE html><html><body><script>
const said = [];
const measured = (frame) => {
  const page = frame.contentDocument, view = frame.contentWindow;
  const flat = (e) => { const box = e.getBoundingClientRect(); return box.width < 8 || box.height < 8; };
  // Of the drawings for a desk and for a phone one is shown.
  const all = (names) => [...page.querySelectorAll(names)].filter((e) => e.checkVisibility());
  // Words that leave their drawing are cut off at its edge.
  const leaves = (text) => {
    const own = text.getBoundingClientRect(), box = text.closest('svg[role=img]').getBoundingClientRect();
    return own.left < box.left - 0.1 || own.right > box.right + 0.1 || own.top < box.top - 0.1 || own.bottom > box.bottom + 0.1;
  };
  return {
    width: frame.clientWidth, needs: page.documentElement.scrollWidth,
    pictures: all('svg[role=img]').length, formulas: all('math').length,
    cut: all('svg[role=img] text').filter(leaves).map((e) => e.textContent),
    flat: all('svg[role=img], math, table, figcaption').filter(flat).length,
    // The bodies of the sketch keep their height beside the style sheet of the page.
    low: all('#model-sketch .moving .body').filter((e) => e.getBoundingClientRect().height < 30).length,
    requests: view.performance.getEntriesByType('resource').length,
    paper: view.getComputedStyle(page.documentElement).backgroundColor, ink: view.getComputedStyle(page.body).color,
    sizes: all('.chart .label').length ? parseFloat(view.getComputedStyle(all('.chart .label')[0]).fontSize) * all('svg[role=img]')[0].getBoundingClientRect().width / all('svg[role=img]')[0].viewBox.baseVal.width : 0,
  };
};
for (const width of [380, 1200]) {
  const frame = document.createElement('iframe');
  frame.style = `width:${width}px;height:900px;border:0`;
  frame.onload = () => { said.push(measured(frame)); if (said.length == 2) document.body.innerHTML = '<pre>' + JSON.stringify(said) + '</pre>'; };
  frame.src = 'report.html';
  document.body.append(frame);
}
</script></body></html>"#;

#[test]
fn a_browser_shows_it_on_phone_and_desk_in_light_and_dark_and_on_paper() {
    let Some(browser) = browser() else {
        return skipped("there is no chromium here");
    };
    for made in [case7(), gap(), rejected()] {
        std::fs::write(made.scratch.path("out/probe.html"), PROBE).expect("the probe can be written");
        let mut papers = Vec::new();
        for scheme in ["0", "1"] {
            let setting = format!("--blink-settings=preferredColorScheme={scheme}");
            let (dom, complaints) =
                look(browser, made, "probe.html", &["--dump-dom", "--window-size=1300,1000", &setting]);
            assert!(!complaints.contains("CONSOLE"), "{complaints}");
            let json = dom
                .split("<pre>")
                .nth(1)
                .and_then(|s| s.split("</pre>").next())
                .unwrap_or_else(|| panic!("{dom}{complaints}"));
            let said: Vec<Value> = serde_json::from_str(json).expect("JSON");
            assert_eq!(said.len(), 2);
            for page in &said {
                assert!(page["needs"].as_f64() <= page["width"].as_f64(), "scrolls sideways: {page}");
                assert_eq!((&page["flat"], &page["requests"]), (&0.into(), &0.into()), "{page}");
                assert_eq!(page["low"], 0, "{page}");
                assert_eq!(page["pictures"].as_u64(), Some(made.figures().len() as u64), "{page}");
                assert_eq!(
                    page["formulas"].as_u64(),
                    Some(made.html.matches("<math").count() as u64),
                    "{page}"
                );
                assert!(
                    page["sizes"].as_f64().is_some_and(|size| size >= 9.0),
                    "words too small to read: {page}"
                );
                assert_ne!(page["paper"], page["ink"]);
                assert!(page["cut"].as_array().is_some_and(Vec::is_empty), "words are cut off: {page}");
            }
            papers.push(said[0]["paper"].clone());
        }
        assert_ne!(papers[0], papers[1], "dark is not light");
        let pdf = made.scratch.path("report.pdf");
        look(browser, made, "report.html", &[&format!("--print-to-pdf={pdf}")]);
        let printed = std::fs::read(&pdf).expect("a PDF");
        assert!(printed.starts_with(b"%PDF") && printed.len() > 20_000, "{}", printed.len());
    }
}
