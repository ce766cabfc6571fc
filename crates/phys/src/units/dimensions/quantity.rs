//! What an expression measures, found from its names operation by operation.

use super::form::Form;
use super::unknowns::Unknowns;
use phisindy_expr::{Ast, AstKind, Binary, Span, Unary};

/// What is known of the dimension of an expression.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Measure {
    /// It is this.
    Fixed(Form),
    /// A number in it takes whatever unit fits. If that is none, it is this; `None`: no telling.
    Loose(Option<Form>),
}

impl Measure {
    /// A number without a unit.
    pub(super) fn number() -> Measure {
        Measure::Loose(Some(Form::none()))
    }

    /// What it is, with every number in it taken as a plain number.
    pub(super) fn plainly(&self) -> Option<&Form> {
        match self {
            Measure::Fixed(form) => Some(form),
            Measure::Loose(form) => form.as_ref(),
        }
    }

    /// `self * other^power`.
    pub(super) fn times(&self, other: &Measure, power: f64) -> Measure {
        match (self, other) {
            (Measure::Fixed(a), Measure::Fixed(b)) => Measure::Fixed(a.times(b, power)),
            _ => Measure::Loose(self.plainly().zip(other.plainly()).map(|(a, b)| a.times(b, power))),
        }
    }

    fn pow(&self, power: f64) -> Measure {
        match self {
            Measure::Fixed(form) => Measure::Fixed(form.pow(power)),
            Measure::Loose(form) => Measure::Loose(form.as_ref().map(|form| form.pow(power))),
        }
    }
}

/// What an expression measures, and whether it is one number throughout.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Quantity {
    pub(super) measure: Measure,
    /// The number, where it is known beforehand.
    pub(super) value: Option<f64>,
    /// Whether it is the same at all times, though perhaps not known yet.
    pub(super) constant: bool,
}

impl Quantity {
    /// Something that varies.
    pub(super) fn varying(measure: Measure) -> Quantity {
        Quantity { measure, value: None, constant: false }
    }

    /// A number that may differ from run to run.
    pub(super) fn constant(measure: Measure) -> Quantity {
        Quantity { measure, value: None, constant: true }
    }

    /// This number.
    pub(super) fn number(value: f64) -> Quantity {
        Quantity { measure: Measure::number(), value: Some(value), constant: true }
    }
}

/// What does not fit, and where in the expression.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Conflict {
    /// Operands that must measure the same.
    Operands { op: Binary, left: (Span, Form), right: (Span, Form) },
    /// The argument of a function that takes a plain number.
    Argument { op: Unary, span: Span, form: Form },
    /// The period or the delay of what is held is no time.
    Time { span: Span, form: Form },
    /// The argument of a table is no number of its first column.
    Table { span: Span, due: Form, form: Form },
    /// An exponent is no plain number.
    Exponent { span: Span, form: Form },
    /// What is raised to a power that varies is no plain number.
    Base { span: Span, form: Form },
}

/// What the two columns of a file measure.
pub(super) type Tables<'a> = &'a dyn Fn(&str) -> [Measure; 2];

/// Finds what an expression measures. What `names` does not know fits everywhere: others complain of it.
pub(super) fn infer(
    ast: &Ast,
    names: impl Fn(&str) -> Option<Quantity>,
    (time, tables): (&Measure, Tables<'_>),
    unknowns: &mut Unknowns,
    conflicts: &mut Vec<Conflict>,
) -> Quantity {
    let anything = || Quantity::varying(Measure::Loose(None));
    let mut found: Vec<Quantity> = Vec::with_capacity(ast.nodes.len());
    let mut rules = Rules { time, unknowns, conflicts };
    for node in &ast.nodes {
        let mut taken = |k: usize| (ast.nodes[k].span, std::mem::replace(&mut found[k], anything()));
        let quantity = match &node.kind {
            AstKind::Number(value) => Quantity::number(*value),
            AstKind::Name(name) => match names(name) {
                Some(quantity) => quantity,
                // Often written for pi rad/s or the like.
                None if name == "pi" => Quantity::number(std::f64::consts::PI),
                None => anything(),
            },
            AstKind::Unary(op, a) => {
                let (span, a) = taken(*a);
                Quantity {
                    value: a.value.map(op.row().value),
                    constant: a.constant,
                    measure: rules.unary(*op, span, a.measure),
                }
            }
            AstKind::Table { path: (path, _), of, .. } => {
                let (span, of) = taken(*of);
                let [due, value] = tables(path);
                if let (Measure::Fixed(due), Measure::Fixed(form)) = (due, of.measure)
                    && !rules.unknowns.equate(&due, &form)
                {
                    rules.conflicts.push(Conflict::Table { span, due, form });
                }
                Quantity { constant: of.constant, ..Quantity::varying(value) }
            }
            AstKind::Binary(op, a, b) => {
                let (a, b) = (taken(*a), taken(*b));
                Quantity {
                    value: a.1.value.zip(b.1.value).map(|(a, b)| (op.row().value)(a, b)),
                    constant: a.1.constant && b.1.constant,
                    measure: rules.binary(*op, a, b),
                }
            }
        };
        found.push(quantity);
    }
    found.pop().unwrap_or_else(anything)
}

/// The rule of each operation.
struct Rules<'a> {
    time: &'a Measure,
    unknowns: &'a mut Unknowns,
    conflicts: &'a mut Vec<Conflict>,
}

