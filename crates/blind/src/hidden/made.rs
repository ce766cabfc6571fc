//! One set, drawn until it is fair.

use super::determined::determined;
use super::effect::{Effect, Scales, draw};
use super::experiment::{Length, experiments, first_part, first_part_of_motion};
use super::fair::{possible, steady, visible};
use super::independent;
use super::instrument::{draw_constant, draw_input, draw_sensor};
use super::motion::{ACCELERATION, Experiment, Motion, earlier, motion};
use super::never;
use super::outside;
use super::place::{Place, places};
use super::rig::{Constant, Drive, Extra, Line, Rig};
use super::rivals::{Judgement, Seen, judge, largest, near, place_motion};
use super::told::{alternatives, described, hidden};
use super::truth::{Gaps, Truth};
use super::wish::{HOLDING, Kind, Purpose, Wish};
use crate::args::Sensors;
use crate::dice::{Dice, rounded};
use phisindy_signal::standard_deviation;
use phisindy_sim::{Noise, Streams, add_noise};

/// Draws before giving up.
const TRIES: usize = 2000;
/// A set with a gap between these is accepted.
const GAPS: (f64, f64) = (1.1, 130.0);
/// The truth must beat every rival by this much.
const MARGIN: f64 = 20.0;
/// The least chi square of an effect that start states and movable constants cannot absorb.
const VISIBLE: f64 = 200.0;
/// The least residual of the catalogue for an effect outside of it, in units of the noise.
const REMAINDER: f64 = 0.4;

/// Records of blind sets, and of worlds, of which many are run.
const LONG: Length = Length { periods: (10.0, 40.0), samples: (2000, 6000), a_period: 60.0 };
const SHORT: Length = Length { periods: (5.0, 11.0), samples: (200, 380), a_period: 20.0 };
/// The least chi square of the hidden cause of a world: five standard deviations for an observer who knows it.
pub(super) const SEEN: f64 = 25.0;

/// Laws of several numbers that only some motions tell apart.
const DETERMINED: &[&str] =
    &["bouc-wen", "lugre", "maxwell", "maxwell-slip", "backlash", "drifting-friction"];

/// A record as the workflow sees it.
pub(super) struct Shown {
    pub(super) times: Vec<f64>,
    /// Columns of the states that are measured: with noise.
    pub(super) columns: Vec<Vec<f64>>,
    /// Value and slope of the drive.
    pub(super) drive: Vec<(f64, f64)>,
    pub(super) lines: Vec<Line>,
}

/// A set that is ready to be written.
pub(super) struct Made {
    pub(super) rig: Rig,
    /// Indices of the measured states and their names.
    pub(super) measured: Vec<(usize, String)>,
    /// One record, split at a sample, or two.
    pub(super) records: Vec<Shown>,
    pub(super) split: usize,
    /// The amplitude of the drive is a constant of each record.
    pub(super) own_amplitude: bool,
    pub(super) truth: Truth,
    pub(super) effects: Vec<Effect>,
    pub(super) experiments: Vec<Experiment>,
    /// The exact motion of each record.
    pub(super) motions: Vec<Motion>,
}

/// Draws until a set is fair.
///
/// # Errors
/// No draw was fair; the text counts the reasons.
pub(super) fn made(wish: &Wish, dice: &mut Dice) -> Result<Made, String> {
    let mut reasons = std::collections::BTreeMap::<&str, usize>::new();
    for _ in 0..TRIES {
        match attempt(wish, dice) {
            Ok(made) => return Ok(made),
            Err(why) => *reasons.entry(why).or_default() += 1,
        }
    }
    Err(format!("{TRIES} draws of {wish:?} were not fair: {reasons:?}"))
}

