//! The page of `phisindy open`: who may ask, what it keeps, and, where there is a browser, the way from
//! dropping a file to the report.
#![allow(missing_docs)]

use phisindy::files::Request;
use phisindy_page::{Page, Source};
use phisindy_report::StopReason;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
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
    thread: Option<JoinHandle<Option<String>>>,
}

impl Served {
    fn new(first: Option<&str>) -> Served {
        Served::of(tempfile::tempdir().expect("a folder"), first)
    }

    fn of(folder: TempDir, first: Option<&str>) -> Served {
        let page = Page::open(folder.path(), first, 0, Request::default()).expect("a page");
        Served::by(folder, page)
    }

    fn by(folder: TempDir, page: Page) -> Served {
        let (url, stop) = (page.url(), Arc::new(AtomicBool::new(false)));
        let asked = Arc::clone(&stop);
        let serve =
            move || page.serve(&|| asked.load(Ordering::SeqCst).then_some(StopReason::Signal("SIGTERM")));
        Served { folder, url, stop, thread: Some(std::thread::spawn(serve)) }
    }

    /// `127.0.0.1:PORT`, and `/TOKEN/`.
    fn parts(&self) -> (&str, &str) {
        let rest = self.url.strip_prefix("http://").expect("an address");
        rest.split_at(rest.find('/').expect("a path"))
    }

    fn connected(&self) -> TcpStream {
        let stream = TcpStream::connect(self.parts().0).expect("it listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a time");
        stream
    }

    /// What comes for these bytes, until the connection ends; nothing more is sent.
    fn raw(&self, bytes: &str) -> String {
        let (mut stream, mut answer) = (self.connected(), Vec::new());
        // The server may end the connection before everything is sent.
        let _ = stream.write_all(bytes.as_bytes()).and_then(|()| stream.shutdown(Shutdown::Write));
        let _ = stream.read_to_end(&mut answer);
        String::from_utf8_lossy(&answer).into_owned()
    }

    /// The head of a request with the token.
    fn head(&self, method: &str, path: &str, headers: &str) -> String {
        let (host, token) = self.parts();
        format!("{method} {token}{path} HTTP/1.1\r\nHost: {host}\r\n{headers}\r\n")
    }

    /// Status, headers and body of an answer.
    fn asked(&self, method: &str, path: &str, headers: &str, body: &str) -> (u16, String, String) {
        let length = body.len();
        let answer =
            self.raw(&format!("{method} {path} HTTP/1.1\r\n{headers}Content-Length: {length}\r\n\r\n{body}"));
        let (head, body) = answer.split_once("\r\n\r\n").expect("a head");
        (status(head), head.to_owned(), body.to_owned())
    }

    /// The answer to the page itself.
    fn own(&self, method: &str, path: &str, body: &str) -> (u16, String) {
        let (host, token) = self.parts();
        let (status, _, body) =
            self.asked(method, &format!("{token}{path}"), &format!("Host: {host}\r\n"), body);
        (status, body)
    }

    /// The answer to a spec that is saved over a version, and its status.
    fn saved(&self, name: &str, version: &Value, more: &str, body: &str) -> (u16, Value) {
        let version = version.as_str().expect("a version");
        let headers = format!("If-Match: {version}\r\nContent-Length: {}\r\n", body.len());
        let answer = self.raw(&(self.head("POST", &format!("api/spec?name={name}{more}"), &headers) + body));
        let body = answer.split_once("\r\n\r\n").expect("a body").1;
        (status(&answer), serde_json::from_str(body).expect("JSON"))
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
        self.thread.take().into_iter().for_each(|t| drop(t.join().expect("no panic")));
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::SeqCst);
    }
}

