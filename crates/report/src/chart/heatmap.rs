//! A square matrix of numbers between -1 and 1: cells shaded by size and sign, with the number in each cell.

use super::label::{at, shortened, width_of, word};
use super::picture::Chart;
use super::sheet::Sheet;
use crate::markup::element;

/// Opacity of a cell of size 1; its number stays readable.
const FULL: f64 = 0.6;

/// The matrix with names at the left and their numbers at the top.
pub(crate) fn heatmap(
    name: &str,
    title: &str,
    description: &str,
    names: &[String],
    values: &[Vec<f64>],
    sheet: Sheet,
) -> Chart {
    let n = names.len();
    let wide = names.iter().map(|name| width_of(name)).fold(40.0, f64::max) + 44.0;
    // On a phone numbers stand for the names, which the caption lists.
    let left = if sheet.is_phone() { 34.0 } else { wide.min(0.4 * sheet.width()) };
    let cell = ((sheet.width() - left - 10.0) / n as f64).min(62.0);
    let high = cell.clamp(16.0, 40.0);
    let size = (left + cell * n as f64 + 10.0, 34.0 + high * n as f64 + 8.0);
    let mut chart = Chart::new(name, title, description, size);
    for (i, row) in values.iter().enumerate() {
        let y = 34.0 + high * i as f64;
        chart.draw([
            word("end", left - 10.0, y + 0.5 * high + 4.5, &(i + 1).to_string()),
            word("middle", left + cell * (i as f64 + 0.5), 22.0, &(i + 1).to_string()),
        ]);
        if !sheet.is_phone() {
            let name = shortened(&names[i], left - 40.0);
            chart.draw([word("label end", left - 34.0, y + 0.5 * high + 4.5, &name)]);
        }
        for (j, &r) in row.iter().enumerate() {
            let x = left + cell * j as f64;
            let sign = if r < 0.0 { "minus" } else { "plus" };
            let strength = if r.is_finite() { FULL * r.abs().min(1.0) } else { 0.0 };
            chart.draw([element("rect")
                .class(format!("cell {sign}"))
                .with("x", at(x + 1.0))
                .with("y", at(y + 1.0))
                .with("width", at(cell - 2.0))
                .with("height", at(high - 2.0))
                .with("rx", 3)
                .with("fill-opacity", format!("{strength:.3}"))]);
            // Where cells are small only the shades are shown.
            if cell >= 33.0 {
                chart.draw([word("value small middle", x + 0.5 * cell, y + 0.5 * high + 4.5, &shown(r))]);
            }
        }
    }
    chart
}

fn shown(r: f64) -> String {
    if r.is_finite() { format!("{r:.2}").replace('-', "−") } else { "–".to_owned() }
}
