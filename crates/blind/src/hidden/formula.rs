//! Sets with a law that the program cannot have in its catalogue: made, run, and the forces compared.

use super::effect::{Action, Effect};
use super::force::{error, missing, on_masses, same_form};
use super::made::{Made, made};
use super::mark::steps;
use super::motion::{Experiment, motion};
use super::place::{Place, places, same_place};
use super::wish::{HOLDING, Kind, LAWS, Purpose, Wish};
use super::{never, score, write};
use crate::args::{FormulaArgs, Missing, Options, Sensors};
use crate::dice::Dice;
use crate::folder::Folder;
use crate::interrupt;
use crate::markdown::markdown;
use crate::program::Program;
use crate::progress::Progress;
use crate::table::Table;
use anyhow::{Result, anyhow, bail};
use phisindy_signal::standard_deviation;
use rayon::prelude::*;
use serde_json::Value;
use std::path::Path;

/// The catalogue's laws without memory that are a force of displacement and velocity.
const STATIC: &[&str] = &[
    "viscous",
    "stiffness",
    "quadratic-drag",
    "coulomb",
    "asymmetric-coulomb",
    "stribeck",
    "dieterich-ruina",
    "position-dependent-friction",
    "cubic-stiffness",
    "quadratic-stiffness",
    "dead-zone",
    "one-sided-stop",
    "van-der-pol",
    "load-dependent-friction",
    "cogging",
    "power-law-damping",
    "cubic-damping",
    "quintic-stiffness",
    "bilinear-stiffness",
];

/// The catalogue's laws with memory.
const MEMORY: &[&str] = &["presliding", "bouc-wen", "lugre", "maxwell", "maxwell-slip", "backlash"];

/// The error of the force that is accepted is the larger of this, and the noise.
const ACCEPTED: f64 = 0.03;
/// The record tells the force of the right formula to this part of the accepted error.
const TOLD: f64 = 1.0 / 3.0;
/// A formula with a larger error of the force is wrong, whatever the program says.
pub(super) const WRONG: f64 = 0.1;
/// Excitation beyond what was seen.
const BEYOND: f64 = 1.4;
/// The free run's NRMSE that is accepted there.
const FOLLOWS: f64 = 0.05;
/// The gap on Validate records that is accepted.
const CLEAN: f64 = 1.1;

/// The marks of a set.
struct Mark {
    set: String,
    law: String,
    masses: usize,
    status: String,
    /// The force that was found, as text; empty if there is none.
    found: String,
    /// The error of the force along the record not used; none without a force.
    error: Option<f64>,
    same: bool,
    gap: Option<f64>,
    /// The free run's NRMSE at [`BEYOND`] times the excitation.
    beyond: Option<f64>,
    /// The program says that the past has a say.
    past: bool,
    seconds: Option<f64>,
    /// What to expect.
    what: Missing,
    accepted: f64,
}

/// Makes the sets, runs the workflow on each and compares; none if the user stopped it.
///
/// # Errors
/// A set that cannot be made, an unknown law, or files that cannot be read or written.
pub(super) fn formula(args: &FormulaArgs, options: &Options) -> Result<Option<Table>> {
    let hidden = laws(args)?;
    let temporary = std::env::temp_dir().join(format!("phisindy-blind-{}", std::process::id()));
    let folder = args.out.clone().unwrap_or_else(|| temporary.clone());
    let program = Program::find(options)?;
    let progress = Progress::new("formula", args.sets, options.quiet);
    let all: Result<Vec<Option<Mark>>> = (0..args.sets)
        .into_par_iter()
        .map(|index| {
            let law = hidden.get(index % hidden.len().max(1)).copied();
            let mark = marked(args, &program, &folder.join(format!("{index:03}")), index, law)?;
            progress.step();
            Ok(mark)
        })
        .collect();
    drop(progress);
    if args.out.is_none() {
        // What is left of it does no harm.
        let _ = std::fs::remove_dir_all(&temporary);
    }
    let all: Option<Vec<Mark>> = all?.into_iter().collect();
    let name = match args.what {
        Missing::Never => "formula-never",
        Missing::LeaveOneOut => "formula-left-out",
        Missing::Nothing => "formula-nothing",
        Missing::Memory => "formula-memory",
    };
    Ok(all.map(|all| Table { name, table: tables(&all, args), failures: each(&all) }))
}

