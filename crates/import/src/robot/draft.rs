//! The text of a draft of a spec for a robot.

use super::energy::Energies;
use super::log::{Log, Role};
use super::sum::{decimal, rounded};
use super::tree::{Joint, Motion, Robot};
use crate::question::{OPEN_QUESTION, Question};
use crate::spec_text::literals::{quoted, three_digits};
use crate::spec_text::record;
use std::fmt::Write;

/// Bounds of friction are this factor above what the file says: that is where a fit starts, and no more.
const WIDE: f64 = 100.0;
/// Bounds of an armature are this factor from what the file says.
const NEAR: f64 = 10.0;
/// The share of a record that is fitted; the rest shows whether it predicts.
const FITTED: f64 = 2.0 / 3.0;

/// How a joint is driven: name and unit of the input, and the force that it makes.
struct Drive {
    input: String,
    unit: String,
    force: String,
    /// Of a current, the number that makes it a torque.
    constant: Option<String>,
}

impl Robot {
    /// Writes the spec; `files` are the names of the robot's file and of the log's, `next` the arguments of the next
    /// command.
    pub fn spec_text(&self, log: Option<&Log>, files: (&str, &str), next: &str) -> String {
        let energies = Energies::of(self);
        let drives: Vec<Option<Drive>> = (0..self.segments.len()).map(|k| self.drive(k, log)).collect();
        let mut text = self.head(log, files, next);
        let _ = writeln!(text, "(\n    title: {},", quoted(&self.name));
        self.constants(&drives, &mut text);
        let inputs: Vec<String> =
            drives.iter().flatten().map(|d| format!("\"{}\": \"{}\"", d.input, d.unit)).collect();
        let _ = writeln!(text, "    inputs: {{ {} }},", inputs.join(", "));
        self.names(&energies, &mut text);
        self.energy(&energies, &drives, &mut text);
        let rubs: Vec<String> =
            self.numbered().filter(|(_, j)| j.friction > 0.0).map(|(k, _)| format!("\"dq{k}\"")).collect();
        if !rubs.is_empty() {
            let _ = writeln!(text, "    contacts: [{}],", rubs.join(", "));
        }
        let places: Vec<String> =
            self.numbered().map(|(k, j)| format!("{}: \"dq{k}\"", quoted(&j.name))).collect();
        let _ = writeln!(text, "    places: {{ {} }},", places.join(", "));
        self.limits(&drives, &mut text);
        text.push_str("    data: [\n");
        match log {
            Some(log) => log.records(&drives, files.1, &mut text),
            None => self.alone(&drives, &mut text),
        }
        text.push_str("    ],\n)\n");
        text
    }

    /// A few lines on the robot and on the columns of its log.
    pub fn summary(&self, log: Option<&Log>) -> Vec<String> {
        let Some(log) = log else {
            return vec![format!(
                "{}: {} joints, {}; no log (--data FILE)",
                self.name,
                self.segments.len(),
                self.format
            )];
        };
        let mut lines = vec![format!(
            "{}: {} joints, {}; {} rows",
            self.name,
            self.segments.len(),
            self.format,
            log.table.rows()
        )];
        for (k, joint) in self.joints().enumerate() {
            let columns = log.headings(k);
            let taken = if columns.is_empty() { "not measured".to_owned() } else { columns.join(", ") };
            lines.push(format!("{}: {taken}", joint.name));
        }
        let asked = |question: &Question| format!("question: {question} {}", question.answer());
        lines.extend(log.questions.iter().map(asked));
        lines
    }

    /// The joints with their numbers, from 1.
    fn numbered(&self) -> impl Iterator<Item = (usize, &Joint)> {
        self.joints().enumerate().map(|(k, joint)| (k + 1, joint))
    }

