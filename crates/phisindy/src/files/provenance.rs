//! From what a result was made - program, spec, data, laws, each with its SHA-256 - and whether it comes out again.

use super::folders::{data_file, named_files, open_plain_file};
use super::laws::{beside, is_built_in, law_files};
use super::load::{Purpose, Refusal, load_text, spec_text, with_assignments};
use super::request::{Assignment, Request};
use crate::loaded::Loaded;
use crate::options::Options;
use phisindy_phys::Sources;
use phisindy_phys::spec::Method;
use phisindy_report::spec_text::{COMPLETED, IDENTIFIED, head, with_data, without_head};
use phisindy_report::{Folder, PROVENANCE, RESULT, SPEC};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::fmt;
use std::fs;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

/// What was asked for: which command of which spec.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'a> {
    /// Whether `run` or `gap`.
    pub command: Purpose,
    /// Path of the spec.
    pub spec: &'a Path,
    /// Where its files are, and what of it is changed.
    pub request: &'a Request,
    /// The method in place of the spec's.
    pub method: Option<Method>,
    /// Laws of the catalogue that were left out.
    pub without: &'a [String],
}

/// From what a result was made. Paths are relative to its folder.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Provenance {
    version: String,
    command: String,
    /// What the spec is called in the result.
    name: String,
    spec: Source,
    set: Vec<String>,
    seed: Option<u64>,
    method: Option<String>,
    without: Vec<String>,
    data: Vec<Source>,
    laws: Vec<Source>,
    /// Of the spec that the folder keeps.
    kept: String,
    /// Of the result, without the time that it took.
    result: String,
}

/// A file that a result depends on.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Source {
    /// Where it was looked for.
    folder: String,
    /// Its path there: of a data file as the spec names it.
    name: String,
    /// Empty if it is no plain file.
    sha256: String,
}

impl Source {
    /// Of a file that is at `path`, for the folder `out` of a result.
    fn of(name: &str, path: &Path, out: &Path) -> Source {
        let below = Path::new(name).components().filter(|part| matches!(part, Component::Normal(_))).count();
        let folder = path.ancestors().nth(below).unwrap_or(path);
        let seen = relative(folder, out).unwrap_or_else(|| folder.to_owned());
        let sha256 = hash_of(path).unwrap_or_default();
        Source { folder: seen.display().to_string(), name: name.to_owned(), sha256 }
    }

    /// Of a spec or a law.
    fn of_text(path: &Path, out: &Path) -> Source {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Source::of(&name, path, out)
    }

    /// As a message calls it.
    fn shown(&self) -> String {
        if self.folder == "." { self.name.clone() } else { format!("{}/{}", self.folder, self.name) }
    }
}

/// The folders of these files, each once.
fn folders(files: &[Source]) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for file in files {
        if !all.contains(&file.folder) {
            all.push(file.folder.clone());
        }
    }
    all
}

/// The version of this program.
const VERSION: &str = env!("CARGO_PKG_VERSION");

impl Provenance {
    /// Of a result that comes into the folder `out`.
    pub fn of(asked: &Asked<'_>, loaded: &Loaded, out: &Path) -> Provenance {
        let Asked { command, spec, request, method, without } = *asked;
        let data = named_files(&loaded.given, spec, request);
        let laws = law_files(spec, request).into_iter().filter(|law| !is_built_in(law));
        Provenance {
            version: VERSION.to_owned(),
            command: if command == Purpose::Gap { "gap" } else { "run" }.to_owned(),
            name: loaded.spec.clone(),
            spec: Source::of_text(spec, out),
            set: request.assignments.iter().map(|a| format!("{}={}", a.path, a.value)).collect(),
            seed: request.seed,
            method: method.map(|m| m.name().to_owned()),
            without: without.to_vec(),
            data: data.iter().map(|(name, path)| Source::of(name, path, out)).collect(),
            laws: laws.map(|law| Source::of_text(&law, out)).collect(),
            kept: String::new(),
            result: String::new(),
        }
    }

    /// One hash of all that the result depends on.
    pub fn inputs(&self) -> String {
        let files = [&self.spec].into_iter().chain(&self.data).chain(&self.laws);
        let hashes = files.map(|file| file.sha256.clone());
        let options = (&self.version, &self.command, &self.set, self.seed, &self.method, &self.without);
        sha256(format!("{options:?}{:?}", hashes.collect::<Vec<_>>()).as_bytes())
    }

