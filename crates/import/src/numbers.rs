//! The numbers of a file as they stand there: a matrix, a row, the points of a function. Matrix Market (coordinate and
//! array; R. Boisvert, R. Pozo, K. Remington, The Matrix Market exchange formats, NISTIR 5935, 1996), text, and all formats
//! of tables.

use crate::cell::SEPARATOR;
use crate::data_file::{DataFile, unreadable};
use crate::headings::Heading;
use crate::refusal::Wanted;
use crate::rows::{LineError, Lines};
use phisindy_expr::Span;
use phisindy_phys::{Diagnostic, Numbers, SourceId};

/// Most numbers of a file: a matrix of 200 degrees of freedom has 40 000.
const MOST: usize = 1_000_000;
/// Most rows of a matrix in the coordinate format, whose zeros are not written.
const MOST_ROWS: usize = 1000;

/// Reads the numbers of a file, of its array of this name if it has several. `at` is where the user named it.
///
/// # Errors
/// The file cannot be read, has no such array, or something in it is no number.
///
/// ```
/// use phisindy_expr::Span;
/// use phisindy_import::{DataFile, numbers};
/// use phisindy_phys::SourceId;
/// let at = (SourceId(0), Span::new(0, 0));
/// let text = b"%%MatrixMarket matrix coordinate real symmetric\n2 2 2\n1 1 4.0\n2 1 -1.5\n";
/// let matrix = numbers(DataFile::of_bytes("K.mtx", text), None, at).unwrap();
/// assert_eq!(matrix.values, [4.0, -1.5, -1.5, 0.0]);
/// let spring = numbers(DataFile::of_bytes("spring.csv", b"x [mm],F [N]\n0,0\n2,31.5\n"), None, at).unwrap();
/// assert_eq!((spring.columns, spring.headings[0].1.as_deref()), (2, Some("mm")));
/// ```
pub fn numbers(
    mut file: DataFile<'_>,
    array: Option<&str>,
    at: (SourceId, Span),
) -> Result<Numbers, Box<Diagnostic>> {
    let name = file.name;
    let start = file.start().map_err(|e| unreadable(name, at, &e))?;
    if array.is_none() && start.starts_with(b"%%MatrixMarket") {
        let bytes = file.whole().map_err(|e| unreadable(name, at, &e))?.unwrap_or_default();
        let text = String::from_utf8_lossy(&bytes);
        return market(&text).map_err(|why| why.diagnostic(name, at));
    }
    let mut lines = Lines::of(file, 0, &Wanted::All { sheet: array }).map_err(|e| unread(name, at, &e))?;
    let sheet = lines.sheet().is_some();
    let mut all = Numbers::default();
    while let Some(line) = lines.next().map_err(|e| unread(name, at, &e))? {
        let cells = if sheet { split(&line.text, SEPARATOR) } else { cells(&line.text) };
        let row: Vec<Option<f64>> = cells.iter().map(|cell| number(cell)).collect();
        let first = all.values.is_empty();
        let wrong = |what: String| Wrong { line: line.number, what }.diagnostic(name, at);
        match row.iter().position(Option::is_none) {
            // Numbers stand for the names of columns without one.
            None if line.number == 0 => {}
            None if first || row.len() == all.columns => {
                all.columns = row.len();
                all.values.extend(row.into_iter().flatten());
            }
            None => {
                return Err(wrong(format!("{} numbers, and the first row has {}", row.len(), all.columns)));
            }
            Some(_) if first && all.headings.is_empty() => {
                let heading = |cell: &String| {
                    let heading = Heading::parse(cell);
                    (heading.raw, heading.unit)
                };
                all.headings = cells.iter().map(heading).collect();
            }
            Some(k) => return Err(wrong(format!("`{}` is no number", cells[k]))),
        }
        if all.values.len() > MOST {
            return Err(wrong(format!("more than {MOST} numbers")));
        }
    }
    match all.values.iter().find(|value| !value.is_finite()) {
        _ if all.values.is_empty() => Err(Wrong { line: 1, what: "no numbers".into() }.diagnostic(name, at)),
        Some(value) => Err(Wrong { line: 1, what: format!("a number that is {value}") }.diagnostic(name, at)),
        None => Ok(all),
    }
}

