//! Edits of a spec's text, and the records and sensors that a fitted value belongs to.

use crate::input::Input;
use phisindy_learn::{FoundParameter, ParameterOf};
use phisindy_phys::splice;
use phisindy_phys::{Diagnostic, Record, SensorPart};

/// A record and the records that continue it.
pub(super) fn records_of(input: Input<'_>, owner: usize) -> impl Iterator<Item = usize> {
    let same =
        move |(r, other): (usize, &Record)| (r == owner || other.continues == Some(owner)).then_some(r);
    input.records.iter().enumerate().filter_map(same)
}

/// Column and property of a sensor's parameter; `None` for a constant.
pub(super) fn sensor_of(p: &FoundParameter) -> Option<(&str, SensorPart)> {
    match &p.id.of {
        ParameterOf::Sensor { name, part, .. } => Some((name, *part)),
        ParameterOf::Constant { .. } => None,
    }
}

pub(super) fn first(diagnostics: &[Diagnostic]) -> String {
    diagnostics.iter().find(|d| d.is_error()).map_or(String::new(), |d| d.message.clone())
}

/// The text of a spec under edit.
pub(super) struct Text(pub(super) String);

impl Text {
    /// Sets the value at a path.
    pub(super) fn set(&mut self, path: &[&str], value: &str) -> Result<(), String> {
        self.0 = splice::set_at(&self.0, path, value).map_err(|e| e.to_string())?;
        Ok(())
    }
}

/// The shortest text that reads back as the same number.
pub(super) fn number(x: f64) -> String {
    format!("{x:?}")
}

/// The start of the first line of a spec that a command writes.
pub fn head(command: &str) -> String {
    format!("// What `phisindy {command} ")
}

/// The start of a line that says where the data files of a written spec are.
const DATA: &str = "// Data files in: ";

/// The text of a written spec with the folders of its data files, relative to its own, in its head.
pub fn with_data(text: &str, folders: &[String]) -> String {
    let lines: String = folders.iter().map(|folder| format!("{DATA}{folder}\n")).collect();
    match text.split_once('\n') {
        Some((first, rest)) => format!("{first}\n{lines}{rest}"),
        None => text.to_owned(),
    }
}

/// The text of a spec that a command wrote, without the lines of its head.
pub fn without_head(text: &str) -> &str {
    let mut rest = text.split_once('\n').map_or("", |(_, rest)| rest);
    while let Some((_, after)) = rest.split_once('\n').filter(|(line, _)| line.starts_with(DATA)) {
        rest = after;
    }
    rest
}

/// The folders of the data files that the head of a spec names, relative to its own folder; none of a spec
/// that no command wrote.
pub fn named_data(text: &str) -> Vec<&str> {
    let mut lines = text.lines();
    let ours = lines.next().is_some_and(|first| ["run", "gap"].iter().any(|c| first.starts_with(&head(c))));
    let named = lines.map_while(|line| line.strip_prefix(DATA)).map(str::trim);
    if ours { named.collect() } else { vec![] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_spec_knows_its_data() {
        let text = format!("{}a.ron` found.\n// More.\n()\n", head("run"));
        assert_eq!(named_data(&text), Vec::<&str>::new());
        assert_eq!(without_head(&with_data(&text, &["a".into(), "b".into()])), "// More.\n()\n");
        let with = with_data(&text, &["..".to_owned(), "../my data".to_owned()]);
        assert_eq!(named_data(&with), ["..", "../my data"]);
        assert!(with.ends_with("// More.\n()\n"));
        assert_eq!(named_data("// Data files in: /etc\n()"), Vec::<&str>::new());
    }
}