/// One draw: a rig, its effects, their motion, the noise, and the checks of all of them.
fn attempt(wish: &Wish, dice: &mut Dice) -> Result<Made, &'static str> {
    let friction = match &wish.kind {
        Kind::Laws(laws) => laws.iter().any(|l| HOLDING.contains(l)),
        Kind::Outside(kind) => kind.ends_with("friction"),
        Kind::Nothing | Kind::Constant(_) => false,
    };
    let world = matches!(wish.purpose, Purpose::World(_));
    let mut rig = Rig::draw(dice, wish.two_masses, friction && wish.holds);
    // A single cosine draws one closed curve over displacement and velocity, along which many formulas are
    // the same.
    let forced = matches!(rig.drive, Drive::Explicit(_) | Drive::Force(_)) && rig.lines.len() > 1;
    if matches!(wish.purpose, Purpose::Formula(_)) && !forced {
        return Err("not forced by several cosines");
    }
    if wish.kind == Kind::Nothing && dice.chance(0.25) {
        add_nonlinear_term(&mut rig, dice);
    }
    if !matches!(wish.purpose, Purpose::Formula(_)) {
        movables(&mut rig, wish, dice);
    }
    let (experiments, split) = experiments(&rig, if world { &SHORT } else { &LONG }, dice);
    let simulated = if world { independent::motion } else { motion };
    let run = |effects: &[Effect], before: f64| -> Result<Vec<Motion>, &'static str> {
        let one = |c: &Experiment| simulated(&rig, effects, c, before).map_err(|_| "not simulated");
        experiments.iter().map(one).collect()
    };
    let mut base = run(&[], 0.0)?;
    let mut effects = effects(&rig, wish, &experiments[0], &base[0], dice)?;
    if experiments.len() == 1 {
        effects.iter_mut().for_each(|e| e.second_phase = None);
    }
    let before = earlier(&effects);
    let motions = run(&effects, before)?;
    if before > 0.0 {
        base = run(&[], before)?;
    }
    let stuck_share = check_sticking(wish, friction, &motions)?;
    let with_velocity = dice.chance(0.75) && wish.sensors == Sensors::Mixed;
    let states = if with_velocity { 2 * rig.count() } else { rig.count() };
    let measured: Vec<(usize, String)> = match wish.sensors {
        Sensors::Acceleration => {
            let several = rig.count() > 1;
            let name = |k: usize| if several { format!("a{}", k + 1) } else { "a".to_owned() };
            (0..rig.count()).map(|k| (ACCELERATION + k, name(k))).collect()
        }
        _ => rig.x.iter().chain(&rig.v).cloned().enumerate().take(states).collect(),
    };
    let Noisy { records, sigma, gaps } = add_sensor_noise(
        wish,
        rig.count(),
        &measured,
        &experiments,
        &motions,
        &base,
        split,
        Streams(dice.seed()),
    )?;
    let drawn = Drawn { rig, effects, experiments, motions, base, measured, split };
    let judgement = drawn.judgement(wish, gaps, &sigma)?;
    if !world && !steady(&drawn.rig, &drawn.effects, &drawn.experiments, &drawn.motions, before, wish.noise) {
        return Err("the motion is too sensitive to its start");
    }
    let truth = drawn.truth(wish, &records, gaps, stuck_share, judgement, &sigma);
    let Drawn { rig, measured, effects, experiments, motions, .. } = drawn;
    let own_amplitude = records.len() == 2
        && matches!(rig.drive, Drive::Explicit(_))
        && records[0].lines.len() == 1
        && records[0].lines != records[1].lines;
    Ok(Made { rig, measured, records, split, own_amplitude, truth, effects, experiments, motions })
}

/// Adds a known Coulomb friction or a known cubic spring to a rig in which nothing is hidden.
fn add_nonlinear_term(rig: &mut Rig, dice: &mut Dice) {
    let force = rig.size * rig.spring[0];
    let (extra, name, value, unit) = if dice.chance(0.5) {
        (Extra::Coulomb, "Fk", dice.log(0.05, 0.4) * force, "N")
    } else {
        (Extra::Cubic, "kn", dice.log(0.05, 1.0) * force / rig.size.powi(3), "N/m^3")
    };
    let unit = if rig.inertia { unit } else { "" };
    rig.extra = Some(extra);
    rig.constants.push(Constant { name: name.to_owned(), value: rounded(value), unit, movable: None });
}

/// The part of the samples of the first record in which a contact sticks.
///
/// # Errors
/// The motion sticks although it should not, or the reverse, or it sticks most of the time.
fn check_sticking(wish: &Wish, friction: bool, motions: &[Motion]) -> Result<f64, &'static str> {
    let stuck = motions[0].stuck.iter().filter(|s| **s).count() as f64 / motions[0].stuck.len() as f64;
    if friction
        && !matches!(wish.purpose, Purpose::World(_))
        && (wish.holds != (stuck > 0.02) || (!wish.holds && motions.iter().any(|m| m.stuck.contains(&true))))
    {
        return Err("sticking is not as wished");
    }
    if stuck > 0.6 {
        return Err("it hardly moves");
    }
    Ok(stuck)
}

