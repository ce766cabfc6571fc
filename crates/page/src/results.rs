//! Results: a folder for each, which appears as a whole, and what can be taken out of it.

use crate::folder::{Working, ending, plain};
use phisindy_phys::Sources;
use phisindy_report::Folder;
use phisindy_report::export::{
    EXPORTERS, Exporter, Subject, Writer, model_name, refusal, uses_largest_input,
};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

/// Where results are, in the working folder.
const RESULTS: &str = "results";
/// Models that a result may hold, the best first.
const MODELS: &[&str] = &["completed.ron", "identified.ron"];
/// What a browser may take of a result.
const ENDINGS: &[&str] = &["html", "svg", "json", "ron", "tex", "txt"];

/// Keeps the files of a result in a new folder and returns its name, `STEM-WHAT-N`.
///
/// # Errors
/// In words: the disk is full, or the folder cannot be written.
pub(crate) fn keep(folder: &Path, stem: &str, what: &str, files: &Folder) -> Result<String, String> {
    let all = folder.join(RESULTS);
    if all.is_symlink() {
        return Err(format!("`{RESULTS}` is a link: results are kept in this folder only"));
    }
    let part = all.join(format!(".{stem}-{what}.{}.part", std::process::id()));
    let written = || -> std::io::Result<String> {
        let _ = fs::remove_dir_all(&part);
        fs::create_dir_all(&part)?;
        for (path, text) in &files.files {
            let path = part.join(path);
            path.parent().map_or(Ok(()), fs::create_dir_all)?;
            fs::write(path, text)?;
        }
        for k in 1.. {
            let name = format!("{stem}-{what}-{k}");
            if !all.join(&name).exists() {
                fs::rename(&part, all.join(&name))?;
                return Ok(name);
            }
        }
        Err(std::io::Error::other("there are too many results"))
    };
    written().map_err(|why| {
        let _ = fs::remove_dir_all(&part);
        format!("cannot keep the result in `{RESULTS}`: {why}")
    })
}

/// All results, the newest first: name, time, verdict.
pub(crate) fn list(folder: &Working) -> Value {
    let entries = fs::read_dir(folder.path().join(RESULTS)).into_iter().flatten().flatten();
    let mut all: Vec<(u64, Value)> = entries.filter_map(|entry| described(&entry.path())).collect();
    all.sort_by_key(|(time, _)| std::cmp::Reverse(*time));
    all.into_iter().map(|(_, told)| told).collect()
}

fn described(path: &Path) -> Option<(u64, Value)> {
    let name = path.file_name()?.to_str().filter(|name| plain(name))?;
    let file = path.join("result.json");
    let changed = fs::metadata(&file).ok()?.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
    let result: Value = serde_json::from_str(&fs::read_to_string(file).ok()?).ok()?;
    let ended = result["verdict"].as_str().or(result["status"].as_str()).unwrap_or("");
    let told = json!({ "name": name, "title": result["title"], "ended": ended, "time": changed.as_secs() });
    Some((changed.as_millis().try_into().ok()?, told))
}

/// The path of a file of a result, `NAME/FILE` or `NAME/figures/FILE`.
///
/// # Errors
/// It is none of a result.
pub(crate) fn file(folder: &Working, path: &str) -> Result<PathBuf, String> {
    let parts: Vec<&str> = path.split('/').collect();
    let known = match parts[..] {
        [name, file] => plain(name) && plain(file),
        [name, "figures", file] => plain(name) && plain(file),
        _ => false,
    };
    let full = folder.path().join(RESULTS).join(path);
    let inside = full.canonicalize().is_ok_and(|p| p.starts_with(folder.path()) && p.is_file());
    if known && inside && ENDINGS.contains(&ending(path).as_str()) {
        Ok(full)
    } else {
        Err(format!("there is no file `{path}` in the results"))
    }
}

/// Languages that a model can be taken in: those that are one text.
pub(crate) fn languages() -> Value {
    let texts = EXPORTERS.iter().filter(|e| matches!(e.write, Writer::Text(_)));
    texts.map(|e| json!({ "id": e.name, "about": e.about })).collect()
}

/// The model of a result in a language: the name of its file, and its text.
///
/// # Errors
/// In words: there is no such result or language, or its model cannot be exported.
pub(crate) fn exported(folder: &Working, result: &str, to: &str) -> Result<(&'static str, String), String> {
    let exporter: &'static Exporter =
        EXPORTERS.iter().find(|e| e.name == to).ok_or_else(|| format!("there is no language `{to}`"))?;
    let Writer::Text(write) = exporter.write else {
        return Err(format!("`phisindy export results/{result} --to {to}` does this"));
    };
    let model = MODELS.iter().find_map(|name| file(folder, &format!("{result}/{name}")).ok());
    let path = model.ok_or_else(|| format!("`{result}` holds no model"))?;
    let text = fs::read_to_string(&path).map_err(|why| why.to_string())?;
    let shown = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let mut sources = Sources::default();
    let source = sources.add(shown.clone(), text.clone());
    let first = |all: Vec<phisindy::Diagnostic>| all.into_iter().next().map_or(String::new(), |d| d.message);
    let (spec, _) = phisindy_phys::spec::read(&text, source).map_err(first)?;
    let (case, _) = phisindy_phys::check(&spec, source).map_err(first)?;
    if let Some(mistake) = refusal(&spec, &case, &shown, source) {
        return Err(mistake.message);
    }
    if uses_largest_input(&case) {
        return Err(format!(
            "a constant follows from its data: `phisindy export results/{result} --to {to}` reads them"
        ));
    }
    let subject = Subject::new(spec, &case, &shown, 0, None).map_err(first)?;
    let name = model_name(&subject, None);
    Ok((exporter.file, write(&subject, &name)))
}
