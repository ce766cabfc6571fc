//! Streams: columns of a record that have times of their own.

use super::group::Fields;
use super::reader::Reader;
use super::{ColumnSpec, Number, StreamSpec, Text};

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
    ) -> (Vec<StreamSpec>, OfRecord) {
        let left = fields.get("columns").is_some_and(|columns| !columns.entries.is_empty());
        let mut of_record = OfRecord { file: left, time: left };
        let streams = self.pairs(fields, "streams", |r, node| {
            const FIELDS: &[&str] = &["sheet", "path", "time", "column"];
            let of = r.fields(node, "a stream", if any_format { FIELDS } else { &FIELDS[1..] })?;
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
            let ((time, rate), name) = (time?, Text { value: String::new(), span: node.span });
            Some(StreamSpec { name, path, sheet, time, rate, column: column?, span: node.span })
        });
        let named = streams.into_iter().map(|(name, stream)| StreamSpec { name, ..stream });
        (named.collect(), of_record)
    }

    /// Adds the columns of streams to those of the rows; none stands in both.
    pub(super) fn own_times(&mut self, columns: &mut Vec<(Text, ColumnSpec)>, streams: &[StreamSpec]) {
        for stream in streams {
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
