//! The subcommands: what is read, what is written, and with which exit code they end.

use crate::args::{Args, Command, Format, Options};
use crate::load::{Loaded, Purpose, Refusal, load};
use crate::outdir::{self, OutDir};
use crate::progress::Progress;
use crate::report::Report;
use crate::{
    draw, export, gap, html, identified_spec, interrupt, laws, manual, new, readme, simulate, sweep,
};
use anyhow::{Context, Result, anyhow};
use phisindy_learn::{Identified, LearnError, LearnOptions, Verdict, identify};
use phisindy_phys::{Diagnostic, Sources};
use phisindy_sim::DIVERGED;
use std::io::{self, IsTerminal, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// The result was rejected.
pub(crate) const REJECTED: u8 = 1;
/// The spec, its files or the command line are wrong.
pub(crate) const INPUT: u8 = 2;
/// The numerics failed.
pub(crate) const NUMERICS: u8 = 3;

/// Does what the command line says.
pub(crate) fn execute(args: &Args) -> ExitCode {
    interrupt::listen(args.options.limit.unwrap_or_default());
    let options = &args.options;
    let done = threads(options).and_then(|()| match &args.command {
        Command::Run { specs } => run(specs, options),
        Command::Gap { spec } => gap::command(spec, options),
        Command::Simulate { spec, record } => simulate(spec, record.as_deref(), options),
        Command::Check { specs } => Ok(check(specs, options)),
        Command::New(args) => new::command(args, options),
        Command::Laws { name } => laws(name.as_deref(), options),
        Command::Export(args) => export::command(args, options),
        Command::Completions { shell } => manual::completions(*shell),
        Command::Man => manual::pages(options),
        Command::Sweep(args) => sweep::command(args, options),
        Command::Table(args) => readme::command(args, options),
    });
    match done {
        Ok(code) => ExitCode::from(code),
        // Whoever read the result has read enough.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            complain(&format!("{error:#}"));
            ExitCode::from(INPUT)
        }
    }
}

fn threads(options: &Options) -> Result<()> {
    if let Some(jobs) = options.jobs {
        rayon::ThreadPoolBuilder::new()
            .num_threads(usize::from(jobs))
            .build_global()
            .context("cannot start the threads of --jobs")?;
    }
    Ok(())
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        let direct = cause.downcast_ref::<io::Error>().map(io::Error::kind);
        let inside = cause.downcast_ref::<csv::Error>().and_then(|e| match e.kind() {
            csv::ErrorKind::Io(e) => Some(e.kind()),
            _ => None,
        });
        direct.or(inside) == Some(io::ErrorKind::BrokenPipe)
    })
}

/// A message on standard error.
pub(crate) fn complain(message: &str) {
    draw::show([&Diagnostic::error(message)], &Sources::default());
}

/// Why a spec came to nothing, on standard error, with what to do where that is known.
pub(crate) fn failed(spec: &str, why: &str) {
    let d = Diagnostic::error(format!("{spec}: {why}"));
    draw::show([&advice(why).into_iter().fold(d, Diagnostic::help)], &Sources::default());
}

/// What to do about a failure.
pub(crate) fn advice(why: &str) -> Option<&'static str> {
    why.contains(DIVERGED).then_some(
        "look at the units of the columns and of the constants that drive it (warnings above may say which), at the signs of stiffness and damping, and at where movable constants start",
    )
}

/// Reads a spec and draws what there is to say about it; mistakes also into the report of a folder.
pub(crate) fn loaded(
    spec: &Path,
    options: &Options,
    purpose: Purpose,
    folder: Option<&OutDir>,
) -> Result<Loaded, u8> {
    loaded_with(spec, options, purpose, folder).map(|(loaded, _)| loaded)
}

