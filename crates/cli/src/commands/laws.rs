//! `phisindy laws`.

use crate::args::Options;
use crate::draw;
use crate::outdir::{OutDir, unless_there};
use crate::terminal::{INPUT, look, print};
use anyhow::{Result, anyhow};
use phisindy::files::{catalogue, doubts};
use phisindy_phys::Sources;
use phisindy_report::laws::{gallery, list, picture, shown};
use std::path::Path;

/// Prints the list of laws or one of them; writes their pictures into `--out`.
pub(crate) fn laws(name: Option<&str>, options: &Options) -> Result<u8> {
    let folders: Vec<&Path> = options.laws.as_deref().into_iter().collect();
    let mut sources = Sources::default();
    let mut all = match catalogue(&folders) {
        Ok(all) => {
            if !options.quiet {
                draw::show(&doubts(&folders, &all, &mut sources), &sources);
            }
            all.laws().to_vec()
        }
        Err(error) => {
            let mistakes = error.diagnostics(&mut sources);
            draw::show(&mistakes, &sources);
            return Ok(INPUT);
        }
    };
    if let Some(out) = &options.out {
        if let Some(name) = name {
            all.retain(|e| e.id == name);
        }
        let folder = OutDir::create(out)?;
        for law in &all {
            if let Some(svg) = picture(law).map_err(|why| anyhow!(why))? {
                folder.write(&format!("{}.svg", law.id), &svg)?;
            }
        }
        folder.write("README.md", gallery(&all))?;
    }
    let Some(name) = name else {
        show(&list(&all, look()))?;
        return Ok(0);
    };
    let Some(law) = all.iter().find(|e| e.id == name) else {
        let ids: Vec<&str> = all.iter().map(|e| e.id.as_str()).collect();
        let near = phisindy_expr::nearest(name, ids.iter().copied());
        let hint = near.map_or_else(
            || format!("there is: {}", ids.join(", ")),
            |near| format!("did you mean `{near}`?"),
        );
        return Err(anyhow!("there is no law `{name}`; {hint}"));
    };
    show(&shown(law))?;
    Ok(0)
}

/// Prints what laws say: their files may be somebody else's.
fn show(text: &str) -> Result<()> {
    print(&String::from_utf8_lossy(&draw::printable(text.as_bytes())))
}

/// A law of the user's own, with a comment on every field.
const TEMPLATE: &str = include_str!("law_template.ron");

/// Prints the template of a law, or writes it into `--out`.
pub(crate) fn new(name: &str, options: &Options) -> Result<u8> {
    if name.is_empty() || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_') {
        return Err(anyhow!(
            "`{name}` is no id of a law: letters, digits and `-`, for it is the name of a file"
        ));
    }
    let text = TEMPLATE.replace("\"NAME\"", &format!("\"{name}\""));
    match &options.out {
        Some(out) => {
            let file = format!("{name}.ron");
            unless_there(&out.join(&file), options.force)?;
            OutDir::create(out)?.write(&file, &text)?;
        }
        None => print(&text)?,
    }
    Ok(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy::Catalogue;

    #[test]
    fn the_template_is_a_law() {
        let law = phisindy_phys::Law::checked(TEMPLATE, phisindy_phys::SourceId(0)).expect("a law");
        assert!(law.has_memory() && law.is_hysteretic());
    }

    /// Every law has a picture, and the page in `docs/laws` is what the program writes.
    #[test]
    fn the_gallery_is_current() {
        let all = Catalogue::built_in();
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/laws");
        assert_eq!(std::fs::read_to_string(docs.join("README.md")).unwrap(), gallery(all.laws()));
        for entry in all.laws() {
            let svg = picture(entry).unwrap().unwrap_or_else(|| panic!("no sketch of {}", entry.id));
            assert!(svg.contains("class=\"model\""), "{}", entry.id);
            let kept = std::fs::read_to_string(docs.join(format!("{}.svg", entry.id))).unwrap();
            assert!(kept == svg, "docs/laws/{}.svg is not current", entry.id);
        }
    }
}
