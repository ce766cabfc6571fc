//! `phisindy sweep`.

use super::spec_file::exit_code;
use crate::args::{Format, Options, SweepArgs};
use crate::outdir::OutDir;
use crate::sweep::shard::Shard;
use crate::sweep::{
    Axis, Cell, Checked, Journal, Merged, NAME, Plan, listed, merged, product, seed_of, vary,
};
use crate::terminal::{INPUT, REJECTED, complain, print, remark};
use crate::{draw, interrupt};
use anyhow::{Context, Result, anyhow, bail};
use phisindy::Loaded;
use phisindy::files::{law_files, named_files, spec_text, with_assignments};
use phisindy_phys::spec::Method;
use phisindy_phys::{Case, Diagnostic, Origin, Sources};
use phisindy_report::sweep::{CellRuns, RunVerdict, SweepRuns};
use std::path::Path;
use std::sync::Arc;

/// The name of the table in the folder of `--out`.
const TABLE: &str = "sweep.json";

/// Sweeps or merges, prints and keeps the result, and returns the exit code.
pub(crate) fn sweep(args: &SweepArgs, options: &Options) -> Result<u8> {
    match &args.spec {
        Some(spec) => swept(spec, args, options),
        None => merge(args, options),
    }
}

/// The folder of `--out`, which may hold journals and a table.
fn folder(options: &Options) -> Result<Option<OutDir>> {
    let ours = |name: &str| {
        name == TABLE || name.starts_with("sweep") && name.ends_with(".jsonl") || name.ends_with(".part")
    };
    options.out.as_deref().map(|out| OutDir::create(out)?.only(ours, options.force)).transpose()
}

fn swept(spec: &Path, args: &SweepArgs, options: &Options) -> Result<u8> {
    if args.shard.is_some() && options.out.is_none() {
        bail!("a shard is merged with others from its journal: say where that is kept, --out DIR");
    }
    let folder = folder(options)?;
    let Prepared { base, text, method, plan } = match prepared(spec, args, options)? {
        Ok(prepared) => prepared,
        Err(code) => return Ok(code),
    };
    let title = &base.case.system.title;
    let name = plan.shard.map_or(NAME.to_owned(), Shard::journal);
    let mut journal = match &folder {
        Some(folder) => Journal::open(
            folder.path(),
            &name,
            &base.spec,
            &dependencies(spec, &text, method, options)?,
            &plan.design(title, method),
        )?,
        None => Journal::default(),
    };
    let before = journal.len();
    let outcome = crate::sweep::sweep(&plan, &mut journal, &base.spec)?;
    let cells = plan.cells.iter().zip(&outcome.runs);
    let cells = cells.map(|(c, runs)| CellRuns { label: &c.cell.label, truth: &c.truth, runs });
    let result = SweepRuns {
        spec: &base.spec,
        title,
        method,
        first: plan.first,
        seeds: plan.seeds,
        cells: cells.collect(),
        stopped: outcome.stopped,
        seconds: outcome.seconds,
    };
    print(&result.written(options.format.into()))?;
    if outcome.stopped {
        complain_of_stop(&journal, folder.as_ref());
        interrupt::tell();
        return Ok(interrupt::code());
    }
    // The table of all shards is that of --merge.
    if let (Some(folder), None) = (&folder, plan.shard) {
        folder.write(TABLE, result.written(Format::Json.into()))?;
    }
    if !options.quiet && options.format != Format::Json {
        let part = plan.shard.map_or(String::new(), |shard| format!(" of shard {shard}"));
        remark(&format!("{} runs{part} in {:.1} s", journal.len() - before, outcome.seconds));
    }
    Ok(complain_of_cells(&result))
}

