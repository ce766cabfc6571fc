//! A model as one file of C99 that needs only the mathematical library.

use super::functions::{Function, Functions, Read};
use super::head::{head, kind};
use super::quoted::quoted;
use super::subject::Subject;
use phisindy_expr::Language;
use std::fmt::Write;

/// The text of the file.
pub(super) fn written(subject: &Subject) -> String {
    let functions = Functions::new(subject, Language::C);
    let usage = [
        "model_rates(t, x, u, modes, du, p, dx)    dx/dt; a mode of 0 is a contact that sticks, +1 and -1 slip in that direction",
        "model_modes(t, x, u, du, p, scale, modes) the modes at a point, by the contact rule",
        "model_simulate(times, ...)                the motion, with located stick and slip events",
        "cc -O2 -std=c99 -DPHISINDY_MAIN THIS.c -o model -lm && ./model < in.csv    the same from columns `t` and the inputs, such as",
        "                                          `phisindy simulate` writes",
    ];
    let mut out = model(subject, &functions, &usage);
    out += "\n#ifdef PHISINDY_MAIN\n";
    out += &names_and_start(subject);
    let _ = writeln!(out, "static const char RECORD[] = {};", quoted(&subject.chosen().name));
    out += "#endif\n\n";
    out += CONTACT_RULE;
    out.push('\n');
    out += include_str!("runtime/whole.c");
    out.push('\n');
    out += include_str!("runtime/main.c");
    out
}

/// The contact rule, and steps that locate its events.
pub(super) const CONTACT_RULE: &str =
    concat!(include_str!("runtime/field.c"), "\n", include_str!("runtime/steps.c"));

/// Comment, sizes, constants, and the functions of the model.
pub(super) fn model(subject: &Subject, functions: &Functions, usage: &[&str]) -> String {
    let mut out = String::from("/*\n");
    for line in head(subject, &functions.identifiers, usage) {
        // A comment must not contain its own end.
        let _ = writeln!(out, "{}", format!("   {}", line.replace("*/", "* /")).trim_end());
    }
    out += "*/\n\n#include <math.h>\n#include <stdbool.h>\n#include <stdio.h>\n#include <stdlib.h>\n#include <string.h>\n\n";
    let contacts = &subject.switched.switches;
    let _ = writeln!(
        out,
        "#define STATES {}\n#define INPUTS {}\n#define OUTPUTS {}\n#define CONTACTS {}\n",
        subject.states.len(),
        subject.inputs.len(),
        subject.outputs.len(),
        contacts.len()
    );
    out += &parameters(subject, functions);
    let flag = |yes: bool| if yes { "true" } else { "false" }.to_owned();
    out += "/* Each velocity that rubs: whether it can stick, and whether its friction has a shape near rest. */\n";
    array(&mut out, "bool CAN_STICK", contacts.iter().map(|s| flag(s.can_stick)), "false");
    array(&mut out, "bool SHAPED", contacts.iter().map(|s| flag(s.shaped)), "false");
    out.push('\n');
    out += Language::C.helpers();
    let surfaces = "Of all contacts: w, dw/dt, how dw/dt changes with each mode, dw/dx.";
    let outputs = "What sensors read beside the states, in the given modes.";
    define(&mut out, "flow", "dx/dt in the given modes.", &functions.flow, subject, functions);
    define(&mut out, "surfaces", surfaces, &functions.surfaces, subject, functions);
    define(&mut out, "outputs", outputs, &functions.outputs, subject, functions);
    out
}

/// The constants as a structure, and their values.
fn parameters(subject: &Subject, functions: &Functions) -> String {
    let mut out = String::from(
        "/* Constants: change them here, or give a copy to the functions. */\ntypedef struct {\n",
    );
    for c in &subject.constants {
        let unit =
            if c.unit.is_empty() { String::new() } else { format!(" /* {} */", c.unit.replace("*/", "* /")) };
        let _ = writeln!(out, "    double {};{unit}", functions.identifiers.of(&c.name));
    }
    if subject.constants.is_empty() {
        out += "    char none;\n";
    }
    out += "} Parameters;\n\nstatic const Parameters PARAMETERS = {\n";
    for c in &subject.constants {
        let _ = writeln!(out, "    .{} = {:?},", functions.identifiers.of(&c.name), c.value);
    }
    if subject.constants.is_empty() {
        out += "    .none = 0,\n";
    }
    out + "};\n\n"
}

/// Names, and the start of the chosen record.
pub(super) fn names_and_start(subject: &Subject) -> String {
    let mut out = String::new();
    let record = subject.chosen();
    let number = |x: &Option<f64>| x.map_or("NAN".to_owned(), |x| format!("{x:?}"));
    array(&mut out, "char *const STATE_NAMES", subject.states.iter().map(|q| quoted(&q.name)), "\"\"");
    array(&mut out, "char *const INPUT_NAMES", subject.inputs.iter().map(|q| quoted(&q.name)), "\"\"");
    array(&mut out, "char *const OUTPUT_NAMES", subject.outputs.iter().map(|q| quoted(&q.name)), "\"\"");
    let kinds = subject.interpolation.iter().map(|i| match kind(*i) {
        "hold" => "0".to_owned(),
        "linear" => "1".to_owned(),
        _ => "2".to_owned(),
    });
    out += "/* 0: the last sample is held, 1: straight lines, 2: a cubic spline. */\n";
    array(&mut out, "int INPUT_KINDS", kinds, "0");
    let contacts = &subject.switched.switches;
    array(&mut out, "char *const CONTACT_NAMES", contacts.iter().map(|s| quoted(&s.text)), "\"\"");
    out += "/* The state at the start; NAN: not known, and for the time: the first one. */\n";
    array(&mut out, "double START", record.start.iter().map(number), "NAN");
    let _ = writeln!(out, "static const double START_TIME = {};", number(&record.start_time));
    out
}

/// An array with at least one entry: C99 has no empty arrays.
pub(super) fn array(out: &mut String, name: &str, entries: impl Iterator<Item = String>, none: &str) {
    let entries: Vec<String> = entries.collect();
    let list = if entries.is_empty() { none.to_owned() } else { entries.join(", ") };
    let _ = writeln!(out, "static const {name}[] = {{{list}}};");
}

fn define(
    out: &mut String,
    name: &str,
    about: &str,
    function: &Function,
    subject: &Subject,
    all: &Functions,
) {
    let arguments = ["state", "inputs", "slopes", "parameters", "mode", "side", "floors", "margins"];
    let lists = arguments.map(|a| match a {
        "parameters" => "const Parameters *parameters".to_owned(),
        list => format!("const double *{list}"),
    });
    let _ =
        write!(out, "\n/* {about} */\nstatic void {name}(double t, {}, double *out)\n{{\n", lists.join(", "));
    // Avoids warnings about unused parameters.
    let _ = writeln!(out, "    (void)t, {}, (void)out;", arguments.map(|a| format!("(void){a}")).join(", "));
    for (local, from) in &function.reads {
        let _ = match from {
            Read::Element(argument, k) => writeln!(out, "    const double {local} = {argument}[{k}];"),
            Read::Constant(k) => {
                let field = all.identifiers.of(&subject.constants[*k].name);
                writeln!(out, "    const double {local} = parameters->{field};")
            }
        };
    }
    for (local, value) in &function.code.temporaries {
        let _ = writeln!(out, "    const double {local} = {value};");
    }
    for (k, root) in function.code.roots.iter().enumerate() {
        let _ = writeln!(out, "    out[{k}] = {root};");
    }
    out.push_str("}\n");
}
