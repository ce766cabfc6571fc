//! A structure of many degrees of freedom, given by matrices in files.

use super::modes::{Damped, Matrices, Modes};
use super::reader::Reader;
use super::{Number, Spanned, Text};
use crate::text::fields;
use crate::text::files::Numbers;
use crate::text::raw::{Node, Shape};
use std::sync::Arc;

/// Fewest and most degrees of freedom.
const DEGREES: (usize, usize) = (2, 200);

/// Matrices in the place of the rates of the points of a structure.
#[derive(Clone, Debug, PartialEq)]
pub struct StructureSpec {
    /// What its coordinates are called: the point `tip` of `q` is the state `q_tip`.
    pub coordinates: Text,
    /// Its points, which are states.
    pub points: Vec<PointSpec>,
    /// Each force with the point, or the speed of points, along which it acts.
    pub forces: Vec<(Text, Text)>,
    /// What its matrices say.
    pub modes: Arc<Modes>,
}

/// A point of a structure.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSpec {
    /// What it is called.
    pub name: Text,
    /// Of its displacement.
    pub unit: Text,
}

impl StructureSpec {
    /// Displacements with their speeds: of the points, then of the modes beside them.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = (Text, Text, Text)> {
        let base = &self.coordinates;
        let pair = move |name: String, unit: Text| {
            let spanned = |value: String| Spanned { value, span: unit.span };
            (spanned(name.clone()), spanned(format!("{name}_speed")), unit.clone())
        };
        let points = self.points.iter().map(move |point| {
            let unit = Spanned { value: point.unit.value.clone(), span: point.name.span };
            pair(format!("{}_{}", base.value, point.name.value), unit)
        });
        let modes = self.modes.beside.iter().map(move |mode| {
            let unit = Spanned { value: "m".into(), span: base.span };
            pair(format!("{}_mode{}", base.value, mode + 1), unit)
        });
        points.chain(modes)
    }

    /// Whether this is the speed of a point.
    pub(crate) fn moves(&self, state: &str) -> bool {
        self.pairs().take(self.points.len()).any(|(_, speed, _)| speed.value == state)
    }

    /// What was left out, in words.
    pub fn note(&self) -> Option<String> {
        let Modes { degrees, frequencies, all, .. } = &*self.modes;
        let last = frequencies.last()?;
        (frequencies.len() < *all).then(|| {
            format!(
                "the structure `{}` has {degrees} degrees of freedom and is reduced to {} modes, up to {last:.4} Hz: what it does above is left out",
                self.coordinates.value,
                frequencies.len()
            )
        })
    }
}

