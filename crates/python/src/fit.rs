//! `Case`, and the results of `run` and `gap` as handles.

use crate::errors::{DataError, Failure, raised, spec_error};
use crate::table::{Slices, Table, columns, slices};
use crate::work::{Observe, Stop, worked};
use numpy::{PyArray1, ToPyArray};
use phisindy::files::{
    self, FolderError, Naming, Purpose, Request, ResultFolder, case_of, law_files, named_files, open_text,
};
use phisindy::{
    Case, Catalogue, Error, Folder, Format, Gap, Identified, Loaded, Method, Options, RecordError, Shown,
};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::time::Instant;

pub(crate) fn add(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add_class::<NativeCase>()?;
    m.add_class::<NativeRun>()?;
    m.add_class::<NativeGap>()?;
    m.add_function(wrap_pyfunction!(compare, m)?)?;
    m.add_function(wrap_pyfunction!(machine, m)?)?;
    m.add_function(wrap_pyfunction!(machine_files, m)?)?;
    m.add_function(wrap_pyfunction!(fleet_of, m)?)?;
    m.add_function(wrap_pyfunction!(next_run, m)?)?;
    m.add_function(wrap_pyfunction!(save, m)?)
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
        let case = py.detach(|| case_of(text, &path, &Request::default()));
        let case = case.map_err(|e| spec_error(py, &e))?;
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

    /// Headings of the files that the spec names; none where it names no files.
    #[getter]
    fn headings(&self) -> Option<Vec<String>> {
        self.case.has_files().then(|| self.case.headings().map(str::to_owned).collect())
    }

    /// Names of states, outputs and inputs, each with how many SI units the unit of the spec is.
    #[getter]
    fn factors(&self) -> Vec<(String, f64)> {
        self.case.factors().map(|(name, factor)| (name.to_owned(), factor)).collect()
    }

    /// Whether a record is synthetic, so that a seed makes a difference and the truth is known.
    #[getter]
    fn synthetic(&self) -> bool {
        self.case.has_synthetic()
    }

    /// The files that a result depends on: data unless tables stand in their place, and laws, those of a folder too.
    fn files(&self, py: Python<'_>, tables: bool, laws: Option<PathBuf>) -> Vec<PathBuf> {
        let request = Request { further_data: further_data(py), laws, ..Request::default() };
        let data = if tables { vec![] } else { named_files(self.case.text(), &self.path, &request) };
        data.into_iter().map(|(_, path)| path).chain(law_files(&self.path, &request)).collect()
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

    /// The case with its records: tables in the place of its files, arrays by the names of states, or what
    /// the spec itself names.
    pub(crate) fn loaded(
        &self,
        tables: &[Slices<'_>],
        seed: Option<u64>,
        purpose: Purpose,
        further_data: Option<PathBuf>,
    ) -> Result<Loaded, Error> {
        // Of a record that was a table, the text has the name alone.
        if tables.is_empty() && !self.case.has_files() && !self.case.has_synthetic() {
            return Err(RecordError::NoRecords.into());
        }
        if tables.is_empty() || self.case.has_files() {
            let tables = tables.iter().map(|table| columns(table)).collect();
            let request =
                Request { seed, tables, further_data, naming: Naming::Variable, ..Request::default() };
            return open_text(self.case.text(), &self.path, &request, purpose);
        }
        let records = tables.iter().map(|table| self.case.record(table)).collect::<Result<Vec<_>, _>>()?;
        Loaded::of(&self.case, &records)
    }
}

/// The folder that the command looks in for data files too. The interpreter's lock is held, so that nobody
/// changes the environment meanwhile.
pub(crate) fn further_data(_: Python<'_>) -> Option<PathBuf> {
    std::env::var_os("PHISINDY_DATA").filter(|folder| !folder.is_empty()).map(PathBuf::from)
}

/// How a result came about.
struct Work<T> {
    found: T,
    seconds: f64,
}

/// Loads a case with its tables and works on it.
fn found<T: Send>(
    py: Python<'_>,
    (case, tables, seed): (&NativeCase, &[Table<'_>], Option<u64>),
    (purpose, jobs, progress, stop): (Purpose, Option<usize>, Option<Py<PyAny>>, Option<&Stop>),
    task: impl FnOnce(Loaded, &Observe<'_>) -> Result<T, Error> + Send,
) -> PyResult<Work<T>> {
    let slices = tables.iter().map(slices).collect::<PyResult<Vec<_>>>()?;
    let (begin, folder) = (Instant::now(), further_data(py));
    let found = worked(py, jobs, progress.as_ref(), stop, |observe| {
        let loaded = case.loaded(&slices, seed, purpose, folder).map_err(Failure::Loading)?;
        task(loaded, observe).map_err(Failure::Working)
    })?;
    let found = found.map_err(|failure| failure.raised(py, !tables.is_empty()))?;
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

/// The laws of the program with those of a folder; none given: the library takes its own, where it needs
/// them.
fn catalogue(folder: Option<PathBuf>) -> PyResult<Option<Catalogue>> {
    let all = folder.map(|folder| phisindy::files::catalogue(&[&folder]));
    all.transpose().map_err(|e| DataError::new_err(e.to_string()))
}

/// Sets specs or results beside each other: the text, and path and text of each file.
#[pyfunction]
#[pyo3(signature = (paths, *, data=None, laws=None, jobs=None, progress=None, stop=None))]
fn compare(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    data: Option<PathBuf>,
    laws: Option<PathBuf>,
    jobs: Option<usize>,
    progress: Option<Py<PyAny>>,
    stop: Option<&Stop>,
) -> PyResult<(String, Vec<(String, String)>)> {
    let request = comparing(py, data, laws);
    let compared = worked(py, jobs, progress.as_ref(), stop, |observe| {
        let report =
            files::compare(&paths, &request, &Options { observe: Some(observe), ..Options::default() })?;
        Ok((report.written(Format::Text), Folder::of_comparison(&report, &[]).files))
    });
    compared?.map_err(DataError::new_err::<String>)
}

/// Judges a machine of a fleet, the first of which is named too: a line for `fleet_of`.
#[pyfunction]
#[pyo3(signature = (path, first, *, data=None, laws=None, jobs=None, stop=None))]
fn machine(
    py: Python<'_>,
    path: PathBuf,
    first: PathBuf,
    data: Option<PathBuf>,
    laws: Option<PathBuf>,
    jobs: Option<usize>,
    stop: Option<&Stop>,
) -> PyResult<String> {
    let request = comparing(py, data, laws);
    let found = worked(py, jobs, None, stop, |observe| {
        files::machine(&path, &first, &request, &Options { observe: Some(observe), ..Options::default() })
    });
    found?.map_err(DataError::new_err::<String>)
}

/// The files that such a line depends on.
#[pyfunction]
#[pyo3(signature = (path, first, *, data=None, laws=None))]
fn machine_files(
    py: Python<'_>,
    path: PathBuf,
    first: PathBuf,
    data: Option<PathBuf>,
    laws: Option<PathBuf>,
) -> PyResult<Vec<PathBuf>> {
    files::machine_files(&path, &first, &comparing(py, data, laws)).map_err(DataError::new_err::<String>)
}

/// Sets machines beside each other: the text, and path and text of each file.
#[pyfunction]
fn fleet_of(py: Python<'_>, machines: Vec<String>) -> PyResult<(String, Vec<(String, String)>)> {
    let compared = py.detach(|| {
        let report = files::fleet_of(machines.iter().map(String::as_str))?;
        Ok((report.written(Format::Text), Folder::of_comparison(&report, &[]).files))
    });
    compared.map_err(DataError::new_err::<String>)
}

/// What a comparison is asked for.
fn comparing(py: Python<'_>, data: Option<PathBuf>, laws: Option<PathBuf>) -> Request {
    Request { data, further_data: further_data(py), laws, naming: Naming::Variable, ..Request::default() }
}

/// Designs the next run: the text, and path and text of each file.
#[pyfunction]
#[pyo3(signature = (path, *, narrow=None, data=None, laws=None, jobs=None, progress=None, stop=None))]
#[expect(clippy::too_many_arguments, reason = "the keywords of `phisindy.next`")]
fn next_run(
    py: Python<'_>,
    path: PathBuf,
    narrow: Option<&str>,
    data: Option<PathBuf>,
    laws: Option<PathBuf>,
    jobs: Option<usize>,
    progress: Option<Py<PyAny>>,
    stop: Option<&Stop>,
) -> PyResult<(String, Vec<(String, String)>)> {
    let request = comparing(py, data, laws);
    let found = worked(py, jobs, progress.as_ref(), stop, |observe| {
        let options = Options { observe: Some(observe), ..Options::default() };
        let report = files::next(&path, narrow, &request, &options)?;
        Ok((report.written(Format::Text), report.folder(&[]).files))
    });
    found?.map_err(DataError::new_err::<String>)
}

/// Puts the files of a result, path and text of each, into a folder.
#[pyfunction]
fn save(files: Vec<(String, String)>, folder: PathBuf, force: bool) -> PyResult<()> {
    let place = ResultFolder::prepare(&folder, None, force).map_err(|why| {
        let allowed = if matches!(why, FolderError::Occupied(_)) { ", or `force=True`" } else { "" };
        DataError::new_err(format!("cannot write a result: {why}: give another folder{allowed}"))
    })?;
    let cannot = |why| DataError::new_err(format!("cannot write the folder `{}`: {why}", folder.display()));
    place.put(&Folder { files, lacks: None }).map(drop).map_err(cannot)
}

/// Record, column, unit, times, what was measured, the free run of the model.
type ShownRow<'py> = (String, String, String, Values<'py>, Values<'py>, Values<'py>);
type Values<'py> = Bound<'py, PyArray1<f64>>;

fn row<'py>(py: Python<'py>, shown: &Shown) -> ShownRow<'py> {
    let [time, measured, model] = [&shown.time, &shown.measured, &shown.model].map(|all| all.to_pyarray(py));
    (shown.record.clone(), shown.column.clone(), shown.unit.clone(), time, measured, model)
}

/// What `run` found.
#[pyclass(name = "Run", frozen)]
pub(crate) struct NativeRun(Work<Identified>);

#[pymethods]
impl NativeRun {
    #[new]
    #[pyo3(signature = (
        case, tables, *, seed=None, method_name=None, jobs=None, progress=None, laws=None, stop=None
    ))]
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
        stop: Option<&Stop>,
    ) -> PyResult<NativeRun> {
        let (method, laws) = (method(method_name)?, catalogue(laws)?);
        let how = (Purpose::Run, jobs, progress, stop);
        let found = found(py, (case, &tables, seed), how, |loaded, observe| {
            loaded.identify(&Options { method, laws: laws.as_ref(), observe: Some(observe) })
        })?;
        Ok(NativeRun(found))
    }

    fn json(&self) -> String {
        self.0.found.written(Format::Json, self.0.seconds)
    }

    fn written(&self) -> String {
        self.0.found.written(Format::Text, self.0.seconds)
    }

    fn latex(&self) -> String {
        self.0.found.latex()
    }

    /// Each measured column beside what the model says of it.
    fn shown<'py>(&self, py: Python<'py>) -> Vec<ShownRow<'py>> {
        let all = py.detach(|| self.0.found.shown());
        all.iter().map(|one| row(py, one)).collect()
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
    #[pyo3(signature = (
        case, tables, *, seed=None, jobs=None, progress=None, laws=None, stop=None
    ))]
    #[expect(clippy::too_many_arguments, reason = "the keywords of `phisindy.gap`")]
    fn new(
        py: Python<'_>,
        case: &NativeCase,
        tables: Vec<Table<'_>>,
        seed: Option<u64>,
        jobs: Option<usize>,
        progress: Option<Py<PyAny>>,
        laws: Option<PathBuf>,
        stop: Option<&Stop>,
    ) -> PyResult<NativeGap> {
        let laws = catalogue(laws)?;
        let how = (Purpose::Gap, jobs, progress, stop);
        let found = found(py, (case, &tables, seed), how, |loaded, observe| {
            loaded.gap(&Options { method: None, laws: laws.as_ref(), observe: Some(observe) })
        })?;
        Ok(NativeGap(found))
    }

    fn json(&self) -> String {
        self.0.found.written(Format::Json, self.0.seconds)
    }

    fn written(&self) -> String {
        self.0.found.written(Format::Text, self.0.seconds)
    }

    /// The equations of the completed model.
    fn latex(&self, py: Python<'_>) -> PyResult<String> {
        self.0.found.latex().map_err(|e| raised(py, e))
    }

    /// Each measured column beside what the model says of it.
    fn shown<'py>(&self, py: Python<'py>) -> Vec<ShownRow<'py>> {
        let all = py.detach(|| self.0.found.shown());
        all.iter().map(|one| row(py, one)).collect()
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
