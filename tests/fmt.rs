//! `phisindy fmt` on files: what it rewrites, what it leaves, what it says.

#![allow(missing_docs)]

use crate::common::{Scratch, phisindy, program};
use std::io::Write;
use std::process::Stdio;

const UNORDERED: &str = "// A rig.\n(states:{\"x\":\"m\"}, /* none */ known:{\"x\":\"0\"},)";
const ORDERED: &str =
    "// A rig.\n(\n    states: { \"x\": \"m\" },\n    /* none */ known: { \"x\": \"0\" },\n)\n";

#[test]
fn files_are_put_in_order_and_mistakes_are_left_alone() {
    let scratch = Scratch::new("fmt");
    let write = |name: &str, text: &str| {
        std::fs::write(scratch.path(name), text).expect("a file");
        scratch.path(name)
    };
    let read = |name: &str| std::fs::read_to_string(scratch.path(name)).expect("a file");
    let (good, bad, wrong) =
        (write("good.ron", ORDERED), write("bad.ron", UNORDERED), write("wrong.ron", "(a: 1 b: 2)"));
    let said = phisindy(&["fmt", "--check", &good, &bad]);
    assert_eq!((said.code, said.out.as_str(), said.err.as_str()), (1, format!("{bad}\n").as_str(), ""));
    assert_eq!(read("bad.ron"), UNORDERED);
    let said = phisindy(&["fmt", &good, &wrong, &bad]);
    assert_eq!((said.code, said.out.as_str(), read("bad.ron").as_str()), (2, "", ORDERED));
    assert!(
        said.err.contains("expected a comma before `b`") && said.err.contains("wrong.ron:1:6"),
        "{}",
        said.err
    );
    assert_eq!(read("wrong.ron"), "(a: 1 b: 2)");
    assert_eq!(phisindy(&["fmt", "--check", &good, &bad]).code, 0);
    let said = phisindy(&["fmt", &scratch.path("none.ron")]);
    assert!(said.code == 2 && said.err.contains("cannot read the spec"), "{}", said.err);
    let left: Vec<_> =
        std::fs::read_dir(&scratch.0).expect("a folder").map(|e| e.expect("an entry").file_name()).collect();
    assert_eq!(left.len(), 3, "{left:?}");
}

#[test]
fn standard_input_goes_to_standard_output() {
    let piped = |arguments: &[&str], text: &str| {
        let mut child = program(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        child.stdin.take().expect("a pipe").write_all(text.as_bytes()).expect("a text");
        let output = child.wait_with_output().expect("it ends");
        (output.status.code(), String::from_utf8(output.stdout).expect("UTF-8"))
    };
    assert_eq!(piped(&["fmt", "-"], UNORDERED), (Some(0), ORDERED.to_owned()));
    assert_eq!(piped(&["fmt", "--check", "-"], UNORDERED), (Some(1), "-\n".to_owned()));
    assert_eq!(piped(&["fmt", "-"], "(a: "), (Some(2), String::new()));
}

#[cfg(unix)]
#[test]
fn a_link_stays_one_and_rights_stay() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let scratch = Scratch::new("fmt-link");
    let (file, link) = (scratch.path("rig.ron"), scratch.path("link.ron"));
    std::fs::write(&file, UNORDERED).expect("a file");
    std::fs::set_permissions(&file, PermissionsExt::from_mode(0o640)).expect("rights");
    symlink(&file, &link).expect("a link");
    assert_eq!(phisindy(&["fmt", &link]).code, 0);
    assert!(std::fs::symlink_metadata(&link).expect("it").is_symlink());
    assert_eq!(std::fs::read_to_string(&file).expect("a file"), ORDERED);
    assert_eq!(std::fs::metadata(&file).expect("it").permissions().mode() & 0o777, 0o640);
    // A hard link is the file under another name.
    let twin = scratch.path("twin.ron");
    std::fs::write(&file, UNORDERED).expect("a file");
    std::fs::hard_link(&file, &twin).expect("a link");
    assert_eq!(phisindy(&["fmt", &twin]).code, 0);
    assert_eq!(std::fs::read_to_string(&file).expect("a file"), ORDERED);
}
