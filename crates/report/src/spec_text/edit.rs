//! Edits of a spec's text, and the records and sensors that a fitted value belongs to.

use crate::input::Input;
use phisindy_learn::{FoundParameter, ParameterOf, SensorPart};
use phisindy_phys::splice;
use phisindy_phys::{Diagnostic, Record};

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
        // A path quotes names that contain dots.
        let part = |p: &&str| if p.contains('.') { format!("\"{p}\"") } else { (*p).to_owned() };
        let path = path.iter().map(part).collect::<Vec<_>>().join(".");
        self.0 = splice::set(&self.0, &path, value).map_err(|e| e.to_string())?;
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