/// The same with the number of warnings.
fn loaded_with(
    spec: &Path,
    options: &Options,
    purpose: Purpose,
    folder: Option<&OutDir>,
) -> Result<(Loaded, usize), u8> {
    let (mut sources, mut found) = (Sources::default(), Vec::new());
    let loaded = load(spec, options, purpose, &mut sources, &mut found);
    // Next to a mistake, warnings are mostly its consequences: what failed to parse leaves constants unused.
    let drawn = || found.iter().filter(|d| d.is_error() || (loaded.is_ok() && !options.quiet));
    draw::show(drawn(), &sources);
    if let (Err(_), Some(folder)) = (&loaded, folder) {
        let name = spec.display().to_string();
        let text = sources.files.iter().find(|f| f.name.starts_with(&name)).map(|f| f.text.as_str());
        let written = html::write_refusal(&name, text, &draw::text(drawn(), &sources), options, folder);
        written.unwrap_or_else(|error| complain(&format!("{error:#}")));
    }
    let doubts = || found.iter().map(|d| d.message.clone()).collect();
    loaded.map(|loaded| (Loaded { doubts: doubts(), ..loaded }, found.len())).map_err(refused)
}

/// The exit code of a refusal.
pub(crate) fn refused(refusal: Refusal) -> u8 {
    match refusal {
        Refusal::Input => INPUT,
        Refusal::Numerics => NUMERICS,
    }
}

/// A line on standard error that is no mistake.
pub(crate) fn remark(message: &str) {
    // Nobody is left to tell if standard error is closed.
    let _ = writeln!(io::stderr(), "{message}");
}

fn run(specs: &[PathBuf], options: &Options) -> Result<u8> {
    let folders = match &options.out {
        Some(out) => outdir::folders(out, specs)?.into_iter().map(Some).collect(),
        None => specs.iter().map(|_| None).collect::<Vec<Option<OutDir>>>(),
    };
    folders.iter().flatten().try_for_each(|folder| folder.without("gap", gap::COMPLETED))?;
    let mut worst = 0;
    for (k, (spec, folder)) in specs.iter().zip(&folders).enumerate() {
        if interrupt::asked() {
            interrupt::tell();
            return Ok(interrupt::code());
        }
        let code = run_one(spec, folder.as_ref(), options, k > 0)?;
        worst = worst.max(code);
    }
    Ok(worst)
}

fn run_one(spec: &Path, folder: Option<&OutDir>, options: &Options, follows: bool) -> Result<u8> {
    let begin = Instant::now();
    let loaded = match loaded(spec, options, Purpose::Run, folder) {
        Ok(loaded) => loaded,
        Err(code) => return Ok(code),
    };
    let found = match identified(&loaded, options) {
        Ok(found) => found,
        Err(error) => {
            failed(&loaded.spec, &error.to_string());
            interrupt::tell();
            if let Some(folder) = folder {
                html::write_failure(&error.to_string(), &loaded, options, folder)?;
            }
            return Ok(match error {
                LearnError::Data(_) => INPUT,
                LearnError::Numerics(_) => NUMERICS,
            });
        }
    };
    let report = Report::new(&loaded, &found, begin.elapsed().as_secs_f64());
    if !options.quiet {
        caution(&report, options.format);
    }
    let kept = folder.map_or(Ok(()), |folder| keep(&report, &loaded, &found, options, folder));
    // A full disk must not take away what was computed: it is printed all the same.
    let blank = if follows && options.format != Format::Json { "\n" } else { "" };
    print(&format!("{blank}{}", report.written(options.format)))?;
    kept?;
    if found.stopped {
        interrupt::tell();
    }
    Ok(match (found.stopped, &found.verdict) {
        (true, _) => interrupt::code(),
        (false, Verdict::Identified) => 0,
        (false, Verdict::Rejected(_)) => REJECTED,
    })
}

/// Writes the files of a run.
fn keep(
    report: &Report<'_>,
    loaded: &Loaded,
    found: &Identified,
    options: &Options,
    folder: &OutDir,
) -> Result<()> {
    folder.write("result.json", &report.written(Format::Json))?;
    folder.write("equation.tex", &report.written(Format::Latex))?;
    match identified_spec::written(loaded, found) {
        Ok(text) => folder.write(identified_spec::NAME, &text)?,
        Err(why) => complain(&format!("identified.ron cannot be written: {why}")),
    }
    html::write_run(report, loaded, options, folder)
}

