//! The table of operations. A new operation is a new row: name, value, derivative, kinks, arithmetic,
//! LaTeX. Values, gradients of any order, the printers, the parser and the tests of operations all use
//! these rows.
//!
//! Derivatives at a kink are a convention: `d|x| = sgn(x)`, `sgn(0) = 0`, `d sgn = d step = 0`, and so
//! `1/2` for `pos` and `dead` at their corners, `d rest = 0`. Only `gate` hides the side that it excludes, including NaN,
//! in its value and in every derivative (`masked` products carry this past infinite slopes). All other
//! operations require a finite value even of a side with slope 0 (0 times infinity is NaN).
//!
//! `hold` is what it holds, for all that know no time; a simulation puts a state in its place that jumps.

use crate::{Graph, Id, elementary};

/// The LaTeX form of an operation; `#1`, `#2` are the operands.
pub type Latex = &'static str;

/// The spelling in each [`crate::Language`], in that order; an operation that a language lacks is a
/// function of [`crate::Language::helpers`].
pub type Spelling = [&'static str; 3];

/// A row of the table of functions of one argument.
pub struct UnaryRow {
    /// The operation.
    pub op: Unary,
    /// Its name in the language; empty for unary minus, which is written as an operator.
    pub name: &'static str,
    /// The value: the one definition that every evaluator follows.
    pub value: fn(f64) -> f64,
    /// dy/dx as a node, from the nodes of x and y.
    pub slope: fn(&mut Graph, Id, Id) -> Id,
    /// Where value or slope jumps.
    pub kinks: &'static [f64],
    /// What becomes of the value when the argument turns its sign; none: neither stays nor turns.
    pub parity: Option<Parity>,
    /// Whether the value can be infinite or NaN where x is finite.
    pub singular: bool,
    /// Additions, multiplications, divisions and roots of one value; comparisons and signs count nothing, a
    /// function of the library one.
    pub flops: u32,
    /// How it prints.
    pub latex: Latex,
    /// How other languages write it.
    pub code: Spelling,
    /// One line for the language reference.
    pub about: &'static str,
}

/// A row of the table of operations with two operands.
pub struct BinaryRow {
    /// The operation.
    pub op: Binary,
    /// Its name in the language, or the operator sign.
    pub name: &'static str,
    /// Precedence of an infix operator; 0 for a function.
    pub precedence: u8,
    /// The value: the one definition that every evaluator follows.
    pub value: fn(f64, f64) -> f64,
    /// dy/da as a node, from the nodes of a, b and y.
    pub slope_a: fn(&mut Graph, Id, Id, Id) -> Id,
    /// dy/db as a node, from the nodes of a, b and y.
    pub slope_b: fn(&mut Graph, Id, Id, Id) -> Id,
    /// Positive distance to the nearest jump of value or slope; infinite where there is none.
    pub kink: fn(f64, f64) -> f64,
    /// Additions, multiplications, divisions and roots of one value; comparisons and signs count nothing, a
    /// function of the library one.
    pub flops: u32,
    /// How it prints.
    pub latex: Latex,
    /// How other languages write it.
    pub code: Spelling,
    /// One line for the language reference.
    pub about: &'static str,
}

macro_rules! unary_table {
    ($($op:ident $name:literal |$x:ident| $value:expr; |$g:ident, $gx:ident, $gy:ident| $slope:expr; $kinks:expr; $parity:expr; $singular:literal $flops:literal $latex:literal $code:tt $about:literal)*) => {
        /// A function of one argument.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[repr(u8)]
        pub enum Unary { $(#[doc = $about] $op,)* }

        /// Every function of one argument.
        pub const UNARY: &[UnaryRow] = &[$(UnaryRow {
            op: Unary::$op,
            name: $name,
            value: |$x| $value,
            slope: |$g, $gx, $gy| { let _ = (&$g, $gx, $gy); $slope },
            kinks: &$kinks,
            parity: $parity,
            singular: $singular,
            flops: $flops,
            latex: $latex,
            code: $code,
            about: $about,
        },)*];

        impl Unary {
            /// The row of this operation.
            pub fn row(self) -> &'static UnaryRow {
                &UNARY[self as usize]
            }

            /// `out[i] = op(a[i])`: one dispatch for all lanes, so that the loop inside vectorises.
            #[inline(always)]
            #[allow(unreachable_patterns)] // sines and cosines have a loop of their own, and a row
            pub(crate) fn lanes<const N: usize>(self, a: &[f64; N], out: &mut [f64; N]) {
                match self {
                    Unary::Sin => elementary::angles(0, a, out),
                    Unary::Cos => elementary::angles(1, a, out),
                    $(Unary::$op => for i in 0..N { let $x = a[i]; out[i] = $value; },)*
                }
            }
        }
    };
}

macro_rules! binary_table {
    ($($op:ident $name:literal $precedence:literal |$a:ident, $b:ident| $value:expr;
       |$g:ident, $ga:ident, $gb:ident, $gy:ident| $slope_a:expr, $slope_b:expr; $kink:expr; $flops:literal $latex:literal $code:tt $about:literal)*) => {
        /// An operation with two operands.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[repr(u8)]
        pub enum Binary { $(#[doc = $about] $op,)* }

        /// Every operation with two operands.
        pub const BINARY: &[BinaryRow] = &[$(BinaryRow {
            op: Binary::$op,
            name: $name,
            precedence: $precedence,
            value: |$a, $b| $value,
            slope_a: |$g, $ga, $gb, $gy| { let _ = (&$g, $ga, $gb, $gy); $slope_a },
            slope_b: |$g, $ga, $gb, $gy| { let _ = (&$g, $ga, $gb, $gy); $slope_b },
            kink: $kink,
            flops: $flops,
            latex: $latex,
            code: $code,
            about: $about,
        },)*];

        impl Binary {
            /// The row of this operation.
            pub fn row(self) -> &'static BinaryRow {
                &BINARY[self as usize]
            }

            /// `out[i] = op(a[i], b[i])`: one dispatch for all lanes, so that the loop inside vectorises.
            #[inline(always)]
            pub(crate) fn lanes<const N: usize>(self, a: &[f64; N], b: &[f64; N], out: &mut [f64; N]) {
                match self { $(Binary::$op => for i in 0..N { let ($a, $b) = (a[i], b[i]); out[i] = $value; },)* }
            }
        }
    };
}

/// What becomes of an expression when some of its symbols change their signs together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parity {
    /// It stays.
    Even,
    /// It changes its sign.
    Odd,
}

const ODD: Option<Parity> = Some(Parity::Odd);
const EVEN: Option<Parity> = Some(Parity::Even);

unary_table! {
    Neg  ""     |x| -x;            |g, x, y| g.constant(-1.0); []; ODD; false 0 "-#1" ["-#1", "-#1", "-#1"] "minus x"
    Abs  "abs"  |x| x.abs();       |g, x, y| g.unary(Unary::Sgn, x); [0.0]; EVEN; false 0 "\\left|#1\\right|" ["abs(#1)", "fabs(#1)", "abs(#1)"] "size of x, also written |x|"
    Sgn  "sgn"  |x| sign(x);       |g, x, y| g.constant(0.0); [0.0]; ODD; false 0 "\\operatorname{sgn}(#1)" ["sgn(#1)", "sgn(#1)", "sgn(#1)"] "-1, 0 or 1 with the sign of x"
    Step "step" |x| 0.5 + 0.5 * sign(x); |g, x, y| g.constant(0.0); [0.0]; None; false 2 "\\operatorname{step}(#1)" ["step(#1)", "step(#1)", "step(#1)"] "(1 + sgn x)/2: 0 before zero, 1 after"
    Rest "rest" |x| at_rest(x);    |g, x, y| g.constant(0.0); [0.0]; EVEN; false 0 "\\operatorname{rest}(#1)" ["rest(#1)", "rest(#1)", "rest(#1)"] "1 while x is zero, as the speed of a contact that sticks, else 0"
    Pos  "pos"  |x| if x <= 0.0 { 0.0 } else { x }; |g, x, y| g.unary(Unary::Step, x); [0.0]; None; false 0 "\\operatorname{pos}(#1)" ["pos(#1)", "pos(#1)", "pos(#1)"] "max(x, 0)"
    Ln   "ln"   |x| elementary::ln(x);        |g, x, y| { let one = g.constant(1.0); g.binary(Binary::Div, one, x) }; []; None; true 32 "\\ln(#1)" ["ln(#1)", "log(#1)", "log(#1)"] "natural logarithm"
    Exp  "exp"  |x| elementary::exp(x);       |g, x, y| y; []; None; true 39 "\\exp(#1)" ["exp(#1)", "exp(#1)", "exp(#1)"] "exponential"
    Sqrt "sqrt" |x| x.sqrt();      |g, x, y| { let half = g.constant(0.5); g.binary(Binary::Div, half, y) }; []; None; true 1 "\\sqrt{#1}" ["sqrt(#1)", "sqrt(#1)", "sqrt(#1)"] "square root"
    Sin  "sin"  |x| elementary::sin(x);       |g, x, y| g.unary(Unary::Cos, x); []; ODD; false 57 "\\sin(#1)" ["sin(#1)", "sin(#1)", "sin(#1)"] "sine (radians)"
    Cos  "cos"  |x| elementary::cos(x);       |g, x, y| { let s = g.unary(Unary::Sin, x); g.unary(Unary::Neg, s) }; []; EVEN; false 57 "\\cos(#1)" ["cos(#1)", "cos(#1)", "cos(#1)"] "cosine (radians)"
    Tan  "tan"  |x| x.tan();       |g, x, y| one_plus_square(g, y, Binary::Add); []; ODD; true 1 "\\tan(#1)" ["tan(#1)", "tan(#1)", "tan(#1)"] "tangent (radians)"
    Tanh "tanh" |x| x.tanh();      |g, x, y| one_plus_square(g, y, Binary::Sub); []; ODD; false 1 "\\tanh(#1)" ["math.tanh(#1)", "tanh(#1)", "tanh(#1)"] "hyperbolic tangent"
    Atan "atan" |x| x.atan();      |g, x, y| { let one = g.constant(1.0); let d = one_plus_square(g, x, Binary::Add); g.binary(Binary::Div, one, d) }; []; ODD; false 1 "\\arctan(#1)" ["math.atan(#1)", "atan(#1)", "atan(#1)"] "inverse tangent"
    Floor "floor" |x| x.floor();   |g, x, y| g.constant(0.0); WHOLE; None; false 0 "\\lfloor #1\\rfloor" ["floor(#1)", "floor(#1)", "floor(#1)"] "largest whole number that is at most x"
}

binary_table! {
    Add  "+" 1 |a, b| a + b; |g, a, b, y| g.constant(1.0), g.constant(1.0);  |_, _| f64::INFINITY; 1 "#1 + #2" ["#1 + #2", "#1 + #2", "#1 + #2"] "sum"
    Sub  "-" 1 |a, b| a - b; |g, a, b, y| g.constant(1.0), g.constant(-1.0); |_, _| f64::INFINITY; 1 "#1 - #2" ["#1 - #2", "#1 - #2", "#1 - #2"] "difference"
    Mul  "*" 2 |a, b| a * b; |g, a, b, y| b, a;                              |_, _| f64::INFINITY; 1 "#1\\,#2" ["#1*#2", "#1*#2", "#1*#2"] "product"
    Div  "/" 2 |a, b| a / b; |g, a, b, y| { let one = g.constant(1.0); g.binary(Binary::Div, one, b) },
        { let q = quotient_by(g, a, b, y); g.unary(Unary::Neg, q) };         |_, _| f64::INFINITY; 1 "\\frac{#1}{#2}" ["div(#1, #2)", "#1/#2", "#1/#2"] "quotient"
    Pow  "^" 4 |a, b| power(a, b); |g, a, b, y| { let one = g.constant(1.0); let n = g.binary(Binary::Sub, b, one); let p = g.binary(Binary::Pow, a, n); g.binary(Binary::Mul, b, p) },
        { let l = g.unary(Unary::Ln, a); g.binary(Binary::Mul, y, l) };      |_, _| f64::INFINITY; 1 "#1^{#2}" ["power(#1, #2)", "pow(#1, #2)", "#1^#2"] "power; an integer exponent takes any base"
    Min  "min" 0 |a, b| if a < b || a.is_nan() { a } else { b }; |g, a, b, y| step_between(g, a, b), step_between(g, b, a); |a, b| (a - b).abs(); 0 "\\min(#1, #2)" ["smaller(#1, #2)", "smaller(#1, #2)", "smaller(#1, #2)"] "the smaller"
    Max  "max" 0 |a, b| if a > b || a.is_nan() { a } else { b }; |g, a, b, y| step_between(g, b, a), step_between(g, a, b); |a, b| (a - b).abs(); 0 "\\max(#1, #2)" ["larger(#1, #2)", "larger(#1, #2)", "larger(#1, #2)"] "the larger"
    Dead "dead" 0 |a, b| dead(a, b); |g, a, b, y| outside(g, a, b),
        { let o = outside(g, a, b); let s = g.unary(Unary::Sgn, a); let p = g.binary(Binary::Mul, s, o); g.unary(Unary::Neg, p) };
        |a, b| if b < 0.0 { (a.abs() - b).min(a.abs()) } else { (a.abs() - b).abs() }; 1 "\\operatorname{dead}(#1, #2)" ["dead(#1, #2)", "dead(#1, #2)", "dead(#1, #2)"] "x outside +-g, less g; 0 inside"
    Mod "mod" 0 |a, b| a - b * (a / b).floor(); |g, a, b, y| g.constant(1.0),
        { let q = g.binary(Binary::Div, a, b); let n = g.unary(Unary::Floor, q); g.unary(Unary::Neg, n) };
        |a, b| ((a / b - (a / b).round()) * b).abs(); 4 "\\operatorname{mod}(#1, #2)" ["mod(#1, #2)", "modulo(#1, #2)", "mod(#1, #2)"] "what is left of a above the largest multiple of b that is at most a: from 0 up to b"
    Atan2 "atan2" 0 |a, b| a.atan2(b); |g, a, b, y| over_square(g, b, a), { let p = over_square(g, a, b); g.unary(Unary::Neg, p) };
        |a, b| if b < 0.0 { a.abs() } else { a.hypot(b) }; 1 "\\operatorname{atan2}(#1, #2)" ["math.atan2(#1, #2)", "atan2(#1, #2)", "atan2(#1, #2)"] "angle of the point with the abscissa b and the ordinate a, from -pi to pi (radians)"
    Gate "gate" 0 |a, b| if b > 0.0 { a } else { 0.0 }; |g, a, b, y| { let one = g.constant(1.0); g.binary(Binary::Gate, one, b) },
        g.constant(0.0); |_, b| b.abs(); 0 "\\operatorname{gate}(#1, #2)" ["gate(#1, #2)", "gate(#1, #2)", "gate(#1, #2)"] "a where b > 0, else 0, whatever a is"
    Masked "masked" 0 |a, b| if a == 0.0 || b == 0.0 { 0.0 } else { a * b }; |g, a, b, y| b, a; |_, _| f64::INFINITY; 1 "\\operatorname{masked}(#1, #2)" ["masked(#1, #2)", "masked(#1, #2)", "masked(#1, #2)"] "product in which zero wins, even over infinity; in derivatives below a gate"
    Hold "hold" 0 |a, _b| a; |g, a, b, y| g.constant(1.0), g.constant(0.0); |_, _| f64::INFINITY; 0 "\\operatorname{hold}(#1, #2)" ["(#1)", "(#1)", "(#1)"] "a as it was at the last multiple of the time b, as a digital controller sees and says it; `hold(a, b, c)` comes into force a time c later"
    Timing "timing" 0 |a, _b| a; |g, a, b, y| g.constant(1.0), g.constant(0.0); |_, _| f64::INFINITY; 0 "#1, #2" ["(#1)", "(#1)", "(#1)"] "period a and delay b of what is held"
}

/// Whole numbers about zero: `floor` jumps at each.
pub const WHOLE: [f64; 17] =
    [-8.0, -7.0, -6.0, -5.0, -4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];

/// Sign with `sgn(0) = 0`; NaN stays NaN.
#[inline(always)]
pub fn sign(x: f64) -> f64 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else {
        x * 0.0
    }
}

/// 1 at zero, else 0; NaN stays NaN.
#[inline(always)]
fn at_rest(x: f64) -> f64 {
    if x.is_nan() { x } else { f64::from(u8::from(x == 0.0)) }
}

/// Integer powers by repeated multiplication (exact for any base), all others by the library.
#[inline(always)]
fn power(a: f64, b: f64) -> f64 {
    if b.abs() <= 64.0 && b.fract() == 0.0 { a.powi(b as i32) } else { a.powf(b) }
}

#[inline(always)]
fn dead(x: f64, g: f64) -> f64 {
    let beyond = x.abs() - g;
    if beyond > 0.0 {
        sign(x) * beyond
    } else if beyond.is_nan() {
        beyond
    } else {
        0.0
    }
}

/// `1 +- x^2`.
fn one_plus_square(g: &mut Graph, x: Id, sign: Binary) -> Id {
    let one = g.constant(1.0);
    let square = g.binary(Binary::Mul, x, x);
    g.binary(sign, one, square)
}

/// `a/(a^2 + b^2)`.
fn over_square(g: &mut Graph, a: Id, b: Id) -> Id {
    let (a2, b2) = (g.binary(Binary::Mul, a, a), g.binary(Binary::Mul, b, b));
    let sum = g.binary(Binary::Add, a2, b2);
    g.binary(Binary::Div, a, sum)
}

/// `y/b` for `y = a/b`. For a number `a` it is `y^2/a`, because a division costs as much as ten products.
fn quotient_by(g: &mut Graph, a: Id, b: Id, y: Id) -> Id {
    let inverse = g.value(a).map(f64::recip).filter(|inverse| inverse.is_normal());
    let Some(inverse) = inverse else { return g.binary(Binary::Div, y, b) };
    let (inverse, square) = (g.constant(inverse), g.binary(Binary::Mul, y, y));
    g.binary(Binary::Mul, inverse, square)
}

/// 1 where `a < b`.
fn step_between(g: &mut Graph, a: Id, b: Id) -> Id {
    let d = g.binary(Binary::Sub, b, a);
    g.unary(Unary::Step, d)
}

/// 1 where `|x| > gap`.
fn outside(g: &mut Graph, x: Id, gap: Id) -> Id {
    let size = g.unary(Unary::Abs, x);
    step_between(g, gap, size)
}

/// A function by its name in the language. `gate`, `timing` and `masked` are internal and not offered.
pub fn function(name: &str) -> Option<Function> {
    let unary =
        UNARY.iter().filter(|r| !r.name.is_empty()).find(|r| r.name == name).map(|r| Function::One(r.op));
    unary.or_else(|| named_binary().find(|r| r.name == name).map(|r| Function::Two(r.op)))
}

/// Names of all functions, for hints.
pub fn function_names() -> impl Iterator<Item = &'static str> {
    UNARY.iter().map(|r| r.name).filter(|n| !n.is_empty()).chain(named_binary().map(|r| r.name))
}

fn named_binary() -> impl Iterator<Item = &'static BinaryRow> {
    BINARY
        .iter()
        .filter(|r| r.precedence == 0 && !matches!(r.op, Binary::Gate | Binary::Timing | Binary::Masked))
}

/// The operation behind a function name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Function {
    /// Takes one argument.
    One(Unary),
    /// Takes two arguments.
    Two(Binary),
}

impl Function {
    /// How many arguments it takes.
    pub fn arity(self) -> usize {
        match self {
            Function::One(_) => 1,
            Function::Two(_) => 2,
        }
    }
}
