//! What people see at a terminal, which `script` of util-linux stands for; pipes are tested everywhere else.

#![allow(missing_docs)]

use crate::common::{self, Scratch, program};
use std::process::{Command, Stdio};

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
    let out = script.output().ok()?;
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

    let plain = at_terminal(&run, false).expect("a terminal as before");
    let result = plain.split("identified").nth(1).expect("the result");
    assert!(!result.split("report:").next().unwrap_or("").contains("\u{1b}[1"), "NO_COLOR: {plain}");
    // A form that is asked for is given.
    let latex = at_terminal(&["run", "specs/case1a.ron", "--format", "latex"], true).expect("a terminal");
    assert!(latex.contains("\\dot{y}"), "{latex}");
}
