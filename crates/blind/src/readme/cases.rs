//! The cases of the paper, and how the program is called for them.

use crate::args::{Assignment, CaseArgs, Options};
use anyhow::{Result, bail};
use std::path::PathBuf;

/// A case of the paper and its printed result.
pub(super) struct Printed {
    /// The name in the paper.
    pub(super) case: &'static str,
    /// The spec's name.
    pub(super) spec: &'static str,
    /// The printed result and its equation.
    pub(super) text: &'static str,
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

/// A case of the paper with its spec's path.
pub(super) type Chosen = (&'static Printed, PathBuf);

pub(super) fn chosen(args: &CaseArgs) -> Result<Vec<Chosen>> {
    let named = |p: &Printed, name: &str| {
        p.case == name || p.spec == name || p.spec.strip_prefix("case") == Some(name)
    };
    for name in &args.cases {
        if !PRINTED.iter().any(|p| named(p, name)) {
            let all: Vec<&str> = PRINTED.iter().filter_map(|p| p.spec.strip_prefix("case")).collect();
            bail!("there is no case `{name}`; there is: {}", all.join(", "));
        }
    }
    let requested =
        PRINTED.iter().filter(|p| args.cases.is_empty() || args.cases.iter().any(|name| named(p, name)));
    Ok(requested.map(|p| (p, args.specs.join(format!("{}.ron", p.spec)))).collect())
}

/// Arguments that every subcommand of the program takes.
pub(super) fn common(sets: &[Assignment], seed: Option<u64>, options: &Options) -> Vec<String> {
    let mut all = Vec::new();
    for set in sets {
        all.extend(["--set".to_owned(), format!("{}={}", set.path, set.value)]);
    }
    all.extend(seed.iter().flat_map(|seed| ["--seed".to_owned(), seed.to_string()]));
    all.extend(options.jobs.iter().flat_map(|jobs| ["--jobs".to_owned(), jobs.to_string()]));
    all
}
