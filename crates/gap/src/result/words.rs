//! All sentences of this crate: data to text.

use super::{
    Activity, Alternative, AlternativeConstant, Cancelling, Cause, CoarseInput, DataError, DataMistake,
    Dependence, DriveFrequency, GapError, InputError, InputNoise, Location, MissingForce, ModelError, Named,
    NamedValue, PlacedLaw, Push, Rival, RoundStart, SensorNonlinearity, SpecMistake, Veto, Vetoed, Warning,
};
use std::f64::consts::TAU;
use std::fmt::{Display, Formatter, Result};

impl Display for PlacedLaw {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "{} at {}", self.name, self.at)
    }
}

impl Rival {
    /// The ids of its laws, joined by ` + `.
    pub fn law(&self) -> String {
        joined(self.laws.iter().map(|l| l.law.as_str()), " + ")
    }

    /// Their places, joined by `, `.
    pub fn at(&self) -> String {
        joined(self.laws.iter().map(|l| l.at.as_str()), ", ")
    }
}

impl Display for Rival {
    /// Examples: `stribeck at v`, `coulomb + viscous at v`, `coulomb at v1 + viscous at v2`. A place that all
    /// laws share is written once.
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self.laws.first() {
            Some(first) if self.laws.iter().all(|l| l.at == first.at) => {
                write!(f, "{} at {}", self.law(), first.at)
            }
            _ => f.write_str(&joined(self.laws.iter().map(ToString::to_string), " + ")),
        }
    }
}

fn joined<T: AsRef<str>>(parts: impl Iterator<Item = T>, between: &str) -> String {
    parts.map(|p| p.as_ref().to_owned()).collect::<Vec<_>>().join(between)
}

impl Display for MissingForce {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let on = match self.on {
            Dependence::Velocity => "the velocity alone",
            Dependence::Displacement => "the displacement alone",
            Dependence::Sum => "the displacement and the velocity, as a sum",
            Dependence::Together => "displacement and velocity together",
            Dependence::Past => {
                return write!(
                    f,
                    "the missing force at {} depends on the past: at the same displacement and velocity it differs with what went before (hysteresis, a contact that gives way, a spring behind a dashpot); no force of displacement and velocity leaves less than {:.2} times the noise",
                    self.at, self.left
                );
            }
            Dependence::Time => {
                return write!(
                    f,
                    "the missing force at {} changes with time: at the same displacement and velocity it differs in the course of a record; no force of displacement and velocity leaves less than {:.2} times the noise",
                    self.at, self.left
                );
            }
            Dependence::More => {
                return write!(
                    f,
                    "the missing force at {} differs at the same displacement and velocity ({:.2} times the noise is left): it depends on the past (hysteresis), on time or on an input, or acts in several places",
                    self.at, self.left
                );
            }
        };
        // The screen is exact near the data only, and one loop run through again and again hides what the
        // past does.
        write!(
            f,
            "along these records the missing force at {} follows {on}, to first order; no formula of it passes as a simulation, so the past, time or another place may play a part",
            self.at
        )
    }
}

impl Display for RoundStart {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        if self.number == 0 { Ok(()) } else { write!(f, "round {}: ", self.number) }
    }
}

impl Display for Activity {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.write_str(match self {
            Activity::Screening(round) => return write!(f, "{round}looking at every law at every place"),
            Activity::Comparing { round, done, all } => {
                return write!(f, "{round}{done} of {all} models compared over short segments");
            }
            Activity::Fitting { round, done, all, best } => {
                write!(f, "{round}{done} of {all} fits")?;
                let Some(best) = best else { return Ok(()) };
                // The first fits of a round are not its best.
                if best.gap >= round.gap {
                    return write!(f, ", none leaves less than the gap of {} so far", rounded(round.gap));
                }
                // What is new comes first: the line may be cut off.
                let laws = joined(best.laws.iter().rev().map(PlacedLaw::to_string), " + ");
                return write!(f, ", gap {} -> {}, best {laws}", rounded(round.gap), rounded(best.gap));
            }
            Activity::Calibrating => "fitting the movable constants",
            Activity::Formulas => "looking for a formula",
            Activity::FittingFormulas => "fitting the best formulas",
            Activity::ErrorBars => "error bars",
            Activity::Constants => "checking the constants that are held",
            Activity::OtherCauses => "looking for other causes",
        })
    }
}

