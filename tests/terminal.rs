//! What people see at a terminal, which `script` of util-linux stands for; pipes are tested everywhere else.

#![allow(missing_docs)]
#![cfg(target_os = "linux")]

use crate::common::{self, Scratch, program, skipped};
use std::io::{Read, Write};
use std::process::{Command, Stdio};

const NO_SCRIPT: &str = "there is no `script` of util-linux";

/// Runs a command line at a terminal of 120 columns; `None` where there is no `script`.
fn at_terminal(arguments: &[&str], colours: bool) -> Option<String> {
    let plain = program(arguments);
    let words = plain.get_args().map(|word| format!("'{}'", word.to_string_lossy()));
    let path = plain.get_program().to_string_lossy().into_owned();
    let line = [path].into_iter().chain(words).collect::<Vec<_>>().join(" ");
    let mut script = Command::new("script");
    script.args(["-qec", &format!("stty cols 120; {line}"), "/dev/null"]).current_dir(common::top());
    script.env_remove("NO_COLOR").env("TERM", "xterm").stdin(Stdio::null());
    if !colours {
        script.env("NO_COLOR", "1");
    }
    let out = script.output().inspect_err(|_| skipped(NO_SCRIPT)).ok()?;
    Some(String::from_utf8_lossy(&out.stdout).replace('\r', ""))
}

#[test]
fn a_terminal_gets_unicode_colours_a_plot_and_the_report_last() {
    let scratch = Scratch::new("terminal");
    let out = scratch.path("out");
    let run = ["run", "specs/case1a.ron", "--out", &out];
    let Some(said) = at_terminal(&run, true) else { return };
    assert!(said.contains("y\u{307}") && !said.contains("\\dot"), "{said}");
    assert!(said.contains("\u{1b}[1;32midentified") && said.contains(" ± "), "{said}");
    assert!(said.chars().any(|c| ('\u{2801}'..='\u{28ff}').contains(&c)), "a plot: {said}");
    let last = said.trim_end().lines().last().expect("a line").to_owned();
    assert!(last.ends_with("report.html"), "{last}");
    // What can be done with it stands above.
    for next in ["phisindy next ", "phisindy simulate ", "phisindy export "] {
        assert!(said.contains(next), "{next}: {said}");
    }

    let plain = at_terminal(&run, false).expect("a terminal as before");
    let result = plain.split("identified").nth(1).expect("the result");
    assert!(!result.split("report:").next().unwrap_or("").contains("\u{1b}[1"), "NO_COLOR: {plain}");
    // A form that is asked for is given.
    let latex = at_terminal(&["run", "specs/case1a.ron", "--format", "latex"], true).expect("a terminal");
    assert!(latex.contains("\\dot{y}"), "{latex}");
}

/// Titles and names of somebody else's spec, and of files, give no commands to a terminal.
#[test]
fn a_terminal_obeys_no_spec() {
    let scratch = Scratch::new("obeys");
    let case = std::fs::read_to_string(common::top().join("specs/case1a.ron")).expect("a spec");
    let case = case.replacen("title: \"", "title: \"\\u{1b}]0;mine\\u{7}\\u{9b}2J", 1);
    let case = case.replacen("Synthetic(", "Synthetic(name: \"one\\u{1b}[2J\", ", 1);
    std::fs::write(scratch.path("a.ron"), case).expect("a file");
    for command in ["run", "gap", "next"] {
        let said = at_terminal(&[command, &scratch.path("a.ron"), "--quiet"], true);
        let Some(said) = said else { return };
        let odd = ["\u{1b}]", "\u{1b}[2J", "\u{7}", "\u{9b}"];
        assert!(!odd.iter().any(|odd| said.contains(odd)), "{command}: {said:?}");
    }
    let name = scratch.path("a\u{1b}[2J.csv");
    std::fs::copy(common::top().join("docs/tutorial/rig.csv"), &name).expect("a file");
    let said = common::phisindy(&["new", &name, "--out", &scratch.path("b.ron")]);
    assert!(said.code == 0 && !said.err.contains('\u{1b}'), "{:?}", said.err);
}

#[test]
fn a_terminal_gets_the_sketch_of_a_model_that_is_checked_and_a_pipe_does_not() {
    let Some(said) = at_terminal(&["check", "specs/case5.ron"], false) else { return };
    for part in ["x₁, m₁ = 1 kg", "spring k₂ = 1 N/m to x₂", "friction to the ground, asked for"] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let quiet = at_terminal(&["check", "specs/case5.ron", "--quiet"], false).expect("a terminal as before");
    assert_eq!(quiet, "");
    let piped = program(&["check", "specs/case5.ron"]).output().expect("the program");
    assert_eq!(String::from_utf8_lossy(&piped.stdout), "");
}