/// All that the runs depend on, except for cell and seed: the method, the text, and what is in the files that it
/// names.
fn dependencies(spec: &Path, text: &str, method: Method, options: &Options) -> Result<Vec<u8>> {
    let mut all = format!("{method:?}\n{text}").into_bytes();
    let request = options.request();
    let data = named_files(text, spec, &request).into_iter().map(|(_, path)| path);
    for file in data.chain(law_files(spec, &request)) {
        let content = std::fs::read(&file).with_context(|| format!("cannot read `{}`", file.display()))?;
        all.extend(format!("\n{} ", content.len()).into_bytes());
        all.extend(content);
    }
    Ok(all)
}

/// Prints the table of the sweep whose journals lie in some folders; with --out it is kept, too.
fn merge(args: &SweepArgs, options: &Options) -> Result<u8> {
    let folder = folder(options)?;
    let merged: Merged = merged(&args.merge)?;
    let cells = merged.design.cells();
    let result = merged.table(&cells);
    print(&result.written(options.format.into()))?;
    // A part replaces no whole.
    if let Some(folder) = folder.filter(|folder| !result.stopped || !is_complete(&folder.path().join(TABLE)))
    {
        folder.write(TABLE, result.written(Format::Json.into()))?;
    }
    if merged.missing > 0 {
        complain(&format!(
            "{} runs are in no journal: a shard is missing, or was stopped before its end: give its folder, or start its command again",
            merged.missing
        ));
        return Ok(REJECTED);
    }
    Ok(complain_of_cells(&result))
}

/// Whether a file is the table of a sweep that came to its end.
fn is_complete(table: &Path) -> bool {
    let text = std::fs::read_to_string(table).unwrap_or_default();
    serde_json::from_str::<serde_json::Value>(&text).is_ok_and(|table| table["stopped"] == false)
}

/// A checked sweep.
struct Prepared {
    /// The spec itself.
    base: Loaded,
    /// Its text with every `--set` in it.
    text: String,
    method: Method,
    plan: Arc<Plan>,
}

/// Most cells of a sweep: each is made and checked before the first run, and is a row of the table.
const MOST_CELLS: u64 = 100_000;
/// Most runs of a sweep, of all shards.
const MOST_RUNS: u64 = 1_000_000;

