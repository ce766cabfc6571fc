//! A plot in braille: each character is a block of two by four dots.

use super::look::{Ink, Look};
use crate::chart::digits;
use crate::stretch::Series;

/// Lines of the plot.
const HIGH: usize = 8;
/// Most characters of a line.
const WIDE: usize = 100;
/// Least width of a terminal for a plot.
const LEAST: usize = 90;
/// Room for the numbers at the left.
const LEFT: usize = 9;

/// A grid of dots, each character with the line that was drawn last there.
struct Grid {
    wide: usize,
    cells: Vec<(u8, Option<Ink>)>,
}

impl Grid {
    fn dot(&mut self, x: usize, y: usize, ink: Option<Ink>) {
        // The dots of a character in Unicode: 1 to 3 and 7 at the left, 4 to 6 and 8 at the right, from the
        // top.
        const BITS: [[u8; 2]; 4] = [[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]];
        if let Some(cell) = self.cells.get_mut((y / 4) * self.wide + x / 2).filter(|_| x / 2 < self.wide) {
            cell.0 |= BITS[y % 4][x % 2];
            cell.1 = ink.or(cell.1);
        }
    }
}

/// A plot of measured and simulated motion, where the terminal is wide enough; else nothing.
pub(crate) fn plot(series: Option<Series>, look: Look) -> Vec<String> {
    series.filter(|_| look.width >= LEAST).map_or(vec![], |series| lines(&series, look))
}

/// The lines of the plot.
fn lines(series: &Series, look: Look) -> Vec<String> {
    let wide = look.width.saturating_sub(LEFT + 3).min(WIDE);
    let all = series.measured.iter().map(|p| p.1).filter(|y| y.is_finite());
    let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), y| (a.min(y), b.max(y)));
    let (Some(first), Some(last)) = (series.measured.first(), series.measured.last()) else { return vec![] };
    if low >= high || first.0 >= last.0 {
        return vec![];
    }
    let room = 0.15 * (high - low);
    let (low, high) = (low - room, high + room);
    let mut grid = Grid { wide, cells: vec![(0, None); wide * HIGH] };
    let lines =
        [(&series.measured, None), (&series.before, Some(Ink::Before)), (&series.model, Some(Ink::Model))];
    for (points, ink) in lines {
        let place = |&(t, y): &(f64, f64)| {
            let x = (t - first.0) / (last.0 - first.0) * (2 * wide - 1) as f64;
            let y = (1.0 - (y - low) / (high - low)) * (4 * HIGH - 1) as f64;
            (x, y)
        };
        for pair in points.windows(2) {
            let (a, b) = (place(&pair[0]), place(&pair[1]));
            let steps = ((b.0 - a.0).abs().max((b.1 - a.1).abs()).ceil() as usize).clamp(1, 8 * HIGH);
            for k in 0..=steps {
                let part = k as f64 / steps as f64;
                let (x, y) = (a.0 + part * (b.0 - a.0), a.1 + part * (b.1 - a.1));
                if y >= 0.0 && y < (4 * HIGH) as f64 && x >= 0.0 {
                    grid.dot(x.round() as usize, y.round() as usize, ink);
                }
            }
        }
    }
    let mut out = vec![legend(series, look)];
    for row in 0..HIGH {
        let label = match row {
            0 => digits(high, 2),
            r if r + 1 == HIGH => digits(low, 2),
            _ => String::new(),
        };
        let cells = &grid.cells[row * wide..(row + 1) * wide];
        // Letters of one colour stand together.
        let runs = cells.chunk_by(|a, b| a.1 == b.1).map(|run| {
            let letters: String = run
                .iter()
                .map(|(bits, _)| char::from_u32(0x2800 + u32::from(*bits)).unwrap_or(' '))
                .collect();
            run[0].1.map_or(letters.clone(), |ink| look.ink(ink, &letters))
        });
        let line: String = runs.collect();
        out.push(format!("{label:>LEFT$} │{line}"));
    }
    let (from, to) = (digits(first.0, 3), format!("{} s", digits(last.0, 3)));
    let space = wide.saturating_sub(from.chars().count() + to.chars().count());
    out.push(format!("{:LEFT$}  {from}{}{to}", "", " ".repeat(space)));
    out
}

fn legend(series: &Series, look: Look) -> String {
    let mut words = vec![format!("{} of {}: measured", series.column, series.record)];
    if !series.before.is_empty() {
        words.push(look.ink(Ink::Before, "before"));
    }
    words.push(look.ink(Ink::Model, if series.before.is_empty() { "model" } else { "after" }));
    let unit = if series.unit.is_empty() { String::new() } else { format!(" ({})", series.unit) };
    format!("{}{unit}", words.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_rises_from_the_lower_left_to_the_upper_right() {
        let points: Vec<(f64, f64)> = (0..50).map(|k| (f64::from(k), f64::from(k))).collect();
        let series = Series {
            record: "r".into(),
            column: "x".into(),
            unit: "m".into(),
            measured: points.clone(),
            before: vec![],
            model: points,
        };
        let lines = lines(&series, Look { colour: false, width: 100 });
        assert_eq!(lines.len(), HIGH + 2);
        let filled = |line: &str| line.chars().position(|c| ('\u{2801}'..='\u{28ff}').contains(&c));
        assert!(filled(&lines[2]) > filled(&lines[HIGH - 1]), "{lines:#?}");
        assert!(lines.iter().all(|l| l.chars().count() <= 100) && lines[0].contains("x of r"));
    }
}
