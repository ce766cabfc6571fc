//! Many seeds of each case at three kinds of noise, both methods.

use super::cases::{Chosen, common};
use crate::args::{Assignment, Options, SweepArgs};
use crate::markdown::{markdown, short};
use crate::program::Program;
use crate::progress::Progress;
use anyhow::{Context, Result, bail};
use serde_json::Value;
use std::path::Path;

/// The kinds of noise and their names.
const NOISE: &[(&str, &str)] = &[
    ("Relative(0.1)", "relative, 10 %"),
    ("Additive(0.02)", "additive, 2 %"),
    ("Additive(0.2)", "additive, 20 %"),
];

/// The table; none if the user stopped it.
pub(super) fn table(
    cases: &[Chosen],
    args: &SweepArgs,
    program: &Program,
    options: &Options,
) -> Result<Option<String>> {
    let mut rows = Vec::new();
    let progress = Progress::new("sweep", 2 * cases.len(), options.quiet);
    for (printed, spec) in cases {
        let sweep = |name: &str, sets: &[(&str, &str)]| {
            let out = args.out.as_ref().map(|out| out.join(printed.spec).join(name));
            let cells = swept(program, spec, args, sets, out.as_deref(), options)?;
            progress.step();
            Ok::<_, anyhow::Error>(cells)
        };
        let trajectory = sweep("trajectory", &[("learn.method", "Trajectory")])?;
        let step = sweep("step", &[("learn.method", "Step"), ("learn.optimiser", "GaussNewton")])?;
        let (Some(trajectory), Some(step)) = (trajectory, step) else { return Ok(None) };
        for (((_, noise), trajectory), step) in NOISE.iter().zip(&trajectory).zip(&step) {
            rows.push(row(printed.case, noise, trajectory, step));
        }
    }
    drop(progress);
    let mut out = format!(
        "Of {} seeds each. Errors are relative to the true coefficient, the worst of all coefficients is shown; the bound is that of Cramer and Rao; coverage is \
         the part of 95 % intervals that hold the truth, from the worst to the best coefficient. Method step has the paper's loss and cut-off, minimised by \
         Gauss-Newton to be quick.\n\n",
        args.seeds
    );
    out += &markdown(
        &[
            "case",
            "noise",
            "exactly the true terms",
            "worst median error",
            "worst rmse / bound",
            "coverage of 95 % intervals",
            "method step: exactly the true terms",
        ],
        &rows,
    );
    Ok(Some(out))
}

/// The result of `phisindy sweep` for a spec with each kind of noise; none if it was stopped.
fn swept(
    program: &Program,
    spec: &Path,
    args: &SweepArgs,
    sets: &[(&str, &str)],
    out: Option<&Path>,
    options: &Options,
) -> Result<Option<Vec<Statistics>>> {
    let noises: Vec<&str> = NOISE.iter().map(|(value, _)| *value).collect();
    let new = sets.iter().map(|(path, value)| Assignment::new(path, value));
    let sets: Vec<Assignment> = args.cases.sets.iter().cloned().chain(new).collect();
    let mut command = program.command();
    command.arg("sweep").arg(spec).args(["--format", "json", "--quiet", "--seeds", &args.seeds.to_string()]);
    command.arg("--vary").arg(format!("data.0.noise={}", noises.join(";")));
    command.args(common(&sets, args.cases.seed, options));
    if let Some(out) = out {
        command.arg("--out").arg(out);
    }
    let Some(output) = program.output(&mut command, None)? else { return Ok(None) };
    let Ok(result) = serde_json::from_str::<Value>(&output.out) else {
        bail!("{}\nthe table needs `{}`", output.err.trim_end(), spec.display());
    };
    if result["stopped"] == true {
        bail!("{}", output.err.trim_end());
    }
    let cells =
        result["cells"].as_array().with_context(|| format!("{}: the sweep has no cells", spec.display()))?;
    cells
        .iter()
        .map(|cell| Statistics::of(cell).with_context(|| spec.display().to_string()))
        .collect::<Result<_>>()
        .map(Some)
}

/// Statistics of the runs of one cell.
struct Statistics {
    /// Finished runs.
    runs: u64,
    /// Runs with exactly the terms of the truth.
    exact: u64,
    /// For each term of the truth: the relative error of the median, rmse over bound, and coverage.
    coefficients: Vec<[Option<f64>; 3]>,
}

impl Statistics {
    fn of(cell: &Value) -> Result<Statistics> {
        if let Some(why) = cell["error"].as_str() {
            bail!("{why}");
        }
        let coefficient = |c: &Value| {
            let number = |key: &str| c[key].as_f64();
            let error = |median: f64| number("truth").map(|truth| (median - truth).abs() / truth.abs());
            let ratio = number("rmse").zip(number("bound")).map(|(rmse, bound)| rmse / bound);
            [number("median").and_then(error), ratio, number("coverage95")]
        };
        let coefficients = cell["coefficients"].as_object().context("a cell without coefficients")?;
        Ok(Statistics {
            runs: cell["runs"].as_u64().context("a cell without runs")?,
            exact: cell["exact_support"].as_u64().context("a cell without exact support")?,
            coefficients: coefficients.values().map(coefficient).collect(),
        })
    }

    /// The largest of one of the numbers, if all coefficients have it.
    fn largest(&self, which: usize) -> Option<f64> {
        let all: Option<Vec<f64>> = self.coefficients.iter().map(|c| c[which]).collect();
        all?.into_iter().reduce(f64::max)
    }

    /// Least and largest coverage.
    fn coverage(&self) -> Option<(f64, f64)> {
        let all: Option<Vec<f64>> = self.coefficients.iter().map(|c| c[2]).collect();
        Some((all?.into_iter().reduce(f64::min)?, self.largest(2)?))
    }
}

fn row(case: &str, noise: &str, trajectory: &Statistics, step: &Statistics) -> Vec<String> {
    let dash = || "-".to_owned();
    let hundredths = |x: f64| format!("{:.0} %", 100.0 * x);
    vec![
        case.to_owned(),
        noise.to_owned(),
        format!("{} of {}", trajectory.exact, trajectory.runs),
        trajectory.largest(0).map_or_else(dash, |e| format!("{} %", short((1e4 * e).round() / 100.0))),
        trajectory.largest(1).map_or_else(dash, |r| format!("{r:.2}")),
        trajectory.coverage().map_or_else(dash, |(least, most)| {
            if least == most {
                hundredths(least)
            } else {
                format!("{} to {}", hundredths(least), hundredths(most))
            }
        }),
        format!("{} of {}", step.exact, step.runs),
    ]
}