/// `1 seed`, `2 seeds`.
fn counted(n: u64, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

/// Checks everything before the first run. If something is wrong, it shows the mistakes; the inner error is
/// the exit code.
fn prepared(spec: &Path, args: &SweepArgs, options: &Options) -> Result<Result<Prepared, u8>> {
    let mut sources = Sources::default();
    let drawn = |mistake: &Diagnostic, sources: &Sources| {
        draw::show([mistake], sources);
        Ok(Err(INPUT))
    };
    let text = spec_text(spec).and_then(|text| with_assignments(text, &options.sets, &mut sources));
    let text = match text {
        Ok(text) => text,
        Err(mistake) => return drawn(&mistake, &sources),
    };
    let plain = Cell { label: String::new(), text: text.clone() };
    let base = match checked(spec, plain, options, &mut sources, true) {
        Ok((_, loaded)) => loaded,
        Err(code) => return Ok(Err(code)),
    };
    let case = &base.case;
    let first = first_seed(args, options, &base)?;
    if case.system.terms.is_empty() {
        bail!("{}: `unknown` is empty, so there is nothing to find", base.spec);
    }
    let method = options.method.map(Method::from).or(case.learn.method).unwrap_or(Method::Trajectory);
    let axes = axes(args, case, method)?;
    let cells = axes.iter().map(|axis| axis.len() as u64).try_fold(1, u64::checked_mul);
    let runs = cells.and_then(|cells| cells.checked_mul(args.seeds));
    if cells.is_none_or(|cells| cells > MOST_CELLS) || runs.is_none_or(|runs| runs > MOST_RUNS) {
        bail!(
            "{} with {} each are too many: a sweep has at most {MOST_CELLS} cells and {MOST_RUNS} runs: \
             list fewer values, or make several sweeps of it",
            cells.map_or("the cells".to_owned(), |n| counted(n, "cell")),
            counted(args.seeds, "seed"),
        );
    }
    let cells = match product(&text, &axes, &mut sources) {
        Ok(cells) => cells,
        Err(mistake) => return drawn(&mistake, &sources),
    };
    let mut all = Vec::new();
    for cell in cells {
        if interrupt::requested() {
            break;
        }
        // Each has sources of its own: those of all cells would fill the memory.
        let mut sources = Sources::default();
        match checked(spec, cell, options, &mut sources, false) {
            Ok((checked, _)) => all.push(checked),
            Err(code) => return Ok(Err(code)),
        }
    }
    if interrupt::requested() {
        complain("stopped before the first run");
        interrupt::tell();
        return Ok(Err(interrupt::code()));
    }
    let plan = Arc::new(Plan {
        spec: spec.to_owned(),
        options: options.clone(),
        cells: all,
        first,
        seeds: args.seeds,
        shard: args.shard,
    });
    Ok(Ok(Prepared { base, text, method, plan }))
}

fn first_seed(args: &SweepArgs, options: &Options, base: &Loaded) -> Result<u64> {
    let Some(first) = options.seed.or(seed_of(&base.case)) else {
        bail!("{}: no record of this case is `Synthetic`, so there is no truth to compare with", base.spec);
    };
    if first.checked_add(args.seeds - 1).is_none() {
        bail!(
            "{} seeds from {first} on would go beyond the largest seed, {}: start at a smaller --seed",
            args.seeds,
            u64::MAX
        );
    }
    Ok(first)
}

/// Reports cells without a result, and returns the exit code.
fn complain_of_cells(result: &SweepRuns<'_>) -> u8 {
    let mut worst = 0;
    for cell in &result.cells {
        let name = if cell.label.is_empty() { result.spec } else { cell.label };
        if let Err(why) = cell.truth {
            complain(&format!("{name}: {why}: no seed can be right"));
            worst = REJECTED;
        } else if !cell.runs.is_empty()
            && cell.runs.iter().all(|r| matches!(r.verdict, RunVerdict::Failed(_)))
        {
            complain(&format!(
                "{name}: no run came to a result: {}",
                cell.runs.first().map_or(String::new(), |r| r.verdict.to_string())
            ));
            worst = REJECTED;
        }
    }
    worst
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

/// A checked cell. If something is wrong, it shows the mistakes; the error is the exit code. Shows warnings
/// if `aloud`.
fn checked(
    spec: &Path,
    cell: Cell,
    options: &Options,
    sources: &mut Sources,
    aloud: bool,
) -> Result<(Checked, Loaded), u8> {
    let mut found = Vec::new();
    let options = Options { seed: None, ..options.clone() };
    let checked = Checked::new(spec, cell, &options, sources, &mut found);
    let drawn = found.iter().filter(|d| d.is_error() || (checked.is_ok() && aloud && !options.quiet));
    draw::show(drawn, sources);
    checked.map_err(exit_code)
}

/// The axes of the sweep, in the order of the options.
fn axes(args: &SweepArgs, case: &Case, method: Method) -> Result<Vec<Axis>> {
    let mut axes = Vec::new();
    let mut add = |option: &str, name: &str, paths: &[String], list: &str, separator: char| {
        let values = listed(list, separator);
        // Cells with one label would share their runs.
        if let Some(twice) = (1..values.len()).find(|&k| values[..k].contains(&values[k])) {
            bail!("{option} lists `{}` twice: list each value once", values[twice]);
        }
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
    for (k, set) in args.vary.iter().enumerate() {
        let parts: Vec<&str> = set.path.split('.').collect();
        if let ["data", _, "seed"] = parts[..] {
            bail!(
                "--vary {}: each run has a seed of its own: choose how many with --seeds, \
                 and the first with --seed",
                set.path
            );
        }
        if args.vary[..k].iter().any(|other| other.path == set.path) {
            bail!("--vary {} is given twice: list all its values in one, as in {0}=1;2", set.path);
        }
        add("--vary", &set.path, std::slice::from_ref(&set.path), &set.value, ';')?;
    }
    Ok(axes)
}
