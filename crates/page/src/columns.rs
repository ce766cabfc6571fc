//! A data file: its columns, what they are taken for, and a spec for it. The user may say what a column is;
//! that stands in the place of its heading, which is what the draft goes by.

use crate::check::said;
use phisindy::files::open_plain_file;
use phisindy_expr::Span;
use phisindy_import::{
    Answers, Column, DataFile, Draft, Heading, NoDraft, NoTime, Quantity, Rig, Table, accepted, spec_text,
    summary, table, unreadable,
};
use phisindy_phys::unit::Unit;
use phisindy_phys::{Diagnostic, Sources};
use serde_json::{Value, json};
use std::path::Path;

/// What a column can be.
struct Role {
    /// Its name in requests.
    id: &'static str,
    /// For people.
    words: &'static str,
    /// The word that a draft knows it by; none: the column is left out.
    heading: Option<&'static str>,
    /// Its unit where the user says none.
    unit: &'static str,
    /// The quantities that its unit may measure.
    quantities: &'static [Quantity],
}

const ROLES: &[Role] = &[
    Role { id: "time", words: "time", heading: Some("time"), unit: "s", quantities: &[Quantity::Time] },
    Role {
        id: "displacement",
        words: "displacement, angle",
        heading: Some("position"),
        unit: "m",
        quantities: &[Quantity::Length, Quantity::Angle, Quantity::Count],
    },
    Role {
        id: "velocity",
        words: "velocity",
        heading: Some("velocity"),
        unit: "m/s",
        quantities: &[Quantity::Speed, Quantity::AngularSpeed],
    },
    Role {
        id: "acceleration",
        words: "acceleration",
        heading: Some("acceleration"),
        unit: "m/s^2",
        quantities: &[Quantity::Acceleration],
    },
    Role {
        id: "base",
        words: "motion of the base",
        heading: Some("base"),
        unit: "m",
        quantities: &[Quantity::Length, Quantity::Angle],
    },
    Role {
        id: "force",
        words: "force, torque",
        heading: Some("force"),
        unit: "N",
        quantities: &[Quantity::Force, Quantity::Torque],
    },
    Role {
        id: "drive",
        words: "drive (voltage, current)",
        heading: Some("drive"),
        unit: "V",
        quantities: &[Quantity::Electric],
    },
    Role { id: "none", words: "not used", heading: None, unit: "", quantities: &[] },
];

/// What the user says of a column.
#[derive(Clone, Debug)]
struct Said {
    heading: String,
    role: &'static str,
    unit: String,
}

/// The columns of a file and a spec for it; `wishes` is a list of `{ heading, role, unit }`, or nothing;
/// `answers` is what the user says of the file beside that.
pub(crate) fn look(path: &Path, name: &str, wishes: &Value, answers: &Answers) -> Value {
    let mut sources = Sources::default();
    let drafted = wished(wishes)
        .map_err(Refused::from)
        .and_then(|said| drafted(path, name, &said, answers, &mut sources));
    match drafted {
        Ok((draft, all)) => described(&draft, &all, name),
        Err(Refused { mistake, lacks_rate }) => {
            let diagnostics = said(&[*mistake], &sources, true);
            json!({ "name": name, "roles": roles(), "diagnostics": diagnostics, "counted": lacks_rate })
        }
    }
}

/// Why there is no draft.
struct Refused {
    mistake: Box<Diagnostic>,
    /// Whether the rate of the rows would do.
    lacks_rate: bool,
}

impl From<Box<Diagnostic>> for Refused {
    fn from(mistake: Box<Diagnostic>) -> Refused {
        Refused { mistake, lacks_rate: false }
    }
}

/// The roles for the page.
fn roles() -> Value {
    ROLES.iter().map(|r| json!({ "id": r.id, "words": r.words, "unit": r.unit })).collect()
}

