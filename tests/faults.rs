//! What goes wrong around the program: full disks, folders that cannot be written, kills, pipes, files that
//! are cut off or come from elsewhere. Nothing may hang, be half-written, or be lost without a word.
#![allow(missing_docs)]
#![cfg(target_os = "linux")]

use crate::common::{self, Outcome, Scratch, phisindy, program};
use std::fs::{self, File};
use std::io::{Read, Write};
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Case 1a over 20 s: a tenth of a second for a run.
const QUICK: &[&str] = &["specs/case1a.ron", "--set", "data.0.duration=20.0"];

/// A swing, row by row.
fn rows(n: usize) -> String {
    let row = |k: usize| {
        let t = 0.01 * k as f64;
        format!("{t:.2},{:.6}\n", (2.0 * t).cos() * (-0.05 * t).exp())
    };
    format!("t,x\n{}", (0..n).map(row).collect::<String>())
}

/// A spec that reads `file`, with more fields of its record.
fn spec(file: &str, more: &str) -> String {
    format!(
        "(constants: {{ \"k\": (value: 4.0, within: (3.0, 5.0)), \"c\": (value: 0.1, within: (0.0, 1.0)) }}, states: {{ \"x\": \"m\", \"v\": \"m/s\" }}, \
         known: {{ \"x\": \"v\", \"v\": \"-k*x - c*v\" }}, unknown: {{}}, \
         data: [Csv(path: \"{file}\", time: \"t\", columns: {{ \"x\": \"x\" }}{more})])"
    )
}

/// A folder with a spec and, if it has a content, its data file.
fn case(name: &str, content: Option<&str>, more: &str) -> Scratch {
    let scratch = Scratch::new(name);
    fs::write(scratch.path("case.ron"), spec("a.csv", more)).expect("a spec");
    if let Some(content) = content {
        fs::write(scratch.path("a.csv"), content).expect("a data file");
    }
    scratch
}

/// `check` with the data, which must end soon.
fn check(scratch: &Scratch) -> Outcome {
    let begin = Instant::now();
    let said = phisindy(&["check", &scratch.path("case.ron"), "--data", &scratch.path("")]);
    assert!(begin.elapsed() < Duration::from_secs(20), "{}", said.err);
    said
}

#[track_caller]
fn refused(said: &Outcome, words: &[&str]) {
    assert_eq!((said.code, said.out.as_str()), (2, ""), "{}", said.err);
    assert!(said.err.contains("help: "), "{}", said.err);
    words.iter().for_each(|word| assert!(said.err.contains(word), "{word:?} is not in {}", said.err));
}

#[test]
fn a_full_disk_is_told_and_the_result_is_not_lost() {
    let scratch = Scratch::new("full");
    // A limit on the size of files is what a full disk looks like to a program; the report is its largest
    // file.
    let shell = format!(
        "ulimit -f 8; exec \"{}\" run {} --out \"{}\"",
        env!("CARGO_BIN_EXE_phisindy"),
        QUICK.join(" "),
        scratch.path("out")
    );
    let output = Command::new("bash").current_dir(common::top()).args(["-c", &shell]).output().expect("bash");
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(2), "{err}");
    assert!(out.contains("\\dot{y}"), "the result is printed all the same: {out}");
    assert!(err.contains("cannot write") && err.contains("--out"), "{err}");
    let left: Vec<_> = fs::read_dir(&scratch.0).expect("a folder").flatten().map(|e| e.file_name()).collect();
    assert!(left.is_empty(), "nothing is left of a result that has no room: {left:?}");
}

#[test]
fn standard_output_may_be_full_or_closed() {
    for arguments in [&[&["run"], QUICK].concat(), &[&["simulate"], QUICK].concat()] {
        let full = File::options().write(true).open("/dev/full").expect("a device that is always full");
        let output =
            program(arguments).stdout(full).stderr(Stdio::piped()).output().expect("the program starts");
        let err = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{err}");
        assert!(err.contains("cannot write to standard output") && err.contains("--out"), "{err}");
        // `| head -1`
        let mut child =
            program(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("starts");
        let mut first = [0];
        child.stdout.take().expect("a pipe").read_exact(&mut first).expect("a byte");
        let output = child.wait_with_output().expect("ends");
        let err = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(0) && !err.contains("panicked"), "{:?} {err}", output.status);
    }
}