/// The rows of a screen of `wide` columns after what a program wrote: new lines, returns, moves up and down,
/// erasing, and the wrap of a line that is full.
fn screen(said: &str, wide: usize) -> Vec<String> {
    let mut rows = vec![String::new()];
    let (mut row, mut column) = (0_usize, 0_usize);
    let mut rest = said.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            '\r' => column = 0,
            '\n' => row += 1,
            '\u{1b}' if rest.next_if_eq(&'[').is_some() => {
                let mut number = String::new();
                let last = loop {
                    match rest.next() {
                        Some(c) if !c.is_ascii_alphabetic() => number.push(c),
                        last => break last,
                    }
                };
                let count = number.parse().unwrap_or(1);
                match last {
                    Some('A') => row = row.saturating_sub(count),
                    Some('B') => row += count,
                    Some('K') => rows[row] = rows[row].chars().take(column).collect(),
                    _ => {}
                }
            }
            c if c.is_control() => {}
            c => {
                if column == wide {
                    (row, column) = (row + 1, 0);
                }
                rows.resize(rows.len().max(row + 1), String::new());
                let mut line: Vec<char> = rows[row].chars().collect();
                line.resize(line.len().max(column + 1), ' ');
                line[column] = c;
                rows[row] = line.into_iter().collect();
                column += 1;
            }
        }
        rows.resize(rows.len().max(row + 1), String::new());
    }
    rows
}

/// The `^C` that the terminal shows stands in the line of the progress, and goes with it.
#[test]
fn no_progress_stays_above_the_result_after_an_interrupt() {
    let path = program(&[]).get_program().to_string_lossy().into_owned();
    let line = format!("stty rows 24 cols 80; '{path}' gap specs/case4.ron");
    let mut script = Command::new("script");
    script.args(["-qec", &line, "/dev/null"]).current_dir(common::top()).env("TERM", "xterm");
    script.env("NO_COLOR", "1").stdin(Stdio::piped()).stdout(Stdio::piped());
    let Ok(mut child) = script.spawn() else { return skipped(NO_SCRIPT) };
    let (mut keys, mut out) = (child.stdin.take().expect("keys"), child.stdout.take().expect("a screen"));
    let (mut said, mut more) = (Vec::new(), [0; 4096]);
    let mut pressed = false;
    while let Ok(count @ 1..) = out.read(&mut more) {
        said.extend_from_slice(&more[..count]);
        // The line is drawn whole, to its end.
        if !pressed && said.ends_with(b" ") && String::from_utf8_lossy(&said).contains(" % ") {
            keys.write_all(b"\x03").expect("a key");
            pressed = true;
        }
    }
    child.wait().expect("an end");
    let said = String::from_utf8_lossy(&said);
    assert!(pressed && said.contains("^C"), "{said}");
    let rows = screen(&said, 80);
    assert!(!rows.iter().any(|row| row.contains("round 1:") || row.contains("^C")), "{rows:#?}");
}

/// Every user of a machine sees the arguments of a program.
#[test]
#[cfg(target_os = "linux")]
fn the_token_of_the_page_reaches_the_browser_in_a_file_that_only_its_user_reads() {
    use std::os::unix::fs::PermissionsExt;
    let scratch = Scratch::new("open-browser");
    let (browser, seen) = (scratch.path("xdg-open"), scratch.path("seen"));
    let text =
        format!("#!/bin/sh\n{{ echo \"$@\"; stat -c %a \"$1\"; cat \"$1\"; }} > '{seen}'\nkill -INT $PPID\n");
    std::fs::write(&browser, text).expect("written");
    std::fs::set_permissions(&browser, std::fs::Permissions::from_mode(0o755)).expect("to be run");
    std::fs::create_dir(scratch.path("work")).expect("made");
    let path = format!("{}:{}", scratch.path(""), std::env::var("PATH").unwrap_or_default());
    let program = program(&[]).get_program().to_string_lossy().into_owned();
    let mut script = Command::new("script");
    script
        .args(["-qec", &format!("'{program}' open '{}'", scratch.path("work")), "/dev/null"])
        .env("PATH", path);
    let Ok(out) = script.stdin(Stdio::null()).output() else { return };
    let said = String::from_utf8_lossy(&out.stdout);
    let url = said.split_whitespace().find(|word| word.starts_with("http://127.0.0.1:")).expect("an address");
    let seen = std::fs::read_to_string(seen).expect("the browser was started");
    let (arguments, rest) = seen.split_once('\n').expect("arguments");
    let token = url.trim_end_matches('/').rsplit('/').next().expect("a token");
    assert!(arguments.ends_with(".html") && !arguments.contains(token), "{arguments}");
    assert!(rest.starts_with("600\n") && rest.contains(&format!("url={url}\"")), "{rest}");
    assert_eq!(std::fs::read_dir(scratch.path("work")).expect("the folder").count(), 0, "nothing is left");
}