/// The laws that are hidden in turn; none where nothing is.
fn laws(args: &FormulaArgs) -> Result<Vec<&'static str>> {
    let all: Vec<&'static str> = match args.what {
        Missing::Never => never::names().collect(),
        Missing::LeaveOneOut => STATIC.to_vec(),
        Missing::Memory => MEMORY.to_vec(),
        Missing::Nothing => return Ok(vec![]),
    };
    let Some(only) = &args.only else { return Ok(all) };
    match all.iter().find(|law| *law == only) {
        Some(law) => Ok(vec![law]),
        None => bail!("there is no such law `{only}`; there is: {}", all.join(", ")),
    }
}

/// Makes a set, runs it if it has no result, and compares; none if the user stopped it.
fn marked(
    args: &FormulaArgs,
    program: &Program,
    folder: &Path,
    index: usize,
    law: Option<&'static str>,
) -> Result<Option<Mark>> {
    if interrupt::requested() {
        return Ok(None);
    }
    let noise = args.noise / 100.0;
    let accepted = ACCEPTED.max(noise);
    let mut dice = Dice::new(args.seed, &format!("formula {:?} {index}", args.what));
    let kind = match (args.what, law) {
        (Missing::Never, Some(law)) => Kind::Outside(law),
        (_, Some(law)) => Kind::Laws(vec![law]),
        (_, None) => Kind::Nothing,
    };
    let rubs = law.is_some_and(|law| HOLDING.contains(&law) || law.ends_with("friction"));
    let wish = Wish {
        kind,
        noise,
        two_masses: dice.chance(0.3),
        holds: rubs && dice.chance(0.5),
        sensors: Sensors::Mixed,
        purpose: Purpose::Formula(TOLD * accepted),
    };
    let made = made(&wish, &mut dice).map_err(|why| anyhow!("set {index}: {why}"))?;
    let kept = folder.join("result.json");
    let known = if args.again { None } else { std::fs::read_to_string(&kept).ok() };
    let result = match known.and_then(|text| serde_json::from_str(&text).ok()) {
        Some(result) => result,
        None => {
            let files = Folder::create(folder)?;
            write::write(&files, index, &made, &mut dice)?;
            let without = match args.what {
                _ if args.bare => LAWS.to_vec(),
                Missing::LeaveOneOut => law.into_iter().collect(),
                Missing::Memory => MEMORY.to_vec(),
                Missing::Never | Missing::Nothing => vec![],
            };
            let Some(result) = score::run(folder, program, &without, args.threads, score::PATIENCE)? else {
                return Ok(None);
            };
            files.write("result.json", &(serde_json::to_string_pretty(&result)? + "\n"))?;
            result
        }
    };
    Ok(Some(compared(args.what, &made, index, law, accepted, &result)))
}

