//! The operations of the expression language, from the table that defines them.

use crate::markdown::markdown;
use phisindy_expr::ops::{BINARY, UNARY, WHOLE, function_names};

/// A row for each operation: how it is written, what it is, where it or its slope jumps.
pub(crate) fn table() -> String {
    let offered = |name: &str| function_names().any(|n| n == name);
    let jumps = |kinks: &[f64]| match kinks == WHOLE {
        true => "each whole number".to_owned(),
        false => kinks.iter().map(f64::to_string).collect::<Vec<_>>().join(", "),
    };
    let infix = BINARY.iter().filter(|row| row.precedence > 0);
    let infix = infix.map(|row| [format!("a {} b", row.name), row.about.to_owned(), String::new()]);
    let one = UNARY.iter().map(|row| {
        let written = match row.name {
            "" => "-x".to_owned(),
            "abs" => "|x|, abs(x)".to_owned(),
            name => format!("{name}(x)"),
        };
        [written, row.about.to_owned(), jumps(row.kinks)]
    });
    let two = BINARY.iter().filter(|row| row.precedence == 0 && offered(row.name));
    let two = two.map(|row| [format!("{}(a, b)", row.name), row.about.to_owned(), String::new()]);
    let rows: Vec<Vec<String>> = infix
        .chain(one)
        .chain(two)
        .map(|[written, about, jumps]| vec![format!("`{written}`"), about, jumps])
        .collect();
    markdown(&["written", "what it is", "value or slope jumps at x ="], &rows)
}
