//! What no compiler says: a file of tests that no `main.rs` names would never run.

use crate::common::top;
use std::path::Path;

/// The names of the files of a folder with tests, and what its roots name.
fn left_out(folder: &Path, roots: &[&str]) -> Vec<String> {
    let text: String =
        roots.iter().map(|root| std::fs::read_to_string(folder.join(root)).expect("a root")).collect();
    let named =
        |file: &str| text.lines().any(|line| line == format!("mod {};", file.trim_end_matches(".rs")));
    let entries = std::fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").file_name());
    let files = entries.filter_map(|name| name.into_string().ok()).filter(|name| name.ends_with(".rs"));
    files.filter(|file| !roots.contains(&file.as_str()) && !named(file)).collect()
}

#[test]
fn every_file_of_tests_is_compiled() {
    for name in ["expr", "learn", "phys", "sim"] {
        let folder = top().join("crates").join(name).join("tests");
        assert_eq!(left_out(&folder, &["main.rs"]), Vec::<String>::new(), "{name}");
    }
    // The test of the page is one of its package, which names it.
    assert_eq!(left_out(&top().join("tests"), &["main.rs", "blind.rs"]), ["page.rs"]);
}
