//! The text of a law.

use serde::de::{Deserializer, MapAccess, Visitor};
use serde::{Deserialize, de};
use std::fmt;

/// What a law's file says.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Law {
    /// For people.
    pub(crate) name: String,
    /// One sentence.
    #[serde(default)]
    pub(crate) about: String,
    /// Where it comes from.
    #[serde(default)]
    pub(crate) reference: String,
    /// Displacement and velocity at the place where it acts, and their units.
    #[serde(default, deserialize_with = "ordered")]
    pub(crate) roles: Vec<(String, String)>,
    /// Numbers to be found.
    #[serde(default, deserialize_with = "ordered")]
    pub(crate) parameters: Vec<(String, Parameter)>,
    /// Numbers that are held.
    #[serde(default, deserialize_with = "ordered")]
    given: Vec<(String, (f64, String))>,
    /// States of its own.
    #[serde(default, deserialize_with = "ordered")]
    internal: Vec<(String, Internal)>,
    /// What it subtracts.
    force: Option<String>,
    /// What it adds.
    push: Option<String>,
    /// Which property of a sensor it is.
    sensor: Option<String>,
    /// Its mirror image, which is tried too.
    mirror: Option<String>,
}

/// A number to be found.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Parameter {
    /// Its unit.
    pub(crate) unit: String,
    /// Its bounds.
    pub(crate) within: (f64, f64),
}

/// A state that belongs to the law.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Internal {
    unit: String,
    rate: String,
    start: f64,
}

impl Law {
    /// Reads the text of a law.
    pub(crate) fn read(text: &str) -> Result<Law, ron::error::SpannedError> {
        ron::Options::default()
            .with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME)
            .from_str(text)
    }

    /// What it does, in lines.
    pub(crate) fn acts(&self) -> Vec<String> {
        let mut lines = Vec::new();
        lines.extend(self.force.iter().map(|f| format!("force against the motion: {f}")));
        lines.extend(self.push.iter().map(|f| format!("push: {f}")));
        lines.extend(self.sensor.iter().map(|s| format!("property of a sensor: {s}")));
        lines.extend(
            self.internal
                .iter()
                .map(|(name, i)| format!("with d{name}/dt = {} ({}, from {})", i.rate, i.unit, i.start)),
        );
        lines.extend(self.mirror.iter().map(|m| format!("or its mirror image: {m}")));
        let quantities: Vec<String> =
            self.roles.iter().map(|(name, unit)| format!("{name} in {unit}")).collect();
        if !quantities.is_empty() {
            lines.push(format!("of: {}", quantities.join(", ")));
        }
        let given: Vec<String> = self
            .given
            .iter()
            .map(|(name, (x, unit))| format!("{name} = {x:?} {unit}").trim_end().to_owned())
            .collect();
        if !given.is_empty() {
            lines.push(format!("with: {}", given.join(", ")));
        }
        lines
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
