//! Cases: questions as they are asked first, with all records in files.

use super::format::Format;
use super::question::{Question, Sheet, heading, records};
use crate::args::{HiddenArgs, RewordArgs, Sensors, Source};
use crate::dice::Dice;
use crate::program::Program;
use crate::{hidden, wrong};
use anyhow::{Context, Result, anyhow};
use phisindy_phys::SourceId;
use phisindy_phys::spec::{self, ConstantSpec, DataSpec, Spec, SyntheticSpec, Text};
use phisindy_phys::splice::quoted;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// Units of constants of a rig by the first letter of their names.
const UNITS: &[(char, &str)] =
    &[('m', "kg"), ('k', "N/m"), ('c', "N*s/m"), ('A', "N"), ('W', "rad/s"), ('p', "rad"), ('q', "N/m^3")];
/// Steps of a sensor in the size of a motion: a fine one.
const STEPS: f64 = 2000.0;

/// A case; none where the program cannot be asked, or the user stopped it.
///
/// # Errors
/// Files cannot be read or written, or the program cannot be started.
pub(super) fn drawn(
    args: &RewordArgs,
    program: &Program,
    index: usize,
    folder: &Path,
) -> Result<Option<Question>> {
    let mut dice = Dice::new(args.seed, &format!("reword {index}"));
    let source = args.from.unwrap_or(match index % 5 {
        0 => Source::Hidden,
        1 => Source::Spec,
        _ => Source::Rig,
    });
    fs::create_dir_all(folder)?;
    let question = match source {
        Source::Hidden => Some(set(args.seed, index, folder, &mut dice)?),
        Source::Rig => {
            let text = wrong::right(&mut dice)?;
            let text = if dice.chance(0.7) { with_units(&text).unwrap_or(text) } else { text };
            measured(&text, program, folder)?
        }
        Source::Spec => {
            let all = specs(&args.specs)?;
            let k = if args.from.is_some() { index } else { index / 5 };
            let path = all.get(k % all.len().max(1)).context("no spec has synthetic records")?;
            measured(&fs::read_to_string(path)?, program, folder)?
        }
    };
    Ok(question.map(|question| counted(question, &mut dice)))
}

fn read(text: &str) -> Option<Spec> {
    spec::read(text, SourceId(0)).ok().map(|(spec, _)| spec)
}

/// Specs of a folder whose records are all synthetic.
fn specs(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).with_context(|| format!("cannot read `{}`", folder.display()))?;
    let mut all: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    all.retain(|path| {
        let spec = fs::read_to_string(path).ok().as_deref().and_then(read);
        spec.is_some_and(|spec| spec.data.iter().all(|data| matches!(data, DataSpec::Synthetic(_))))
    });
    all.sort();
    Ok(all)
}

/// A set of `hidden`.
fn set(seed: u64, index: usize, folder: &Path, dice: &mut Dice) -> Result<Question> {
    let sensors = if dice.chance(0.3) { Sensors::Acceleration } else { Sensors::Mixed };
    let args = HiddenArgs { out: folder.to_owned(), sets: 1, seed, only: None, sensors };
    hidden::set(&args, index, folder)?;
    let spec = fs::read_to_string(folder.join("spec.ron"))?;
    let mut sheets = BTreeMap::new();
    for record in records(&read(&spec).context("a set that cannot be read")?) {
        let name = &record.path.value;
        sheets.insert(name.clone(), sheet(&fs::read_to_string(folder.join(name))?));
    }
    Ok(Question { command: "gap", spec, sheets, counts: None })
}

/// A table of commas.
fn sheet(text: &str) -> Sheet {
    let cells = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
    let mut lines = text.lines();
    let heads = cells(lines.next().unwrap_or_default());
    Sheet { heads, rows: lines.map(cells).collect(), format: Format::Text(',', '.') }
}

/// A spec of a rig with units.
fn with_units(text: &str) -> Option<String> {
    let spec = read(text)?;
    let mut question =
        Question { command: "run", spec: text.to_owned(), sheets: BTreeMap::new(), counts: None };
    let states = spec
        .states
        .iter()
        .map(|(name, unit)| (unit.span, if name.value.starts_with('x') { "m" } else { "m/s" }.to_owned()));
    question = question.edited(states.collect());
    for (name, constant) in &spec.constants {
        let unit = UNITS.iter().find(|(first, _)| name.value.starts_with(*first));
        if let (ConstantSpec::Number { value, .. }, Some((_, unit))) = (constant, unit) {
            question =
                question.set(&["constants", &name.value], &format!("({:?}, \"{unit}\")", value.value))?;
        }
    }
    Some(question.spec)
}

