//! The page of `phisindy open`: who may ask, what it keeps, and, where there is a browser, the way from
//! dropping a file to the report.
#![allow(missing_docs)]

use phisindy::files::Request;
use phisindy_page::Page;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Longest time that anything here takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A page that is served until the end of the test.
struct Served {
    folder: TempDir,
    url: String,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Served {
    fn new(first: Option<&str>) -> Served {
        Served::of(tempfile::tempdir().expect("a folder"), first)
    }

    fn of(folder: TempDir, first: Option<&str>) -> Served {
        let page = Page::open(folder.path(), first, 0, Request::default()).expect("a page");
        let (url, stop) = (page.url(), Arc::new(AtomicBool::new(false)));
        let asked = Arc::clone(&stop);
        let serve = move || page.serve(&|| asked.load(Ordering::SeqCst)).expect("served to the end");
        Served { folder, url, stop, thread: Some(std::thread::spawn(serve)) }
    }

    /// `127.0.0.1:PORT`, and `/TOKEN/`.
    fn parts(&self) -> (&str, &str) {
        let rest = self.url.strip_prefix("http://").expect("an address");
        rest.split_at(rest.find('/').expect("a path"))
    }

    /// Status, headers and body of an answer.
    fn asked(&self, method: &str, path: &str, headers: &str, body: &str) -> (u16, String, String) {
        let mut stream = TcpStream::connect(self.parts().0).expect("it listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a time");
        let length = body.len();
        let head = format!(
            "{method} {path} HTTP/1.1\r\n{headers}Content-Length: {length}\r\nConnection: close\r\n\r\n"
        );
        stream.write_all((head + body).as_bytes()).expect("sent");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("an answer");
        let answer = String::from_utf8_lossy(&answer).into_owned();
        let (head, body) = answer.split_once("\r\n\r\n").expect("a head");
        let status = head.split(' ').nth(1).and_then(|s| s.parse().ok()).expect("a status");
        (status, head.to_owned(), body.to_owned())
    }

    /// The answer to the page itself.
    fn own(&self, method: &str, path: &str, body: &str) -> (u16, String) {
        let (host, token) = self.parts();
        let (status, _, body) =
            self.asked(method, &format!("{token}{path}"), &format!("Host: {host}\r\n"), body);
        (status, body)
    }

    fn json(&self, method: &str, path: &str, body: &str) -> Value {
        let (status, body) = self.own(method, path, body);
        assert_eq!(status, 200, "{path}: {body}");
        serde_json::from_str(&body).expect("JSON")
    }

    fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.folder.path().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    fn end(&mut self) {
        self.stop.store(true, Ordering::SeqCst);
        self.thread.take().into_iter().for_each(|t| t.join().expect("no panic"));
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::SeqCst);
    }
}

/// A released mass with friction, quick to identify.
const SPEC: &str = r#"(constants: { "k": (1.0, "1/s^2") }, states: { "x": "m", "v": "m/s" }, known: { "x": "v", "v": "-k*x" },
    unknown: { "v": (factor: "-sgn(v)", candidates: ["1"]) }, contacts: ["v"],
    data: [Synthetic(truth: { "v": "-0.3*sgn(v)" }, start: { "x": 2.0, "v": 0.0 }, duration: 10.0, step: 0.02, noise: Additive(0.01), seed: 1)])"#;