/// Records with noise.
struct Noisy {
    records: Vec<Shown>,
    /// Standard deviation of the noise of each measured column of the first record.
    sigma: Vec<f64>,
    gaps: Gaps,
}

/// Adds noise to the readings of all records, and measures the gap between them and the known part.
///
/// # Errors
/// A column does not move.
#[expect(clippy::too_many_arguments, reason = "what a record is made of")]
fn add_sensor_noise(
    wish: &Wish,
    masses: usize,
    measured: &[(usize, String)],
    experiments: &[Experiment],
    motions: &[Motion],
    base: &[Motion],
    split: usize,
    streams: Streams,
) -> Result<Noisy, &'static str> {
    let mut sigma = Vec::new();
    let mut records = Vec::new();
    let (mut fit, mut validate) = ((0.0, 0usize), (0.0, 0usize));
    for (r, (experiment, motion)) in experiments.iter().zip(motions).enumerate() {
        let mut columns = Vec::new();
        for (k, (state, name)) in measured.iter().enumerate() {
            let exact = motion.reading(*state, masses);
            // A sensor's noise does not know how far a run goes.
            let own = matches!(wish.purpose, Purpose::World(_)).then(|| sigma.get(k).copied()).flatten();
            let deviation = own.unwrap_or(wish.noise * standard_deviation(exact));
            if deviation <= 0.0 || !deviation.is_finite() {
                return Err("nothing moves");
            }
            let purpose = format!("noise of {name} in {r}");
            let noisy = match wish.purpose {
                Purpose::World(noise) => {
                    noise.read(exact, deviation, &mut Dice::new(streams.seed(&purpose), ""))
                }
                Purpose::Blind | Purpose::Formula(_) => {
                    let mut noisy = exact.clone();
                    add_noise(&mut noisy, Noise::Sensor(deviation), &mut streams.stream(&purpose));
                    noisy
                }
            };
            if r == 0 {
                sigma.push(deviation);
            }
            for (i, y) in noisy.iter().enumerate() {
                let e = (y - base[r].quantity(*state, masses)[i]) / deviation;
                let sum = if r == 0 && i < split { &mut fit } else { &mut validate };
                *sum = (sum.0 + e * e, sum.1 + 1);
            }
            columns.push(noisy);
        }
        let drive = experiment.times.iter().map(|&t| Rig::drive_at(&experiment.lines, t)).collect();
        records.push(Shown {
            times: experiment.times.clone(),
            columns,
            drive,
            lines: experiment.lines.clone(),
        });
    }
    let gap = |(sum, count): (f64, usize)| (sum / count as f64).sqrt();
    Ok(Noisy { records, sigma, gaps: Gaps { fit: gap(fit), validate: gap(validate) } })
}

/// A rig with its effects and exact motions.
struct Drawn {
    rig: Rig,
    effects: Vec<Effect>,
    experiments: Vec<Experiment>,
    /// The motion of each record with the effects, and that of the known part alone.
    motions: Vec<Motion>,
    base: Vec<Motion>,
    measured: Vec<(usize, String)>,
    split: usize,
}