#[test]
fn an_output_folder_that_cannot_be_written_is_told_before_the_work() {
    let scratch = Scratch::new("readonly");
    let file = scratch.path("file");
    fs::write(&file, "mine").expect("written");
    let said = phisindy(&[&["run"], QUICK, &["--out", &file]].concat());
    assert_eq!((said.code, said.out.as_str()), (2, ""), "{}", said.err);
    assert!(said.err.contains("--out: ") && said.err.contains("is a file"), "{}", said.err);
    assert_eq!(fs::read_to_string(&file).expect("it"), "mine");
    let folder = scratch.path("folder");
    fs::create_dir(&folder).expect("a folder");
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o555)).expect("read-only");
    let said = phisindy(&[&["run"], QUICK, &["--out", &folder]].concat());
    assert_eq!((said.code, said.out.as_str()), (2, ""), "{}", said.err);
    assert!(said.err.contains("is read-only"), "{}", said.err);
    let said = phisindy(&[&["run"], QUICK, &["--out", "/proc/phisindy"]].concat());
    assert_eq!((said.code, said.out.as_str()), (2, ""), "{}", said.err);
    assert!(said.err.contains("cannot write the folder"), "{}", said.err);
}

#[test]
fn a_sweep_that_was_killed_goes_on_to_the_same_table() {
    let sweep = [&["sweep"], QUICK, &["--seeds", "12", "--jobs", "2"]].concat();
    let whole = phisindy(&sweep);
    assert_eq!(whole.code, 0, "{}", whole.err);
    let scratch = Scratch::new("kill");
    let folder = scratch.path("out");
    let kept = [&sweep as &[&str], &["--out", &folder]].concat();
    let lines = || fs::read_to_string(scratch.path("out/sweep.jsonl")).map_or(0, |text| text.lines().count());
    // Killed twice, each time after a few more runs.
    for least in [3, 6] {
        let mut child = program(&kept).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("starts");
        let begin = Instant::now();
        while lines() < least && child.try_wait().expect("a child").is_none() {
            assert!(begin.elapsed() < Duration::from_secs(60), "no run is finished");
            std::thread::sleep(Duration::from_millis(2));
        }
        let _ = child.kill();
        child.wait().expect("ends");
        assert!(!fs::exists(scratch.path("out/sweep.json")).expect("a folder") || lines() == 13);
    }
    let again = phisindy(&kept);
    assert_eq!((again.code, again.out), (0, whole.out), "{}", again.err);
}

#[test]
fn what_is_no_file_is_refused_and_not_waited_for() {
    let scratch = case("pipe", None, "");
    let made = Command::new("mkfifo").arg(scratch.path("a.csv")).status().expect("mkfifo");
    assert!(made.success());
    refused(&check(&scratch), &["pipe or a device", "asked for here"]);
    let said = phisindy(&["new", &scratch.path("a.csv")]);
    refused(&said, &["pipe or a device"]);
    fs::remove_file(scratch.path("a.csv")).expect("removed");
    fs::create_dir(scratch.path("a.csv")).expect("a folder");
    refused(&check(&scratch), &["it is a folder", "name a file in it"]);
    let said = phisindy(&["check", &scratch.path("")]);
    assert!(said.code == 2 && said.err.contains("it is a folder"), "{}", said.err);
    refused(&phisindy(&["check", "/dev/zero"]), &["longer than 1 MiB"]);
    // A spec is read no further than a spec can be long.
    let long = scratch.path("long.ron");
    File::create(&long).and_then(|file| file.set_len(1 << 40)).expect("a file");
    refused(&phisindy(&["check", &long]), &["longer than 1 MiB"]);
    // No writer comes.
    for name in ["a.ron", "j/sweep-1-of-2.jsonl", "out/result.json"] {
        let path = scratch.path(name);
        fs::create_dir_all(Path::new(&path).parent().expect("a folder")).expect("made");
        assert!(Command::new("mkfifo").arg(path).status().expect("mkfifo").success());
    }
    refused(&phisindy(&["run", &scratch.path("a.ron")]), &["pipe or a device"]);
    let said = phisindy(&["sweep", "--merge", &scratch.path("j")]);
    assert!(said.code == 2 && said.err.contains("pipe or a device"), "{}", said.err);
    let said = phisindy(&[&["run"], QUICK, &["--planned", &scratch.path("out")]].concat());
    assert!(said.code == 2 && said.err.contains("pipe or a device"), "{}", said.err);
    let said = phisindy(&[&["run"], QUICK, &["--force", "--out", &scratch.path("out")]].concat());
    assert_eq!(said.code, 0, "{}", said.err);
}

