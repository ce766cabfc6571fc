//! Folders of results, and the ends of the program that they must outlast: signals, limits, kills at any write.
#![allow(missing_docs, clippy::print_stderr)]
#![cfg(unix)]

use crate::common::{Scratch, phisindy, program};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Case 1a over 20 s: a tenth of a second for a run.
const QUICK: &[&str] = &["run", "specs/case1a.ron", "--set", "data.0.duration=20.0", "--quiet"];
/// A run that would take an hour.
const LONG: &[&str] =
    &["run", "specs/case1a.ron", "--method", "step", "--set", "learn=(epochs: [9000000], rates: [0.01])"];

/// All files below a folder by their paths in it.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
        match path.is_dir() {
            true => {
                all.extend(files(&path).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)))
            }
            false => drop(all.insert(name, fs::read(&path).expect("a file"))),
        }
    }
    all
}

/// The files of a result without its duration, which differs between two runs.
fn timeless(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = files(folder);
    if let Some(json) = all.get_mut("result.json") {
        let mut result: Value = serde_json::from_slice(json).expect("whole JSON");
        result["seconds"] = Value::Null;
        *json = result.to_string().into_bytes();
    }
    if let Some(equation) = all.get_mut("equation.tex") {
        let text = String::from_utf8(std::mem::take(equation)).expect("text");
        let (before, after) = text.split_once(" (method ").expect("how it was found");
        *equation = format!("{before}{}", after.split_once(" s)").expect("its time").1).into_bytes();
    }
    if let Some(page) = all.get_mut("report.html") {
        assert!(page.ends_with(b"</html>\n"), "a whole page");
        *page = b"a page".to_vec();
    }
    all
}

/// Starts work and sends it a signal once it has begun.
fn signalled(child: &mut Child, signals: &[&str]) {
    for signal in signals {
        std::thread::sleep(Duration::from_secs(3));
        let kill = Command::new("kill").args([signal, child.id().to_string().as_str()]).status();
        assert!(kill.expect("kill runs").success());
    }
}

