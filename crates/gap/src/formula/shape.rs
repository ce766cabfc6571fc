//! Shapes: products of atoms without their coefficients, and sums of them as laws.

use super::atom::{Atom, DISPLACEMENT, Inner, VELOCITY};
use super::scale::Scale;
use crate::place::product;
use phisindy_expr::{Id, Scratch, Tape};
use phisindy_phys::{Law, LawEntry, LawError};

/// A product of an atom in the displacement and one in the velocity; of neither for a constant force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shape {
    pub(super) displacement: Option<&'static Atom>,
    pub(super) velocity: Option<&'static Atom>,
}

/// A shape with inner numbers (of the displacement, of the velocity).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Term {
    pub(super) shape: Shape,
    pub(super) inner: Vec<f64>,
}

/// All shapes of a place: atoms, products of factors, a constant.
pub(super) fn shapes(has_displacement: bool) -> Vec<Shape> {
    let mut all = vec![Shape { displacement: None, velocity: None }];
    if has_displacement {
        all.extend(DISPLACEMENT.iter().map(|a| Shape { displacement: Some(a), velocity: None }));
    }
    all.extend(VELOCITY.iter().map(|a| Shape { displacement: None, velocity: Some(a) }));
    if has_displacement {
        for a in DISPLACEMENT.iter().filter(|a| a.factor) {
            let factors = VELOCITY.iter().filter(|b| b.factor);
            all.extend(factors.map(|b| Shape { displacement: Some(a), velocity: Some(b) }));
        }
    }
    all
}

impl Shape {
    /// Its inner numbers: of which quantity (0 displacement, 1 velocity), and what they are.
    pub(super) fn inner(&self) -> Vec<(usize, Inner)> {
        let of = [self.displacement, self.velocity];
        let all = of.into_iter().enumerate().filter_map(|(k, a)| Some((k, a?.inner)));
        all.filter(|(_, inner)| *inner != Inner::No).collect()
    }

    /// Whether it is a spring or a damper.
    pub(super) fn is_linear(&self) -> bool {
        let all: Vec<&Atom> = self.displacement.into_iter().chain(self.velocity).collect();
        matches!(all[..], [one] if one.text == "y")
    }

    /// The values of the inner numbers that are tried, all combinations.
    pub(super) fn grid(&self, scales: &[Scale; 2]) -> Vec<Vec<f64>> {
        let coarse = self.displacement.is_some() && self.velocity.is_some();
        let mut all: Vec<Vec<f64>> = vec![vec![]];
        for (k, inner) in self.inner() {
            let values = scales[k].values(inner, coarse);
            let with = |g: &Vec<f64>| -> Vec<Vec<f64>> {
                values.iter().map(|v| g.iter().copied().chain([*v]).collect()).collect()
            };
            all = all.iter().flat_map(with).collect();
        }
        all
    }

    /// The shape with the atom of a quantity replaced by its limit, and the power of the inner number that
    /// becomes a factor; `step`: the limit of a small size.
    pub(super) fn at_limit(&self, quantity: usize, step: bool) -> Option<(Shape, i32)> {
        let limit = match quantity {
            0 => self.displacement?.limit(DISPLACEMENT, step)?,
            _ => self.velocity?.limit(VELOCITY, step)?,
        };
        let mut shape = *self;
        match quantity {
            0 => shape.displacement = limit.atom,
            _ => shape.velocity = limit.atom,
        }
        Some((shape, limit.power))
    }

    /// Its expression with names for the inner numbers.
    fn text(&self, names: &[String]) -> String {
        let mut names = names.iter();
        let of = [(self.displacement, "x", "X"), (self.velocity, "v", "V")];
        let parts: Vec<String> = of
            .into_iter()
            .filter_map(|(atom, quantity, unit)| {
                let atom = atom?;
                let inner =
                    if atom.inner == Inner::No { "" } else { names.next().map_or("", String::as_str) };
                Some(atom.written(quantity, inner, unit))
            })
            .collect();
        parts.join("*")
    }

    /// The unit of its coefficient.
    fn unit(&self) -> String {
        let of = |a: Option<&'static Atom>| a.map_or(0.0, |a| a.unit);
        let (x, v) = (of(self.displacement), of(self.velocity));
        product(&[("N", 1.0), ("m", -x - v), ("s", v)])
    }
}

/// Letters of inner numbers of the displacement and of the velocity.
fn letter(quantity: usize, inner: Inner) -> &'static str {
    match (quantity, inner) {
        (0, Inner::Power) => "p",
        (0, Inner::Wave) => "k",
        (0, Inner::Rate) => "r",
        (0, Inner::Corner) => "x0",
        (0, _) => "l",
        (_, Inner::Power) => "q",
        (_, Inner::Wave | Inner::Rate) => "w",
        (_, Inner::Corner) => "v0",
        (_, _) => "vs",
    }
}

/// The unit of an inner number.
fn unit(quantity: usize, inner: Inner) -> &'static str {
    match (quantity, inner) {
        (_, Inner::Power | Inner::No) => "",
        (0, Inner::Wave) => "rad/m",
        (0, Inner::Rate) => "1/m",
        (0, _) => "m",
        (_, Inner::Wave) => "rad*s/m",
        (_, Inner::Rate) => "s/m",
        (_, _) => "m/s",
    }
}

/// Coefficients of either sign are not bounded by anything that is known.
const LARGE: f64 = 1e15;

