//! Results: a folder for each, which appears as a whole, and what can be taken out of it.

use crate::folder::{LONGEST_NAME, Working, ending, plain};
use phisindy::files::{open_plain_file, put_new};
use phisindy_phys::Sources;
use phisindy_report::Folder;
use phisindy_report::export::{
    EXPORTERS, Exporter, Subject, Writer, model_name, refusal, uses_largest_input,
};
use serde_json::{Value, json};
use std::cmp::Reverse;
use std::fs;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// Where results are, in the working folder.
const RESULTS: &str = "results";
/// The file in each that tells how it ended.
const RESULT: &str = "result.json";
/// Most results that are shown.
const SHOWN: usize = 200;
/// Models that a result may hold, the best first.
const MODELS: &[&str] = &["completed.ron", "identified.ron"];
/// What a browser may take of a result.
const ENDINGS: &[&str] = &["csv", "html", "svg", "json", "ron", "tex", "txt"];

/// A folder like that of a new result, as paths in it see other files.
pub(crate) fn place(folder: &Path) -> PathBuf {
    folder.join(RESULTS).join("new")
}

/// Keeps the files of a result in a new folder and returns its name, `STEM-WHAT-N`.
///
/// # Errors
/// In words: the disk is full, or the folder cannot be written.
pub(crate) fn keep(folder: &Path, stem: &str, what: &str, files: &Folder) -> Result<String, String> {
    let all = folder.join(RESULTS);
    if all.is_symlink() {
        return Err(format!("`{RESULTS}` is a link: results are kept in this folder only"));
    }
    // `STEM-WHAT-K` is a plain name too.
    let stem = &stem[..stem.floor_char_boundary(LONGEST_NAME - 20)];
    let kept = fs::create_dir_all(&all)
        .and_then(|()| put_new(files, |k| all.join(format!("{stem}-{what}-{k}"))))
        .map_err(|why| format!("cannot keep the result in `{RESULTS}`: {why}"))?;
    Ok(kept.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default())
}

/// The newest results: name, time, verdict, laws.
pub(crate) fn list(folder: &Working) -> Value {
    let entries = fs::read_dir(folder.path().join(RESULTS)).into_iter().flatten().flatten();
    let mut all: Vec<(SystemTime, PathBuf)> = entries.filter_map(|entry| dated(entry.path())).collect();
    all.sort_by_key(|(time, _)| Reverse(*time));
    all.iter().take(SHOWN).filter_map(|(time, path)| described(*time, path)).collect()
}

/// A result, and when it was written.
fn dated(path: PathBuf) -> Option<(SystemTime, PathBuf)> {
    Some((fs::metadata(path.join(RESULT)).ok()?.modified().ok()?, path))
}

fn described(time: SystemTime, path: &Path) -> Option<Value> {
    let name = path.file_name()?.to_str().filter(|name| plain(name))?;
    let result: Value =
        serde_json::from_reader(BufReader::new(open_plain_file(&path.join(RESULT)).ok()?)).ok()?;
    let ended = match result["runs"] {
        Value::Array(_) => "measure next",
        _ => result["verdict"].as_str().or(result["status"].as_str()).unwrap_or_default(),
    };
    let laws: Vec<&Value> =
        result["steps"].as_array().into_iter().flatten().map(|step| &step["name"]).collect();
    let time = time.duration_since(UNIX_EPOCH).ok()?.as_secs();
    Some(json!({
        "name": name, "title": result["title"], "ended": ended, "laws": laws, "time": time,
        "stopped": !matches!(result["stopped"], Value::Null | Value::Bool(false)),
    }))
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
    let files = phisindy::files::named_numbers(&text, &path, &phisindy::files::Request::default(), source);
    let (spec, _) =
        phisindy_phys::spec::read_with_files(&text, source, &files.map_err(first)?).map_err(first)?;
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