#[test]
fn who_does_not_know_the_token_is_refused() {
    let page = Served::new(None);
    let (host, token) = page.parts();
    let own = format!("Host: {host}\r\n");
    let status = |path: &str, headers: &str| page.asked("GET", path, headers, "").0;
    assert_eq!(status(token, &own), 200);
    assert_eq!(status(&format!("{token}api/state"), &own), 200);
    for path in ["/", "/api/state", "/0123456789abcdef0123456789abcdef/api/state", &token[..20]] {
        assert_eq!(status(path, &own), 403, "{path}");
    }
    let port = host.split(':').nth(1).expect("a port");
    assert_eq!(status(token, &format!("Host: localhost:{port}\r\n")), 200);
    for other in ["evil.example", "127.0.0.1", &format!("evil.example:{port}"), "127.0.0.1:1"] {
        assert_eq!(status(token, &format!("Host: {other}\r\n")), 403, "{other}");
    }
    for origin in ["Origin: http://evil.example\r\n", "Origin: null\r\n", "Sec-Fetch-Site: cross-site\r\n"] {
        let path = format!("{token}api/stop");
        assert_eq!(page.asked("POST", &path, &format!("{own}{origin}"), "").0, 403, "{origin}");
    }
    assert_eq!(page.own("GET", "api/nothing", "").0, 404);
    assert_eq!(page.own("DELETE", "api/state", "").0, 404);
}

#[test]
fn the_page_asks_for_nothing_from_elsewhere() {
    let page = Served::new(None);
    let (host, token) = page.parts();
    let (_, head, body) = page.asked("GET", token, &format!("Host: {host}\r\n"), "");
    for header in [
        "Content-Security-Policy: default-src 'none'",
        "Referrer-Policy: no-referrer",
        "Cache-Control: no-store",
    ] {
        assert!(head.contains(header), "{head}");
    }
    let addresses = body.matches("http").count() - body.matches("http://www.w3.org/2000/svg").count();
    assert_eq!(addresses, 0, "an address in the page");
}

#[test]
fn nothing_outside_of_the_folder_is_read_or_written() {
    let page = Served::new(None);
    for name in ["..%2Fa.ron", "%2Fetc%2Fpasswd", "a%2Fb.ron", ".a.ron", "a.ron%00", "..", ""] {
        for (method, path) in [
            ("GET", "api/spec"),
            ("POST", "api/spec"),
            ("POST", "api/data"),
            ("POST", "api/look"),
            ("POST", "api/check"),
        ] {
            let (status, body) = page.own(method, &format!("{path}?name={name}"), "null");
            assert_eq!(status, 400, "{method} {path} {name}: {body}");
        }
    }
    for path in [
        "results/../a.ron",
        "results/a/../../b.json",
        "results/%2e%2e/a.json",
        "results/a",
        "results/a/b/c.json",
    ] {
        assert_eq!(page.own("GET", path, "").0, 404, "{path}");
    }
    assert_eq!(std::fs::read_dir(page.folder.path()).expect("the folder").count(), 0);
    assert_eq!(page.own("POST", "api/spec?name=a.csv", "x").0, 400, "only a spec is replaced");
}

#[test]
fn a_file_becomes_a_spec_and_the_spec_a_result() {
    let mut page = Served::new(None);
    let rig = std::fs::read_to_string(top().join("docs/tutorial/rig.csv")).expect("the file of the tutorial");
    assert_eq!(page.json("POST", "api/data?name=rig.csv", &rig)["name"], "rig.csv");
    let look = page.json("POST", "api/look?name=rig.csv", "null");
    let spec = look["spec"].as_str().expect("a spec");
    assert_eq!(
        (&look["columns"][1]["role"], &look["columns"][2]["role"]),
        (&json!("displacement"), &json!("force"))
    );
    assert_eq!(page.json("POST", "api/new-spec?name=rig.ron", spec)["name"], "rig.ron");
    assert_eq!(page.text("rig.ron"), spec);
    let told = page.json("POST", "api/check?name=rig.ron", &spec.replace("-sgn(v)/m", "-sgn(vv)/m"));
    assert!(told["diagnostics"][0]["message"].as_str().expect("words").contains("vv"), "{told}");
    assert_eq!(page.text("rig.ron"), spec, "a check writes nothing");
    page.json("POST", "api/spec?name=quick.ron", SPEC);
    page.json("POST", "api/start?name=quick.ron&what=run", "");
    let result = worked(&page);
    assert_eq!(result["ended"]["result"], "quick-run-1", "{result}");
    let state = page.json("GET", "api/state", "");
    assert_eq!(
        (&state["results"][0]["ended"], &state["specs"]),
        (&json!("identified"), &json!(["quick.ron", "rig.ron"]))
    );
    let (status, report) = page.own("GET", "results/quick-run-1/report.html", "");
    assert!(
        status == 200 && report.contains("<math") && report.contains("phisindy run quick.ron"),
        "{status}"
    );
    let (status, model) = page.own("GET", "api/export?result=quick-run-1&to=python", "");
    assert!(status == 200 && model.contains("def rates"), "{model}");
    page.end();
    assert!(
        page.text("results/quick-run-1/identified.ron").contains("sgn(v)"),
        "the end of the page loses nothing"
    );
}

