//! `phisindy new`: writes a commented spec for a data file, or for a robot of URDF or MJCF.

mod robot;

use crate::args::{NewArgs, Options};
use crate::progress::Progress;
use crate::terminal::{INPUT, look, print, quoted, remark};
use crate::{draw, outdir};
use anyhow::{Result, anyhow};
use phisindy_expr::Span;
use phisindy_import::{
    Answers, DataFile, Draft, Question, Table, accepted, next_step, spec_text_of, summary, table, unreadable,
};
use phisindy_phys::{Diagnostic, SourceId, Sources, spec};
use phisindy_report::{Look, sketch};
use std::cell::RefCell;
use std::fs::File;
use std::io::{self, IsTerminal, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Writes a spec for a data file and returns the exit code.
///
/// # Errors
/// The spec cannot be written.
pub(crate) fn command(args: &NewArgs, options: &Options) -> Result<u8> {
    written(args, options, Purpose::Draft)
}

/// The text of a robot, if the file is of one.
///
/// # Errors
/// As a robot it is too large, or no UTF-8.
pub(crate) fn robot_text(path: &Path) -> Result<Option<String>> {
    robot::text(path)
}

/// What a draft is written for.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Purpose {
    /// To be looked at: `new`.
    Draft,
    /// To be searched at once: `go`. Where questions are open it is not written, and they are asked.
    Search,
}

/// The same for a purpose.
///
/// # Errors
/// The spec cannot be written.
pub(crate) fn written(args: &NewArgs, options: &Options, purpose: Purpose) -> Result<u8> {
    let out = options.out.as_deref().filter(|out| *out != Path::new("-"));
    // Checked before any work: an existing spec may contain hours of edits.
    if let Some(out) = out {
        if out.is_dir() {
            return Err(anyhow!(
                "`{}` is a folder: give --out the name of a file, such as case.ron",
                out.display()
            ));
        }
        if let Some(path) = args.paths.iter().find(|path| same(out, path)) {
            return Err(anyhow!(
                "`{}` is the data file itself, which its spec would replace: give --out another name",
                path.display()
            ));
        }
        outdir::unless_there(out, options.force)?;
    }
    if let [path] = args.paths.as_slice()
        && let Some(text) = robot::text(path)?
    {
        return robot::written(&text, args, options, (purpose, out));
    }
    if let (Some(data), Purpose::Draft) = (&options.data, purpose) {
        return Err(anyhow!(
            "`--data {}` names the log of a robot, and `{}` is neither URDF nor MJCF: name the data file alone",
            data.display(),
            args.paths[0].display()
        ));
    }
    let files = names(&args.paths)?;
    let mut sources = Sources::default();
    let mut answers = args.said.answers();
    let next = next_command(&args.paths[0], out);
    let (drafts, text) = loop {
        let each =
            args.paths.iter().map(|path| drafted(path, args, &answers, purpose, options.quiet, &mut sources));
        let drafts = match each.collect::<Result<Vec<Draft>, _>>() {
            Ok(drafts) => drafts,
            Err(d) => {
                draw::show([&*d], &sources);
                return Ok(INPUT);
            }
        };
        let each: Vec<(&Draft, &str)> =
            drafts.iter().zip(&files).map(|(d, file)| (d, file.as_str())).collect();
        // Before any question: files of two rigs have no answer in common.
        let text = match spec_text_of(&each, &next) {
            Ok(text) => text,
            Err(why) => {
                let d = Diagnostic::error(why)
                    .help("draft it alone, or give its columns the same headings and units");
                draw::show([&d], &sources);
                return Ok(INPUT);
            }
        };
        if !asked(drafts.iter().flat_map(|d| &d.questions), &mut answers)? {
            break (drafts, text);
        }
    };
    let open = |(draft, path): (&Draft, &PathBuf)| -> Vec<Diagnostic> {
        let ask = |q: &Question| Diagnostic::error(format!("`{}`: {q}", path.display())).help(q.answer());
        draft.questions.iter().map(ask).collect()
    };
    let questions: Vec<Diagnostic> = drafts.iter().zip(&args.paths).flat_map(open).collect();
    if purpose == Purpose::Search && !questions.is_empty() {
        draw::show(questions.iter(), &sources);
        return Ok(INPUT);
    }
    let (draft, file) = (&drafts[0], &files[0]);
    let Some(text) = put(text, file, options, (out, &mut sources))? else { return Ok(INPUT) };
    if !options.quiet {
        for (draft, file) in drafts.iter().zip(&files) {
            summary(draft, file).iter().for_each(|line| remark(line));
        }
    }
    if purpose == Purpose::Draft && !options.quiet {
        // A pipe, or a terminal that shows the spec itself, gets no picture of it.
        if let (Some(look), Some(_)) = (look(), out) {
            sketched(&text, look).iter().for_each(|line| remark(line));
        }
        let edit = "look at its lines marked EDIT, then type";
        remark(&match out {
            Some(out) => format!("{} is written: {edit}", out.display()),
            None => format!("save this as a file (or say --out FILE), {edit}"),
        });
        remark(&format!("    phisindy {} {next}", next_step(draft)));
    }
    Ok(0)
}

/// Writes the text of a spec for a file, changed as `--set` says, and returns it; nothing after a mistake that is shown.
fn put(
    text: String,
    file: &str,
    options: &Options,
    (out, sources): (Option<&Path>, &mut Sources),
) -> Result<Option<String>> {
    let text = match phisindy::files::with_assignments(text, &options.sets, sources) {
        Ok(text) => text,
        Err(d) => {
            draw::show([&d], sources);
            return Ok(None);
        }
    };
    if let Err(why) = accepted(&text) {
        return Err(match options.sets.is_empty() {
            true => anyhow!("the spec for `{file}` would not be accepted ({why}): please report this"),
            false => anyhow!("the spec for `{file}` would not be accepted after --set: {why}"),
        });
    }
    match out {
        Some(out) => outdir::replace_file(out, &text)?,
        None => print(&text)?,
    }
    Ok(Some(text))
}

