//! `phisindy-blind wrong`: does the program report a wrong known part? Each random rig is identified twice:
//! with the correct known part, and with one mistake in it.
//!
//! ```text
//! seed --Rig::draw--> rig --with_mistake--> known part with one mistake --written--> spec
//!      --identify--> reported? intervals right?
//! ```
//!
//! Two kinds of mistakes are counted apart. The dictionary can compensate some (missing damping, and a
//! candidate for it): they are identified, not wrong. Others are invisible: the wrong model with free
//! friction, fitted to the true motion without noise, leaves a chi square below [`tally::VISIBLE`] in both
//! records together.

mod mistake;
mod rig;
mod tally;
mod written;

use crate::args::{Options, WrongArgs};
use crate::dice::Dice;
use crate::folder::Folder;
use crate::interrupt;
use crate::progress::Progress;
use crate::synthetic::{Loaded, checked, load};
use crate::table::Table;
use anyhow::{Result, anyhow, bail};
use mistake::{KINDS, SMALL, needs_cubic, with_mistake};
use phisindy_learn::{
    Effort, Identified, LearnOptions, Verdict, Warning, calibrate, identify, project, smoothed,
};
use phisindy_phys::spec::Role;
use phisindy_signal::standard_deviation;
use rayon::prelude::*;
use rig::Rig;
use std::ops::ControlFlow;
use tally::{Outcome, tally};
use written::{Unknown, written};

/// Draws before giving up.
const TRIES: usize = 200;
/// A mass that sticks for a longer part of the record hardly moves.
const MOST_STUCK: f64 = 0.6;

/// The table, and a line for each set that is wrong without a warning; none if the user stopped it.
///
/// # Errors
/// There is no such mistake, or specs cannot be written.
pub(crate) fn table(args: &WrongArgs, options: &Options) -> Result<Option<Table>> {
    let kinds: Vec<&'static str> = match args.only.as_deref() {
        None => KINDS.to_vec(),
        Some("small") => SMALL.to_vec(),
        Some(only) => KINDS.iter().chain(SMALL).copied().filter(|k| *k == only).collect(),
    };
    if kinds.is_empty() {
        bail!("there is no such mistake; there is: small, {}", KINDS.join(", "));
    }
    let folder = args.out.as_deref().map(Folder::create).transpose()?;
    let progress = Progress::new("wrong", args.sets, options.quiet);
    let sets: Vec<Vec<Outcome>> = (0..args.sets)
        .into_par_iter()
        .map(|index| {
            let both = both(index, kinds[index % kinds.len()], args.seed, folder.as_ref())?;
            progress.step();
            Ok(both)
        })
        .collect::<Result<_>>()?;
    drop(progress);
    Ok((!interrupt::requested()).then(|| tally(&sets.concat())))
}

/// One rig with the wrong and the correct known part; empty if the user stopped it.
fn both(
    index: usize,
    kind: &'static str,
    seed: Option<u64>,
    folder: Option<&Folder>,
) -> Result<Vec<Outcome>> {
    if interrupt::requested() {
        return Ok(vec![]);
    }
    let mut dice = Dice::new(seed.unwrap_or(0), &format!("wrong {index}"));
    let pair = drawn(kind, &mut dice, seed).map_err(|why| anyhow!("set {index}, {kind}: {why}"))?;
    let mut out = Vec::new();
    for (kind, set) in [(kind, &pair.wrong), ("nothing", &pair.right)] {
        let name = format!("{index:03}-{}", kind.replace([' ', ','], "-"));
        if let Some(folder) = folder {
            folder.write(&format!("{name}.ron"), &set.loaded.text)?;
        }
        out.push(Outcome { set: name, kind: kind.to_owned(), ..outcome(set) });
    }
    Ok(out)
}

/// A spec of a rig with its records.
struct Set {
    loaded: Loaded,
    /// The mistake and the rig.
    said: String,
    /// Chi square of the mistake that the best friction cannot absorb.
    visible: f64,
    /// Coefficients of all candidates.
    truth: Vec<f64>,
    /// Whether the dictionary can compensate the mistake.
    inside: bool,
}

/// The wrong and the correct model of a rig.
struct Pair {
    wrong: Set,
    right: Set,
}

fn drawn(kind: &str, dice: &mut Dice, seed: Option<u64>) -> Result<Pair, String> {
    let mut last = "nothing was drawn".to_owned();
    for _ in 0..TRIES {
        let cubic = needs_cubic(kind) || dice.chance(0.15);
        let rig = Rig::draw(dice, cubic);
        match pair(&rig, kind, dice, seed) {
            Ok(pair) => return Ok(pair),
            Err(why) => last = why,
        }
    }
    Err(format!("{TRIES} draws will not do; the last one: {last}"))
}