/// The state of the work once it has ended, from the events.
fn worked(page: &Served) -> Value {
    let (host, token) = page.parts();
    let mut stream = TcpStream::connect(host).expect("it listens");
    stream.set_read_timeout(Some(PATIENCE)).expect("a time");
    write!(stream, "GET {token}api/events HTTP/1.1\r\nHost: {host}\r\n\r\n").expect("sent");
    for line in BufReader::new(stream).lines() {
        let line = line.expect("an event in time");
        if let Some(data) = line.strip_prefix("data: ") {
            let state: Value = serde_json::from_str(data).expect("JSON");
            if !state["ended"].is_null() {
                return state;
            }
        }
    }
    panic!("the events ended before the work")
}

#[test]
fn one_thing_is_done_at_a_time_and_can_be_stopped() {
    let page = Served::new(None);
    page.json(
        "POST",
        "api/spec?name=long.ron",
        &SPEC.replace("duration: 10.0, step: 0.02", "duration: 400.0, step: 0.01"),
    );
    page.json("POST", "api/start?name=long.ron&what=gap", "");
    let (status, body) = page.own("POST", "api/start?name=long.ron&what=run", "");
    assert!(status == 400 && body.contains("something is running"), "{status} {body}");
    page.json("POST", "api/stop", "");
    let ended = worked(&page)["ended"].clone();
    assert!(ended["stopped"] == true || ended["error"].is_string(), "{ended}");
    let (status, body) = page.own("POST", "api/start?name=missing.ron&what=run", "");
    assert!(status == 400 && body.contains("missing.ron"), "{body}");
}

/// A browser that is told what to do through a pipe (<https://chromedevtools.github.io/devtools-protocol/>).
struct Browser {
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    session: Option<String>,
    next: u64,
    _profile: TempDir,
}

impl Browser {
    /// None if this machine has no browser.
    fn start() -> Option<Browser> {
        let names = ["chromium", "chromium-browser", "google-chrome"];
        let there =
            |name: &&str| Command::new(name).arg("--version").output().is_ok_and(|o| o.status.success());
        let name = names.into_iter().find(there)?;
        let profile = tempfile::tempdir().expect("a folder");
        let shell = format!(
            "exec {name} --headless --no-sandbox --disable-gpu --disable-dev-shm-usage --no-first-run --disable-background-networking \
             --remote-debugging-pipe --window-size=1300,1000 --user-data-dir='{}' about:blank 3<&0 4>&1 </dev/null >/dev/null 2>&1",
            profile.path().display()
        );
        let mut child = Command::new("sh")
            .args(["-c", &shell])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .ok()?;
        let (to, from) = (child.stdin.take()?, BufReader::new(child.stdout.take()?));
        Some(Browser { child, to, from, session: None, next: 0, _profile: profile })
    }

    fn call(&mut self, method: &str, parameters: Value) -> Value {
        let answer = self.answer(method, parameters);
        assert!(answer["error"].is_null(), "{method}: {answer}");
        answer["result"].clone()
    }