    /// What drives a joint: what the log has, or else each motor of the file, or every joint where there is none.
    fn drive(&self, k: usize, log: Option<&Log>) -> Option<Drive> {
        let number = k + 1;
        let motor = self.motors.iter().find(|motor| motor.joint == k);
        let (letter, unit) = match self.segments[k].joint.motion {
            Motion::Turn => ("tau", "N*m"),
            Motion::Slide => ("F", "N"),
        };
        let plain = |name: String, unit: &str| Drive {
            force: name.clone(),
            input: name,
            unit: unit.to_owned(),
            constant: None,
        };
        let effort = || plain(format!("{letter}{number}"), unit);
        let Some(log) = log else {
            return (self.motors.is_empty() || motor.is_some()).then(effort);
        };
        if log.column(k, Role::Effort).is_some() {
            return Some(effort());
        }
        if log.column(k, Role::Current).is_some() {
            let (input, constant) = (format!("i{number}"), format!("K{number}"));
            let force = format!("{constant}*{input}");
            return Some(Drive { input, unit: "A".to_owned(), force, constant: Some(format!("{unit}/A")) });
        }
        log.column(k, Role::Command)?;
        let gear = motor.map_or(1.0, |motor| motor.gear);
        let name = format!("u{number}");
        let force = if gear == 1.0 { name.clone() } else { format!("{}*{name}", decimal(gear)) };
        Some(Drive { force, ..plain(name, unit) })
    }

    /// The comment at the head.
    fn head(&self, log: Option<&Log>, (file, data): (&str, &str), next: &str) -> String {
        let mut text = String::new();
        let mut line = |words: String| {
            let _ = writeln!(text, "{}", format!("// {}", words.replace(['\n', '\r'], " ")).trim_end());
        };
        for question in log.iter().flat_map(|log| &log.questions) {
            line(format!("{OPEN_QUESTION}{question} ({})", question.edit()));
        }
        match log {
            Some(_) => line(format!(
                "Written by `phisindy new {file} --data {data}`. Look at the lines marked EDIT, then type: phisindy gap {next}"
            )),
            None => line(format!(
                "Written by `phisindy new {file}`: the model alone, without a record of its motion."
            )),
        }
        line(String::new());
        let columns = |k: usize| {
            let names = log.map_or(vec![], |log| log.headings(k));
            if names.is_empty() { String::new() } else { format!(" by {}", names.join(", ")) }
        };
        for (k, segment) in self.segments.iter().enumerate() {
            let what = match segment.joint.motion {
                Motion::Turn => "turns",
                Motion::Slide => "slides",
            };
            let on =
                segment.parent.map_or(String::new(), |p| format!(" on `{}`", self.segments[p].joint.name));
            line(format!("q{0}, dq{0}: `{1}` {what}{on}{2}", k + 1, segment.joint.name, columns(k)));
        }
        line(String::new());
        line("For each joint: c, s are cosine and sine; w, v, u the angular velocity, the velocity of the joint's point and".to_owned());
        line("the direction up, along the axes that move with it; h its height. Bodies that are fixed to it are one.".to_owned());
        for remark in &self.remarks {
            line(format!("EDIT: {remark}"));
        }
        text
    }

    fn constants(&self, drives: &[Option<Drive>], text: &mut String) {
        text.push_str("    constants: {\n");
        if let Some((_, strength)) = self.up() {
            let _ = writeln!(text, "        \"g\": ({:?}, \"m/s^2\"),", rounded(strength));
        }
        for (k, segment) in self.segments.iter().enumerate() {
            let (number, joint) = (k + 1, &segment.joint);
            let (force, inertia, way) = match joint.motion {
                Motion::Turn => ("N*m", "kg*m^2", "rad"),
                Motion::Slide => ("N", "kg", "m"),
            };
            let per_speed =
                if joint.motion == Motion::Turn { "N*m*s".to_owned() } else { "N*s/m".to_owned() };
            let mut line: Vec<String> = vec![];
            if segment.body.mass > 0.0 {
                line.push(format!("\"m{number}\": ({:?}, \"kg\"),", rounded(segment.body.mass)));
            }
            if joint.spring.0 > 0.0 {
                line.push(format!("\"k{number}\": ({:?}, \"{force}/{way}\"),", rounded(joint.spring.0)));
            }
            let mut moved = |name: &str, value: f64, unit: &str, (low, high): (f64, f64)| {
                if value > 0.0 {
                    let [low, high] = [low * value, high * value].map(three_digits);
                    line.push(format!(
                        "\"{name}{number}\": (value: {:?}, unit: \"{unit}\", within: ({low:?}, {high:?})),",
                        rounded(value)
                    ));
                }
            };
            moved("J", joint.armature, inertia, (1.0 / NEAR, NEAR));
            moved("b", joint.damping, &per_speed, (0.0, WIDE));
            moved("Fc", joint.friction, force, (0.0, WIDE));
            if let Some(Drive { constant: Some(unit), .. }) = &drives[k] {
                line.push(format!(
                    "\"K{number}\": (value: 1.0, unit: \"{unit}\", within: ({:?}, {WIDE:?})), // EDIT: torque of the joint for each ampere\n       ",
                    1.0 / WIDE
                ));
            }
            if !line.is_empty() {
                let _ = writeln!(text, "{}", format!("        {}", line.join(" ")).trim_end());
            }
        }
        text.push_str("    },\n");
    }

