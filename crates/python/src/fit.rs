//! `Case`, and the results of `run` and `gap` as handles.

use crate::errors::{DataError, raised, spec_error};
use crate::table::{Table, columns, slices};
use phisindy::files::{Purpose, Request, open_text};
use phisindy::{Case, Catalogue, Error, Folder, Format, Gap, Identified, Loaded, Method, Options, Progress};
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Mutex;
use std::time::Instant;

pub(crate) fn add(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add_class::<NativeCase>()?;
    m.add_class::<NativeRun>()?;
    m.add_class::<NativeGap>()
}

/// A checked spec, and its path: its data files are beside it.
#[pyclass(name = "Case", frozen)]
pub(crate) struct NativeCase {
    case: Case,
    path: PathBuf,
}

#[pymethods]
impl NativeCase {
    #[new]
    fn new(py: Python<'_>, text: &str, path: PathBuf) -> PyResult<NativeCase> {
        let case = py.detach(|| Case::read(text)).map_err(|e| spec_error(py, &e))?;
        Ok(NativeCase { case, path })
    }

    fn changed(&self, py: Python<'_>, path: &str, value: &str) -> PyResult<NativeCase> {
        let case = self.case.with(path, value).map_err(|e| raised(py, e))?;
        Ok(NativeCase { case, path: self.path.clone() })
    }

    #[getter]
    fn text(&self) -> &str {
        self.case.text()
    }

    #[getter]
    fn title(&self) -> &str {
        self.case.title()
    }

    #[getter]
    fn states(&self) -> Vec<String> {
        self.case.states().map(str::to_owned).collect()
    }

    #[getter]
    fn inputs(&self) -> Vec<String> {
        self.case.inputs().map(str::to_owned).collect()
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.case.warnings().collect()
    }
}

impl NativeCase {
    pub(crate) fn case(&self) -> &Case {
        &self.case
    }

    /// The case with its records: tables in the place of its files, arrays by the names of states, or what the
    /// spec itself names.
    pub(crate) fn loaded(
        &self,
        py: Python<'_>,
        tables: &[Table<'_>],
        seed: Option<u64>,
        purpose: Purpose,
    ) -> PyResult<Loaded> {
        if tables.is_empty() || self.case.has_files() {
            let tables = tables.iter().map(columns).collect::<PyResult<_>>()?;
            let request = Request { seed, tables, ..Request::default() };
            let (text, path) = (self.case.text(), &self.path);
            return py.detach(|| open_text(text, path, &request, purpose)).map_err(|e| raised(py, e));
        }
        let record = |table: &Table<'_>| {
            let record = self.case.record(&slices(table)?);
            record.map_err(|e| DataError::new_err(e.to_string()))
        };
        let records = tables.iter().map(record).collect::<PyResult<Vec<_>>>()?;
        py.detach(|| Loaded::of(&self.case, &records)).map_err(|e| raised(py, e))
    }
}

/// How a result came about.
struct Work<T> {
    found: T,
    seconds: f64,
}

/// Works without the lock of the interpreter, on so many threads. `progress` is called with a fraction and what is
/// being done; Ctrl-C and its exceptions end the work.
fn work<T: Send>(
    py: Python<'_>,
    jobs: Option<usize>,
    progress: Option<Py<PyAny>>,
    task: impl FnOnce(&(dyn Fn(Progress<'_>) -> ControlFlow<()> + Sync)) -> Result<T, Error> + Send,
) -> PyResult<Work<T>> {
    let begin = Instant::now();
    let stopped: Mutex<Option<PyErr>> = Mutex::new(None);
    let observe = |at: Progress<'_>| {
        let heard = Python::attach(|py| {
            py.check_signals()?;
            match &progress {
                Some(tell) => tell.call1(py, (at.fraction, at.activity)).map(drop),
                None => Ok(()),
            }
        });
        match heard {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                if let Ok(mut stopped) = stopped.lock() {
                    stopped.get_or_insert(error);
                }
                ControlFlow::Break(())
            }
        }
    };
    let found = py.detach(|| match jobs {
        None => Ok(task(&observe)),
        Some(jobs) => {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs).build();
            pool.map(|pool| pool.install(|| task(&observe)))
        }
    });
    if let Some(error) = stopped.into_inner().ok().flatten() {
        return Err(error);
    }
    let found = found.map_err(|e| DataError::new_err(format!("{jobs:?} threads cannot be started: {e}")))?;
    let found = found.map_err(|e| raised(py, e))?;
    Ok(Work { found, seconds: begin.elapsed().as_secs_f64() })
}