/// The spec with its synthetic records in files.
fn measured(text: &str, program: &Program, folder: &Path) -> Result<Option<Question>> {
    let spec = read(text).ok_or_else(|| anyhow!("a spec that cannot be read"))?;
    let path = folder.join("synthetic.ron");
    fs::write(&path, text)?;
    let (mut sheets, mut data) = (BTreeMap::new(), Vec::new());
    for (k, record) in spec.data.iter().enumerate() {
        let mut command = program.command();
        command.arg("simulate").arg(&path).args(["--record", &k.to_string(), "--quiet"]);
        let Some(said) = program.output(&mut command, None)? else { return Ok(None) };
        let DataSpec::Synthetic(synthetic) = record else { return Ok(None) };
        let file = format!("record{k}.csv");
        let sheet = sheet(&said.out);
        let Some(entry) = entry(&spec, synthetic, &file, &sheet) else { return Ok(None) };
        data.push(entry);
        sheets.insert(file, sheet);
    }
    let question = Question { command: "run", spec: text.to_owned(), sheets, counts: None };
    Ok(question.set(&["data"], &format!("[{}]", data.join(",\n"))))
}

/// A record of a file in place of a synthetic one.
fn entry(spec: &Spec, record: &SyntheticSpec, file: &str, sheet: &Sheet) -> Option<String> {
    if !record.sensors.is_empty() || sheet.rows.is_empty() {
        return None;
    }
    let outputs = spec.outputs.iter().map(|(name, output)| (name, &output.unit));
    let pairs = spec.states.iter().chain(&spec.inputs).map(|(name, unit)| (name, unit));
    let column = |(name, unit): (&Text, &Text)| {
        let read = sheet.heads.contains(&name.value);
        let name = quoted(&name.value);
        read.then(|| match unit.value.as_str() {
            "" => format!("{name}: {name}"),
            unit => format!("{name}: ({name}, \"{unit}\")"),
        })
    };
    let columns: Vec<String> = pairs.chain(outputs).filter_map(column).collect();
    let mut text =
        format!("Csv(path: \"{file}\", time: (\"t\", \"s\"), columns: {{ {} }}", columns.join(", "));
    let mut constants = Vec::new();
    for (name, constant) in &record.constants {
        constants.push(match constant {
            ConstantSpec::Number { value, unit: None } => {
                format!("{}: {:?}", quoted(&name.value), value.value)
            }
            ConstantSpec::Number { value, unit: Some(unit) } => {
                format!("{}: ({:?}, {})", quoted(&name.value), value.value, quoted(&unit.value))
            }
            ConstantSpec::MaxAbs(of) => format!("{}: MaxAbs({})", quoted(&name.value), quoted(&of.value)),
            _ => return None,
        });
    }
    let inputs: Vec<_> =
        record.interpolate.iter().map(|(name, how)| format!("{}: {how:?}", quoted(&name.value))).collect();
    for (field, entries) in [("constants", constants), ("interpolate", inputs)] {
        if !entries.is_empty() {
            let _ = write!(text, ", {field}: {{ {} }}", entries.join(", "));
        }
    }
    Some(format!("{text}, role: {:?})", record.role))
}

/// Some cases have a sensor with steps: a column in millimetres, with a whole number or a fraction of them.
fn counted(question: Question, dice: &mut Dice) -> Question {
    let with_steps = |question: &Question| -> Option<Question> {
        let spec = question.read()?;
        let in_metres = |unit: &Option<Text>| unit.as_ref().is_some_and(|unit| unit.value == "m");
        let first = records(&spec).next()?;
        let state = |name: &str| spec.states.iter().any(|(state, _)| state.value == name);
        let (name, _) = first.columns.iter().find(|(name, c)| in_metres(&c.unit) && state(&name.value))?;
        let mut largest = 0.0_f64;
        let mut question = question.clone();
        question.clone().rewrite(&name.value, &spec, |text| {
            largest = largest.max(text.parse::<f64>().ok()?.abs());
            Some(text.to_owned())
        })?;
        let per = 10.0_f64.powf((STEPS / (1e3 * largest)).log10().round());
        question.rewrite(&name.value, &spec, |text| {
            Some(format!("{:?}", (text.parse::<f64>().ok()? * 1e3 * per).round() / per))
        })?;
        let units = records(&spec).filter_map(|r| heading(r, &name.value)?.unit.as_ref());
        let places = units.map(|unit| (unit.span, "mm".to_owned())).collect();
        Some(Question { counts: Some((name.value.clone(), per)), ..question.edited(places) })
    };
    let steps = dice.chance(0.3).then(|| with_steps(&question)).flatten();
    steps.unwrap_or(question)
}