/// What is wrong in a line of a file.
struct Wrong {
    line: usize,
    what: String,
}

impl Wrong {
    fn diagnostic(&self, name: &str, (source, span): (SourceId, Span)) -> Box<Diagnostic> {
        let Wrong { line, what } = self;
        let d =
            Diagnostic::error(format!("`{name}`, line {line}: {what}")).at(source, span, "asked for here");
        Box::new(
            d.help("a matrix is one row of numbers on each line, or Matrix Market; a table has two columns"),
        )
    }
}

fn unread(name: &str, at: (SourceId, Span), error: &LineError) -> Box<Diagnostic> {
    Box::new(match error {
        LineError::Io(e) => unreadable(name, at, e),
        LineError::Format(refusal) => {
            let d = Diagnostic::error(refusal.message.clone()).at(at.0, at.1, "this file");
            refusal.help.iter().fold(d, |d, help| d.help(help.clone()))
        }
        LineError::NotText(_, line) | LineError::TooLong(line) => {
            *Wrong { line: *line, what: "no text, nor a format that is known".into() }.diagnostic(name, at)
        }
        LineError::Changed => {
            *Wrong { line: 1, what: "the file changed while it was read".into() }.diagnostic(name, at)
        }
    })
}

/// The cells of a line of text: between semicolons, tabs, commas or blanks.
fn cells(line: &str) -> Vec<String> {
    match [';', '\t', ','].into_iter().find(|mark| line.contains(*mark)) {
        Some(mark) => split(line, mark),
        None => line.split_whitespace().map(str::to_owned).collect(),
    }
}

fn split(line: &str, mark: char) -> Vec<String> {
    line.trim_end_matches(mark).split(mark).map(|cell| cell.trim().trim_matches('"').to_owned()).collect()
}

/// A number, with a decimal comma too where that separates no cells.
fn number(cell: &str) -> Option<f64> {
    cell.parse().ok().or_else(|| cell.replacen(',', ".", 1).parse().ok())
}