    fn names(&self, energies: &Energies, text: &mut String) {
        if energies.names.iter().all(Vec::is_empty) {
            return;
        }
        text.push_str("    let: {\n");
        for ((_, joint), names) in self.numbered().zip(&energies.names) {
            if names.is_empty() {
                continue;
            }
            let _ = writeln!(text, "        // {}", joint.name.replace(['\n', '\r'], " "));
            // Sine and cosine stand in one line, the parts of a vector in another one.
            let kind = |name: &str| name.chars().next().map(|c| if c == 's' { 'c' } else { c });
            for same in names.chunk_by(|(a, _), (b, _)| kind(a) == kind(b)) {
                let all: Vec<String> =
                    same.iter().map(|(name, of)| format!("\"{name}\": \"{of}\",")).collect();
                let _ = writeln!(text, "        {}", all.join(" "));
            }
        }
        text.push_str("    },\n");
    }

    fn energy(&self, energies: &Energies, drives: &[Option<Drive>], text: &mut String) {
        let coordinates: Vec<String> = self
            .numbered()
            .map(|(k, joint)| {
                let unit = if joint.motion == Motion::Turn { "rad" } else { "m" };
                format!("\"q{k}\": (\"dq{k}\", \"{unit}\")")
            })
            .collect();
        let _ = writeln!(text, "    energy: (\n        coordinates: {{ {} }},", coordinates.join(", "));
        let kinds = [
            ("kinetic", &energies.kinetic),
            ("potential", &energies.potential),
            ("dissipation", &energies.dissipation),
        ];
        for (field, parts) in kinds.into_iter().filter(|(_, parts)| !parts.is_empty()) {
            let _ = writeln!(text, "        {field}: \"{}\",", parts.join("\n            + "));
        }
        let forces: Vec<String> = drives
            .iter()
            .enumerate()
            .filter_map(|(k, drive)| Some(format!("\"{}\": \"dq{}\"", drive.as_ref()?.force, k + 1)))
            .collect();
        let undriven: Vec<&str> = self
            .joints()
            .zip(drives)
            .filter(|(_, drive)| drive.is_none())
            .map(|(joint, _)| joint.name.as_str())
            .collect();
        let edit = match undriven.as_slice() {
            [] => String::new(),
            names => format!(" // EDIT: nothing drives {}", names.join(", ").replace(['\n', '\r'], " ")),
        };
        let _ = writeln!(text, "        forces: {{ {} }},{edit}\n    ),", forces.join(", "));
    }

    /// What the file says of ranges and efforts.
    fn limits(&self, drives: &[Option<Drive>], text: &mut String) {
        let mut all = vec![];
        for ((k, joint), drive) in self.numbered().zip(drives) {
            let direct = drive.as_ref().filter(|d| d.force == d.input && !d.input.starts_with('u'));
            if let (Some(effort), Some(drive)) = (joint.effort, direct) {
                all.push(format!("\"{}\": ({:?}, {effort:?})", drive.input, -effort));
            }
            if let Some((low, high)) = joint.range {
                all.push(format!("\"q{k}\": ({:?}, {:?})", rounded(low), rounded(high)));
            }
        }
        if !all.is_empty() {
            let _ = writeln!(text, "    limits: {{ {} }},", all.join(", "));
        }
    }

