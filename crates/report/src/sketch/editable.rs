//! The sketch for a page on which it is edited: the picture, and its parts by their names in the spec.

use super::canvas::Canvas;
use super::moving::Moving;
use super::number::{DAMPING, INERTIA, Numbers, STIFFNESS, unit};
use super::read::Reading;
use super::scheme::{Body, End, Kind, Known, Part};
use super::{found, layout, text};
use crate::markup::element;
use phisindy_phys::Case;
use phisindy_phys::spec::Spec;

/// A sketch whose parts can be pointed at.
pub struct EditableSketch {
    /// The picture; the group of each part and body has its key as `data-part`.
    pub svg: String,
    /// Springs, dampers, contacts, ...
    pub parts: Vec<SketchPart>,
    /// What moves.
    pub bodies: Vec<SketchBody>,
    /// The forces from outside, in words.
    pub pushes: Vec<String>,
    /// The supports that move: displacement and speed, where they are inputs.
    pub bases: Vec<[Option<String>; 2]>,
}

/// A part of a sketch.
#[derive(Clone, Debug, PartialEq)]
pub struct SketchPart {
    /// Unique in its sketch.
    pub key: String,
    /// What it is, in words.
    pub title: String,
    /// What is along it: `spring`, `nonlinear spring`, `damper`, ...
    pub kind: &'static str,
    /// Whether the spec asks for it, and does not state it.
    pub sought: bool,
    /// Its ends; the first is the ground or a support where there is one.
    pub ends: [SketchEnd; 2],
    /// Its constants.
    pub constants: Vec<String>,
}

/// Where a part ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SketchEnd {
    /// At rest.
    Ground,
    /// One of [`EditableSketch::bases`].
    Base(usize),
    /// One of [`EditableSketch::bodies`].
    Body(usize),
}

/// A body of a sketch.
#[derive(Clone, Debug, PartialEq)]
pub struct SketchBody {
    /// Unique in its sketch.
    pub key: String,
    /// What it is, in words.
    pub title: String,
    /// Its displacement, where it has one.
    pub displacement: Option<String>,
    /// Its speed.
    pub speed: String,
    /// What its forces are divided by, where that is known.
    pub mass: Option<String>,
    /// The constants of its mass.
    pub constants: Vec<String>,
    /// Units of a mass, a damper and a spring.
    pub units: [String; 3],
}

/// The sketch of a case for a page; none where there is nothing to draw.
pub fn editable_sketch(spec: &Spec, case: &Case) -> Option<EditableSketch> {
    let mut reading = Reading::new(spec, case, Numbers::default());
    found::add_sought(&mut reading, case);
    if reading.scheme.bodies.is_empty() && reading.scheme.blocks.is_empty() {
        return None;
    }
    let masses: Vec<_> = reading.bodies.iter().map(|b| b.mass).collect();
    let (mut view, ..) = reading.view();
    let masses: Vec<_> = masses.into_iter().map(|m| m.map_or(vec![], |m| view.constants(m))).collect();
    let Reading { system, bodies, bases, scheme, .. } = &reading;
    let canvas: Canvas = layout::drawn(scheme);
    let (wide, high) = layout::size(&canvas);
    let svg = element("svg")
        .with("id", "model-sketch")
        .class("chart")
        .with("role", "group")
        .with("aria-label", "Sketch of the model")
        .with("viewBox", format!("0 0 {wide} {high}"))
        .with("width", wide)
        .with("height", high)
        .all(canvas.drawn);
    let name = |k: usize| system.states[k].name.clone();
    let body = |(k, (body, shown)): (usize, (&Moving, &Body))| {
        let mass = body.mass.map(|mass| system.graph.text(mass, &system.names));
        let of = if shown.inertia.is_empty() { "mass without a name" } else { &shown.inertia };
        SketchBody {
            key: End::Body(k).key(),
            title: format!("body {}, {of}", shown.name),
            displacement: body.displacement.map(name),
            speed: name(body.speed),
            constants: masses[k].clone(),
            mass,
            units: match body.mass {
                None => [INERTIA[usize::from(body.turns)].to_owned(), String::new(), String::new()],
                Some(_) => [INERTIA, DAMPING, STIFFNESS].map(|units| unit(system, body, units)),
            },
        }
    };
    let end = |end: End| match end {
        End::Ground => SketchEnd::Ground,
        End::Base(k) => SketchEnd::Base(k),
        End::Body(k) => SketchEnd::Body(k),
    };
    let part = |part: &Part| SketchPart {
        key: part.key(),
        title: text::of_part(scheme, part).words,
        kind: part.kind.word(),
        sought: part.known == Known::Sought,
        ends: [end(part.ends.0), end(part.ends.1)],
        constants: part.constants.clone(),
    };
    let input = |u: usize| system.inputs[u].name.clone();
    Some(EditableSketch {
        svg: svg.to_string(),
        parts: scheme.elements.iter().filter(|p| p.kind != Kind::Link).map(part).collect(),
        bodies: bodies.iter().zip(&scheme.bodies).enumerate().map(body).collect(),
        pushes: scheme
            .pushes
            .iter()
            .map(|p| format!("{}: {}", scheme.bodies[p.body].name, p.words))
            .collect(),
        bases: bases.iter().map(|&(x, v)| [x.map(input), v.map(input)]).collect(),
    })
}
