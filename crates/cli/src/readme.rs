//! `phisindy table`: the tables of README.md and the docs, made from the specs and the code, so that nobody copies numbers by hand.

mod language;
mod paper;
mod seeds;

use crate::args::{Options, TableArgs, TableKind};
use crate::command::print;
use crate::outdir::replace_file;
use crate::{draw, hidden, interrupt, wrong};
use anyhow::{Context, Result, bail};
use phisindy_phys::Sources;
use std::path::PathBuf;

/// A case of the paper and what it prints for it.
pub(crate) struct Printed {
    /// The name in the paper.
    case: &'static str,
    /// The spec's name.
    spec: &'static str,
    /// What the paper prints, and where.
    text: &'static str,
}

/// What the paper prints for each synthetic case (`L = ln((|y|+eps)/V)`, `M = ln(c+V/(|y|+eps))`).
const PRINTED: &[Printed] = &[
    Printed { case: "1a", spec: "case1a", text: "0.502, eq. (41)" },
    Printed { case: "1b", spec: "case1b", text: "0.493 + 0.049 L + 0.058 M, eq. (44)" },
    Printed { case: "2a", spec: "case2a", text: "0.500, eq. (45)" },
    Printed { case: "2b", spec: "case2b", text: "0.503 + 0.077 L + 0.099 M, eq. (46)" },
    Printed { case: "3 (Coulomb)", spec: "case3_coulomb", text: "0.502, eq. (47)" },
    Printed { case: "3 (DR)", spec: "case3_dr", text: "0.507 + 0.040 L + 0.056 M, eq. (48)" },
    Printed { case: "4", spec: "case4", text: "0.198, eq. (50)" },
    Printed { case: "5", spec: "case5", text: "0.5, eq. (66)" },
    Printed { case: "6", spec: "case6", text: "0.501; 0.3, eq. (74)" },
    Printed {
        case: "7",
        spec: "case7",
        text: "0.302; 0.294 + 0.22 x1 - 0.145 x2 - 0.131 y1 - 0.11 y2 - 0.034 M2, eq. (78): wrong terms",
    },
    Printed { case: "7, expert", spec: "case7_expert", text: "0.3; 0.286 + 0.062 L2 + 0.074 M2, eq. (80)" },
];

/// Makes a table, prints it, and puts it into a file if asked to.
pub(crate) fn command(args: &TableArgs, options: &Options) -> Result<u8> {
    if args.kind == TableKind::Hidden {
        return hidden::make(args, options);
    }
    let mut failures = String::new();
    let cases = chosen(args)?;
    let (name, made) = match args.kind {
        TableKind::Paper => ("paper", paper::table(&cases, options)?),
        TableKind::Sweep => ("sweep", seeds::table(&cases, args, options)?),
        TableKind::Score => {
            let scored = hidden::score(args, options)?;
            (
                "score",
                scored.map(|s| {
                    failures = s.failures;
                    s.tables
                }),
            )
        }
        TableKind::Wrong => {
            let scored = wrong::table(args, options)?;
            (
                "wrong",
                scored.map(|s| {
                    failures = s.failures;
                    s.table
                }),
            )
        }
        TableKind::Language => ("language", Some(language::table())),
        TableKind::Hidden => ("hidden", None),
    };
    let Some(table) = made else { return Ok(interrupt::code()) };
    print(&table)?;
    if !failures.is_empty() {
        print(&format!("\n{failures}"))?;
    }
    if let Some(path) = &args.write {
        let shown = path.display();
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read `{shown}`"))?;
        replace_file(path, &between_marks(&text, name, &table).with_context(|| format!("`{shown}`"))?)?;
    }
    Ok(0)
}

/// A case of the paper with its spec's path.
pub(crate) type Chosen = (&'static Printed, PathBuf);

fn chosen(args: &TableArgs) -> Result<Vec<Chosen>> {
    let named = |p: &Printed, name: &str| {
        p.case == name || p.spec == name || p.spec.strip_prefix("case") == Some(name)
    };
    for name in &args.cases {
        if !PRINTED.iter().any(|p| named(p, name)) {
            let all: Vec<&str> = PRINTED.iter().filter_map(|p| p.spec.strip_prefix("case")).collect();
            bail!("there is no case `{name}`; there is: {}", all.join(", "));
        }
    }
    let asked =
        PRINTED.iter().filter(|p| args.cases.is_empty() || args.cases.iter().any(|name| named(p, name)));
    Ok(asked.map(|p| (p, args.specs.join(format!("{}.ron", p.spec)))).collect())
}

/// The text with what stands between `<!-- table:NAME -->` and `<!-- end -->` replaced.
fn between_marks(text: &str, name: &str, table: &str) -> Result<String> {
    let begin = format!("<!-- table:{name} -->");
    let Some(head) = text.find(&begin).map(|at| at + begin.len()) else {
        bail!("the mark `{begin}` is missing");
    };
    let Some(length) = text[head..].find("<!-- end -->") else {
        bail!("`<!-- end -->` is missing after `{begin}`");
    };
    Ok(format!("{}\n{table}{}", &text[..head], &text[head + length..]))
}

/// A Markdown table.
pub(crate) fn markdown(head: &[&str], rows: &[Vec<String>]) -> String {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    // A bar would end the cell.
    let clean = |cell: &String| cell.replace('|', "\\|");
    let mut out = line(head.iter().map(|h| (*h).to_owned()).collect());
    out += &line(head.iter().map(|_| "---".to_owned()).collect());
    rows.iter().for_each(|row| out += &line(row.iter().map(clean).collect()));
    out
}

/// Draws what is wrong and ends.
fn fail<T>(found: &[phisindy_phys::Diagnostic], sources: &Sources, spec: &std::path::Path) -> Result<T> {
    draw::show(found.iter().filter(|d| d.is_error()), sources);
    bail!("the table needs `{}`", spec.display())
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
