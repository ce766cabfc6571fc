//! From a spec file to a checked case with its records.

use super::columns::Columns;
use super::folders::{self, Folders, Missing, open_plain_file};
use super::laws;
use super::request::{Assignment, Request};
use super::streams::{self, Part};
use super::trends::Trends;
use crate::case;
use crate::error::{Error, SpecError};
use crate::laws::Catalogue;
use crate::loaded::{Laws, Loaded, NotWritten, checked};
use phisindy_expr::Span;
use phisindy_gap::requested_formulas;
use phisindy_import::OPEN_QUESTION;
use phisindy_phys::spec::{ColumnSpec, CsvSpec, InputSpec, Number, Role, Text};
use phisindy_phys::{
    Case, Diagnostic, Note, Origin, Record, RecordPlan, Severity, SourceId, Sources, Table, Units,
    link_continuations, overlaps, suspicions, unit::Unit,
};
use phisindy_signal::{Interpolation, Signal, mean_step, strongest_line};
use phisindy_sim::{SimError, SyntheticError, Trajectory, synthesize};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// What the spec is read for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// All records are needed, and the laws that `unknown` names.
    Run,
    /// All records are needed; the catalogue is searched whatever `unknown` names.
    Gap,
    /// Files are read if they are there; nothing is simulated.
    Check,
    /// Synthetic records, and measured ones if the model has no unknown part and can predict them.
    Simulate,
}

/// Why there is no case, as an exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The spec or its files are wrong.
    Input,
    /// The truth of a synthetic record cannot be simulated.
    Numerics,
}

/// Reads a spec and its records. All diagnostics, errors and warnings, are added to `found`.
///
/// # Errors
/// At least one of the diagnostics is an error.
pub fn load(
    path: &Path,
    request: &Request,
    purpose: Purpose,
    sources: &mut Sources,
    found: &mut Vec<Diagnostic>,
) -> Result<Loaded, Refusal> {
    let text = spec_text(path)
        .and_then(|text| with_assignments(text, &request.assignments, sources))
        .map_err(|d| {
            found.push(d);
            Refusal::Input
        })?;
    load_text(path, text, request, purpose, sources, found)
}

/// The same from a text that was read before; `path` says where its data files are, and its assignments have
/// been spliced in.
///
/// # Errors
/// At least one of the diagnostics is an error.
pub fn load_text(
    path: &Path,
    text: String,
    request: &Request,
    purpose: Purpose,
    sources: &mut Sources,
    found: &mut Vec<Diagnostic>,
) -> Result<Loaded, Refusal> {
    let shown = path.display().to_string();
    let name = if request.assignments.is_empty() { shown.clone() } else { format!("{shown} (after --set)") };
    let source = sources.add(name, text.clone());
    let folders = Folders::new(request, path, &text);
    let given = folders.numbers(&text, source).map_err(|mistakes| {
        found.extend(mistakes);
        Refusal::Input
    })?;
    let (parsed, case) = match checked(&text, source, &given) {
        Ok((parsed, case, warnings)) => {
            found.extend(warnings);
            found.extend(open_questions(&text, source));
            (parsed, case)
        }
        Err(mistakes) => {
            found.extend(mistakes);
            return Err(Refusal::Input);
        }
    };
    // A law with a mistake is told whatever the spec names: its author wants it tried.
    let catalogue = laws::checked_beside(path, request, sources, found);
    let wanted = matches!(purpose, Purpose::Run | Purpose::Check) && !case.searches.is_empty();
    if let Err(mistakes) = if wanted { requested_formulas(&case, source).map(|_| ()) } else { Ok(()) } {
        found.extend(mistakes);
        return Err(Refusal::Input);
    }
    let named = |catalogue: Catalogue| match purpose {
        Purpose::Run | Purpose::Check if !case.laws.is_empty() => {
            Laws::of(&case, &catalogue, source).map(Some)
        }
        _ => Ok(None),
    };
    let laws = catalogue.and_then(named).map_err(|mistakes| {
        found.extend(mistakes);
        Refusal::Input
    })?;
    let mut loader =
        Loader { request, source, folders, sources, found, trends: Trends::default(), suspected: vec![] };
    let (records, truths) = loader.records(&case, purpose)?;
    let given = text.clone();
    let loaded = Loaded { spec: shown, given, text, parsed, case, records, truths, doubts: vec![] };
    match laws {
        Some(laws) => {
            // A check does without the records.
            let records = if purpose == Purpose::Run { loaded.records.clone() } else { vec![] };
            laws.written(loaded, records, sources, found).map_err(|NotWritten| Refusal::Input)
        }
        None => Ok(loaded),
    }
}

