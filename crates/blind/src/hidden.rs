//! `phisindy-blind hidden` makes data sets with a hidden effect for a blind test of the gap workflow.
//! `phisindy-blind score` runs the workflow on them and compares.
//!
//! ```text
//! seed --wish--> requirements of a set --made--> rig, effect, motion, noise (drawn until fair)
//!      --write--> spec.ron, *.csv | truth.json
//! DIR/NNN --run--> result.json --scored, with truth.json--> marks --tally--> table
//! ```
//! `phisindy-blind formula` makes sets with a law that is left out of the catalogue, or in none, and compares
//! forces.

mod calibrate;
mod determined;
mod effect;
mod experiment;
mod fair;
mod force;
mod formula;
mod independent;
mod instrument;
mod linear;
mod made;
mod mark;
mod motion;
mod never;
mod outside;
mod place;
mod rig;
mod rivals;
mod score;
mod sensor_noise;
mod tally;
mod told;
mod truth;
mod wish;
mod write;

use crate::args::{CalibrateArgs, FormulaArgs, HiddenArgs, Options, ScoreArgs};
use crate::dice::Dice;
use crate::folder::{Folder, print};
use crate::interrupt;
use crate::progress::Progress;
use crate::table::Table;
use anyhow::{Result, anyhow};
use rayon::prelude::*;
use std::path::Path;

/// Scores the sets; none if the user stopped it.
///
/// # Errors
/// There are no sets, or files cannot be read or written.
pub(crate) fn score(args: &ScoreArgs, options: &Options) -> Result<Option<Table>> {
    score::score(args, options)
}

/// Worlds, answers and how far these can be believed; none if the user stopped it.
///
/// # Errors
/// A world that cannot be made, or files that cannot be read or written.
pub(crate) fn calibrate(args: &CalibrateArgs, options: &Options) -> Result<Option<Table>> {
    calibrate::calibrate(args, options)
}

/// Sets for formulas, made, run and scored; none if the user stopped it.
///
/// # Errors
/// A set that cannot be made, or files that cannot be read or written.
pub(crate) fn formula(args: &FormulaArgs, options: &Options) -> Result<Option<Table>> {
    formula::formula(args, options)
}

/// Makes the sets; false if the user stopped it.
///
/// # Errors
/// A wish that cannot be met, or files that cannot be written.
pub(crate) fn make(args: &HiddenArgs, options: &Options) -> Result<bool> {
    let progress = Progress::new("hidden", args.sets, options.quiet);
    (0..args.sets).into_par_iter().try_for_each(|index| -> Result<()> {
        if !interrupt::requested() {
            set(args, index, &args.out.join(format!("{index:03}")))?;
            progress.step();
        }
        Ok(())
    })?;
    drop(progress);
    if interrupt::requested() {
        return Ok(false);
    }
    print(&format!("{} sets in {}\n", args.sets, args.out.display()))?;
    Ok(true)
}

/// Makes one of the sets.
///
/// # Errors
/// A wish that cannot be met, or files that cannot be written.
pub(crate) fn set(args: &HiddenArgs, index: usize, folder: &Path) -> Result<()> {
    let wish =
        wish::wish(args.seed, index, args.only.as_deref(), args.sensors).map_err(|why| anyhow!(why))?;
    let mut dice = Dice::new(args.seed, &format!("set {index}"));
    let made = made::made(&wish, &mut dice).map_err(|why| anyhow!("set {index}: {why}"))?;
    write::write(&Folder::create(folder)?, index, &made, &mut dice)
}
