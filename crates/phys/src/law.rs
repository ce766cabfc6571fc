//! A law of the catalogue: a force with parameters that may act at many places of a model.
//!
//! The file of a law is text. `Law::read` compiles it to nodes of a graph of its own. Properties of a law,
//! such as whether it sticks or has a clearance, are read off that graph.

mod catalogue;
mod check;
mod compile;
mod dissipation;
mod graph;
mod properties;
mod symmetry;

pub use catalogue::{BUILT_IN, LawEntry};
pub use graph::{LawError, LawGraph, LawScreen, jointly_linear};

use crate::units::unit::{Dimension, Unit};
use serde::de::{Deserializer, MapAccess, Visitor};
use serde::{Deserialize, de};
use std::fmt;

/// The name of an input in what acts in its place.
pub const INPUT: &str = "u";
/// What acts is the input of a little while ago.
const DELAY: &str = "delay";

/// What a law's file says.
///
/// ```
/// use phisindy_phys::Law;
/// let law = Law::read(r#"(name: "Quadratic drag", roles: { "v": "m/s" }, parameters: { "d": (unit: "N*s^2/m^2", within: (0.0, 10.0)) }, force: "d*v*|v|")"#).unwrap();
/// assert_eq!(law.subtracted(false).unwrap(), "d*v*|v|");
/// assert!(!law.sticks());
/// ```
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Law {
    /// For people.
    pub name: String,
    /// One sentence.
    #[serde(default)]
    pub about: String,
    /// Where it comes from.
    #[serde(default)]
    pub reference: String,
    /// Displacement and velocity at the place where it acts, and their units.
    #[serde(default, deserialize_with = "ordered")]
    pub roles: Vec<(String, String)>,
    /// Numbers to be found.
    #[serde(default, deserialize_with = "ordered")]
    pub parameters: Vec<(String, LawParameter)>,
    /// Numbers that are held.
    #[serde(default, deserialize_with = "ordered")]
    pub given: Vec<(String, (f64, String))>,
    /// States of its own.
    #[serde(default, deserialize_with = "ordered")]
    pub internal: Vec<(String, Internal)>,
    /// What it subtracts.
    pub force: Option<String>,
    /// What it adds.
    pub push: Option<String>,
    /// Which property of a sensor it is.
    pub sensor: Option<String>,
    /// What acts in the place of a recorded input `u`: an expression, or `delay` for the input of a little while ago.
    pub input: Option<String>,
    /// Its mirror image, which is tried too.
    pub mirror: Option<String>,
    /// Laws that it contains, simplest first: what `gap` tries in its place.
    #[serde(default)]
    pub simpler: Vec<String>,
    /// Two laws that are together the same force: this one is named in their place.
    #[serde(default)]
    pub same_as: Vec<String>,
    /// Laws of one family describe one thing: `gap` never puts two of them at one place.
    #[serde(default)]
    pub family: String,
    /// What its parameters must fulfil to deserve its name.
    #[serde(default)]
    pub needs: Option<Need>,
    /// How `gap` looks for it at a glance; without it the parameters that stand linearly are solved for, and
    /// the others tried on a grid.
    #[serde(default)]
    pub screen: Option<Screen>,
    /// How its picture is drawn.
    #[serde(default)]
    pub sketch: Option<Sketch>,
    /// Another cause that no record can tell from it, and what to check.
    #[serde(default)]
    pub indistinguishable: Option<Indistinguishable>,
    /// For other laws, by id, the measurement that tells them from this one.
    #[serde(default, deserialize_with = "ordered")]
    pub told_apart_by: Vec<(String, String)>,
    /// Its expressions as nodes.
    #[serde(skip)]
    compiled: LawGraph,
}

/// A cause that has the same effect on every record as a law.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Indistinguishable {
    /// The other cause, in words.
    pub cause: String,
    /// What to check on the rig, in words.
    pub check: String,
}

/// What a role of a law stands for at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The displacement, in metres.
    Displacement,
    /// The velocity, in metres per second.
    Velocity,
    /// A force of the known part that presses what rubs, in newtons.
    Load,
}