/// A matrix in one of the formats of Matrix Market.
fn market(text: &str) -> Result<Numbers, Wrong> {
    let wrong = |line: usize, what: &str| Wrong { line, what: what.to_owned() };
    let mut lines = text.lines().enumerate().map(|(k, line)| (k + 1, line.trim()));
    let head = lines.next().map_or("", |(_, line)| line).to_lowercase();
    let words: Vec<&str> = head.split_whitespace().collect();
    let [_, "matrix", form, field, symmetry] = words[..] else {
        return Err(wrong(1, "the head is `%%MatrixMarket matrix coordinate real symmetric`, or the like"));
    };
    if !["real", "integer", "double"].contains(&field) {
        return Err(wrong(1, "only real matrices are read"));
    }
    if !["general", "symmetric"].contains(&symmetry) {
        return Err(wrong(1, "only general and symmetric matrices are read"));
    }
    let mut rows = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('%'));
    let sizes = rows.next().map(|(line, text)| {
        (line, text.split_whitespace().map(str::parse).collect::<Result<Vec<usize>, _>>())
    });
    let (coordinate, symmetric) = (form == "coordinate", symmetry == "symmetric");
    let (r, c, entries) = match sizes {
        Some((_, Ok(sizes))) if coordinate && sizes.len() == 3 => (sizes[0], sizes[1], sizes[2]),
        Some((_, Ok(sizes))) if form == "array" && sizes.len() == 2 => (sizes[0], sizes[1], 0),
        Some((line, _)) => {
            return Err(wrong(line, "this line holds the numbers of rows, columns and entries"));
        }
        None => return Err(wrong(1, "nothing follows the head")),
    };
    if r == 0 || c == 0 || r > MOST_ROWS || c > MOST_ROWS || (symmetric && r != c) {
        return Err(wrong(2, &format!("a matrix of {r} x {c} entries is not read")));
    }
    let mut values = vec![0.0; r * c];
    let mut count = 0;
    // Arrays go down the columns, of a symmetric matrix from the diagonal on.
    let (mut i, mut j) = (0, 0);
    for (line, text) in rows {
        let words: Vec<&str> = text.split_whitespace().collect();
        let (row, column, value) = match (coordinate, &words[..]) {
            (true, &[row, column, value]) => {
                let place = |word: &str, most: usize| {
                    word.parse().ok().filter(|k| (1..=most).contains(k)).map(|k: usize| k - 1)
                };
                match (place(row, r), place(column, c)) {
                    (Some(row), Some(column)) => (row, column, value),
                    _ => {
                        return Err(wrong(
                            line,
                            &format!("there is no entry ({row}, {column}) in {r} x {c}"),
                        ));
                    }
                }
            }
            (false, &[value]) if j < c => {
                let place = (i, j, value);
                i += 1;
                if i == r {
                    j += 1;
                    i = if symmetric { j } else { 0 };
                }
                place
            }
            _ => return Err(wrong(line, "this line does not fit its head")),
        };
        let value: f64 = match value.parse::<f64>() {
            Ok(value) if value.is_finite() => value,
            _ => return Err(wrong(line, &format!("`{value}` is no number"))),
        };
        // Finite elements write an entry in parts.
        values[row * c + column] += value;
        if symmetric && row != column {
            values[column * c + row] += value;
        }
        count += 1;
    }
    let due = if coordinate {
        entries
    } else if symmetric {
        r * (r + 1) / 2
    } else {
        r * c
    };
    match count == due {
        true => Ok(Numbers { columns: c, values, headings: vec![] }),
        false => Err(wrong(text.lines().count(), &format!("{count} entries, and the head says {due}"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Numbers, String> {
        let at = (SourceId(0), Span::new(0, 0));
        numbers(DataFile::of_bytes("a.mtx", text.as_bytes()), None, at).map_err(|d| d.message)
    }

    #[test]
    fn all_forms_of_one_matrix_are_the_same() {
        let due = [4.0, -1.0, 0.0, -1.0, 3.0, 0.5, 0.0, 0.5, 2.0];
        for text in [
            "%%MatrixMarket matrix coordinate real general\n% a remark\n3 3 7\n1 1 4\n1 2 -1\n2 1 -1\n2 2 3\n2 3 .5\n3 2 .5\n3 3 2\n",
            "%%MatrixMarket matrix coordinate real symmetric\n3 3 6\n1 1 4\n2 1 -1\n2 2 1\n2 2 2\n3 2 0.5\n3 3 2\n",
            "%%MatrixMarket matrix array real general\n3 3\n4\n-1\n0\n-1\n3\n0.5\n0\n0.5\n2\n",
            "%%MatrixMarket matrix array real symmetric\n3 3\n4\n-1\n0\n3\n0.5\n2\n",
            "4, -1, 0\n-1, 3, 0.5\n0, 0.5, 2\n",
            "4;-1;0\n-1;3;0,5\n0;0,5;2\n",
            "# exported\n4 -1 0\n-1 3 0.5\n0 0.5 2\n",
        ] {
            assert_eq!(read(text).map(|found| found.values).as_deref(), Ok(&due[..]), "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        for (text, due) in [
            ("%%MatrixMarket matrix coordinate complex general\n", "line 1: only real"),
            (
                "%%MatrixMarket matrix coordinate real general\n2 2 1\n3 1 4\n",
                "line 3: there is no entry (3, 1)",
            ),
            (
                "%%MatrixMarket matrix coordinate real general\n2 2 2\n1 1 4\n",
                "1 entries, and the head says 2",
            ),
            ("%%MatrixMarket matrix array real general\n2 2\n1\n2\nx\n4\n", "line 5: `x` is no number"),
            ("1 2\n3 4 5\n", "line 2: 3 numbers"),
            ("x,y\n1,2\n3,a\n", "line 3: `a` is no number"),
            ("x,y\n", "no numbers"),
        ] {
            let found = read(text).expect_err(text);
            assert!(found.contains(due), "{text}: {found}");
        }
    }
}