impl Display for Veto {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Veto::FeedsMotion => {
                f.write_str("with it the total damping is negative at some speeds: it would feed the motion")
            }
            Veto::Requirement(because) => f.write_str(because),
            Veto::ParameterAtEnd { name, bound, unit } => {
                write!(f, "its {name} runs to the limit that the law allows ({bound:e} {unit})")
            }
            Veto::NotSeen(name) => {
                write!(
                    f,
                    "the records do not determine its {name}: of what the law allows, nothing near is excluded"
                )
            }
            Veto::NeverSlips => f.write_str("its contact never slips: it stands for a spring"),
            Veto::IsDryFriction => {
                f.write_str("its force hardly depends on the speed: it stands for dry friction")
            }
            Veto::Pushes => f.write_str("in places it would push instead of brake"),
            Veto::SlowTone(period) => write!(f, "no record lasts half of one of its periods ({period:.0} s)"),
            Veto::OwnFrequency { line, times, free } => {
                let multiple = if *times == 1 { String::new() } else { format!("{times} times ") };
                let whose = if *free { "the oscillation" } else { "the drive" };
                write!(
                    f,
                    "its frequency is {multiple}that of {whose} ({line:.4} rad/s), where it could stand in for anything else that is missing"
                )
            }
            Veto::Undetermined(names) => {
                write!(f, "the records do not determine {}: the intervals contain zero", names.join(" and "))
            }
            Veto::DoesNotGiveWay { stops, slope } => write!(
                f,
                "in {stops} stops the mass yields to the force on the contact by only {slope:.2} of what this law predicts: the contact does not give way"
            ),
        }
    }
}

impl Display for Vetoed {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "{} is ruled out: {}", self.law.law, self.why)
    }
}

/// A number to five digits with its unit.
impl Display for NamedValue {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "{} = {}", self.name, in_unit(self.value, &self.unit))
    }
}

fn in_unit(value: f64, unit: &str) -> String {
    let digits = format!("{value:.4e}").parse::<f64>().unwrap_or(value);
    if unit.is_empty() { format!("{digits}") } else { format!("{digits} {unit}") }
}

/// `, then Fc = 0.3 N, ...`
fn then(numbers: &[NamedValue]) -> String {
    let all: Vec<String> = numbers.iter().map(ToString::to_string).collect();
    if all.is_empty() { String::new() } else { format!(", then {}", all.join(", ")) }
}

impl Display for Alternative {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Alternative::Constant(constant) => constant.fmt(f),
            Alternative::Drive(drive) => drive.fmt(f),
            Alternative::InputNoise(noise) => noise.fmt(f),
            Alternative::Pushes(all) => {
                f.write_str(
                    "a force acts that nobody measured, and between its pushes the model leaves nothing: ",
                )?;
                f.write_str(&joined(all.iter().map(ToString::to_string), "; "))
            }
        }
    }
}

impl Display for AlternativeConstant {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let needless: Vec<String> = self.needless.iter().map(ToString::to_string).collect();
        let less =
            if needless.is_empty() { String::new() } else { format!(" without {}", needless.join(" and ")) };
        let other: String = self.other.iter().map(|law| format!(" and {law}")).collect();
        write!(
            f,
            "the known part may be wrong instead: with {} (the spec says {}){other} the model explains the data{less} (BIC {:.1} {}){}: how well is that constant known?",
            self.constant,
            in_unit(self.stated, &self.constant.unit),
            self.delta_bic.abs(),
            if self.delta_bic < 0.0 { "lower" } else { "higher" },
            then(&self.numbers)
        )
    }
}

impl Display for DriveFrequency {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let beside: String = self.beside.iter().map(|law| format!(", with {law}")).collect();
        let what = if self.explains {
            "check that frequency, and the clock of the records"
        } else {
            "something else is missing as well, which may show once that is corrected: let it move, `(value: .., within: (.., ..))`, and try again"
        };
        write!(
            f,
            "the drive may be off its frequency: at {:.5} times what the spec says{beside} the gap of the model as it is goes from {:.3} to {:.3}{}: {what}",
            self.ratio,
            self.gap.0,
            self.gap.1,
            then(&self.numbers)
        )
    }
}

impl Display for Push {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let Push { record, at, from, to, changes, unit } = self;
        let change = rounded(*changes);
        write!(f, "in {record} from {from:.3} to {to:.3} s at {at}, which it changes by {change} {unit}")
    }
}

impl Display for InputNoise {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let left = match self.left <= self.alone {
            true => format!("and no more is left ({:.2})", self.left),
            false => format!("where {:.2} is left", self.left),
        };
        write!(
            f,
            "the noise of {} from sample to sample moves the model but not the rig: noise of this size alone leaves a gap of about {:.2}, {left}; measure that input with less noise, or use what was commanded",
            self.inputs.join(" and "),
            self.alone,
        )
    }
}

impl Display for InputError {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let size = |value: f64| format!("{value:.2e} {}", self.unit).trim_end().to_owned();
        write!(
            f,
            "{}: what is left of `{}` ({}) is no more than the error of {} between its samples: interpolation of higher order moves the model by {}; no model can do better unless it is recorded faster",
            self.of.record,
            self.of.column,
            size(self.left),
            self.inputs.join(" and "),
            size(self.open)
        )
    }
}

