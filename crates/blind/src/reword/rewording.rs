//! The table of rewordings: ways to ask the same question in other words.

use super::answer::{Agree, Back};
use super::format::Format;
use super::question::Question;
use super::{data, model, order};
use crate::dice::Dice;
use phisindy_phys::spec::Spec;

/// The same question in other words, and the way back for its answer.
#[derive(Clone, Debug)]
pub(super) struct Reworded {
    pub(super) question: Question,
    pub(super) back: Back,
}

impl From<Question> for Reworded {
    fn from(question: Question) -> Reworded {
        Reworded { question, back: Back::default() }
    }
}

/// One rewording; none of a question that it does not apply to.
pub(super) struct Rewording {
    pub(super) name: &'static str,
    pub(super) agree: Agree,
    pub(super) of: fn(Question, &Spec, &mut Dice) -> Option<Reworded>,
}

const fn row(
    name: &'static str,
    agree: Agree,
    of: fn(Question, &Spec, &mut Dice) -> Option<Reworded>,
) -> Rewording {
    Rewording { name, agree, of }
}

/// All of them.
pub(super) const REWORDINGS: &[Rewording] = &[
    row("unit of a column", Agree::Bits, data::unit),
    row("unit of time", Agree::Bits, data::unit_of_time),
    row("g for m/s^2", Agree::Solver, data::gravities),
    row("gain for a unit", Agree::Solver, data::gain),
    row("counts", Agree::Solver, data::counts),
    row("quantum said", Agree::Solver, data::quantum),
    row("sign of a coordinate", Agree::Solver, model::sign),
    row("origin of a coordinate", Agree::Solver, model::origin),
    row("origin of time", Agree::Solver, |q, spec, _| data::from_origin(q, spec, data::ORIGIN)),
    // A double holds the time since 1970 to a quarter of a microsecond.
    row("time since 1970", Agree::Interval, |q, spec, _| data::from_origin(q, spec, data::EPOCH)),
    row("relative coordinates", Agree::Solver, model::relative),
    row("names", Agree::Bits, model::names),
    row("order of states", Agree::Solver, order::states),
    row("order of constants", Agree::Bits, order::constants),
    row("order of candidates", Agree::Solver, order::candidates),
    row("order of columns", Agree::Bits, order::columns),
    row("order of records", Agree::Solver, order::records),
    row("record cut in two", Agree::Interval, data::cut),
    row("sums and products turned", Agree::Solver, model::turned),
    row("mass factored out", Agree::Solver, model::factored),
    row("a name for an expression", Agree::Bits, model::named),
    row("constant of another", Agree::Bits, model::constant),
    row("semicolons, decimal comma", Agree::Bits, |q, spec, _| data::file(q, spec, Format::Text(';', ','))),
    row("tabs", Agree::Bits, |q, spec, _| data::file(q, spec, Format::Text('\t', '.'))),
    row("XLSX", Agree::Bits, |q, spec, _| data::file(q, spec, Format::Xlsx)),
    row("NPZ", Agree::Bits, |q, spec, _| data::file(q, spec, Format::Npz)),
    row("MAT", Agree::Bits, |q, spec, _| data::file(q, spec, Format::Matlab)),
    row("starts later", Agree::Interval, data::later),
    row("every second sample", Agree::Interval, |q, _, _| Some(data::rows(q, |k| k % 2 == 0))),
    row("unit of a constant", Agree::Bits, model::unit_of_constant),
    row("units of the model", Agree::Bits, model::units),
];