/// A sum of shapes as a law: coefficient and inner numbers of each term are its parameters, in this order.
pub(super) struct Formula {
    pub(super) entry: LawEntry,
    /// Symbols of the expression.
    pub(super) symbols: usize,
}

/// The law of a sum of shapes, told by this name. `scales` bound the inner numbers.
pub(super) fn formula(
    id: &str,
    name: &str,
    about: &str,
    of: &[Shape],
    scales: &[Scale; 2],
) -> Result<Formula, LawError> {
    let several = of.len() > 1;
    let numbered = |letter: &str, k: usize| {
        if several { format!("{letter}{}", k + 1) } else { letter.to_owned() }
    };
    let (mut parameters, mut terms) = (vec![], vec![]);
    for (k, shape) in of.iter().enumerate() {
        let c = numbered("c", k);
        parameters.push(format!(
            "        \"{c}\": (unit: \"{}\", within: ({:?}, {LARGE:?})),",
            shape.unit(),
            -LARGE
        ));
        let mut names = vec![];
        for (quantity, inner) in shape.inner() {
            let name = numbered(letter(quantity, inner), k);
            let (low, high) = scales[quantity].within(inner);
            let unit = unit(quantity, inner);
            parameters.push(format!("        \"{name}\": (unit: \"{unit}\", within: ({low:?}, {high:?})),"));
            names.push(name);
        }
        let text = shape.text(&names);
        terms.push(match text.strip_prefix("1/") {
            _ if text.is_empty() => c,
            Some(over) if shape.velocity.is_none() => format!("{c}/{over}"),
            _ => format!("{c}*{text}"),
        });
    }
    let force = terms.join(" + ");
    let has = |k: usize| of.iter().any(|s| [s.displacement, s.velocity][k].is_some());
    let power = |k: usize| {
        of.iter().any(|s| [s.displacement, s.velocity][k].is_some_and(|a| a.inner == Inner::Power))
    };
    let listed = |all: [(bool, &str); 2]| {
        all.into_iter().filter(|(is, _)| *is).map(|(_, t)| t).collect::<Vec<_>>().join(", ")
    };
    let roles = listed([(has(0), r#""x": "m""#), (has(1), r#""v": "m/s""#)]);
    let given = listed([(power(0), r#""X": (1.0, "m")"#), (power(1), r#""V": (1.0, "m/s")"#)]);
    let given = if given.is_empty() { String::new() } else { format!("    given: {{ {given} }},\n") };
    let text = format!(
        "(\n    name: \"{name}\",\n    about: \"{about}\",\n    reference: \"found in these data\",\n    roles: {{ {roles} }},\n    parameters: {{\n{}\n    }},\n{given}    force: \"{force}\",\n)\n",
        parameters.join("\n")
    );
    let entry = LawEntry::read(id, &text)?;
    let symbols = symbols(&entry.law);
    Ok(Formula { entry, symbols })
}

/// Symbols of the expression of a law's force.
fn symbols(law: &Law) -> usize {
    let of = law.nodes();
    of.force.map_or(0, |force| of.graph.reachable(&[force]).len())
}

/// A force without memory compiled: its values along a motion.
pub(super) struct Program {
    tape: Tape,
    /// Which of displacement, velocity it reads.
    reads: [bool; 2],
    pub(super) symbols: usize,
    pub(super) sticks: bool,
}

impl Program {
    /// A shape with its coefficient.
    pub(super) fn new(shape: Shape, scales: &[Scale; 2]) -> Option<Program> {
        Program::of(&formula("term", "a term", "", &[shape], scales).ok()?.entry.law)
    }

    /// The force of a law; `None` if it reads more than displacement, velocity and its parameters.
    pub(super) fn of(law: &Law) -> Option<Program> {
        let of = law.nodes();
        let inputs: Vec<Id> =
            of.displacement.into_iter().chain(of.velocity).chain(of.parameters.iter().copied()).collect();
        Some(Program {
            tape: Tape::compile(&of.graph, &inputs, &[of.force?]).ok()?,
            reads: [of.displacement.is_some(), of.velocity.is_some()],
            symbols: symbols(law),
            sticks: law.sticks(),
        })
    }

    /// Its values along displacement and velocity, its coefficient 1.
    pub(super) fn evaluate(&self, displacement: &[f64], velocity: &[f64], inner: &[f64]) -> Vec<f64> {
        let numbers: Vec<f64> = [1.0].iter().chain(inner).copied().collect();
        self.force(displacement, velocity, &numbers)
    }

    /// Its values along displacement and velocity with these parameters.
    pub(super) fn force(&self, displacement: &[f64], velocity: &[f64], numbers: &[f64]) -> Vec<f64> {
        const LANES: usize = 64;
        let mut scratch = Scratch::<LANES>::new(&self.tape);
        let series: Vec<&[f64]> = [(self.reads[0], displacement), (self.reads[1], velocity)]
            .into_iter()
            .filter(|(is, _)| *is)
            .map(|(_, s)| s)
            .collect();
        for (k, value) in numbers.iter().enumerate() {
            *scratch.input(series.len() + k) = [*value; LANES];
        }
        let samples = velocity.len();
        let mut out = Vec::with_capacity(samples);
        for first in (0..samples).step_by(LANES) {
            let count = LANES.min(samples - first);
            for (k, s) in series.iter().enumerate() {
                let input = scratch.input(k);
                (0..LANES).for_each(|lane| input[lane] = s[first + lane.min(count - 1)]);
            }
            scratch.run();
            out.extend(&scratch.output(0)[..count]);
        }
        out
    }
}