impl Display for Named {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "of what is left of {} in {}", self.column, self.record)
    }
}

impl Display for Cause {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Cause::Drift { of, share, swing } => write!(
                f,
                "{:.0} % {of} grows with time, by {swing:.3e} (SI) from end to end: drift of a sensor, perhaps as it warms up; `detrend: {{ \"{}\": Linear }}` removes it",
                100.0 * share,
                of.column
            ),
            Cause::Bend { column, share } => write!(
                f,
                "{:.0} % of what is left of {column} is a curve over {column}: a sensor whose reading is not in proportion, or a force that bends the motion",
                100.0 * share
            ),
            Cause::Tone { of, share, frequency } => write!(
                f,
                "{:.0} % {of} is one tone of {frequency:.4} rad/s ({:.4} Hz): hum of the sensor or the mains, a drive that the model does not know, or the rig's own frequency, if it is not the model's",
                100.0 * share,
                frequency / TAU
            ),
        }
    }
}

impl Display for DataMistake {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            DataMistake::Scale { of, factor } => write!(
                f,
                "{}: `{}` has the shape that the model gives, but {factor:.3} times its size: are the units of the column, and of the forces, right?",
                of.record, of.column
            ),
            DataMistake::Proportion { of, factor } => write!(
                f,
                "{}: the model moves `{}` {factor:.1e} times as much as the record shows: are the units of the columns, of the forces and of the constants right?",
                of.record, of.column
            ),
            DataMistake::Swapped { of, other } => write!(
                f,
                "{}: `{}` fits what the model gives for `{other}`, and the other way round: the two columns are probably swapped",
                of.record, of.column
            ),
        }
    }
}

impl Display for Warning {
    // One arm for each sentence: the table is longer than 80 lines, and has no logic to divide.
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Warning::UnknownLeftOut { candidates } => {
                let what = if *candidates { "has candidates" } else { "asks for laws or formulas" };
                write!(f, "`unknown` {what}: `gap` leaves them out and searches the catalogue instead")
            }
            Warning::Curve { count, at } => write!(
                f,
                "{count} corrections of the spring at {at} describe its curve, as that many would describe any: they do not say which law it follows; a static test, force against displacement, would"
            ),
            Warning::ManyEffects { count, some_left } => {
                let what = if *some_left { "hardly more than noise" } else { "nothing but noise" };
                write!(
                    f,
                    "with {count} effects the model leaves {what}, but so many corrections may cover up one effect that no law here describes"
                )
            }
            Warning::Refused { law, fit, validate, follows } => {
                let why = if *follows { "" } else { ", where the model hardly moves any more" };
                write!(
                    f,
                    "{law} is not added: it takes the gap on the fitted data from {:.3} to {:.3}, and that on data not used from {:.3} to {:.3}{why}",
                    fit.0, fit.1, validate.0, validate.1
                )
            }
            Warning::Vetoed(vetoed) => {
                write!(f, "{} fits, but evidence speaks against it: {}", vetoed.law.name, vetoed.why)
            }
            Warning::Cancelling(Cancelling { laws, left }) => write!(
                f,
                "{} and {} cancel each other over most of the motion (what is left of the smaller one is {:.0} %): their sum approximates another law",
                laws.0,
                laws.1,
                100.0 * left
            ),
            Warning::OneFrequency(frequency) => write!(
                f,
                "all fitted records are driven at one frequency ({frequency:.4} rad/s, {:.4} Hz), where a stiffness, a delay, drag, and friction that varies along the path change the motion in nearly the same way: a run at another frequency would tell them apart",
                frequency / TAU
            ),
            Warning::Spec(SpecMistake::Constants { names, gap }) => write!(
                f,
                "with the values of {} and {} exchanged the gap is {gap:.3}: are they mixed up in the spec?",
                names.0, names.1
            ),
            Warning::Spec(SpecMistake::Column { of, other, relative, gap }) => {
                let (is, says) = if *relative {
                    ("relative to", "absolute")
                } else {
                    ("absolute, not relative to", "relative")
                };
                write!(
                    f,
                    "if {} is {is} {other}, the gap is {gap:.3}; the spec takes it for {says}: how is that sensor mounted?",
                    of.column
                )
            }
            Warning::Spec(SpecMistake::Sign { of, gap }) => {
                write!(
                    f,
                    "with {of} of the other sign the gap is {gap:.3}: which direction counts as positive there?"
                )
            }
            Warning::SensorNonlinearity(SensorNonlinearity { law, of, bend }) => write!(
                f,
                "the effect of {law} is so small that a slightly nonlinear sensor would look the same: in {} the scale of {} would have to bend by {:.2} % of the motion; calibrate it, or measure at a larger amplitude",
                of.record,
                of.column,
                100.0 * bend
            ),
            Warning::Redrawn { from, to } => write!(
                f,
                "with inputs that go `{to:?}` between their samples (`interpolate`; now {from:?}) the model explains the data: how does the input move there?"
            ),
            Warning::CoarseInput(CoarseInput { inputs, open, effect }) => write!(
                f,
                "{} has so few samples per period that another interpolation moves the model by {open:.2} times the noise, and what is left to explain by {effect:.2}: no effect of this size can be made out; record the input faster",
                joined(inputs.iter().map(|name| format!("`{name}`")), ", ")
            ),
            Warning::InputError(error) => error.fmt(f),
            Warning::Alternative(alternative) => alternative.fmt(f),
            Warning::Drive(drive) => drive.fmt(f),
            Warning::Cause(cause) => cause.fmt(f),
            Warning::Data(mistake) => mistake.fmt(f),
            Warning::Fit(warning) => warning.fmt(f),
        }
    }
}

