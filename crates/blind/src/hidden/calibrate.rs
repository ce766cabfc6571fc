//! `phisindy-blind calibrate`: is what the program says as sure as it says?
//!
//! ```text
//! seed --prior--> wish --made--> world: rig, cause, noise, data by another solver | truth.json
//! world --phisindy gap--> result.json --answer, with the truth--> right, honest or wrong, and its probabilities
//! answers --tally--> tables | the counts that reports quote
//! ```

mod answer;
mod band;
mod prior;
mod tally;

use super::formula::{force_error, forces};
use super::made::{Made, made};
use super::mark::steps;
use super::score::{read, run};
use super::truth::Truth;
use super::write;
use crate::args::{CalibrateArgs, Options};
use crate::dice::Dice;
use crate::folder::{Folder, replace};
use crate::interrupt;
use crate::program::Program;
use crate::progress::Progress;
use crate::table::Table;
use anyhow::{Result, anyhow, bail};
use rayon::prelude::*;
use serde_json::Value;
use std::time::Duration;
use tally::World;

/// The file that says whose worlds a folder holds.
const SEED: &str = "seed.json";

/// Draws the worlds, runs those without an answer, and counts; none if the user stopped it.
///
/// # Errors
/// The folder holds worlds of another seed, a world cannot be made, or files cannot be read or written.
pub(super) fn calibrate(args: &CalibrateArgs, options: &Options) -> Result<Option<Table>> {
    let folder = Folder::create(&args.out)?;
    let kept = args.out.join(SEED);
    if !kept.exists() {
        folder.write(SEED, &format!("{}\n", args.seed))?;
    }
    let seed: u64 = read(&kept, "is no seed")?;
    if seed != args.seed {
        bail!("`{}` holds worlds of seed {seed}: take another folder", args.out.display());
    }
    let progress = Progress::new("calibrate", args.sets, options.quiet);
    let all: Vec<Option<World>> = (0..args.sets)
        .into_par_iter()
        .map(|index| {
            let answer = answered(args, options, index)?;
            progress.step();
            Ok(answer)
        })
        .collect::<Result<_>>()?;
    drop(progress);
    let Some(all) = all.into_iter().collect::<Option<Vec<World>>>() else { return Ok(None) };
    if let Some(path) = &args.table {
        replace(path, &tally::counts(&all, args.seed))?;
    }
    Ok(Some(tally::tally(&all)))
}

/// A world of a seed.
///
/// # Errors
/// No draw of its kind can be seen.
fn world(seed: u64, index: usize) -> Result<(Made, Dice)> {
    let mut dice = Dice::new(seed, &format!("world {index}"));
    let wish = prior::draw(&mut dice);
    let made = made(&wish, &mut dice).map_err(|why| anyhow!("world {index}: {why}"))?;
    Ok((made, dice))
}

/// A world and the program's answer, of now or kept; none if the user stopped it.
fn answered(args: &CalibrateArgs, options: &Options, index: usize) -> Result<Option<World>> {
    let set = args.out.join(format!("{index:03}"));
    let kept = set.join("result.json");
    if !kept.exists() && interrupt::requested() {
        return Ok(None);
    }
    let (made, mut dice) = world(args.seed, index)?;
    if !kept.exists() {
        let folder = Folder::create(&set)?;
        write::write(&folder, index, &made, &mut dice)?;
        let program = Program::find(options)?;
        let patience = Duration::from_secs(args.patience);
        let Some(answer) = run(&set, &program, &[], 1, patience)? else { return Ok(None) };
        folder.write("result.json", &(serde_json::to_string_pretty(&answer)? + "\n"))?;
    }
    let truth: Truth = read(&set.join("truth.json"), "is no truth")?;
    let result: Value = read(&kept, "is damaged; delete it to run its world again")?;
    let error = forces(&made, &steps(&result)).and_then(|found| force_error(&made, &found));
    let answer = answer::answer(&truth, &result, error);
    Ok(Some(World { set: format!("{index:03}"), truth, answer }))
}

#[cfg(test)]
mod tests {
    use super::super::effect::Action;
    use super::super::rivals::{Seen, near};
    use super::super::sensor_noise::SensorNoise;
    use super::super::truth::Placed;
    use super::super::wish::{Kind, Purpose, Wish};
    use super::*;
    use crate::args::Sensors;

    #[test]
    fn a_seed_draws_the_same_worlds_again() {
        let drawn = |seed: u64| {
            let (made, _) = world(seed, 3).expect("a world");
            (serde_json::to_string(&made.truth).expect("JSON"), made.records[0].columns.clone())
        };
        assert!(drawn(5) == drawn(5));
        assert!(drawn(5) != drawn(6));
    }

    /// The force that is hidden is no error, wherever it acts: between a mass and a moved wall too.
    #[test]
    fn the_true_force_has_no_error() {
        let mut of_wall = 0;
        for (made, _) in (0..60).map(|index| world(20, index).expect("a world")) {
            let [effect] = &made.effects[..] else { continue };
            let Action::Force { force, internal, .. } = &effect.action else { continue };
            if !internal.is_empty() || effect.second_phase.is_some() || made.truth.sticks {
                continue;
            }
            let step = serde_json::json!({ "force": effect.written(force, false), "at": effect.at });
            let found = forces(&made, &[&step]).expect("a force");
            let error = force_error(&made, &found).expect("an error");
            assert!(error < 1e-3, "{}: {step}: {error}", effect.law);
            of_wall += usize::from(effect.at.contains("du"));
        }
        assert!(of_wall > 0);
    }

    /// Where the records show one of two laws, that one is the answer.
    #[test]
    fn a_law_that_the_records_do_not_show_need_not_be_found() {
        let worlds = (0..40).map(|index| world(20, index).expect("a world").0.truth);
        let mut simpler = 0;
        for truth in worlds.filter(|truth| truth.margin.is_some_and(|margin| margin < 0.0)) {
            let words = |set: &[Placed]| {
                let mut all: Vec<String> = set.iter().map(|p| format!("{} at {}", p.law, p.at)).collect();
                all.sort();
                all
            };
            let mut nearest: Vec<&str> = truth.nearest.split(" + ").collect();
            nearest.sort_unstable();
            assert!(truth.alternatives.iter().any(|set| words(set) == nearest), "{}", truth.nearest);
            simpler += 1;
        }
        assert!(simpler > 0);
    }

    /// The part that the best law leaves: nothing of a law, much of a force in time.
    #[test]
    fn a_force_is_as_far_from_the_laws_as_it_is() {
        let apart = |kind: Kind| {
            let purpose = Purpose::World(SensorNoise::White);
            let wish = Wish {
                kind,
                noise: 0.01,
                two_masses: false,
                holds: false,
                sensors: Sensors::Displacement,
                purpose,
            };
            let made = made(&wish, &mut Dice::new(8, "apart")).expect("a world");
            near(&Seen {
                rig: &made.rig,
                effects: &made.effects,
                experiment: &made.experiments[0],
                motion: &made.motions[0],
                base: &made.motions[0],
                columns: &[],
            })
        };
        let (none, all) = apart(Kind::Laws(vec!["cubic-stiffness"]));
        assert!(
            none < 1e-3 && all.iter().any(|set| set.len() == 1 && set[0].0 == "cubic-stiffness"),
            "{none}"
        );
        let (most, all) = apart(Kind::Outside("pulse-force"));
        assert!(most > 0.2 && all.is_empty(), "{most}");
    }
}
