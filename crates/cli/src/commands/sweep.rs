//! `phisindy sweep`.

use super::spec_file::exit_code;
use crate::args::{Format, Options, SweepArgs};
use crate::outdir::OutDir;
use crate::sweep::{Axis, Cell, Checked, Journal, Plan, listed, product, seed_of, vary};
use crate::terminal::{INPUT, REJECTED, complain, print, remark};
use crate::{draw, interrupt};
use anyhow::{Result, anyhow, bail};
use phisindy::Loaded;
use phisindy::files::{spec_text, with_assignments};
use phisindy_phys::spec::Method;
use phisindy_phys::{Case, Origin, Sources};
use phisindy_report::sweep::{CellRuns, RunVerdict, SweepRuns, json, table};

/// Sweeps, prints, and says with which exit code to end.
pub(crate) fn sweep(args: &SweepArgs, options: &Options) -> Result<u8> {
    let folder = options.out.as_deref().map(OutDir::create).transpose()?;
    let mut sources = Sources::default();
    let text =
        match spec_text(&args.spec).and_then(|text| with_assignments(text, &options.sets, &mut sources)) {
            Ok(text) => text,
            Err(mistake) => {
                draw::show([&mistake], &sources);
                return Ok(INPUT);
            }
        };
    let plain = Cell { label: String::new(), text: text.clone() };
    let base = match checked(args, plain, options, &mut sources, true) {
        Ok((_, loaded)) => loaded,
        Err(code) => return Ok(code),
    };
    let case = &base.case;
    let Some(first) = options.seed.or(seed_of(case)) else {
        bail!("{}: no record of this case is `Synthetic`, so there is no truth to compare with", base.spec);
    };
    if first.checked_add(args.seeds - 1).is_none() {
        bail!(
            "{} seeds from {first} on would go beyond the largest seed, {}: start at a smaller --seed",
            args.seeds,
            u64::MAX
        );
    }
    if case.system.terms.is_empty() {
        bail!("{}: `unknown` is empty, so there is nothing to find", base.spec);
    }
    let method_used = options.method.map(Method::from).or(case.learn.method).unwrap_or(Method::Trajectory);
    let cells = match product(&text, &axes(args, case, method_used)?, &mut sources) {
        Ok(cells) => cells,
        Err(mistake) => {
            draw::show([&mistake], &sources);
            return Ok(INPUT);
        }
    };
    let mut all = Vec::new();
    for cell in cells {
        match checked(args, cell, options, &mut sources, false) {
            Ok((checked, _)) => all.push(checked),
            Err(code) => return Ok(code),
        }
    }
    let mut journal = match &folder {
        Some(folder) => Journal::open(folder.path(), &base.spec, &format!("{method_used:?}\n{text}"))?,
        None => Journal::default(),
    };
    let plan =
        Plan { spec: args.spec.clone(), options: options.clone(), cells: all, first, seeds: args.seeds };
    let before = journal.len();
    let outcome = crate::sweep::sweep(&plan, &mut journal, &base.spec)?;
    let cells = plan.cells.iter().zip(&outcome.runs);
    let cells = cells.map(|(c, runs)| CellRuns { label: &c.cell.label, truth: &c.truth, runs });
    let result = SweepRuns {
        spec: &base.spec,
        title: &case.system.title,
        method: method_used,
        first,
        seeds: args.seeds,
        cells: cells.collect(),
        stopped: outcome.stopped,
        seconds: outcome.seconds,
    };
    let object = json(&result) + "\n";
    match options.format {
        Format::Json => print(&object)?,
        form => {
            let comment = |line: &String| match form {
                Format::Latex if line.is_empty() => "%\n".to_owned(),
                Format::Latex => format!("% {line}\n"),
                _ => format!("{line}\n"),
            };
            print(&table(&result).iter().map(comment).collect::<String>())?;
        }
    }
    let new = journal.len() - before;
    if outcome.stopped {
        complain_of_stop(&journal, folder.as_ref());
        interrupt::tell();
        return Ok(interrupt::code());
    }
    if let Some(folder) = &folder {
        folder.write("sweep.json", &object)?;
    }
    if !options.quiet && options.format != Format::Json {
        remark(&format!("{new} runs in {:.1} s", outcome.seconds));
    }
    let mut worst = 0;
    for (checked, runs) in plan.cells.iter().zip(&outcome.runs) {
        let cell =
            if checked.cell.label.is_empty() { base.spec.as_str() } else { checked.cell.label.as_str() };
        if let Err(why) = &checked.truth {
            complain(&format!("{cell}: {why}: no seed can be right"));
            worst = REJECTED;
        } else if runs.iter().all(|r| matches!(r.verdict, RunVerdict::Failed(_))) {
            complain(&format!(
                "{cell}: no run came to a result: {}",
                runs.first().map_or(String::new(), |r| r.verdict.to_string())
            ));
            worst = REJECTED;
        }
    }
    Ok(worst)
}

fn complain_of_stop(journal: &Journal, folder: Option<&OutDir>) {
    let kept = match folder {
        Some(folder) => format!(
            "{} finished runs are kept in `{}`; the same command goes on from there",
            journal.len(),
            folder.path().display()
        ),
        None => "the table holds the finished runs only; with --out DIR they are kept, and the same command goes on from there".into(),
    };
    complain(&format!("stopped before the end: {kept}"));
}

/// A cell that makes sense; otherwise what is wrong was drawn, and this is the exit code. Warnings are drawn if `aloud`.
fn checked(
    args: &SweepArgs,
    cell: Cell,
    options: &Options,
    sources: &mut Sources,
    aloud: bool,
) -> Result<(Checked, Loaded), u8> {
    let mut found = Vec::new();
    let options = Options { seed: None, ..options.clone() };
    let checked = Checked::new(&args.spec, cell, &options, sources, &mut found);
    let drawn = found.iter().filter(|d| d.is_error() || (checked.is_ok() && aloud && !options.quiet));
    draw::show(drawn, sources);
    checked.map_err(exit_code)
}

/// What varies, in the order of the options.
fn axes(args: &SweepArgs, case: &Case, method: Method) -> Result<Vec<Axis>> {
    let mut axes = Vec::new();
    let mut add = |option: &str, name: &str, paths: &[String], list: &str, separator: char| {
        let values = listed(list, separator);
        axes.push(vary(name, paths, &values));
        if values.is_empty() { Err(anyhow!("{option} lists nothing")) } else { Ok(()) }
    };
    if let Some(list) = &args.noise {
        let synthetic =
            case.records.iter().enumerate().filter(|(_, r)| matches!(r.origin, Origin::Synthetic(_)));
        let paths: Vec<String> = synthetic.map(|(k, _)| format!("data.{k}.noise")).collect();
        add("--noise", "noise", &paths, list, ',')?;
    }
    if let Some(list) = &args.cutoffs {
        let mut paths = vec!["learn.cutoff".to_owned()];
        let mut list = list.clone();
        if method == Method::Trajectory {
            paths = vec!["learn.selection".to_owned()];
            list = listed(&list, ',').iter().map(|x| format!("Cutoff({x})")).collect::<Vec<_>>().join(",");
        }
        add("--cutoffs", "cutoff", &paths, &list, ',')?;
    }
    for set in &args.vary {
        add("--vary", &set.path, std::slice::from_ref(&set.path), &set.value, ';')?;
    }
    Ok(axes)
}
