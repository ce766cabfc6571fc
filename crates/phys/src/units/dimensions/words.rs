//! Mistakes of dimension in words: what, where, what to do.

use super::form::Form;
use super::quantity::Conflict;
use crate::text::diagnostic::{Diagnostic, SourceId};
use crate::text::spec::Text;
use phisindy_expr::{Binary, Span, Unary};

/// Writes diagnostics that point into one text. Pairs of forms are what is due and what is there.
pub(super) struct Words {
    source: SourceId,
}

impl Words {
    pub(super) fn new(source: SourceId) -> Words {
        Words { source }
    }

    /// A mistake inside an expression that begins where `text` does.
    pub(super) fn conflict(&self, text: Span, conflict: &Conflict, missing: Option<String>) -> Diagnostic {
        let at = |span: &Span| span.shifted(text.start);
        let plain = |takes: String, span: &Span, form: &Form, help: &str| {
            Diagnostic::error(format!("{takes} a plain number, not {form}"))
                .at(self.source, at(span), is_in(form))
                .help(missing.as_deref().map_or(help.to_owned(), asked))
        };
        match conflict {
            Conflict::Operands { op, left, right } => {
                let done = match op {
                    Binary::Add => "added".to_owned(),
                    Binary::Sub => "subtracted".to_owned(),
                    op => format!("compared by `{}`", op.row().name),
                };
                let message = format!("{} and {} cannot be {done}", left.1, right.1);
                Diagnostic::error(message)
                    .at(self.source, at(&right.0), is_in(&right.1))
                    .also(self.source, at(&left.0), is_in(&left.1))
                    .help(missing.map_or_else(|| bridge(&left.1, &right.1), |m| asked(&m)))
            }
            Conflict::Table { span, due, form } => Diagnostic::error(format!(
                "the first column of this table is {due}, and its argument is {form}"
            ))
            .at(self.source, at(span), is_in(form))
            .help(missing.map_or_else(|| bridge(due, form), |m| asked(&m))),
            Conflict::Argument { op, span, form } => {
                let help = if *op == Unary::Ln {
                    "divide by a reference in the same unit, as in `ln(|v|/v0)`"
                } else {
                    "divide by a constant in the same unit"
                };
                plain(format!("`{}` takes", op.row().name), span, form, help)
            }
            Conflict::Time { span, form } => Diagnostic::error(format!(
                "period and delay of `hold` are times, not {}",
                in_unit(form)
            ))
            .at(self.source, at(span), is_in(form))
            .help("write `hold(expression, period)`: a number in seconds, or a constant in \"s\" or \"ms\""),
            Conflict::Exponent { span, form } => {
                plain("an exponent is".into(), span, form, "divide by a constant in the same unit")
            }
            Conflict::Base { span, form } => {
                let help = "the unit of a power whose exponent varies would vary too: divide by a constant in the same unit";
                plain("what is raised to a power that varies is".into(), span, form, help)
            }
        }
    }

    /// A rate of change of a state, or a part of one.
    pub(super) fn rate(
        &self,
        state: &Text,
        unit: Option<&Text>,
        text: &Text,
        what: &str,
        [due, is]: [&Form; 2],
        missing: Option<String>,
    ) -> Diagnostic {
        let name = &state.value;
        let message = format!("`{name}` changes in {due}, but {what} is {}", in_unit(is));
        let d = Diagnostic::error(message).at(self.source, text.span, is_in(is));
        let d = match unit {
            Some(unit) => d.also(self.source, unit.span, format!("the unit of `{name}`, per second: {due}")),
            None => d,
        };
        d.help(missing.map_or_else(|| bridge(due, is), |m| asked(&m)))
    }