fn status(answer: &str) -> u16 {
    answer.split(' ').nth(1).and_then(|s| s.parse().ok()).unwrap_or_else(|| panic!("no status: {answer:?}"))
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
    let body = body + &page.own("GET", "page.js", "").1 + &page.own("GET", "page.css", "").1;
    assert!(!head.contains("unsafe-inline") && !body.contains(" style=") && !body.contains(" onclick="));
    for header in [
        "Content-Security-Policy: default-src 'none'; script-src 'self'",
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
    let long = format!("{}.ron", "x".repeat(300));
    for name in [
        "..%2Fa.ron",
        "%2Fetc%2Fpasswd",
        "a%2Fb.ron",
        ".a.ron",
        "a.ron%00",
        "..",
        "",
        "nul.ron",
        "a.ron.",
        &long,
    ] {
        for (method, path) in [
            ("GET", "api/spec"),
            ("POST", "api/spec"),
            ("POST", "api/data"),
            ("POST", "api/look"),
            ("POST", "api/check"),
        ] {
            let body = if method == "POST" { "null" } else { "" };
            let (status, body) = page.own(method, &format!("{path}?name={name}"), body);
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
fn a_spec_that_was_dropped_names_no_folder_of_data() {
    let folder = tempfile::tempdir().expect("a folder");
    let [work, other] = ["work", "other"].map(|name| folder.path().join(name));
    for (place, heading) in [(&work, "x"), (&other, "secret")] {
        std::fs::create_dir(place).expect("made");
        std::fs::write(place.join(format!("{heading}.csv")), format!("t,{heading}\n0,1\n1,2\n"))
            .expect("written");
    }
    let spec = r#"(states: { "x": "m" }, known: { "x": "-x" }, data: [Csv(path: "secret.csv", time: "t", columns: { "x": "x" })])"#;
    let written = format!("// What `phisindy run a.ron` found.\n// Data files in: ../other\n{spec}");
    let checked = |page: &Page| {
        let url = page.url();
        let (host, token) =
            url.trim_start_matches("http://").trim_end_matches('/').split_once('/').expect("both");
        let length = written.len();
        let head = format!(
            "POST /{token}/api/check?name=a.ron HTTP/1.1\r\nHost: {host}\r\nContent-Length: {length}\r\n\r\n"
        );
        String::from_utf8(page.answered((head + &written).as_bytes())).expect("text")
    };
    let said = checked(&Page::open(&work, None, 0, Request::default()).expect("a page"));
    assert!(said.contains("there is no data file") && !said.contains("columns of the file"), "{said}");
    // What was there when the page was opened is the user's own.
    std::fs::write(work.join("b.ron"), &written).expect("written");
    let said = checked(&Page::open(&work, None, 0, Request::default()).expect("a page"));
    assert!(said.contains("columns of the file"), "{said}");
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
    page.json("POST", "api/start?name=quick.ron&what=next", "");
    let result = worked(&page);
    assert_eq!(result["ended"]["result"], "quick-next-1", "{result}");
    assert_eq!(page.json("GET", "api/state", "")["results"][0]["ended"], json!("measure next"));
    assert!(page.own("GET", "results/quick-next-1/drive.csv", "").1.starts_with("t_s"));
    page.end();
    assert!(
        page.text("results/quick-run-1/identified.ron").contains("sgn(v)"),
        "the end of the page loses nothing"
    );
}

#[test]
fn the_result_of_a_long_name_is_shown() {
    let page = Served::new(None);
    let name = format!("{}\u{e9}{}.ron", "x".repeat(179), "y".repeat(15));
    page.json("POST", &format!("api/spec?name={}", name.replace('\u{e9}', "%c3%a9")), SPEC);
    page.json("POST", &format!("api/start?name={}&what=run", name.replace('\u{e9}', "%c3%a9")), "");
    let result = worked(&page)["ended"]["result"].as_str().expect("a name").to_owned();
    assert_eq!(page.json("GET", "api/state", "")["results"][0]["name"], result.as_str());
    assert_eq!(page.own("GET", &format!("results/{result}/report.html"), "").0, 200);
}

#[cfg(unix)]
#[test]
fn a_pipe_is_not_waited_for() {
    let page = Served::new(None);
    std::fs::create_dir_all(page.folder.path().join("results/a-run-1")).expect("made");
    for name in ["a.ron", "results/a-run-1/result.json"] {
        assert!(
            Command::new("mkfifo").arg(page.folder.path().join(name)).status().expect("mkfifo").success()
        );
    }
    let (status, body) = page.own("GET", "api/spec?name=a.ron", "");
    assert!(status == 400 && body.contains("pipe or a device"), "{body}");
    assert_eq!(page.json("GET", "api/state", "")["results"], json!([]));
}

/// The state of the work once it has ended.
fn worked(page: &Served) -> Value {
    let since = Instant::now();
    loop {
        let job = page.json("GET", "api/now", "")["job"].clone();
        if !job["ended"].is_null() {
            return job;
        }
        assert!(since.elapsed() < PATIENCE, "it does not end: {job}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// A search that takes long.
fn long() -> String {
    SPEC.replace("duration: 10.0, step: 0.02", "duration: 400.0, step: 0.01")
}

/// Starts a long search, and waits until it does.
fn started(page: &Served) {
    page.json("POST", "api/spec?name=long.ron", &long());
    page.json("POST", "api/start?name=long.ron&what=gap", "");
    let since = Instant::now();
    while page.json("GET", "api/now", "")["job"]["fraction"] == 0.0 {
        assert!(since.elapsed() < PATIENCE, "it does not begin");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn one_thing_is_done_at_a_time_and_can_be_stopped() {
    let page = Served::new(None);
    started(&page);
    let (status, body) = page.own("POST", "api/start?name=long.ron&what=run", "");
    assert!(status == 400 && body.contains("something is running"), "{status} {body}");
    page.json("POST", "api/stop", "");
    let ended = worked(&page)["ended"].clone();
    assert!(ended["stopped"] == true && ended["result"] == "long-gap-1", "{ended}");
    let report = page.text("results/long-gap-1/report.html");
    assert!(report.contains("Stopped by you before the end"), "the report says so");
    assert_eq!(page.json("GET", "api/state", "")["results"][0]["stopped"], true);
    let (status, body) = page.own("POST", "api/start?name=missing.ron&what=run", "");
    assert!(status == 400 && body.contains("missing.ron"), "{body}");
}

#[test]
fn the_end_of_the_page_keeps_what_was_found() {
    let mut page = Served::new(None);
    started(&page);
    page.end();
    let result: Value = serde_json::from_str(&page.text("results/long-gap-1/result.json")).expect("JSON");
    assert_eq!(result["stopped"], true);
    assert!(page.text("results/long-gap-1/report.html").contains("Stopped by SIGTERM before the end"));
    assert!(TcpStream::connect(page.parts().0).is_err(), "nobody listens any more");
}

#[test]
fn what_breaks_off_changes_nothing() {
    let page = Served::new(None);
    page.json("POST", "api/spec?name=a.ron", SPEC);
    let version =
        page.json("GET", "api/spec?name=a.ron", "")["version"].as_str().expect("a version").to_owned();
    let post = |path: &str, headers: &str, body: &str| {
        let headers = format!("If-Match: {version}\r\n{headers}");
        status(&page.raw(&(page.head("POST", path, &headers) + body)))
    };
    for path in ["api/spec?name=a.ron", "api/new-spec?name=a.ron", "api/data?name=a.csv"] {
        assert_eq!(post(path, "Content-Length: 100\r\n", "(states:"), 400, "{path}: it breaks off");
        assert_eq!(post(path, "Content-Length: 99999999999999\r\n", "("), 413, "{path}: it is too long");
        let chunks = ("Transfer-Encoding: chunked\r\n", "8\r\n(states:\r\n");
        assert_eq!(post(path, chunks.0, chunks.1), 411, "{path}: chunks without an end");
        assert_eq!(post(path, "", "(states:"), 411, "{path}: no length");
        assert_eq!(post(path, "Content-Length: -1\r\n", "("), 411, "{path}: no number");
    }
    assert_eq!(page.text("a.ron"), SPEC);
    let all: Vec<_> = std::fs::read_dir(page.folder.path()).expect("the folder").flatten().collect();
    assert_eq!(all.len(), 1, "nothing is left: {all:?}");
}

#[test]
fn an_edit_never_replaces_another_one() {
    let page = Served::new(None);
    let first = page.json("POST", "api/spec?name=a.ron", "one\n")["version"].clone();
    // Two tabs have read the same text.
    let (status, told) = page.saved("a.ron", &first, "", "two\n");
    assert_eq!(status, 200, "{told}");
    assert_eq!(page.saved("a.ron", &first, "", "mine\n").0, 412);
    assert_eq!(page.own("POST", "api/spec?name=a.ron", "mine\n").0, 412, "without a version");
    // An editor.
    std::fs::write(page.folder.path().join("a.ron"), "three\n").expect("written");
    assert_eq!(page.saved("a.ron", &told["version"], "", "mine\n").0, 412);
    let now = page.json("GET", "api/now?name=a.ron", "")["version"].clone();
    assert!(now.is_string() && now != told["version"], "the page sees it");
    // What a page saves that closes.
    assert_eq!(page.saved("a.ron", &told["version"], "&beside=1", "mine\n").1["name"], "a-2.ron");
    assert_eq!((page.text("a.ron").as_str(), page.text("a-2.ron").as_str()), ("three\n", "mine\n"));
    let answer = page.raw(&page.head("GET", "api/spec?name=a.ron", ""));
    assert!(answer.contains(&format!("ETag: {}\r\n", now.as_str().expect("a version"))), "{answer}");
}

#[test]
fn what_is_answered_has_limits_before_it_is_read() {
    let page = Served::new(None);
    let long = "a".repeat(100_000);
    assert_eq!(status(&page.raw(&page.head("GET", &long, ""))), 431);
    assert_eq!(status(&page.raw(&page.head("GET", "", &format!("X: {long}\r\n")))), 431);
    let many = (0..200).fold(String::new(), |mut all, k| {
        let _ = write!(all, "h{k}: 1\r\n");
        all
    });
    assert_eq!(status(&page.raw(&page.head("GET", "", &many))), 431);
    assert_eq!(status(&page.raw("nonsense\r\n\r\n")), 400);
    let (host, _) = page.parts();
    let foreign = format!("POST / HTTP/1.1\r\nHost: {host}\r\nContent-Length: 100000000000000\r\n\r\n");
    assert_eq!(status(&page.raw(&foreign)), 403);
    assert_eq!(page.own("GET", "api/state", "").0, 200);
}

/// Memory of this process (MB).
#[cfg(target_os = "linux")]
fn memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("the status of this process");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("its memory");
    line.trim().trim_end_matches(" kB").parse::<u64>().expect("a number") / 1024
}

/// `PHISINDY_REQUESTS=100` makes the tests of hostile requests a hundred times as long.
fn times() -> u32 {
    std::env::var("PHISINDY_REQUESTS").ok().map_or(1, |n| n.parse().expect("a number of times"))
}

#[test]
fn a_search_goes_on_whoever_asks() {
    let times = times() as usize;
    let page = Served::new(None);
    started(&page);
    // As many as the system gives files for, on both sides.
    let idle: Vec<TcpStream> = (0..20 * times.min(100)).map(|_| page.connected()).collect();
    let slow: Vec<TcpStream> = (0..10)
        .map(|k| {
            let mut stream = page.connected();
            let head = page.head("POST", &format!("api/data?name=slow-{k}.csv"), "Content-Length: 1000\r\n");
            stream.write_all((head + "t,x\n").as_bytes()).expect("sent");
            stream
        })
        .collect();
    let (host, token) = page.parts();
    let own = [
        page.head("GET", "api/state", ""),
        page.head("GET", "api/nothing", ""),
        page.head("GET", "results/%2e%2e/long.ron", ""),
        page.head("POST", "api/spec?name=long.ron", "Content-Length: 100000000000000\r\n"),
        page.head("POST", "api/spec?name=long.ron", "Content-Length: 9\r\n") + "(states:",
        page.head("POST", "api/data?name=nul", "Content-Length: 3\r\n") + "t,x",
        page.head("POST", "api/check?name=long.ron", "Content-Length: 3\r\n") + "(((",
        page.head("POST", "api/start?name=long.ron&what=sing", "Content-Length: 0\r\n"),
        page.head("GET", &"a".repeat(20_000), ""),
        page.head("GET", "api/now", "")[..40].to_owned(),
    ];
    let foreign = [
        format!("GET / HTTP/1.1\r\nHost: {host}\r\n\r\n"),
        format!("POST {token}api/stop HTTP/1.1\r\nHost: evil.example\r\nContent-Length: 0\r\n\r\n"),
        format!(
            "POST /{}/ HTTP/1.1\r\nHost: {host}\r\nContent-Length: 100000000000000\r\n\r\n",
            "0".repeat(32)
        ),
        "\0\u{ff}\r\n\r\n".to_owned(),
    ];
    std::thread::scope(|threads| {
        for (all, count) in [(&own[..], 280 * times), (&own, 280 * times), (&foreign, 100 * times)] {
            let page = &page;
            threads.spawn(move || all.iter().cycle().take(count).for_each(|text| drop(page.raw(text))));
        }
    });
    let job = page.json("GET", "api/now", "")["job"].clone();
    let goes_on = job["running"] == true && job["stopping"] == false;
    // With many requests it ends meanwhile.
    assert!(job["job"] == 1 && (goes_on || job["ended"]["stopped"] == false), "{job}");
    assert_eq!(page.text("long.ron"), long());
    #[cfg(target_os = "linux")]
    assert!(memory() <= 200, "{} MB", memory());
    drop((idle, slow));
    page.json("POST", "api/stop", "");
    assert_eq!(worked(&page)["ended"]["result"], "long-gap-1");
    let state = page.json("GET", "api/state", "");
    assert_eq!((&state["data"], &state["specs"]), (&json!([]), &json!(["long.ron"])), "no part is a file");
}

/// Pieces of requests.
const PIECES: &[&str] = &[
    "GET ",
    "POST ",
    "DELETE ",
    "/TOKEN/",
    "/",
    "api/state",
    "api/now?name=",
    "api/spec?name=",
    "api/new-spec?name=",
    "api/data?name=",
    "api/look?name=",
    "api/check?name=",
    "api/edit?name=",
    "{\"text\":\"(\",\"what\":\"constant\"}",
    "api/export?result=",
    "&to=python",
    "&beside=1",
    "&rate=1e9",
    "results/",
    "results/a-gap-1/report.html",
    "?keep=1",
    "a.ron",
    "b.csv",
    "nul.csv",
    "..",
    "%2f",
    "%00",
    "%",
    "\u{fc}",
    " HTTP/1.1\r\n",
    "Host: HOST\r\n",
    "Host: evil\r\n",
    "Content-Length: ",
    "5",
    "18446744073709551616",
    "-1",
    "\r\n",
    "Transfer-Encoding: chunked\r\n",
    "If-Match: \"0\"\r\n",
    "Origin: null\r\n",
    ": ",
    "t,x\n0,1\n",
    "(states: {",
    "null",
    "[{}]",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 500 * times(), ..ProptestConfig::default() })]

    /// Any bytes get an answer or none, and change nothing but files of the folder, as a whole.
    #[test]
    fn no_request_makes_it_fail(
        asked in select(&["GET /TOKEN/", "POST /TOKEN/", ""][..]),
        first in select(PIECES),
        name in select(PIECES),
        head in select(&[" HTTP/1.1\r\nHost: HOST\r\nContent-Length: 5\r\n\r\nt,x\n0", " HTTP/1.1\r\nHost: HOST\r\n", ""][..]),
        rest in vec(select(PIECES), 0..8),
        noise in vec(any::<u8>(), 0..4),
    ) {
        static PAGE: OnceLock<(TempDir, Page)> = OnceLock::new();
        let (folder, page) = PAGE.get_or_init(|| {
            let folder = tempfile::tempdir().expect("a folder");
            std::fs::create_dir(folder.path().join("work")).expect("made");
            let page = Page::open(&folder.path().join("work"), None, 0, Request::default()).expect("a page");
            (folder, page)
        });
        let url = page.url();
        let (host, token) = url.trim_start_matches("http://").trim_end_matches('/').split_once('/').expect("both");
        let text = [asked, first, name, head].into_iter().chain(rest).collect::<String>();
        let mut bytes = text.replace("HOST", host).replace("TOKEN", token).into_bytes();
        bytes.extend(noise);
        let answer = page.answered(&bytes);
        prop_assert!(answer.is_empty() || answer.starts_with(b"HTTP/1.1 "), "{text:?}");
        prop_assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 1, "{:?}", text);
        for entry in std::fs::read_dir(folder.path().join("work")).expect("the folder").flatten() {
            let name = entry.file_name().into_string().expect("a plain name");
            // `null` is a name like others, `nul.csv` is a device.
            prop_assert!(!name.starts_with('.') && !name.starts_with("nul."), "{name} of {text:?}");
        }
    }
}

#[test]
fn a_full_or_forbidden_place_is_tried_again_until_it_takes_the_result() {
    let page = Served::new(None);
    // A file stands where the folder of results would be.
    std::fs::write(page.folder.path().join("results"), "").expect("written");
    page.json("POST", "api/spec?name=quick.ron", SPEC);
    page.json("POST", "api/start?name=quick.ron&what=run", "");
    let since = Instant::now();
    while !page.json("GET", "api/now", "")["job"]["activity"]
        .as_str()
        .expect("words")
        .contains("trying again")
    {
        assert!(since.elapsed() < PATIENCE, "it does not say so");
        std::thread::sleep(Duration::from_millis(50));
    }
    std::fs::remove_file(page.folder.path().join("results")).expect("removed");
    assert_eq!(worked(&page)["ended"]["result"], "quick-run-1");
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

    /// Presses a key.
    fn key(&mut self, key: &str) {
        let (code, text) = match key {
            "Enter" => (13, "\r"),
            "Tab" => (9, ""),
            _ => (32, " "),
        };
        for kind in ["keyDown", "keyUp"] {
            let mut event = json!({ "type": kind, "key": key, "code": key, "windowsVirtualKeyCode": code });
            if kind == "keyDown" && !text.is_empty() {
                event["text"] = json!(text);
            }
            self.call("Input.dispatchKeyEvent", event);
        }
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
        "{{ const all = new DataTransfer(); all.items.add(new File([{}], 'rig.csv')); all.items.add(new File(['t_ms,x_mm\\n'], 'con.csv'));
            dispatchEvent(new DragEvent('drop', {{ dataTransfer: all, cancelable: true }})); 0 }}",
        json!(rig)
    ));
    browser.until("$('columns').rows.length === 3 && $('problem').textContent !== ''");
    let told = browser.value("$('problem').textContent + $('curves-of').textContent");
    assert!(
        told.as_str()
            .is_some_and(|t| t.contains("con.csv") && t.ends_with("Curves of rig.csv over time (s)")),
        "{told}"
    );
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
    browser.until("$('line').textContent.includes('round 1')");
    browser.picture("4-progress");
    browser.until("!$('answer').hidden");
    assert!(
        browser
            .value("$('line').textContent")
            .as_str()
            .is_some_and(|t| t.starts_with("what is missing in rig.ron: "))
    );
    assert_eq!(browser.value("$('answer').compareDocumentPosition($('work'))"), 4, "the answer is above");
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
    // A page that is opened again finds everything. A file leads to it.
    let way = page.folder.path().join("way.html");
    std::fs::write(&way, format!("<meta http-equiv=\"refresh\" content=\"0; url={}\">", page.url))
        .expect("written");
    browser.visit(&format!("file://{}", way.display()));
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

/// Each step of the first minutes ticks itself; all of it can be done with keys alone.
#[test]
fn the_sketch_and_the_constants_are_forms_of_the_text() {
    let Some(mut browser) = Browser::start() else {
        let _ =
            writeln!(std::io::stderr(), "skipped: the_sketch_and_the_constants: there is no chromium here");
        return;
    };
    let page = Served::new(None);
    browser.visit(&page.url);
    browser.until("document.readyState === 'complete' && !$('tour').hidden");
    browser.value("$('example').focus()");
    browser.key("Enter");
    browser.until("$('columns').rows.length === 3");
    browser.value("$('write').focus()");
    browser.key("Enter");
    browser.until("!$('gap').disabled");
    let drafted = page.text("rig.ron");
    let names = "[...document.querySelectorAll('#sketch [role=button]')].map(g => g.getAttribute('aria-label').split(' ')[0]).sort().join()";
    assert_eq!(browser.value(names), "body,damper,friction,spring");
    browser.picture("11-sketch");

    // The damper goes, and comes back.
    browser.value("document.querySelector('[data-key^=damper]').focus()");
    browser.key("Enter");
    browser.until("!$('part').hidden && document.activeElement === $('part-title')");
    browser.picture("12-part");
    browser.value("[...document.querySelectorAll('#part-actions button')].find(b => b.textContent === 'Remove').focus()");
    browser.key("Enter");
    browser.until("!text().includes('c*v') && !document.querySelector('[data-key^=damper]') && page.ok");
    assert!(page.text("rig.ron").contains("\"(F - k*x)/m\", // EDIT: the physics that you are sure of"));
    assert_eq!(browser.value("document.activeElement.id + $('part').hidden"), "backtrue");
    browser.key("Enter");
    browser.until("document.querySelector('[data-key^=damper]') && page.ok && page.saved === text()");
    assert_eq!(page.text("rig.ron"), drafted);

    // The answer comes by keys too.
    browser.value("$('gap').focus()");
    browser.key("Enter");
    browser.until("!$('curve').hidden && document.querySelector('#curve svg').getAttribute('aria-label').includes('gap of the best model')");
    browser.until("$('finding').textContent === 'Explained: Stribeck friction at v'");
    browser.until("$('steps').querySelectorAll('.done').length === 5");

    // A number is changed at its place; what the program refuses it says why.
    browser.value("document.querySelector('#constants [data-at=\"form//m/value\"]').select()");
    let typed = |browser: &mut Browser, words: &str| {
        browser.call("Input.insertText", json!({ "text": words }));
        browser.key("Tab");
    };
    typed(&mut browser, "1.6 kg");
    browser.until("text().includes('\"m\": (value: 1.6, unit: \"kg\", within: (0.0247, 247.0)), // EDIT') && page.saved === text()");
    assert_eq!(browser.value("document.activeElement.dataset.at"), "form//m/unit");
    browser.until("document.querySelector('#sketch').textContent.includes('1.6 kg')");
    typed(&mut browser, "N");
    browser.until("$('refused').textContent !== ''");
    assert!(page.text("rig.ron").contains("unit: \"kg\""));
    browser.value("{ const e = document.querySelector('#constants [data-at=\"form//k/kind\"]'); e.value = 'find'; e.dispatchEvent(new Event('change')); 0 }");
    browser.until("text().includes('\"k\": Find(start: 835.0') && $('refused').textContent === ''");

    // A body gets a spring.
    browser.value("document.querySelector('[data-key=body0]').focus()");
    browser.key(" ");
    browser.until("document.querySelectorAll('#part-new form').length === 2");
    browser.value("document.querySelectorAll('#part-new form')[1].elements.value.focus()");
    browser.call("Input.insertText", json!({ "text": "12" }));
    browser.key("Enter");
    browser.until("text().includes('(F - c*v - k*x - k2*x)/m') && text().includes('\"k2\": (12, \"N/m\")')");
    browser.picture("13-body");
    // While the text has a mistake the last sketch stays, dimmed.
    browser.value("{ code.focus(); getSelection().selectAllChildren(code); getSelection().collapseToStart(); document.execCommand('insertText', false, '?'); 0 }");
    browser.until("$('sketch').classList.contains('stale') && $('told').textContent.includes('mistake')");
    assert_eq!(browser.value("$('back').disabled"), true, "what was typed is not undone");
    browser.value("document.execCommand('undo')");
    browser.until("!$('sketch').classList.contains('stale')");

    // Another file of the same columns validates.
    let rig = page.text("rig.csv");
    page.json("POST", "api/data?name=again.csv", &(rig + "\n"));
    page.json("POST", "api/data?name=other.csv", "t,y\n0,1\n1,2\n");
    browser.value("folder().then(() => 0)");
    let role = |file: &str, to: &str| {
        format!(
            "{{ const e = [...$('files').children].find(li => li.textContent.startsWith('{file}')).querySelector('select'); e.value = '{to}'; e.dispatchEvent(new Event('change')); 0 }}"
        )
    };
    browser.value(&role("again.csv", "Validate"));
    browser.until("text().includes('Csv(path: \"again.csv\"') && page.ok");
    browser.value(&role("other.csv", "Fit"));
    browser.until("$('refused').textContent.includes('time_s')");
    assert!(!page.text("rig.ron").contains("other.csv"));

    // Two results side by side.
    page.json("POST", "api/spec?name=quick.ron", SPEC);
    for k in 2..4 {
        page.json("POST", "api/start?name=quick.ron&what=run", "");
        let since = Instant::now();
        while page.json("GET", "api/now", "")["job"]["running"] == true
            || page.json("GET", "api/now", "")["job"]["job"] != k
        {
            assert!(since.elapsed() < PATIENCE, "it does not end");
            std::thread::sleep(Duration::from_millis(50));
        }
    }
    browser.value("folder().then(() => 0)");
    browser.until("$('results').querySelectorAll('[type=checkbox]').length === 3");
    browser
        .value("[...$('results').querySelectorAll('[type=checkbox]')].slice(0, 2).forEach(e => e.click())");
    browser.until("!$('compare').hidden && $('compared').textContent.includes('0.0 standard errors')");
    for (width, mode) in [(1300, "light"), (1300, "dark"), (390, "light"), (390, "dark")] {
        let device = json!({ "width": width, "height": 1000, "deviceScaleFactor": 1, "mobile": false });
        browser.call("Emulation.setDeviceMetricsOverride", device);
        browser.call(
            "Emulation.setEmulatedMedia",
            json!({ "features": [{ "name": "prefers-color-scheme", "value": mode }] }),
        );
        browser.picture(&format!("14-{width}-{mode}"));
        assert_eq!(
            browser.value("document.documentElement.scrollWidth <= innerWidth"),
            true,
            "{width} scrolls sideways"
        );
        if let Ok(axe) = std::env::var("PHISINDY_AXE") {
            browser.value(
                &std::fs::read_to_string(axe).expect("axe.js").replace("window.axe", "globalThis.axe"),
            );
            let told = browser.value("axe.run().then(r => JSON.stringify(r.violations.map(v => [v.id, v.impact, v.nodes.map(n => n.html.slice(0, 200))])))");
            assert_eq!(told, "[]", "{width} {mode}");
        }
    }
}

/// Who stopped it, knows the page that was asked to; its report has the signal.
#[test]
fn only_what_you_stopped_is_stopped_by_you() {
    let Some(mut browser) = Browser::start() else {
        let _ = writeln!(std::io::stderr(), "skipped: only_what_you_stopped: there is no chromium here");
        return;
    };
    let mut page = Served::new(None);
    started(&page);
    browser.visit(&page.url);
    browser.until("!$('stop').hidden");
    browser.value("$('stop').click()");
    browser.until("$('finding').textContent.startsWith('Stopped by you; found so far: ')");
    assert_eq!(browser.value("$('results').textContent.includes('stopped early')"), true);
    started(&page);
    browser.until("!$('stop').hidden");
    page.end();
    assert!(page.text("results/long-gap-2/report.html").contains("Stopped by SIGTERM"));
    let again = Served::of(std::mem::replace(&mut page.folder, TempDir::new().expect("a folder")), None);
    browser.visit(&again.url);
    browser
        .until("document.readyState === 'complete' && $('results').querySelectorAll('button').length === 2");
    browser.value("$('results').querySelector('button').click()");
    browser.until("$('finding').textContent.startsWith('Stopped early; found so far: ')");
}

#[test]
fn two_tabs_and_an_editor_lose_no_edit() {
    let Some(mut browser) = Browser::start() else {
        let _ = writeln!(std::io::stderr(), "skipped: two_tabs_and_an_editor: there is no chromium here");
        return;
    };
    let page = Served::new(Some("a.ron"));
    std::fs::write(page.folder.path().join("a.ron"), SPEC).expect("written");
    let typed = |words: &str| {
        format!(
            "{{ code.focus(); getSelection().selectAllChildren(code); getSelection().collapseToStart();
                document.execCommand('insertText', false, '/* {words} */'); 0 }}"
        )
    };
    let ready = "document.readyState === 'complete' && page.spec === 'a.ron' && page.ok";
    browser.visit(&page.url);
    browser.until(ready);
    // An editor saves, the page has no edit of its own: it shows the new text.
    std::fs::write(page.folder.path().join("a.ron"), format!("/* editor */{SPEC}")).expect("written");
    browser.until("text().startsWith('/* editor */')");
    // Both edit: the page says so, and writes nothing until it is told what to do.
    browser.value(&typed("mine"));
    std::fs::write(page.folder.path().join("a.ron"), format!("/* again */{SPEC}")).expect("written");
    browser.until("!$('conflict').hidden");
    browser.picture("10-conflict");
    assert!(page.text("a.ron").starts_with("/* again */"));
    assert_eq!(browser.value("$('gap').disabled && text().startsWith('/* mine */')"), true);
    browser.value("$('keep-mine').click()");
    browser.until("$('conflict').hidden && page.spec === 'a-2.ron' && page.ok");
    assert!(page.text("a-2.ron").starts_with("/* mine *//* editor */"));
    // A page that closes at once saves beside what it could not have seen.
    browser.value("openSpec('a.ron')");
    browser.until(ready);
    std::fs::write(page.folder.path().join("a.ron"), format!("/* third */{SPEC}")).expect("written");
    browser.value(&(typed("last") + "; location.reload(); 0"));
    let since = Instant::now();
    while !page.folder.path().join("a-3.ron").exists() {
        assert!(since.elapsed() < PATIENCE, "the last edit is lost");
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(page.text("a-3.ron").starts_with("/* last */") && page.text("a.ron").starts_with("/* third */"));
}

/// A driven body that rubs, as a board sends it: a heading, then a row each millisecond.
fn board(seconds: u32) -> Vec<String> {
    let (mut x, mut v, mut seed, fine) = (0.0_f64, 0.0_f64, 1_u64, 20);
    let mut lines = vec!["time_s,x_mm,F_N\r\n".to_owned()];
    for i in 0..1000 * seconds {
        let force = |t: f64| 3.0 * (1.0 + 0.5 * (0.7 * t).sin()) * (9.0 * t).cos();
        let t = f64::from(i) * 1e-3;
        // Readings of a sensor with some 10 um of noise: D. Knuth's multiplier, its high bits.
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let noise = 0.03 * ((seed >> 32) as f64 / f64::from(u32::MAX) - 0.5);
        lines.push(format!("{t:.3},{:.4},{:.4}\r\n", 1e3 * x + noise, force(t)));
        for s in 0..fine {
            let h = 1e-3 / f64::from(fine);
            let push = force(t + h * f64::from(s)) - 60.0 * x - 1.0 * v;
            let rubbed = v + h / 2.0 * (push - 0.3 * v.signum());
            // It stays where it is stopped while the push is below the friction.
            v = if rubbed * v <= 0.0 && push.abs() < 0.3 { 0.0 } else { rubbed };
            x += h * v;
        }
    }
    lines
}

/// What the board of [`board`] is known to be, with a file that is not there.
const RIG: &str = r#"(
    states: { "x": "m", "v": "m/s" }, inputs: { "F": "N" }, inertia: { "v": "m" }, contacts: ["v"],
    constants: { "m": (2.0, "kg"), "k": (value: 50.0, unit: "N/m", within: (1.0, 900.0)), "c": (value: 0.5, unit: "N*s/m", within: (0.0, 20.0)) },
    known: { "x": "v", "v": "(F - k*x - c*v)/m" },
    data: [Csv(path: "rig.csv", time: ("time_s", "s"), columns: { "x": ("x_mm", "mm"), "F": ("F_N", "N") }, window: (0.0, 3.0))], // as sent
)"#;

