//! A model without unknown part as a program or model file for other tools.
//!
//! ```text
//! checked spec --Subject--> Functions (two functions of the model in a language) --> Python, C, MATLAB
//!                     +----------------------------------------------------------> Modelica, JSON
//!                     +--Functions and the contact rule--> FMU: files of an archive
//! ```

mod c;
mod fmu;
mod functions;
mod head;
mod identifier;
mod joint_friction;
mod json;
mod matlab;
mod modelica;
mod python;
mod quoted;
mod subject;

pub use fmu::Fmu;
pub use joint_friction::{JointFriction, Moved};
pub use subject::{Experiment, Subject, refusal, uses_largest_input};

/// A language that models are exported to.
#[derive(Debug)]
pub struct Exporter {
    /// Name on the command line.
    pub name: &'static str,
    /// What is written, in a few words.
    pub about: &'static str,
    /// Name of the file where the user names only a folder.
    pub file: &'static str,
    /// What is written; the second argument is the name that the model has in its file.
    pub write: Writer,
}

/// What an exporter makes of a model.
#[derive(Clone, Copy, Debug)]
pub enum Writer {
    /// One text.
    Text(fn(&Subject, &str) -> String),
    /// The files of a functional mock-up unit, which are compiled and packed by the caller. It tells
    /// [`Subject::experiment`] first.
    Fmu(fn(&Subject, &str) -> Fmu),
    /// The file of a robot, which the caller has: it gets back the [`JointFriction`] of its joints.
    Robot,
}

/// All languages; a new one is a new row.
pub const EXPORTERS: &[Exporter] = &[
    Exporter {
        name: "python",
        about: "A module that needs the standard library alone",
        file: "model.py",
        write: Writer::Text(|subject, _| python::written(subject)),
    },
    Exporter {
        name: "c",
        about: "One file of C99",
        file: "model.c",
        write: Writer::Text(|subject, _| c::written(subject)),
    },
    Exporter {
        name: "modelica",
        about: "A model of Modelica 3",
        file: "Model.mo",
        write: Writer::Text(modelica::written),
    },
    Exporter {
        name: "fmu",
        about: "FMI 3.0: model exchange and co-simulation, with sources and a binary where there is a C compiler",
        file: "model.fmu",
        write: Writer::Fmu(fmu::written),
    },
    Exporter {
        name: "matlab",
        about: "A MEX function in C for MATLAB and GNU Octave",
        file: "model_mex.c",
        write: Writer::Text(matlab::written),
    },
    Exporter {
        name: "urdf",
        about: "The robot that the model was drafted from, with the friction that was found",
        file: "robot.urdf",
        write: Writer::Robot,
    },
    Exporter { name: "mjcf", about: "The same for MuJoCo", file: "robot.xml", write: Writer::Robot },
    Exporter {
        name: "json",
        about: "The model as data",
        file: "model.json",
        write: Writer::Text(|subject, _| json::written(subject)),
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
