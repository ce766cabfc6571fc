//! The model as a sketch: bodies, springs, dampers, contacts, forces and sensors, and what was found in it.
//!
//! ```text
//! Spec, Case --named, probe--> System with names --moving, acting, linear--> Scheme --found--> Scheme, lit
//! Scheme --layout (row, below, blocks)--> Canvas --> SVG        Scheme --text--> lines of a terminal
//! ```
//!
//! What a part is, is asked of the expressions of the checked system: a force in proportion to a difference of two
//! displacements is a spring between them, whatever the spec calls it.

mod acting;
mod below;
mod blocks;
mod canvas;
mod editable;
mod found;
mod layout;
mod linear;
#[cfg(test)]
mod mechanisms;
mod moving;
mod named;
mod number;
mod probe;
mod read;
mod row;
mod scheme;
mod symbol;
mod terms;
#[cfg(test)]
mod tests;
mod text;

use crate::chart::Chart;
use crate::gap::GapReport;
use crate::run::RunReport;
use crate::terminal::Look;
pub use editable::{EditableSketch, SketchBody, SketchEnd, SketchPart, editable_sketch};
pub(crate) use moving::Moving;
use number::Numbers;
use phisindy_learn::FoundParameter;
use phisindy_phys::spec::Spec;
use phisindy_phys::{Case, System};
use read::Reading;
use scheme::{Known, Scheme};
use std::collections::HashMap;

/// The style sheet of sketches, beside that of charts.
pub(crate) const STYLE: &str = include_str!("sketch/sketch.css");

/// The style sheet of a page with an [`editable_sketch`].
pub fn sketch_style() -> String {
    format!("{}{STYLE}", crate::chart::STYLE)
}

/// The sketch of a case as it is, as lines of a terminal; none where there is nothing to draw.
pub fn sketch(spec: &Spec, case: &Case, look: Look) -> Vec<String> {
    text::lines(&of_case(spec, case), look)
}

/// A model as the sketch reads it: the system with the names of its constants, what these are worth (SI), and
/// what moves in it.
pub(crate) struct Model {
    pub(crate) system: System,
    pub(crate) values: HashMap<String, f64>,
    pub(crate) bodies: Vec<Moving>,
}

impl Model {
    /// With the numbers that were found.
    pub(crate) fn new(spec: &Spec, case: &Case, found: &[FoundParameter]) -> Model {
        let Reading { system, numbers, bodies, .. } = Reading::read(spec, case, found::numbers(found));
        Model { system, values: numbers.values, bodies }
    }
}

fn of_case(spec: &Spec, case: &Case) -> Scheme {
    let mut reading = Reading::new(spec, case, Numbers::default());
    found::add_sought(&mut reading, case);
    reading.scheme
}

/// The sketch of what `run` found.
pub(crate) fn of_run(report: &RunReport<'_>) -> Option<(Chart, String)> {
    let input = report.input;
    let numbers = found::numbers(&report.identified.parameters);
    let mut reading = Reading::new(input.spec, input.case, numbers);
    found::add_found(&mut reading, report);
    chart(&reading.scheme)
}

/// The sketch of what `gap` found.
pub(crate) fn of_gap(report: &GapReport<'_>) -> Option<(Chart, String)> {
    let input = report.input;
    let mut reading = Reading::new(input.spec, input.case, found::numbers(&report.gap.parameters));
    found::add_steps(&mut reading, report);
    chart(&reading.scheme)
}

/// The picture with its caption; none of a scheme without parts.
fn chart(scheme: &Scheme) -> Option<(Chart, String)> {
    if scheme.bodies.is_empty() && scheme.blocks.is_empty() {
        return None;
    }
    let canvas = layout::drawn(scheme);
    let said = text::sentences(scheme);
    let chart = Chart::new("model-sketch", "Sketch of the model", &said, layout::size(&canvas));
    let mut chart = chart.styled(STYLE);
    chart.draw(canvas.drawn);
    let lit = scheme.elements.iter().map(|e| e.known).chain(scheme.pushes.iter().map(|p| p.known));
    let lit = lit.chain(scheme.blocks.iter().map(|b| b.known));
    let lit = lit.chain(scheme.bodies.iter().filter(|b| !b.lit.is_empty()).map(|_| Known::Found));
    let caption = match lit.max() {
        Some(Known::Found) => "The model as the spec states it; blue: what was found.",
        _ => "The model as the spec states it.",
    };
    Some((chart, caption.to_owned()))
}
