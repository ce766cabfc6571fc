//! What must hold for any input: one function for each thing that reads what others wrote. None may panic; the rest is asserted here.
//!
//! ```text
//! python3 fuzz/run.py all 2000000 1      corpus from specs/, then libFuzzer on each target, then a row of docs/robustness.md for each
//! ```

mod arrays;
mod datafile;
mod gap;
mod journal;
mod meter;
mod routes;

pub use arrays::arrays;
pub use datafile::{csv, format};
pub use gap::gap;
pub use journal::journal;
pub use meter::{Limits, measured, measured_within};
pub use routes::routes;

use phisindy_expr::{Graph, Names, Scratch, Span, Symbol, Tape, parse};
use phisindy_phys::{Diagnostic, Law, SourceId, Sources, splice};

/// Longest message: more is no message, and a long input must not come back as one.
const LONGEST_MESSAGE: usize = 2000;

/// An expression: a mistake has its place in the text; what is read can be printed, read back as the same node, differentiated and evaluated, with the
/// same bits in any number of lanes.
pub fn expression(input: &[u8]) {
    let Ok(text) = std::str::from_utf8(input) else { return };
    let ast = match parse(text) {
        Ok(ast) => ast,
        Err(e) => {
            inside(e.span, text);
            assert!(e.to_string().len() + e.hint().unwrap_or_default().len() < LONGEST_MESSAGE, "{e}");
            return;
        }
    };
    ast.nodes.iter().for_each(|node| inside(node.span, text));
    let (mut graph, mut names) = (Graph::default(), Names::default());
    let root = graph.lower(&ast, |name| Some(names.intern(name))).expect("every name is known");
    let printed = graph.text(root, &names);
    assert!(!graph.latex(root, &names).is_empty());
    // What was within the limits may print longer than they are: a product of signs gains parentheses.
    if let Ok(again) = parse(&printed) {
        let back = graph.lower(&again, |name| names.get(name)).expect("the same names");
        assert_eq!(back, root, "{text:?} was printed as {printed:?}");
    }
    let symbols: Vec<Symbol> = graph.symbols(&[root]);
    let inputs: Vec<_> = symbols.into_iter().map(|s| graph.symbol(s)).collect();
    let mut outputs = vec![root];
    outputs.extend(graph.gradient(root, &inputs));
    let tape = Tape::compile(&graph, &inputs, &outputs).expect("every symbol is an input");
    let (mut one, mut many) = (Scratch::<1>::new(&tape), Scratch::<64>::new(&tape));
    for lane in 0..3 {
        for k in 0..inputs.len() {
            let x = [0.0, -1.5, 0.37 * (k + 1) as f64][lane];
            one.input(k)[0] = x;
            many.input(k)[lane] = x;
        }
    }
    one.run();
    many.run();
    for k in 0..outputs.len() {
        let (a, b) = (one.output(k)[0], many.output(k)[2]);
        assert!(
            a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()),
            "{text:?}: {a} alone, {b} in a lane"
        );
    }
}

/// The form of a spec: mistakes have their places in it, and no more than a hundred are told.
pub fn spec(input: &[u8]) {
    let Ok(text) = std::str::from_utf8(input) else { return };
    let (Ok((_, said)) | Err(said)) = phisindy_phys::spec::read(text, SourceId(0));
    assert!(said.len() <= 100, "{} mistakes", said.len());
    let mut sources = Sources::default();
    sources.add("case.ron", text);
    said.iter().for_each(|d| told_well(d, &sources));
    if let Ok(once) = phisindy_phys::format(text, SourceId(0)) {
        assert_eq!(phisindy_phys::format(&once, SourceId(0)).as_ref(), Ok(&once), "what `fmt` wrote it writes otherwise");
    }
    // What is half typed has an outline.
    let _ = phisindy_phys::outline::read(text);
}

/// The meaning of a spec: what is refused is refused with a reason, and what is checked twice is found the same.
pub fn check(input: &[u8]) {
    let Ok(text) = std::str::from_utf8(input) else { return };
    let Ok((spec, _)) = phisindy_phys::spec::read(text, SourceId(0)) else { return };
    let mut sources = Sources::default();
    let source = sources.add("case.ron", text);
    match phisindy_phys::check(&spec, source) {
        Ok((case, said)) => {
            said.iter().for_each(|d| told_well(d, &sources));
            assert!(!said.iter().any(Diagnostic::is_error));
            assert_eq!(case.records.len(), spec.data.len());
        }
        Err(said) => {
            said.iter().for_each(|d| told_well(d, &sources));
            assert!(said.iter().any(Diagnostic::is_error), "refused without a reason");
            let again = phisindy_phys::check(&spec, source).expect_err("refused again");
            assert_eq!(again, said);
        }
    }
}

/// `--set`: path, value and text are separated by zeros. What was set can be set again without a change.
pub fn splice(input: &[u8]) {
    let Ok(text) = std::str::from_utf8(input) else { return };
    let mut parts = text.splitn(3, '\0');
    let (Some(path), Some(value), Some(text)) = (parts.next(), parts.next(), parts.next()) else { return };
    match splice::set(text, path, value) {
        Ok(new) => {
            assert_eq!(splice::set(&new, path, value).as_ref(), Ok(&new), "{path}={value} in {text:?}")
        }
        Err(e) => assert!(!e.message.is_empty()),
    }
}

/// A law: what it does can be said, and its force can be parsed or is refused with a place.
pub fn law(input: &[u8]) {
    let Ok(text) = std::str::from_utf8(input) else { return };
    match Law::read(text) {
        Ok(law) => {
            let told = [
                law.is_hysteretic(),
                law.sticks(),
                law.has_clearance(),
                law.is_resistance(),
                law.has_memory(),
            ];
            assert!(!(law.is_linear_spring() && !law.is_spring()), "{text:?} and {told:?}");
            assert!(law.linear_parameters().len() <= law.parameters.len());
            let _ = (law.parity(), law.dissipates(), law.property());
            for mirror in [false, true] {
                if let Some(force) = law.subtracted(mirror) {
                    expression(force.as_bytes());
                }
            }
        }
        Err(why) => assert!(!why.to_string().is_empty()),
    }
}

/// Every label lies inside of its text, and there is something to read that is not the whole input.
pub(crate) fn told_well(diagnostic: &Diagnostic, sources: &Sources) {
    assert!(!diagnostic.message.is_empty());
    let length = diagnostic.message.len() + diagnostic.help.iter().map(String::len).sum::<usize>();
    assert!(
        length < LONGEST_MESSAGE,
        "{length} bytes: {}...",
        &diagnostic.message.chars().take(200).collect::<String>()
    );
    diagnostic.labels.iter().for_each(|label| inside(label.span, &sources.get(label.source).text));
}

fn inside(span: Span, text: &str) {
    assert!(text.get(span.range()).is_some(), "{span:?} is no piece of {text:?}");
}
