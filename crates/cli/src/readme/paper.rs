//! Each case of the paper: what it prints, and what both methods find with its own noise and seed.

use super::{Chosen, fail, markdown};
use crate::args::{Assignment, Options};
use crate::interrupt;
use crate::load::{Loaded, Purpose, load};
use crate::progress::Progress;
use anyhow::Result;
use phisindy_learn::{Estimate, Identified, LearnError, LearnOptions, Verdict, identify, project};
use phisindy_phys::spec::Method;
use phisindy_phys::{Case, Sources};
use std::ops::ControlFlow;
use std::path::Path;

/// Without the event condition: the case, its equation, what the paper prints.
const WITHOUT: &[(&str, &str, &str)] = &[("1a", "y", "0.354, eq. (42)"), ("5", "y2", "0.389, eq. (66)")];

/// The tables; none if the user stopped it.
pub(super) fn table(cases: &[Chosen], options: &Options) -> Result<Option<String>> {
    let (mut noisy, mut clean, mut without) = (Vec::new(), Vec::new(), Vec::new());
    for (printed, spec) in cases {
        let solved = |sets: &[(&str, &str)], method: Method| solve(spec, sets, method, options);
        let Some(step) = solved(&[], Method::Step)? else { return Ok(None) };
        let Some(trajectory) = solved(&[], Method::Trajectory)? else { return Ok(None) };
        let Some(exact) = solved(&[("data.0.noise", "Relative(0.0)")], Method::Step)? else {
            return Ok(None);
        };
        let truth = trajectory.truth();
        noisy.push(vec![
            printed.case.to_owned(),
            truth.clone(),
            printed.text.to_owned(),
            step.found(&plain),
            trajectory.found(&with_interval),
        ]);
        clean.push(vec![printed.case.to_owned(), truth.clone(), exact.found(&plain)]);
        if let Some((_, state, text)) = WITHOUT.iter().find(|(case, ..)| *case == printed.case) {
            let dictionary = format!("unknown.{state}.candidates");
            let sets = [("contacts", "[]"), (dictionary.as_str(), "[\"1\"]")];
            let Some(alone) = solved(&sets, Method::Step)? else { return Ok(None) };
            without.push(vec![printed.case.to_owned(), truth, (*text).to_owned(), alone.found(&plain)]);
        }
    }
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

/// One run.
struct Solved {
    loaded: Loaded,
    outcome: Result<Identified, LearnError>,
}

/// Runs a spec; none if the user stopped it.
fn solve(spec: &Path, sets: &[(&str, &str)], method: Method, options: &Options) -> Result<Option<Solved>> {
    let (mut sources, mut found) = (Sources::default(), Vec::new());
    let mut options = options.clone();
    let new = sets.iter().map(|&(path, value)| Assignment { path: path.to_owned(), value: value.to_owned() });
    options.sets.extend(new);
    let Ok(loaded) = load(spec, &options, Purpose::Run, &mut sources, &mut found) else {
        return fail(&found, &sources, spec);
    };
    let mut progress = Progress::new(&loaded.spec, options.quiet);
    let outcome =
        identify(&loaded.case, &loaded.records, &LearnOptions { method: Some(method) }, &mut |fraction| {
            progress.at(fraction);
            if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
    Ok(if interrupt::asked() { None } else { Some(Solved { loaded, outcome }) })
}

impl Solved {
    fn truth(&self) -> String {
        let case = &self.loaded.case;
        match project(case, &self.loaded.records) {
            Ok(truth) => {
                let terms: Vec<(usize, f64)> = truth.terms.into_iter().zip(truth.coefficients).collect();
                // The projection rounds.
                sums(
                    case,
                    &terms.iter().map(|&(t, c)| (t, c, crate::table::short(c.abs()))).collect::<Vec<_>>(),
                )
            }
            Err(why) => why.to_string(),
        }
    }

    fn found(&self, print: &dyn Fn(&Estimate) -> String) -> String {
        let found = match &self.outcome {
            Ok(found) => found,
            Err(why) => return format!("fails: {why}"),
        };
        let terms: Vec<(usize, f64, String)> =
            found.terms.iter().map(|f| (f.term, f.coefficient.value, print(&f.coefficient))).collect();
        let sums = sums(&self.loaded.case, &terms);
        match &found.verdict {
            Verdict::Identified => sums,
            Verdict::Rejected(why) => format!("{sums} (rejected: {why})"),
        }
    }
}

/// Sums of terms, one for each equation that has a dictionary.
fn sums(case: &Case, terms: &[(usize, f64, String)]) -> String {
    let system = &case.system;
    let states = (0..system.states.len()).filter(|&k| system.terms.iter().any(|t| t.state == k));
    let one = |state: usize| {
        let mut sum = String::new();
        for (term, value, text) in terms.iter().filter(|(t, ..)| system.terms[*t].state == state) {
            sum.push_str(match (sum.is_empty(), *value < 0.0) {
                (true, true) => "-",
                (true, false) => "",
                (false, true) => " - ",
                (false, false) => " + ",
            });
            sum.push_str(text);
            let name = symbol(&system.terms[*term].candidate);
            if name != "1" {
                sum.push(' ');
                sum.push_str(&name);
            }
        }
        if sum.is_empty() { "nothing".to_owned() } else { sum }
    };
    states.map(one).collect::<Vec<_>>().join("; ")
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
        assert_eq!(with_interval(&Estimate::normal(0.5, 0.001)), "0.5000 [0.4980, 0.5020]");
        assert_eq!(with_interval(&Estimate::normal(-0.5, 0.01)), "0.500 [0.480, 0.520]");
    }
}
