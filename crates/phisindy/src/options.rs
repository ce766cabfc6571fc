//! What the caller decides beside the spec.

use crate::laws::Catalogue;
use phisindy_phys::spec::Method;
use std::fmt;
use std::ops::ControlFlow;

/// Options of [`crate::identify`] and [`crate::gap`]; the default is what the command line does.
///
/// ```
/// use phisindy::{Method, Options, Progress};
/// use std::ops::ControlFlow;
/// let observe = |progress: Progress<'_>| {
///     println!("{:.0} % {}", 100.0 * progress.fraction, progress.activity);
///     ControlFlow::Continue(())
/// };
/// let options = Options { method: Some(Method::Step), observe: Some(&observe), ..Options::default() };
/// # assert!(options.laws.is_none());
/// ```
#[derive(Clone, Copy, Default)]
pub struct Options<'a> {
    /// How to identify, in place of the spec's `learn.method`.
    pub method: Option<Method>,
    /// The laws to choose from; none: [`Catalogue::built_in`].
    pub laws: Option<&'a Catalogue>,
    /// Hears of the progress, and may stop the work, which then returns what it has.
    pub observe: Option<&'a Observer<'a>>,
}

/// Is told of the progress, from any thread; `Break` stops the work.
pub type Observer<'a> = dyn Fn(Progress<'_>) -> ControlFlow<()> + Sync + 'a;

/// How far the work is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress<'a> {
    /// The finished part, from 0 to 1.
    pub fraction: f64,
    /// What is being done; may be empty.
    pub activity: &'a str,
    /// The gap of the best model so far, where the work is a search that knows one.
    pub gap: Option<f64>,
}

impl Options<'_> {
    /// Tells the observer, if there is one.
    pub(crate) fn progress(&self, fraction: f64, activity: &str) -> ControlFlow<()> {
        self.tell(Progress { fraction, activity, gap: None })
    }

    /// Tells all of it to the observer, if there is one.
    pub(crate) fn tell(&self, progress: Progress<'_>) -> ControlFlow<()> {
        self.observe.map_or(ControlFlow::Continue(()), |observe| observe(progress))
    }
}

impl fmt::Debug for Options<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Options")
            .field("method", &self.method)
            .field("laws", &self.laws)
            .finish_non_exhaustive()
    }
}
