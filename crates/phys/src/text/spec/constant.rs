//! Constants, and whatever else is a number that may move.

use super::group::Fields;
use super::reader::Reader;
use super::{ConstantSpec, FilterSpec, Find, Movable, Number, SensorSpec, SensorValue, Text};
use crate::text::diagnostic::Diagnostic;
use crate::text::fields;
use crate::text::raw::{Node, Shape};

/// How a constant may be written.
const FORMS: &str = "a constant is 1.0, (1.0, \"kg\"), \"sqrt(k/m)\", (value: 1.0, unit: \"kg\", within: (0.5, 2.0)), \
                     Find(start: 1.0, unit: \"kg\", within: (0.5, 2.0)) or MaxAbs(\"F\")";

/// Standard deviations of a belief beyond which nothing lies: a normal number is there once in 10^15.
const BELIEVED: f64 = 8.0;

impl Reader<'_> {
    /// A constant in any of its forms: what stands first tells which.
    pub(super) fn constant(&mut self, node: &Node) -> Option<ConstantSpec> {
        match node.shape {
            Shape::Number => self.number(node).map(|value| ConstantSpec::Number { value, unit: None }),
            Shape::Text => self.words(node).map(ConstantSpec::Expression),
            Shape::Group => match (self.variant(node), node.name) {
                (Some("Find"), _) => self.find(node).map(ConstantSpec::Find),
                (Some("MaxAbs"), _) => {
                    let input = self.argument(node, "the name of an input")?;
                    self.words(input).map(ConstantSpec::MaxAbs)
                }
                (Some(_), Some(name)) => self.unknown_name("kind of constant", name, &["Find", "MaxAbs"]),
                _ if node.entries.iter().any(|e| e.key.is_some()) => {
                    self.movable(node).map(ConstantSpec::Movable)
                }
                _ => {
                    let (value, unit) = self.quantity(node)?;
                    Some(ConstantSpec::Number { value, unit })
                }
            },
            _ => self.expected(node, "a constant", FORMS),
        }
    }

    /// `1.0` or `(1.0, "kg")`.
    pub(super) fn quantity(&mut self, node: &Node) -> Option<(Number, Option<Text>)> {
        if node.shape == Shape::Number {
            return Some((self.number(node)?, None));
        }
        let [value, unit] = self.tuple(node, "a number, or a number and its unit like (1.0, \"kg\")")?;
        let (value, unit) = (self.number(value), self.unit(unit));
        Some((value?, Some(unit?)))
    }

    fn movable(&mut self, node: &Node) -> Option<Movable> {
        let fields = self.fields(node, &fields::MOVABLE)?;
        let value = self.required(&fields, "value", Self::number);
        let unit = self.optional(&fields, "unit", Self::unit);
        let sigma = self.optional(&fields, "sigma", Self::positive);
        let within = self.bounds_or_belief(&fields, value.as_ref(), sigma.as_ref());
        let each = self.optional(&fields, "each", Self::truth).unwrap_or(false);
        let (value, within) = (value?, within?);
        self.inside(&value, &within);
        Some(Movable { value, unit, within, sigma, each, span: node.span })
    }

    /// `Find(start: ..., within: ...)`; the caller has seen the name.
    pub(super) fn find(&mut self, node: &Node) -> Option<Find> {
        let fields = self.fields(node, &fields::FIND)?;
        let start = self.required(&fields, "start", Self::number);
        let unit = self.optional(&fields, "unit", Self::unit);
        let sigma = self.optional(&fields, "sigma", Self::positive);
        let within = self.bounds_or_belief(&fields, start.as_ref(), sigma.as_ref());
        let each = self.optional(&fields, "each", Self::truth).unwrap_or(false);
        let (start, within) = (start?, within?);
        self.inside(&start, &within);
        Some(Find { start, unit, within, sigma, each, span: node.span })
    }

    /// The bounds of a number; of one with a belief they may be left out, and stand so far out that no belief
    /// reaches them.
    fn bounds_or_belief(
        &mut self,
        fields: &Fields<'_, '_>,
        centre: Option<&Number>,
        sigma: Option<&Number>,
    ) -> Option<(Number, Number)> {
        let (None, Some(centre), Some(sigma)) = (fields.get("within"), centre, sigma) else {
            return self.required(fields, "within", Self::bounds);
        };
        let at = |value: f64| Number { value, ..centre.clone() };
        let reach = BELIEVED * sigma.value;
        Some((at(centre.value - reach), at(centre.value + reach)))
    }

    fn inside(&mut self, value: &Number, within: &(Number, Number)) {
        let (low, high) = within;
        if (low.value..=high.value).contains(&value.value) {
            return;
        }
        let place = self.slice(value.span);
        let diagnostic = Diagnostic::error(format!("{place} lies outside its bounds"))
            .at(self.source, value.span, "outside")
            .also(self.source, low.span.to(high.span), "the bounds")
            .help("move the bounds, or start inside them");
        self.note(diagnostic);
    }

    /// Offset, gain, delay and filters of a column.
    pub(super) fn sensor(&mut self, node: &Node) -> Option<SensorSpec> {
        let fields = self.fields(node, &fields::SENSOR)?;
        let offset = self.optional(&fields, "offset", Self::sensor_value);
        let gain = self.optional(&fields, "gain", Self::sensor_value);
        let delay = self.optional(&fields, "delay", Self::sensor_value);
        let clock = self.optional(&fields, "clock", Self::sensor_value);
        let lag = self.optional(&fields, "lag", Self::sensor_value);
        let average = self.optional(&fields, "average", Self::quantity);
        let lowpass = self.optional(&fields, "lowpass", Self::filter);
        let highpass = self.optional(&fields, "highpass", Self::filter);
        Some(SensorSpec {
            offset,
            gain,
            delay,
            clock,
            lag,
            average,
            lowpass,
            highpass,
            ..self.channel(&fields)
        })
    }

    /// `(order: 2, cutoff: (500.0, "Hz"))`
    fn filter(&mut self, node: &Node) -> Option<FilterSpec> {
        let fields = self.fields(node, &fields::FILTER)?;
        let order = self.required(&fields, "order", Self::count);
        let cutoff =
            self.required(&fields, "cutoff", |reader, node| match (node.shape, reader.variant(node)) {
                (Shape::Group, None) => {
                    let (value, unit) = reader.quantity(node)?;
                    Some((SensorValue::Number(value), unit))
                }
                _ => Some((reader.sensor_value(node)?, None)),
            });
        Some(FilterSpec { order: order?, cutoff: cutoff?, span: node.span })
    }

    pub(super) fn sensor_value(&mut self, node: &Node) -> Option<SensorValue> {
        match (node.shape, self.variant(node)) {
            (Shape::Number, _) => self.number(node).map(SensorValue::Number),
            (Shape::Group, Some("Find")) => self.find(node).map(SensorValue::Find),
            (Shape::Text, _) => self.words(node).map(SensorValue::Constant),
            _ => self.expected(
                node,
                "a number, `Find(...)` or the name of a constant",
                "a number is taken in SI units",
            ),
        }
    }
}