#[test]
fn a_spec_reads_nothing_outside_of_its_data_folder() {
    let outside = Scratch::new("outside");
    fs::write(outside.path("secret.csv"), rows(50)).expect("written");
    let scratch = case("links", None, "");
    for target in [outside.path("secret.csv"), "/dev/zero".to_owned(), "/etc/passwd".to_owned()] {
        let link = scratch.path("a.csv");
        let _ = fs::remove_file(&link);
        symlink(&target, &link).expect("a link");
        refused(&check(&scratch), &["is a link that leads out of the data folder"]);
    }
    // A folder that is a link leads out too; a link inside of the folder does not.
    symlink(outside.path(""), scratch.path("sub")).expect("a link");
    fs::write(scratch.path("case.ron"), spec("sub/secret.csv", "")).expect("written");
    refused(&check(&scratch), &["leads out of the data folder"]);
    fs::write(scratch.path("real.csv"), rows(50)).expect("written");
    symlink("real.csv", scratch.path("inside.csv")).expect("a link");
    fs::write(scratch.path("case.ron"), spec("inside.csv", "")).expect("written");
    assert_eq!(check(&scratch).code, 0);
    for path in ["../secret.csv", "/etc/passwd", "sub/../../secret.csv", "~/x.csv", "\\\\host\\x.csv"] {
        fs::write(scratch.path("case.ron"), spec(&path.replace('\\', "\u{2216}"), "")).expect("written");
        refused(&check(&scratch), &["data f"]);
    }
    // Laws beside the spec come with it.
    fs::write(scratch.path("case.ron"), spec("real.csv", "")).expect("written");
    fs::create_dir(scratch.path("laws")).expect("a folder");
    symlink("/etc/passwd", scratch.path("laws/mine.ron")).expect("a link");
    let said = phisindy(&["gap", &scratch.path("case.ron"), "--data", &scratch.path("")]);
    assert_eq!((said.code, said.out.as_str()), (2, ""), "{}", said.err);
    assert!(
        said.err.contains("leads out of the folder of laws") && !said.err.contains("root:"),
        "{}",
        said.err
    );
}

#[test]
fn a_file_that_ends_inside_its_last_number_is_told_of() {
    let whole = rows(100);
    let said = check(&case("whole", Some(whole.trim_end()), ""));
    assert!(said.code == 0 && !said.err.contains("warning"), "no line end is no mistake: {}", said.err);
    // Inside the last number, and before its first digit.
    let said = check(&case("cut", Some(&whole[..whole.len() - 4]), ""));
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(
        said.err.contains("perhaps inside its last number") && said.err.contains("a.csv:101"),
        "{}",
        said.err
    );
    let at = whole.trim_end().rfind(',').expect("a comma");
    refused(&check(&case("comma", Some(&whole[..=at]), "")), &["ends in the middle of line 101", "cut off"]);
}

#[test]
fn a_file_that_became_shorter_between_two_runs_is_told_of() {
    let scratch = case("shorter", Some(&rows(1000)), ", window: (0.0, 9.9)");
    let said = check(&scratch);
    assert!(said.code == 0 && !said.err.contains("warning"), "{}", said.err);
    fs::write(scratch.path("a.csv"), rows(400)).expect("written");
    let said = check(&scratch);
    assert!(said.err.contains("goes on to 9.9 s") && said.err.contains("ends at 3.99 s"), "{}", said.err);
    fs::write(scratch.path("a.csv"), "").expect("written");
    refused(&check(&scratch), &["is empty"]);
}

#[test]
fn a_file_that_grows_while_it_is_read_is_refused() {
    let scratch = case("grows", Some(&rows(200_000)), "");
    let path = scratch.path("a.csv");
    let mut child = program(&["check", &scratch.path("case.ron"), "--data", &scratch.path("")])
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts");
    // A logger that has not finished.
    let mut log = File::options().append(true).open(&path).expect("the file");
    let mut k = 200_000;
    while child.try_wait().expect("a child").is_none() {
        writeln!(log, "{:.2},0.5", 0.01 * f64::from(k)).expect("written");
        k += 1;
    }
    let said = child.wait_with_output().expect("ends");
    let err = String::from_utf8_lossy(&said.stderr);
    let told = err.contains("changed while it was read") || err.contains("ends in the middle of line");
    assert!(said.status.code() == Some(2) && told, "{err}");
}
