//! Streams: columns of a record that have times of their own; and what a column of counts or of a single turn is.

use super::group::Fields;
use super::reader::Reader;
use super::{ColumnSpec, Number, SensorSpec, Spanned, StreamSpec, Text};
use crate::text::fields;
use crate::text::raw::Node;
use phisindy_expr::{Graph, parse};
use phisindy_signal::Interpolation;

/// A stream, and what it says of its sensor and of what is between two samples.
pub(super) struct Stream {
    pub(super) spec: StreamSpec,
    channel: SensorSpec,
    hold: bool,
}

/// What streams leave to the record.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OfRecord {
    /// The file of a stream, or of `columns`.
    pub(super) file: bool,
    /// The time of a stream, or of `columns`.
    pub(super) time: bool,
}

impl Reader<'_> {
    /// `{ "x": (path: "camera.csv", time: "t", column: ("x_mm", "mm")), ... }`, and what they leave to the record.
    pub(super) fn streams(
        &mut self,
        fields: &Fields<'_, '_>,
        any_format: bool,
        shared: Option<&(ColumnSpec, Option<Number>)>,
    ) -> (Vec<Stream>, OfRecord) {
        let left = fields.get("columns").is_some_and(|columns| !columns.entries.is_empty());
        let mut of_record = OfRecord { file: left, time: left };
        let streams = self.pairs(fields, "streams", |r, node| {
            let of = r.fields(node, if any_format { &fields::STREAM } else { &fields::CSV_STREAM })?;
            let path = r.optional(&of, "path", Self::words);
            let sheet = if any_format { r.optional(&of, "sheet", Self::prose) } else { None };
            of_record.file |= path.is_none();
            let time = match (of.get("time"), shared) {
                (None, Some(shared)) => {
                    of_record.time = true;
                    Some(shared.clone())
                }
                _ => r.required(&of, "time", Self::time),
            };
            let column = r.required(&of, "column", Self::column);
            let (channel, hold) = (r.channel(&of), r.optional(&of, "hold", Self::truth).unwrap_or(false));
            let ((time, rate), name) = (time?, Text { value: String::new(), span: node.span });
            let spec = StreamSpec { name, path, sheet, time, rate, column: column?, span: node.span };
            Some(Stream { spec, channel, hold })
        });
        let named = |(name, Stream { spec, channel, hold })| Stream {
            spec: StreamSpec { name, ..spec },
            channel,
            hold,
        };
        (streams.into_iter().map(named).collect(), of_record)
    }

    /// What a column of counts or of a single turn is: the same fields in a stream and in a sensor.
    pub(super) fn channel(&mut self, fields: &Fields<'_, '_>) -> SensorSpec {
        SensorSpec {
            quantum: self.optional(fields, "quantum", Self::step),
            per: self.optional(fields, "per", Self::per),
            unwrap: self.optional(fields, "unwrap", Self::turn),
            ..SensorSpec::default()
        }
    }

    fn step(&mut self, node: &Node) -> Option<(Number, Option<Text>)> {
        let (number, unit) = self.quantity(node)?;
        if number.value > 0.0 {
            return Some((number, unit));
        }
        self.wrong(node.span, "a quantum is greater than zero", "the step of a column", "")
    }

    /// `("rev", 4096)`: so many counts in one of these units.
    fn per(&mut self, node: &Node) -> Option<Text> {
        let [unit, count] = self.tuple(node, "a unit and how many counts it has, like (\"rev\", 4096)")?;
        let (unit, count) = (self.words(unit), self.positive(count));
        let (unit, count) = (unit?, count?);
        Some(Spanned { value: format!("{}/{}", unit.value, count.value), span: unit.span })
    }

    /// A number in SI, or an expression of numbers: `"2*pi"`.
    fn turn(&mut self, node: &Node) -> Option<Number> {
        if node.shape == crate::text::raw::Shape::Number {
            return self.positive(node);
        }
        let text = self.words(node)?;
        let mut graph = Graph::default();
        let root = parse(&text.value).ok().and_then(|ast| graph.lower(&ast, |_| None).ok());
        match root.and_then(|root| graph.value(root)).filter(|turn| *turn > 0.0) {
            Some(value) => Some(Spanned { value, span: text.span }),
            None => self.wrong(
                text.span,
                format!("`{}` is no turn", text.value),
                "should be a number greater than zero",
                "write after how much the column begins anew, in SI: \"2*pi\" of an angle",
            ),
        }
    }

    /// Gives each sensor what the stream of its column says, and each column of counts its unit.
    pub(super) fn channels(
        &mut self,
        streams: &[Stream],
        sensors: &mut Vec<(Text, SensorSpec)>,
        interpolate: &mut Vec<(Text, Interpolation)>,
        columns: &mut [(Text, ColumnSpec)],
    ) {
        for Stream { spec: StreamSpec { name, .. }, channel, hold } in streams {
            if *hold && interpolate.iter().all(|(n, _)| n.value != name.value) {
                interpolate.push((name.clone(), Interpolation::Hold));
            }
            if *channel == SensorSpec::default() {
                continue;
            }
            match sensors.iter_mut().find(|(n, _)| n.value == name.value) {
                Some((_, own)) => {
                    let SensorSpec { quantum, per, unwrap, .. } = channel.clone();
                    own.quantum = own.quantum.take().or(quantum);
                    own.per = own.per.take().or(per);
                    own.unwrap = own.unwrap.take().or(unwrap);
                }
                None => sensors.push((name.clone(), channel.clone())),
            }
        }
        for (name, per) in sensors.iter().filter_map(|(name, sensor)| Some((name, sensor.per.as_ref()?))) {
            let Some((_, column)) = columns.iter_mut().find(|(n, _)| n.value == name.value) else { continue };
            if let Some(unit) = column.unit.as_ref().filter(|unit| unit.value.trim() != "count") {
                let message = format!("`{}` is in `{}`, and has counts per unit too", name.value, unit.value);
                self.wrong::<()>(per.span, message, "counts have no other unit", "delete one of the two");
            }
            column.unit = Some(per.clone());
        }
    }

    /// Adds the columns of streams to those of the rows; none stands in both.
    pub(super) fn own_times(&mut self, columns: &mut Vec<(Text, ColumnSpec)>, streams: &[Stream]) {
        for Stream { spec: stream, .. } in streams {
            let name = &stream.name;
            if columns.iter().any(|(n, _)| n.value == name.value) {
                let message = format!("`{}` stands in `columns` and in `streams`", name.value);
                self.wrong::<()>(name.span, message, "has a column already", "delete one of the two");
            } else {
                columns.push((name.clone(), stream.column.clone()));
            }
        }
    }
}