/// Sends lines as a board does, a row each millisecond, in pieces that end anywhere.
fn sent(lines: &[String], mut to: impl Write) {
    let bytes: Vec<u8> = lines.concat().into_bytes();
    let (began, each) = (Instant::now(), bytes.len() / lines.len());
    for (k, piece) in bytes.chunks(each * 7 + 3).enumerate() {
        let due = Duration::from_micros(1000 * (k * (each * 7 + 3) / each) as u64);
        std::thread::sleep(due.saturating_sub(began.elapsed()));
        to.write_all(piece).expect("it is read");
    }
}

/// Follows a source while its lines are sent; whether all of them are in the file, and what was judged.
fn followed(
    source: &str,
    spec: Option<&str>,
    lines: &[String],
    send: impl FnOnce() + Send,
) -> (Served, Value) {
    let folder = tempfile::tempdir().expect("a folder");
    if let Some(text) = spec {
        std::fs::write(folder.path().join("rig.ron"), text).expect("written");
    }
    let page = Page::open(folder.path(), spec.map(|_| "rig.ron"), 0, Request::default()).expect("a page");
    let page = page.follow(source.parse().expect("a source")).expect("it is read");
    let served = Served::by(folder, page);
    let late = std::thread::scope(|threads| {
        let sender = threads.spawn(send);
        while !sender.is_finished() {
            served.json("GET", "api/live", "");
            std::thread::sleep(Duration::from_millis(200));
        }
        let since = Instant::now();
        loop {
            let now = served.json("GET", "api/live", "");
            if now["lines"] == lines.len() && now["judged_lines"] == lines.len() {
                break since.elapsed();
            }
            assert!(
                since.elapsed() < PATIENCE,
                "{} {} {}",
                now["lines"],
                now["judged_lines"],
                now["trouble"]
            );
            std::thread::sleep(Duration::from_millis(20));
        }
    });
    let _ = writeln!(
        std::io::stdout(),
        "{source}: judged {:.2} s after the last of {} lines",
        late.as_secs_f64(),
        lines.len()
    );
    served.json("POST", "api/live-stop", "");
    let since = Instant::now();
    while served.json("GET", "api/live", "")["ended"] != true {
        assert!(since.elapsed() < PATIENCE);
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(served.text("live.csv"), lines.concat(), "{source}");
    let now = served.json("GET", "api/live", "");
    (served, now)
}

/// The example lies in the crate, so that a package has it.
#[test]
fn the_example_is_the_file_of_the_tutorial() {
    let page = Served::new(None);
    assert_eq!(page.json("POST", "api/example", "")["name"], "rig.csv");
    let due = std::fs::read_to_string(top().join("docs/tutorial/rig.csv")).expect("the file of the tutorial");
    assert_eq!(page.text("rig.csv"), due);
}

/// Seconds that a board sends for: `PHISINDY_LIVE=60` is a minute at 1 kHz.
fn live_seconds() -> u32 {
    std::env::var("PHISINDY_LIVE").ok().and_then(|text| text.parse().ok()).unwrap_or(4)
}

#[cfg(unix)]
#[test]
fn a_board_is_followed_and_no_sample_is_lost() {
    use std::os::fd::AsRawFd;
    let (board_side, our_side) = serial2::SerialPort::pair().expect("a pseudo-terminal");
    let port = std::fs::read_link(format!("/proc/self/fd/{}", our_side.as_raw_fd())).expect("a name");
    let lines = board(live_seconds());
    let (served, now) =
        followed(&format!("serial:{}", port.display()), Some(RIG), &lines, || sent(&lines, &board_side));
    // The spec that judges is a copy, comments kept; what it says is what `gap` will be asked.
    assert_eq!(
        (&now["spec"], &served.json("GET", "api/state", "")["first"]),
        (&json!("rig-live.ron"), &json!("rig-live.ron"))
    );
    let spec = served.text("rig-live.ron");
    assert!(
        spec.contains("live.csv") && spec.contains("// as sent") && served.text("rig.ron") == RIG,
        "{spec}"
    );
    let force = &now["judged"]["forces"][0];
    assert_eq!((&force["speed"], &force["unit"]), (&json!("v"), &json!("N")), "{now}");
    let at = |k: usize| force["nodes"][k][1].as_f64().expect("a force");
    let last = force["nodes"].as_array().expect("nodes").len() - 1;
    let due = |k: usize| force["nodes"][k][0].as_f64().expect("a speed");
    for k in [0, last] {
        assert!((at(k) - 0.3 * due(k).signum() - due(k)).abs() < 0.2, "{force}");
    }
    assert!(
        now["judged"]["words"]
            .as_str()
            .is_some_and(|w| w.starts_with("Enough") || w.starts_with("Move") || w.starts_with("Go on")),
        "{now}"
    );
    // The same result as of the file afterwards: the same bytes, by the same spec.
    let check = served.json("POST", "api/check?name=rig-live.ron", &spec);
    assert_eq!(check["ok"], true, "{check}");
}

#[test]
fn a_socket_and_a_file_are_followed_too() {
    let lines = board(2);
    let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address");
    let (_, now) = followed(&format!("tcp://{address}"), None, &lines, || {
        sent(&lines, listener.accept().expect("it connects").0);
    });
    assert!(now["judged"]["curves"].as_array().is_some_and(|c| c.len() == 2), "{now}");
    let file = tempfile::NamedTempFile::new().expect("a file");
    let mut grows = file.reopen().expect("the file");
    followed(&file.path().display().to_string(), None, &lines, || sent(&lines, &mut grows));
}

/// A board that is started anew sends its heading again and counts from zero: its lines are a record of their own.
#[test]
fn a_file_that_begins_anew_is_another_record() {
    let folder = tempfile::tempdir().expect("a folder");
    let (source, lines) = (folder.path().join("log.csv"), board(1));
    std::fs::write(&source, lines[..500].concat()).expect("written");
    let page = Page::open(folder.path(), None, 0, Request::default()).expect("a page");
    let page = page.follow(source.display().to_string().parse().expect("a source")).expect("it is read");
    let served = Served::by(folder, page);
    let until = |name: &str, count: usize| {
        let since = Instant::now();
        loop {
            let now = served.json("GET", "api/live", "");
            if now["name"] == name && now["lines"] == count {
                break;
            }
            assert!(since.elapsed() < PATIENCE, "{now}");
            std::thread::sleep(Duration::from_millis(20));
        }
    };
    until("live.csv", 500);
    std::fs::write(&source, lines[..300].concat()).expect("written");
    until("live-2.csv", 300);
    assert_eq!(served.text("live.csv"), lines[..500].concat());
    assert_eq!(served.text("live-2.csv"), lines[..300].concat());
}

#[test]
fn a_source_that_is_not_there_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    for source in ["serial:/dev/none", "tcp://127.0.0.1:1", "none.csv"] {
        let page = Page::open(folder.path(), None, 0, Request::default()).expect("a page");
        let why = page.follow(source.parse().expect("a source")).map(|_| ()).expect_err("nothing is there");
        assert!(why.to_string().contains(source), "{why}");
    }
    // A spec that reads no file cannot judge: no other model is taken in its place.
    for (text, word) in
        [("( constants: {", "rig.ron"), (&*RIG.replace("data:", "title: \"none\", //"), "rig.ron")]
    {
        std::fs::write(folder.path().join("rig.ron"), text).expect("written");
        std::fs::write(folder.path().join("grows.csv"), "").expect("written");
        let page = Page::open(folder.path(), Some("rig.ron"), 0, Request::default()).expect("a page");
        let source = folder.path().join("grows.csv").display().to_string().parse().expect("a source");
        let why = page.follow(source).map(|_| ()).expect_err("no model");
        assert!(why.to_string().contains(word), "{why}");
    }
    for wrong in ["serial:", "serial:/dev/x@fast", "tcp://host", "tcp://host:port", "udp://host:1"] {
        assert!(wrong.parse::<Source>().is_err(), "{wrong}");
    }
}