/// What a command says that a signal ends, with the code for that.
#[track_caller]
fn ended(arguments: &[&str], signal: &str) -> String {
    let mut child = program(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("starts");
    signalled(&mut child, &[signal]);
    let said = child.wait_with_output().expect("ends");
    let err = String::from_utf8_lossy(&said.stderr).into_owned();
    assert_eq!(said.status.code(), Some(130), "{signal}: {err}");
    err
}

#[test]
fn every_signal_keeps_what_was_found_and_marks_it() {
    for (signal, name) in [("-TERM", "SIGTERM"), ("-HUP", "SIGHUP"), ("-INT", "Ctrl-C")] {
        let scratch = Scratch::new("signal");
        let out = scratch.path("out");
        ended(&[LONG, &["--out", &out]].concat(), signal);
        let words = format!("topped by {name} before the end");
        // What was given is whole.
        let given = |path: &str| ["spec.ron", "provenance.json"].contains(&path);
        for (path, bytes) in files(&scratch.0.join("out")).into_iter().filter(|(path, _)| !given(path)) {
            let text = String::from_utf8(bytes).expect("text");
            let marked = if path == "result.json" { "\"stopped\":true" } else { &words };
            assert!(text.contains(marked), "{signal}: {path}");
        }
    }
}

#[test]
fn a_page_that_waits_ends_by_a_signal_and_speaks_of_no_work() {
    for signal in ["-TERM", "-HUP", "-INT"] {
        let scratch = Scratch::new("page");
        let err = ended(&["open", "--no-open", &scratch.path("")], signal);
        assert!(!err.contains("the work ends"), "{err}");
    }
}

/// `nohup` sets SIGHUP aside.
#[cfg(target_os = "linux")]
#[test]
fn work_that_was_told_to_outlast_its_terminal_does() {
    let scratch = Scratch::new("nohup");
    let shell = format!(
        "trap '' HUP; exec \"{}\" {} --out \"{}\" 2>&1",
        env!("CARGO_BIN_EXE_phisindy"),
        LONG.iter().map(|word| format!("'{word}'")).collect::<Vec<_>>().join(" "),
        scratch.path("out")
    );
    let mut child = Command::new("sh")
        .current_dir(crate::common::top())
        .args(["-c", &shell])
        .stdout(Stdio::piped())
        .spawn()
        .expect("sh");
    signalled(&mut child, &["-HUP", "-TERM"]);
    let said = child.wait_with_output().expect("ends");
    assert!(String::from_utf8_lossy(&said.stdout).contains("stopped by SIGTERM"), "{said:?}");
}

#[test]
fn what_a_limit_leaves_replaces_no_complete_result() {
    let scratch = Scratch::new("less");
    let out = scratch.path("out");
    assert_eq!(phisindy(&[QUICK, &["--out", &out]].concat()).code, 0);
    let before = files(&scratch.0.join("out"));
    let said = phisindy(&[LONG, &["--limit", "1s", "--out", &out]].concat());
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(
        said.err.contains("stays as it was; this result is kept in") && said.err.contains("out.1"),
        "{}",
        said.err
    );
    assert!(files(&scratch.0.join("out")) == before);
    let beside = fs::read_to_string(scratch.path("out.1/identified.ron")).expect("what was found");
    assert!(beside.contains("// Stopped: the limit of 1 s is met before the end"), "{beside}");
    // A spec with a mistake leaves nothing at all beside a result.
    let said = phisindy(&["run", "specs/wrong/candidate_unknown_name.ron", "--out", &out]);
    assert!(said.code == 2 && said.err.contains("keeps its earlier result"), "{}", said.err);
    assert!(files(&scratch.0.join("out")) == before && !fs::exists(scratch.path("out.2")).expect("a folder"));
    // What is complete replaces what is not, and nothing of both is mixed.
    assert_eq!(phisindy(&[QUICK, &["--out", &scratch.path("out.1")]].concat()).code, 0);
    assert!(timeless(&scratch.0.join("out.1")) == timeless(&scratch.0.join("out")));
    assert_eq!(fs::read_to_string(scratch.path("out.1.1/identified.ron")).expect("kept"), beside);
}

#[test]
fn folders_with_other_files_need_force() {
    let sweep = ["sweep", "specs/case1a.ron", "--set", "data.0.duration=20.0", "--seeds", "1"];
    for command in [QUICK, &sweep] {
        let scratch = Scratch::new("others");
        let notes = scratch.path("notes.txt");
        fs::write(&notes, "mine").expect("a file");
        let out = scratch.path("");
        let said = phisindy(&[command, &["--out", &out]].concat());
        assert_eq!((said.code, said.out.as_str()), (2, ""), "{}", said.err);
        assert!(
            said.err.contains("holds what is no result: `notes.txt`") && said.err.contains("--force"),
            "{}",
            said.err
        );
        let said = phisindy(&[command, &["--out", &out, "--force"]].concat());
        assert_eq!(
            (said.code, fs::read_to_string(&notes).expect("it").as_str()),
            (0, "mine"),
            "{}",
            said.err
        );
    }
}

/// How the tracer changes a call of the program: end it there, or let the call fail.
const FAULTS: [&str; 2] = ["signal=KILL", "error=ENOSPC"];

/// Runs the program with a fault at the `k`-th call of each kind; `None` if there is no `k`-th call.
fn faulty(arguments: &[&str], call: &str, fault: &str, k: usize) -> Option<Option<i32>> {
    let trace = Scratch::new("trace");
    let log = trace.path("log");
    let calls = format!("trace={call}");
    let inject = format!("inject={call}:{fault}:when={k}");
    let plain = program(arguments);
    let output = Command::new("strace")
        .current_dir(crate::common::top())
        .args(["-f", "-qq", "-o", &log, "-e", &calls, "-e", &inject, "--"])
        .arg(plain.get_program())
        .args(plain.get_args())
        .output()
        .expect("strace runs");
    let log = fs::read_to_string(&log).unwrap_or_default();
    let met = log.contains("INJECTED") || log.contains("killed by SIGKILL");
    met.then(|| output.status.code())
}

/// Whether the program ended as the fault asks: killed, or with or without its result. The tracer ends like it.
fn ended_as_due(fault: &str, code: Option<i32>) -> bool {
    if fault == FAULTS[0] { code.is_none() } else { matches!(code, Some(0 | 2)) }
}

/// Whether calls can be traced here.
fn can_trace() -> bool {
    // Each call of a kind is a run of its own: minutes. (`--seccomp-bpf` is faster, and sends no signals.)
    if std::env::var_os("PHISINDY_FAULTS").is_none() {
        eprintln!("skipped: PHISINDY_FAULTS is not set, no faults are made");
        return false;
    }
    let able =
        Command::new("strace").args(["-qq", "-o", "/dev/null", "true"]).status().is_ok_and(|s| s.success());
    if !able {
        eprintln!("strace cannot be used here: no faults are made");
    }
    able
}

/// The calls that change a disk.
const CALLS: [&str; 8] =
    ["mkdir", "write", "fsync", "fdatasync", "rename", "renameat2", "unlink,unlinkat", "rmdir"];
/// Calls of one kind that are made to fail at most.
const MOST: usize = 60;

/// At whatever call the program ends, the folder holds the earlier result or the new one, whole; so does every
/// folder beside it.
#[cfg(target_os = "linux")]
#[test]
fn a_folder_of_results_outlasts_every_fault() {
    if !can_trace() {
        return;
    }
    let made = |title: &str, out: &str| {
        let title = format!("title=\"{title}\"");
        let said = phisindy(&[QUICK, &["--set", &title, "--out", out]].concat());
        assert_eq!(said.code, 0, "{}", said.err);
    };
    let reference = Scratch::new("reference");
    let old = {
        made("old", &reference.path("old"));
        timeless(&reference.0.join("old"))
    };
    let new = {
        made("new", &reference.path("new"));
        timeless(&reference.0.join("new"))
    };
    let mut faults = 0;
    for over in [false, true] {
        for (call, fault) in CALLS.iter().flat_map(|call| FAULTS.map(|fault| (call, fault))) {
            for k in 1..MOST {
                let scratch = Scratch::new("fault");
                let out = scratch.0.join("out");
                if over {
                    made_from(&reference.0.join("old"), &out);
                }
                let path = scratch.path("out");
                let arguments = [QUICK, &["--set", "title=\"new\"", "--out", &path]].concat();
                let Some(code) = faulty(&arguments, call, fault, k) else { break };
                faults += 1;
                let told = format!("{call} {fault} {k}, over a result: {over}, exit code {code:?}");
                assert!(ended_as_due(fault, code), "{told}");
                let now = timeless(&out);
                assert!(now == new || (if over { now == old } else { now.is_empty() }), "{told}");
                for entry in fs::read_dir(&scratch.0).expect("a folder").flatten() {
                    let name = entry.file_name().to_string_lossy().into_owned();
                    if name.starts_with("out.") {
                        let beside = timeless(&entry.path());
                        assert!(beside == old || beside == new, "{told}: {name}");
                    } else if code.is_some() && !call.starts_with('r') && !call.starts_with('u') {
                        assert_eq!(
                            name, "out",
                            "{told}: nothing else is left where the program ended by itself"
                        );
                    }
                }
                // The next run mends everything; one for each kind is enough.
                if k == 1 {
                    made("new", &path);
                    let left = fs::read_dir(&scratch.0).expect("a folder").flatten();
                    let parts: Vec<_> =
                        left.filter(|e| e.file_name().to_string_lossy().ends_with(".part")).collect();
                    let now = timeless(&out);
                    let differ: Vec<&String> =
                        new.keys().filter(|name| now.get(*name) != new.get(*name)).collect();
                    assert!(
                        differ.is_empty() && now.len() == new.len() && parts.is_empty(),
                        "{told}: {differ:?} {parts:?}"
                    );
                }
            }
        }
    }
    assert!(faults > 60, "only {faults} faults were made");
    eprintln!("{faults} faults");
}

/// The page of a program, as a browser sees it. Requests give nothing once the program has ended.
struct Page {
    host: String,
    token: String,
}

impl Page {
    /// The page whose address is the first line that begins like one.
    fn of(out: impl Read) -> Option<Page> {
        let mut lines = BufReader::new(out).lines().map_while(Result::ok);
        let address = lines.find_map(|line| Some(line.strip_prefix("http://")?.to_owned()))?;
        let (host, token) = address.split_once('/')?;
        Some(Page { host: host.to_owned(), token: token.to_owned() })
    }

    /// Status and body of an answer.
    fn asked(&self, method: &str, path: &str, headers: &str, body: &str) -> Option<(u16, Value)> {
        let (Page { host, token }, length) = (self, body.len());
        let head = format!("{method} /{token}{path} HTTP/1.1\r\nHost: {host}\r\n{headers}");
        let mut stream = TcpStream::connect(host).ok()?;
        stream.set_read_timeout(Some(Duration::from_secs(60))).ok()?;
        stream.write_all(format!("{head}Content-Length: {length}\r\n\r\n{body}").as_bytes()).ok()?;
        let mut answer = String::new();
        stream.read_to_string(&mut answer).ok()?;
        let (head, body) = answer.split_once("\r\n\r\n")?;
        Some((head.split(' ').nth(1)?.parse().ok()?, serde_json::from_str(body).ok()?))
    }

    /// Sends something; whether it was taken. A fault meets every thread, and each request has one.
    fn sent(&self, path: &str, body: &str) -> Option<bool> {
        let there = self.asked("GET", "api/spec?name=a.ron", "", "")?.1;
        let known = there["version"].as_str().map_or(String::new(), |v| format!("If-Match: {v}\r\n"));
        Some(self.asked("POST", path, &known, body)?.0 == 200)
    }

    /// Uploads data, saves a spec twice, and runs it to its end.
    fn worked(&self, folder: &str, specs: [&str; 2]) -> Option<Value> {
        self.sent("api/data?name=rig.csv", DATA)?;
        for spec in specs {
            if !self.sent("api/spec?name=a.ron", spec)? {
                fs::write(Path::new(folder).join("a.ron"), spec).expect("written");
            }
        }
        while !self.sent("api/start?name=a.ron&what=run", "")? {}
        loop {
            std::thread::sleep(Duration::from_millis(20));
            let job = self.asked("GET", "api/now", "", "")?.1["job"].clone();
            if job["running"] == false {
                return Some(job["ended"].clone());
            }
        }
    }
}

/// A file that is uploaded.
const DATA: &str = "t_s,x_mm\n0.0,1.5\n0.1,1.4\n";

/// A page in a folder with one spec, `a.ron`, whose run would take an hour and is under way; `shell` stands before
/// the program.
fn searching(scratch: &Scratch, shell: &str) -> (Child, Page) {
    let long = fs::read_to_string(crate::common::top().join("specs/case1a.ron")).expect("a spec");
    let long = long.replace(
        "learn: (optimiser: RAdam, epochs: [1000, 1000, 1000], rates: [0.1, 0.01, 0.001]",
        "learn: (method: Step, epochs: [9000000], rates: [0.01]",
    );
    fs::write(scratch.path("a.ron"), long).expect("written");
    let shell = format!("{shell} exec \"$0\" open --no-open --quiet \"$1\"");
    let mut child = Command::new("sh")
        .args(["-c", &shell, env!("CARGO_BIN_EXE_phisindy"), &scratch.path("")])
        .stdout(Stdio::piped())
        .spawn()
        .expect("starts");
    let page = Page::of(child.stdout.take().expect("a pipe")).expect("its address");
    assert_eq!(page.sent("api/start?name=a.ron&what=run", ""), Some(true));
    (child, page)
}

/// What its page kept at a signal.
#[track_caller]
fn kept_at(scratch: &Scratch, name: &str) {
    let report = fs::read_to_string(scratch.path("results/a-run-1/report.html")).expect("a result");
    assert!(report.contains(&format!("topped by {name} before the end")), "{name}");
}

/// A signal ends the search of a page, which keeps what it found.
#[test]
fn the_search_of_a_page_is_kept_at_every_signal() {
    for (signal, name) in [("-TERM", "SIGTERM"), ("-HUP", "SIGHUP"), ("-INT", "Ctrl-C")] {
        let scratch = Scratch::new("search");
        let (mut child, _) = searching(&scratch, "");
        signalled(&mut child, &[signal]);
        assert_eq!(child.wait().expect("ends").code(), Some(130), "{signal}");
        kept_at(&scratch, name);
    }
}

/// Where the system gives no file for one more connection, the page waits until it does, and its search goes on.
#[cfg(target_os = "linux")]
#[test]
fn a_page_outlasts_the_want_of_files() {
    // A connection takes two files: of an odd number that is left it gets one.
    for most in [60, 61] {
        let scratch = Scratch::new("files");
        let (mut child, page) = searching(&scratch, &format!("ulimit -n {most};"));
        let taken = || fs::read_dir(format!("/proc/{}/fd", child.id())).map_or(0, Iterator::count);
        let idle: Vec<TcpStream> =
            (0..most).map(|_| TcpStream::connect(&page.host).expect("it listens")).collect();
        let since = Instant::now();
        while taken() < most - 1 && since.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(1));
        }
        let used = taken();
        std::thread::sleep(Duration::from_millis(300));
        drop(idle);
        let now = page.asked("GET", "api/now", "", "");
        // Before anything can fail here: it would run for an hour.
        signalled(&mut child, &["-TERM"]);
        assert_eq!(child.wait().expect("ends").code(), Some(130));
        assert!(used >= most - 1, "only {used} of {most} files were used");
        let (status, now) = now.expect("an answer");
        assert!(status == 200 && now["job"]["running"] == true, "{now}");
        kept_at(&scratch, "SIGTERM");
    }
}

