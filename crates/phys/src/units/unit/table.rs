//! The units that are known by name.

use super::dimension::Dimension;
use std::f64::consts::PI;

/// Name, factor to SI, powers of kg, m, s, A, K, and whether it takes prefixes.
type Row = (&'static str, f64, [i8; 5], bool);

#[rustfmt::skip]
const UNITS: &[Row] = &[
    ("m",    1.0,          [0, 1, 0, 0, 0],   true),
    ("in",   0.0254,       [0, 1, 0, 0, 0],   false),
    ("inch", 0.0254,       [0, 1, 0, 0, 0],   false),
    ("ft",   0.3048,       [0, 1, 0, 0, 0],   false),
    ("g",    1e-3,         [1, 0, 0, 0, 0],   true),
    ("t",    1e3,          [1, 0, 0, 0, 0],   false),
    ("s",    1.0,          [0, 0, 1, 0, 0],   true),
    ("min",  60.0,         [0, 0, 1, 0, 0],   false),
    ("h",    3600.0,       [0, 0, 1, 0, 0],   false),
    ("d",    86_400.0,     [0, 0, 1, 0, 0],   false),
    ("A",    1.0,          [0, 0, 0, 1, 0],   true),
    ("K",    1.0,          [0, 0, 0, 0, 1],   true),
    ("Hz",   1.0,          [0, 0, -1, 0, 0],  true),
    ("rpm",  PI / 30.0,    [0, 0, -1, 0, 0],  false),
    ("rad",  1.0,          [0, 0, 0, 0, 0],   true),
    ("deg",  PI / 180.0,   [0, 0, 0, 0, 0],   false),
    ("°",    PI / 180.0,   [0, 0, 0, 0, 0],   false),
    ("rev",  2.0 * PI,     [0, 0, 0, 0, 0],   false),
    ("turn", 2.0 * PI,     [0, 0, 0, 0, 0],   false),
    // What an encoder or a converter counts, before anybody says how much of what that is.
    ("count", 1.0,         [0, 0, 0, 0, 0],   false),
    ("%",    1e-2,         [0, 0, 0, 0, 0],   false),
    ("N",    1.0,          [1, 1, -2, 0, 0],  true),
    ("lbf",  4.448_221_615_260_5, [1, 1, -2, 0, 0], false),
    ("kgf",  9.806_65,     [1, 1, -2, 0, 0],  false),
    ("Nm",   1.0,          [1, 2, -2, 0, 0],  true),
    // Standard gravity, in which accelerometers count; `g` is the gram.
    ("gn",   9.806_65,     [0, 1, -2, 0, 0],  true),
    ("Pa",   1.0,          [1, -1, -2, 0, 0], true),
    ("psi",  6_894.757_293_168, [1, -1, -2, 0, 0], false),
    ("bar",  1e5,          [1, -1, -2, 0, 0], true),
    ("J",    1.0,          [1, 2, -2, 0, 0],  true),
    ("W",    1.0,          [1, 2, -3, 0, 0],  true),
    ("L",    1e-3,         [0, 3, 0, 0, 0],   true),
    ("C",    1.0,          [0, 0, 1, 1, 0],   true),
    ("V",    1.0,          [1, 2, -3, -1, 0], true),
    ("ohm",  1.0,          [1, 2, -3, -2, 0], true),
    ("Ω",    1.0,          [1, 2, -3, -2, 0], true),
    ("F",    1.0,          [-1, -2, 4, 2, 0], true),
    ("H",    1.0,          [1, 2, -2, -2, 0], true),
    ("Wb",   1.0,          [1, 2, -2, -1, 0], true),
    ("T",    1.0,          [1, 0, -2, -1, 0], true),
];

/// Both signs for micro are in use: the micro sign and the Greek letter.
const PREFIXES: &[(&str, f64)] = &[
    ("n", 1e-9),
    ("u", 1e-6),
    ("µ", 1e-6),
    ("μ", 1e-6),
    ("m", 1e-3),
    ("c", 1e-2),
    ("d", 1e-1),
    ("k", 1e3),
    ("M", 1e6),
    ("G", 1e9),
];

/// Factor to SI and dimension of the unit of this name, perhaps with a prefix. A name that stands in the
/// table is never taken apart: `min` is no milli-inch.
pub(super) fn find(name: &str) -> Option<(f64, Dimension)> {
    let unit = |&(_, factor, [kg, m, s, a, k], _): &Row, prefix: f64| {
        (factor * prefix, Dimension::new(kg, m, s, a, k))
    };
    if let Some(row) = UNITS.iter().find(|row| row.0 == name) {
        return Some(unit(row, 1.0));
    }
    PREFIXES.iter().find_map(|(prefix, factor)| {
        let base = name.strip_prefix(prefix)?;
        UNITS.iter().find(|row| row.3 && row.0 == base).map(|row| unit(row, *factor))
    })
}

/// Names to suggest.
///
/// ```
/// use phisindy_phys::unit::{Unit, names};
/// assert!(names().all(|name| Unit::parse(name).is_ok()));
/// ```
pub fn names() -> impl Iterator<Item = &'static str> {
    UNITS.iter().map(|row| row.0).chain(["kg", "mm", "um", "ms", "kN"])
}
