//! `phisindy table hidden`: data sets with a hidden effect, as somebody would make them who wants to test the gap workflow blind. `phisindy table score` runs
//! the workflow on them and compares.
//!
//! ```text
//! seed --wish--> what a set is to hold --made--> rig, effect, motion, noise (drawn again until fair) --write--> spec.ron, *.csv | truth.json
//! DIR/NNN --run--> result.json --scored, with truth.json--> marks --tally--> table
//! ```

mod course;
mod dice;
mod effect;
mod fair;
mod linear;
mod made;
mod mark;
mod motion;
mod outside;
mod place;
mod rig;
mod rivals;
mod score;
mod tally;
mod told;
mod truth;
mod wish;
mod write;

use crate::args::{Options, TableArgs};
use crate::command::print;
use crate::interrupt;
use crate::outdir::OutDir;
use crate::progress::Progress;
use anyhow::{Result, anyhow};
use std::path::PathBuf;

pub(crate) use dice::{Dice, rounded};
pub(crate) use effect::substitute;
pub(crate) use score::Score;

/// Scores the sets; none if the user stopped it.
///
/// # Errors
/// There are no sets, or files cannot be read or written.
pub(crate) fn score(args: &TableArgs, options: &Options) -> Result<Option<Score>> {
    score::score(&folder(options)?, options, args.again)
}

/// Makes the sets.
///
/// # Errors
/// A wish that cannot be met, or files that cannot be written.
pub(crate) fn make(args: &TableArgs, options: &Options) -> Result<u8> {
    let out = folder(options)?;
    let seed = options.seed.unwrap_or(0);
    let mut progress = Progress::new("hidden", options.quiet);
    for index in 0..args.sets {
        if interrupt::asked() {
            return Ok(interrupt::code());
        }
        let wish = wish::wish(seed, index, args.only.as_deref()).map_err(|why| anyhow!(why))?;
        let mut dice = Dice::new(seed, &format!("set {index}"));
        let made = made::made(&wish, &mut dice).map_err(|why| anyhow!("set {index}: {why}"))?;
        write::write(&OutDir::create(&out.join(format!("{index:03}")))?, index, &made, &mut dice)?;
        progress.at((index + 1) as f64 / args.sets as f64);
    }
    drop(progress);
    print(&format!("{} sets in {}\n", args.sets, out.display()))?;
    Ok(0)
}

fn folder(options: &Options) -> Result<PathBuf> {
    options.out.clone().ok_or_else(|| anyhow!("say where the sets are: --out DIR"))
}
