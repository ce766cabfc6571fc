//! What a planned run decided, beside what was promised.

use super::{chance, rounded};
use crate::table::short;
use phisindy_design::DECIDED;
use phisindy_gap::{Gap, Step};
use phisindy_learn::FoundParameter;
use serde_json::{Value, json};

/// What `next --out` kept of the best run.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The run in words.
    run: String,
    promise: Promise,
}

#[derive(Clone, Debug, PartialEq)]
enum Promise {
    /// With which probability one of so many models is decided, and which one led.
    Decides { probability: f64, models: usize, first: (String, f64) },
    /// Numbers, their units, and their half-widths before and after (in these units).
    Narrows(Vec<(String, String, f64, f64)>),
}

/// What became of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// In a sentence.
    pub sentence: String,
    pub(crate) json: Value,
}

impl Plan {
    /// The plan of a `result.json` that `next --out` wrote.
    ///
    /// ```
    /// use phisindy_report::Plan;
    /// let text = r#"{ "aim": "narrow", "runs": [ { "words": "tone of ± 4 N", "numbers": [
    ///     { "name": "Fc", "unit": "N", "half_width": 0.02, "promised": 0.004 } ] } ] }"#;
    /// assert!(Plan::read(text).is_some());
    /// assert!(Plan::read("{}").is_none());
    /// ```
    pub fn read(text: &str) -> Option<Plan> {
        let all: Value = serde_json::from_str(text).ok()?;
        let best = all.get("runs")?.get(0)?;
        let of = |value: &Value| Some((value["name"].as_str()?.to_owned(), value["probability"].as_f64()?));
        let promise = match all.get("aim")?.as_str()? {
            "separate" => {
                let models = all.get("models")?.as_array()?;
                let probability = best["decides"].as_f64()?;
                Promise::Decides { probability, models: models.len(), first: of(models.first()?)? }
            }
            _ => {
                let number = |value: &Value| {
                    let [name, unit] = ["name", "unit"].map(|key| value[key].as_str().map(str::to_owned));
                    Some((name?, unit?, value["half_width"].as_f64()?, value["promised"].as_f64()?))
                };
                Promise::Narrows(best["numbers"].as_array()?.iter().map(number).collect::<Option<_>>()?)
            }
        };
        Some(Plan { run: best["words"].as_str()?.to_owned(), promise })
    }

    /// Beside the result of a search.
    pub fn beside_search(&self, found: &Gap) -> Outcome {
        let sure = found.steps.iter().filter_map(|step| step.probability).reduce(f64::min);
        self.beside((&model_name(&found.steps), sure), &found.parameters)
    }

    /// Beside the numbers of a fit.
    pub fn beside_fit(&self, found: &[FoundParameter]) -> Outcome {
        self.beside(("the identified model", None), found)
    }

    fn beside(&self, (name, now): (&str, Option<f64>), found: &[FoundParameter]) -> Outcome {
        let (told, json) = match &self.promise {
            Promise::Decides { probability, models, first } => {
                let decided = now.is_some_and(|p| p > DECIDED);
                let before =
                    if name == first.0 { format!(" ({} before)", chance(first.1)) } else { String::new() };
                let has = now.map_or("no probability".to_owned(), chance);
                let word = if decided { "decided" } else { "not decided" };
                let told = format!(
                    "promised one of {models} models above {DECIDED} with probability {}; {name} has {has} now{before}: {word}",
                    chance(*probability)
                );
                (
                    told,
                    json!({ "decides": probability, "model": name, "probability": now, "decided": decided }),
                )
            }
            Promise::Narrows(numbers) => {
                let now = numbers.iter().map(|(name, unit, before, promised)| {
                    let own = found.iter().find(|p| p.id.to_string() == *name);
                    let width = own.map(|p| 0.5 * (p.estimate.ci95.1 - p.estimate.ci95.0) / p.factor);
                    let has = width.map_or("is no number of this model".to_owned(), |w| format!("has ± {}", short(rounded(w))));
                    let [before_, promised_] = [before, promised].map(|x| short(rounded(*x)));
                    let words = format!("{name} {has} {unit}, promised ± {promised_} (± {before_} before)");
                    (words, json!({ "name": name, "unit": unit, "before": before, "promised": promised, "half_width": width }))
                });
                let (words, values): (Vec<String>, Vec<Value>) = now.unzip();
                (words.join("; "), json!({ "numbers": values }))
            }
        };
        let mut json = json;
        json["run"] = self.run.clone().into();
        Outcome { sentence: format!("the planned run ({}): {told}", self.run), json }
    }
}

/// What a model with these laws is called.
pub fn model_name(steps: &[Step]) -> String {
    let law = |step: &Step| format!("{} at {}", step.effect.entry.law.name, step.effect.place.at);
    let laws: Vec<String> = steps.iter().map(law).collect();
    if laws.is_empty() { "the model as it is".to_owned() } else { laws.join(" + ") }
}
