//! Numbers as JSON, which knows none without an end: those stand as the words `inf`, `-inf`, `NaN`.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Written {
    Number(f64),
    Word(String),
}

fn written(x: &f64) -> Written {
    if x.is_finite() { Written::Number(*x) } else { Written::Word(x.to_string()) }
}

fn read<E: serde::de::Error>(from: Written) -> Result<f64, E> {
    match from {
        Written::Number(x) => Ok(x),
        Written::Word(word) => word.parse().map_err(|_| E::custom(format!("`{word}` is no number"))),
    }
}

pub(crate) fn serialize<S: Serializer>(all: &[f64], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(all.iter().map(written))
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<f64>, D::Error> {
    Vec::<Written>::deserialize(from)?.into_iter().map(read).collect()
}

/// The same of rows.
pub(crate) mod rows {
    use super::*;

    pub(crate) fn serialize<S: Serializer>(all: &[Vec<f64>], to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(all.iter().map(|row| row.iter().map(written).collect::<Vec<_>>()))
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Vec<f64>>, D::Error> {
        let rows = Vec::<Vec<Written>>::deserialize(from)?.into_iter();
        rows.map(|row| row.into_iter().map(read).collect()).collect()
    }
}

/// The same of numbers with their names, intervals and units.
pub(crate) mod intervals {
    use super::*;

    type Named = (String, f64, (f64, f64), String);

    pub(crate) fn serialize<S: Serializer>(all: &[Named], to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(all.iter().map(|(name, value, (low, high), unit)| {
            (name, written(value), (written(low), written(high)), unit)
        }))
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Named>, D::Error> {
        let all = Vec::<(String, Written, (Written, Written), String)>::deserialize(from)?.into_iter();
        all.map(|(name, value, (low, high), unit)| Ok((name, read(value)?, (read(low)?, read(high)?), unit)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::{Cause, Estimates, Number, Unit};

    /// A number that the data say nothing about has an infinite variance, and comes back as that.
    #[test]
    fn a_unit_comes_back_to_the_bit() {
        let number = |name: &str| Number { name: name.into(), unit: "N".into(), factor: 1e3 };
        let numbers = vec![("Fc".to_owned(), 0.1 + 0.2, (f64::NEG_INFINITY, 1.0 / 3.0), "N".to_owned())];
        let unit = Unit {
            name: "a".into(),
            causes: vec![Cause { law: "coulomb".into(), at: "v".into(), stated: Some(0.1), numbers }],
            estimates: Estimates {
                numbers: vec![number("k"), number("m")],
                values: vec![0.1, 1e-300],
                covariance: vec![vec![f64::INFINITY, 0.0], vec![0.0, 2.0 / 3.0]],
            },
            ..Unit::default()
        };
        let text = serde_json::to_string(&unit).expect("a text");
        assert_eq!(serde_json::from_str::<Unit>(&text).expect("a unit"), unit, "{text}");
    }
}
