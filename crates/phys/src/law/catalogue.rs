//! The laws that come with the program, and the entries of a catalogue.

use super::{Law, LawError};
use crate::text::diagnostic::{Diagnostic, SourceId};
use std::sync::Arc;

/// A law of a catalogue with its id.
#[derive(Clone, Debug)]
pub struct LawEntry {
    /// The name of its file.
    pub id: String,
    /// The text of its file.
    pub text: String,
    /// What it says.
    pub law: Arc<Law>,
}

impl LawEntry {
    /// Reads the text of a law.
    ///
    /// # Errors
    /// As [`Law::read`].
    pub fn read(id: &str, text: &str) -> Result<LawEntry, LawError> {
        Ok(LawEntry { id: id.to_owned(), text: text.to_owned(), law: Arc::new(Law::read(text)?) })
    }

    /// The same with the places of all mistakes.
    ///
    /// # Errors
    /// As [`Law::checked`].
    pub fn checked(id: &str, text: &str, source: SourceId) -> Result<LawEntry, Vec<Diagnostic>> {
        let law = Law::checked(text, source)?;
        Ok(LawEntry { id: id.to_owned(), text: text.to_owned(), law: Arc::new(law) })
    }
}

/// Id and text of each built-in law, in the order of the ids.
#[rustfmt::skip]
pub const BUILT_IN: &[(&str, &str)] = &[
    ("asymmetric-coulomb", include_str!("../../laws/asymmetric-coulomb.ron")),
    ("backlash", include_str!("../../laws/backlash.ron")),
    ("bilinear-damping", include_str!("../../laws/bilinear-damping.ron")),
    ("bilinear-stiffness", include_str!("../../laws/bilinear-stiffness.ron")),
    ("bouc-wen", include_str!("../../laws/bouc-wen.ron")),
    ("breakaway", include_str!("../../laws/breakaway.ron")),
    ("cogging", include_str!("../../laws/cogging.ron")),
    ("coulomb", include_str!("../../laws/coulomb.ron")),
    ("cubic-damping", include_str!("../../laws/cubic-damping.ron")),
    ("cubic-stiffness", include_str!("../../laws/cubic-stiffness.ron")),
    ("dead-zone", include_str!("../../laws/dead-zone.ron")),
    ("dieterich-ruina", include_str!("../../laws/dieterich-ruina.ron")),
    ("digressive-damping", include_str!("../../laws/digressive-damping.ron")),
    ("drifting-friction", include_str!("../../laws/drifting-friction.ron")),
    ("drifting-stiffness", include_str!("../../laws/drifting-stiffness.ron")),
    ("geared-stribeck", include_str!("../../laws/geared-stribeck.ron")),
    ("hanging-body", include_str!("../../laws/hanging-body.ron")),
    ("harmonic-force", include_str!("../../laws/harmonic-force.ron")),
    ("input-dead-band", include_str!("../../laws/input-dead-band.ron")),
    ("input-delay", include_str!("../../laws/input-delay.ron")),
    ("input-gain", include_str!("../../laws/input-gain.ron")),
    ("input-lag", include_str!("../../laws/input-lag.ron")),
    ("input-saturation", include_str!("../../laws/input-saturation.ron")),
    ("load-dependent-friction", include_str!("../../laws/load-dependent-friction.ron")),
    ("lugre", include_str!("../../laws/lugre.ron")),
    ("maxwell", include_str!("../../laws/maxwell.ron")),
    ("maxwell-slip", include_str!("../../laws/maxwell-slip.ron")),
    ("nonlinear-maxwell", include_str!("../../laws/nonlinear-maxwell.ron")),
    ("offset", include_str!("../../laws/offset.ron")),
    ("one-sided-stop", include_str!("../../laws/one-sided-stop.ron")),
    ("parametric-stiffness", include_str!("../../laws/parametric-stiffness.ron")),
    ("position-dependent-friction", include_str!("../../laws/position-dependent-friction.ron")),
    ("power-law-damping", include_str!("../../laws/power-law-damping.ron")),
    ("presliding", include_str!("../../laws/presliding.ron")),
    ("quadratic-drag", include_str!("../../laws/quadratic-drag.ron")),
    ("quadratic-stiffness", include_str!("../../laws/quadratic-stiffness.ron")),
    ("quintic-stiffness", include_str!("../../laws/quintic-stiffness.ron")),
    ("sensor-delay", include_str!("../../laws/sensor-delay.ron")),
    ("sensor-gain", include_str!("../../laws/sensor-gain.ron")),
    ("sensor-lag", include_str!("../../laws/sensor-lag.ron")),
    ("sensor-offset", include_str!("../../laws/sensor-offset.ron")),
    ("stiffness", include_str!("../../laws/stiffness.ron")),
    ("stribeck", include_str!("../../laws/stribeck.ron")),
    ("van-der-pol", include_str!("../../laws/van-der-pol.ron")),
    ("viscous", include_str!("../../laws/viscous.ron")),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// The table is the folder, and what the laws are is read off their graphs.
    #[test]
    fn the_folder_is_built_in_and_its_laws_are_what_they_are() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("laws");
        let mut files: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|e| e.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
            .collect();
        files.sort();
        assert_eq!(files, BUILT_IN.iter().map(|(id, _)| *id).collect::<Vec<_>>());
        let ids: Vec<&str> = BUILT_IN.iter().map(|(id, _)| *id).collect();
        for (id, text) in BUILT_IN {
            assert_eq!(Law::unknown_references(text, SourceId(0), &ids), [], "{id}");
        }
        let all: Vec<LawEntry> = BUILT_IN
            .iter()
            .map(|(id, text)| {
                LawEntry::checked(id, text, SourceId(0)).unwrap_or_else(|d| panic!("{id}: {d:?}"))
            })
            .collect();
        let those = |is: fn(&Law) -> bool| -> Vec<&str> {
            all.iter().filter(|e| is(&e.law)).map(|e| e.id.as_str()).collect()
        };
        assert_eq!(
            those(Law::sticks),
            [
                "asymmetric-coulomb",
                "breakaway",
                "coulomb",
                "dieterich-ruina",
                "drifting-friction",
                "geared-stribeck",
                "load-dependent-friction",
                "position-dependent-friction",
                "stribeck"
            ]
        );
        assert_eq!(those(|law| !law.static_levels().is_empty()), ["breakaway"]);
        assert_eq!(those(Law::has_clearance), ["dead-zone", "one-sided-stop"]);
        assert_eq!(
            those(Law::has_memory),
            [
                "backlash",
                "bouc-wen",
                "hanging-body",
                "input-lag",
                "lugre",
                "maxwell",
                "maxwell-slip",
                "nonlinear-maxwell",
                "presliding"
            ]
        );
        assert_eq!(those(|law| law.nodes().inertias.iter().any(Option::is_some)), ["hanging-body"]);
        assert_eq!(
            those(|law| law.acting().is_some()),
            ["input-dead-band", "input-gain", "input-lag", "input-saturation"]
        );
        assert_eq!(those(Law::is_input_gain), ["input-gain"]);
        // A curve is no line, no offset, and has no memory.
        let lines =
            ["stiffness", "viscous", "offset", "harmonic-force", "maxwell", "input-gain", "sensor-gain"];
        let curves = those(Law::is_curve);
        assert!(curves.contains(&"coulomb") && curves.contains(&"cubic-stiffness"), "{curves:?}");
        assert!(lines.iter().all(|id| !curves.contains(id)), "{curves:?}");
        assert_eq!(
            those(Law::is_hysteretic),
            ["backlash", "bouc-wen", "lugre", "maxwell-slip", "presliding"]
        );
        assert_eq!(
            those(Law::is_resistance),
            [
                "bilinear-damping",
                "cubic-damping",
                "digressive-damping",
                "power-law-damping",
                "quadratic-drag",
                "viscous"
            ]
        );
        assert_eq!(those(Law::is_of_time), ["harmonic-force"]);
        assert_eq!(those(Law::is_linear_spring), ["stiffness"]);
        assert_eq!(
            those(Law::is_spring),
            [
                "bilinear-stiffness",
                "cogging",
                "cubic-stiffness",
                "dead-zone",
                "drifting-stiffness",
                "one-sided-stop",
                "parametric-stiffness",
                "quadratic-stiffness",
                "quintic-stiffness",
                "stiffness"
            ]
        );
    }

    /// However it is spelled: spaces, a sign turned, `max` in place of `pos`.
    #[test]
    fn a_law_is_told_by_its_graph_not_by_its_spelling() {
        let law = |force: &str| {
            let text = format!(
                r#"(name: "L", roles: {{ "x": "m", "v": "m/s" }}, parameters: {{ "F": (unit: "N", within: (0.0, 1.0)), "g": (unit: "m", within: (0.0, 1.0)) }}, force: "{force}")"#
            );
            Law::read(&text).unwrap()
        };
        assert!(law("F * sgn (v)").sticks() && law("-F*sgn(-v)").sticks() && !law("F*sgn(x)").sticks());
        assert!(law("F*max(x-g, 0)").has_clearance() && !law("F*x*|x|").has_clearance());
        assert_eq!(law("F*dead(x, g)").linear_parameters(), [0]);
        assert_eq!(
            law("F*v + m*g").nodes().outside.iter().map(|(n, _)| n.as_str()).collect::<Vec<_>>(),
            ["m"]
        );
    }

    #[test]
    fn a_mistake_says_where_it_stands() {
        let said = |text: &str| LawEntry::read("l", text).unwrap_err().to_string();
        assert!(said(r#"(name: "L", force: "F*(")"#).starts_with("`force`: "));
        let need = r#"(name: "L", parameters: { "F": (unit: "N", within: (0.0, 1.0)) }, force: "F", needs: (positive: "F - G", because: "no"))"#;
        assert_eq!(said(need), "`needs`: the name `G` stands for nothing here");
    }
}
