//! What the program said of a world, beside what is there: the one place that decides what is right.
//!
//! A *description* is the set of laws at places that is there, or another one that is the same force (or reading) in these
//! records: those of [`Truth::alternatives`]. For a force of no catalogue it is also any set of named laws that holds all but
//! 5 % of what is missing along the record not used, with the numbers that were found.
//! * A named law at its place is right if a description has it.
//! * Where one law at its place is found, another one that the records cannot tell from it is that answer too.
//! * Pushes are right if in each record one of them lasts while the hidden pulse is above half of its height, and none acts at
//!   another time or place.
//! * A formula (`described`) is right if its forces hold all but 10 % of what is missing there.
//! * "None of these" is right where what was found is no description and something is hidden.
//! * A verdict with exit 0 is right if its laws are a description (`named`: a part of one), and no interval of a number misses by
//!   twice its half-width. Anything else with exit 0 is wrong. A verdict with exit 1 is honest.

use crate::hidden::formula::WRONG;
use crate::hidden::mark::{Mark, Verdict, mark, own, placed, sorted, steps};
use crate::hidden::rivals::NEAR;
use crate::hidden::truth::{Placed, Truth};
use serde_json::Value;

/// How a verdict stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standing {
    Right,
    Honest,
    Wrong,
    /// There is no verdict, or not in time.
    Failed,
}

/// A statement with the probability that was said of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Said {
    pub(super) probability: f64,
    pub(super) right: bool,
}

/// An answer that was compared.
#[derive(Clone, Debug)]
pub(super) struct Answer {
    pub(super) standing: Standing,
    /// Whether its laws are what is hidden, whatever the verdict.
    pub(super) whole: bool,
    pub(super) mark: Mark,
    /// Of each law at its place.
    pub(super) laws: Vec<Said>,
    /// Of a force without a form.
    pub(super) none: Option<Said>,
    /// The error of its forces, where that was asked.
    pub(super) error: Option<f64>,
}

/// Compares an answer with the truth. `error` is that of its forces, rms over rms of what is missing along the record not used.
pub(super) fn answer(truth: &Truth, result: &Value, error: Option<f64>) -> Answer {
    let mark = mark(truth, result);
    let all = steps(result);
    let found: Vec<Placed> = all.iter().map(|step| placed(step)).collect();
    let named = sorted(&found);
    let hides = truth.kind != "nothing";
    let formula = all.iter().any(|step| step["law"] == "discovered");
    let near = truth.kind == "outside" && !formula && error.is_some_and(|error| error <= NEAR);
    let descriptions: Vec<Vec<(String, String)>> = std::iter::once(&own(truth))
        .filter(|own| !own.is_empty())
        .chain(&truth.alternatives)
        .map(|set| sorted(set))
        .chain(near.then(|| named.clone()))
        .collect();
    let same = |d: &Vec<(String, String)>| {
        let [step] = &all[..] else { return false };
        let rivals = step["rivals"].as_array().into_iter().flatten().filter(|r| r["same"] == true);
        rivals.map(|rival| sorted(&[placed(rival)])).any(|rival| rival == *d)
    };
    let whole = if hides { descriptions.iter().any(|d| *d == named || same(d)) } else { named.is_empty() };
    let part = !named.is_empty() && descriptions.iter().any(|d| named.iter().all(|n| d.contains(n)));
    let holds = error.is_some_and(|error| error <= WRONG);
    let standing = match mark.status.as_str() {
        _ if mark.verdict == Verdict::Failed => Standing::Failed,
        "unexplained" | "undetermined" | "contradictory" => Standing::Honest,
        _ if mark.far => Standing::Wrong,
        "nothing-missing" if !hides => Standing::Right,
        "explained" if hides && whole => Standing::Right,
        "named" if part || holds_pulse(truth, result) => Standing::Right,
        "described" if holds => Standing::Right,
        _ => Standing::Wrong,
    };
    let said = |step: &Value| {
        let law = &sorted(&[placed(step)])[0];
        let formula = step["law"] == "discovered";
        let one = |d: &Vec<(String, String)>| d.contains(law) || same(d);
        let right = if formula { holds } else { descriptions.iter().any(one) };
        Some(Said { probability: step["probability"].as_f64()?, right })
    };
    let none = result["none"].as_f64().filter(|_| mark.verdict != Verdict::Failed);
    let none = none.map(|probability| Said { probability, right: hides && !whole && !holds });
    let laws =
        if standing == Standing::Failed { vec![] } else { all.iter().filter_map(|s| said(s)).collect() };
    Answer { standing, whole, mark, laws, none, error }
}