    /// Adds itself and the spec as it was given to the files of a result, and lets the specs among them find their
    /// data files.
    pub fn put_into(mut self, files: &mut Folder, loaded: &Loaded) {
        let given =
            format!("{}{}` was given (version {VERSION}).\n{}", head(&self.command), self.name, loaded.given);
        files.add(SPEC, given);
        let folders = folders(&self.data);
        for (name, text) in &mut files.files {
            if [SPEC, COMPLETED, IDENTIFIED].contains(&name.as_str()) {
                *text = with_data(text, &folders);
            }
        }
        let of =
            |wanted: &str| files.files.iter().find(|(name, _)| name == wanted).map_or("", |(_, text)| text);
        self.kept = sha256(of(SPEC).as_bytes());
        self.result = sha256(timeless(of(RESULT)).to_string().as_bytes());
        files.add(PROVENANCE, serde_json::to_string_pretty(&self).unwrap_or_default() + "\n");
    }

    /// That of the result in a folder.
    ///
    /// # Errors
    /// In words: the folder holds none.
    pub fn read(folder: &Path) -> Result<Provenance, String> {
        let path = folder.join(PROVENANCE);
        let shown = path.display();
        let text = text_of(&path).map_err(|why| {
            format!(
                "cannot read `{shown}`: {why}: name a folder that `phisindy run SPEC --out DIR` or `phisindy gap SPEC --out DIR` wrote; those of versions before this file cannot be verified"
            )
        })?;
        serde_json::from_str(&text)
            .map_err(|why| format!("`{shown}` is damaged: {why}: make the result again"))
    }
}

/// A way in which a result, or what it was made from, is not as it was.
#[derive(Clone, Debug, PartialEq)]
pub enum Difference {
    /// Another version of the program made it.
    Version(String),
    /// The time or a limit ended the work: what is finished then depends on the machine.
    Stopped,
    /// A file that it was made from is not there, or cannot be read.
    Missing(String),
    /// A file that it was made from is another one now, and the first line of a text that differs: its number, as it
    /// was, as it is.
    Changed(String, Option<(usize, String, String)>),
    /// A file of the result itself was edited.
    Edited(String),
    /// The work ends in an error now.
    Fails(String),
    /// A value of the result: where in `result.json`, as it was, as it comes out now.
    Value(String, String, String),
}

impl Difference {
    /// Its name in JSON.
    pub fn code(&self) -> &'static str {
        match self {
            Difference::Version(_) => "version",
            Difference::Stopped => "stopped",
            Difference::Missing(_) => "missing",
            Difference::Changed(..) => "changed",
            Difference::Edited(_) => "edited",
            Difference::Fails(_) => "fails",
            Difference::Value(..) => "value",
        }
    }

    /// The file or value that it is about.
    pub fn subject(&self) -> &str {
        match self {
            Difference::Missing(what)
            | Difference::Changed(what, _)
            | Difference::Edited(what)
            | Difference::Value(what, ..) => what,
            Difference::Version(_) | Difference::Stopped | Difference::Fails(_) => "",
        }
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Difference::Version(then) => write!(f, "version {then} made it, and this is version {VERSION}"),
            Difference::Stopped => f.write_str("its work was stopped before the end, which no run repeats"),
            Difference::Missing(path) => write!(f, "`{path}` cannot be read"),
            Difference::Changed(path, None) => write!(f, "`{path}` has changed"),
            Difference::Changed(path, Some((line, then, now))) => {
                write!(f, "`{path}` has changed: line {line} was `{then}`, and is `{now}`")
            }
            Difference::Edited(path) => write!(f, "`{path}` was edited after it was written"),
            Difference::Fails(why) => write!(f, "the work fails now: {why}"),
            Difference::Value(at, then, now) => write!(f, "{at}: {then} then, {now} now"),
        }
    }
}

/// What came of a result that was made again.
#[derive(Clone, Debug)]
pub struct Verified {
    /// What is not as it was; nothing: the same bits.
    pub differences: Vec<Difference>,
    /// Whether all values of the result came out again.
    pub same_values: bool,
}

