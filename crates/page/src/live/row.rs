//! A line of numbers, as boards and programs send it.

/// Whether a line holds numbers alone.
pub(super) fn is_row(line: &[u8]) -> bool {
    let number = |b: &u8| b.is_ascii_digit() || b" \t\r\n,;.+-eENnAaIiFf".contains(b);
    let line = line.trim_ascii();
    line.first().is_some_and(|b| b.is_ascii_digit() || b"+-.".contains(b)) && line.iter().all(number)
}

/// Number of its cells.
pub(super) fn cells(line: &[u8]) -> usize {
    let separator = [b';', b'\t', b','].into_iter().find(|s| line.contains(s));
    match separator {
        Some(separator) => line.iter().filter(|b| **b == separator).count() + 1,
        None => line.split(u8::is_ascii_whitespace).filter(|cell| !cell.is_empty()).count(),
    }
}

/// Its first number, mostly the time; NaN for none.
pub(super) fn first_number(line: &[u8]) -> f64 {
    let cell = line.trim_ascii().split(|b| b" \t,;".contains(b)).next().unwrap_or_default();
    std::str::from_utf8(cell).ok().and_then(|cell| cell.parse().ok()).unwrap_or(f64::NAN)
}
