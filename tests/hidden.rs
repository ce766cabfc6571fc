//! The blind sets for the gap workflow, and what scores them: a few sets of a fixed seed.

#![allow(missing_docs)]

use crate::common::{Scratch, blind, phisindy};
use serde_json::{Value, json};
use std::fs;
use std::path::PathBuf;

const SETS: usize = 10;

fn sets(scratch: &Scratch) -> Vec<PathBuf> {
    (0..SETS).map(|k| scratch.0.join(format!("{k:03}"))).collect()
}

fn made(name: &str) -> Scratch {
    let scratch = Scratch::new(name);
    let said = blind(&["hidden", "--out", &scratch.path(""), "--sets", "10", "--seed", "5"]);
    assert_eq!(said.code, 0, "{}", said.err);
    scratch
}

fn truth(set: &std::path::Path) -> Value {
    serde_json::from_str(&fs::read_to_string(set.join("truth.json")).expect("a truth")).expect("JSON")
}

#[test]
fn specs_of_blind_sets_are_clean_and_do_not_tell() {
    let scratch = made("hidden");
    for set in sets(&scratch) {
        let spec = set.join("spec.ron");
        let path = spec.to_str().expect("UTF-8");
        let said = phisindy(&["check", path, "--data", set.to_str().expect("UTF-8")]);
        assert_eq!((said.code, said.err), (0, format!("{path}: no mistakes\n")));
        let text = fs::read_to_string(&spec).expect("a spec");
        let truth = truth(&set);
        for effect in truth["effects"].as_array().expect("a list") {
            assert!(!text.contains(effect["law"].as_str().expect("a word")), "{path} names its law");
            // The stiffness of a dead zone is that of a spring that the model has.
            for (name, value) in
                effect["parameters"].as_object().expect("a map").iter().filter(|(n, _)| *n != "ks")
            {
                let value = value.as_f64().expect("a number");
                assert!(!text.contains(&format!("{value:?}")), "{path} holds {name} = {value}");
            }
        }
        let gap = truth["gap_before"]["validate"].as_f64().expect("a number");
        match truth["kind"].as_str() {
            Some("nothing") => assert!((0.9..1.1).contains(&gap), "{path}: {gap}"),
            _ => assert!((1.1..=130.0).contains(&gap), "{path}: {gap}"),
        }
    }
}

#[test]
fn a_seed_makes_the_same_sets_again() {
    let (one, two) = (made("hidden-one"), made("hidden-two"));
    for (a, b) in sets(&one).iter().zip(sets(&two)) {
        for entry in fs::read_dir(a).expect("a folder") {
            let name = entry.expect("an entry").file_name();
            let read = |folder: &PathBuf| fs::read(folder.join(&name)).expect("a file");
            assert!(read(a) == read(&b), "{}", name.display());
        }
    }
}

#[test]
fn the_score_takes_results_that_are_there_and_does_not_run_them_again() {
    let scratch = made("scored");
    for set in sets(&scratch) {
        let truth = truth(&set);
        let kind = truth["kind"].as_str().expect("a word");
        let step = |e: &Value| {
            let values = e["parameters"].as_object().expect("a map").iter();
            let found = values.map(|(n, x)| (n.clone(), json!({ "value": x, "ci95": [-1e30, 1e30] })));
            json!({ "law": e["law"], "at": e["at"], "parameters": found.collect::<serde_json::Map<_, _>>() })
        };
        let (status, steps) = match kind {
            "nothing" => ("nothing-missing", vec![]),
            "outside" => ("unexplained", vec![]),
            _ => ("explained", truth["effects"].as_array().expect("a list").iter().map(step).collect()),
        };
        let result = json!({ "status": status, "steps": steps, "final": { "fit": 1.0, "validate": 1.0 }, "seconds": 1.0 });
        fs::write(set.join("result.json"), result.to_string()).expect("written");
    }
    let folder = scratch.path("");
    let said = blind(&["score", "--out", &folder]);
    assert_eq!(said.code, 0, "{}", said.err);
    let all = said.out.lines().find(|l| l.starts_with("| all |")).expect("a row");
    assert!(all.starts_with("| all | 10 |") && all.contains("(100.0 %)"), "{all}");
    assert!(!said.out.contains("Wrong") && !said.out.contains("values:"), "{}", said.out);
    // One mistake is one line.
    let wrong = json!({ "status": "explained", "steps": [{ "law": "van-der-pol", "at": "nowhere" }], "seconds": 2.0 });
    fs::write(scratch.path("003/result.json"), wrong.to_string()).expect("written");
    let said = blind(&["score", "--out", &folder]);
    let lines: Vec<&str> = said.out.lines().filter(|l| l.starts_with("003 ")).collect();
    assert!(lines.len() == 1 && lines[0].contains("van-der-pol at nowhere"), "{}", said.out);
}