impl Drawn {
    /// Compares the effects with the rest of the catalogue; the default where nothing is hidden.
    ///
    /// # Errors
    /// The set is not fair: why.
    fn judgement(&self, wish: &Wish, gaps: Gaps, sigma: &[f64]) -> Result<Judgement, &'static str> {
        if wish.kind == Kind::Nothing {
            return Ok(Judgement::default());
        }
        let world = matches!(wish.purpose, Purpose::World(_));
        let fair = (GAPS.0..=GAPS.1).contains(&gaps.validate) && (GAPS.0..=1.5 * GAPS.1).contains(&gaps.fit);
        if !world && !fair {
            return Err("the gap is too small or too large");
        }
        let experiment = first_part(&self.experiments[0], self.split);
        let motion = first_part_of_motion(&self.motions[0], self.split);
        let base = first_part_of_motion(&self.base[0], self.split);
        let columns: Vec<(usize, String, f64)> =
            self.measured.iter().zip(sigma).map(|((k, n), s)| (*k, n.clone(), *s)).collect();
        let seen = Seen {
            rig: &self.rig,
            effects: &self.effects,
            experiment: &experiment,
            motion: &motion,
            base: &base,
            columns: &columns,
        };
        if world { possible(&seen) } else { visible(&seen) }?;
        let mut judgement = judge(&seen);
        let outside = matches!(wish.kind, Kind::Outside(_));
        if world {
            if judgement.visible < SEEN {
                return Err("start states and constants absorb it");
            }
            if outside && self.effects.iter().all(Effect::is_force) {
                let (apart, near) = near(&seen);
                judgement.apart = Some(apart);
                judgement.same.extend(near);
            }
            return Ok(judgement);
        }
        if let Purpose::Formula(accuracy) = wish.purpose {
            let freedom: usize = self.effects.iter().map(Effect::freedom).sum();
            let error = (freedom as f64 / judgement.visible).sqrt();
            let measured: Vec<(usize, f64)> = columns.iter().map(|(k, _, noise)| (*k, *noise)).collect();
            let told = error < accuracy
                && determined(&self.rig, &self.effects, &self.experiments[0], self.split, &measured);
            return if told { Ok(judgement) } else { Err("the record does not tell the force") };
        }
        if judgement.visible < VISIBLE {
            return Err("start states and constants absorb it");
        }
        if outside && judgement.remainder < REMAINDER {
            return Err("the catalogue describes it nearly");
        }
        if !outside && judgement.margin < MARGIN {
            return Err("a rival is too near");
        }
        let measured: Vec<(usize, f64)> = columns.iter().map(|(k, _, noise)| (*k, *noise)).collect();
        let remembers = |e: &Effect| DETERMINED.contains(&e.law.as_str());
        if self.effects.iter().any(remembers)
            && !determined(&self.rig, &self.effects, &self.experiments[0], self.split, &measured)
        {
            return Err("the record does not tell the numbers");
        }
        Ok(judgement)
    }

    /// What `truth.json` says of the set.
    fn truth(
        &self,
        wish: &Wish,
        records: &[Shown],
        gaps: Gaps,
        stuck_share: f64,
        judgement: Judgement,
        sigma: &[f64],
    ) -> Truth {
        let (rig, measured, split) = (&self.rig, &self.measured, self.split);
        let hides = wish.kind != Kind::Nothing;
        let samples = if records.len() == 1 {
            [split, records[0].times.len() - split]
        } else {
            [split, records[1].times.len()]
        };
        let kind = match &wish.kind {
            Kind::Nothing => "nothing",
            Kind::Laws(laws) if laws.len() == 1 => "one",
            Kind::Laws(_) => "two",
            Kind::Outside(_) => "outside",
            Kind::Constant(_) => "constant",
        };
        let movable = rig.constants.iter().filter(|c| c.movable.is_some());
        Truth {
            kind: kind.to_owned(),
            alternatives: alternatives(&self.effects, &judgement, rig, measured),
            effects: self.effects.iter().map(hidden).collect(),
            noise: wish.noise,
            sticks: stuck_share > 0.0,
            stuck_share,
            masses: rig.count(),
            gap_before: gaps,
            margin: (hides && judgement.margin.is_finite()).then_some(judgement.margin),
            nearest: judgement.nearest,
            gap_fitted: hides.then(|| {
                let data = (split * measured.len()) as f64;
                (1.0 + judgement.visible / data).sqrt()
            }),
            remainder: matches!(wish.kind, Kind::Outside(_)).then_some(judgement.remainder),
            sigma: measured.iter().map(|(_, n)| n.clone()).zip(sigma.iter().copied()).collect(),
            movable: movable.map(|c| (c.name.clone(), c.value)).collect(),
            rig: described(rig, records.len()),
            samples,
            apart: judgement.apart,
            shown: judgement.apart.map(|_| judgement.shown),
            noise_kind: match wish.purpose {
                Purpose::World(noise) => noise.name(),
                Purpose::Blind | Purpose::Formula(_) => "white",
            }
            .to_owned(),
        }
    }
}

