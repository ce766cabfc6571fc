//! The result of the workflow for one set, compared with the truth.

use super::place::same_place;
use super::truth::{Hidden, Placed, Truth};
use serde_json::Value;
use std::collections::BTreeMap;

/// A value within this relative error is right.
const WITHIN: f64 = 0.05;
/// An interval of 95 % misses by this many half-widths once in ten thousand.
const FAR: f64 = 2.0;
/// What the program says where it has an answer.
const STATUS: &[&str] =
    &["nothing-missing", "explained", "described", "named", "unexplained", "undetermined", "contradictory"];

/// How the workflow named the effects of a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// The truth: nothing where nothing is hidden, unexplained where no law describes the effect.
    Right,
    /// Another description of the same force in this record.
    Equivalent,
    /// An effect where nothing is hidden.
    FalseAlarm,
    /// Anything else.
    Wrong,
    /// The program returned no result.
    Failed,
}

/// The marks of a set.
#[derive(Clone, Debug)]
pub(super) struct Mark {
    pub(super) verdict: Verdict,
    pub(super) status: String,
    /// The named effects as text.
    pub(super) named: String,
    /// Relative error of each value of a correctly named effect, by `law.parameter`.
    pub(super) errors: BTreeMap<String, f64>,
    /// Whether the data determine all of them: each 95 % interval ends within [`WITHIN`] of the value.
    pub(super) told: bool,
    /// The number of 95 % intervals, and of those that contain the truth.
    pub(super) intervals: (usize, usize),
    /// Whether one of these misses it by [`FAR`] half-widths or more.
    pub(super) far: bool,
    /// The final gap on the Validate record.
    pub(super) after: Option<f64>,
    pub(super) seconds: Option<f64>,
}

impl Mark {
    /// Whether all effects have the right names.
    pub(super) fn good(&self) -> bool {
        matches!(self.verdict, Verdict::Right | Verdict::Equivalent)
    }

    /// Whether all values are right; none if there is no value to compare.
    pub(super) fn values(&self) -> Option<bool> {
        (!self.errors.is_empty()).then(|| self.errors.values().all(|e| *e <= WITHIN))
    }
}

/// Compares a result of `gap --format json` with the truth.
pub(super) fn mark(truth: &Truth, result: &Value) -> Mark {
    let steps = steps(result);
    let word = |value: &Value| value.as_str().unwrap_or("").to_owned();
    let named: Vec<Placed> = steps.iter().map(|step| placed(step)).collect();
    let status = word(&result["status"]);
    let own = own(truth);
    let alike = |set: &Vec<Placed>| sorted(set) == sorted(&named);
    let verdict = match truth.kind.as_str() {
        _ if !STATUS.contains(&status.as_str()) => Verdict::Failed,
        "nothing" if !named.is_empty() => Verdict::FalseAlarm,
        "nothing" if status == "nothing-missing" => Verdict::Right,
        // No law is named; a formula is none of the catalogue.
        "outside" if matches!(status.as_str(), "unexplained" | "described") => Verdict::Right,
        "one" | "two" | "constant" if alike(&own) => Verdict::Right,
        "one" | "two" | "constant" if truth.alternatives.iter().any(alike) => Verdict::Equivalent,
        _ => Verdict::Wrong,
    };
    let mut mark = Mark {
        verdict,
        status,
        named: result["error"].as_str().map_or_else(|| words(&named), str::to_owned),
        errors: BTreeMap::new(),
        told: true,
        intervals: (0, 0),
        far: false,
        after: result["final"]["validate"].as_f64(),
        seconds: result["seconds"].as_f64(),
    };
    if verdict == Verdict::Right && matches!(truth.kind.as_str(), "one" | "two" | "constant") {
        for effect in &truth.effects {
            let same = |s: &&&Value| {
                word(&s["law"]) == effect.law && same_place(&word(&s["at"])) == same_place(&effect.at)
            };
            if let Some(step) = steps.iter().find(same) {
                values(effect, step, &mut mark);
            }
        }
    }
    mark
}

/// The steps of a result.
pub(super) fn steps(result: &Value) -> Vec<&Value> {
    result["steps"].as_array().map_or(vec![], |s| s.iter().collect())
}

/// Law and place of a step.
pub(super) fn placed(step: &Value) -> Placed {
    let word = |value: &Value| value.as_str().unwrap_or("").to_owned();
    Placed { law: word(&step["law"]), at: word(&step["at"]) }
}

