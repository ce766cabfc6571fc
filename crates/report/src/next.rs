//! The next run of a rig: what it would decide or narrow.

mod html;
mod json;
mod planned;
mod text;

pub use planned::{Outcome, Plan, model_name};

use crate::folder::{DRIVE, Folder, MOTION};
use crate::format::Format;
use crate::html::HtmlReport;
use crate::table::short;
use phisindy_compare::HALF_WIDTH_95;
use phisindy_design::{Aim, DECIDED, Design, Limits, Response, Rival, Run, Shape, step};

/// A quantity as the spec has it.
#[derive(Clone, Debug)]
pub struct QuantityShown {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// How many SI units this is.
    pub factor: f64,
}

impl QuantityShown {
    /// A value (SI) in its unit.
    fn written(&self, value: f64) -> String {
        format!("{} {}", short(rounded(value / self.factor)), self.unit).trim_end().to_owned()
    }
}

/// What a model predicts of the best run: each measured column, in the units of the spec, with its standard deviation.
#[derive(Clone, Debug)]
pub struct Predicted {
    /// For each column its values.
    pub mean: Vec<Vec<f64>>,
    /// For each column by how much they are uncertain.
    pub std_error: Vec<Vec<f64>>,
}

impl Predicted {
    /// Of a response that was measured in the units of the spec.
    pub fn of(response: &Response, columns: usize) -> Predicted {
        let column =
            |k: usize, of: &dyn Fn(usize) -> f64| (k..response.mean.len()).step_by(columns).map(of).collect();
        let spread = |i: usize| {
            response.spread.iter().chain(&response.starts).map(|s| s[i].powi(2)).sum::<f64>().sqrt()
        };
        let all = |of: &dyn Fn(usize) -> f64| (0..columns).map(|k| column(k, of)).collect();
        Predicted { mean: all(&|i| response.mean[i]), std_error: all(&spread) }
    }
}

/// The runs that were found for a spec.
#[derive(Clone, Debug)]
pub struct NextReport {
    /// What the spec is called.
    pub name: String,
    /// How its result ended.
    pub status: String,
    /// The probability that none of the models is right, where the result tells it.
    pub none: Option<f64>,
    /// What the run is to do.
    pub aim: Aim,
    /// Within what it stays.
    pub limits: Limits,
    /// The runs.
    pub design: Design,
    /// What each model predicts of the best one.
    pub predicted: Vec<Predicted>,
    /// The measured columns.
    pub columns: Vec<QuantityShown>,
    /// The inputs.
    pub inputs: Vec<QuantityShown>,
    /// The numbers of the first model that were found.
    pub numbers: Vec<QuantityShown>,
    /// Each setting of the constants in words; the first is none.
    pub settings: Vec<String>,
    /// What a careful reader should know.
    pub doubts: Vec<String>,
    /// The models, the most probable one first.
    pub rivals: Vec<Rival>,
}

impl NextReport {
    /// The result in one of its forms, with an end of line.
    pub fn written(&self, format: Format) -> String {
        match format {
            Format::Json => json::object(self).to_string() + "\n",
            of_text => of_text.lines(text::lines(self)),
        }
    }

    /// The files that `next --out` keeps; `arguments` are the words of the command line.
    pub fn folder(&self, arguments: &[String]) -> Folder {
        let mut all = Folder::default();
        all.add(crate::RESULT, serde_json::to_string_pretty(&json::object(self)).unwrap_or_default() + "\n");
        all.add(DRIVE, self.drive());
        all.add(MOTION, self.motion());
        all.add_report(self.html(arguments));
        all
    }

    /// The report with its picture.
    pub fn html(&self, arguments: &[String]) -> HtmlReport {
        html::page(self, arguments).html()
    }

    /// The best run in a sentence.
    pub fn sentence(&self) -> String {
        let best = &self.design.runs[0];
        let run = self.described(best);
        let first = &self.rivals[0];
        match &self.aim {
            Aim::Separate => format!(
                "{run}: one of {} models gets above {DECIDED} with probability {} ({} has {} now)",
                self.rivals.len(),
                chance(best.separation.decides),
                first.name,
                chance(first.probability),
            ),
            Aim::Narrow(_) | Aim::NarrowAll => {
                let told: Vec<String> = self.asked().map(|k| self.narrowing(best, k)).collect();
                format!("{run}: {}", told.join(", "))
            }
        }
    }

    /// Places, among the numbers of the first model, of those that are to be narrowed.
    fn asked(&self) -> impl Iterator<Item = usize> {
        let wanted = |name: &str| match &self.aim {
            Aim::Narrow(one) => one == name,
            _ => true,
        };
        let first = &self.rivals[0];
        (0..first.numbers.len()).filter(move |&k| wanted(&first.numbers[k].0) && first.std_error(k) > 0.0)
    }

