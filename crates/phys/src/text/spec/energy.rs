//! The energies of a mechanism as they are written.

use super::reader::Reader;
use super::{Spanned, Text};
use crate::text::fields;
use crate::text::raw::Node;

/// Energies in the place of the rates of coordinates and speeds.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergySpec {
    /// Each coordinate with the name of its speed, and its unit.
    pub coordinates: Vec<(Text, (Text, Text))>,
    /// Of coordinates and speeds, quadratic in these.
    pub kinetic: Text,
    /// Of the coordinates.
    pub potential: Option<Text>,
    /// Half of what is lost, where that is linear in the speeds (Rayleigh's function); or any function whose
    /// derivative by a speed is the force that is lost there.
    pub dissipation: Option<Text>,
    /// Each force with the speed along which it acts.
    pub forces: Vec<(Text, Text)>,
    /// What is zero whatever moves, by coordinates and time.
    pub constraints: Vec<Text>,
}

impl EnergySpec {
    /// Coordinates and speeds as states with their units, in the order `x, v, y, w`.
    pub(crate) fn states(&self) -> impl Iterator<Item = (Text, Text)> {
        self.coordinates.iter().flat_map(|(coordinate, (speed, unit))| {
            [(coordinate.clone(), unit.clone()), (speed.clone(), per_second(unit))]
        })
    }

    /// The rates of the coordinates.
    pub(crate) fn rates(&self) -> impl Iterator<Item = (Text, Text)> {
        self.coordinates.iter().map(|(coordinate, (speed, _))| (coordinate.clone(), speed.clone()))
    }
}

/// The unit of what changes in a second.
pub(super) fn per_second(unit: &Text) -> Text {
    let value = match unit.value.trim() {
        "" => String::new(),
        plain if plain.contains(['/', '*', ' ']) => format!("({plain})/s"),
        plain => format!("{plain}/s"),
    };
    Spanned { value, span: unit.span }
}

impl Reader<'_> {
    /// `(coordinates: { "x": ("v", "m") }, kinetic: "m*v^2/2", potential: "k*x^2/2", dissipation: "c*v^2/2", forces: { "F": "v" })`
    pub(super) fn energy(&mut self, node: &Node) -> Option<EnergySpec> {
        let fields = self.fields(node, &fields::ENERGY)?;
        let coordinates = self.required(&fields, "coordinates", |r, n| r.map(n, Self::coordinate));
        let kinetic = self.required(&fields, "kinetic", Self::words);
        let potential = self.optional(&fields, "potential", Self::words);
        let dissipation = self.optional(&fields, "dissipation", Self::words);
        let forces = self.pairs(&fields, "forces", Self::words);
        let constraints = self.optional(&fields, "constraints", |r, n| r.list(n, Self::words));
        let coordinates = coordinates?;
        if coordinates.is_empty() {
            return self.wrong(
                node.span,
                "`energy` has no coordinates",
                "nothing moves",
                "name one with its speed and its unit: coordinates: { \"x\": (\"v\", \"m\") }",
            );
        }
        Some(EnergySpec {
            coordinates,
            kinetic: kinetic?,
            potential,
            dissipation,
            forces,
            constraints: constraints.unwrap_or_default(),
        })
    }

    /// `("v", "m")`: a speed and the unit of its coordinate.
    fn coordinate(&mut self, node: &Node) -> Option<(Text, Text)> {
        let [speed, unit] = self.tuple(node, "the name of its speed and its unit, as in (\"v\", \"m\")")?;
        let (speed, unit) = (self.words(speed), self.unit(unit));
        Some((speed?, unit?))
    }
}
