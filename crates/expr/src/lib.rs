//! Expressions: text in, numbers, derivatives and LaTeX out.
//!
//! ```text
//! text --parse--> Ast (with spans) --lower--> Graph (shared nodes) --Tape::compile--> Tape --Scratch::run--> values
//!                                              |  ^
//!                                              |  +-- vjp: derivatives are nodes of the same graph
//!                                              +----- print: LaTeX and plain text
//! ```
//!
//! This crate knows no physics, no time and no files. Every operation is one row of [`ops`].
//!
//! ```
//! use phisindy_expr::{Graph, Names, Scratch, Tape, parse};
//!
//! let ast = parse("ln(c+V/(|y|+eps))*sgn(y)").unwrap();
//! let (mut graph, mut names) = (Graph::default(), Names::default());
//! let f = graph.lower(&ast, |name| Some(names.intern(name))).unwrap();
//! let y = graph.symbol(names.get("y").unwrap());
//! let slope = graph.gradient(f, &[y])[0];
//!
//! let inputs: Vec<_> = ["c", "V", "eps", "y"].map(|n| graph.symbol(names.get(n).unwrap())).into();
//! let tape = Tape::compile(&graph, &inputs, &[f, slope]).unwrap();
//! let mut scratch = Scratch::<1>::new(&tape);
//! for (k, value) in [0.022, 0.003, 1e-6, 0.1].into_iter().enumerate() {
//!     scratch.input(k)[0] = value;
//! }
//! scratch.run();
//! assert!((scratch.output(0)[0] - (0.022_f64 + 0.003 / 0.100001).ln()).abs() < 1e-15);
//! assert_eq!(graph.text(f, &names), "ln(c + V/(abs(y) + eps))*sgn(y)");
//! ```

mod ast;
mod code;
mod elementary;
mod graph;
mod lower;
mod names;
pub mod ops;
mod parity;
mod parser;
mod print;
mod range;
mod rename;
mod replace;
mod simplify;
mod span;
mod tape;
mod token;
mod vjp;

pub use ast::{Ast, AstKind, AstNode};
pub use code::{Code, Language, Naming};
pub use graph::{Graph, Id, Node};
pub use lower::UnknownName;
pub use names::{Names, Symbol, nearest};
pub use ops::{Binary, Parity, Unary};
pub use parser::{ParseError, ParseErrorKind, clipped, parse, parse_with};
pub use print::{latex_name, latex_number, latex_rate};
pub use rename::rename;
pub use span::Span;
pub use tape::{Cost, Scratch, Tape, Unbound, wide};
