//! What a folder holds after results were put into it.

use super::*;
use tempfile::TempDir;

/// A result called `name`; one that was stopped, or only a failure, says so.
fn result(name: &str, worth: Worth) -> Folder {
    let head = "<html><meta name=\"generator\" content=\"phisindy 0\">";
    let mut files = vec![("figures/a.svg".to_owned(), name.to_owned())];
    if worth != Worth::Nothing {
        let stopped = worth == Worth::Part;
        files.push((RESULT.to_owned(), format!("{{\"title\":\"{name}\",\"stopped\":{stopped}}}\n")));
    }
    files.push((REPORT.to_owned(), format!("{head}{name}")));
    Folder { files, lacks: None }
}

fn put(path: &Path, name: &str, worth: Worth) -> Kept {
    let folder = ResultFolder::prepare(path, None, false).expect("a folder for a result");
    folder.put(&result(name, worth)).expect("written")
}

/// Names and texts of all files below a folder, in order.
fn all(folder: &Path) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder").flatten() {
        let (path, name) = (entry.path(), entry.file_name().into_string().expect("UTF-8"));
        if path.is_dir() {
            found.extend(all(&path).into_iter().map(|(inner, text)| (format!("{name}/{inner}"), text)));
        } else {
            found.push((name, fs::read_to_string(path).expect("text")));
        }
    }
    found.sort();
    found
}

fn titles(top: &TempDir) -> Vec<String> {
    let texts = all(top.path()).into_iter().filter(|(name, _)| name.ends_with(".svg"));
    texts.map(|(name, text)| format!("{}: {text}", name.split('/').next().unwrap_or_default())).collect()
}

#[test]
fn an_earlier_result_is_kept_beside_and_nothing_is_mixed() {
    let top = tempfile::tempdir().expect("a folder");
    let out = top.path().join("out");
    assert_eq!(put(&out, "a", Worth::Whole), Kept { at: Some(out.clone()), earlier: None });
    fs::create_dir(out.join("laws"))
        .and_then(|()| fs::write(out.join("laws/discovered-1.ron"), "()"))
        .expect("a law");
    let earlier = top.path().join("out.1");
    assert_eq!(put(&out, "b", Worth::Whole), Kept { at: Some(out.clone()), earlier: Some(earlier.clone()) });
    assert!(earlier.join("laws/discovered-1.ron").exists() && !out.join("laws").exists());
    put(&out, "c", Worth::Whole);
    assert_eq!(titles(&top), ["out.1: a", "out.2: b", "out: c"]);
    let ours: Vec<_> = fs::read_dir(top.path()).expect("a folder").collect();
    assert_eq!(ours.len(), 3, "nothing else is left: {ours:?}");
}

#[test]
fn what_was_stopped_replaces_nothing_better() {
    let top = tempfile::tempdir().expect("a folder");
    let out = top.path().join("out");
    put(&out, "mistake", Worth::Nothing);
    // A report about mistakes is worth nothing once there is another one.
    assert_eq!(put(&out, "again", Worth::Nothing).earlier, None);
    put(&out, "part", Worth::Part);
    assert_eq!(titles(&top), ["out: part"]);
    put(&out, "whole", Worth::Whole);
    let beside = put(&out, "less", Worth::Part);
    assert_eq!(beside, Kept { at: Some(top.path().join("out.2")), earlier: None });
    assert_eq!(put(&out, "mistake", Worth::Nothing), Kept { at: None, earlier: None });
    assert_eq!(titles(&top), ["out.1: part", "out.2: less", "out: whole"]);
}

#[test]
fn other_files_are_refused_or_stay() {
    let top = tempfile::tempdir().expect("a folder");
    let out = top.path().join("out");
    put(&out, "a", Worth::Whole);
    for name in ["notes.txt", "figures/mine.png", "laws/mine.ron"] {
        fs::create_dir_all(folder_of(&out.join(name)))
            .and_then(|()| fs::write(out.join(name), "mine"))
            .expect("a file");
        let refused = ResultFolder::prepare(&out, None, false).expect_err("other files");
        assert!(matches!(&refused, FolderError::Occupied(why) if why.contains(name)), "{refused}");
        let kept = ResultFolder::prepare(&out, None, true)
            .expect("allowed")
            .put(&result("b", Worth::Whole))
            .expect("written");
        assert_eq!(fs::read_to_string(out.join(name)).expect("it stays"), "mine");
        assert!(!kept.earlier.expect("the result before").join(name).exists());
        fs::remove_file(out.join(name)).expect("removed");
    }
    // Somebody else's file of such a name is in the way, and is not lost.
    let own = top.path().join("own");
    fs::create_dir(&own).and_then(|()| fs::write(own.join("completed.ron"), "mine")).expect("a file");
    let earlier = put(&own, "a", Worth::Whole).earlier.expect("what was there");
    assert_eq!(fs::read_to_string(earlier.join("completed.ron")).expect("it"), "mine");
}