/// A result beside the truth.
fn compared(
    what: Missing,
    made: &Made,
    index: usize,
    law: Option<&str>,
    accepted: f64,
    result: &Value,
) -> Mark {
    let text = |value: &Value| value.as_str().unwrap_or("").to_owned();
    let steps = steps(result);
    let found = forces(made, &steps);
    let written = |step: &&Value| {
        let force = step["force"].as_str().map_or_else(|| text(&step["law"]), str::to_owned);
        format!("{force} at {}", text(&step["at"]))
    };
    let depends = text(&result["missing_force"]["depends_on"]);
    let mut mark = Mark {
        set: format!("{index:03}"),
        law: law.unwrap_or("(nothing)").to_owned(),
        masses: made.rig.count(),
        status: text(&result["status"]),
        found: steps.iter().map(written).collect::<Vec<_>>().join("; "),
        error: None,
        same: false,
        gap: result["final"]["validate"].as_f64(),
        beyond: None,
        past: depends == "the past",
        seconds: result["seconds"].as_f64(),
        what,
        accepted,
    };
    let (Some(found), Some(_)) = (found, law) else { return mark };
    mark.error = force_error(made, &found);
    let last = made.motions.len() - 1;
    if let ([truth], [one]) = (&made.effects[..], &found[..])
        && same_place(&truth.at) == same_place(&one.at)
        && let (Action::Force { place, .. }, Action::Force { force, .. }) = (&truth.action, &one.action)
    {
        mark.same = same_form(truth, place, force, &states(place, made, last));
    }
    mark.beyond = beyond(made, &made.experiments[last], &found);
    mark
}

/// The forces of all steps; `None` if there are none, or one is no force of displacement and velocity.
pub(super) fn forces(made: &Made, steps: &[&Value]) -> Option<Vec<Effect>> {
    let found: Option<Vec<Effect>> = steps.iter().map(|step| force(made, step)).collect();
    found.filter(|all| !all.is_empty())
}

/// The error of forces along the record that is not used, the second or the second part of the only one: rms over rms of
/// what is missing there. `None` if a force is no expression of the states.
pub(super) fn force_error(made: &Made, found: &[Effect]) -> Option<f64> {
    let last = made.motions.len() - 1;
    let (rig, exact, experiment) = (&made.rig, &made.motions[last], &made.experiments[last]);
    let from = if last == 0 { made.split } else { 0 };
    let tail = |forces: Vec<Vec<f64>>| forces.into_iter().map(|f| f[from..].to_vec()).collect::<Vec<_>>();
    let due = tail(missing(rig, exact, experiment));
    let got = tail(on_masses(rig, found, exact, experiment)?);
    Some(error(&got, &due, &exact.stuck[from..])).filter(|e| e.is_finite())
}

/// Displacement and velocity of a place along a record.
fn states(place: &Place, made: &Made, record: usize) -> Vec<(f64, f64)> {
    let (states, masses) = (&made.motions[record].states, made.rig.count());
    let sum = |shift: usize, i: usize| place.parts.iter().map(|&(m, sign)| sign * states[shift + m][i]).sum();
    (0..made.motions[record].stuck.len()).map(|i| (sum(0, i), sum(masses, i))).collect()
}

/// The force of a step as an effect; `None` if it is no force of displacement and velocity.
fn force(made: &Made, step: &Value) -> Option<Effect> {
    let (force, at) = (step["force"].as_str()?, step["at"].as_str()?);
    let mut place = places(&made.rig).into_iter().find(|p| same_place(&p.at) == same_place(at))?;
    // `v2-v1` pulls the other way than `v1-v2`.
    if place.at.replace(' ', "") != at.replace(' ', "") {
        place.parts.iter_mut().for_each(|(_, sign)| *sign = -*sign);
    }
    let action = Action::Force { place, force: force.to_owned(), internal: vec![] };
    Some(Effect { law: String::new(), at: at.to_owned(), parameters: vec![], second_phase: None, action })
}

/// The NRMSE of the free run with these forces against the truth, at [`BEYOND`] times the excitation.
fn beyond(made: &Made, of: &Experiment, found: &[Effect]) -> Option<f64> {
    let mut more = of.clone();
    more.lines.iter_mut().for_each(|line| line.amplitude *= BEYOND);
    let due = motion(&made.rig, &made.effects, &more, 0.0).ok()?;
    let Ok(got) = motion(&made.rig, found, &more, 0.0) else { return Some(f64::INFINITY) };
    let of = |k: usize| {
        let miss = due.states[k].iter().zip(&got.states[k]).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        (miss / due.states[k].len() as f64).sqrt() / standard_deviation(&due.states[k])
    };
    Some((0..made.rig.count()).map(of).fold(0.0, f64::max))
}