/// At whatever call the program of a page ends, its files are old or new and whole, and so is every result.
#[cfg(target_os = "linux")]
#[test]
fn a_page_outlasts_every_fault() {
    if !can_trace() {
        return;
    }
    let spec = fs::read_to_string(crate::common::top().join("specs/case1a.ron")).expect("a spec");
    let specs = ["old", "new"]
        .map(|title| spec.replace("Case 1a", title).replace("duration: 50.0", "duration: 20.0"));
    let specs = specs.each_ref().map(String::as_str);
    // The page in `folder` with a fault; its end, and whether the fault was met.
    let opened = |folder: &str, inject: Option<(&str, &str, usize)>| {
        let trace = Scratch::new("trace");
        let log = trace.path("log");
        let mut command = Command::new("strace");
        command.args(["-f", "-qq", "-o", &log]);
        match inject {
            Some((call, fault, k)) => command.args([
                "-e",
                &format!("trace={call}"),
                "-e",
                &format!("inject={call}:{fault}:when={k}"),
            ]),
            None => command.args(["-e", "trace=none"]),
        };
        let mut child = command
            .arg("--")
            .arg(program(&[]).get_program())
            .args(["open", "--no-open", "--quiet", folder])
            .stdout(Stdio::piped())
            .spawn()
            .expect("strace runs");
        let ended =
            Page::of(child.stdout.take().expect("a pipe")).and_then(|page| page.worked(folder, specs));
        let traced = format!("/proc/{0}/task/{0}/children", child.id());
        let traced = fs::read_to_string(traced).unwrap_or_default();
        let _ =
            Command::new("kill").arg("-TERM").args(traced.split_whitespace()).stderr(Stdio::null()).status();
        let code = child.wait().expect("ends").code();
        let log = fs::read_to_string(&log).unwrap_or_default();
        (ended, code, log.contains("INJECTED") || log.contains("killed by SIGKILL"))
    };
    let reference = Scratch::new("reference");
    let (ended, code, _) = opened(&reference.path(""), None);
    assert_eq!((ended.expect("an end")["result"].as_str(), code), (Some("a-run-1"), Some(130)));
    let due = timeless(&reference.0.join("results/a-run-1"));
    assert!(due.len() > 5, "{:?}", due.keys());
    let mut faults = 0;
    for (call, fault) in CALLS.iter().flat_map(|call| FAULTS.map(|fault| (call, fault))) {
        for k in 1..MOST {
            let scratch = Scratch::new("fault");
            let (ended, code, met) = opened(&scratch.path(""), Some((call, fault, k)));
            if !met {
                break;
            }
            faults += 1;
            let told = format!("{call} {fault} {k}: {ended:?}, exit code {code:?}");
            for (name, all) in [("rig.csv", &[DATA][..]), ("a.ron", &specs)] {
                let text = fs::read_to_string(scratch.path(name));
                assert!(
                    text.is_ok_and(|text| all.contains(&text.as_str())) || !scratch.0.join(name).exists(),
                    "{told}: {name}"
                );
            }
            let results = fs::read_dir(scratch.0.join("results")).into_iter().flatten().flatten();
            let results: Vec<_> =
                results.filter(|e| !e.file_name().to_string_lossy().starts_with('.')).collect();
            for result in &results {
                let now = timeless(&result.path());
                let differ: Vec<&String> =
                    due.keys().filter(|name| now.get(*name) != due.get(*name)).collect();
                assert!(differ.is_empty() && now.len() == due.len(), "{told}: {differ:?}");
            }
            if let Some(ended) = ended {
                assert_eq!((ended["result"].as_str(), code), (Some("a-run-1"), Some(130)), "{told}");
                assert_eq!(results.len(), 1, "{told}");
            }
            // The next page works as if nothing had been.
            if k % 10 == 1 {
                let (ended, code, _) = opened(&scratch.path(""), None);
                assert!(ended.is_some_and(|e| e["result"].is_string()) && code == Some(130), "{told}");
            }
        }
    }
    assert!(faults > 60, "only {faults} faults were made");
    eprintln!("{faults} faults");
}

