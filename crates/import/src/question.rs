//! Questions that a data file leaves open, and the answers of the user.

use crate::headings::{ACCELERATIONS, Heading, Quantity};
use crate::rig::Rig;
use phisindy_phys::unit::Unit;
use std::fmt;

/// What stands before a question that is open, in the comment at the head of a draft.
pub const OPEN_QUESTION: &str = "QUESTION: ";

/// What a draft has to know and the file does not say. A search before it is answered would be one on an
/// invention.
#[derive(Clone, Debug, PartialEq)]
pub enum Question {
    /// The motion is counted: how many are a turn or a length?
    Counts {
        /// Heading of the column.
        heading: String,
        /// What it counts.
        of: Counted,
    },
    /// No heading tells which of these columns moves and which drives.
    Columns {
        /// Their headings, or numbers.
        headings: Vec<String>,
        /// Number of columns of the file.
        all: usize,
    },
    /// The motion has no unit, and its name or size leaves open what it may be in.
    Unit {
        /// Heading of the motion.
        heading: String,
        /// The unit that the draft takes.
        taken: &'static str,
    },
    /// Nothing that drives the motion is measured, and it does not die out.
    Drive {
        /// Heading of the motion.
        heading: String,
        /// Of an accelerometer, heading of another one, which may be on the base.
        beside: Option<String>,
    },
    /// Of two displacements no heading says whether one is the base of the other.
    Base {
        /// Heading of the motion.
        body: String,
        /// Heading of what may be the base.
        base: String,
    },
    /// The numbers do not tell whether a force drives the motion or is what a prescribed motion meets.
    Force {
        /// Heading of the motion.
        motion: String,
        /// Heading of the force.
        force: String,
    },
    /// The file has no times, and is of cycles whose force may hang on the way alone.
    Rate,
    /// The unit in the heading of the time makes no record of a motion.
    TimeUnit {
        /// Heading of the column.
        heading: String,
        /// The unit that it states.
        unit: String,
        /// Median step, as a number in the file.
        step: f64,
        /// The unit that the draft takes.
        taken: String,
    },
}

/// What is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counted {
    /// Turns or lengths.
    Motion {
        /// Whether the file says that these are counts; else they are whole numbers without a unit.
        said: bool,
    },
    /// The acceleration of a sensor.
    Acceleration,
}

impl fmt::Display for Question {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Question::Counts { heading, of: Counted::Acceleration } => {
                write!(f, "`{heading}` counts: how many counts are the acceleration of gravity?")
            }
            Question::Counts { heading, of: Counted::Motion { said } } => {
                let what = if *said { "counts" } else { "has whole numbers and no unit" };
                write!(f, "`{heading}` {what}: how many counts are a turn or a millimetre?")
            }
            Question::Columns { headings, .. } => {
                let list = headings.iter().take(MOST_SHOWN).map(|h| format!("`{h}`"));
                let more = if headings.len() > MOST_SHOWN { ", ..." } else { "" };
                let list = list.collect::<Vec<_>>().join(", ");
                write!(f, "no heading says what {list}{more} are: which one moves, and what drives it?")
            }
            Question::Unit { heading, taken } => {
                write!(f, "`{heading}` has no unit, and may be another thing than {taken}: what is it in?")
            }
            Question::Drive { heading, beside: Some(other) } => {
                write!(
                    f,
                    "`{heading}` does not die out: is `{other}` the acceleration of the base that drives it?"
                )
            }
            Question::Drive { heading, beside: None } => {
                write!(
                    f,
                    "`{heading}` does not die out, and nothing that drives it is measured: what drives it?"
                )
            }
            Question::Base { body, base } => {
                write!(f, "`{body}` and `{base}` both move: is `{base}` the base that moves the other?")
            }
            Question::Force { motion, force } => {
                write!(
                    f,
                    "does `{force}` drive `{motion}`, or is it what the prescribed motion `{motion}` meets?"
                )
            }
            Question::Rate => f.write_str("there are no times: how many rows are there in a second?"),
            Question::TimeUnit { heading, unit, step, taken } => write!(
                f,
                "the heading `{heading}` says {unit}, and steps of {step} {unit} make no record of a motion: \
                 is it {taken}?"
            ),
        }
    }
}

