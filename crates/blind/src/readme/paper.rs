//! Each case of the paper: its printed result, and the results of both methods with its own noise and seed.

use super::cases::{Chosen, common};
use crate::args::{Assignment, CaseArgs, Options};
use crate::markdown::{markdown, short};
use crate::program::Program;
use crate::progress::Progress;
use crate::synthetic::{Loaded, load_file};
use anyhow::Result;
use phisindy_learn::project;
use serde_json::Value;
use std::path::Path;

/// Without the event condition: the case, its equation, what the paper prints.
const WITHOUT: &[(&str, &str, &str)] = &[("1a", "y", "0.354, eq. (42)"), ("5", "y2", "0.389, eq. (66)")];

/// The tables; none if the user stopped it.
pub(super) fn table(
    cases: &[Chosen],
    args: &CaseArgs,
    program: &Program,
    options: &Options,
) -> Result<Option<String>> {
    let (mut noisy, mut clean, mut without) = (Vec::new(), Vec::new(), Vec::new());
    let progress = Progress::new("paper", cases.len(), options.quiet);
    for (printed, spec) in cases {
        let solved =
            |sets: &[(&str, &str)], method: &str| Solved::run(program, spec, args, sets, method, options);
        let Some(step) = solved(&[], "step")? else { return Ok(None) };
        let Some(trajectory) = solved(&[], "trajectory")? else { return Ok(None) };
        let Some(exact) = solved(&[("data.0.noise", "Relative(0.0)")], "step")? else {
            return Ok(None);
        };
        let truth = trajectory.truth();
        noisy.push(vec![
            printed.case.to_owned(),
            truth.clone(),
            printed.text.to_owned(),
            step.equations(&plain),
            trajectory.equations(&with_interval),
        ]);
        clean.push(vec![printed.case.to_owned(), truth.clone(), exact.equations(&plain)]);
        if let Some((_, state, text)) = WITHOUT.iter().find(|(case, ..)| *case == printed.case) {
            let dictionary = format!("unknown.{state}.candidates");
            let sets = [("contacts", "[]"), (dictionary.as_str(), "[\"1\"]")];
            let Some(alone) = solved(&sets, "step")? else { return Ok(None) };
            without.push(vec![printed.case.to_owned(), truth, (*text).to_owned(), alone.equations(&plain)]);
        }
        progress.step();
    }
    drop(progress);
    let mut out = String::from(
        "With the noise and the seed of the specs (relative noise of 10 %). Method step has the hyperparameters that the paper prints. `L` and `M` are the \
         logarithms of Dieterich-Ruina; the equations of two masses are separated by a semicolon.\n\n",
    );
    out += &markdown(
        &["case", "truth", "the paper prints", "method step", "method trajectory [95 % interval]"],
        &noisy,
    );
    if !without.is_empty() {
        out += "\nWithout the event condition (`contacts: []`), the dictionary reduced to the constant, method step:\n\n";
        out += &markdown(&["case", "truth", "the paper prints", "found"], &without);
    }
    out += "\nWithout noise, method step: what is wrong here is wrong with the one-step loss and its fixed cut-off.\n\n";
    out += &markdown(&["case", "truth", "found"], &clean);
    Ok(Some(out))
}

/// One run: the case with its truth, and the result of the program.
struct Solved {
    loaded: Loaded,
    outcome: Result<Value, String>,
}

impl Solved {
    /// Runs a spec; none if the user stopped it.
    fn run(
        program: &Program,
        spec: &Path,
        args: &CaseArgs,
        sets: &[(&str, &str)],
        method: &str,
        options: &Options,
    ) -> Result<Option<Solved>> {
        let new = sets.iter().map(|(path, value)| Assignment::new(path, value));
        let sets: Vec<Assignment> = args.sets.iter().cloned().chain(new).collect();
        let loaded = load_file(spec, &sets, args.seed)?;
        let mut command = program.command();
        command.arg("run").arg(spec).args(["--format", "json", "--quiet", "--method", method]);
        command.args(common(&sets, args.seed, options));
        let output = program.output(&mut command, None)?;
        Ok(output.map(|output| {
            let outcome = serde_json::from_str(&output.out).map_err(|_| output.reason(spec));
            Solved { loaded, outcome }
        }))
    }

    fn truth(&self) -> String {
        let system = &self.loaded.case.system;
        match project(&self.loaded.case, &self.loaded.records) {
            Ok(truth) => {
                // The projection rounds.
                let term = |(&term, &value): (&usize, &f64)| {
                    let term = &system.terms[term];
                    let state = system.states[term.state].name.clone();
                    Term { state, candidate: term.candidate.clone(), value, text: short(value.abs()) }
                };
                self.sums(&truth.terms.iter().zip(&truth.coefficients).map(term).collect::<Vec<_>>())
            }
            Err(why) => why.to_string(),
        }
    }

