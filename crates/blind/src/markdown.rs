//! Tables in Markdown, and their places in documents.

use anyhow::{Result, bail};

/// A table.
pub(crate) fn markdown(head: &[&str], rows: &[Vec<String>]) -> String {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    // A bar would end the cell.
    let clean = |cell: &String| cell.replace('|', "\\|");
    let mut out = line(head.iter().map(|h| (*h).to_owned()).collect());
    out += &line(head.iter().map(|_| "---".to_owned()).collect());
    rows.iter().for_each(|row| out += &line(row.iter().map(clean).collect()));
    out
}

/// The text with a new table between `<!-- table:NAME -->` and `<!-- end -->`.
///
/// # Errors
/// One of the marks is missing.
pub(crate) fn between_marks(text: &str, name: &str, table: &str) -> Result<String> {
    let begin = format!("<!-- table:{name} -->");
    let Some(head) = text.find(&begin).map(|at| at + begin.len()) else {
        bail!("the mark `{begin}` is missing");
    };
    let Some(length) = text[head..].find("<!-- end -->") else {
        bail!("`<!-- end -->` is missing after `{begin}`");
    };
    Ok(format!("{}\n{table}{}", &text[..head], &text[head + length..]))
}

/// A number with five digits.
pub(crate) fn short(x: f64) -> String {
    if !x.is_finite() {
        return if x.is_nan() { "unknown".to_owned() } else { "unbounded".to_owned() };
    }
    let scientific = format!("{x:.4e}");
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let trimmed = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    };
    match exponent {
        -4..=5 => trimmed(&format!("{x:.*}", (4 - exponent).max(0) as usize)),
        _ => format!("{}e{exponent}", trimmed(mantissa)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_goes_between_its_marks() {
        let text = "a\n<!-- table:paper -->\nold\n<!-- end -->\nb\n<!-- table:sweep -->\n<!-- end -->\n";
        let with = between_marks(text, "paper", "new\n").expect("marks");
        assert_eq!(with, text.replace("old", "new"));
        let with = between_marks(&with, "sweep", "x\n").expect("marks");
        assert!(with.ends_with("<!-- table:sweep -->\nx\n<!-- end -->\n"));
        assert!(between_marks(text, "none", "").is_err());
    }

    #[test]
    fn bars_do_not_end_cells() {
        assert_eq!(markdown(&["a"], &[vec!["|y|".into()]]), "| a |\n| --- |\n| \\|y\\| |\n");
    }
}