/// The model of a spec as lines.
fn sketched(text: &str, look: Look) -> Vec<String> {
    let source = SourceId(0);
    let Ok((spec, _)) = spec::read(text, source) else { return vec![] };
    let case = phisindy_phys::check(&spec, source);
    case.map_or(vec![], |(case, _)| sketch(&spec, &case, look))
}

/// The names of the files, as a spec has them: all in one folder.
fn names(paths: &[PathBuf]) -> Result<Vec<String>> {
    // Counted twice, a record would seem to be known better than it is.
    if let Some(k) = (1..paths.len()).find(|&k| paths[..k].iter().any(|earlier| same(earlier, &paths[k]))) {
        return Err(anyhow!("`{}` is named twice: name each file once", paths[k].display()));
    }
    let folder = |path: &Path| path.parent().map(Path::to_owned).unwrap_or_default();
    if let Some(other) = paths.iter().find(|path| folder(path) != folder(&paths[0])) {
        return Err(anyhow!(
            "`{}` and `{}` are in different folders: put the files of one rig into one, for a spec names files alone",
            paths[0].display(),
            other.display()
        ));
    }
    let name = |path: &PathBuf| {
        let file = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        // It separates folders elsewhere, and specs name files alone.
        if file.contains('\\') {
            return Err(anyhow!("a spec cannot name the file `{file}`: give it a name without `\\`"));
        }
        Ok(file)
    };
    paths.iter().map(name).collect()
}

/// Asks the first open question where somebody can answer, and adds the answer; returns whether there is a new one. An
/// empty line leaves it open.
fn asked<'q>(mut questions: impl Iterator<Item = &'q Question>, answers: &mut Answers) -> Result<bool> {
    let Some(question) = questions.next() else { return Ok(false) };
    if !(io::stdin().is_terminal() && io::stderr().is_terminal()) {
        return Ok(false);
    }
    remark(&format!("{question}\n({}; an empty line leaves it open)", question.answer()));
    loop {
        let mut line = String::new();
        if io::stdin().read_line(&mut line)? == 0 || line.trim().is_empty() {
            return Ok(false);
        }
        // `--counts 4096/rev` is what the hint says.
        let own = line.trim();
        let own =
            own.strip_prefix("--").and_then(|rest| rest.split_once(' ')).map_or(own, |(_, value)| value);
        match question.answered(own, answers) {
            Ok(()) => return Ok(true),
            Err(why) => remark(&format!("give {why}")),
        }
    }
}

fn drafted(
    path: &Path,
    args: &NewArgs,
    answers: &Answers,
    purpose: Purpose,
    quiet: bool,
    sources: &mut Sources,
) -> Result<Draft, Box<Diagnostic>> {
    let (name, at) = named(path, purpose, sources);
    let progress = RefCell::new(Progress::new("reading", quiet));
    let table = tabled(path, (&name, at), args, &progress, sources)?;
    progress.borrow_mut().doing("looking at the columns");
    let tell = |done: f64| progress.borrow_mut().at(READING + (1.0 - READING) * done);
    Draft::with_answers(table, answers, &tell).map_err(|why| why.diagnostic(&name, at))
}

/// A file as the user named it, for messages: its name, and where that stands.
fn named(path: &Path, purpose: Purpose, sources: &mut Sources) -> (String, (SourceId, Span)) {
    let name = path.display().to_string();
    let command = if purpose == Purpose::Draft { "new" } else { "go" };
    let words = format!("phisindy {command} {name}");
    let span = Span::new(words.len() - name.len(), words.len());
    (name, (sources.add("command line", words), span))
}

/// The table of a data file.
fn tabled(
    path: &Path,
    (name, at): (&str, (SourceId, Span)),
    args: &NewArgs,
    progress: &RefCell<Progress>,
    sources: &mut Sources,
) -> Result<Table, Box<Diagnostic>> {
    let opened = phisindy::files::open_plain_file(path).and_then(|file| Ok((file.metadata()?.len(), file)));
    let (size, file) = opened.map_err(|e| Box::new(unreadable(name, at, &e)))?;
    let bytes = Told { bytes: file, read: 0, size, progress };
    table(DataFile::new(name, bytes, size), args.sheet.as_deref(), at, sources)
}

/// The part of the work that is reading, as far as a bar needs it.
const READING: f64 = 0.3;

/// A file that tells how much of it was read.
struct Told<'p> {
    bytes: File,
    read: u64,
    size: u64,
    progress: &'p RefCell<Progress>,
}

impl Read for Told<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.bytes.read(out)?;
        self.read += count as u64;
        self.progress.borrow_mut().at(READING * self.read as f64 / self.size.max(1) as f64);
        Ok(count)
    }
}

impl Seek for Told<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.read = self.bytes.seek(to)?;
        Ok(self.read)
    }
}

/// The arguments of the next command.
fn next_command(first: &Path, out: Option<&Path>) -> String {
    let folder = |path: &Path| match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    let spec = out.map_or_else(
        || Path::new(first.file_name().unwrap_or_default()).with_extension("ron"),
        Path::to_owned,
    );
    let data = folder(first);
    if same(&folder(&spec), &data) {
        quoted(&spec)
    } else {
        format!("{} --data {}", quoted(&spec), quoted(&data))
    }
}

/// Whether two paths lead to one file or folder.
fn same(a: &Path, b: &Path) -> bool {
    a.canonicalize().is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b))
}
