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
use number::Numbers;
use phisindy_phys::Case;
use phisindy_phys::spec::Spec;
use read::Reading;
use scheme::{Known, Scheme};

/// The style sheet of sketches, beside that of charts.
pub(crate) const STYLE: &str = include_str!("sketch/sketch.css");

/// The sketch of a case as it is, as lines of a terminal; none where there is nothing to draw.
pub fn sketch(spec: &Spec, case: &Case, look: Look) -> Vec<String> {
    text::lines(&of_case(spec, case), look)
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
