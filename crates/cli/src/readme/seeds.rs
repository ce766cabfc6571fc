//! Many seeds of each case at three kinds of noise, both methods.

use super::{Chosen, fail, markdown};
use crate::args::{Assignment, Options, TableArgs};
use crate::draw;
use crate::load::{spec_text, with_sets};
use crate::outdir::OutDir;
use crate::sweep::{Checked, Journal, Plan, Statistics, product, seed_of, sweep, vary};
use crate::table::short;
use anyhow::{Result, anyhow, bail};
use phisindy_phys::Sources;

/// The kinds of noise and what they are called.
const NOISE: &[(&str, &str)] = &[
    ("Relative(0.1)", "relative, 10 %"),
    ("Additive(0.02)", "additive, 2 %"),
    ("Additive(0.2)", "additive, 20 %"),
];

/// The table; none if the user stopped it.
pub(super) fn table(cases: &[Chosen], args: &TableArgs, options: &Options) -> Result<Option<String>> {
    if options.method.is_some() {
        bail!("`table sweep` compares both methods; leave --method out");
    }
    let mut rows = Vec::new();
    for (printed, spec) in cases {
        let mut sources = Sources::default();
        let text = spec_text(spec).and_then(|text| with_sets(text, &options.sets, &mut sources));
        let text = text.or_else(|mistake| fail(&[mistake], &sources, spec))?;
        let noises: Vec<String> = NOISE.iter().map(|(value, _)| (*value).to_owned()).collect();
        let set = |path: &str, value: &str| Assignment { path: path.to_owned(), value: value.to_owned() };
        let methods = vec![
            (String::new(), vec![set("learn.method", "Trajectory")]),
            (
                "method step".to_owned(),
                vec![set("learn.method", "Step"), set("learn.optimiser", "GaussNewton")],
            ),
        ];
        let axes = [vary("noise", &["data.0.noise".to_owned()], &noises), methods];
        let cells =
            product(&text, &axes, &mut sources).or_else(|mistake| fail(&[mistake], &sources, spec))?;
        let (mut checked, mut first) = (Vec::new(), options.seed);
        for cell in cells {
            let mut found = Vec::new();
            let Ok((cell, loaded)) = Checked::new(spec, cell, options, &mut sources, &mut found) else {
                return fail(&found, &sources, spec);
            };
            cell.truth.as_ref().map_err(|why| anyhow!("{}: {why}", loaded.spec))?;
            first = first.or(seed_of(&loaded.case));
            checked.push(cell);
        }
        let mut journal = match &options.out {
            Some(out) => {
                let folder = OutDir::create(&out.join(printed.spec))?;
                Journal::open(folder.path(), &spec.display().to_string(), &format!("table\n{text}"))?
            }
            None => Journal::default(),
        };
        let plan = Plan {
            spec: spec.clone(),
            options: options.clone(),
            cells: checked,
            first: first.unwrap_or(0),
            seeds: args.seeds,
        };
        let outcome = sweep(&plan, &mut journal, &spec.display().to_string())?;
        if outcome.stopped {
            draw::show(
                [&phisindy_phys::Diagnostic::error(
                    "stopped before the end; with --out DIR finished runs are kept",
                )],
                &sources,
            );
            return Ok(None);
        }
        let numbers: Vec<Statistics> = plan
            .cells
            .iter()
            .zip(&outcome.runs)
            .filter_map(|(cell, runs)| cell.truth.as_ref().ok().map(|named| Statistics::of(named, runs)))
            .collect();
        for ((_, noise), pair) in NOISE.iter().zip(numbers.chunks(2)) {
            if let [trajectory, step] = pair {
                rows.push(row(printed.case, noise, trajectory, step));
            }
        }
    }
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

fn row(case: &str, noise: &str, trajectory: &Statistics, step: &Statistics) -> Vec<String> {
    let dash = || "-".to_owned();
    let hundredths = |x: f64| format!("{:.0} %", 100.0 * x);
    vec![
        case.to_owned(),
        noise.to_owned(),
        format!("{} of {}", trajectory.exact, trajectory.runs),
        trajectory.worst_median().map_or_else(dash, |e| format!("{} %", short((1e4 * e).round() / 100.0))),
        trajectory.worst_ratio().map_or_else(dash, |r| format!("{r:.2}")),
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
