//! Friction that was found, back into the file of a robot.

use super::put;
use crate::args::{ExportArgs, Options};
use crate::commands::new;
use crate::draw;
use crate::terminal::{INPUT, remark};
use anyhow::{Result, anyhow, bail};
use phisindy::files::{self, Purpose};
use phisindy_import::{JointMotion, Refitted, Robot};
use phisindy_phys::{Diagnostic, Sources, System};
use phisindy_report::export::{JointFriction, Moved};
use std::path::Path;

/// Two numbers that miss less of a force are that force.
const ALIKE: f64 = 1e-3;

/// Writes the robot with its friction; says what two numbers cannot say.
pub(super) fn export(spec: &Path, args: &ExportArgs, options: &Options, file: Option<&Path>) -> Result<u8> {
    let to = args.to.name;
    let Some(path) = &args.model else {
        bail!(
            "`--to {to}` writes into the file of the robot: say which one, as in `--model robot.{}`",
            ending(to)
        );
    };
    let shown = path.display().to_string();
    let text = new::robot_text(path)?
        .ok_or_else(|| anyhow!("`{shown}` is neither URDF nor MJCF, or cannot be opened"))?;
    let mut sources = Sources::default();
    let source = sources.add(shown.clone(), text.clone());
    let robot = match Robot::read(&text, source) {
        Ok(robot) => robot,
        Err(d) => {
            draw::show([&*d], &sources);
            return Ok(INPUT);
        }
    };
    let own = robot.format.to_lowercase();
    if own != to {
        bail!("`{shown}` is {}: say `--to {own}`, which keeps the rest of the file", robot.format);
    }
    let mut found = Vec::new();
    let loaded = match files::load(spec, &options.request(), Purpose::Simulate, &mut sources, &mut found) {
        Ok(loaded) => loaded,
        Err(_) => {
            draw::show(found.iter().filter(|d| d.is_error()), &sources);
            return Ok(INPUT);
        }
    };
    let system = &loaded.case.system;
    let motions = match loaded.simulate() {
        Ok(motions) => motions,
        Err(why) => bail!("no motion tells at which speeds the joints move: {why}"),
    };
    let moved = |motion: &phisindy::Motion| {
        let states = system
            .states
            .iter()
            .map(|s| motion.state(&s.name).map(<[f64]>::to_vec))
            .collect::<Option<_>>()?;
        let constants = loaded.records.iter().find(|r| r.name == motion.record)?.constants.clone();
        Some(Moved { states, constants })
    };
    let moved: Vec<Moved> = motions.iter().filter_map(moved).collect();
    let mut refitted = vec![];
    for joint in robot.joints() {
        let (force, per_speed) = match joint.motion {
            JointMotion::Turn => ("N*m", "N*m*s"),
            JointMotion::Slide => ("N", "N*s/m"),
        };
        let Some(friction) = JointFriction::of(system, &joint.name, &moved) else {
            remark(&format!(
                "{}: no place of the spec is the speed of this joint, so it stays as it is",
                joint.name
            ));
            continue;
        };
        let armature = armature(system, &joint.name);
        let mut line = format!(
            "{}: dry {} {force}, viscous {} {per_speed}",
            joint.name,
            short(friction.dry),
            short(friction.viscous)
        );
        if friction.missed > ALIKE {
            line.push_str(&format!(
                "; these two miss {:.1} % of the force that was found, over speeds up to {} {}",
                100.0 * friction.missed,
                short(friction.fastest),
                if joint.motion == JointMotion::Turn { "rad/s" } else { "m/s" }
            ));
            if !friction.depends_on.is_empty() {
                line.push_str(&format!(" (it depends on {} too)", friction.depends_on.join(", ")));
            }
        }
        if armature.is_some() && own == "urdf" {
            line.push_str("; URDF has no armature");
        }
        if !options.quiet {
            remark(&line);
        }
        refitted.push(Refitted {
            joint: joint.name.clone(),
            dry: friction.dry,
            viscous: friction.viscous,
            armature,
        });
    }
    if refitted.is_empty() {
        let d = Diagnostic::error(format!("`{}` has no place that is a joint of `{shown}`", spec.display()))
            .help("`places` names the joints: { \"shoulder\": \"dq1\" }, as `phisindy new` writes it");
        draw::show([&d], &sources);
        return Ok(INPUT);
    }
    let (written, lost) = match Robot::with_friction(&text, source, &refitted) {
        Ok(written) => written,
        Err(d) => {
            draw::show([&*d], &sources);
            return Ok(INPUT);
        }
    };
    for joint in lost {
        remark(&format!("{joint}: the file does not name it, so it stays as it is: give it a name there"));
    }
    put(file, written.as_bytes())?;
    Ok(0)
}

fn ending(to: &str) -> &str {
    if to == "urdf" { "urdf" } else { "xml" }
}

/// The armature of a joint: the constant `J1` that the draft has for the speed `dq1`.
fn armature(system: &System, joint: &str) -> Option<f64> {
    let place = system.places.iter().find(|place| place.name == joint)?;
    let speed = system.states.iter().find(|state| state.node == place.of.node)?;
    let name = format!("J{}", speed.name.strip_prefix("dq")?);
    let moves = system.parameters.iter().find(|p| p.name == name).map(|p| p.start);
    moves.or_else(|| system.constants.iter().find(|(own, _)| *own == name).map(|(_, value)| *value))
}

/// Four digits.
fn short(x: f64) -> String {
    let digits: f64 = format!("{x:.3e}").parse().unwrap_or(x);
    digits.to_string()
}
