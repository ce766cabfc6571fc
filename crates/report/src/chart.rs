//! Charts as SVG: panels with axes. Elements carry classes and a style sheet sets their colours, so that one
//! picture serves light and dark pages and paper.
//!
//! ```text
//! Panel { axes, marks } --> Chart (panels placed in a picture, a legend) --> SVG, alone or in a page
//! ```

mod axis;
mod coordinates;
mod decimate;
mod heatmap;
mod label;
mod legend;
mod mark;
mod panel;
mod picture;
mod sheet;
mod strip;

pub(crate) use axis::{Axis, Scale, digits};
pub(crate) use coordinates::Place;
pub(crate) use heatmap::heatmap;
pub(crate) use label::{at, shortened, width_of, word};
pub(crate) use legend::{Entry, Swatch, legend};
pub(crate) use mark::Mark;
pub(crate) use panel::Panel;
pub(crate) use picture::{Chart, STYLE};
pub(crate) use sheet::Sheet;
pub(crate) use strip::Strip;
