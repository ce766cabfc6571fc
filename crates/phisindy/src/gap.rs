//! The search of the catalogue: which laws a model lacks.

use crate::case::Case;
use crate::error::Error;
use crate::laws::Catalogue;
use crate::loaded::Loaded;
use crate::options::{Options, Progress};
use crate::record::Record;
use phisindy_gap::{self as workflow, Activity, Standing, Status, Step};
use phisindy_report::{Ending, Folder, Format, GapReport, Invocation, StopReason};
use phisindy_report::{Shown, equations};

/// Finds where a model and its records disagree, names the laws of the catalogue that are missing, and adds
/// them. Candidates and laws in `unknown` are
/// left out.
///
/// # Errors
/// A record makes no sense with the case, or the model cannot be simulated. That no law explains the records
/// is a status, not an error.
pub fn gap(case: &Case, records: &[Record], options: &Options<'_>) -> Result<Gap, Error> {
    Loaded::of(case, records)?.gap(options)
}

impl Loaded {
    /// As [`gap`].
    ///
    /// # Errors
    /// As [`gap`].
    pub fn gap(self, options: &Options<'_>) -> Result<Gap, Error> {
        self.comparable()?;
        let laws = options.laws.cloned().unwrap_or_else(Catalogue::built_in);
        let mut observe = |fraction: f64, activity: Activity| {
            let gap = match &activity {
                Activity::Fitting { best: Some(best), .. } => Some(best.gap),
                Activity::Screening(round)
                | Activity::Comparing { round, .. }
                | Activity::Fitting { round, .. } => Some(round.gap),
                _ => None,
            };
            let gap = gap.filter(|gap| gap.is_finite() && *gap > 0.0);
            options.tell(Progress { fraction, activity: &activity.to_string(), gap })
        };
        let (case, records) = (self.case.clone(), self.records.clone());
        let result = workflow::gap(&self.text, case, records, laws.laws(), &mut observe)?;
        Ok(Gap { result, loaded: self, laws })
    }
}

impl Loaded {
    /// How the model does as it is.
    pub(crate) fn standing(&self) -> Result<Standing, Error> {
        self.comparable()?;
        Ok(workflow::standing(self.parsed.clone(), self.case.clone(), self.records.clone())?)
    }
}

/// What the search found. A gap is the rms of the residual of a free run in units of the noise: 1 is perfect.
pub struct Gap {
    pub(crate) result: workflow::Gap,
    loaded: Loaded,
    laws: Catalogue,
}

impl Gap {
    /// How it ended.
    pub fn status(&self) -> Status {
        self.result.status
    }

    /// The laws that were added, in their order.
    pub fn steps(&self) -> &[Step] {
        &self.result.steps
    }

    /// Laws that helped a little before the search gave up.
    pub fn partial(&self) -> &[Step] {
        &self.result.partial
    }

    /// The gap of the model as it was, on the fitted records and on those kept for validation.
    pub fn before(&self) -> (f64, Option<f64>) {
        self.result.before
    }

    /// The gap of the completed model.
    pub fn after(&self) -> (f64, Option<f64>) {
        self.result.after
    }

    /// What a careful reader should know of the text, the records and the result.
    pub fn warnings(&self) -> Vec<String> {
        let found = self.result.warnings.iter().map(ToString::to_string);
        self.loaded.doubts.iter().cloned().chain(found).collect()
    }

    /// Whether the observer stopped the work before its end.
    pub fn stopped(&self) -> bool {
        self.result.interrupted()
    }

    /// The result as `phisindy gap` prints it; the work took so many seconds.
    pub fn written(&self, format: Format, seconds: f64) -> String {
        self.report(seconds, StopReason::Interrupt).written(format)
    }

    /// The files that `phisindy gap --out` keeps.
    pub fn folder(&self, seconds: f64) -> Folder {
        self.folder_of(seconds, &Invocation::default(), StopReason::Interrupt)
    }

    /// The same of a command line, which the report shows as what repeats it; if the observer stopped the work, it
    /// says why.
    pub fn folder_of(&self, seconds: f64, how: &Invocation, why: StopReason) -> Folder {
        Folder::of_gap(&self.report(seconds, why), how)
    }

    /// Each measured column of each record beside what the model says of it, in the units of the spec.
    pub fn shown(&self) -> Vec<Shown> {
        self.report(0.0, StopReason::Interrupt).shown()
    }

    fn report(&self, seconds: f64, why: StopReason) -> GapReport<'_> {
        let stopped = self.stopped().then_some(why);
        let ending = Ending { seconds, stopped };
        let (input, catalogue) = (self.loaded.input(), self.laws.laws());
        GapReport { input, gap: &self.result, catalogue, planned: None, ending }
    }

    /// The equations of the model with the laws written into it, with their numbers, in LaTeX, a line for
    /// each.
    ///
    /// # Errors
    /// As of [`Gap::case`].
    pub fn latex(&self) -> Result<String, Error> {
        let found = equations(&self.case()?.checked, &[], &self.result.parameters);
        Ok(found.into_iter().map(|equation| equation.latex).collect::<Vec<_>>().join("\n"))
    }

    /// The model with the laws written into it.
    ///
    /// # Errors
    /// The text has a mistake, which is one of this library.
    pub fn case(&self) -> Result<Case, Error> {
        Ok(Case::read_with(&self.result.completed, &self.loaded.parsed.files)?)
    }
}