fn pair(rig: &Rig, kind: &str, dice: &mut Dice, seed: Option<u64>) -> Result<Pair, String> {
    if rig.lines == 0 && kind.starts_with("drive") {
        return Err("nothing drives it".to_owned());
    }
    let (wrong, said) = with_mistake(rig, kind, dice).ok_or("it cannot be wrong in this way")?;
    let set = |physics: &rig::Physics, said: &str| -> Result<Set, String> {
        let title = format!("Known part: {said}");
        let loaded = load(written(rig, physics, &title, Unknown::Dictionary), seed)?;
        let visible = visible(&loaded, &written(rig, physics, &title, Unknown::Movable), rig)?;
        let (truth, inside) = true_coefficients(&loaded, rig);
        Ok(Set { loaded, said: format!("{said}; {}", rig.described()), visible, truth, inside })
    };
    let right = set(&rig.physics, "nothing is wrong")?;
    if hardly_moves(&right.loaded) {
        return Err("it hardly moves".to_owned());
    }
    Ok(Pair { wrong: set(&wrong, &said)?, right })
}

/// The spec of a random rig in which nothing is wrong.
///
/// # Errors
/// No rig was drawn that moves.
pub(crate) fn right(dice: &mut Dice) -> Result<String> {
    let text = |dice: &mut Dice| {
        let rig = Rig::draw(dice, false);
        written(&rig, &rig.physics, "a rig", Unknown::Dictionary)
    };
    let moves = |text: &String| load(text.clone(), None).is_ok_and(|loaded| !hardly_moves(&loaded));
    (0..TRIES).map(|_| text(dice)).find(moves).ok_or_else(|| anyhow!("{TRIES} rigs hardly move"))
}

/// Whether a mass sticks for most of a record.
fn hardly_moves(loaded: &Loaded) -> bool {
    let stuck = |modes: &[i8]| modes.iter().filter(|m| **m == 0).count() as f64 / modes.len().max(1) as f64;
    loaded.truths.iter().any(|run| stuck(&run.modes) > MOST_STUCK)
}

/// The least chi square of the wrong model against the true motion; infinite if it cannot be simulated.
fn visible(loaded: &Loaded, movable: &str, rig: &Rig) -> Result<f64, String> {
    let case = checked(movable)?;
    let mut records = loaded.records.clone();
    let mut noise = Vec::new();
    for (record, truth) in records.iter_mut().zip(&loaded.truths) {
        record.role = Role::Fit;
        for (k, column) in record.columns.iter_mut().enumerate() {
            if let Some(column) = column {
                *column = truth.column(k);
            }
        }
        let level = |c: &Option<Vec<f64>>| c.as_deref().map_or(0.0, |c| rig.noise * standard_deviation(c));
        noise.push(record.columns.iter().map(level).collect::<Vec<f64>>());
    }
    let smooth: Vec<_> = records.iter().map(|r| smoothed(&case.system, r)).collect();
    let fitted = calibrate(&case.system, &records, &smooth, &noise, Effort::Plain);
    Ok(fitted.map_or(f64::INFINITY, |c| c.chi2))
}

/// True coefficients of all candidates, and whether the dictionary contains all that the known part lacks.
fn true_coefficients(loaded: &Loaded, rig: &Rig) -> (Vec<f64>, bool) {
    let system = &loaded.case.system;
    let mut truth = vec![0.0; system.terms.len()];
    match project(&loaded.case, &loaded.records) {
        Ok(identified) => {
            identified.terms.iter().zip(&identified.coefficients).for_each(|(&t, &x)| truth[t] = x);
            (truth, true)
        }
        Err(_) => {
            for (x, term) in truth.iter_mut().zip(&system.terms) {
                let friction = rig.friction.iter().find(|f| rig.count() + f.mass == term.state);
                let of = friction.and_then(|f| f.terms.iter().find(|(c, _)| *c == term.candidate));
                *x = of.map_or(0.0, |(_, x)| *x);
            }
            (truth, false)
        }
    }
}

/// The result of the program for a set.
fn outcome(set: &Set) -> Outcome {
    let loaded = &set.loaded;
    let options = LearnOptions::default();
    let identified = identify(&loaded.case, &loaded.records, &options, &mut |_| ControlFlow::Continue(()));
    let mut out =
        Outcome { said: set.said.clone(), inside: set.inside, visible: set.visible, ..Outcome::default() };
    match identified {
        Err(_) => out.told.push("refused".to_owned()),
        Ok(identified) => {
            out.told = told(&identified);
            for term in &identified.terms {
                let (e, truth) = (term.coefficient, set.truth[term.term]);
                let reach = if truth > e.value { e.ci95.1 - e.value } else { e.value - e.ci95.0 };
                let off = (truth - e.value).abs() / reach.max(f64::MIN_POSITIVE);
                out.off = out.off.max(off);
                out.covered = (out.covered.0 + usize::from(off <= 1.0), out.covered.1 + 1);
            }
            out.warnings = identified.warnings.iter().map(ToString::to_string).collect();
        }
    }
    out
}

/// The doubts of the model that it reports, one word for each.
fn told(identified: &Identified) -> Vec<String> {
    let mut told = Vec::new();
    if identified.verdict != Verdict::Identified {
        told.push(identified.verdict.word().to_owned());
    }
    let has = |doubt: fn(&Warning) -> bool| identified.warnings.iter().any(doubt);
    let doubts = [
        (has(Warning::doubts_residual), "residual"),
        (has(|w| matches!(w, Warning::AtBound { .. })), "bound"),
        (has(Warning::doubts_validation), "validation"),
    ];
    told.extend(doubts.iter().filter(|(is, _)| *is).map(|(_, name)| (*name).to_owned()));
    told
}
