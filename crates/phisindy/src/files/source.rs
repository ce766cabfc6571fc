//! A spec or the folder of a result, as what another result is made from.

use super::laws::beside;
use super::load::{Purpose, open_text, spec_text, with_assignments};
use super::request::{Assignment, Request};
use crate::Identified;
use crate::error::Error;
use crate::laws::Catalogue;
use crate::loaded::Loaded;
use crate::options::{Options, Progress};
use phisindy_phys::{Diagnostic, Sources};
use phisindy_report::SPEC;
use phisindy_report::spec_text::{COMPLETED, named_data};
use std::path::{Path, PathBuf};

/// Does a part of the work, from one fraction of the whole to another.
pub(super) fn part<R>(
    options: &Options<'_>,
    (from, to): (f64, f64),
    work: impl FnOnce(&Options<'_>) -> R,
) -> R {
    let observe = |now: Progress<'_>| options.progress(from + (to - from) * now.fraction, now.activity);
    work(&Options { observe: Some(&observe), ..*options })
}

/// A spec, or the one in a folder of a result.
pub(super) struct Source {
    /// As the user named it.
    pub(super) name: String,
    /// Its file.
    path: PathBuf,
    pub(super) text: String,
}

impl Source {
    /// What `gap` found, or what `run` was given with its dictionary.
    pub(super) fn completed(path: &Path) -> Result<Source, String> {
        Source::first_of(path, &[COMPLETED, SPEC])
    }

    /// What a result was made from, with fields set.
    pub(super) fn given(path: &Path, set: &[Assignment]) -> Result<Source, String> {
        let source = Source::first_of(path, &[SPEC])?;
        let text = with_assignments(source.text, set, &mut Sources::default()).map_err(|d| line(&d))?;
        Ok(Source { text, ..source })
    }

    fn first_of(path: &Path, models: &[&str]) -> Result<Source, String> {
        let shown = path.display();
        let file = if path.is_dir() {
            let mut models = models.iter().map(|name| path.join(name));
            models.find(|file| file.is_file()).ok_or_else(|| {
                format!(
                    "`{shown}` is no folder of a result of this version: name one that `phisindy run SPEC --out DIR` or `phisindy gap SPEC --out DIR` wrote, or a spec"
                )
            })?
        } else {
            path.to_owned()
        };
        let text = spec_text(&file).map_err(|d| line(&d))?;
        Ok(Source { name: shown.to_string(), path: file, text })
    }

    /// Its file.
    pub(super) fn file(&self) -> &Path {
        &self.path
    }

    /// The laws of the program, with those beside the spec and of the folder that is asked for.
    pub(super) fn laws(&self, request: &Request) -> Result<Catalogue, String> {
        beside(&self.path, request).map_err(|why| why.to_string())
    }

    /// A text with the records of this spec.
    pub(super) fn opened(&self, text: &str, request: &Request, purpose: Purpose) -> Result<Loaded, Error> {
        let named = named_data(&self.text).into_iter().map(str::to_owned).collect();
        open_text(text, &self.path, &Request { named_data: Some(named), ..request.clone() }, purpose)
    }

    /// A model, fitted to the records of this spec.
    pub(super) fn fitted(
        &self,
        model: &str,
        request: &Request,
        options: &Options<'_>,
    ) -> Result<Identified, Error> {
        self.opened(model, request, Purpose::Run)?.identify(options)
    }
}

/// A mistake with its help, as a line.
fn line(mistake: &Diagnostic) -> String {
    let parts = [&mistake.message].into_iter().chain(&mistake.help);
    parts.map(String::as_str).collect::<Vec<_>>().join(": ")
}

/// An error as a line.
pub(super) fn words(why: &Error) -> String {
    match why {
        Error::Spec(mistakes) => {
            let first = mistakes.mistakes().find(|d| d.is_error());
            first.map_or_else(|| mistakes.to_string(), |d| d.message.clone())
        }
        other => other.to_string(),
    }
}
