//! What it takes to repeat a result: fixed constants, spec, version, command, seed.

use super::page::{Page, block, paragraph};
use super::table::{Cell, code, in_unit, table, text};
use crate::input::{Input, Invocation};
use crate::markup::{Element, element};
use phisindy_phys::spec::ConstantSpec;
use phisindy_phys::unit::Unit;
use phisindy_phys::{Origin, Record};

/// Adds the sections at the end of every report.
pub(crate) fn add(page: &mut Page, input: Input<'_>, invocation: &Invocation) {
    page.section("Held constant", [constants(input), of_records(input)].into_iter().flatten());
    page.section("To repeat it", command(seeds(input, invocation), input.name, Some(input.text), invocation));
}

/// Version, command, seeds, and the spec as far as it could be read.
pub(crate) fn command(
    seeds: Option<Element>,
    spec: &str,
    text: Option<&str>,
    invocation: &Invocation,
) -> Vec<Element> {
    let words: Vec<String> = invocation.arguments.iter().map(|word| quoted(word)).collect();
    let version = paragraph(concat!("Written by phisindy ", env!("CARGO_PKG_VERSION"), "."));
    let hash = invocation.inputs.as_ref().map(|hash| {
        let words = "SHA-256 of spec, data, laws and version; `phisindy verify` makes the result again:";
        [paragraph(words), block(hash, "hash")]
    });
    let after = if invocation.assigned { ", every --set in it" } else { "" };
    let heading = element("h3").text(format!("{spec}{after}"));
    let command = block(&format!("phisindy {}", words.join(" ")), "command");
    let spec = text.map(|text| [heading, block(text, "spec")]);
    let hash = hash.into_iter().flatten();
    [version, command].into_iter().chain(seeds).chain(hash).chain(spec.into_iter().flatten()).collect()
}

/// A word quoted for a shell.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// The seeds of synthetic records.
fn seeds(input: Input<'_>, invocation: &Invocation) -> Option<Element> {
    let own = input.case.records.iter().filter_map(|plan| match &plan.origin {
        Origin::Synthetic(made) => Some(format!("{} of {}", made.seed, plan.name)),
        Origin::Csv(_) => None,
    });
    let own: Vec<String> = own.collect();
    let given = invocation.seed.map(|seed| format!("{seed}, given by --seed in place of the spec's"));
    (!own.is_empty()).then(|| paragraph(&format!("Seed: {}.", given.unwrap_or_else(|| own.join(", ")))))
}

/// Constants of the spec that are plain numbers, in its units.
fn constants(input: Input<'_>) -> Option<Element> {
    let row = |(name, value): &(String, f64)| {
        let given = input.spec.constants.iter().find(|(n, _)| n.value == *name).map(|(_, c)| c);
        let own = match given {
            Some(ConstantSpec::Number { unit, .. }) => unit.as_ref().map_or("", |u| u.value.as_str()),
            _ => "",
        };
        let factor = Unit::parse(own).map_or(1.0, |u| u.factor);
        vec![code(name), Cell::Number(value / factor), in_unit(own)]
    };
    let rows = input.case.system.constants.iter().map(row).collect();
    table("Constants", &["constant", "value", "unit"], rows)
}

/// Constants of the records, in SI.
fn of_records(input: Input<'_>) -> Option<Element> {
    let names = &input.case.system.record_constants;
    let of = |r: &Record| {
        let pairs = names.iter().zip(r.constants.clone());
        pairs
            .map(|((name, _), value)| vec![text(&r.name), code(name), Cell::Number(value)])
            .collect::<Vec<_>>()
    };
    table(
        "Constants of the records (SI)",
        &["record", "constant", "value"],
        input.records.iter().flat_map(of).collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn a_shell_reads_the_same_words() {
        assert_eq!(quoted("specs/case7.ron"), "specs/case7.ron");
        assert_eq!(quoted("unknown.y.candidates=[\"1\"]"), "'unknown.y.candidates=[\"1\"]'");
        assert_eq!(quoted("it's"), "'it'\\''s'");
    }
}