/// The questions of a draft that nobody has answered: what the spec says there is a guess.
fn open_questions(text: &str, source: SourceId) -> Vec<Diagnostic> {
    let of_comment = |at: &usize| text[..*at].ends_with("// ");
    let asked = text.match_indices(OPEN_QUESTION).map(|(at, _)| at).filter(of_comment).map(|at| {
        let end = text[at..].find('\n').map_or(text.len(), |length| at + length);
        Diagnostic::warning("a question of this draft is open: what stands for its answer is a guess")
            .at(source, Span::new(at, end), "")
            .help("answer it in the spec, or by an option of `phisindy new`, and delete this line")
    });
    asked.collect()
}

/// Reads a spec and all its records, for [`Loaded::identify`] and [`Loaded::gap`]. What is odd about them is
/// in [`Loaded::doubts`].
///
/// # Errors
/// The spec or one of its files is wrong.
pub fn open(path: &Path, request: &Request) -> Result<Loaded, Error> {
    let (mut sources, mut found) = (Sources::default(), Vec::new());
    match load(path, request, Purpose::Gap, &mut sources, &mut found) {
        Ok(loaded) => Ok(Loaded { doubts: found.into_iter().map(|d| d.message).collect(), ..loaded }),
        Err(Refusal::Input | Refusal::Numerics) => Err(SpecError::new(found, sources).into()),
    }
}

/// Reads a case from a text, and the files that it names beside its records; `path` says where they are.
///
/// # Errors
/// All mistakes of the text and of these files.
pub fn case_of(text: &str, path: &Path, request: &Request) -> Result<case::Case, SpecError> {
    let mut sources = Sources::default();
    let source = sources.add("spec", text);
    match Folders::new(request, path, text).numbers(text, source) {
        Ok(files) => case::Case::read_with(text, &files),
        Err(mistakes) => Err(SpecError::new(mistakes, sources)),
    }
}

/// As [`open`], of a text that was read before, or that is no file: `path` names it in messages, and its data
/// files are looked for beside it.
///
/// # Errors
/// The text or one of its files is wrong.
pub fn open_text(text: &str, path: &Path, request: &Request, purpose: Purpose) -> Result<Loaded, Error> {
    let (mut sources, mut found) = (Sources::default(), Vec::new());
    let loaded = match with_assignments(text.to_owned(), &request.assignments, &mut sources) {
        Ok(text) => load_text(path, text, request, purpose, &mut sources, &mut found),
        Err(d) => {
            found.push(d);
            Err(Refusal::Input)
        }
    };
    match loaded {
        Ok(loaded) => Ok(Loaded { doubts: found.into_iter().map(|d| d.message).collect(), ..loaded }),
        Err(Refusal::Input | Refusal::Numerics) => Err(SpecError::new(found, sources).into()),
    }
}

/// Endings of data files, in small letters.
const DATA: [&str; 21] = [
    "csv", "tsv", "txt", "dat", "asc", "xlsx", "xls", "xlsb", "ods", "mat", "npy", "npz", "tdms", "unv",
    "uff", "uf", "h5", "hdf5", "parquet", "lvm", "log",
];

/// What to say to a data file where a spec is expected; `None` if the name does not end as those of data
/// files do, or if the text begins as a spec does.
fn data_file(path: &Path, bytes: &[u8]) -> Option<Diagnostic> {
    let ending = path.extension()?.to_str()?.to_lowercase();
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(4096)]);
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//"));
    let spec = lines.next().is_some_and(|line| line.starts_with('(') || line.starts_with("#!["));
    let shown = path.display();
    (DATA.contains(&ending.as_str()) && !spec).then(|| {
        let written = path.with_extension("ron");
        let written = written.file_name().map_or_else(|| "case.ron".into(), |name| name.to_string_lossy());
        Diagnostic::error(format!("`{shown}` is a data file, not a spec"))
            .help(format!("`phisindy new {shown} --out {written}` looks at it and writes a spec for it"))
            .help(format!("`phisindy go {shown}` does that and looks for what is missing at once"))
    })
}

