//! What a record says that is still growing: its motion, the missing force at each speed, whether that is enough.

use super::snapshot;
use crate::check::said;
use crate::columns::look;
use crate::folder::Working;
use phisindy::files::{Purpose, Request, load_text, spec_text};
use phisindy_import::Answers;
use phisindy_phys::Sources;
use phisindy_report::{Coverage, coverage};
use serde_json::{Value, json};
use std::io;
use std::path::Path;

/// The judgement of a file of the folder, by the model of a spec of it or by a draft. What is judged is a copy of its
/// newest stretch: the file itself changes while it is read.
pub(crate) fn of(
    folder: &Working,
    (name, spec): (&str, Option<&str>),
    request: &Request,
    place: &Path,
) -> Value {
    let copy = place.join(name);
    let snapshot = || -> io::Result<usize> {
        let (text, left_out) = snapshot::of(&folder.file(name).map_err(io::Error::other)?)?;
        std::fs::write(&copy, text)?;
        Ok(left_out)
    };
    let left_out = match snapshot() {
        Ok(left_out) => left_out,
        Err(why) => {
            return json!({ "words": format!("`{name}` cannot be judged: {why}"), "forces": [], "curves": [] });
        }
    };
    let seen = look(&copy, name, &Value::Null, &Answers::default());
    let told = |words: &str, forces: Vec<Value>| json!({ "words": words, "forces": forces, "curves": seen["preview"], "left_out": left_out });
    let text = match spec {
        Some(spec) => folder.file(spec).and_then(|path| spec_text(&path).map_err(|d| d.message)),
        None => seen["spec"].as_str().map(str::to_owned).ok_or_else(|| message(&seen["diagnostics"])),
    };
    let text = match text {
        Ok(text) => text,
        Err(why) => return told(&why, vec![]),
    };
    let request = &Request { data: Some(place.to_owned()), ..request.clone() };
    let (mut sources, mut found) = (Sources::default(), Vec::new());
    let by = folder.path().join(spec.unwrap_or("live.ron"));
    let Ok(loaded) = load_text(&by, text, request, Purpose::Gap, &mut sources, &mut found) else {
        return told(&message(&json!(said(&found, &sources, false))), vec![]);
    };
    let forces = coverage(&loaded.case.system, &loaded.records);
    let words = match forces.iter().find(|force| !force.is_enough()).or(forces.first()) {
        Some(force) => force.to_string(),
        None => "Move it: no speed is measured well enough to tell a force.".into(),
    };
    told(&words, forces.iter().map(force).collect())
}

fn force(of: &Coverage) -> Value {
    let node =
        |n: &phisindy_report::CoverageNode| json!([n.speed, n.force, n.half.is_finite().then_some(n.half)]);
    let nodes: Vec<Value> = of.nodes.iter().map(node).collect();
    json!({ "speed": of.speed.0, "speed_unit": of.speed.1, "unit": of.unit, "nodes": nodes, "enough": of.is_enough(), "words": of.to_string() })
}

/// The first mistake, in words.
fn message(diagnostics: &Value) -> String {
    diagnostics[0]["message"].as_str().unwrap_or("nothing has come yet").to_owned()
}
