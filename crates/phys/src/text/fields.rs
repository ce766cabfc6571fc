//! What may stand where in a spec or a law: one table for the reader, for editors, and for the reference.

mod table;

pub use table::*;

/// What may stand at a place.
#[derive(Clone, Copy, Debug)]
pub enum Form {
    /// A finite number.
    Number,
    /// A whole number that is not negative.
    Whole,
    /// `true` or `false`.
    Truth,
    /// One character in quotes.
    Character,
    /// A text for people.
    Prose,
    /// An expression, in quotes.
    Expression,
    /// A unit, in quotes.
    Unit,
    /// The path of a file.
    File,
    /// The heading of a column of a data file.
    Header,
    /// The name of a law of the catalogue.
    LawId,
    /// A name that nothing else asks for.
    Free,
    /// A name that is declared here.
    Declares(Kind),
    /// A name that is declared elsewhere.
    Name(&'static [Kind]),
    /// This bare word.
    Word(&'static str),
    /// This word in quotes.
    Quoted(&'static str),
    /// `(...)` or `Variant(...)` with fields.
    Group(&'static Group),
    /// `(...)` without fields.
    Tuple(&'static [Form]),
    /// `Variant(...)` without fields.
    Call(&'static str, &'static [Form]),
    /// `[...]`
    List(&'static Form),
    /// `{...}`: what the keys are, and what they lead to.
    Map(&'static Form, &'static Form),
    /// `{...}` with fields beside its keys.
    Mixed(&'static Group, &'static Form, &'static Form),
    /// One of these.
    One(&'static [Form]),
}

impl Form {
    /// The forms that are meant, where it may be one of several.
    ///
    /// ```
    /// use phisindy_phys::fields::{Form, SPEC};
    /// let constants = SPEC.field("constants").expect("a field");
    /// let Form::Map(_, value) = constants.form() else { panic!() };
    /// assert!(matches!(value.each(), [Form::Number, Form::Expression, ..]));
    /// ```
    pub fn each(&self) -> &[Form] {
        match self {
            Form::One(forms) => forms,
            form => std::slice::from_ref(form),
        }
    }
}

/// What a declared name stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "`word` says what each is")]
pub enum Kind {
    State,
    Speed,
    Input,
    Output,
    Constant,
    Definition,
    Place,
    Impact,
    Point,
    Role,
    Parameter,
    Given,
    Internal,
    Grid,
}

impl Kind {
    /// For people.
    pub fn word(self) -> &'static str {
        match self {
            Kind::State => "state",
            Kind::Speed => "speed of a coordinate",
            Kind::Input => "input",
            Kind::Output => "output",
            Kind::Constant => "constant",
            Kind::Definition => "name for an expression",
            Kind::Place => "place",
            Kind::Impact => "impact",
            Kind::Point => "point of a structure",
            Kind::Role => "role: what the law knows of its place",
            Kind::Parameter => "parameter: a number to be found",
            Kind::Given => "number that is held",
            Kind::Internal => "internal state of the law",
            Kind::Grid => "number that is tried on a grid",
        }
    }
}

/// What holds where a field is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Absent {
    /// It may not be.
    Needed,
    /// It may not be, unless this other field is there.
    Without(&'static str),
    /// This, in words.
    Is(&'static str),
}

/// A field: its name, what stands there, what it is, and what holds where it is left out.
#[derive(Clone, Copy, Debug)]
pub struct Field(pub &'static str, pub Form, pub &'static str, pub Absent);

impl Field {
    /// What stands there.
    pub fn form(&self) -> &Form {
        &self.1
    }

    /// What it is, in Markdown whose links lead nowhere but into the reference.
    pub fn about(&self) -> &'static str {
        self.2
    }
}

/// The fields of something in round brackets.
#[derive(Debug)]
pub struct Group {
    /// What has these fields, in messages.
    pub owner: &'static str,
    /// The name in front of its bracket.
    pub variant: Option<&'static str>,
    /// In the order of the reference.
    pub fields: &'static [Field],
}

impl Group {
    /// The field of this name.
    pub fn field(&self, name: &str) -> Option<&'static Field> {
        self.fields.iter().find(|field| field.0 == name)
    }

    /// The names of its fields.
    pub fn names(&self) -> Vec<&'static str> {
        self.fields.iter().map(|field| field.0).collect()
    }
}