#[test]
fn a_known_part_with_one_thing_wrong_is_told_of() {
    let scratch = Scratch::new("wrong-physics");
    let said = blind(&["wrong", "--out", &scratch.path(""), "--sets", "2", "--seed", "4", "--quiet"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let cells = |name: &str| -> Vec<String> {
        let row = said.out.lines().find(|l| l.starts_with(&format!("| {name} |"))).expect("a row");
        row.split('|').map(|c| c.trim().to_owned()).collect()
    };
    let (wrong, right) = (cells("all of these"), cells("nothing is wrong"));
    assert!(wrong[2] == "2" && wrong[3] == "2", "{}", said.out);
    assert!(right[2] == "2" && right[3] == "0", "{}", said.out);
    // Whoever doubts a set runs its spec.
    let spec = scratch.path("000-stiffness.ron");
    let checked = phisindy(&["check", &spec]);
    assert_eq!(checked.code, 0, "{}", checked.err);
}

#[test]
fn calibrate_goes_on_from_answers_that_are_there() {
    let scratch = Scratch::new("calibrate");
    let folder = scratch.path("worlds");
    let of = |seed: &str| {
        blind(&["calibrate", "--out", &folder, "--sets", "2", "--seed", seed, "--quiet", "--patience", "1"])
    };
    // Answers that were kept are read, not asked for again.
    for k in 0..2 {
        let set = scratch.0.join(format!("worlds/{k:03}"));
        fs::create_dir_all(&set).expect("a folder");
        let hidden = json!({ "law": "coulomb", "at": "v", "parameters": { "Fc": 1.0 }, "expression": "" });
        let truth = json!({
            "kind": "one", "effects": [hidden], "alternatives": [], "noise": 0.01, "sticks": false, "stuck_share": 0.0, "masses": 1,
            "gap_before": { "fit": 2.0, "validate": 2.0 }, "gap_fitted": 2.0, "margin": null, "nearest": "", "remainder": null,
            "sigma": {}, "movable": {}, "rig": "a rig", "samples": [10, 10], "apart": null, "shown": null, "noise_kind": "white",
        });
        let law = ["coulomb", "viscous"][k];
        let step = json!({ "law": law, "at": "v", "probability": 0.995, "parameters": {} });
        let answer = json!({ "status": "explained", "steps": [step], "none": 0.01, "seconds": 1.0 });
        fs::write(set.join("truth.json"), truth.to_string()).expect("written");
        fs::write(set.join("result.json"), answer.to_string()).expect("written");
    }
    let said = of("3");
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(
        said.out.contains("| a law at its place | above 0.99 | 2 | 0.995 | 1 | 2 to 2 | no |"),
        "{}",
        said.out
    );
    assert!(said.out.contains("| all | 2 | 1 | 0 | 0 | 1 | 0 | - | 1 |"), "{}", said.out);
    assert!(said.out.contains("001 Wrong: coulomb at v"), "{}", said.out);
    // Worlds of another seed are not mixed with these.
    assert_eq!(of("4").code, 2);
}
