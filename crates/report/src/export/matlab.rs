//! A model as a function of MATLAB and GNU Octave: the model in C99 with what they call, one MEX file. The
//! contact rule stays the one of the other languages.

use super::c::{CONTACT_RULE, array, model, names_and_start};
use super::functions::Functions;
use super::quoted::quoted;
use super::subject::Subject;
use phisindy_expr::Language;
use std::fmt::Write;

/// The text of the file; `name` is that of the function.
pub(crate) fn written(subject: &Subject, name: &str) -> String {
    let functions = Functions::new(subject, Language::C);
    let usage = [
        format!("mex {name}.c                                          makes the function, in MATLAB; a C compiler is needed"),
        format!("mkoctfile --mex {name}.c                              the same for GNU Octave, in a shell"),
        format!("{name}()                                              names, constants, start state"),
        format!("[x, mode, y] = {name}(t, u, start, constants)         the motion at the times t, with located stick and slip events: a row"),
        "    for each time; u: a row for each time, a column for each input; y: what sensors read beside the states".to_owned(),
        format!("[dx, mode] = {name}('rates', t, x, u, mode, constants)    dx/dt; a mode of 0 is a contact that sticks, +1 and -1 slip"),
        "    in that direction; [] or none: the modes at that point, by the contact rule".to_owned(),
        "constants is a structure with those that are to change; [] or none stands for the usual start and constants".to_owned(),
    ];
    let usage: Vec<&str> = usage.iter().map(String::as_str).collect();
    let mut out = model(subject, &functions, &usage);
    let constants = subject.constants.iter().map(|c| quoted(functions.identifiers.of(&c.name)));
    let _ = writeln!(out, "\n#define CONSTANTS {}", subject.constants.len());
    array(&mut out, "char *const CONSTANT_NAMES", constants, "\"\"");
    out += &names_and_start(subject);
    out.push('\n');
    out += CONTACT_RULE;
    out.push('\n');
    out += include_str!("runtime/whole.c");
    out.push('\n');
    out += include_str!("runtime/mex.c");
    out
}
