//! `phisindy export`: the identified model as a text that runs elsewhere.

mod c;
mod functions;
mod head;
mod identifier;
mod json;
mod modelica;
mod python;
mod quoted;
mod subject;

use crate::args::{ExportArgs, Options, Target};
use crate::command::{INPUT, print};
use crate::{draw, outdir};
use anyhow::{Context, Result, anyhow};
use phisindy_phys::Sources;
use std::path::{Path, PathBuf};
use subject::Subject;

/// Exports a model to standard output, or to the file of --out.
pub(crate) fn command(args: &ExportArgs, options: &Options) -> Result<u8> {
    let spec = spec_of(&args.path)?;
    let file = options.out.as_deref().map(|out| file_of(out, args.to));
    file.iter().try_for_each(|file| outdir::unless_there(file, args.force))?;
    let mut sources = Sources::default();
    let subject = match Subject::read(&spec, args.record.as_deref(), options, &mut sources) {
        Ok(subject) => subject,
        Err(mistakes) => {
            draw::show(&mistakes, &sources);
            return Ok(INPUT);
        }
    };
    let text = match args.to {
        Target::Python => python::written(&subject),
        Target::C => c::written(&subject),
        Target::Modelica => modelica::written(&subject, &model_name(&subject, file.as_deref())),
        Target::Json => json::written(&subject),
    };
    match file {
        Some(file) => {
            if let Some(folder) = file.parent().filter(|p| !p.as_os_str().is_empty()) {
                std::fs::create_dir_all(folder)
                    .with_context(|| format!("cannot make the folder `{}` of --out", folder.display()))?;
            }
            outdir::replace_file(&file, &text)?;
        }
        None => print(&text)?,
    }
    Ok(0)
}

/// The spec that is meant: itself, or the one that `run` or `gap` left in a folder.
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

/// The file of --out: itself, or one with a plain name if it is a folder.
fn file_of(out: &Path, to: Target) -> PathBuf {
    let name = match to {
        Target::Python => "model.py",
        Target::C => "model.c",
        Target::Modelica => "Model.mo",
        Target::Json => "model.json",
    };
    let folder =
        out.is_dir() || out.as_os_str().to_string_lossy().ends_with(['/', std::path::MAIN_SEPARATOR]);
    if folder { out.join(name) } else { out.to_owned() }
}

/// Tools look for a Modelica model in the file of its name; without a file the title names it.
fn model_name(subject: &Subject, file: Option<&Path>) -> String {
    let stem = file.and_then(Path::file_stem).map(|s| s.to_string_lossy().into_owned());
    let title = subject.title.split(':').next().unwrap_or_default();
    let words = title.split(|c: char| !c.is_ascii_alphanumeric()).filter(|w| !w.is_empty());
    let joined: String = words.map(|w| format!("{}{}", w[..1].to_uppercase(), &w[1..])).collect();
    let clean: String =
        stem.unwrap_or(joined).chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if clean.starts_with(|c: char| c.is_ascii_alphabetic()) { clean } else { format!("Model{clean}") }
}
