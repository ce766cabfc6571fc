//! `phisindy export`.

mod robot;

use crate::args::{ExportArgs, Options};
use crate::terminal::{INPUT, print, remark};
use crate::{draw, fmu, outdir};
use anyhow::{Context, Result, anyhow, bail};
use phisindy::files::{self, Purpose};
use phisindy::record_named;
use phisindy_phys::{Diagnostic, Sources, spec};
use phisindy_report::export::{self, Experiment, Exporter, Subject, Writer, model_name};
use std::path::{Path, PathBuf};

/// Exports a model to standard output, or to the file of --out.
pub(crate) fn export(args: &ExportArgs, options: &Options) -> Result<u8> {
    let spec = spec_of(&args.path)?;
    let file = options.out.as_deref().map(|out| file_of(out, args.to));
    file.iter().try_for_each(|file| outdir::unless_there(file, options.force))?;
    if file.is_none() && matches!(args.to.write, Writer::Fmu(_)) {
        bail!(
            "an FMU is an archive, and no text for a terminal: say where it goes, as in --out {}",
            args.to.file
        );
    }
    if let Writer::Robot = args.to.write {
        return robot::export(&spec, args, options, file.as_deref());
    }
    if let Some(model) = &args.model {
        bail!(
            "`--model {}` means nothing to `--to {}`: it is of urdf and mjcf",
            model.display(),
            args.to.name
        );
    }
    let mut sources = Sources::default();
    let mut subject = match subject(&spec, args.record.as_deref(), options, &mut sources) {
        Ok(subject) => subject,
        Err(mistakes) => {
            draw::show(&mistakes, &sources);
            return Ok(INPUT);
        }
    };
    let stem = file.as_deref().and_then(Path::file_stem).map(|s| s.to_string_lossy());
    let name = model_name(&subject, stem.as_deref());
    let written = match args.to.write {
        Writer::Text(write) => write(&subject, &name).into_bytes(),
        Writer::Fmu(write) => {
            subject.experiment = experiment(&spec, args.record.as_deref(), &subject, options);
            if subject.experiment.is_none() && !options.quiet {
                remark(
                    "the record's data are not there, so that the FMU does not know how large its states become: their `nominal` is 1 \
                     where they start at zero (--data DIR says where the data are)",
                );
            }
            packed(&write(&subject, &name), options.quiet)?
        }
        Writer::Robot => bail!("a robot is written above"),
    };
    put(file.as_deref(), &written)?;
    Ok(0)
}

/// Writes a model into its file, or else on standard output.
fn put(file: Option<&Path>, written: &[u8]) -> Result<()> {
    let Some(file) = file else { return print(&String::from_utf8_lossy(written)) };
    if let Some(folder) = file.parent().filter(|p| !p.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder `{}` of --out", folder.display()))?;
    }
    outdir::replace_file(file, written)
}

/// The archive of an FMU, with a binary where that can be compiled.
fn packed(fmu: &export::Fmu, quiet: bool) -> Result<Vec<u8>> {
    let binary = fmu::compiled(fmu);
    if let (Err(why), false) = (&binary, quiet) {
        remark(&format!(
            "the FMU holds its sources and no binary, for {why}: an importer that compiles can run it"
        ));
    }
    fmu::archive(fmu, binary.ok())
}

/// How the states move in the record, if that can be told.
fn experiment(path: &Path, record: Option<&str>, subject: &Subject, options: &Options) -> Option<Experiment> {
    let (mut sources, mut found) = (Sources::default(), Vec::new());
    let loaded = files::load(path, &options.request(), Purpose::Simulate, &mut sources, &mut found).ok()?;
    let name =
        record.map_or_else(|| loaded.records.first().map(|r| r.name.clone()), |r| Some(r.to_owned()))?;
    let motion = loaded.only(&name).ok()?.simulate().ok()?.into_iter().next()?;
    let (from, to) = (*motion.time.first()?, *motion.time.last()?);
    let columns = subject.states().map(|name| motion.state(name)).collect::<Option<Vec<_>>>()?;
    Some(Experiment {
        from,
        to,
        step: (to - from) / motion.time.len().saturating_sub(1).max(1) as f64,
        first: columns.iter().map(|c| c[0]).collect(),
        sizes: columns.iter().map(|c| c.iter().fold(0.0_f64, |m, x| m.max(x.abs()))).collect(),
    })
}

/// The spec to export: `path` itself, or the one that `run` or `gap` wrote into the folder `path`.
fn spec_of(path: &Path) -> Result<PathBuf> {
    if !path.is_dir() {
        return Ok(path.to_owned());
    }
    let there: Vec<PathBuf> = ["completed.ron", "identified.ron"]
        .iter()
        .map(|name| path.join(name))
        .filter(|p| p.is_file())
        .collect();
    let shown = path.display();
    match there.as_slice() {
        [one] => Ok(one.clone()),
        [] => Err(anyhow!(
            "`{shown}` holds neither identified.ron nor completed.ron: give the folder that `phisindy run SPEC --out DIR` or `phisindy gap SPEC \
             --out DIR` wrote, or a spec"
        )),
        _ => Err(anyhow!(
            "`{shown}` holds identified.ron and completed.ron: say which one, `phisindy export {shown}/identified.ron`"
        )),
    }
}

/// The file of `--out`: `out` itself, or a file with the default name in the folder `out`.
fn file_of(out: &Path, to: &Exporter) -> PathBuf {
    let folder =
        out.is_dir() || out.as_os_str().to_string_lossy().ends_with(['/', std::path::MAIN_SEPARATOR]);
    if folder { out.join(to.file) } else { out.to_owned() }
}

/// Reads a spec. Warnings are not shown, for `check` and `run` have shown them.
///
/// # Errors
/// Diagnostics: mistakes of the spec, an unknown part, a missing record.
fn subject(
    path: &Path,
    record: Option<&str>,
    options: &Options,
    sources: &mut Sources,
) -> Result<Subject, Vec<Diagnostic>> {
    let text = files::spec_text(path).and_then(|text| files::with_assignments(text, &options.sets, sources));
    let text = text.map_err(|d| vec![d])?;
    let shown = path.display().to_string();
    let source = sources.add(shown.clone(), text.clone());
    let files = files::named_numbers(&text, path, &options.request(), source)?;
    let (spec, _) = spec::read_with_files(&text, source, &files)?;
    let (case, _) = phisindy_phys::check(&spec, source)?;
    if let Some(mistake) = export::refusal(&spec, &case, &shown, source) {
        return Err(vec![mistake]);
    }
    let constants = if export::uses_largest_input(&case) {
        Some(simulated_constants(path, text, options, sources)?)
    } else {
        None
    };
    let names = case.records.iter().map(|r| r.name.as_str());
    let record = record.map_or(Ok(0), |wish| record_named(wish, names)).map_err(|why| vec![why])?;
    Subject::new(spec, &case, &shown, record, constants.as_deref())
}

/// The constants of each record, once its excitation is generated.
fn simulated_constants(
    path: &Path,
    text: String,
    options: &Options,
    sources: &mut Sources,
) -> Result<Vec<Vec<f64>>, Vec<Diagnostic>> {
    let mut found = Vec::new();
    let loaded = files::load_text(path, text, &options.request(), Purpose::Simulate, sources, &mut found);
    loaded.map(|l| l.records.into_iter().map(|r| r.constants).collect()).map_err(|_| found)
}