/// In some sets a stiffness or a damping is only known within bounds, but never the one that the hidden law
/// changes.
fn movables(rig: &mut Rig, wish: &Wish, dice: &mut Dice) {
    let share = if matches!(&wish.kind, Kind::Laws(laws) if laws.len() == 2) { 0.1 } else { 0.25 };
    if !dice.chance(share) {
        return;
    }
    let about = |letters: &str| {
        matches!(&wish.kind, Kind::Laws(laws) if laws.iter().any(|law| match *law {
            "viscous" | "van-der-pol" => letters == "c",
            "stiffness" | "dead-zone" => letters == "k",
            _ => false,
        }))
    };
    let (first, second) = (dice.chance(0.7), dice.chance(0.5));
    let chosen: &[&str] = match (first, second) {
        (true, true) => &["c"],
        (true, false) => &["k"],
        (false, _) => &["c", "k"],
    };
    for letter in chosen.iter().filter(|l| !about(l)) {
        let off = if *letter == "c" { dice.between(0.6, 1.5) } else { dice.between(0.93, 1.07) };
        for c in rig.constants.iter_mut().filter(|c| c.name == *letter || c.name == format!("{letter}1")) {
            let nominal = rounded(c.value * off);
            let (low, high) =
                if *letter == "c" { (0.0, 4.0 * nominal) } else { (0.8 * nominal, 1.25 * nominal) };
            c.movable = Some((nominal, rounded(low), rounded(high)));
        }
    }
}

fn effects(
    rig: &Rig,
    wish: &Wish,
    experiment: &Experiment,
    base: &Motion,
    dice: &mut Dice,
) -> Result<Vec<Effect>, &'static str> {
    let none: [Effect; 0] = [];
    let seen = Seen { rig, effects: &none, experiment, motion: base, base, columns: &[] };
    let all = places(rig);
    let force = experiment.times.iter().map(|&t| Rig::drive_at(&experiment.lines, t)).fold(
        0.0_f64,
        |m, (value, slope)| {
            let f = match rig.drive {
                Drive::Base { .. } => rig.spring[0] * value + rig.damper[0] * slope,
                _ => value,
            };
            m.max(f.abs())
        },
    );
    let scales = |place: &Place| {
        let (x, v) = place_motion(&seen, place);
        // The first half of a released motion counts, otherwise the second half: the stationary motion.
        let part = if rig.drive == Drive::Free { 0..x.len() / 2 } else { x.len() / 2..x.len() };
        let (x, v) = (largest(&x[part.clone()]), largest(&v[part]));
        let force = if rig.drive == Drive::Free { 0.3 * x * rig.spring[0] } else { force };
        Scales { x, v, force, time: experiment.times[experiment.times.len() - 1] }
    };
    let duration = experiment.times[experiment.times.len() - 1];
    let columns: Vec<(String, f64)> =
        rig.x.iter().chain(&rig.v).cloned().zip(base.states.iter().map(|x| largest(x))).collect();
    let mut out: Vec<Effect> = Vec::new();
    let laws: &[&str] = match &wish.kind {
        Kind::Nothing => &[],
        Kind::Laws(laws) => laws,
        Kind::Outside(kind) => {
            let place = dice.pick(&all);
            let drawn = never::draw(kind, place, scales(place), dice)
                .or_else(|| outside::draw(kind, place, scales(place), rig, duration, dice, wish.holds))
                .or_else(|| draw_sensor(kind, &columns, rig.count(), rig.natural, dice));
            return drawn.map(|e| vec![e]).ok_or("no such effect");
        }
        Kind::Constant(letter) => {
            return draw_constant(letter, rig, dice).map(|e| vec![e]).ok_or("no such constant");
        }
    };
    for law in laws {
        let of_instrument = draw_sensor(law, &columns, rig.count(), rig.natural, dice);
        let effect = match of_instrument.or_else(|| draw_input(law, rig, dice)) {
            Some(effect) => effect,
            None => {
                let place = dice.pick(&all);
                // A constant or harmonic force does not depend on the motion: its place is a mass.
                if place.wall != 0.0 && matches!(*law, "offset" | "harmonic-force") {
                    return Err("no such place");
                }
                draw(law, place, scales(place), rig, dice, wish.holds).ok_or("no such place")?
            }
        };
        if out.iter().any(|e| e.law == effect.law && e.at == effect.at) {
            return Err("twice the same");
        }
        out.push(effect);
    }
    // The measured columns are drawn later, so the set may still be rejected because of its sensor.
    Ok(out)
}
