//! Names of a spec as identifiers of another language: legal names stay, others change without clashes.

use phisindy_expr::Language;
use std::collections::{HashMap, HashSet};

/// Keywords of Python, and names that the exported functions use.
const PYTHON: &str = "False None True and as assert async await break class continue def del elif else except finally for from global if import in is \
lambda nonlocal not or pass raise return try while with yield math bisect csv sys print float int abs max min sum \
t state inputs slopes parameters mode side floors margins";

/// The same for C, and macros of its headers.
const C: &str = "auto break case char const continue default do double else enum extern float for goto if inline int long register restrict return short \
signed sizeof static struct switch typedef union unsigned void volatile while bool true false asm typeof linux unix NULL EOF NAN INFINITY HUGE_VAL errno \
stdin stdout stderr assert isnan isinf isfinite signbit fpclassify isnormal STATES INPUTS OUTPUTS CONTACTS CAN_STICK SHAPED START START_TIME STATE_NAMES \
INPUT_NAMES INPUT_KINDS CONTACT_NAMES PARAMETERS Parameters t state inputs slopes parameters mode side floors margins out";

/// The same for Modelica.
const MODELICA: &str = "algorithm and annotation assert block break class connect connector constant constrainedby der discrete each else elseif elsewhen \
encapsulated end enumeration equation expandable extends external false final flow for function if import impure in initial inner input loop model not \
operator or outer output package parameter partial protected public pure record redeclare replaceable return stream then true type when while within time Real \
Integer Boolean String pre edge change sample terminal terminate reinit delay cardinality sign smooth noEvent homotopy sum product size fill zeros ones abs \
max min mod rem div floor ceil integer";

/// The identifiers of one exported file.
pub(crate) struct Identifiers {
    language: Language,
    taken: HashSet<String>,
    names: HashMap<String, String>,
}

impl Identifiers {
    /// Identifiers for these names. Legal names come first, so that a changed name never takes the place of a
    /// legal one.
    pub(crate) fn new<'a>(language: Language, names: impl Iterator<Item = &'a str> + Clone) -> Identifiers {
        let words = match language {
            Language::Python => PYTHON,
            Language::C => C,
            Language::Modelica => MODELICA,
        };
        let taken = words.split_whitespace().chain(language.taken()).map(str::to_owned).collect();
        let mut all = Identifiers { language, taken, names: HashMap::new() };
        for name in names.clone().filter(|name| legal(language, name)) {
            if all.taken.insert(name.to_owned()) {
                all.names.insert(name.to_owned(), name.to_owned());
            }
        }
        for name in names {
            if !all.names.contains_key(name) {
                let identifier = all.fresh(&spelled(name));
                all.names.insert(name.to_owned(), identifier);
            }
        }
        all
    }

    /// The identifier of a name given to [`Identifiers::new`].
    pub(crate) fn of(&self, name: &str) -> &str {
        &self.names[name]
    }

    /// A new identifier: `wish`, or a variant of it that is free.
    pub(crate) fn fresh(&mut self, wish: &str) -> String {
        let mut identifier = wish.to_owned();
        while !legal(self.language, &identifier) || !self.taken.insert(identifier.clone()) {
            identifier.push('_');
        }
        identifier
    }

    /// Changed names with their identifiers, in order.
    pub(crate) fn changed(&self) -> Vec<(&str, &str)> {
        let mut all: Vec<(&str, &str)> =
            self.names.iter().filter(|(a, b)| a != b).map(|(a, b)| (a.as_str(), b.as_str())).collect();
        all.sort_unstable();
        all
    }
}

/// Whether the characters of a name are legal; keywords are checked elsewhere.
fn legal(language: Language, name: &str) -> bool {
    // Python normalises identifiers (NFKC); Greek letters have one form each, so they stay distinct.
    let letter = |c: char| c.is_ascii_alphabetic() || (language == Language::Python && greek(c).is_some());
    let reserved = language == Language::C && name.starts_with('_');
    let mut letters = name.chars();
    !reserved
        && letters.next().is_some_and(|c| c == '_' || letter(c))
        && letters.all(|c| c == '_' || c.is_ascii_digit() || letter(c))
}

/// A name in ASCII: Greek letters by name, others by number.
fn spelled(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars() {
        match greek(c) {
            _ if c.is_ascii_alphanumeric() || c == '_' => out.push(c),
            Some(word) => out.push_str(&word),
            None => out.push_str(&format!("u{:04x}", u32::from(c))),
        }
    }
    if out.starts_with('_') { format!("x{out}") } else { out }
}

/// The name of a Greek letter.
fn greek(c: char) -> Option<String> {
    const SMALL: [&str; 25] = [
        "alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa", "lambda",
        "mu", "nu", "xi", "omicron", "pi", "rho", "varsigma", "sigma", "tau", "upsilon", "phi", "chi", "psi",
        "omega",
    ];
    let small = |c: char| Some(SMALL[u32::from(c).checked_sub(u32::from('\u{3b1}'))? as usize]);
    match c {
        '\u{3b1}'..='\u{3c9}' => small(c).map(str::to_owned),
        '\u{391}'..='\u{3a1}' | '\u{3a3}'..='\u{3a9}' => {
            let word = small(char::from_u32(u32::from(c) + 32)?)?;
            Some(format!("{}{}", word[..1].to_uppercase(), &word[1..]))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn legal_names_stay_and_the_others_take_nobodys_place() {
        let names = ["x", "y1", "lambda", "lambda_", "in", "int", "ω", "µ", "_Q", "state"];
        let all = |language| {
            let ids = Identifiers::new(language, names.into_iter());
            names.map(|n| ids.of(n).to_owned()).join(" ")
        };
        assert_eq!(all(Language::Python), "x y1 lambda__ lambda_ in_ int_ ω u00b5 _Q state_");
        assert_eq!(all(Language::C), "x y1 lambda lambda_ in int_ omega u00b5 x_Q state_");
        assert_eq!(all(Language::Modelica), "x y1 lambda lambda_ in_ int omega u00b5 _Q state");
    }

    #[test]
    fn no_name_is_that_of_an_operation() {
        let mut ids = Identifiers::new(Language::C, ["pow", "log", "fabs"].into_iter());
        assert_eq!((ids.of("pow"), ids.of("log"), ids.of("fabs")), ("pow_", "log_", "fabs_"));
        assert_eq!(ids.fresh("q0"), "q0");
        assert_eq!(ids.fresh("q0"), "q0_");
    }
}
