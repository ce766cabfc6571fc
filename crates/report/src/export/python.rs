//! A model as a Python module that needs only the standard library.

use super::functions::{Function, Functions, Read};
use super::head::{head, kind};
use super::quoted::quoted;
use super::subject::Subject;
use phisindy_expr::Language;
use std::fmt::Write;

/// The text of the module.
pub(crate) fn written(subject: &Subject) -> String {
    let functions = Functions::new(subject, Language::Python);
    let usage = [
        "rates(t, x, u, modes)      dx/dt; a mode of 0 is a contact that sticks, +1 and -1 slip in that direction",
        "modes(t, x, u)             the modes at a point, by the contact rule",
        "simulate(times, ...)       the motion, with located stick and slip events",
        "python3 THIS.py < in.csv   the same from columns `t` and the inputs, such as `phisindy simulate` writes",
    ];
    let mut out = String::new();
    head(subject, &functions.identifiers, &usage).iter().for_each(|line| line_of(&mut out, "#", line));
    out += "\nimport bisect\nimport csv\nimport math\nimport sys\n\n";
    out += "# Name and unit of each state; of each input also how it goes between its samples.\n";
    list(
        &mut out,
        "STATES",
        subject.states.iter().map(|q| format!("({}, {})", quoted(&q.name), quoted(&q.unit))),
    );
    let inputs = subject.inputs.iter().zip(&subject.interpolation);
    list(
        &mut out,
        "INPUTS",
        inputs.map(|(q, i)| format!("({}, {}, \"{}\")", quoted(&q.name), quoted(&q.unit), kind(*i))),
    );
    out += "# Name and unit of what sensors read beside the states.\n";
    let outputs = subject.outputs.iter();
    list(&mut out, "OUTPUTS", outputs.map(|q| format!("({}, {})", quoted(&q.name), quoted(&q.unit))));
    out +=
        "# Each velocity that rubs: whether it can stick, and whether its friction has a shape near rest.\n";
    let truth = |yes: bool| if yes { "True" } else { "False" };
    let contacts = subject.switched.switches.iter();
    list(
        &mut out,
        "CONTACTS",
        contacts.map(|s| format!("({}, {}, {})", quoted(&s.text), truth(s.can_stick), truth(s.shaped))),
    );
    out += "# Constants: change them here, or give a copy to the functions.\nPARAMETERS = {\n";
    for c in &subject.constants {
        let unit = if c.unit.is_empty() { String::new() } else { format!("  # {}", c.unit) };
        let _ = writeln!(out, "    {}: {:?},{unit}", quoted(&c.name), c.value);
    }
    out += "}\n# The state at the start; None: not known.\n";
    let record = subject.chosen();
    let number = |x: &Option<f64>| x.map_or("None".to_owned(), |x| format!("{x:?}"));
    let _ = writeln!(out, "START = [{}]", record.start.iter().map(number).collect::<Vec<_>>().join(", "));
    let _ =
        writeln!(out, "START_TIME = {}\nRECORD = {}\n\n", number(&record.start_time), quoted(&record.name));
    out += Language::Python.helpers();
    define(&mut out, "_flow", "dx/dt in the given modes.", &functions.flow, subject);
    define(
        &mut out,
        "_surfaces",
        "Of all contacts: w, dw/dt, how dw/dt changes with each mode, dw/dx.",
        &functions.surfaces,
        subject,
    );
    define(
        &mut out,
        "_outputs",
        "What sensors read beside the states, in the given modes.",
        &functions.outputs,
        subject,
    );
    out += "\n\n";
    out += include_str!("runtime.py");
    out
}

fn line_of(out: &mut String, mark: &str, line: &str) {
    let _ = writeln!(out, "{}", format!("{mark} {line}").trim_end());
}

fn list(out: &mut String, name: &str, entries: impl Iterator<Item = String>) {
    let _ = writeln!(out, "{name} = [{}]", entries.collect::<Vec<_>>().join(", "));
}

fn define(out: &mut String, name: &str, about: &str, function: &Function, subject: &Subject) {
    let _ = write!(
        out,
        "\n\ndef {name}(t, state, inputs, slopes, parameters, mode, side, floors, margins):\n    \"\"\"{about}\"\"\"\n"
    );
    for (local, from) in &function.reads {
        let _ = match from {
            Read::Element(argument, k) => writeln!(out, "    {local} = {argument}[{k}]"),
            Read::Constant(k) => {
                writeln!(out, "    {local} = parameters[{}]", quoted(&subject.constants[*k].name))
            }
        };
    }
    for (local, value) in &function.code.temporaries {
        let _ = writeln!(out, "    {local} = {value}");
    }
    out.push_str("    return [\n");
    for root in &function.code.roots {
        let _ = writeln!(out, "        {root},");
    }
    out.push_str("    ]\n");
}
