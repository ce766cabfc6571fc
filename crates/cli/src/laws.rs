//! The catalogue of laws: built in, beside the spec, and in the folder of `--laws`.

mod builtin;
mod picture;

pub(crate) use picture::picture;

use crate::args::Options;
use crate::datafile;
use crate::table::{aligned, short};
use anyhow::{Context, Result, anyhow, bail};
use phisindy_phys::Law;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// Most bytes of a law.
const LONGEST: u64 = 1 << 16;
/// Most laws of a folder.
const MOST: usize = 1000;

/// A law and where it comes from.
pub(crate) struct Entry {
    /// What it is called in specs and results: the name of its file.
    pub(crate) id: String,
    /// The text of its file.
    pub(crate) text: String,
    /// What the text says.
    pub(crate) law: Law,
}

/// All laws: built in, then those of each folder, which may replace earlier ones.
pub(crate) fn catalogue(folders: &[&Path]) -> Result<Vec<Entry>> {
    let mut all = Vec::new();
    for (id, text) in builtin::LAWS {
        all.push(entry(id, (*text).to_owned(), &format!("the built-in law `{id}`"))?);
    }
    for folder in folders {
        let mut paths: Vec<_> = std::fs::read_dir(folder)
            .and_then(|entries| entries.map(|e| e.map(|e| e.path())).collect::<Result<_, _>>())
            .with_context(|| format!("cannot read the folder of laws `{}`", folder.display()))?;
        paths.retain(|p| p.extension().is_some_and(|e| e == "ron"));
        paths.sort();
        if paths.len() > MOST {
            bail!(
                "the folder of laws `{}` holds {} laws (at most {MOST}): take some out",
                folder.display(),
                paths.len()
            );
        }
        for path in paths {
            let id = path.file_stem().map_or(String::new(), |s| s.to_string_lossy().into_owned());
            let text = text_of(&path, folder)
                .with_context(|| format!("cannot read the law `{}`", path.display()))?;
            let new = entry(&id, text, &format!("the law `{}`", path.display()))?;
            all.retain(|e| e.id != id);
            all.push(new);
        }
    }
    all.sort_by(|a, b| a.id.cmp(&b.id));
    Ok(all)
}

/// The laws that a spec may name: built in, in the folder `laws` beside it, in that of `--laws`.
pub(crate) fn beside(spec: &Path, options: &Options) -> Result<Vec<phisindy_gap::Entry>> {
    let own = spec.parent().map(|p| p.join("laws")).filter(|p| p.is_dir());
    let folders: Vec<&Path> = own.as_deref().into_iter().chain(options.laws.as_deref()).collect();
    let all = catalogue(&folders)?.into_iter();
    Ok(all.map(|e| phisindy_gap::Entry { id: e.id, law: Arc::new(e.law) }).collect())
}

/// The text of a law. The folder may come with somebody else's spec, so nothing is read that is not a file in it.
fn text_of(path: &Path, folder: &Path) -> Result<String> {
    if !path.canonicalize()?.starts_with(folder.canonicalize()?) {
        bail!("it is a link that leads out of the folder of laws: copy the file into the folder");
    }
    let mut text = String::new();
    datafile::open(path)?.take(LONGEST + 1).read_to_string(&mut text)?;
    if text.len() as u64 > LONGEST {
        bail!("it is longer than {LONGEST} bytes: a law is a few lines of text");
    }
    Ok(text)
}

fn entry(id: &str, text: String, what: &str) -> Result<Entry> {
    let law = Law::read(&text).map_err(|e| anyhow!("{what} cannot be read: {e}"))?;
    Ok(Entry { id: id.to_owned(), text, law })
}

/// One line for each law.
pub(crate) fn list(all: &[Entry]) -> String {
    let rows: Vec<Vec<String>> =
        all.iter().map(|e| vec![e.id.clone(), e.law.name.clone(), e.law.about.clone()]).collect();
    aligned(&rows).join("\n") + "\n"
}

/// One law, for people: its name, what it says, its parameters, where it comes from, its text.
pub(crate) fn shown(entry: &Entry) -> String {
    let law = &entry.law;
    let mut lines = vec![format!("{} ({})", law.name, entry.id), law.about.clone(), String::new()];
    lines.extend(law.acts());
    if !law.parameters.is_empty() {
        let mut rows = vec![["parameter", "unit", "within"].map(str::to_owned).to_vec()];
        for (name, p) in &law.parameters {
            let unit = if p.unit.is_empty() { "-".to_owned() } else { p.unit.clone() };
            rows.push(vec![name.clone(), unit, format!("{} to {}", short(p.within.0), short(p.within.1))]);
        }
        lines.push(String::new());
        lines.extend(aligned(&rows));
    }
    lines.push(String::new());
    lines.push(format!("Reference: {}", law.reference));
    lines.push(String::new());
    lines.push(format!("laws/{}.ron:", entry.id));
    lines.extend(entry.text.lines().map(|l| format!("    {l}").trim_end().to_owned()));
    lines.join("\n") + "\n"
}

/// All laws with their pictures, as a page of Markdown.
pub(crate) fn gallery(all: &[Entry]) -> String {
    let mut out = String::from(
        "# The catalogue of laws\n\nWritten by `phisindy laws --out docs/laws` from the files in `specs/laws`. Each picture is drawn along the motion `x = sin t`, `v = cos t`, with example\nnumbers; a law of your own gets one by a line `sketch: (over: \"v\", with: { ... })`.\n",
    );
    for e in all {
        let law = &e.law;
        out += &format!("\n## {} (`{}`)\n\n{}\n", law.name, e.id, law.about);
        if law.sketch.is_some() {
            out += &format!("\n![{}]({}.svg)\n", law.name, e.id);
        }
        out.push('\n');
        out += &law.acts().iter().map(|l| format!("- {}\n", code(l))).collect::<String>();
        for (name, p) in &law.parameters {
            let unit = if p.unit.is_empty() { "no unit" } else { p.unit.as_str() };
            let each = if p.each { ", one for each record" } else { "" };
            out += &format!("- `{name}`: {unit}, {} to {}{each}\n", short(p.within.0), short(p.within.1));
        }
        if !law.reference.is_empty() {
            out += &format!("\n{}\n", law.reference);
        }
    }
    out
}

/// What stands behind the colon as code.
fn code(line: &str) -> String {
    line.split_once(": ").map_or_else(|| line.to_owned(), |(what, text)| format!("{what}: `{text}`"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every law has a picture, and the page in `docs/laws` is what the program writes.
    #[test]
    fn the_gallery_is_current() {
        let all = catalogue(&[]).unwrap();
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/laws");
        assert_eq!(std::fs::read_to_string(docs.join("README.md")).unwrap(), gallery(&all));
        for entry in &all {
            let svg = picture(entry).unwrap().unwrap_or_else(|| panic!("no sketch of {}", entry.id));
            assert!(svg.contains("class=\"model\""), "{}", entry.id);
            let kept = std::fs::read_to_string(docs.join(format!("{}.svg", entry.id))).unwrap();
            assert!(kept == svg, "docs/laws/{}.svg is not current", entry.id);
        }
    }
}