/// The text of the spec.
pub fn spec_text(path: &Path) -> Result<String, Diagnostic> {
    let shown = path.display();
    let mut text = start_of(path)
        .map_err(|e| {
            Diagnostic::error(format!("cannot read the spec `{shown}`: {e}")).help(
                "name a text file that exists and that you may read; `phisindy new DATA.csv` writes one",
            )
        })
        .and_then(|bytes| data_file(path, &bytes).map_or(Ok(bytes), Err))
        .and_then(|bytes| {
            let text = String::from_utf8(bytes);
            text.map_err(|_| {
                Diagnostic::error(format!("the spec `{shown}` is not UTF-8 text")).help("save it as UTF-8")
            })
        })?;
    if let Some(rest) = text.strip_prefix('\u{feff}') {
        text = rest.to_owned();
    }
    Ok(text)
}

/// What the reader of specs takes, and a byte more, by which it sees that there is too much.
const LONGEST: u64 = (1 << 20) + 1;

/// The bytes of a plain file, as far as they can be a spec, or of what a shell hands over (`/dev/stdin`, `<(...)`). Of
/// another pipe nobody may ever write the end.
pub fn start_of(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let file = if path.starts_with("/dev") { File::open(path)? } else { open_plain_file(path)? };
    file.take(LONGEST).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text with every assignment spliced in.
pub fn with_assignments(
    mut text: String,
    sets: &[Assignment],
    sources: &mut Sources,
) -> Result<String, Diagnostic> {
    for set in sets {
        text = phisindy_phys::splice::set(&text, &set.path, &set.value).map_err(|e| {
            let whole = format!("{}={}", set.path, set.value);
            let at = whole
                .find(&e.part)
                .map_or(Span::new(0, set.path.len()), |at| Span::new(at, at + e.part.len()));
            let argument = sources.add("--set", whole);
            let near =
                phisindy_expr::nearest(&e.part, e.available.iter().map(String::as_str)).map(str::to_owned);
            let mut d = Diagnostic::error(e.message.clone()).at(argument, at, "");
            d.help.extend(near.map(|near| format!("did you mean `{near}`?")));
            if !e.available.is_empty() {
                d = d.help(format!("there is: {}", e.available.join(", ")));
            }
            d.help("a path is made of fields, keys and indices, as in `data.0.noise=Additive(0.02)`")
        })?;
    }
    Ok(text)
}

struct Loader<'a> {
    request: &'a Request,
    source: SourceId,
    folders: Folders,
    sources: &'a mut Sources,
    found: &'a mut Vec<Diagnostic>,
    trends: Trends,
    suspected: Vec<Suspected>,
}

/// What is odd about one or more records.
struct Suspected {
    /// Of its diagnostic in [`Loader::found`].
    place: usize,
    records: Vec<String>,
    words: String,
}

impl Suspected {
    fn message(&self) -> String {
        format!("{}: {}", self.records.join(", "), self.words)
    }
}

type Records = (Vec<Record>, Vec<Option<Trajectory>>);

impl<'r> Loader<'r> {
    fn records(&mut self, case: &Case, purpose: Purpose) -> Result<Records, Refusal> {
        let (mut records, mut truths, mut plans) = (vec![], vec![], vec![]);
        let mut refusal = None;
        let tables = self.tables(case)?;
        for (index, plan) in case.records.iter().enumerate() {
            let made = match (&plan.origin, purpose) {
                (Origin::Csv(_), Purpose::Simulate) if case.is_open() => continue,
                (Origin::Synthetic(_), Purpose::Check) => continue,
                (Origin::Csv(csv), _) => self
                    .measured(plan, csv, tables[index], case, purpose)
                    .map(|record| record.map(|r| (r, None))),
                (Origin::Synthetic(_), _) => {
                    self.synthetic(index, plan, case).map(|(r, truth)| Some((r, Some(truth))))
                }
            };
            match made {
                Ok(Some((record, truth))) => {
                    records.push(record);
                    truths.push(truth);
                    plans.push(plan.clone());
                }
                Ok(None) => {}
                Err(why) => refusal = refusal.or(Some(why)),
            }
        }
        link_continuations(&case.system, &mut records, &plans);
        for overlap in overlaps(&case.system, &records, &plans) {
            let help = "let the window of one begin where that of the other ends, or take another file to validate on";
            self.push(Diagnostic::warning(overlap.to_string()).help(help));
        }
        if purpose == Purpose::Check && case.records.iter().all(|plan| plan.role == Role::Validate) {
            self.push(
                Diagnostic::error("no record has the role Fit")
                    .help("there is nothing to identify from: take `role: Validate` off one of them"),
            );
            refusal = refusal.or(Some(Refusal::Input));
        }
        refusal.map_or(Ok((records, truths)), Err)
    }

