//! Tables. Numbers are shown with five digits; the full value is in the `value` attribute.

use crate::markup::{Element, element};
pub(crate) use crate::table::raised as unit;
use crate::table::{ends, short};
use phisindy_learn::{Estimate, FoundParameter};

/// A cell.
pub(crate) enum Cell {
    /// Words.
    Text(String),
    /// Text in the language of the specs.
    Code(String),
    /// The same for one record.
    CodeOf(String, String),
    /// A number.
    Number(f64),
    /// An interval.
    Interval(f64, f64),
    /// Anything else.
    Made(Element),
}

/// Words in a cell.
pub(crate) fn text(text: impl Into<String>) -> Cell {
    Cell::Text(text.into())
}

/// Code in a cell.
pub(crate) fn code(text: impl Into<String>) -> Cell {
    Cell::Code(text.into())
}

/// A table with a caption for screen readers; none without rows.
pub(crate) fn table(caption: &str, head: &[&str], rows: Vec<Vec<Cell>>) -> Option<Element> {
    if rows.is_empty() {
        return None;
    }
    let heads = head.iter().map(|h| element("th").with("scope", "col").text(h));
    // On a phone a row is a card, and each cell of it says what it is.
    let labelled = |(c, h): (Cell, &&str)| cell(c).with("data-label", h);
    let body = rows.into_iter().map(|row| element("tr").all(row.into_iter().zip(head).map(labelled)));
    let table = element("table")
        .add(element("caption").text(caption))
        .add(element("thead").add(element("tr").all(heads)))
        .add(element("tbody").all(body));
    Some(
        element("div")
            .class("scroll")
            .with("tabindex", 0)
            .with("role", "group")
            .with("aria-label", caption)
            .add(table),
    )
}

fn cell(cell: Cell) -> Element {
    let td = element("td");
    match cell {
        Cell::Text(text) => td.text(text),
        Cell::Code(text) => td.add(element("code").text(text)),
        Cell::CodeOf(name, record) => {
            td.add(element("span").add(element("code").text(name)).text(format!(" of {record}")))
        }
        Cell::Made(element) => td.add(element),
        Cell::Number(x) => td.class("number").add(number(x)),
        Cell::Interval(a, b) => {
            let (low, high) = ends(a, b);
            let inside =
                element("span").text("[").add(shown(a, &low)).text(", ").add(shown(b, &high)).text("]");
            td.class("number").add(inside)
        }
    }
}

/// A number with its full value as attribute.
fn number(x: f64) -> Element {
    shown(x, &short(x))
}

fn shown(x: f64, text: &str) -> Element {
    element("data").with("value", format!("{x:?}")).text(text.replace('-', "−"))
}

/// Value, standard error, interval.
pub(crate) fn estimate(e: &Estimate, factor: f64) -> [Cell; 3] {
    [
        Cell::Number(e.value / factor),
        Cell::Number(e.std_error / factor),
        Cell::Interval(e.ci95.0 / factor, e.ci95.1 / factor),
    ]
}

/// A table of fitted parameters.
pub(crate) fn parameters(found: &[FoundParameter]) -> Option<Element> {
    let bounded = found.iter().any(|p| p.at_bound);
    let row = |p: &FoundParameter| {
        let name = match p.id.shown_record() {
            Some(record) => Cell::CodeOf(p.id.of.to_string(), record.to_owned()),
            None => code(p.id.to_string()),
        };
        let mut row = vec![name, in_unit(&p.unit)];
        row.extend(estimate(&p.estimate, p.factor));
        row.push(Cell::Interval(p.bounds.0 / p.factor, p.bounds.1 / p.factor));
        if bounded {
            row.push(text(if p.at_bound { "at its bound" } else { "" }));
        }
        row
    };
    let mut head = vec!["parameter", "unit", "value", "std. error", "95 % interval", "bounds"];
    head.extend(bounded.then_some("remark"));
    table("Parameters that were fitted", &head, found.iter().map(row).collect())
}

/// A unit in a cell; a dash for a plain number.
pub(crate) fn in_unit(text: &str) -> Cell {
    let unit = unit(text);
    Cell::Text(if unit.is_empty() { "–".to_owned() } else { unit })
}