    /// A record for a model without one.
    fn alone(&self, drives: &[Option<Drive>], text: &mut String) {
        let (mut columns, mut inputs) = (vec![], vec![]);
        for ((k, _), drive) in self.numbered().zip(drives) {
            columns.push(format!(
                "\"q{k}\": (\"position {k}\", \"{}\")",
                if self.segments[k - 1].joint.motion == Motion::Turn { "rad" } else { "m" }
            ));
            if let Some(drive) = drive {
                columns.push(format!("\"{}\": \"torque {k}\"", drive.input));
                inputs.push(format!("\"{}\": Formula(\"0\")", drive.input));
            }
        }
        let start: Vec<String> = self
            .numbered()
            .map(|(k, joint)| {
                // Somewhere within the range, and not at rest.
                let (low, high) = joint.range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
                format!("\"q{k}\": {:?}", three_digits((joint.reference + 0.1).clamp(low, high)))
            })
            .collect();
        let _ = writeln!(
            text,
            "        // EDIT: put your records here, with a column for each place or speed that was measured and for each input:\n        \
             // Csv(path: \"log.csv\", time: \"t\", columns: {{ {} }}),\n        \
             Synthetic(name: \"falls\", truth: {{}}, start: {{ {} }}, duration: 1.0, step: 0.01, inputs: {{ {} }}),",
            columns.join(", "),
            start.join(", "),
            inputs.join(", ")
        );
    }
}

impl Log {
    /// The records of the log.
    fn records(&self, drives: &[Option<Drive>], file: &str, text: &mut String) {
        let form = if self.table.is_text { "Csv" } else { "Table" };
        let (time, remark) = record::time(&self.time, &self.table);
        let mut columns = vec![];
        for (k, drive) in drives.iter().enumerate() {
            for (role, name) in [(Role::Place, "q"), (Role::Speed, "dq")] {
                let own = self
                    .column(k, role)
                    .map(|c| format!("\"{name}{}\": {}", k + 1, record::column(&self.table, c)));
                columns.extend(own);
            }
            let input = [Role::Effort, Role::Current, Role::Command]
                .into_iter()
                .find_map(|role| self.column(k, role));
            if let (Some(drive), Some(c)) = (drive, input) {
                columns.push(format!("\"{}\": {}", drive.input, record::column(&self.table, c)));
            }
        }
        let mut fields: Vec<String> = vec![];
        if !self.table.record_fields.is_empty() {
            fields.push(self.table.record_fields.join(", "));
        }
        if self.has_holes() {
            fields.push("missing: Omit".to_owned());
        }
        if self.decimation() > 1 {
            fields.push(format!("decimate: {}", self.decimation()));
        }
        let runs = self.time.runs(self.table.rows());
        let mut all = vec![];
        match runs.as_slice() {
            [run] => {
                let times = &self.table.columns[self.time.column].values[run.clone()];
                let factor =
                    crate::headings::factor(self.table.columns[self.time.column].heading.unit.as_deref());
                let seconds = |k: usize| times[k.min(times.len() - 1)] * factor;
                let middle = (times.len() as f64 * FITTED) as usize;
                for (name, from, to, role) in
                    [("fitted", 0, middle, "Fit"), ("predicted", middle, times.len(), "Validate")]
                {
                    all.push((
                        name.to_owned(),
                        format!(
                            "window: ({:?}, {:?}), role: {role}",
                            rounded(seconds(from)),
                            rounded(seconds(to))
                        ),
                    ));
                }
            }
            several => {
                for k in 0..several.len() {
                    let role = if k + 1 < several.len() { "Fit" } else { "Validate" };
                    all.push((format!("run {k}"), format!("run: {k}, role: {role}")));
                }
            }
        }
        for (name, rows) in all {
            let fields: Vec<String> = fields.iter().cloned().chain([rows]).collect();
            let _ = writeln!(
                text,
                "        {form}(path: {}, name: {}, time: {time}, columns: {{ {} }},{remark}\n            {}),",
                quoted(file),
                quoted(&name),
                columns.join(", "),
                fields.join(", ")
            );
        }
    }
}