    /// For each record the table in the place of its file: one for each measured record, or one for each
    /// file.
    fn tables(&mut self, case: &Case) -> Result<Vec<Option<&'r Columns>>, Refusal> {
        let given = &self.request.tables;
        let mut files: Vec<&str> = Vec::new();
        let mut all = vec![None; case.records.len()];
        let mut measured = 0;
        for (place, plan) in all.iter_mut().zip(&case.records) {
            let Origin::Csv(csv) = &plan.origin else { continue };
            let path = csv.path.value.as_str();
            let file = files.iter().position(|f| *f == path).unwrap_or_else(|| {
                files.push(path);
                files.len() - 1
            });
            *place = Some((measured, file));
            measured += 1;
        }
        if !given.is_empty() && given.len() != measured && given.len() != files.len() {
            let message = format!(
                "{} tables are given for {measured} measured records of {} files",
                given.len(),
                files.len()
            );
            let d = Diagnostic::error(message);
            self.push(
                d.help("give a table for each record with a file, or one for each file, in their order"),
            );
            return Err(Refusal::Input);
        }
        let by_record = given.len() == measured;
        let table = |(record, file): (usize, usize)| given.get(if by_record { record } else { file });
        Ok(all.into_iter().map(|place| place.and_then(table)).collect())
    }

    /// Warns of something odd about a record; what several records share is one warning.
    fn warn_of(&mut self, record: &str, words: String) {
        match self.suspected.iter_mut().find(|s| s.words == words) {
            Some(shared) => {
                shared.records.push(record.to_owned());
                self.found[shared.place].message = shared.message();
            }
            None => {
                let records = vec![record.to_owned()];
                let new = Suspected { place: self.found.len(), records, words };
                self.found.push(Diagnostic::warning(new.message()));
                self.suspected.push(new);
            }
        }
    }

    fn push(&mut self, diagnostic: Diagnostic) {
        // Two records of one file have the same mistakes.
        if !self.found.iter().any(|d| d.message == diagnostic.message && d.help == diagnostic.help) {
            self.found.push(diagnostic);
        }
    }

    /// A record from a file; none if `check` may do without.
    fn measured(
        &mut self,
        plan: &RecordPlan,
        csv: &CsvSpec,
        table: Option<&Columns>,
        case: &Case,
        purpose: Purpose,
    ) -> Result<Option<Record>, Refusal> {
        if csv.in_memory {
            let message = format!("record `{}` is arrays of another program, not a file", plan.name);
            let d = Diagnostic::error(message).at(self.source, csv.span, "");
            self.push(d.help("name a file: `Csv(path: \"run.csv\", ...)`"));
            return Err(Refusal::Input);
        }
        let units = Units::of(csv, &case.system);
        let parts = streams::parts(csv, &units, &case.system);
        let mut places = vec![];
        for Part { csv, .. } in parts.iter().filter(|_| table.is_none()) {
            match self.folders.find(&csv.path.value, self.source, csv.path.span) {
                Ok(path) => places.push(path),
                Err(Missing::Nowhere(mut d)) if purpose == Purpose::Check && !self.folders.given => {
                    d.severity = Severity::Warning;
                    self.push(d);
                    return Ok(None);
                }
                Err(missing) => {
                    self.push(missing.diagnostic());
                    return Err(Refusal::Input);
                }
            }
        }
        let mut rows = |csv: &CsvSpec| {
            let parts = streams::parts(csv, &units, &case.system);
            let mut read = |k: usize, Part { csv, units, .. }: &Part| match table {
                Some(table) => table.read(csv, units, self.source, self.sources),
                None => folders::read(csv, units, &places[k], self.source, self.sources),
            };
            let tables =
                parts.iter().enumerate().map(|(k, part)| read(k, part)).collect::<Result<Vec<_>, _>>()?;
            streams::joined(csv, &parts, tables, self.source)
        };
        let mut read = rows(csv);
        let rescaled = read.as_ref().ok().and_then(|(table, _)| in_the_unit_of_time(csv, &units, table));
        if let Some(rescaled) = &rescaled {
            read = rows(rescaled);
            self.push(told_unit(csv, rescaled, self.source));
        }
        let csv = rescaled.as_ref().unwrap_or(csv);
        let record = read.and_then(|(mut table, warnings)| {
            warnings.into_iter().chain(beyond_the_end(csv, &table, self.source)).for_each(|d| self.push(d));
            let done = self.trends.take_off(csv, &units, &mut table);
            let mut record = Record::from_table(plan, &table, &case.system, self.source)?;
            record.notes.extend(omission(csv, &table));
            let decimated = decimation(csv, &record);
            record.notes.extend(decimated);
            record.notes.extend(done);
            Ok(record)
        });
        if let Ok(record) = &record {
            for suspicion in suspicions(&case.system, record) {
                self.warn_of(&record.name, suspicion.to_string());
            }
            for beyond in case.system.beyond_tables(record) {
                self.warn_of(&record.name, beyond);
            }
        }
        record.map(Some).map_err(|mistakes| {
            mistakes.into_iter().for_each(|d| self.push(d));
            Refusal::Input
        })
    }

    fn synthetic(
        &mut self,
        index: usize,
        plan: &RecordPlan,
        case: &Case,
    ) -> Result<(Record, Trajectory), Refusal> {
        let Origin::Synthetic(truth) = &plan.origin else { return Err(Refusal::Input) };
        // Records of one spec must not repeat each other's noise.
        let seed = self
            .request
            .seed
            .map(|seed| seed.wrapping_add((index as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)));
        let mistakes = std::cell::RefCell::new(Vec::new());
        let (folders, source) = (&self.folders, self.source);
        let sources = std::cell::RefCell::new(&mut *self.sources);
        let file = |input: &InputSpec| {
            input_file(input, folders, source, &mut sources.borrow_mut()).map_err(|found| {
                let message = found.first().map_or(String::new(), |d| d.message.clone());
                mistakes.borrow_mut().extend(found);
                message
            })
        };
        let made = synthesize(plan, truth, &case.system, seed, &file);
        let mistakes = mistakes.into_inner();
        made.map_err(|error| {
            let help = match &error {
                SyntheticError::Simulation(SimError::TooManyEvents { .. }) => {
                    Some("a friction may push there: one that is less at rest than in motion, or `rest` without a sign")
                }
                SyntheticError::Simulation(_) => {
                    Some("`known` and `truth` may grow without bound, or divide by zero, from this start")
                }
                _ => None,
            };
            if mistakes.is_empty() {
                let d = Diagnostic::error(format!("record `{}`: {error}", plan.name));
                self.push(help.iter().fold(d, |d, help| d.help(*help)));
            }
            mistakes.into_iter().for_each(|d| self.push(d));
            if help.is_some() { Refusal::Numerics } else { Refusal::Input }
        })
    }
}

