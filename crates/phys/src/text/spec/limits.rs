//! What a rig can do and may do: the limits within which a next run is looked for.

use super::reader::Reader;
use super::{Number, Text};
use crate::text::fields;
use crate::text::raw::{Entry, Node, Shape};

/// The limits of a rig, as they are written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LimitsSpec {
    /// Inputs, states, outputs and constants that can be set, each between two values in its unit.
    pub ranges: Vec<(Text, (Number, Number))>,
    /// The longest run (s).
    pub duration: Option<Number>,
    /// The frequencies of a drive (Hz).
    pub band: Option<(Number, Number)>,
}

impl Reader<'_> {
    /// `{ "f": (-5.0, 5.0), "x": (-0.02, 0.02), duration: 60.0, band: (0.1, 10.0) }`
    pub(super) fn limits(&mut self, node: &Node) -> Option<LimitsSpec> {
        if node.shape != Shape::Map {
            let help = "limits look like { \"f\": (-5.0, 5.0), duration: 60.0, band: (0.1, 10.0) }";
            return self.expected(node, "a map `{...}`", help);
        }
        let is_field = |entry: &&Entry| entry.key.as_ref().is_some_and(|key| key.shape == Shape::Name);
        let part = |entries: Vec<Entry>, shape| Node { shape, entries, name: None, ..*node };
        let (fields, ranges): (Vec<&Entry>, Vec<&Entry>) = node.entries.iter().partition(is_field);
        let (fields, ranges) = (fields.into_iter().cloned().collect(), ranges.into_iter().cloned().collect());
        let (fields, ranges) = (part(fields, Shape::Group), part(ranges, Shape::Map));
        let ranges = self.map(&ranges, Self::bounds);
        let fields = self.fields(&fields, &fields::LIMITS)?;
        let duration = self.optional(&fields, "duration", Self::positive);
        let band = self.optional(&fields, "band", Self::band);
        Some(LimitsSpec { ranges: ranges?, duration, band })
    }

    /// Two frequencies above zero.
    fn band(&mut self, node: &Node) -> Option<(Number, Number)> {
        let (low, high) = self.bounds(node)?;
        if low.value > 0.0 {
            return Some((low, high));
        }
        self.wrong(
            low.span,
            "a band begins above 0 Hz",
            "must be greater than zero",
            "the run may rest between: band: (0.1, 10.0)",
        )
    }
}