fn wished(wishes: &Value) -> Result<Vec<Said>, Box<Diagnostic>> {
    let text = |wish: &Value, key: &str| wish[key].as_str().unwrap_or_default().to_owned();
    let each = wishes.as_array().into_iter().flatten().map(|wish| {
        let (heading, id, unit) = (text(wish, "heading"), text(wish, "role"), text(wish, "unit"));
        let role = ROLES.iter().find(|r| r.id == id).ok_or_else(|| {
            Box::new(Diagnostic::error(format!("`{heading}` cannot be `{id}`: there is no such role")))
        })?;
        let unit = if unit.is_empty() { role.unit.to_owned() } else { unit };
        if let (Some(_), Err(why)) = (role.heading, Unit::parse(&unit)) {
            return Err(Box::new(Diagnostic::error(format!("the unit of `{heading}`: {why}"))));
        }
        Ok(Said { heading, role: role.id, unit })
    });
    each.collect()
}

/// The draft, and the headings of all columns of the file, with those that the user leaves out.
fn drafted(
    path: &Path,
    name: &str,
    said: &[Said],
    answers: &Answers,
    sources: &mut Sources,
) -> Result<(Draft, Vec<String>), Refused> {
    let at = (sources.add("data", name), Span::new(0, name.len()));
    let opened = open_plain_file(path).and_then(|file| Ok((file.metadata()?.len(), file)));
    let (size, file) = opened.map_err(|why| Box::new(unreadable(name, at, &why)))?;
    let mut table = table(DataFile::new(name, file, size), None, at, sources)?;
    let all = table.columns.iter().map(|c| c.heading.raw.clone()).collect();
    assign(&mut table, said)?;
    let draft = Draft::with_answers(table, answers, &|_| {}).map_err(|why| {
        let lacks_rate = matches!(why, NoDraft::Time(NoTime::NoRate { .. }));
        Refused { mistake: why.diagnostic(name, at), lacks_rate }
    })?;
    Ok((draft, all))
}

/// Puts what the user says in the place of the headings. Once anything is said, a column without a word is
/// not used.
fn assign(table: &mut Table, said: &[Said]) -> Result<(), Box<Diagnostic>> {
    if said.is_empty() {
        return Ok(());
    }
    let mut kept: Vec<Column> = Vec::new();
    for mut column in std::mem::take(&mut table.columns) {
        let Some(said) = said.iter().find(|s| s.heading == column.heading.raw) else { continue };
        let Some((role, word)) = ROLES.iter().find(|r| r.id == said.role).and_then(|r| Some((r, r.heading?)))
        else {
            continue;
        };
        let heading = Heading::parse(&format!("{word} [{}]", said.unit));
        if !role.quantities.contains(&heading.quantity) {
            let (raw, unit) = (&column.heading.raw, &said.unit);
            let mistake = format!("`{raw}` cannot be the {} in `{unit}`", role.words);
            return Err(Box::new(
                Diagnostic::error(mistake).help(format!("its unit is one such as `{}`", role.unit)),
            ));
        }
        column.heading = Heading { raw: column.heading.raw, ..heading };
        kept.push(column);
    }
    table.columns = kept;
    Ok(())
}

/// The draft as data: columns with their numbers and roles, the spec, what was seen.
fn described(draft: &Draft, all: &[String], name: &str) -> Value {
    let columns: Vec<Value> = all.iter().map(|heading| column(draft, heading)).collect();
    let text = spec_text(draft, name, &format!("{}.ron", super::folder::stem(name)));
    // What is written must be accepted; if not, it is a mistake of the program that the user should see.
    let doubt =
        accepted(&text).err().map(|why| json!([{ "error": true, "message": why.to_string(), "help": [] }]));
    let rows = draft.table.rows();
    json!({
        "name": name, "roles": roles(), "columns": columns, "spec": text, "rows": rows,
        "counted": draft.time.counted, "rate": draft.time.rate, "summary": summary(draft, name), "diagnostics": doubt.unwrap_or_else(|| json!([])),
        "preview": preview(draft), "rigs": Rig::ALL.map(|(name, _)| name),
        "questions": draft.questions.iter().map(ToString::to_string).collect::<Vec<_>>(),
    })
}

