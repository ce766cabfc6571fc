//! The reference is current: it names the fields that the program knows.

use crate::common::{Scratch, phisindy, top};

fn reference() -> String {
    std::fs::read_to_string(top().join("docs/reference.md")).expect("the reference")
}

/// The first column of the table under a heading.
fn documented(text: &str, owner: &str) -> Vec<String> {
    let part =
        text.split(&format!("### `{owner}`\n")).nth(1).unwrap_or_else(|| panic!("no part for {owner}"));
    let part = part.split("\n#").next().unwrap_or(part);
    let rows = part.lines().filter_map(|l| l.strip_prefix("| `")?.split('`').next());
    rows.map(str::to_owned).collect()
}

/// The fields of a law that the program allows.
fn allowed_in_laws(text: &str) -> Vec<String> {
    let scratch = Scratch::new("reference-laws");
    std::fs::create_dir_all(scratch.path("laws")).expect("a folder");
    std::fs::write(scratch.path("laws/own.ron"), text).expect("a law");
    let said = phisindy(&["laws", "--laws", &scratch.path("laws")]).err;
    let list = said.split("allowed: ").nth(1).unwrap_or_else(|| panic!("{said}"));
    list.lines().next().expect("a line").split(", ").map(str::to_owned).collect()
}

#[test]
fn every_field_of_a_law_is_in_the_reference_and_no_other() {
    let text = reference();
    let laws = [
        ("a law", "(wrong: 1)"),
        ("a parameter of a law", "(parameters: { \"k\": (wrong: 1) })"),
        ("an internal state", "(internal: { \"z\": (wrong: 1) })"),
        ("screen", "(screen: (wrong: 1))"),
    ];
    for (owner, law) in laws {
        let (mut have, mut want) = (documented(&text, owner), allowed_in_laws(law));
        have.sort();
        want.sort();
        assert_eq!(have, want, "{owner}");
    }
}

/// The fields that the program allows, from what it says of one that it does not know.
fn allowed(spec: &str) -> Vec<String> {
    let scratch = Scratch::new("reference");
    let path = scratch.path("case.ron");
    std::fs::write(&path, spec).expect("a spec");
    let said = phisindy(&["check", &path]).err;
    let at = said.find("unknown field").unwrap_or_else(|| panic!("{said}"));
    let list = said[at..].split("allowed: ").nth(1).unwrap_or_else(|| panic!("{said}"));
    list.lines().next().expect("a line").split(", ").map(str::to_owned).collect()
}

#[test]
fn every_field_is_in_the_reference_and_no_other() {
    let text = reference();
    let case = |constants: &str, unknown: &str, data: &str, more: &str| {
        format!(
            "(constants: {{ {constants} }}, states: {{ \"x\": \"m\" }}, known: {{ \"x\": \"0\" }}, unknown: {{ {unknown} }}, data: [{data}], {more})"
        )
    };
    let record = |inside: &str| case("", "", &format!("Synthetic({inside})"), "");
    let input = |kind: &str| record(&format!("inputs: {{ \"u\": {kind}(wrong: 1) }}"));
    let specs = [
        ("the spec", case("", "", "", "wrong: 1")),
        ("a movable constant", case("\"k\": (value: 1.0, wrong: 1)", "", "", "")),
        ("Find", case("\"k\": Find(wrong: 1)", "", "", "")),
        ("an unknown part", case("", "\"x\": (wrong: 1)", "", "")),
        ("Csv", case("", "", "Csv(wrong: 1)", "")),
        ("Table", case("", "", "Table(wrong: 1)", "")),
        ("a stream", case("", "", "Table(streams: { \"x\": (wrong: 1) })", "")),
        ("Arrays", case("", "", "Arrays(wrong: 1)", "")),
        ("Synthetic", record("wrong: 1")),
        ("a sensor", record("sensors: { \"x\": (wrong: 1) }")),
        ("Jonswap", input("Jonswap")),
        ("Multisine", input("Multisine")),
        ("File", input("File")),
        ("learn", case("", "", "", "learn: (wrong: 1)")),
    ];
    for (owner, spec) in specs {
        let (mut have, mut want) = (documented(&text, owner), allowed(&spec));
        have.sort();
        want.sort();
        assert_eq!(have, want, "{owner}");
    }
}

