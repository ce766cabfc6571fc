//! The catalogue of laws: built in, beside the spec, and in the folder of `--laws`.

mod builtin;

use crate::args::Options;
use crate::datafile;
use anyhow::{Context, Result, anyhow, bail};
use phisindy_phys::Law;
use phisindy_report::laws::LawFile;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// Most bytes of a law.
const LONGEST: u64 = 1 << 16;
/// Most laws of a folder.
const MOST: usize = 1000;

/// All laws: built in, then those of each folder, which may replace earlier ones.
pub(crate) fn catalogue(folders: &[&Path]) -> Result<Vec<LawFile>> {
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

fn entry(id: &str, text: String, what: &str) -> Result<LawFile> {
    let law = Law::read(&text).map_err(|e| anyhow!("{what} cannot be read: {e}"))?;
    Ok(LawFile { id: id.to_owned(), text, law })
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_report::laws::{gallery, picture};

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
