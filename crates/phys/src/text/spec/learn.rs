//! How to identify.

use super::reader::Reader;
use super::{Crossings, LearnSpec, Method, Optimiser, SegmentsSpec, SelectionSpec};
use crate::text::fields;
use crate::text::raw::{Node, Shape};

/// What the lists of stages ask for.
const STAGES: &str = "give one number for each stage, or leave the list out";

impl Reader<'_> {
    pub(super) fn learn(&mut self, node: &Node) -> Option<LearnSpec> {
        let optimisers =
            [("RAdam", Optimiser::RAdam), ("Sgd", Optimiser::Sgd), ("GaussNewton", Optimiser::GaussNewton)];
        let crossings = [("Keep", Crossings::Keep), ("Skip", Crossings::Skip)];
        let methods = [("Step", Method::Step), ("Trajectory", Method::Trajectory)];
        let fields = self.fields(node, &fields::LEARN)?;
        let optimiser = self.optional(&fields, "optimiser", |r, n| r.choice(n, "optimiser", &optimisers));
        let epochs =
            self.optional(&fields, "epochs", |r, n| r.filled(n, STAGES, |r, n| Some(r.count(n)?.value)));
        let rates =
            self.optional(&fields, "rates", |r, n| r.filled(n, STAGES, |r, n| Some(r.positive(n)?.value)));
        if let (Some(epochs), Some(rates)) = (fields.get("epochs"), fields.get("rates"))
            && (epochs.shape, rates.shape) == (Shape::List, Shape::List)
            && epochs.entries.len() != rates.entries.len()
        {
            let message = format!(
                "{} learning rates for {} stages of epochs",
                rates.entries.len(),
                epochs.entries.len()
            );
            self.wrong::<()>(rates.span, message, "one rate for each stage", "");
        }
        Some(LearnSpec {
            optimiser,
            epochs,
            rates,
            cutoff: self.optional(&fields, "cutoff", Self::not_negative),
            tolerance: self.optional(&fields, "tolerance", Self::not_negative),
            crossings: self
                .optional(&fields, "crossings", |r, n| r.choice(n, "treatment of crossings", &crossings)),
            selection: self.optional(&fields, "selection", Self::selection),
            horizon: self.optional(&fields, "horizon", Self::count).map(|horizon| horizon.value),
            segments: self.optional(&fields, "segments", Self::segments),
            differentiator: self.optional(&fields, "differentiator", Self::differentiator),
            method: self.optional(&fields, "method", |r, n| r.choice(n, "method", &methods)),
        })
    }

    fn selection(&mut self, node: &Node) -> Option<SelectionSpec> {
        match (self.variant(node), node.shape) {
            (Some("Auto"), Shape::Name) => Some(SelectionSpec::Auto),
            (Some("All"), Shape::Name) => Some(SelectionSpec::All),
            (Some("Cutoff"), Shape::Group) => {
                let value = self.argument(node, "one number")?;
                self.not_negative(value).map(|value| SelectionSpec::Cutoff(value.value))
            }
            (Some(_), _) => {
                self.unknown_name("selection", node.name.unwrap_or(node.span), &["Auto", "All", "Cutoff(x)"])
            }
            _ => self.expected(node, "a selection", "Auto, All or Cutoff(0.05)"),
        }
    }

    /// `Auto`, `Count(4)`, or plainly 4.
    fn segments(&mut self, node: &Node) -> Option<SegmentsSpec> {
        let count = match (self.variant(node), node.shape) {
            (Some("Auto"), Shape::Name) => return Some(SegmentsSpec::Auto),
            (Some("Count"), Shape::Group) => self.argument(node, "one whole number")?,
            (Some(_), _) => {
                return self.unknown_name(
                    "number of segments",
                    node.name.unwrap_or(node.span),
                    &["Auto", "Count(n)"],
                );
            }
            (None, Shape::Number) => node,
            _ => return self.expected(node, "a number of segments", "Auto or Count(4)"),
        };
        self.count(count).map(|count| SegmentsSpec::Count(count.value))
    }
}
