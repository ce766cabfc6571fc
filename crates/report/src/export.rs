//! A model without unknown part as a program or model file for other tools.
//!
//! ```text
//! checked spec --Subject--> Functions (two functions of the model in a language) --> Python, C
//!                     +----------------------------------------------------------> Modelica, JSON
//! ```

mod c;
mod functions;
mod head;
mod identifier;
mod json;
mod modelica;
mod python;
mod quoted;
mod subject;

pub use subject::{Subject, refusal, uses_largest_input};

/// A language that models are exported to.
#[derive(Debug)]
pub struct Exporter {
    /// Name on the command line.
    pub name: &'static str,
    /// What is written, in a few words.
    pub about: &'static str,
    /// Name of the file where the user names only a folder.
    pub file: &'static str,
    /// The text of a model; the second argument is the name that the model has in its file.
    pub write: fn(&Subject, &str) -> String,
}

/// All languages; a new one is a new row.
pub const EXPORTERS: &[Exporter] = &[
    Exporter {
        name: "python",
        about: "A module that needs the standard library alone",
        file: "model.py",
        write: |subject, _| python::written(subject),
    },
    Exporter {
        name: "c",
        about: "One file of C99",
        file: "model.c",
        write: |subject, _| c::written(subject),
    },
    Exporter { name: "modelica", about: "A model of Modelica 3", file: "Model.mo", write: modelica::written },
    Exporter {
        name: "json",
        about: "The model as data",
        file: "model.json",
        write: |subject, _| json::written(subject),
    },
];

/// The name of a model in its file: `stem`, the file's name without extension, or else a name made of the
/// title. (Tools expect a Modelica model in the file of its name.)
pub fn model_name(subject: &Subject, stem: Option<&str>) -> String {
    let title = subject.title.split(':').next().unwrap_or_default();
    let words = title.split(|c: char| !c.is_ascii_alphanumeric()).filter(|w| !w.is_empty());
    let joined: String = words.map(|w| format!("{}{}", w[..1].to_uppercase(), &w[1..])).collect();
    let clean: String =
        stem.unwrap_or(&joined).chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if clean.starts_with(|c: char| c.is_ascii_alphabetic()) { clean } else { format!("Model{clean}") }
}