/// Whether the pushes of an answer are a pulse that is hidden.
fn holds_pulse(truth: &Truth, result: &Value) -> bool {
    let [pulse] = &truth.effects[..] else { return false };
    let number = |name: &str| pulse.parameters.get(name).copied();
    let (Some(at), Some(width), "pulse-force") = (number("T"), number("s"), pulse.law.as_str()) else {
        return false;
    };
    // exp(-z^2) is one half.
    let half = width * 2.0_f64.ln().sqrt();
    let mut records = result["records"].as_array().into_iter().flatten();
    let pushes: Vec<&Value> = result["pushes"].as_array().into_iter().flatten().collect();
    let (from, to) = (|p: &Value| p["from"].as_f64(), |p: &Value| p["to"].as_f64());
    let in_it = |p: &&Value| from(p) <= Some(at - half) && to(p) >= Some(at + half);
    let beside = |p: &&Value| to(p) < Some(at - 3.0 * width) || from(p) > Some(at + 3.0 * width);
    let here = |p: &&Value| p["at"] == pulse.at.as_str();
    records.all(|r| pushes.iter().any(|p| p["record"] == r["record"] && in_it(p)))
        && !pushes.is_empty()
        && pushes.iter().all(|p| here(p) && !beside(p))
}

/// What is hidden, in tables.
pub(super) fn class(truth: &Truth) -> &'static str {
    let law = truth.effects.first().map_or("", |e| e.law.as_str());
    let sensor = law.starts_with("sensor-") || law.starts_with("input-");
    match truth.kind.as_str() {
        "nothing" => "nothing",
        "two" => "two laws",
        "constant" => "a changed constant",
        "one" if sensor => "a fault of a sensor or input",
        "one" => "a law",
        _ if law.ends_with("-sensor") => "a sensor's fault of no catalogue",
        _ => "a force of no catalogue",
    }
}

