//! Specs of the repository as cases and records, without the program.
#![allow(dead_code)] // not every test uses all of it

use phisindy_phys::{Case, Origin, Record, Sources, check, spec, splice};
use phisindy_sim::synthesize;

/// Reads `specs/NAME.ron`, applies `sets`, and makes its synthetic records.
pub(crate) fn load(name: &str, sets: &[(&str, &str)]) -> (Case, Vec<Record>) {
    let path = format!("{}/../../specs/{name}.ron", env!("CARGO_MANIFEST_DIR"));
    load_text(&std::fs::read_to_string(path).unwrap(), sets)
}

/// The same from a text.
pub(crate) fn load_text(text: &str, sets: &[(&str, &str)]) -> (Case, Vec<Record>) {
    let case = prepare(text, sets);
    let records = case
        .records
        .iter()
        .map(|plan| match &plan.origin {
            Origin::Synthetic(truth) => {
                synthesize(plan, truth, &case.system, None, &|_| Err("no files here".into())).unwrap().0
            }
            Origin::Csv(_) => panic!("a measured record"),
        })
        .collect();
    (case, records)
}

/// A text with `sets` applied, read and checked.
pub(crate) fn prepare(text: &str, sets: &[(&str, &str)]) -> Case {
    let mut text = text.to_owned();
    for (path, value) in sets {
        text = splice::set(&text, path, value).unwrap();
    }
    let mut sources = Sources::default();
    let id = sources.add("spec", text.clone());
    let (spec, _) = spec::read(&text, id).unwrap();
    let (case, _) = check(&spec, id).unwrap();
    case
}