    fn answer(&mut self, method: &str, parameters: Value) -> Value {
        self.next += 1;
        let mut message = json!({ "id": self.next, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        self.to.write_all(format!("{message}\0").as_bytes()).expect("the browser listens");
        loop {
            let mut bytes = Vec::new();
            self.from.read_until(0, &mut bytes).expect("the browser answers");
            assert!(!bytes.is_empty(), "the browser has ended");
            let answer: Value = serde_json::from_slice(&bytes[..bytes.len() - 1]).expect("JSON");
            if answer["id"] == self.next {
                return answer;
            }
        }
    }

    fn visit(&mut self, url: &str) {
        self.session = None;
        let target = self.call("Target.createTarget", json!({ "url": url }))["targetId"].clone();
        let session = self.call("Target.attachToTarget", json!({ "targetId": target, "flatten": true }));
        self.session = session["sessionId"].as_str().map(str::to_owned);
    }

    /// Between two pages there is nothing that could evaluate a script.
    fn evaluated(&mut self, script: &str) -> Value {
        let since = Instant::now();
        let parameters = json!({ "expression": script, "returnByValue": true, "awaitPromise": true });
        loop {
            let answer = self.answer("Runtime.evaluate", parameters.clone());
            let between = answer["error"]["message"].as_str().is_some_and(|m| m.contains("context"));
            if !between {
                assert!(answer["error"].is_null(), "{script}: {answer}");
                return answer["result"].clone();
            }
            assert!(since.elapsed() < PATIENCE, "{script}: {answer}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    fn value(&mut self, script: &str) -> Value {
        let said = self.evaluated(script);
        assert!(said["exceptionDetails"].is_null(), "{script}: {said}");
        said["result"]["value"].clone()
    }

    /// Waits until an expression is true.
    fn until(&mut self, script: &str) {
        let since = Instant::now();
        // Before the page is there its names are unknown.
        while self.evaluated(script)["result"]["value"] != true {
            let seen = "document.body && document.body.innerText.slice(0, 3000)";
            assert!(since.elapsed() < PATIENCE, "never: {script}\n{}", self.value(seen));
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// A picture, where `PHISINDY_PICTURES` names a folder for it.
    fn picture(&mut self, name: &str) {
        let Some(folder) = std::env::var_os("PHISINDY_PICTURES") else { return };
        let shot =
            self.call("Page.captureScreenshot", json!({ "captureBeyondViewport": true, "format": "png" }));
        let text = shot["data"].as_str().expect("a picture");
        std::fs::write(Path::new(&folder).join(format!("{name}.base64")), text).expect("written");
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn a_browser_goes_from_a_dropped_file_to_the_report() {
    let Some(mut browser) = Browser::start() else {
        // Past the capture of output: `.ci/run` counts such lines.
        let _ = writeln!(std::io::stderr(), "skipped: a_browser_goes: there is no chromium here");
        return;
    };
    let page = Served::new(None);
    browser.visit(&page.url);
    browser.until("document.readyState === 'complete' && $('where').textContent !== ''");
    browser.picture("1-empty");

    let rig = std::fs::read_to_string(top().join("docs/tutorial/rig.csv")).expect("the file of the tutorial");
    browser.value(&format!(
        "{{ const all = new DataTransfer(); all.items.add(new File([{}], 'rig.csv'));
            dispatchEvent(new DragEvent('drop', {{ dataTransfer: all, cancelable: true }})); 0 }}",
        json!(rig)
    ));
    browser.until("$('columns').rows.length === 3");
    assert_eq!(
        browser.value("[...document.querySelectorAll('#columns select')].map(s => s.value).join()"),
        "time,displacement,force"
    );
    assert_eq!(browser.value("document.querySelectorAll('#curves polyline').length"), 2);
    // The force is left out, then taken again.
    let choose = |role: &str| {
        format!(
            "{{ const s = document.querySelectorAll('#columns select')[2]; s.value = '{role}'; s.dispatchEvent(new Event('change')); 0 }}"
        )
    };
    browser.value(&choose("none"));
    browser.until(
        "document.querySelectorAll('#curves polyline').length === 1 && !page.look.spec.includes('F_N')",
    );
    browser.value(&choose("force"));
    browser.until(
        "document.querySelectorAll('#curves polyline').length === 2 && page.look.spec.includes('F_N')",
    );
    browser.picture("2-columns");

    browser.value("$('write').click()");
    browser.until("!$('gap').disabled");
    assert!(page.text("rig.ron").contains("Csv(path: \"rig.csv\""));
    // A mistake is told below its line; what was typed is in the file.
    browser.value(
        "{ const line = [...code.children].find(d => d.textContent.includes('\"v\": \"(F'));
           const at = line.firstChild.data.indexOf('k*x'), r = document.createRange();
           r.setStart(line.firstChild, at); r.setEnd(line.firstChild, at + 1);
           code.focus(); getSelection().removeAllRanges(); getSelection().addRange(r);
           document.execCommand('insertText', false, 'kk'); 0 }",
    );
    browser.until("$('told').textContent === '1 mistake'");
    assert_eq!(browser.value("document.querySelectorAll('#code [data-told]').length"), 1);
    assert!(
        browser
            .value("document.querySelector('#code [data-told]').dataset.told")
            .as_str()
            .expect("words")
            .contains("`kk`")
    );
    assert_eq!(browser.value("$('gap').disabled"), true);
    assert!(page.text("rig.ron").contains("kk*x"));
    browser.picture("3-mistake");
    browser.value("document.execCommand('undo')");
    browser.until("!$('gap').disabled");
    assert!(!page.text("rig.ron").contains("kk*x"));

    browser.value("$('gap').click()");
    browser.until("$('log').children.length > 1");
    browser.picture("4-progress");
    browser.until("!$('answer').hidden");
    assert_eq!(browser.value("$('finding').textContent"), "Explained: Stribeck friction at v");
    assert_eq!(browser.value("document.querySelectorAll('#gaps i').length"), 2);
    browser.until("$('report').src.includes('rig-gap-1/report.html')");
    browser.picture("5-answer");
    let links =
        browser.value("[...document.querySelectorAll('#downloads a')].map(a => a.textContent).join()");
    assert!(
        links.as_str().expect("words").starts_with("report,completed.ron,numbers,model: python"),
        "{links}"
    );
    let kept = browser.value(
        "fetch(document.querySelector('#downloads a').href).then(r => r.headers.get('Content-Disposition'))",
    );
    assert!(kept.as_str().expect("a name").contains("rig-gap-1-report.html"), "{kept}");
    assert!(page.text("results/rig-gap-1/completed.ron").contains("Fs"));
    // A report has a script of its own, which reaches nothing of the page.
    let report = browser.value("$('report').src");
    browser.visit(report.as_str().expect("an address"));
    browser.until("document.readyState === 'complete' && document.querySelectorAll('math').length > 0");
    browser.picture("6-report");
    assert_eq!(browser.value("fetch('../../api/state').then(() => 'read', () => 'refused')"), "refused");
    // A page that is opened again finds everything.
    browser.visit(&page.url);
    browser
        .until("document.readyState === 'complete' && $('results').querySelectorAll('button').length === 1");
    browser.value("$('results').querySelector('button').click()");
    browser.until("!$('answer').hidden && $('finding').textContent.includes('Stribeck')");
    std::thread::sleep(Duration::from_millis(300)); // the report is drawn in its frame
    browser.picture("7-again");
    let phone = json!({ "width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": false });
    for (device, name) in [
        (json!({ "width": 1300, "height": 1000, "deviceScaleFactor": 1, "mobile": false }), "8-desk"),
        (phone, "9-phone"),
    ] {
        browser.call("Emulation.setDeviceMetricsOverride", device);
        browser.call(
            "Emulation.setEmulatedMedia",
            json!({ "features": [{ "name": "prefers-color-scheme", "value": "dark" }] }),
        );
        browser.picture(name);
        let sideways = "document.documentElement.scrollWidth <= innerWidth";
        assert_eq!(browser.value(sideways), true, "{name} scrolls sideways");
    }
    let foreign = "performance.getEntriesByType('resource').filter(e => !e.name.startsWith(location.origin) && !e.name.startsWith('data:')).length";
    assert_eq!(browser.value(foreign), 0);
}