/// Makes the result in a folder again, and compares it to the bit. `data` is where its data files are now, if not
/// where they were.
///
/// # Errors
/// In words: the folder holds no result that can be verified.
pub fn verify(folder: &Path, data: Option<&Path>, options: &Options<'_>) -> Result<Verified, String> {
    let made = Provenance::read(folder)?;
    let read = |name: &str| {
        text_of(&folder.join(name))
            .map_err(|why| format!("cannot read `{}`: {why}", folder.join(name).display()))
    };
    let (kept, result) = (read(SPEC)?, timeless(&read(RESULT)?));
    if !result.is_object() {
        return Err(format!("`{}` is damaged: make the result again", folder.join(RESULT).display()));
    }
    let mut differences = Vec::new();
    if made.version != VERSION {
        differences.push(Difference::Version(made.version.clone()));
    }
    if result["stopped"] == true {
        differences.push(Difference::Stopped);
    }
    if sha256(kept.as_bytes()) != made.kept {
        differences.push(Difference::Edited(SPEC.to_owned()));
    }
    if sha256(result.to_string().as_bytes()) != made.result {
        differences.push(Difference::Edited(RESULT.to_owned()));
    }
    let spec = folder.join(&made.spec.folder).join(&made.spec.name);
    let assignments = made.set.iter().filter_map(|set| set.split_once('='));
    let assignments: Vec<Assignment> = assignments
        .map(|(path, value)| Assignment { path: path.to_owned(), value: value.to_owned() })
        .collect();
    let mut look = |file: &Source, place: &Path, line: &dyn Fn() -> Option<(usize, String, String)>| {
        let hash = data_file(place, &file.name).and_then(|path| hash_of(&path).ok());
        match hash {
            _ if file.sha256.is_empty() => {}
            Some(hash) if hash == file.sha256 => {}
            Some(_) => differences.push(Difference::Changed(file.shown(), line())),
            None => differences.push(Difference::Missing(file.shown())),
        }
    };
    for file in &made.data {
        look(file, data.unwrap_or(&folder.join(&file.folder)), &|| None);
    }
    // The folder keeps the spec: without the original it is complete.
    if spec.is_file() {
        look(&made.spec, &folder.join(&made.spec.folder), &|| changed_line(&kept, &spec, &assignments));
    }
    for law in &made.laws {
        look(law, &folder.join(&law.folder), &|| None);
    }
    let places = folders(&made.data).into_iter().map(|place| folder.join(place));
    let mut places = data.map(Path::to_owned).into_iter().chain(places);
    let request = Request {
        data: places.next(),
        further_data: places.next(),
        named_data: Some(places.map(|place| place.display().to_string()).collect()),
        laws: laws_folder(&made, folder, &spec),
        seed: made.seed,
        ..Request::default()
    };
    let before = differences.len();
    match again(&made, kept, &spec, &request, options) {
        Ok(now) => compare("", &result, &now, &mut differences),
        Err(why) => differences.push(Difference::Fails(why)),
    }
    Ok(Verified { same_values: differences.len() == before, differences })
}

/// The folder of further laws, as seen now: that of the laws that do not lie beside the spec.
fn laws_folder(made: &Provenance, folder: &Path, spec: &Path) -> Option<PathBuf> {
    let beside = spec.parent().map(|parent| parent.join("laws"));
    let mut folders = folders(&made.laws).into_iter().map(|place| folder.join(place));
    folders.find(|f| beside.as_ref().and_then(|b| b.canonicalize().ok()) != f.canonicalize().ok())
}

/// The result, made once more.
fn again(
    made: &Provenance,
    text: String,
    spec: &Path,
    request: &Request,
    options: &Options<'_>,
) -> Result<Value, String> {
    let purpose = if made.command == "gap" { Purpose::Gap } else { Purpose::Run };
    let (mut sources, mut found) = (Sources::default(), Vec::new());
    let loaded = load_text(spec, text, request, purpose, &mut sources, &mut found);
    let loaded = loaded.map_err(|(Refusal::Input | Refusal::Numerics)| {
        found.iter().find(|d| d.is_error()).map_or_else(String::new, |d| d.message.clone())
    })?;
    let doubts = found.into_iter().map(|d| d.message).collect();
    let loaded = Loaded { doubts, spec: made.name.clone(), ..loaded };
    let laws = beside(spec, request).map_err(|why| why.to_string())?.without(&made.without);
    let method = made.method.as_deref().and_then(Method::named);
    let options = Options { laws: Some(&laws), method, observe: options.observe };
    let files = match purpose {
        Purpose::Gap => loaded.gap(&options).map(|found| found.folder(0.0)),
        _ => loaded.identify(&options).map(|found| found.folder(0.0)),
    };
    let files = files.map_err(|why| why.to_string())?.files;
    let result = files.into_iter().find(|(name, _)| name == RESULT);
    Ok(result.map_or(Value::Null, |(_, text)| timeless(&text)))
}

/// A result as JSON, without the time that it took, the plan that it stands beside, and the version that made it.
fn timeless(text: &str) -> Value {
    let mut value: Value = serde_json::from_str(text).unwrap_or(Value::Null);
    if let Some(object) = value.as_object_mut() {
        object.remove("seconds");
        object.remove("planned");
        object.remove("version");
    }
    value
}

/// Adds the values that differ.
fn compare(at: &str, then: &Value, now: &Value, found: &mut Vec<Difference>) {
    match (then, now) {
        (Value::Object(a), Value::Object(b)) => {
            let more = b.keys().filter(|key| !a.contains_key(*key));
            for key in a.keys().chain(more) {
                let at = if at.is_empty() { key.clone() } else { format!("{at}.{key}") };
                compare(&at, a.get(key).unwrap_or(&Value::Null), b.get(key).unwrap_or(&Value::Null), found);
            }
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            a.iter().zip(b).enumerate().for_each(|(k, (a, b))| compare(&format!("{at}[{k}]"), a, b, found));
        }
        _ if then == now => {}
        _ => found.push(Difference::Value(at.to_owned(), short(&then.to_string()), short(&now.to_string()))),
    }
}

