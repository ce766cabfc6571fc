//! `phisindy laws`.

use crate::args::Options;
use crate::laws::catalogue;
use crate::outdir::OutDir;
use crate::terminal::print;
use anyhow::{Result, anyhow};
use phisindy_report::laws::{gallery, list, picture, shown};
use std::path::Path;

/// Prints the list of laws or one of them; writes their pictures into `--out`.
pub(crate) fn laws(name: Option<&str>, options: &Options) -> Result<u8> {
    let folders: Vec<&Path> = options.laws.as_deref().into_iter().collect();
    let mut all = catalogue(&folders)?;
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
        folder.write("README.md", &gallery(&all))?;
    }
    let Some(name) = name else {
        print(&list(&all))?;
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
    print(&shown(law))?;
    Ok(0)
}