/// The record with its window in seconds, where it was written in the unit of the time: taken as seconds it
/// would keep all rows or none, in that unit it keeps some, and its length is nearer to that of the file.
fn in_the_unit_of_time(csv: &CsvSpec, units: &Units, table: &Table) -> Option<CsvSpec> {
    let ((first, last), (from, to)) = (table.extent?, csv.window.as_ref()?);
    let cuts = |factor: f64| {
        let (from, to) = (factor * from.value, factor * to.value);
        from < last && to > first && (from > first || to < last)
    };
    let off = |factor: f64| (factor * (to.value - from.value) / (last - first)).ln().abs();
    let factor = units.time.factor;
    (factor != 1.0 && !cuts(1.0) && cuts(factor) && off(factor) < off(1.0)).then(|| {
        let seconds = |at: &Number| Number { value: at.value * factor, ..at.clone() };
        CsvSpec { window: Some((seconds(from), seconds(to))), ..csv.clone() }
    })
}

fn told_unit(csv: &CsvSpec, taken: &CsvSpec, source: SourceId) -> Diagnostic {
    let window = |of: &CsvSpec| of.window.as_ref().map_or((0.0, 0.0), |(a, b)| (a.value, b.value));
    let ((a, b), (from, to)) = (window(csv), window(taken));
    let unit = csv.time.unit.as_ref().map_or("", |u| u.value.as_str());
    let span = csv.window.as_ref().map_or(csv.span, |(a, b)| a.span.to(b.span));
    Diagnostic::warning(format!(
        "the window of `{}` is taken in {unit}, as its time is: {a} to {b} {unit} are {from} to {to} s",
        csv.path.value
    ))
    .at(source, span, "would keep all rows or none, in seconds")
    .help(format!("a window is in seconds: write ({from:?}, {to:?})"))
}