    fn shown(&self, number: usize) -> (QuantityShown, f64) {
        let name = &self.rivals[0].numbers[number].0;
        let own = self.numbers.iter().find(|q| q.name == *name).cloned();
        let shown = own.unwrap_or(QuantityShown { name: name.clone(), unit: String::new(), factor: 1.0 });
        (shown, HALF_WIDTH_95 * self.rivals[0].std_error(number))
    }

    /// `Fc from ± 0.02 to ± 0.004 N`.
    fn narrowing(&self, run: &Run, number: usize) -> String {
        let (shown, before) = self.shown(number);
        let after = HALF_WIDTH_95 * run.narrowed.std_errors[number];
        format!(
            "{} from ± {} to ± {}",
            shown.name,
            short(rounded(before / shown.factor)),
            shown.written(after)
        )
    }

    /// A run in words: `tone of ± 0.4 N at 2.1 Hz in F, 6 s from rest`.
    fn described(&self, run: &Run) -> String {
        let seconds = short(rounded(run.trial.duration()));
        let setting = match run.trial.setting {
            0 => String::new(),
            k => format!(", with {}", self.settings[k]),
        };
        let Some(w) = run.trial.waveform else {
            let at: Vec<String> = run
                .trial
                .start
                .iter()
                .map(|(name, value)| {
                    let shown = self.columns.iter().find(|q| q.name == *name);
                    format!(
                        "{name} = {}",
                        shown.map_or_else(|| short(rounded(*value)), |q| q.written(*value))
                    )
                })
                .collect();
            return format!("let go at {}, {seconds} s{setting}", at.join(", "));
        };
        let input = &self.inputs[w.input];
        let [f, end] = [w.frequency, w.end].map(|f| short(rounded(f)));
        let at = match w.shape {
            Shape::Tone | Shape::Triangle => format!("at {f} Hz"),
            Shape::Steps => format!("two in a cycle of {f} Hz"),
            Shape::Bursts => format!("of two cycles at {f} Hz"),
            Shape::Sweep | Shape::Multisine => format!("from {f} to {end} Hz"),
        };
        let about = if w.middle == 0.0 { String::new() } else { format!("{} ", input.written(w.middle)) };
        let size = input.written(w.amplitude);
        format!(
            "{} of {about}± {size} {at} in {}, {seconds} s from rest{setting}",
            w.shape.name(),
            input.name
        )
    }

    /// What the drive of a record would do once more, and three times.
    fn controls(&self) -> impl Iterator<Item = (&'static str, &Run)> {
        let again = self.design.again.iter().map(|run| ("the first record's drive once more", run));
        again.chain(self.design.longer.iter().map(|run| ("the same three times", run)))
    }

    fn drive(&self) -> String {
        let trial = self.design.runs[0].trial.sampled(step(&self.rivals[0].like));
        let names = self.inputs.iter().map(heading);
        let mut out = std::iter::once("t_s".to_owned()).chain(names).collect::<Vec<_>>().join(",") + "\n";
        for i in 0..trial.samples {
            let values = trial.inputs.iter().zip(&self.inputs).map(|(values, q)| values[i] / q.factor);
            out += &row(std::iter::once(trial.step * i as f64).chain(values));
        }
        out
    }

    fn motion(&self) -> String {
        let trial = &self.design.runs[0].trial;
        let names = (1..=self.predicted.len()).flat_map(|k| {
            let of = move |q: &QuantityShown| {
                [format!("{} of model {k}", heading(q)), format!("± {}", heading(q))]
            };
            self.columns.iter().flat_map(of)
        });
        let mut out = std::iter::once("t_s".to_owned()).chain(names).collect::<Vec<_>>().join(",") + "\n";
        for i in 0..trial.samples {
            let values = self.predicted.iter().flat_map(|p| {
                p.mean
                    .iter()
                    .zip(&p.std_error)
                    .flat_map(move |(mean, error)| [mean[i], HALF_WIDTH_95 * error[i]])
            });
            out += &row(std::iter::once(trial.step * i as f64).chain(values));
        }
        out
    }
}

fn heading(q: &QuantityShown) -> String {
    if q.unit.is_empty() { q.name.clone() } else { format!("{} [{}]", q.name, q.unit) }
}

fn row(values: impl Iterator<Item = f64>) -> String {
    values.map(|x| format!("{x:.8e}").parse().unwrap_or(x).to_string()).collect::<Vec<_>>().join(",") + "\n"
}

/// Three digits.
fn rounded(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}

/// A probability, as a sentence has it.
fn chance(p: f64) -> String {
    match p {
        p if p > 0.995 => "above 0.99".to_owned(),
        p if p < 0.005 => "below 0.01".to_owned(),
        p => format!("{p:.2}"),
    }
}