/// Each example of a law is accepted by the program.
#[test]
fn the_laws_of_the_reference_are_laws() {
    let text = reference();
    let scratch = Scratch::new("reference-examples");
    std::fs::create_dir_all(scratch.path("laws")).expect("a folder");
    let mut names = Vec::new();
    for part in text.split(".ron`:\n\n```ron\n").collect::<Vec<_>>().windows(2) {
        let name = part[0].rsplit('`').next().expect("a name");
        let law = part[1].split("```").next().expect("a law");
        std::fs::write(scratch.path(&format!("laws/my-{name}.ron")), law).expect("a law");
        names.push(format!("my-{name}"));
    }
    let said = phisindy(&["laws", "--laws", &scratch.path("laws")]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(
        names.len() == 2 && names.iter().all(|name| said.out.contains(name.as_str())),
        "{names:?}: {}",
        said.out
    );
}

/// The fields under a heading that must be there.
fn needed(text: &str, owner: &str) -> Vec<String> {
    let part =
        text.split(&format!("### `{owner}`\n")).nth(1).unwrap_or_else(|| panic!("no part for {owner}"));
    let rows = part.split("\n#").next().unwrap_or(part).lines().filter(|l| l.ends_with("| **needed** |"));
    rows.filter_map(|l| l.strip_prefix("| `")?.split('`').next().map(str::to_owned)).collect()
}

/// What the program misses in something that is empty: `the field X of OWNER is missing`.
fn missed(said: &str, owner: &str) -> Vec<String> {
    let end = format!("` of {owner} is missing");
    said.lines()
        .filter_map(|l| Some(l.strip_prefix("error: the field `")?.strip_suffix(&end)?.to_owned()))
        .collect()
}

#[test]
fn fields_that_must_be_there_are_marked_in_the_reference() {
    let text = reference();
    let scratch = Scratch::new("reference-needed");
    // What a hint lacks beside its columns is told once there are some.
    let laws =
        [r#"(parameters: { "k": () }, internal: { "z": () }, screen: ())"#, r#"(screen: (columns: ["v"]))"#];
    let mut said = String::new();
    for (k, law) in laws.iter().enumerate() {
        let folder = scratch.path(&format!("laws-{k}"));
        std::fs::create_dir_all(&folder).expect("a folder");
        std::fs::write(format!("{folder}/own.ron"), law).expect("a law");
        said += &phisindy(&["laws", "--laws", &folder]).err;
    }
    let inputs = r#"inputs: { "u": Jonswap(), "w": Multisine(), "z": File() }"#;
    let spec = format!(
        r#"(constants: {{ "k": (unit: "m"), "c": Find(unit: "m") }}, outputs: {{ "a": () }},
            data: [Csv(), Table(), Arrays(), Synthetic(), Synthetic({inputs}, truth: {{}}, start: {{}}, duration: 1.0, step: 0.1)])"#
    );
    std::fs::write(scratch.path("case.ron"), spec).expect("a spec");
    said += &phisindy(&["check", &scratch.path("case.ron")]).err;
    let owners = [
        ("the spec", "the spec"),
        ("an output", "an output"),
        ("a movable constant", "a movable constant"),
        ("Find", "`Find`"),
        ("Csv", "`Csv`"),
        ("Table", "`Table`"),
        ("Arrays", "`Arrays`"),
        ("Synthetic", "`Synthetic`"),
        ("Jonswap", "`Jonswap`"),
        ("Multisine", "`Multisine`"),
        ("File", "`File`"),
        ("a law", "a law"),
        ("a parameter of a law", "a parameter of a law"),
        ("an internal state", "an internal state"),
        ("screen", "`screen`"),
    ];
    for (owner, word) in owners {
        let mut missed = missed(&said, word);
        // The program asks for the data after everything else is there.
        if owner == "the spec" {
            missed.push("data".to_owned());
        }
        let (mut have, want) = (needed(&text, owner), &mut missed);
        have.sort();
        want.sort();
        want.dedup();
        assert_eq!(have, *want, "{owner}: {said}");
    }
}

/// The rows of the tables are those of the table of fields, in its order and its words.
#[test]
fn the_reference_says_of_each_field_what_editors_say() {
    use phisindy_phys::fields::{self, Absent, Group};
    let text = reference();
    let groups: &[&Group] = &[
        &fields::SPEC,
        &fields::ENERGY,
        &fields::IMPACT,
        &fields::STRUCTURE,
        &fields::POINT,
        &fields::OUTPUT,
        &fields::MOVABLE,
        &fields::FIND,
        &fields::UNKNOWN,
        &fields::CSV,
        &fields::TABLE,
        &fields::STREAM,
        &fields::ARRAYS,
        &fields::SYNTHETIC,
        &fields::SENSOR,
        &fields::JONSWAP,
        &fields::MULTISINE,
        &fields::FILE,
        &fields::LEARN,
        &fields::LAW,
        &fields::PARAMETER,
        &fields::INTERNAL,
        &fields::SCREEN,
    ];
    let headings = text.lines().filter(|line| line.starts_with("### `")).count();
    assert_eq!(headings, groups.len());
    for group in groups {
        let heading = format!("### `{}`\n", group.owner.trim_matches('`'));
        let part = text.split(&heading).nth(1).unwrap_or_else(|| panic!("no {heading}"));
        let part = part.split("\n#").next().unwrap_or(part);
        let rows: Vec<&str> = part.lines().filter(|line| line.starts_with("| `")).collect();
        let due: Vec<String> = group
            .fields
            .iter()
            .map(|field| {
                let absent = match field.3 {
                    Absent::Needed | Absent::Without(_) => "**needed**",
                    Absent::Is(what) => what,
                };
                format!("| `{}` | {} | {absent} |", field.0, field.about().replace('|', "\\|"))
            })
            .collect();
        assert_eq!(rows, due, "{heading}");
    }
}
