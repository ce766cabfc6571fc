//! `phisindy lsp` and `phisindy schema`: what editors are told.

use crate::args::{Options, Written};
use crate::terminal::print;
use anyhow::{Context, Result, anyhow};
use phisindy_phys::fields::{LAW, SPEC};

/// Serves an editor over standard input and output.
pub(crate) fn serve(options: &Options) -> Result<u8> {
    phisindy_editor::serve(&options.request())
        .map_err(|why| anyhow!("the talk with the editor broke off: {why}"))?;
    Ok(0)
}

/// Prints the schema of a spec or a law.
pub(crate) fn schema(of: Written) -> Result<u8> {
    let schema = match of {
        Written::Spec => phisindy_editor::schema(&SPEC, "spec"),
        Written::Law => phisindy_editor::schema(&LAW, "law"),
    };
    print(&(serde_json::to_string_pretty(&schema).context("the schema cannot be written")? + "\n"))?;
    Ok(0)
}