/// Laws and places of the truth.
pub(super) fn own(truth: &Truth) -> Vec<Placed> {
    truth.effects.iter().map(|e| Placed { law: e.law.clone(), at: e.at.clone() }).collect()
}

/// A set of effects in words.
pub(super) fn words(set: &[Placed]) -> String {
    let one = |p: &Placed| format!("{} at {}", p.law, p.at);
    if set.is_empty() { "nothing".to_owned() } else { set.iter().map(one).collect::<Vec<_>>().join(" + ") }
}

pub(super) fn sorted(set: &[Placed]) -> Vec<(String, String)> {
    let mut all: Vec<(String, String)> = set.iter().map(|p| (p.law.clone(), same_place(&p.at))).collect();
    all.sort();
    all
}

/// Judges the values of one effect.
fn values(effect: &Hidden, step: &Value, mark: &mut Mark) {
    let truth = turned(effect, step["at"].as_str().unwrap_or(&effect.at));
    let estimate = |name: &str| step["parameters"][name]["value"].as_f64();
    for (name, &value) in &truth {
        let Some(have) = estimate(name) else { continue };
        let cyclic = name == "phase";
        // Angles differ by whole turns.
        let off = if cyclic { turn(have - value) } else { have - value };
        let size = if cyclic { 1.0 } else { value.abs().max(f64::MIN_POSITIVE) };
        if effect.law != "dead-zone" {
            mark.errors.insert(format!("{}.{name}", effect.law), off.abs() / size);
        }
        let ends = &step["parameters"][name]["ci95"];
        if let (Some(low), Some(high)) = (ends[0].as_f64(), ends[1].as_f64()) {
            let shift = value + off - have;
            mark.intervals.0 += 1;
            mark.told &= effect.law == "dead-zone" || 0.5 * (high - low) <= WITHIN * size;
            mark.intervals.1 += usize::from((low + shift..=high + shift).contains(&value));
            mark.far |= (0.5 * (low + high) + shift - value).abs() > FAR * 0.5 * (high - low);
        }
    }
    if effect.law == "dead-zone"
        && let (Some(ks), Some(gap)) = (estimate("ks"), estimate("gap"))
    {
        let want = truth["ks"] * truth["gap"];
        mark.errors.insert("dead-zone.ks*gap".to_owned(), (ks * gap - want).abs() / want.abs());
    }
}

/// The parameters for a place with the opposite sign.
fn turned(effect: &Hidden, at: &str) -> BTreeMap<String, f64> {
    let mut all = effect.parameters.clone();
    let spelled = |text: &str| text.replace(' ', "");
    if spelled(at) == spelled(&effect.at) {
        return all;
    }
    for name in ["f0", "k2", "F1"] {
        if let Some(x) = all.get_mut(name) {
            *x = -*x;
        }
    }
    if let (Some(p), Some(m)) = (all.get("Fp").copied(), all.get("Fm").copied()) {
        all.insert("Fp".to_owned(), m);
        all.insert("Fm".to_owned(), p);
    }
    if effect.law == "cogging"
        && let Some(phase) = all.get_mut("phase")
    {
        *phase = -*phase;
    }
    if effect.law == "harmonic-force"
        && let Some(phase) = all.get_mut("phase")
    {
        *phase += std::f64::consts::PI;
    }
    all
}

