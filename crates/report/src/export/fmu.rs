//! A functional mock-up unit of FMI 3.0 (<https://fmi-standard.org/docs/3.0/>) as files: the description, and
//! its sources in C. Model exchange and co-simulation are the same model: contacts are event indicators, or
//! the steps locate their events themselves.

mod description;
mod variables;

use super::c;
use super::functions::Functions;
use super::subject::Subject;
use description::{build_description, description};
use phisindy_expr::Language;
use std::fmt::Write;
use variables::Variables;

/// The files of the archive with their paths in it, and what a compiler needs.
#[derive(Debug)]
pub struct Fmu {
    /// Path in the archive and text.
    pub files: Vec<(String, String)>,
    /// The identifier of the model, which names its binary.
    pub identifier: String,
    /// The path of the one file of C.
    pub source: String,
}

/// The files of a model with this identifier.
pub(crate) fn written(subject: &Subject, identifier: &str) -> Fmu {
    let variables = Variables::new(subject);
    let source = source(subject, &variables);
    let token = token(&[&source, &variables.names()]);
    let source = source.replace(TOKEN, &token);
    let path = format!("sources/{identifier}.c");
    let files = vec![
        ("modelDescription.xml".to_owned(), description(subject, &variables, identifier, &token)),
        ("sources/buildDescription.xml".to_owned(), build_description(identifier)),
        (path.clone(), source),
    ];
    Fmu { files, identifier: identifier.to_owned(), source: path }
}

/// Stands for the token while it is not known.
const TOKEN: &str = "{token}";

/// The one file of C.
fn source(subject: &Subject, variables: &Variables) -> String {
    let functions = Functions::new(subject, Language::C);
    let usage = [
        "The sources of a functional mock-up unit (FMI 3.0); variables and their references stand in modelDescription.xml.",
        "cc -O2 -std=c99 -shared -fPIC -fvisibility=hidden THIS.c -o THIS.so -lm",
    ];
    let mut out = c::model(subject, &functions, &usage);
    let _ = writeln!(out, "\n#define PARAMETER_COUNT {}", subject.constants.len());
    let _ = writeln!(out, "static const char TOKEN[] = \"{TOKEN}\";");
    out += "/* The state at the start, and the size of each state: its largest value where the record is known. */\n";
    let number = |x: &f64| format!("{x:?}");
    c::array(&mut out, "double START", variables.start.iter().map(number), "0.0");
    c::array(&mut out, "double NOMINAL", variables.nominal.iter().map(number), "1.0");
    out.push('\n');
    out += c::CONTACT_RULE;
    out.push('\n');
    out += include_str!("runtime/fmu.c");
    out
}

/// A name for these texts: two different models do not share it. (FNV-1a of 64 bits, twice, from two starts.)
fn token(texts: &[&str]) -> String {
    let hash = |start: u64| {
        let bytes = texts.iter().flat_map(|text| text.bytes().chain([0]));
        bytes.fold(start, |h, byte| (h ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
    };
    format!("{{{:016x}{:016x}}}", hash(0xcbf2_9ce4_8422_2325), hash(0x9e37_79b9_7f4a_7c15))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_token_tells_texts_apart() {
        assert_eq!(token(&["a", "b"]), token(&["a", "b"]));
        assert_ne!(token(&["a", "b"]), token(&["ab", ""]));
        assert_eq!(token(&[]).len(), 34);
    }
}