fn column(draft: &Draft, heading: &str) -> Value {
    let Some(k) = draft.table.columns.iter().position(|c| c.heading.raw == heading) else {
        return json!({ "heading": heading, "role": "none", "usage": "not used" });
    };
    let (statistics, own) = (&draft.statistics[k], &draft.table.columns[k].heading);
    let number = |x: f64| if x.is_finite() { json!(x) } else { Value::Null };
    json!({
        "heading": heading, "unit": own.unit, "role": role(draft, k), "usage": draft.usages[k].to_string(),
        "min": number(statistics.min), "max": number(statistics.max), "std": number(statistics.std),
        "noise": number(statistics.noise), "frequency": draft.frequency(k),
        "missing": statistics.missing,
    })
}

/// The role that a draft gives a column.
fn role(draft: &Draft, k: usize) -> &'static str {
    use phisindy_import::Input;
    let roles = &draft.roles;
    match roles.input {
        Input::Base(c) if c == k => return "base",
        Input::Force(c) | Input::Reaction(c) if c == k => return "force",
        Input::Drive(c) if c == k => return "drive",
        _ => {}
    }
    let held = [
        (Some(draft.time.column).filter(|_| !draft.time.counted), "time"),
        (roles.displacement, "displacement"),
        (roles.velocity, "velocity"),
        (roles.acceleration, "acceleration"),
    ];
    held.into_iter().find(|(c, _)| *c == Some(k)).map_or("none", |(_, id)| id)
}

/// Most points of a curve of the preview.
const POINTS: usize = 600;