/// A condition on the parameters of a law.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Need {
    /// An expression of the parameters that is not negative.
    pub positive: String,
    /// Why, in words.
    pub because: String,
}

/// A picture of a law: its force along the motion `x = sin t`, `v = cos t`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sketch {
    /// What it is drawn over: a displacement `x`, a velocity `v`, or time `t`.
    pub over: String,
    /// Example values of the parameters.
    #[serde(deserialize_with = "ordered")]
    pub with: Vec<(String, f64)>,
}

/// How a law is screened: a sum of columns, their coefficients free.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Screen {
    /// What is added to the force; the coefficients are called c1, c2, ...
    pub columns: Vec<String>,
    /// The internal state's rate in terms of the grid, if there is one.
    #[serde(default)]
    pub rate: Option<String>,
    /// Numbers tried on a grid, and their units.
    #[serde(default, deserialize_with = "ordered")]
    pub grid: Vec<(String, String)>,
    /// Each parameter from the coefficients and the grid.
    #[serde(deserialize_with = "ordered")]
    pub seed: Vec<(String, String)>,
}

/// A number to be found.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LawParameter {
    /// Its unit.
    pub unit: String,
    /// Its bounds.
    pub within: (f64, f64),
    /// Whether each record has its own.
    #[serde(default)]
    pub each: bool,
    /// Whether the bounds are the whole range of the number (an angle over a turn, a share up to 1): then a
    /// value at one of them speaks against nothing.
    #[serde(default)]
    pub whole: bool,
}

/// A state that belongs to the law.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Internal {
    /// Its unit.
    pub unit: String,
    /// Its rate of change.
    pub rate: String,
    /// Where it starts.
    pub start: f64,
    /// Of the speed of a body that the law brings along, its inertia: laws act between it and the place then.
    #[serde(default)]
    pub inertia: Option<String>,
}

impl Law {
    /// Its expressions as nodes of a graph of their own.
    pub fn nodes(&self) -> &LawGraph {
        &self.compiled
    }

    /// The force that it subtracts (a push with its sign turned), as text; `None` for what acts on sensors.
    pub fn subtracted(&self, mirror: bool) -> Option<String> {
        let force = if mirror { self.mirror.as_ref() } else { self.force.as_ref() };
        force.cloned().or_else(|| self.push.as_ref().filter(|_| !mirror).map(|p| format!("-({p})")))
    }

    /// The name that the law gives to a displacement or a velocity, told by the unit of the role.
    pub fn role(&self, wanted: Role) -> Option<&str> {
        let unit = match wanted {
            Role::Displacement => Dimension::METRE,
            Role::Velocity => Dimension::METRE.div(Dimension::SECOND),
            Role::Load => Dimension::NEWTON,
        };
        let is = |text: &str| Unit::parse(text).is_ok_and(|u| u.dimension == unit);
        self.roles.iter().find(|(_, unit)| is(unit)).map(|(name, _)| name.as_str())
    }

    /// Which property of a sensor it is, or what acts in the place of an input; `None` for a force.
    pub fn property(&self) -> Option<&str> {
        self.sensor.as_deref().or(self.input.as_deref())
    }

    /// What acts in the place of an input `u`, as an expression of it.
    pub fn acting(&self) -> Option<&str> {
        self.input.as_deref().filter(|what| *what != DELAY)
    }

    /// Whether it has states of its own.
    pub fn has_memory(&self) -> bool {
        !self.internal.is_empty()
    }
}

/// A map in the order of the text; a repeated key is a mistake.
fn ordered<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
) -> Result<Vec<(String, T)>, D::Error> {
    struct Pairs<T>(std::marker::PhantomData<T>);
    impl<'de, T: Deserialize<'de>> Visitor<'de> for Pairs<T> {
        type Value = Vec<(String, T)>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a map")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
            let mut pairs: Vec<(String, T)> = Vec::new();
            while let Some((key, value)) = map.next_entry::<String, T>()? {
                if pairs.iter().any(|(k, _)| *k == key) {
                    return Err(de::Error::custom(format!("`{key}` stands here twice")));
                }
                pairs.push((key, value));
            }
            Ok(pairs)
        }
    }
    deserializer.deserialize_map(Pairs(std::marker::PhantomData))
}
