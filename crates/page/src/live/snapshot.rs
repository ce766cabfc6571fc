//! What is judged of a file that grows: its heading, and the rows of its newest stretch that are whole.

use super::row::{cells, first_number, is_row};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

/// Most rows that are judged: a judgement of so many takes about a second.
const ROWS: usize = 60_000;
/// Most bytes that they are looked for in.
const BYTES: u64 = 8 << 20;
/// Where the heading is looked for.
const HEAD: u64 = 1 << 16;

/// Heading and rows, and how many lines beside them are neither. A heading that comes again, or a time that goes back,
/// begins a new stretch: a board was started anew.
///
/// # Errors
/// The file cannot be read.
pub(super) fn of(path: &Path) -> io::Result<(Vec<u8>, usize)> {
    let mut file = File::open(path)?;
    let (mut head, mut tail) = (Vec::new(), Vec::new());
    (&mut file).take(HEAD).read_to_end(&mut head)?;
    let length = file.metadata()?.len();
    let from = length.saturating_sub(BYTES);
    file.seek(SeekFrom::Start(from))?;
    file.take(length - from).read_to_end(&mut tail)?;
    let heading: Vec<&[u8]> = whole(&head).take_while(|line| !is_row(line)).collect();
    // The first line behind a jump is cut.
    let lines = whole(&tail).skip(if from > 0 { 1 } else { heading.len() });
    let (mut rows, mut left_out): (Vec<&[u8]>, usize) = (vec![], 0);
    for line in lines {
        if is_row(line) && rows.first().is_none_or(|first| cells(first) == cells(line)) {
            rows.push(line);
        } else if heading.contains(&line) && !line.trim_ascii().is_empty() {
            rows.clear();
        } else if !line.trim_ascii().is_empty() && !line.starts_with(b"#") {
            left_out += 1;
        }
    }
    let times: Vec<f64> = rows.iter().map(|row| first_number(row)).collect();
    let back: Vec<usize> = (1..times.len()).filter(|&i| times[i] < times[i - 1]).collect();
    // A first column that goes back at every turn is no time.
    let begins = back.last().filter(|_| back.len() * 100 <= rows.len()).copied().unwrap_or(0);
    let begins = begins.max(rows.len().saturating_sub(ROWS));
    let text = heading.into_iter().chain(rows[begins..].iter().copied()).flatten().copied();
    Ok((text.collect(), left_out))
}

/// The lines that have an end.
fn whole(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    bytes.split_inclusive(|b| *b == b'\n').filter(|line| line.ends_with(b"\n"))
}

#[cfg(test)]
mod tests {
    #[test]
    fn what_is_no_row_is_left_out_and_a_new_start_begins_anew() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let mut rows: String = (0..300).map(|i| format!("{}.5,1.0\n", i)).collect();
        rows.insert_str(9, "ERR sensor\n1,2,3\n\0\n");
        let of = |text: &str| {
            std::fs::write(file.path(), text).unwrap();
            let (bytes, left_out) = super::of(file.path()).unwrap();
            (String::from_utf8(bytes).unwrap(), left_out)
        };
        let (text, left_out) = of(&format!("# board\nt_s,x_m\n{rows}5."));
        assert!(text.starts_with("# board\nt_s,x_m\n0.5,1.0\n") && text.ends_with("299.5,1.0\n"), "{text}");
        assert_eq!((text.lines().count(), left_out), (302, 3));
        // The board begins anew, with its heading or without.
        for again in ["t_s,x_m\n", ""] {
            let (text, _) = of(&format!("t_s,x_m\n{rows}{again}0.1,2.0\n0.2,2.0\n"));
            assert_eq!(text, "t_s,x_m\n0.1,2.0\n0.2,2.0\n");
        }
    }
}