/// One line for each set.
fn each(all: &[Mark]) -> String {
    let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.4}"));
    let line = |m: &Mark| {
        format!(
            "{} {} ({} dof): {}: {}; force {}, form {}, gap {}, beyond {}, {} s\n",
            m.set,
            m.law,
            m.masses,
            m.status,
            m.found,
            number(m.error),
            if m.same { "same" } else { "other" },
            number(m.gap),
            number(m.beyond),
            m.seconds.map_or("-".to_owned(), |s| format!("{s:.0}")),
        ) + if m.past { "    it depends on the past\n" } else { "" }
    };
    all.iter().map(line).collect()
}

/// All sets, by the number of masses, and by law.
fn tables(all: &[Mark], args: &FormulaArgs) -> String {
    let of = |keep: &dyn Fn(&Mark) -> bool| all.iter().filter(|m| keep(m)).collect::<Vec<_>>();
    let mut rows = vec![row(&format!("all ({} %, seed {})", args.noise, args.seed), &of(&|_| true))];
    rows.extend([1, 2].map(|n| row(&format!("{n} dof"), &of(&|m| m.masses == n))));
    let mut laws: Vec<&str> = all.iter().map(|m| m.law.as_str()).collect();
    laws.sort_unstable();
    laws.dedup();
    if args.what != Missing::Nothing {
        rows.extend(laws.iter().map(|law| row(law, &of(&|m| m.law == *law))));
    }
    markdown(&head(args.what), &rows)
}

fn head(what: Missing) -> Vec<&'static str> {
    let mut head = vec!["hidden", "sets"];
    head.extend(match what {
        Missing::Nothing => vec!["nothing added"],
        Missing::Memory => vec!["no force of displacement and velocity", "said to depend on the past"],
        Missing::Never | Missing::LeaveOneOut => vec![
            "force right",
            "the same form",
            "gap at most 1.1",
            "follows 1.4 times the excitation",
            "error of the force (median)",
            "a wrong force",
            "unexplained",
        ],
    });
    head.push("seconds (mean, max)");
    head
}

fn row(name: &str, sets: &[&Mark]) -> Vec<String> {
    let part = |f: &dyn Fn(&Mark) -> bool| {
        let n = sets.iter().filter(|m| f(m)).count();
        format!("{n} of {}", sets.len())
    };
    let within = |x: Option<f64>, most: f64| x.is_some_and(|x| x <= most);
    let told = |m: &Mark| matches!(m.status.as_str(), "explained" | "described");
    let mut row = vec![name.to_owned(), sets.len().to_string()];
    match sets.first().map_or(Missing::Never, |m| m.what) {
        Missing::Nothing => row.push(part(&|m| m.status == "nothing-missing")),
        Missing::Memory => {
            row.push(part(&|m| !told(m)));
            row.push(part(&|m| m.past));
        }
        Missing::Never | Missing::LeaveOneOut => {
            let mut errors: Vec<f64> = sets.iter().filter_map(|m| m.error).collect();
            errors.sort_by(f64::total_cmp);
            row.push(part(&|m| told(m) && within(m.error, m.accepted)));
            row.push(part(&|m| told(m) && m.same));
            row.push(part(&|m| told(m) && within(m.gap, CLEAN)));
            row.push(part(&|m| told(m) && within(m.beyond, FOLLOWS)));
            row.push(errors.get(errors.len() / 2).map_or("-".to_owned(), |e| format!("{e:.4}")));
            row.push(part(&|m| told(m) && !within(m.error, WRONG)));
            row.push(part(&|m| m.status == "unexplained"));
        }
    }
    let seconds: Vec<f64> = sets.iter().filter_map(|m| m.seconds).collect();
    let most = seconds.iter().copied().fold(0.0, f64::max);
    row.push(format!("{:.0}, {most:.0}", seconds.iter().sum::<f64>() / seconds.len().max(1) as f64));
    row
}