/// A warning where a window goes on after its file has ended: the file may have been longer.
fn beyond_the_end(csv: &CsvSpec, table: &Table, source: SourceId) -> Option<Diagnostic> {
    let ((start, end), (_, last)) = (csv.window.as_ref()?, table.extent?);
    let missing = end.value - last;
    // The window of a record that is whole often ends half a step behind it.
    let told = table.time.len() >= 2 && missing > 0.02 * (end.value - start.value);
    let message = format!(
        "the window goes on to {} s, but the time in `{}` ends at {last} s",
        end.value, csv.path.value
    );
    let d = || {
        Diagnostic::warning(message).at(source, start.span.to(end.span), "goes on after the end of the file")
    };
    told.then(|| {
        let d = d().help(format!("if the file is whole, end the window there: ({}, {last})", start.value));
        match &csv.time.unit {
            Some(unit) if unit.value != "s" => d.help("a window is in seconds, whatever the unit of `time`"),
            _ => d,
        }
    })
}

/// What `missing: Omit` did.
fn omission(csv: &CsvSpec, table: &Table) -> Option<Note> {
    let gap = table.time.windows(2).map(|t| t[1] - t[0]).fold(0.0, f64::max);
    let (path, omitted, kept) = (csv.path.value.clone(), table.omitted, table.time.len());
    (omitted > 0).then_some(Note::Omitted { path, omitted, kept, gap })
}

/// What `decimate` did.
fn decimation(csv: &CsvSpec, record: &Record) -> Option<Note> {
    let rows = csv.decimate.as_ref().map(|d| d.value).filter(|n| *n > 1)?;
    // A mean over a stretch takes (pi f stretch)^2/6 off a sine.
    let lost = |k: usize| {
        let (time, values) = record.own_column(k)?;
        let line = strongest_line(&time, &values)?;
        Some((std::f64::consts::PI * line.frequency * mean_step(&time)).powi(2) / 6.0)
    };
    let loss = (0..record.columns.len()).filter_map(lost).fold(0.0, f64::max);
    Some(Note::Decimated { path: csv.path.value.clone(), rows, loss: Some(loss).filter(|loss| *loss > LOSS) })
}

/// A mean of rows that takes more than this off the amplitude is told.
const LOSS: f64 = 0.003;

/// An input of a synthetic record that is given as a file.
fn input_file(
    input: &InputSpec,
    folders: &Folders,
    source: SourceId,
    sources: &mut Sources,
) -> Result<Signal, Vec<Diagnostic>> {
    let InputSpec::File { path, time, column } = input else {
        return Err(vec![Diagnostic::error("this input is not a file")]);
    };
    let found = folders.find(&path.value, source, path.span).map_err(|m| vec![m.diagnostic()])?;
    let csv = column_of(path, time, column);
    let unit = |c: &ColumnSpec| c.unit.as_ref().and_then(|u| Unit::parse(&u.value).ok()).unwrap_or(Unit::ONE);
    let units = Units { time: unit(time), columns: vec![unit(column)] };
    let (table, _) = folders::read(&csv, &units, &found, source, sources)?;
    let (times, values) = (table.time.into(), table.columns.concat());
    Signal::new(times, values, Interpolation::Cubic).map_err(|e| {
        vec![Diagnostic::error(format!("`{}` is no input: {e}", path.value)).at(source, path.span, "")]
    })
}

/// A plain file with one column, in the form that records have.
fn column_of(path: &Text, time: &ColumnSpec, column: &ColumnSpec) -> CsvSpec {
    CsvSpec {
        path: path.clone(),
        in_memory: false,
        any_format: true,
        sheet: None,
        name: None,
        time: time.clone(),
        rate: None,
        columns: vec![(column.header.clone(), column.clone())],
        streams: vec![],
        derive: vec![],
        sensors: vec![],
        rows: vec![],
        window: None,
        start: vec![],
        role: Role::Fit,
        separator: None,
        decimal: None,
        header: None,
        skip: 0,
        run: None,
        interpolate: vec![],
        constants: vec![],
        decimate: None,
        omits_missing: false,
        detrend: vec![],
        span: path.span,
    }
}