/// The columns that the model reads, against time, thinned so that least and greatest values stay.
fn preview(draft: &Draft) -> Value {
    let times = &draft.table.columns[draft.time.column].values;
    let used: Vec<usize> = draft.roles.used().collect();
    let curve = |k: usize| {
        let values = &draft.table.columns[k].values;
        let chunk = times.len().div_ceil(POINTS / 2).max(1);
        let mut points = Vec::new();
        for rows in (0..times.len()).collect::<Vec<_>>().chunks(chunk) {
            let mut good: Vec<usize> =
                rows.iter().copied().filter(|&r| values[r].is_finite() && times[r].is_finite()).collect();
            good.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
            let mut ends: Vec<usize> = good.first().into_iter().chain(good.last()).copied().collect();
            ends.sort_unstable();
            points.extend(ends.into_iter().map(|r| json!([times[r], values[r]])));
        }
        let heading = &draft.table.columns[k].heading;
        json!({ "heading": heading.raw, "unit": heading.unit, "points": points })
    };
    used.into_iter().map(curve).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const TEXT: &str = "t,one,two\n";

    fn file() -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rig.csv");
        let rows = (0..400).map(|k| {
            let t = 0.01 * f64::from(k);
            format!(
                "{t:.2},{:.5},{:.5}\n",
                (9.0 * t).sin(),
                3.0 * (9.0 * t + 0.4).cos() + 0.5 * (21.0 * t).sin()
            )
        });
        std::fs::write(&path, TEXT.to_owned() + &rows.collect::<String>()).unwrap();
        (folder, path)
    }

    #[test]
    fn what_the_user_says_of_columns_goes_into_the_spec() {
        let (_folder, path) = file();
        let wish = |one: (&str, &str), two: (&str, &str)| {
            json!([{ "heading": "t", "role": "time", "unit": "s" }, { "heading": "one", "role": one.0, "unit": one.1 },
                   { "heading": "two", "role": two.0, "unit": two.1 }])
        };
        let told =
            look(&path, "rig.csv", &wish(("displacement", "mm"), ("force", "kN")), &Answers::default());
        let spec = told["spec"].as_str().unwrap_or_else(|| panic!("{told}"));
        assert!(spec.contains(r#""x": ("one", "mm")"#) && spec.contains(r#""F": ("two", "kN")"#), "{spec}");
        assert_eq!(told["columns"][2]["role"], "force", "{told}");
        let told =
            look(&path, "rig.csv", &wish(("none", ""), ("acceleration", "m/s^2")), &Answers::default());
        let spec = told["spec"].as_str().unwrap_or_else(|| panic!("{told}"));
        assert!(spec.contains("rate(v)") && !spec.contains("\"one\""), "{spec}");
        assert_eq!(told["columns"][1]["role"], "none", "{told}");
    }

    #[test]
    fn the_rate_of_a_file_without_times_can_be_said() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("acc.csv");
        let rows: String = (0..400).map(|k| format!("{:.4}\n", (0.09 * f64::from(k)).sin())).collect();
        std::fs::write(&path, format!("acc (g)\n{rows}")).unwrap();
        let asked = look(&path, "acc.csv", &Value::Null, &Answers::default());
        assert!(asked["counted"] == true && asked["spec"].is_null(), "{asked}");
        assert!(asked["diagnostics"][0]["message"].as_str().unwrap().contains("How many rows"), "{asked}");
        let told = look(&path, "acc.csv", &Value::Null, &Answers { rate: Some(250.0), ..Answers::default() });
        assert!(told["spec"].as_str().unwrap().contains("time: Rate(250.0)"), "{told}");
    }

    #[test]
    fn what_the_file_does_not_say_is_asked_and_a_rig_answers() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("going.csv");
        let rows: String = (0..2000)
            .map(|k| format!("{:.2},{:.5}\n", 0.01 * f64::from(k), (0.05 * f64::from(k)).sin()))
            .collect();
        std::fs::write(&path, format!("t_s,x_m\n{rows}")).unwrap();
        let asked = look(&path, "going.csv", &Value::Null, &Answers::default());
        assert!(asked["questions"][0].as_str().unwrap().contains("what drives it?"), "{asked}");
        let said = Answers { rig: Some(Rig::Free), ..Answers::default() };
        assert_eq!(look(&path, "going.csv", &Value::Null, &said)["questions"], json!([]));
        let said = Answers { rig: Some(Rig::Motor), ..Answers::default() };
        let told = look(&path, "going.csv", &Value::Null, &said);
        assert!(told["diagnostics"][0]["message"].as_str().unwrap().contains("`--rig motor`"), "{told}");
    }

    #[test]
    fn frequencies_are_in_hertz_whatever_the_unit_of_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ms.csv");
        let rows: String =
            (0..2000).map(|k| format!("{k},{:.5}\n", (TAU * 4.5e-3 * f64::from(k)).sin())).collect();
        std::fs::write(&path, format!("time (ms),x (mm)\n{rows}")).unwrap();
        let told = look(&path, "ms.csv", &Value::Null, &Answers::default());
        let frequency = told["columns"][1]["frequency"].as_f64().unwrap_or_else(|| panic!("{told}"));
        assert!((frequency - 4.5).abs() < 0.05, "{frequency}");
        assert!(told["columns"][0]["frequency"].is_null(), "{told}");
    }

    #[test]
    fn a_unit_that_does_not_fit_is_told() {
        let (_folder, path) = file();
        let wish = json!([{ "heading": "one", "role": "force", "unit": "mm" }]);
        let told = look(&path, "rig.csv", &wish, &Answers::default());
        assert!(told["diagnostics"][0]["message"].as_str().unwrap().contains("`one`"), "{told}");
        let told = look(
            &path,
            "rig.csv",
            &json!([{ "heading": "one", "role": "hat", "unit": "" }]),
            &Answers::default(),
        );
        assert!(told["diagnostics"][0]["error"] == true, "{told}");
    }
}