/// Copies a result.
fn made_from(from: &Path, to: &Path) {
    for (name, bytes) in files(from) {
        fs::create_dir_all(to.join(&name).parent().expect("a folder")).expect("made");
        fs::write(to.join(&name), bytes).expect("written");
    }
}

/// At whatever call a sweep ends, the same command goes on to the same table.
#[cfg(target_os = "linux")]
#[test]
fn a_sweep_outlasts_every_fault() {
    if !can_trace() {
        return;
    }
    let sweep = [
        "sweep",
        "specs/case1a.ron",
        "--set",
        "data.0.duration=20.0",
        "--seeds",
        "2",
        "--jobs",
        "1",
        "--quiet",
    ];
    let whole = phisindy(&sweep);
    assert_eq!(whole.code, 0, "{}", whole.err);
    let mut faults = 0;
    for (call, fault) in CALLS.iter().flat_map(|call| FAULTS.map(|fault| (call, fault))) {
        for k in 1..MOST {
            let scratch = Scratch::new("fault");
            let out = scratch.path("out");
            let arguments = [&sweep as &[&str], &["--out", &out]].concat();
            let Some(code) = faulty(&arguments, call, fault, k) else { break };
            faults += 1;
            let told = format!("{call} {fault} {k}, exit code {code:?}");
            assert!(ended_as_due(fault, code), "{told}");
            if let Ok(table) = fs::read_to_string(scratch.path("out/sweep.json")) {
                serde_json::from_str::<Value>(&table).expect("a whole table");
            }
            let again = phisindy(&arguments);
            assert_eq!((again.code, &again.out), (0, &whole.out), "{told}: {}", again.err);
            let names: Vec<String> = files(&scratch.0.join("out")).into_keys().collect();
            assert_eq!(names, ["sweep.json", "sweep.jsonl"], "{told}");
        }
    }
    assert!(faults > 20, "only {faults} faults were made");
}
