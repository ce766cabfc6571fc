//! The tutorial, the newcomer's log and the guides are played: their commands run, their edits apply, their
//! outputs are what they

//! show.

#[allow(dead_code)] // each test uses its part
use crate::common::{self, program, top};
use std::path::{Path, PathBuf};

/// A block of code of a page.
#[derive(Debug)]
struct Block<'a> {
    /// What stands after the fence.
    kind: &'a str,
    /// The file that the line before names at its end, `name`:
    file: Option<&'a str>,
    lines: Vec<&'a str>,
}

fn blocks(text: &str) -> Vec<Block<'_>> {
    let (mut all, mut open, mut last) = (Vec::new(), None::<Block<'_>>, "");
    for line in text.lines() {
        match (&mut open, line.strip_prefix("```")) {
            (Some(_), Some(_)) => all.extend(open.take()),
            (Some(block), None) => block.lines.push(line),
            (None, Some(kind)) => {
                let file = last.strip_suffix("`:").and_then(|l| l.rsplit('`').next());
                open = Some(Block { kind, file, lines: vec![] });
            }
            (None, None) if !line.trim().is_empty() => last = line,
            _ => {}
        }
    }
    all
}

/// The words of a command; a part in single quotes is one.
fn words(command: &str) -> Vec<String> {
    let mut all = vec![String::new()];
    let mut quoted = false;
    for c in command.chars() {
        match c {
            '\'' => quoted = !quoted,
            ' ' if !quoted => all.push(String::new()),
            c => all.last_mut().expect("a word").push(c),
        }
    }
    all
}

/// Whether the lines are those that are shown, `...` standing for any.
fn shows(said: &str, shown: &[&str]) -> Result<(), String> {
    let mut rest = said.lines().map(str::trim_end).filter(|l| !l.is_empty()).peekable();
    let mut gap = false;
    for line in shown.iter().map(|l| l.trim_end()) {
        if line == "..." {
            gap = true;
            continue;
        }
        let found = if gap { rest.any(|l| l == line) } else { rest.next() == Some(line) };
        if !found {
            return Err(format!("`{line}` is not there (or not in its place) in:\n{said}"));
        }
        gap = false;
    }
    if gap || rest.peek().is_none() { Ok(()) } else { Err(format!("there is more than is shown:\n{said}")) }
}

fn edit(path: &Path, lines: &[&str]) {
    let mut text = std::fs::read_to_string(path).expect("the spec");
    for pair in lines.chunks(2) {
        let [old, new] = pair else { panic!("an edit is a line that goes and one that comes: {lines:?}") };
        let (old, new) = (old.strip_prefix('-').expect("goes"), new.strip_prefix('+').expect("comes"));
        assert!(text.contains(old), "`{old}` is not in:\n{text}");
        text = text.replacen(old, new, 1);
    }
    std::fs::write(path, text).expect("the spec");
}

/// Plays a page of `docs` in a folder of its own with the data file of this path; edits are of `spec`. How
/// many commands it had.
fn play(page: &str, data: &Path, spec: &str) -> usize {
    let folder: PathBuf = Path::new(env!("CARGO_TARGET_TMPDIR")).join(page);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::copy(data, folder.join(data.file_name().expect("a file"))).expect("the data");
    let text = std::fs::read_to_string(top().join("docs").join(page)).expect("the page");
    let commands = typed(&blocks(&text), &folder, spec);
    pictures(page, &folder, &text);
    commands
}

/// The pictures of the pages: the page, what its commands left, and the picture in `docs/tutorial`. With the
/// variable PHISINDY_FIGURES the tests make them again: `PHISINDY_FIGURES=1 PHISINDY_DATA=DIR cargo test -p
/// phisindy-cli tutorial`.
const PICTURES: &[(&str, &str, &str)] = &[
    ("tutorial.md", "first/figures/residual-1.svg", "residual.svg"),
    ("tutorial.md", "found/figures/gap.svg", "gap.svg"),
    ("tutorial.md", "found/figures/effect-1.svg", "stribeck.svg"),
    ("tutorial.md", "found/figures/motion-1.svg", "motion.svg"),
    ("tutorial-rig.md", "found/figures/gap.svg", "rig-gap.svg"),
    ("tutorial-rig.md", "found/figures/motion-1.svg", "rig-motion.svg"),
];

/// Each picture that a page shows is one that its commands make.
fn pictures(page: &str, folder: &Path, text: &str) {
    for (_, made, picture) in PICTURES.iter().filter(|(of, _, _)| *of == page) {
        assert!(text.contains(&format!("(tutorial/{picture})")), "{page} does not show {picture}");
        let svg = std::fs::read(folder.join(made)).unwrap_or_else(|e| panic!("{page}: {made}: {e}"));
        if std::env::var_os("PHISINDY_FIGURES").is_some() {
            std::fs::write(top().join("docs/tutorial").join(picture), svg).expect("the picture");
        }
    }
}