/// The first line of a spec that is not as in the one that a result keeps: its number, as it was, as it is.
fn changed_line(kept: &str, spec: &Path, sets: &[Assignment]) -> Option<(usize, String, String)> {
    let now = spec_text(spec).ok()?;
    let now = with_assignments(now, sets, &mut Sources::default()).ok()?;
    let (mut then, mut now) = (without_head(kept).lines(), now.lines());
    for number in 1.. {
        match (then.next(), now.next()) {
            (None, None) => return None,
            (a, b) if a == b => {}
            (a, b) => {
                let (a, b) = (a.unwrap_or("").trim(), b.unwrap_or("").trim());
                let same = a.chars().zip(b.chars()).take_while(|(a, b)| a == b).count();
                return Some((number, around(a, same), around(b, same)));
            }
        }
    }
    None
}

/// Text that fits into a line.
fn short(text: &str) -> String {
    around(text, 0)
}

/// The part of a text about its character `at` that fits into a line.
fn around(text: &str, at: usize) -> String {
    const LONGEST: usize = 70;
    let length = text.chars().count();
    if length <= LONGEST {
        return text.to_owned();
    }
    let from = at.saturating_sub(LONGEST / 2).min(length - LONGEST);
    let part: String = text.chars().skip(from).take(LONGEST).collect();
    let dots = |there: bool| if there { "..." } else { "" };
    format!("{}{part}{}", dots(from > 0), dots(from + LONGEST < length))
}

fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

fn hexadecimal(hash: &[u8]) -> String {
    hash.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The hash of a plain file.
fn hash_of(path: &Path) -> io::Result<String> {
    let (mut file, mut hash, mut buffer) = (open_plain_file(path)?, Sha256::new(), vec![0; 1 << 16]);
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok(hexadecimal(&hash.finalize())),
            n => hash.update(&buffer[..n]),
        }
    }
}

/// A plain file as text.
fn text_of(path: &Path) -> io::Result<String> {
    open_plain_file(path)?;
    fs::read_to_string(path)
}

/// The whole path of a folder that will be there, if it is not yet.
fn whole(path: &Path) -> Option<PathBuf> {
    let there = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    there.canonicalize().ok().or_else(|| Some(whole(path.parent()?)?.join(path.file_name()?)))
}

/// A folder as seen from another one, which is not there before its result is.
fn relative(folder: &Path, from: &Path) -> Option<PathBuf> {
    let (folder, from) = (whole(folder).filter(|folder| folder.exists())?, whole(from)?);
    let shared = folder.components().zip(from.components()).take_while(|(a, b)| a == b).count();
    // Another disk of Windows.
    if matches!(folder.components().nth(shared), Some(Component::Prefix(_))) {
        return Some(folder);
    }
    let up = from.components().skip(shared).map(|_| Component::ParentDir);
    let path: PathBuf = up.chain(folder.components().skip(shared)).collect();
    Some(if path.as_os_str().is_empty() { PathBuf::from(".") } else { path })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_folder_is_seen_from_another_one() {
        let top = tempfile::tempdir().expect("a folder");
        for name in ["a/b", "c d"] {
            fs::create_dir_all(top.path().join(name)).expect("a folder");
        }
        let seen = |folder: &str, from: &str| {
            relative(&top.path().join(folder), &top.path().join(from)).map(|p| p.display().to_string())
        };
        assert_eq!(seen("c d", "a/b").as_deref(), Some("../../c d"));
        assert_eq!(seen("a/b", "a").as_deref(), Some("b"));
        assert_eq!(seen("a", "a").as_deref(), Some("."));
        assert_eq!(seen("nowhere", "a"), None);
        assert_eq!(seen("c d", "a/new").as_deref(), Some("../../c d"));
        assert_eq!(seen("c d", "a/results/new").as_deref(), Some("../../../c d"));
    }

    #[test]
    fn values_are_compared_where_they_stand() {
        let (then, now) =
            (json!({ "a": [1.0, { "b": 2.0 }], "c": 1 }), json!({ "a": [1.0, { "b": 2.5 }], "d": 1 }));
        let mut found = Vec::new();
        compare("", &then, &now, &mut found);
        let found: Vec<String> = found.iter().map(ToString::to_string).collect();
        assert_eq!(found, ["a[1].b: 2.0 then, 2.5 now", "c: 1 then, null now", "d: null then, 1 now"]);
    }
}