/// An angle between minus and plus half a turn.
fn turn(angle: f64) -> f64 {
    let whole = std::f64::consts::TAU;
    angle - whole * (angle / whole).round()
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::truth::Gaps;
    use super::*;

    type Told<'a> = (&'a str, &'a str, &'a [(&'a str, f64)]);

    pub(in super::super) fn truth(kind: &str, effects: &[Told<'_>]) -> Truth {
        let hidden = |(law, at, parameters): &Told<'_>| Hidden {
            law: (*law).to_owned(),
            at: (*at).to_owned(),
            parameters: parameters.iter().map(|(n, x)| ((*n).to_owned(), *x)).collect(),
            expression: String::new(),
        };
        Truth {
            kind: kind.to_owned(),
            effects: effects.iter().map(hidden).collect(),
            alternatives: vec![],
            noise: 0.02,
            sticks: false,
            stuck_share: 0.0,
            masses: 1,
            gap_before: Gaps { fit: 5.0, validate: 4.0 },
            gap_fitted: None,
            margin: None,
            nearest: String::new(),
            remainder: None,
            sigma: BTreeMap::new(),
            movable: BTreeMap::new(),
            rig: String::new(),
            samples: [10, 10],
            apart: None,
            shown: None,
            noise_kind: "white".to_owned(),
        }
    }

    fn read(text: &str) -> Value {
        serde_json::from_str(text).expect("JSON")
    }

    #[test]
    fn a_law_at_its_place_is_right_and_its_values_are_judged() {
        let t = truth("one", &[("coulomb", "v2-v1", &[("Fc", 1.0)])]);
        let m = mark(
            &t,
            &read(
                r#"{"status": "explained", "seconds": 2.5, "final": {"fit": 1.0, "validate": 1.01},
                    "steps": [{"law": "coulomb", "at": "v1-v2", "parameters": {"Fc": {"value": 1.04, "ci95": [1.01, 1.07]}}}]}"#,
            ),
        );
        assert_eq!(m.verdict, Verdict::Right);
        assert_eq!(m.values(), Some(true));
        assert_eq!(m.intervals, (1, 0));
        assert_eq!((m.after, m.seconds), (Some(1.01), Some(2.5)));
    }

    #[test]
    fn only_the_product_of_a_dead_zone_counts() {
        let t = truth("one", &[("dead-zone", "v", &[("ks", 100.0), ("gap", 0.01)])]);
        let m = mark(
            &t,
            &read(
                r#"{"status": "explained", "steps": [{"law": "dead-zone", "at": "v",
                    "parameters": {"ks": {"value": 50.0, "ci95": [0.0, 200.0]}, "gap": {"value": 0.0203, "ci95": [0.0, 1.0]}}}]}"#,
            ),
        );
        assert_eq!((m.values(), m.intervals), (Some(true), (2, 2)));
    }

    #[test]
    fn equivalents_count_and_other_places_do_not() {
        let mut t = truth("one", &[("asymmetric-coulomb", "v", &[("Fp", 1.0), ("Fm", 2.0)])]);
        let placed = |law: &str| Placed { law: law.to_owned(), at: "v".to_owned() };
        t.alternatives = vec![vec![placed("offset"), placed("coulomb")]];
        let both = r#"{"status": "explained", "steps": [{"law": "coulomb", "at": "v"}, {"law": "offset", "at": "v"}]}"#;
        assert_eq!(mark(&t, &read(both)).verdict, Verdict::Equivalent);
        assert_eq!(mark(&t, &read(&both.replace("\"v\"", "\"w\""))).verdict, Verdict::Wrong);
    }

    #[test]
    fn nothing_and_the_unexplained_have_marks_of_their_own() {
        let added = read(r#"{"status": "explained", "steps": [{"law": "coulomb", "at": "v"}]}"#);
        let quiet = read(r#"{"status": "nothing-missing", "steps": []}"#);
        let helpless = read(r#"{"status": "unexplained", "steps": []}"#);
        let (nothing, outside) = (truth("nothing", &[]), truth("outside", &[("smooth-bouc-wen", "v", &[])]));
        assert_eq!(mark(&nothing, &added).verdict, Verdict::FalseAlarm);
        assert_eq!(mark(&nothing, &quiet).verdict, Verdict::Right);
        assert_eq!(mark(&nothing, &helpless).verdict, Verdict::Wrong);
        assert_eq!(mark(&outside, &helpless).verdict, Verdict::Right);
        assert_eq!(mark(&outside, &added).verdict, Verdict::Wrong);
        assert_eq!(mark(&outside, &read(r#"{"status": "failed"}"#)).verdict, Verdict::Failed);
    }

    #[test]
    fn a_place_spelled_the_other_way_round_turns_one_sided_values() {
        let t = truth(
            "two",
            &[
                ("asymmetric-coulomb", "v1-v2", &[("Fp", 1.0), ("Fm", 2.0)]),
                ("harmonic-force", "v", &[("phase", 3.1)]),
            ],
        );
        let m = mark(
            &t,
            &read(
                r#"{"status": "explained", "steps": [
                    {"law": "asymmetric-coulomb", "at": "v2-v1", "parameters": {"Fp": {"value": 2.0}, "Fm": {"value": 1.0}}},
                    {"law": "harmonic-force", "at": "v", "parameters": {"phase": {"value": -3.1731853, "ci95": [-3.2, -3.1]}}}]}"#,
            ),
        );
        assert_eq!((m.verdict, m.values(), m.intervals), (Verdict::Right, Some(true), (1, 1)));
    }
}