    fn equations(&self, print: &dyn Fn(&Estimate) -> String) -> String {
        let result = match &self.outcome {
            Ok(result) => result,
            Err(why) => return format!("fails: {why}"),
        };
        let mut terms = Vec::new();
        for equation in result["equations"].as_array().into_iter().flatten() {
            for term in equation["terms"].as_array().into_iter().flatten() {
                let estimate = Estimate::of(term);
                let word = |value: &Value| value.as_str().unwrap_or_default().to_owned();
                terms.push(Term {
                    state: word(&equation["state"]),
                    candidate: word(&term["candidate"]),
                    value: estimate.value,
                    text: print(&estimate),
                });
            }
        }
        let sums = self.sums(&terms);
        match result["reason"].as_str() {
            None => sums,
            Some(why) => format!("{sums} (rejected: {why})"),
        }
    }

    /// Sums of terms, one for each equation that has a dictionary.
    fn sums(&self, terms: &[Term]) -> String {
        let system = &self.loaded.case.system;
        let states = (0..system.states.len()).filter(|&k| system.terms.iter().any(|t| t.state == k));
        let one = |state: usize| {
            let mut sum = String::new();
            for term in terms.iter().filter(|term| term.state == system.states[state].name) {
                sum.push_str(match (sum.is_empty(), term.value < 0.0) {
                    (true, true) => "-",
                    (true, false) => "",
                    (false, true) => " - ",
                    (false, false) => " + ",
                });
                sum.push_str(&term.text);
                let name = symbol(&term.candidate);
                if name != "1" {
                    sum.push(' ');
                    sum.push_str(&name);
                }
            }
            if sum.is_empty() { "nothing".to_owned() } else { sum }
        };
        states.map(one).collect::<Vec<_>>().join("; ")
    }
}

/// A term of an equation, its coefficient also in words.
struct Term {
    state: String,
    candidate: String,
    value: f64,
    text: String,
}

/// A coefficient as the program's JSON holds it.
struct Estimate {
    value: f64,
    std_error: f64,
    ci95: (f64, f64),
}

impl Estimate {
    /// JSON has no infinities: null means unbounded.
    fn of(term: &Value) -> Estimate {
        let number = |value: &Value, missing: f64| value.as_f64().unwrap_or(missing);
        Estimate {
            value: number(&term["coefficient"], f64::NAN),
            std_error: number(&term["std_error"], f64::INFINITY),
            ci95: (number(&term["ci95"][0], f64::NEG_INFINITY), number(&term["ci95"][1], f64::INFINITY)),
        }
    }
}

/// The paper's letters for the logarithms of Dieterich-Ruina, `L` and `M`, with the number of the velocity.
fn symbol(candidate: &str) -> String {
    let logarithm = |before: &str, after: &str| {
        let velocity = candidate.strip_prefix(before)?.strip_suffix(after)?;
        velocity.strip_prefix('y').map(str::to_owned)
    };
    if let Some(number) = logarithm("ln((|", "|+eps)/V)") {
        format!("L{number}")
    } else if let Some(number) = logarithm("ln(c+V/(|", "|+eps))") {
        format!("M{number}")
    } else {
        candidate.replace('*', " ")
    }
}

/// With as many digits as the paper prints.
fn plain(e: &Estimate) -> String {
    format!("{:.3}", e.value.abs())
}

/// Two digits of the error.
fn with_interval(e: &Estimate) -> String {
    let digits =
        if e.std_error > 0.0 && e.std_error.is_finite() { 1.0 - e.std_error.log10().floor() } else { 4.0 };
    let digits = digits.clamp(3.0, 7.0) as usize;
    let (low, high) = if e.value < 0.0 { (-e.ci95.1, -e.ci95.0) } else { e.ci95 };
    format!("{:.digits$} [{low:.digits$}, {high:.digits$}]", e.value.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_logarithms_have_the_papers_letters() {
        assert_eq!(symbol("ln((|y|+eps)/V)"), "L");
        assert_eq!(symbol("ln(c+V/(|y2|+eps))"), "M2");
        assert_eq!(symbol("x*y"), "x y");
    }

    #[test]
    fn intervals_have_two_digits_of_the_error() {
        let normal = |value: f64, std_error: f64| {
            let reach = 1.96 * std_error;
            Estimate { value, std_error, ci95: (value - reach, value + reach) }
        };
        assert_eq!(with_interval(&normal(0.5, 0.001)), "0.5000 [0.4980, 0.5020]");
        assert_eq!(with_interval(&normal(-0.5, 0.01)), "0.500 [0.480, 0.520]");
    }
}