fn method(name: Option<&str>) -> PyResult<Option<Method>> {
    match name {
        None => Ok(None),
        Some("step") => Ok(Some(Method::Step)),
        Some("trajectory") => Ok(Some(Method::Trajectory)),
        Some(other) => {
            Err(DataError::new_err(format!("there is no method `{other}`: give `step` or `trajectory`")))
        }
    }
}

fn catalogue(folder: Option<PathBuf>) -> PyResult<Catalogue> {
    let folders: Vec<&std::path::Path> = folder.as_deref().into_iter().collect();
    phisindy::files::catalogue(&folders).map_err(|e| DataError::new_err(e.to_string()))
}

/// What `run` found.
#[pyclass(name = "Run", frozen)]
pub(crate) struct NativeRun(Work<Identified>);

#[pymethods]
impl NativeRun {
    #[new]
    #[pyo3(signature = (case, tables, *, seed=None, method_name=None, jobs=None, progress=None, laws=None))]
    #[expect(clippy::too_many_arguments, reason = "the keywords of `phisindy.run`")]
    fn new(
        py: Python<'_>,
        case: &NativeCase,
        tables: Vec<Table<'_>>,
        seed: Option<u64>,
        method_name: Option<&str>,
        jobs: Option<usize>,
        progress: Option<Py<PyAny>>,
        laws: Option<PathBuf>,
    ) -> PyResult<NativeRun> {
        let (method, laws) = (method(method_name)?, catalogue(laws)?);
        let loaded = case.loaded(py, &tables, seed, Purpose::Run)?;
        drop(tables);
        let found = work(py, jobs, progress, |observe| {
            let observe = |p: Progress<'_>| observe(p);
            let options = Options { method, laws: Some(&laws), observe: Some(&observe) };
            loaded.identify(&options)
        })?;
        Ok(NativeRun(found))
    }

    fn json(&self) -> String {
        self.0.found.written(Format::Json, self.0.seconds)
    }

    fn written(&self, latex: bool) -> String {
        self.0.found.written(if latex { Format::Latex } else { Format::Text }, self.0.seconds)
    }

    fn latex(&self) -> String {
        self.0.found.latex()
    }

    /// Path and text of each file.
    fn files(&self, py: Python<'_>) -> Vec<(String, String)> {
        let Folder { files, .. } = py.detach(|| self.0.found.folder(self.0.seconds));
        files
    }

    /// The text of the identified model.
    fn model(&self, py: Python<'_>) -> PyResult<String> {
        self.0.found.case().map(|case| case.text().to_owned()).map_err(|e| raised(py, e))
    }
}

/// What `gap` found.
#[pyclass(name = "Gap", frozen)]
pub(crate) struct NativeGap(Work<Gap>);

#[pymethods]
impl NativeGap {
    #[new]
    #[pyo3(signature = (case, tables, *, seed=None, jobs=None, progress=None, laws=None))]
    fn new(
        py: Python<'_>,
        case: &NativeCase,
        tables: Vec<Table<'_>>,
        seed: Option<u64>,
        jobs: Option<usize>,
        progress: Option<Py<PyAny>>,
        laws: Option<PathBuf>,
    ) -> PyResult<NativeGap> {
        let laws = catalogue(laws)?;
        let loaded = case.loaded(py, &tables, seed, Purpose::Gap)?;
        drop(tables);
        let found = work(py, jobs, progress, |observe| {
            let observe = |p: Progress<'_>| observe(p);
            loaded.gap(&Options { method: None, laws: Some(&laws), observe: Some(&observe) })
        })?;
        Ok(NativeGap(found))
    }

    fn json(&self) -> String {
        self.0.found.written(Format::Json, self.0.seconds)
    }

    fn written(&self) -> String {
        self.0.found.written(Format::Text, self.0.seconds)
    }

    /// Path and text of each file.
    fn files(&self, py: Python<'_>) -> Vec<(String, String)> {
        let Folder { files, .. } = py.detach(|| self.0.found.folder(self.0.seconds));
        files
    }

    /// The text of the completed model.
    fn model(&self, py: Python<'_>) -> PyResult<String> {
        self.0.found.case().map(|case| case.text().to_owned()).map_err(|e| raised(py, e))
    }
}
