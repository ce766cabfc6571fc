//! What drives a simulated record.

use super::reader::Reader;
use super::{InputSpec, Number, Spanned};
use crate::text::fields;
use crate::text::raw::Node;

/// Most cosines of a sum.
const MOST_COSINES: f64 = 1e5;

impl Reader<'_> {
    pub(super) fn input(&mut self, node: &Node) -> Option<InputSpec> {
        match (self.variant(node), node.name) {
            (Some("Jonswap"), Some(_)) => self.jonswap(node),
            (Some("Multisine"), Some(_)) => self.multisine(node),
            (Some("File"), Some(_)) => self.file(node),
            (Some("Formula"), Some(_)) => {
                let formula = self.argument(node, "an expression")?;
                self.words(formula).map(InputSpec::Formula)
            }
            (Some(_), Some(name)) => {
                self.unknown_name("kind of input", name, &["Jonswap", "Formula", "Multisine", "File"])
            }
            _ => {
                let help = "Jonswap(hs: 10.0, tp: 0.5), Formula(\"A*cos(W*t)\"), Multisine(...) or File(...)";
                self.expected(node, "an input", help)
            }
        }
    }

    fn jonswap(&mut self, node: &Node) -> Option<InputSpec> {
        let fields = self.fields(node, &fields::JONSWAP)?;
        let hs = self.required(&fields, "hs", Self::positive);
        let tp = self.required(&fields, "tp", Self::positive);
        let default = |value| Spanned { value, span: node.span };
        let gamma = self.optional(&fields, "gamma", Self::positive).unwrap_or(default(3.3));
        let omega = self.optional(&fields, "omega", Self::frequencies);
        let omega = omega.unwrap_or((default(0.1), default(50.0), default(0.1)));
        Some(InputSpec::Jonswap { hs: hs?, tp: tp?, gamma, omega })
    }

    /// First, last, distance.
    fn frequencies(&mut self, node: &Node) -> Option<(Number, Number, Number)> {
        let [first, last, step] = self.tuple(node, "three numbers: first, last, distance")?;
        let (first, last, step) = (self.positive(first), self.positive(last), self.positive(step));
        let (first, last, step) = (first?, last?, step?);
        if first.value > last.value {
            let message = "the first frequency is above the last";
            return self.wrong(first.span.to(last.span), message, "must go from low to high", "");
        }
        if (last.value - first.value) / step.value > MOST_COSINES {
            let message = format!("more than {MOST_COSINES} frequencies");
            return self.wrong(step.span, message, "too small a distance", "");
        }
        Some((first, last, step))
    }

    fn multisine(&mut self, node: &Node) -> Option<InputSpec> {
        let fields = self.fields(node, &fields::MULTISINE)?;
        let amplitude = self.required(&fields, "amplitude", Self::not_negative);
        let band = self.required(&fields, "band", Self::bounds);
        let count = self.optional(&fields, "count", Self::count);
        if let Some(count) = count.as_ref().filter(|count| f64::from(count.value) > MOST_COSINES) {
            self.wrong::<()>(count.span, format!("more than {MOST_COSINES} frequencies"), "too many", "");
        }
        let band = band?;
        if band.0.value < 0.0 {
            return self.wrong(band.0.span, "a frequency is negative", "must not be negative", "");
        }
        Some(InputSpec::Multisine { amplitude: amplitude?, band, count })
    }

    fn file(&mut self, node: &Node) -> Option<InputSpec> {
        let fields = self.fields(node, &fields::FILE)?;
        let path = self.required(&fields, "path", Self::words);
        let time = self.required(&fields, "time", Self::column);
        let column = self.required(&fields, "column", Self::column);
        Some(InputSpec::File { path: path?, time: time?, column: column? })
    }
}