impl Question {
    /// How to answer on the command line.
    pub fn answer(&self) -> String {
        match self {
            Question::Counts { of: Counted::Acceleration, .. } => {
                "say `--counts 16384/gn`, with the number of your sensor".to_owned()
            }
            Question::Counts { .. } => {
                "say `--counts 4096/rev` or `--counts 200/mm`, with the numbers of your rig".to_owned()
            }
            Question::Columns { all, .. } => format!(
                "say `--columns time_s,x_mm,F_N`, a name with its unit for each of the {all} columns, \
                 and `-` for one that is not used"
            ),
            Question::Unit { .. } => {
                "say `--columns time_s,angle_deg,F_N`, a name with its unit for each column, and `-` for one that is not \
                 used; or write the unit into the heading"
                    .to_owned()
            }
            Question::Drive { beside: Some(_), .. } => {
                "say `--rig base-excited` if it is, `--rig free` if nothing drives it"                    .to_owned()
            }
            Question::Drive { beside: None, .. } => {
                "give a file with the force, the current or the motion of the base beside it, \
                 or say `--rig free` if nothing does"
                    .to_owned()
            }
            Question::Base { .. } => {
                "say `--rig base-excited` if it is; if the other one is, `--columns time_s,base_mm,x_mm` in the order \
                 of the file; else the kind of rig"
                    .to_owned()
            }
            Question::Force { .. } => {
                "say `--rig slider` if it drives a body, `--rig tester` if the motion is prescribed"
                    .to_owned()
            }
            Question::Rate => "say `--rate 500Hz`; of cycles that are so slow that the force hangs on the way alone, \
                 `--rate 1Hz --rig tester`"
                .to_owned(),
            Question::TimeUnit { .. } => {
                "say `--time-unit us` (or s, ms, ns, min, h), or correct the heading".to_owned()
            }
        }
    }

    /// Adds what a user answers to what is known of the file: `4096/rev`, `us`, `time_s,x_mm,F_N`, `free`.
    ///
    /// # Errors
    /// In words: what the answer should be.
    pub fn answered(&self, text: &str, answers: &mut Answers) -> Result<(), String> {
        match self {
            Question::Counts { heading, .. } => {
                let own = CountUnit::parse(text)?;
                answers
                    .counts
                    .push(CountUnit { heading: own.heading.or_else(|| Some(heading.clone())), ..own });
            }
            Question::Unit { heading, .. } => answers.units.push((heading.clone(), unit_of_motion(text)?)),
            Question::Columns { .. } => {
                answers.columns = text.split(',').map(|name| name.trim().to_owned()).collect();
            }
            Question::Drive { .. } | Question::Base { .. } | Question::Force { .. } => {
                answers.rig = Some(Rig::parse(text)?);
            }
            Question::Rate => answers.rate = Some(rate(text)?),
            Question::TimeUnit { .. } => answers.time_unit = Some(time_unit(text)?),
        }
        Ok(())
    }

    /// How to answer in the spec of the draft.
    pub(crate) fn edit(&self) -> String {
        match self {
            Question::Counts { heading, of: Counted::Acceleration } => {
                format!("write `(\"{heading}\", \"gn/16384\")` and states in m; as it is all is in counts")
            }
            Question::Counts { heading, .. } => format!(
                "write `(\"{heading}\", \"rev/4096\")` for 4096 counts a turn and the state in rad, \
                 or `\"mm/200\"` and m; as it is all is in counts"
            ),
            Question::Columns { .. } => {
                "it is drafted as free, with the first of them as the motion".to_owned()
            }
            Question::Unit { heading, taken } => {
                format!("it is taken for {taken}; write `(\"{heading}\", \"deg\")` or another unit in the records")
            }
            Question::Drive { .. } => "it is drafted as free; delete this line if it is".to_owned(),
            Question::Base { .. } => "it is drafted as one; delete this line if it is".to_owned(),
            Question::Force { .. } => {
                "it is drafted as a force on a body; delete this line if it is".to_owned()
            }
            Question::Rate => {
                "a row is taken for a second: what hangs on the speed means nothing; delete this line if the cycles are slow"
                    .to_owned()
            }
            Question::TimeUnit { taken, .. } => {
                format!("the records take {taken}; write the right unit there, and the windows in seconds")
            }
        }
    }
}

/// Most headings in a question.
const MOST_SHOWN: usize = 6;

/// Rows per second, as a user says them: `1000`, `50 Hz`, `2kHz`.
///
/// # Errors
/// In words: what it should be.
pub fn rate(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let (number, factor) = match (text.strip_suffix("kHz"), text.strip_suffix("Hz")) {
        (Some(number), _) => (number, 1e3),
        (None, Some(number)) => (number, 1.0),
        (None, None) => (text, 1.0),
    };
    let rate = number.trim().parse::<f64>().map(|rate| rate * factor);
    let sound = rate.ok().filter(|rate| rate.is_normal() && *rate > 0.0);
    sound.ok_or("a number of rows per second, as in 1000 or 2kHz".to_owned())
}

