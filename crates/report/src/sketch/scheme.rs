//! What a sketch shows: bodies, and what acts on them.

/// The parts of a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Scheme {
    pub(crate) bodies: Vec<Body>,
    /// Inputs that move a support.
    pub(crate) bases: Vec<String>,
    pub(crate) elements: Vec<Part>,
    pub(crate) pushes: Vec<Push>,
    pub(crate) blocks: Vec<Block>,
}

/// Something that moves.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Body {
    /// Its displacement, or its speed where it has none.
    pub(crate) name: String,
    /// Whether it turns.
    pub(crate) turns: bool,
    /// `3.08 kg`; empty where the spec does not tell.
    pub(crate) inertia: String,
    /// The columns that sensors read of it.
    pub(crate) sensors: Vec<String>,
    /// What was found of a sensor.
    pub(crate) lit: Vec<String>,
}

/// Where an element ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum End {
    Ground,
    /// One of [`Scheme::bases`].
    Base(usize),
    /// One of [`Scheme::bodies`].
    Body(usize),
}

/// What an element is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    Spring,
    BentSpring,
    Damper,
    BentDamper,
    Friction,
    /// A weight on an arm: gravity in an angle.
    Weight,
    /// A force with a memory, or one of several quantities.
    Force,
    /// Bodies that move each other by their masses.
    Link,
}

impl Kind {
    /// Its name in words.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Kind::Spring => "spring",
            Kind::BentSpring => "nonlinear spring",
            Kind::Damper => "damper",
            Kind::BentDamper => "nonlinear damper",
            Kind::Friction => "friction",
            Kind::Weight => "weight on an arm",
            Kind::Force => "force",
            Kind::Link => "joint",
        }
    }
}

/// How far a part is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Known {
    /// The spec states it.
    #[default]
    Stated,
    /// It is asked for.
    Sought,
    /// It is the answer.
    Found,
}

/// A spring, a damper, a contact, ...
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Part {
    pub(crate) kind: Kind,
    /// In their order; the first is the ground or a base where there is one.
    pub(crate) ends: (End, End),
    /// Lines beside it: its name and its number.
    pub(crate) words: Vec<String>,
    pub(crate) known: Known,
    /// The constants of its force, where the spec states it.
    pub(crate) constants: Vec<String>,
}

impl Part {
    /// Tells it from the other parts of its scheme.
    pub(crate) fn key(&self) -> String {
        let (a, b) = self.ends;
        let asked = if self.known == Known::Sought { "asked-" } else { "" };
        format!("{asked}{}-{}-{}", self.kind.word().replace(' ', "-"), a.key(), b.key())
    }
}

impl End {
    pub(crate) fn key(self) -> String {
        match self {
            End::Ground => "ground".to_owned(),
            End::Base(k) => format!("base{k}"),
            End::Body(k) => format!("body{k}"),
        }
    }
}

/// A force from outside.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Push {
    pub(crate) body: usize,
    pub(crate) words: String,
    pub(crate) known: Known,
}

/// A state that is no motion of a body.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Block {
    pub(crate) name: String,
    /// What its rate is made of.
    pub(crate) of: Vec<String>,
    /// The inputs among these.
    pub(crate) inputs: Vec<String>,
    /// Whether a sensor reads it.
    pub(crate) measured: bool,
    /// What is found or asked for in its rate.
    pub(crate) words: String,
    pub(crate) known: Known,
}

/// Adds what is not there yet.
fn add_new(all: &mut Vec<String>, new: Vec<String>) {
    for text in new {
        if !all.contains(&text) {
            all.push(text);
        }
    }
}

impl Scheme {
    /// Adds an element; one of the same kind at the same place gets its words, and a contact without words its answer.
    pub(crate) fn add(&mut self, kind: Kind, ends: (End, End), words: Vec<String>, known: Known) {
        self.part(kind, ends, words, known);
    }

    /// Adds an element that the spec states, with the constants of its force.
    pub(crate) fn state(&mut self, kind: Kind, ends: (End, End), words: Vec<String>, constants: Vec<String>) {
        add_new(&mut self.part(kind, ends, words, Known::Stated).constants, constants);
    }

    fn part(&mut self, kind: Kind, ends: (End, End), words: Vec<String>, known: Known) -> &mut Part {
        let ends = if ends.0 <= ends.1 { ends } else { (ends.1, ends.0) };
        let bare = |e: &Part| e.words.is_empty() && e.known <= known;
        let same = |e: &Part| e.kind == kind && e.ends == ends && (e.known == known || bare(e));
        let place = self.elements.iter().position(same).unwrap_or_else(|| {
            self.elements.push(Part { kind, ends, words: vec![], known, constants: vec![] });
            self.elements.len() - 1
        });
        let part = &mut self.elements[place];
        part.known = known;
        add_new(&mut part.words, words);
        part
    }

    /// Adds a force from outside; a body has one arrow for all.
    pub(crate) fn push(&mut self, body: usize, words: String, known: Known) {
        match self.pushes.iter_mut().find(|p| p.body == body && p.known == known) {
            Some(same) if same.words == words => {}
            Some(same) => {
                let next = words.strip_prefix('−').map_or(format!("+ {words}"), |rest| format!("− {rest}"));
                same.words = format!("{} {next}", same.words);
            }
            None => self.pushes.push(Push { body, words, known }),
        }
    }
}