/// What a reader should know, on standard error; not a second time where the result goes to the same terminal.
fn caution(report: &Report<'_>, format: Format) {
    let twice = format != Format::Json && io::stdout().is_terminal() && io::stderr().is_terminal();
    report.notes.iter().for_each(|note| remark(&format!("note: {note}")));
    if !twice {
        let said: Vec<Diagnostic> = report.warnings.iter().map(|w| Diagnostic::warning(w.clone())).collect();
        draw::show(&said, &Sources::default());
    }
}

/// The call into the library, with the bar, until the user has enough.
fn identified(loaded: &Loaded, options: &Options) -> Result<Identified, LearnError> {
    let mut progress = Progress::new(&loaded.spec, options.quiet);
    let learn = LearnOptions { method: options.method.map(Into::into) };
    identify(&loaded.case, &loaded.records, &learn, &mut |fraction| {
        progress.at(fraction);
        if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })
}

fn simulate(spec: &Path, record: Option<&str>, options: &Options) -> Result<u8> {
    let mut loaded = match loaded(spec, options, Purpose::Simulate, None) {
        Ok(loaded) => loaded,
        Err(code) => return Ok(code),
    };
    if loaded.records.is_empty() {
        return Err(anyhow!(
            "{}: the model has an unknown part and no `Synthetic` record: identify it first (`phisindy run {} --out DIR`), then simulate \
             DIR/identified.ron",
            loaded.spec,
            loaded.spec
        ));
    }
    if let Some(record) = record {
        loaded = match loaded.only(record) {
            Ok(loaded) => loaded,
            Err(mistake) => {
                draw::show([&mistake], &Sources::default());
                return Ok(INPUT);
            }
        };
    }
    let runs = match simulate::runs(&loaded) {
        Ok(runs) => runs,
        Err(why) => {
            failed(&loaded.spec, &why.to_string());
            return Ok(NUMERICS);
        }
    };
    let mut out = io::BufWriter::new(io::stdout().lock());
    simulate::write(&loaded, &runs, &mut out).and_then(|()| Ok(out.flush()?)).context(STDOUT)?;
    Ok(0)
}

fn check(specs: &[PathBuf], options: &Options) -> u8 {
    let codes = specs.iter().map(|spec| match loaded_with(spec, options, Purpose::Check, None) {
        Ok((_, warnings)) => {
            // Silence would leave it open whether anything was looked at.
            if !options.quiet {
                let warned = match warnings {
                    0 => String::new(),
                    1 => ", 1 warning".to_owned(),
                    n => format!(", {n} warnings"),
                };
                remark(&format!("{}: no mistakes{warned}", spec.display()));
            }
            0
        }
        Err(code) => code,
    });
    codes.max().unwrap_or(0)
}

fn laws(name: Option<&str>, options: &Options) -> Result<u8> {
    let folders: Vec<&Path> = options.laws.as_deref().into_iter().collect();
    let mut all = laws::catalogue(&folders)?;
    if let Some(out) = &options.out {
        if let Some(name) = name {
            all.retain(|e| e.id == name);
        }
        let folder = OutDir::create(out)?;
        for entry in &all {
            if let Some(svg) = laws::picture(entry)? {
                folder.write(&format!("{}.svg", entry.id), &svg)?;
            }
        }
        folder.write("README.md", &laws::gallery(&all))?;
    }
    let Some(name) = name else {
        print(&laws::list(&all))?;
        return Ok(0);
    };
    let Some(entry) = all.iter().find(|e| e.id == name) else {
        let ids: Vec<&str> = all.iter().map(|e| e.id.as_str()).collect();
        let near = phisindy_expr::nearest(name, ids.iter().copied());
        let hint = near.map_or_else(
            || format!("there is: {}", ids.join(", ")),
            |near| format!("did you mean `{near}`?"),
        );
        return Err(anyhow!("there is no law `{name}`; {hint}"));
    };
    print(&laws::shown(entry))?;
    Ok(0)
}

/// What is wrong where the result has nowhere to go.
const STDOUT: &str =
    "cannot write to standard output: write into a file on a disk with space, or give --out DIR";

/// The result.
pub(crate) fn print(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).context(STDOUT)
}