    /// An input or output whose expression has another dimension; `what` names it, `said` its expression.
    pub(super) fn assigned(
        &self,
        (what, said): (&str, &str),
        name: &Text,
        text: &Text,
        [due, is]: [&Form; 2],
        missing: Option<String>,
    ) -> Diagnostic {
        let message = format!("{what} `{}` is {}, but {said} is {}", name.value, in_unit(due), in_unit(is));
        Diagnostic::error(message)
            .at(self.source, text.span, is_in(is))
            .help(missing.map_or_else(|| bridge(due, is), |m| asked(&m)))
    }

    /// Energies, or powers, of different kinds; `what` names that of `text`.
    pub(super) fn energy(
        &self,
        what: &str,
        text: &Text,
        [due, is]: [&Form; 2],
        missing: Option<String>,
    ) -> Diagnostic {
        let message = format!(
            "{what} is {}, but beside this kinetic energy it should be {}",
            in_unit(is),
            in_unit(due)
        );
        Diagnostic::error(message)
            .at(self.source, text.span, is_in(is))
            .help(missing.map_or_else(|| bridge(due, is), |m| asked(&m)))
    }

    pub(super) fn derivative(
        &self,
        input: &Text,
        of: &Text,
        declared: Option<&Text>,
        [due, is]: [&Form; 2],
    ) -> Diagnostic {
        let (name, source) = (&input.value, &of.value);
        let d = Diagnostic::error(format!(
            "the derivative of `{source}` is {}, but `{name}` is {}",
            in_unit(due),
            in_unit(is)
        ))
        .at(self.source, of.span, format!("its derivative is {}", in_unit(due)));
        let d = match declared {
            Some(unit) => d.also(self.source, unit.span, is_in(is)),
            None => d,
        };
        d.help(format!("declare `\"{name}\": \"{}\"` in `inputs`", bare(due)))
    }

    /// A constant that is defined for each record, here otherwise than elsewhere.
    pub(super) fn defined_otherwise(&self, name: &Text, here: &Form, elsewhere: &Form) -> Diagnostic {
        let message =
            format!("`{}` is {} here and {} elsewhere", name.value, in_unit(here), in_unit(elsewhere));
        Diagnostic::error(message)
            .at(self.source, name.span, "")
            .help("one constant has one dimension in all records")
    }

    /// A constant where another dimension is due; `what` is what it stands for.
    pub(super) fn named(&self, what: &str, constant: &Text, [due, is]: [&Form; 2]) -> Diagnostic {
        let name = &constant.value;
        Diagnostic::error(format!("{what} is {}, but `{name}` is {}", in_unit(due), in_unit(is)))
            .at(self.source, constant.span, is_in(is))
            .help(format!("name a constant in \"{}\" or a multiple of it, or write a number", bare(due)))
    }

    /// A constant that is a cutoff and no frequency in Hz.
    pub(super) fn cutoff(&self, constant: &Text, is: &str) -> Diagnostic {
        Diagnostic::error(format!("a cutoff is a frequency in Hz, but `{}` is {is}", constant.value))
            .at(self.source, constant.span, "")
            .help("give it in Hz or kHz; 1 Hz is 6.283 rad/s")
    }

    pub(super) fn unit(&self, what: &str, unit: &Text, [due, is]: [&Form; 2]) -> Diagnostic {
        Diagnostic::error(format!("{what} is {}, not {}", in_unit(due), in_unit(is)))
            .at(self.source, unit.span, "")
            .help(format!("write \"{}\" or a multiple of it", bare(due)))
    }
}

/// `a plain number`, or `in N/m`.
pub(super) fn in_unit(form: &Form) -> String {
    if form.is_none() { form.to_string() } else { format!("in {form}") }
}

fn is_in(form: &Form) -> String {
    format!("this is {}", in_unit(form))
}

/// As a unit is written.
fn bare(form: &Form) -> String {
    if form.is_none() { "1".into() } else { form.to_string() }
}

fn asked(missing: &str) -> String {
    format!("is {missing} missing here?")
}

fn bridge(due: &Form, is: &Form) -> String {
    let factor = bare(&due.over(is));
    format!(
        "a constant in {factor} as a factor would make it fit; a number without a unit takes whatever unit fits"
    )
}