/// A unit of a length or an angle, as a user says it.
///
/// # Errors
/// In words: what is one.
fn unit_of_motion(text: &str) -> Result<String, String> {
    let of = Heading::parse(&format!("x [{text}]"));
    let unit = of.unit.filter(|_| matches!(of.quantity, Quantity::Length | Quantity::Angle));
    unit.ok_or("a unit of a length or an angle, such as m, mm, rad, deg, rev".to_owned())
}

/// A unit of time, as a user says it.
///
/// # Errors
/// In words: what is one.
pub fn time_unit(text: &str) -> Result<String, String> {
    let second = Unit::parse("s").map(|unit| unit.dimension).ok();
    let unit = Unit::parse(text).ok().filter(|unit| Some(unit.dimension) == second);
    unit.map(|_| text.trim().to_owned()).ok_or("a unit of time, such as s, ms, us, ns".to_owned())
}

/// What the user says of a file beside what it holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answers {
    /// Rows per second, in the place of times.
    pub rate: Option<f64>,
    /// Names of the columns, with their units, in the place of their headings: in order, `-` for one that is
    /// not used. None: the headings of the file.
    pub columns: Vec<String>,
    /// The unit of the time.
    pub time_unit: Option<String>,
    /// What a count is.
    pub counts: Vec<CountUnit>,
    /// Headings without a unit, and what they are in.
    pub units: Vec<(String, String)>,
    /// The kind of rig.
    pub rig: Option<Rig>,
}

/// What a count of an encoder is.
#[derive(Clone, Debug, PartialEq)]
pub struct CountUnit {
    /// Heading of the column; none for all that count.
    pub heading: Option<String>,
    /// The unit of a count, as specs write it: `rev/4096`.
    pub unit: String,
}

impl Answers {
    /// The unit of the counts of a column, if it is said of this one.
    pub(crate) fn own_unit_of(&self, heading: &Heading) -> Option<&str> {
        let own = self.counts.iter().find(|c| c.heading.as_deref() == Some(heading.raw.as_str()));
        own.map(|c| c.unit.as_str())
    }

    /// The unit of the counts of a motion, if it is said: of this column, or of all whose kind it fits.
    pub(crate) fn unit_of(&self, heading: &Heading) -> Option<&str> {
        let general = || self.counts.iter().find(|c| c.heading.is_none() && c.fits(heading));
        self.own_unit_of(heading).or_else(|| general().map(|c| c.unit.as_str()))
    }
}

impl CountUnit {
    /// What `4096/rev` says of all columns that count, `enc_motor=4096/rev` of one of them.
    ///
    /// # Errors
    /// In words: what it should say.
    ///
    /// ```
    /// use phisindy_import::CountUnit;
    /// let said = CountUnit::parse("enc_motor=4096/rev").unwrap();
    /// assert_eq!((said.heading.as_deref(), said.unit.as_str()), (Some("enc_motor"), "rev/4096"));
    /// assert!(CountUnit::parse("4096/kg").is_err());
    /// ```
    pub fn parse(text: &str) -> Result<CountUnit, String> {
        let wrong = || "how many counts are a turn or a length, as in 4096/rev or 200/mm".to_owned();
        let (heading, ratio) = match text.rsplit_once('=') {
            Some((heading, ratio)) => (Some(heading.trim().to_owned()), ratio),
            None => (None, text),
        };
        let (number, unit) = ratio.split_once('/').ok_or_else(wrong)?;
        let (number, unit) = (number.trim(), unit.trim());
        let many = number.parse::<f64>().is_ok_and(|n| n.is_normal() && n > 0.0);
        let of = Heading::parse(&format!("x [{unit}]"));
        let measures = matches!(of.quantity, Quantity::Angle | Quantity::Length | Quantity::Acceleration);
        let unit = format!("{}/{number}", of.unit.unwrap_or_default());
        let sound = many && measures && Unit::parse(&unit).is_ok();
        sound.then_some(CountUnit { heading, unit }).ok_or_else(wrong)
    }

    /// Whether a column may count that: an accelerometer gravities, an encoder turns or lengths.
    fn fits(&self, heading: &Heading) -> bool {
        let accelerates = Heading::parse(&format!("x [{}]", self.unit)).quantity == Quantity::Acceleration;
        accelerates == heading.has_word(ACCELERATIONS)
    }
}