impl Reader<'_> {
    /// `(mass: "M.mtx", damping: "C.mtx", stiffness: "K.mtx", coordinates: "q", points: { "tip": 45 })`
    pub(super) fn structure(&mut self, node: &Node) -> Option<StructureSpec> {
        let fields = self.fields(node, &fields::STRUCTURE)?;
        let coordinates = self.required(&fields, "coordinates", Self::words);
        let mass = self.required(&fields, "mass", Self::matrix);
        let stiffness = self.required(&fields, "stiffness", Self::matrix);
        let damping = match fields.get("damping") {
            Some(node) => self.damping(node),
            None => Some(Damped::Ratios(vec![])),
        };
        let forces = self.pairs(&fields, "forces", Self::words);
        let modes = self.optional(&fields, "modes", Self::count);
        let band = self.optional(&fields, "band", Self::bounds);
        let ((mass, at), (stiffness, stiffness_at)) = (mass?, stiffness?);
        let n = mass.rows();
        if n < DEGREES.0 || n > DEGREES.1 {
            let message = format!(
                "a structure has {} to {} degrees of freedom, and this one {n}",
                DEGREES.0, DEGREES.1
            );
            return self.wrong(at.span, message, "", "reduce it where it comes from, or write `energy`");
        }
        let points = self.required(&fields, "points", |r, node| r.map(node, |r, node| r.point(node, n)));
        let damping = damping?;
        let damped = if let Damped::Matrix(matrix, span) = &damping { Some((matrix, *span)) } else { None };
        for (what, matrix, span) in [("mass", &mass, at.span), ("stiffness", &stiffness, stiffness_at.span)]
            .into_iter()
            .chain(damped.map(|(matrix, span)| ("damping", matrix, span)))
        {
            self.symmetric(what, matrix, n, span)?;
        }
        let points = points?;
        if points.is_empty() {
            return self.wrong(
                node.span,
                "`structure` has no points",
                "nothing of it is seen",
                "name one with its degree of freedom: points: { \"tip\": 45 }",
            );
        }
        let rows: Vec<Vec<f64>> = points.iter().map(|(_, (row, _))| row.clone()).collect();
        let all = Matrices { mass: &mass, stiffness: &stiffness, damping, points: &rows };
        let band = band.map(|(low, high)| (low.value, high.value));
        let found = match Modes::new(&all, modes.as_ref().map(|m| m.value as usize), band) {
            Ok(found) => found,
            Err(why) => {
                let span = match why.of_point() {
                    Some(k) => points[k].0.span,
                    None if why.is_of_mass() => at.span,
                    None => stiffness_at.span,
                };
                return self.wrong(span, why.to_string(), "", why.advice());
            }
        };
        let points = points.into_iter().map(|(name, (_, unit))| {
            let unit = unit.unwrap_or_else(|| Spanned { value: "m".into(), span: name.span });
            PointSpec { name, unit }
        });
        Some(StructureSpec {
            coordinates: coordinates?,
            points: points.collect(),
            forces,
            modes: Arc::new(found),
        })
    }

    /// `"K.mtx"`, or `("model.npz", "K")`: its numbers, and where its path stands.
    fn matrix(&mut self, node: &Node) -> Option<(Numbers, Text)> {
        let (path, array) = match node.shape {
            Shape::Group => {
                let [path, array] =
                    self.tuple(node, "a file and the name of an array in it, as in (\"model.npz\", \"K\")")?;
                let (path, array) = (self.words(path), self.words(array));
                (path?, Some(array?.value))
            }
            _ => (self.words(node)?, None),
        };
        // Files that are not given have been told of.
        let files = self.files.clone().unwrap_or_default();
        files.numbers(&path.value, array.as_deref()).map(|numbers| (numbers.clone(), path))
    }

    /// A file, one ratio for all modes, or one for each.
    fn damping(&mut self, node: &Node) -> Option<Damped> {
        let ratios: Vec<Number> = match node.shape {
            Shape::Number => vec![self.not_negative(node)?],
            Shape::List => self.list(node, Self::not_negative)?,
            _ => return self.matrix(node).map(|(numbers, path)| Damped::Matrix(numbers, path.span)),
        };
        Some(Damped::Ratios(ratios.into_iter().map(|ratio| ratio.value).collect()))
    }

    /// `45`, `(row: "modes.csv")`, or `(dof: 45, unit: "rad")`: its row of so many numbers, and its unit.
    fn point(&mut self, node: &Node, n: usize) -> Option<(Vec<f64>, Option<Text>)> {
        let unit_row = |r: &mut Self, node: &Node| {
            let dof = r.whole(node)?;
            let place = usize::try_from(dof.value).ok().filter(|k| (1..=n).contains(k));
            let Some(place) = place else {
                return r.wrong(
                    dof.span,
                    format!("there is no degree of freedom {} among {n}", dof.value),
                    "",
                    "they are counted from 1",
                );
            };
            Some((0..n).map(|k| f64::from(u8::from(k + 1 == place))).collect())
        };
        if node.shape == Shape::Number {
            return unit_row(self, node).map(|row| (row, None));
        }
        let fields = self.fields(node, &fields::POINT)?;
        let unit = self.optional(&fields, "unit", Self::unit);
        let row = match (fields.get("dof"), fields.get("row")) {
            (Some(dof), None) => unit_row(self, dof),
            (None, Some(row)) => {
                let (numbers, path) = self.matrix(row)?;
                if numbers.values.len() != n {
                    let message = format!(
                        "the row `{}` has {} numbers, and the structure {n} degrees of freedom",
                        path.value,
                        numbers.values.len()
                    );
                    return self.wrong(
                        path.span,
                        message,
                        "",
                        "write one number for each, in one row or one column",
                    );
                }
                Some(numbers.values)
            }
            _ => self.wrong(
                node.span,
                "a point is one degree of freedom or one row",
                "",
                "write 45, (dof: 45, unit: \"rad\") or (row: \"row.csv\")",
            ),
        };
        Some((row?, unit))
    }

    /// Whether a matrix is square, of the size of the mass, and symmetric but for rounding.
    fn symmetric(&mut self, what: &str, matrix: &Numbers, n: usize, span: phisindy_expr::Span) -> Option<()> {
        let (rows, columns) = (matrix.rows(), matrix.columns);
        if (rows, columns) != (n, n) {
            let message =
                format!("the {what} matrix has {rows} x {columns} numbers, and the mass has {n} rows");
            return self.wrong(span, message, "", "all matrices of a structure are square and of one size");
        }
        let largest = matrix.values.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
        for i in 0..n {
            for j in 0..i {
                let (a, b) = (matrix.at(i, j), matrix.at(j, i));
                if (a - b).abs() > 1e-6 * largest {
                    let message = format!(
                        "the {what} matrix is not symmetric: its entry ({}, {}) is {a}, and ({}, {}) is {b}",
                        i + 1,
                        j + 1,
                        j + 1,
                        i + 1
                    );
                    let help = "only symmetric matrices are read: gyroscopic and circulatory terms belong into `known` or `forces`";
                    return self.wrong(span, message, "", help);
                }
            }
        }
        Some(())
    }
}