impl Rules<'_> {
    fn unary(&mut self, op: Unary, span: Span, of: Measure) -> Measure {
        match op {
            Unary::Neg | Unary::Abs | Unary::Pos => of,
            Unary::Sqrt => of.pow(0.5),
            Unary::Sgn | Unary::Step | Unary::Rest => Measure::Fixed(Form::none()),
            Unary::Ln
            | Unary::Exp
            | Unary::Sin
            | Unary::Cos
            | Unary::Tan
            | Unary::Tanh
            | Unary::Atan
            | Unary::Floor => {
                self.plain(of, |form| Conflict::Argument { op, span, form });
                Measure::Fixed(Form::none())
            }
        }
    }

    fn binary(&mut self, op: Binary, left: (Span, Quantity), right: (Span, Quantity)) -> Measure {
        let (at, a) = (left.0, left.1.measure);
        match op {
            Binary::Mul | Binary::Masked => a.times(&right.1.measure, 1.0),
            Binary::Div => a.times(&right.1.measure, -1.0),
            Binary::Pow => self.power(at, a, right.0, right.1),
            Binary::Gate => a,
            Binary::Hold | Binary::Timing => {
                if op == Binary::Timing {
                    self.timed(at, &a);
                }
                self.timed(right.0, &right.1.measure);
                a
            }
            Binary::Atan2 => {
                self.alike(op, (at, a), (right.0, right.1.measure));
                Measure::Fixed(Form::none())
            }
            Binary::Add | Binary::Sub | Binary::Min | Binary::Max | Binary::Dead | Binary::Mod => {
                self.alike(op, (at, a), (right.0, right.1.measure))
            }
        }
    }

    /// Demands a time.
    fn timed(&mut self, span: Span, of: &Measure) {
        if let (Measure::Fixed(form), Measure::Fixed(time)) = (of, self.time)
            && !self.unknowns.equate(form, time)
        {
            self.conflicts.push(Conflict::Time { span, form: form.clone() });
        }
    }

    /// What two operands of the same unit have.
    fn alike(&mut self, op: Binary, (at, a): (Span, Measure), (right, b): (Span, Measure)) -> Measure {
        match (a, b) {
            (Measure::Fixed(a), Measure::Fixed(b)) => {
                if self.unknowns.equate(&a, &b) {
                    return Measure::Fixed(a);
                }
                self.conflicts.push(Conflict::Operands { op, left: (at, a), right: (right, b) });
                Measure::Loose(None)
            }
            (Measure::Fixed(form), _) | (_, Measure::Fixed(form)) => Measure::Fixed(form),
            (Measure::Loose(a), Measure::Loose(b)) => Measure::Loose(agreed(a, b)),
        }
    }

    fn power(&mut self, at: Span, base: Measure, exponent_at: Span, exponent: Quantity) -> Measure {
        self.plain(exponent.measure, |form| Conflict::Exponent { span: exponent_at, form });
        match (exponent.value, exponent.constant) {
            (Some(power), _) => base.pow(power),
            // One number, but not known yet: it gives some unit.
            (None, true) => match base {
                Measure::Fixed(form) if form.is_none() => Measure::Fixed(form),
                _ => Measure::Loose(None),
            },
            (None, false) => match self.plain(base, |form| Conflict::Base { span: at, form }) {
                true => Measure::Fixed(Form::none()),
                false => Measure::Loose(None),
            },
        }
    }

    /// Demands a plain number; false if it is none.
    fn plain(&mut self, of: Measure, conflict: impl FnOnce(Form) -> Conflict) -> bool {
        match of {
            Measure::Fixed(form) if !self.unknowns.equate(&form, &Form::none()) => {
                self.conflicts.push(conflict(form));
                false
            }
            _ => true,
        }
    }
}

/// What two readings of numbers without units agree on: a number beside a length is most likely a length.
fn agreed(a: Option<Form>, b: Option<Form>) -> Option<Form> {
    let (a, b) = (a?, b?);
    match (a.is_none(), b.is_none()) {
        (true, _) => Some(b),
        (_, true) => Some(a),
        _ => a.over(&b).is_none().then_some(a),
    }
}
