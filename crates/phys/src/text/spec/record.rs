//! Records: where data come from.

use super::group::Fields;
use super::reader::Reader;
use super::size::SAMPLES;
use super::{ColumnSpec, CsvSpec, DeriveSpec, NoiseSpec, Number, Role, Spanned, SyntheticSpec, Text};
use crate::text::fields;
use crate::text::raw::{Node, Shape};
use phisindy_signal::{Detrend, Differentiator, Interpolation};

impl Reader<'_> {
    /// `Csv(path: "run.csv", ...)`, and `Table(path: "run.xlsx", sheet: "1", ...)` with one field more.
    pub(super) fn csv(&mut self, node: &Node, any_format: bool) -> Option<CsvSpec> {
        let fields = match any_format {
            true => self.fields(node, &fields::TABLE)?,
            false => self.fields(node, &fields::CSV)?,
        };
        let sheet = if any_format { self.optional(&fields, "sheet", Self::prose) } else { None };
        let stated = self.optional(&fields, "time", Self::time);
        let (streams, of_record) = self.streams(&fields, any_format, stated.as_ref());
        let path = match streams.iter().find_map(|s| s.spec.path.clone()).filter(|_| !of_record.file) {
            Some(first) => self.optional(&fields, "path", Self::words).or(Some(first)),
            None => self.required(&fields, "path", Self::words),
        };
        let time = match streams.first().filter(|_| !of_record.time) {
            _ if fields.get("time").is_some() => stated,
            Some(first) => Some((first.spec.time.clone(), first.spec.rate.clone())),
            None => self.required(&fields, "time", Self::time),
        };
        let mut columns = match streams.is_empty() {
            true => self.required(&fields, "columns", |r, n| r.map(n, Self::column)),
            false => self.optional(&fields, "columns", |r, n| r.map(n, Self::column)).or(Some(vec![])),
        };
        if let Some(columns) = &mut columns {
            self.own_times(columns, &streams);
        }
        let separator = self.optional(&fields, "separator", Self::character);
        let decimal = self.optional(&fields, "decimal", Self::character);
        self.different(separator.as_ref(), decimal.as_ref());
        let (name, window, role) = (self.name(&fields), self.window(&fields), self.role(&fields));
        let derive = self.pairs(&fields, "derive", Self::derive);
        let mut sensors = self.pairs(&fields, "sensors", Self::sensor);
        let rows = self.pairs(&fields, "rows", Self::number);
        let start = self.pairs(&fields, "start", Self::number);
        let header = self.optional(&fields, "header", Self::truth);
        let skip = self.optional(&fields, "skip", Self::whole).map_or(0, |n| n.value as usize);
        let run = self.optional(&fields, "run", Self::whole);
        let mut interpolate = self.pairs(&fields, "interpolate", Self::interpolation);
        let constants = self.pairs(&fields, "constants", Self::constant);
        let decimate = self.optional(&fields, "decimate", Self::count);
        let omits_missing = self.optional(&fields, "missing", Self::missing).unwrap_or(false);
        let detrend = self.pairs(&fields, "detrend", Self::detrend);
        if let Some(columns) = &mut columns {
            self.measured(&detrend, columns);
            self.channels(&streams, &mut sensors, &mut interpolate, columns);
        }
        let streams = streams.into_iter().map(|stream| stream.spec).collect();
        let (time, rate) = time?;
        Some(CsvSpec {
            path: path?,
            in_memory: false,
            any_format,
            sheet,
            name,
            time,
            rate,
            columns: columns?,
            streams,
            derive,
            sensors,
            rows,
            window,
            start,
            role,
            separator,
            decimal,
            header,
            skip,
            run,
            interpolate,
            constants,
            decimate,
            omits_missing,
            detrend,
            span: node.span,
        })
    }

    /// `Arrays(columns: ["x", "u"], ...)`: columns that a program gives by these names, in the units of the
    /// states and inputs.
    pub(super) fn arrays(&mut self, node: &Node) -> Option<CsvSpec> {
        let fields = self.fields(node, &fields::ARRAYS)?;
        let columns = self.required(&fields, "columns", |r, n| r.list(n, Self::words));
        let (name, role) = (self.name(&fields), self.role(&fields));
        let derive = self.pairs(&fields, "derive", Self::derive);
        let sensors = self.pairs(&fields, "sensors", Self::sensor);
        let start = self.pairs(&fields, "start", Self::number);
        let interpolate = self.pairs(&fields, "interpolate", Self::interpolation);
        let constants = self.pairs(&fields, "constants", Self::constant);
        let here = |value: &str| Text { value: value.to_owned(), span: node.span };
        let plain = |name: Text| (name.clone(), ColumnSpec { header: name, unit: None });
        Some(CsvSpec {
            path: name.clone().unwrap_or_else(|| here("record")),
            in_memory: true,
            any_format: false,
            sheet: None,
            name,
            time: ColumnSpec { header: here("t"), unit: None },
            rate: None,
            columns: columns?.into_iter().map(plain).collect(),
            streams: vec![],
            derive,
            sensors,
            rows: vec![],
            window: None,
            start,
            role,
            separator: None,
            decimal: None,
            header: None,
            skip: 0,
            run: None,
            interpolate,
            constants,
            decimate: None,
            omits_missing: false,
            detrend: vec![],
            span: node.span,
        })
    }

    pub(super) fn synthetic(&mut self, node: &Node) -> Option<SyntheticSpec> {
        let fields = self.fields(node, &fields::SYNTHETIC)?;
        let truth = self.required(&fields, "truth", |r, n| r.map(n, Self::words));
        let start = self.required(&fields, "start", |r, n| r.map(n, Self::number));
        let duration = self.required(&fields, "duration", Self::positive);
        let step = self.required(&fields, "step", Self::positive);
        if let (Some(duration), Some(step)) = (&duration, &step) {
            self.samples(duration, step);
        }
        let (name, window, role) = (self.name(&fields), self.window(&fields), self.role(&fields));
        let noise = self.optional(&fields, "noise", Self::noise).unwrap_or(NoiseSpec::None);
        let seed = self.optional(&fields, "seed", Self::whole).map(|seed| seed.value);
        let inputs = self.pairs(&fields, "inputs", Self::input);
        let derive = self.pairs(&fields, "derive", Self::derive);
        let sensors = self.pairs(&fields, "sensors", Self::sensor);
        for (name, _) in sensors.iter().filter(|(_, s)| s.per.is_some() || s.unwrap.is_some()) {
            let message = format!("the column of `{}` is made here: it counts nothing", name.value);
            self.wrong::<()>(name.span, message, "`per` and `unwrap` are for files", "delete them");
        }
        let measure = self.optional(&fields, "measure", |r, n| {
            r.filled(n, "name what is measured, or leave the list out", Self::words)
        });
        let interpolate = self.pairs(&fields, "interpolate", Self::interpolation);
        let constants = self.pairs(&fields, "constants", Self::constant);
        Some(SyntheticSpec {
            name,
            truth: truth?,
            start: start?,
            duration: duration?,
            step: step?,
            noise,
            seed,
            inputs,
            derive,
            sensors,
            measure,
            window,
            role,
            interpolate,
            constants,
            span: node.span,
        })
    }

    fn name(&mut self, fields: &Fields<'_, '_>) -> Option<Text> {
        self.optional(fields, "name", Self::prose)
    }

    fn window(&mut self, fields: &Fields<'_, '_>) -> Option<(Number, Number)> {
        self.optional(fields, "window", Self::bounds)
    }

    fn role(&mut self, fields: &Fields<'_, '_>) -> Role {
        let table = [("Fit", Role::Fit), ("Validate", Role::Validate)];
        self.optional(fields, "role", |r, n| r.choice(n, "role", &table)).unwrap_or_default()
    }

    /// A column, or `Rate(1000.0)` where the file has none of time.
    pub(super) fn time(&mut self, node: &Node) -> Option<(ColumnSpec, Option<Number>)> {
        if self.variant(node) != Some("Rate") {
            return self.column(node).map(|column| (column, None));
        }
        let rate = self.argument(node, "the number of rows per second")?;
        let header = Text { value: String::new(), span: node.span };
        Some((ColumnSpec { header, unit: None }, Some(self.positive(rate)?)))
    }

    /// `"time_s"` or `("x_mass_m", "m")`.
    pub(super) fn column(&mut self, node: &Node) -> Option<ColumnSpec> {
        if node.shape == Shape::Text {
            return Some(ColumnSpec { header: self.words(node)?, unit: None });
        }
        let [header, unit] =
            self.tuple(node, "a column's heading, or heading and unit like (\"x_mm\", \"mm\")")?;
        let (header, unit) = (self.words(header), self.unit(unit));
        Some(ColumnSpec { header: header?, unit: Some(unit?) })
    }

    fn derive(&mut self, node: &Node) -> Option<DeriveSpec> {
        match (self.variant(node), node.name) {
            (Some("Derivative"), Some(_)) => match node.entries.as_slice() {
                [of, how] if of.key.is_none() && how.key.is_none() => {
                    let how = self.differentiator(&how.value);
                    Some(DeriveSpec::Derivative(self.words(&of.value)?, Some(how?)))
                }
                _ => {
                    let input =
                        self.argument(node, "the name of an input, and perhaps how to differentiate it")?;
                    self.words(input).map(|of| DeriveSpec::Derivative(of, None))
                }
            },
            (Some(_), Some(name)) => self.unknown_name("way to derive", name, &["Derivative"]),
            _ => self.expected(node, "`Derivative(\"u\")`", ""),
        }
    }

    pub(super) fn differentiator(&mut self, node: &Node) -> Option<Differentiator> {
        self.choice(node, "differentiator", &Differentiator::ALL.map(|d| (d.name(), d)))
    }

    fn interpolation(&mut self, node: &Node) -> Option<Interpolation> {
        let table = [
            ("Linear", Interpolation::Linear),
            ("Hold", Interpolation::Hold),
            ("Cubic", Interpolation::Cubic),
        ];
        self.choice(node, "interpolation", &table)
    }

    /// Whether rows without a value are left out.
    fn missing(&mut self, node: &Node) -> Option<bool> {
        self.choice(node, "way with missing values", &[("Omit", true), ("Refuse", false)])
    }

    fn detrend(&mut self, node: &Node) -> Option<Detrend> {
        self.choice(node, "trend", &[("Mean", Detrend::Mean), ("Linear", Detrend::Linear)])
    }

    /// A trend can only be taken off something that has a column.
    fn measured(&mut self, detrend: &[(Text, Detrend)], columns: &[(Text, ColumnSpec)]) {
        for (name, _) in detrend.iter().filter(|(n, _)| columns.iter().all(|(c, _)| c.value != n.value)) {
            let message = format!("`{}` has no column here, so it has no trend", name.value);
            let list: Vec<&str> = columns.iter().map(|(c, _)| c.value.as_str()).collect();
            let help = format!("`columns` of this record holds: {}", list.join(", "));
            self.wrong::<()>(name.span, message, "not in `columns`", &help);
        }
    }

    fn noise(&mut self, node: &Node) -> Option<NoiseSpec> {
        const KINDS: &[&str] = &["Relative", "Additive", "Sensor"];
        let (Some(kind), Some(name)) = (self.variant(node), node.name) else {
            let help = "Relative(0.1), Additive(0.02) or Sensor({\"x\": (1e-6, \"m\")})";
            return self.expected(node, "a kind of noise", help);
        };
        if !KINDS.contains(&kind) {
            return self.unknown_name("kind of noise", name, KINDS);
        }
        let argument =
            self.argument(node, if kind == "Sensor" { "a map of columns" } else { "one number" })?;
        match kind {
            "Relative" => self.not_negative(argument).map(NoiseSpec::Relative),
            "Additive" => self.not_negative(argument).map(NoiseSpec::Additive),
            _ => self.map(argument, Self::deviation).map(NoiseSpec::Sensor),
        }
    }

    fn deviation(&mut self, node: &Node) -> Option<(Number, Option<Text>)> {
        let (value, unit) = self.quantity(node)?;
        if value.value < 0.0 {
            let message = format!("expected zero or more, found {}", self.slice(value.span));
            return self.wrong(
                value.span,
                message,
                "must not be negative",
                "a standard deviation is zero or more",
            );
        }
        Some((value, unit))
    }

    fn samples(&mut self, duration: &Number, step: &Number) {
        let count = duration.value / step.value;
        if count < 1.0 {
            self.wrong::<()>(
                step.span,
                "the step is longer than the duration",
                "longer than the whole record",
                "take a shorter step, or a longer duration",
            );
        } else if count > SAMPLES {
            let message = format!("{count:.1e} samples are too many (at most {SAMPLES:.0e})");
            self.wrong::<()>(
                step.span,
                message,
                "too short for this duration",
                "take a longer step, or a shorter duration",
            );
        }
    }

    fn different(&mut self, separator: Option<&Spanned<char>>, decimal: Option<&Spanned<char>>) {
        if let (Some(separator), Some(decimal)) = (separator, decimal)
            && separator.value == decimal.value
        {
            let message = "separator and decimal mark are the same character";
            self.wrong::<()>(
                decimal.span,
                message,
                "the separator too",
                "give another separator, such as ';'",
            );
        }
    }
}