impl Display for Location {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let told = |x: &f64, unit: &str| format!("{} {unit}", rounded(*x)).trim_end().to_owned();
        match self {
            Location::Everywhere => f.write_str("everywhere alike"),
            Location::Sticking => f.write_str("while it sticks"),
            Location::Switching => f.write_str("where it switches"),
            Location::Slipping => f.write_str("while it slips"),
            Location::FirstFifth => f.write_str("in the first fifth of the record"),
            Location::FirstHalf => f.write_str("in the first half of the record"),
            Location::LastHalf => f.write_str("in the last half of the record"),
            Location::LastFifth => f.write_str("in the last fifth of the record"),
            Location::Above { name, value, unit } => write!(f, "at {name} above {}", told(value, unit)),
            Location::Below { name, value, unit } => write!(f, "at {name} below {}", told(value, unit)),
            Location::SizeAbove { name, value, unit } => write!(f, "at |{name}| above {}", told(value, unit)),
            Location::SizeBelow { name, value, unit } => write!(f, "at |{name}| below {}", told(value, unit)),
        }
    }
}

impl Display for super::Region {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self.location {
            Location::Everywhere => self.location.fmt(f),
            _ => write!(f, "{} ({:.0} % of it)", self.location, 100.0 * self.power),
        }
    }
}

/// Rounds a location to three digits.
fn rounded(x: f64) -> String {
    let scientific = format!("{x:.2e}");
    match x.abs() {
        1e-3..1e5 => scientific.parse::<f64>().map_or(scientific, |x| x.to_string()),
        0.0 => "0".to_owned(),
        _ => scientific,
    }
}

impl Display for GapError {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            GapError::Data(error) => error.fmt(f),
            GapError::Numerics(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for GapError {}

impl Display for DataError {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            DataError::NoFit => f.write_str(
                "no record has the role Fit, so there is nothing to compare with: take `role: Validate` off one of them",
            ),
            DataError::FewSamples { record, samples, least } => write!(
                f,
                "{record}: {samples} samples are too few to tell noise from motion ({least} at least): take a longer window, or decimate less"
            ),
            DataError::DeadColumn(why) => why.fmt(f),
            DataError::MostlyNoise { record, share } => write!(
                f,
                "{record}: what was measured is mostly noise ({:.0} % of it): no motion to explain",
                100.0 * share
            ),
            DataError::Spec(why) => f.write_str(why),
        }
    }
}

impl Display for ModelError {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            ModelError::Fit(why) => write!(f, "the model as it is cannot be simulated: {why}"),
            ModelError::Effect(why) => why.fmt(f),
            ModelError::Text(why) => why.fmt(f),
            ModelError::Spec => f.write_str("the spec cannot be changed as the search needs it"),
        }
    }
}

impl std::error::Error for ModelError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_has_three_digits_of_any_size() {
        let cases =
            [(0.0, "0"), (0.012_345, "0.0123"), (-98_765.0, "-98800"), (2e-7, "2.00e-7"), (1.5e9, "1.50e9")];
        for (x, due) in cases {
            assert_eq!(rounded(x), due);
        }
    }

    #[test]
    fn a_place_that_all_laws_of_a_rival_share_is_said_once() {
        let law = |law: &str, at: &str| PlacedLaw { law: law.into(), name: law.into(), at: at.into() };
        let said = |laws| {
            Rival { laws, delta_bic: 1.0, behind: f64::INFINITY, same: false, completed: None, model: None }
                .to_string()
        };
        assert_eq!(said(vec![law("stribeck", "v")]), "stribeck at v");
        assert_eq!(said(vec![law("coulomb", "v"), law("viscous", "v")]), "coulomb + viscous at v");
        assert_eq!(said(vec![law("coulomb", "v1"), law("viscous", "v2")]), "coulomb at v1 + viscous at v2");
    }
}