/// Types the commands of these blocks in a folder. How many they are.
fn typed(blocks: &[Block<'_>], folder: &Path, spec: &str) -> usize {
    let mut commands = 0;
    for block in blocks {
        match (block.kind, block.file) {
            ("diff", _) => edit(&folder.join(spec), &block.lines),
            ("ron" | "xml", Some(file)) => {
                let path = folder.join(file);
                std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
                std::fs::write(path, block.lines.join("\n")).expect("a file");
            }
            ("console", _) => {
                let (command, shown) = block.lines.split_first().expect("a command");
                let words = words(command.strip_prefix("$ phisindy ").expect("a command of this program"));
                let mut run = program(&words.iter().map(String::as_str).collect::<Vec<_>>());
                let output = run.current_dir(folder).output().expect("the program starts");
                let (out, err) =
                    (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
                // A first model may be one that the data do not determine.
                let due = if out.contains("% undetermined: ") { 1 } else { 0 };
                assert_eq!(output.status.code(), Some(due), "{command}\n{out}{err}");
                // What only goes to standard error is shown where there is nothing else.
                let said = if out.is_empty() || words[0] == "new" { &err } else { &out };
                shows(said, shown).unwrap_or_else(|why| panic!("{command}: {why}"));
                commands += 1;
            }
            // A part of the spec.
            ("text", _) => {
                let text = std::fs::read_to_string(folder.join(spec)).expect("the spec");
                for line in &block.lines {
                    assert!(text.contains(line), "`{line}` is not in:\n{text}");
                }
            }
            // What is done before the program is there.
            ("sh", _) => {}
            other => panic!("a block of an unknown kind: {other:?}"),
        }
    }
    commands
}

#[test]
fn the_tutorial_is_as_it_says() {
    let commands = play("tutorial.md", &top().join("docs/tutorial/rig.csv"), "rig.ron");
    assert_eq!(commands, 6);
}

#[test]
fn the_guides_are_as_they_say() {
    let rig = top().join("docs/tutorial/rig.csv");
    assert_eq!(play("guides/own-law.md", &rig, "rig.ron"), 3);
    assert_eq!(play("guides/accelerometer.md", &top().join("docs/guides/accelerometer.csv"), "rig.ron"), 3);
    assert_eq!(play("guides/loads.md", &rig, "loads.ron"), 1);
    assert_eq!(play("guides/mechanism.md", &rig, "rail.ron"), 3);
    assert_eq!(play("guides/editors.md", &rig, "rig.ron"), 3);
}

/// Its data are other people's: it is played where `PHISINDY_DATA` names their folder.
#[test]
fn the_first_ten_minutes_are_as_they_say() {
    const FILE: &str = "frame_stickslip_250g.csv";
    let Some(folder) = common::measured(FILE) else { return };
    let commands = play("tutorial-rig.md", &folder.join(FILE), "frame.ron");
    assert!(commands > 6, "{commands}");
}

/// The first thing that a reader sees: `...` ends a line that is shortened.
#[test]
fn the_first_command_of_the_readme_prints_what_it_shows() {
    let text = std::fs::read_to_string(top().join("README.md")).expect("the README");
    const START: &str = "$ phisindy ";
    let all = blocks(&text);
    let first = all.iter().find(|b| b.lines.first().is_some_and(|l| l.starts_with(START))).expect("it");
    let (command, shown) = first.lines.split_first().expect("a command");
    let words = words(&command[START.len()..]);
    let said = common::phisindy(&words.iter().map(String::as_str).collect::<Vec<_>>()).out;
    let all: Vec<&str> = said.lines().collect();
    let mut rest = all.as_slice();
    for line in shown.iter().filter(|line| **line != "...") {
        let start = line.split("...").next().unwrap_or(line);
        let at = rest.iter().position(|l| l.starts_with(start) && (line.contains("...") || l == line));
        rest = &rest
            [at.unwrap_or_else(|| panic!("`{line}` is not there (or not in its place) in:\n{said}")) + 1..];
    }
    assert!(shown.len() > 6, "{shown:?}");
}

/// What follows it: from the bundled file to the name of the law.
#[test]
fn the_minute_of_the_readme_is_as_it_says() {
    let folder: PathBuf = Path::new(env!("CARGO_TARGET_TMPDIR")).join("readme");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(folder.join("docs/tutorial")).expect("a folder");
    std::fs::copy(top().join("docs/tutorial/rig.csv"), folder.join("docs/tutorial/rig.csv"))
        .expect("the data");
    let text = std::fs::read_to_string(top().join("README.md")).expect("the README");
    let mut all = blocks(&text);
    all.retain(|b| b.lines.first().is_some_and(|l| l.starts_with("$ phisindy ") && !l.contains("specs/")));
    assert_eq!(typed(&all, &folder, "rig.ron"), 2);
}

#[test]
fn what_is_shown_must_be_said() {
    assert!(shows("a\nb\nc\n", &["a", "...", "c"]).is_ok());
    assert!(shows("a\nb\nc\n", &["a", "c"]).is_err());
    assert!(shows("a\nb\nc\n", &["...", "d"]).is_err());
    assert!(shows("a\nb\nc\n", &["a"]).is_err());
}