/// The truth and what was said of it, on two lines.
pub(super) fn told(set: &str, truth: &Truth, answer: &Answer) -> String {
    let numbers = |e: &crate::hidden::truth::Hidden| {
        let all: Vec<String> = e.parameters.iter().map(|(n, x)| format!("{n} {x:e}")).collect();
        format!("{} at {} ({})", e.law, e.at, all.join(", "))
    };
    let hidden: Vec<String> = truth.effects.iter().map(numbers).collect();
    let hidden = if hidden.is_empty() { "nothing".to_owned() } else { hidden.join(" + ") };
    let apart = truth.apart.map_or(String::new(), |a| format!(", {:.1} % apart from every law", 100.0 * a));
    let shown = truth.shown.map_or(String::new(), |s| format!(" (chi square {s:.0})"));
    let fitted = truth.gap_fitted.map_or(String::new(), |g| format!(", gap of {g:.2} beside free constants"));
    let said: Vec<String> = answer.laws.iter().map(|s| format!("{:.3}", s.probability)).collect();
    let none = answer.none.map_or(String::new(), |s| format!(", none {:.3}", s.probability));
    let error = answer.error.map_or(String::new(), |e| format!(", forces off by {:.1} %", 100.0 * e));
    let far = if answer.mark.far { ", an interval misses" } else { "" };
    format!(
        "{set} {:?}: {hidden}{apart}{shown}{fitted}; {}, noise of {} {} %\n    said {}: {} [{}]{none}{error}{far}\n",
        answer.standing,
        truth.rig,
        truth.noise_kind,
        100.0 * truth.noise,
        answer.mark.status,
        answer.mark.named,
        said.join(", "),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hidden::mark::tests::truth;

    fn standing(truth: &Truth, result: &str, error: Option<f64>) -> Standing {
        answer(truth, &serde_json::from_str(result).expect("JSON"), error).standing
    }

    const STEP: &str = r#"{"law": "coulomb", "at": "v1-v2", "probability": 0.97, "parameters": {"Fc": {"value": 1.04, "ci95": [1.01, 1.07]}}}"#;

    #[test]
    fn a_verdict_is_right_where_it_names_what_is_there() {
        let one = truth("one", &[("coulomb", "v2-v1", &[("Fc", 1.0)])]);
        let two = truth("two", &[("coulomb", "v2-v1", &[("Fc", 1.0)]), ("viscous", "v1", &[("dc", 2.0)])]);
        let said = |status: &str| format!(r#"{{"status": "{status}", "steps": [{STEP}], "none": 0.02}}"#);
        assert_eq!(standing(&one, &said("explained"), None), Standing::Right);
        assert_eq!(standing(&two, &said("explained"), None), Standing::Wrong);
        assert_eq!(standing(&two, &said("named"), None), Standing::Right);
        assert_eq!(standing(&truth("nothing", &[]), &said("named"), None), Standing::Wrong);
        assert_eq!(standing(&two, &said("undetermined"), None), Standing::Honest);
        assert_eq!(standing(&one, r#"{"status": "nothing-missing", "steps": []}"#, None), Standing::Wrong);
        assert_eq!(standing(&one, r#"{"status": "failed"}"#, None), Standing::Failed);
    }

    #[test]
    fn an_interval_that_misses_by_far_is_wrong() {
        let said = format!(r#"{{"status": "explained", "steps": [{STEP}]}}"#);
        // The half-width is 0.03: 0.99 is less than two of them away, 0.97 more.
        for (fc, due) in [(0.99, Standing::Right), (0.97, Standing::Wrong)] {
            let one = truth("one", &[("coulomb", "v2-v1", &[("Fc", fc)])]);
            assert_eq!(standing(&one, &said, None), due, "{fc}");
        }
    }

    #[test]
    fn a_force_of_no_catalogue_is_none_of_these_or_a_formula_that_holds() {
        let mut outside = truth("outside", &[("tanh-damper", "v", &[])]);
        let formula = r#"{"status": "described", "none": 0.3, "steps": [{"law": "discovered", "at": "v", "probability": 0.9}]}"#;
        assert_eq!(standing(&outside, formula, Some(0.04)), Standing::Right);
        assert_eq!(standing(&outside, formula, Some(0.2)), Standing::Wrong);
        assert_eq!(standing(&outside, formula, None), Standing::Wrong);
        let law = r#"{"status": "explained", "none": 0.3, "steps": [{"law": "coulomb", "at": "v", "probability": 0.9}]}"#;
        let of = |truth: &Truth, text: &str| answer(truth, &serde_json::from_str(text).expect("JSON"), None);
        let compared = of(&outside, law);
        assert_eq!(compared.standing, Standing::Wrong);
        assert_eq!(compared.laws, [Said { probability: 0.9, right: false }]);
        assert_eq!(compared.none, Some(Said { probability: 0.3, right: true }));
        // A law that holds all but 5 % of it, as it was found or as it is there.
        let of_formula = answer(&outside, &serde_json::from_str(formula).expect("JSON"), Some(0.04));
        assert!(of_formula.laws[0].right && !of_formula.whole);
        let near = answer(&outside, &serde_json::from_str(law).expect("JSON"), Some(0.04));
        assert_eq!((near.standing, near.laws[0].right), (Standing::Right, true));
        let far = answer(&outside, &serde_json::from_str(law).expect("JSON"), Some(0.06));
        assert_eq!((far.standing, far.laws[0].right), (Standing::Wrong, false));
        outside.alternatives = vec![vec![Placed { law: "coulomb".into(), at: "v".into() }]];
        let compared = of(&outside, law);
        assert_eq!(compared.standing, Standing::Right);
        assert_eq!(compared.none, Some(Said { probability: 0.3, right: false }));
    }
}
