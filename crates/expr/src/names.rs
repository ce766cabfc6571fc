//! Names and their symbols.

use std::collections::HashMap;

/// An interned name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Symbol(pub u32);

/// A table of names.
///
/// ```
/// use phisindy_expr::Names;
/// let mut names = Names::default();
/// let eps = names.intern("eps");
/// assert_eq!(names.name(eps), "eps");
/// assert_eq!(names.get("epss"), None);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Names {
    names: Vec<String>,
    index: HashMap<String, Symbol>,
    /// Names that mean the rate of another one: LaTeX writes them as that one with a dot.
    rates: HashMap<Symbol, Symbol>,
}

impl Names {
    /// The symbol of a name, created if it is new.
    pub fn intern(&mut self, name: &str) -> Symbol {
        if let Some(&symbol) = self.index.get(name) {
            return symbol;
        }
        let symbol = Symbol(self.names.len() as u32);
        self.names.push(name.to_owned());
        self.index.insert(name.to_owned(), symbol);
        symbol
    }

    /// The symbol of a name, if it has one.
    pub fn get(&self, name: &str) -> Option<Symbol> {
        self.index.get(name).copied()
    }

    /// The name of a symbol of this table.
    ///
    /// # Panics
    /// If the symbol comes from another table.
    pub fn name(&self, symbol: Symbol) -> &str {
        &self.names[symbol.0 as usize]
    }

    /// Says that a symbol means the rate of another one.
    pub fn mark_rate(&mut self, symbol: Symbol, of: Symbol) {
        self.rates.insert(symbol, of);
    }

    /// The symbol whose rate it means, if that was said.
    pub fn rate_of(&self, symbol: Symbol) -> Option<Symbol> {
        self.rates.get(&symbol).copied()
    }
}

/// The candidate nearest to `name` in spelling, if it is near enough to be meant: only the case differs, or
/// at most a third of the letters (one letter, for short names).
///
/// ```
/// use phisindy_expr::nearest;
/// assert_eq!(nearest("epss", ["eps", "x"]), Some("eps"));
/// assert_eq!(nearest("Omega", ["omega", "o"]), Some("omega"));
/// assert_eq!(nearest("q", ["eps", "x1"]), None);
/// ```
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = name.to_lowercase();
    let letters = name.chars().count();
    candidates
        .into_iter()
        .map(|c| if c.to_lowercase() == lower { (0, c) } else { (edits(name, c), c) })
        .filter(|&(d, c)| d <= (letters.max(c.chars().count()) / 3).max(1) && d < letters)
        .min_by_key(|&(d, _)| d)
        .map(|(_, c)| c)
}

/// Levenshtein distance with neighbouring letters swapped counted as one edit (optimal string alignment).
fn edits(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut before: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let change = usize::from(a[i - 1] != b[j - 1]);
            let mut best = (last[j - 1] + change).min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(before[j - 2] + 1);
            }
            row.push(best);
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}