#[test]
fn the_spec_in_the_folder_stays_there() {
    let top = tempfile::tempdir().expect("a folder");
    let (out, spec) = (top.path().join("out"), top.path().join("out/rig.ron"));
    fs::create_dir(&out).and_then(|()| fs::write(&spec, "(1)")).expect("a spec");
    for expected in [None, Some("(1)")] {
        let folder = ResultFolder::prepare(&out, Some(&spec), false).expect("a folder");
        let kept = folder.put(&result("a", Worth::Whole)).expect("written");
        let earlier = kept.earlier.map(|folder| fs::read_to_string(folder.join("rig.ron")).expect("a copy"));
        assert_eq!(earlier.as_deref(), expected);
        assert_eq!(fs::read_to_string(&spec).expect("the spec"), "(1)");
    }
    let completed = out.join("completed.ron");
    fs::write(&completed, "(2)").expect("a spec");
    let refused = ResultFolder::prepare(&out, Some(&completed), true).expect_err("it would be replaced");
    assert!(refused.to_string().contains("holds the spec itself"), "{refused}");
}

#[test]
fn what_a_killed_program_left_is_removed_and_what_is_written_is_not() {
    let top = tempfile::tempdir().expect("a folder");
    let (dead, alive) = (top.path().join(".out.1.part"), top.path().join(".out.2.part"));
    for part in [&dead, &alive] {
        fs::create_dir(part).and_then(|()| fs::write(part.join(RESULT), "{")).expect("a part");
    }
    let lock = File::open(&alive).expect("a folder");
    lock.try_lock().expect("locked");
    put(&top.path().join("out"), "a", Worth::Whole);
    assert_eq!((dead.exists(), alive.exists()), (false, true));
}

#[test]
fn the_part_of_a_program_with_the_same_number_is_left() {
    let top = tempfile::tempdir().expect("a folder");
    let other = top.path().join(format!(".out.{}.part", std::process::id()));
    fs::create_dir(&other).and_then(|()| fs::write(other.join(RESULT), "{")).expect("a part");
    let lock = File::open(&other).expect("a folder");
    lock.try_lock().expect("locked");
    put(&top.path().join("out"), "a", Worth::Whole);
    assert!(other.join(RESULT).exists());
    let parts = |top: &Path| {
        let names = fs::read_dir(top).expect("a folder").flatten().map(|e| e.file_name());
        names.filter(|name| name.to_string_lossy().starts_with(".out.")).count()
    };
    // Two that write at the same time have a name each, and leave nothing.
    let out = top.path().join("out");
    let (one, two) = (new_folder(&out).expect("a part"), new_folder(&out).expect("a part"));
    remove_parts(&out);
    assert_eq!(parts(top.path()), 3);
    drop((one, two, lock));
    remove_parts(&out);
    assert_eq!(parts(top.path()), 0);
}

#[cfg(unix)]
#[test]
fn links_are_not_followed() {
    use std::os::unix::fs::symlink;
    let top = tempfile::tempdir().expect("a folder");
    let (elsewhere, out) = (top.path().join("elsewhere"), top.path().join("out"));
    fs::create_dir(&elsewhere).and_then(|()| symlink(&elsewhere, &out)).expect("a link");
    let refused = ResultFolder::prepare(&out, None, true).expect_err("a link");
    assert!(refused.to_string().contains("is a link to"), "{refused}");
    let inner = top.path().join("inner");
    fs::create_dir(&inner).and_then(|()| symlink(&elsewhere, inner.join("figures"))).expect("a link");
    let refused = ResultFolder::prepare(&inner, None, false).expect_err("a link in it");
    assert!(matches!(refused, FolderError::Occupied(_)), "{refused}");
    let forced = ResultFolder::prepare(&inner, None, true).expect("allowed");
    forced.put(&result("a", Worth::Whole)).expect("written");
    assert_eq!(all(&elsewhere), [], "nothing was written there");
}
