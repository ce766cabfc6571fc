//! Structures from matrices, and tables: what a spec with files means.

use approx::assert_relative_eq;
use phisindy_expr::{Scratch, Tape};
use phisindy_phys::{Case, Diagnostic, Files, Numbers, SourceId, check, named_files, spec};

type Matrix = Vec<Vec<f64>>;

const M: [[f64; 3]; 3] = [[2.0, 0.3, 0.0], [0.3, 1.5, 0.2], [0.0, 0.2, 1.0]];
const K: [[f64; 3]; 3] = [[50.0, -20.0, 0.0], [-20.0, 45.0, -25.0], [0.0, -25.0, 30.0]];
// Not a combination of both: the modes do not decouple it.
const C: [[f64; 3]; 3] = [[0.8, 0.0, 0.0], [0.0, 0.1, -0.1], [0.0, -0.1, 0.5]];

fn numbers(rows: &[&[f64]]) -> Numbers {
    Numbers { columns: rows[0].len(), values: rows.concat(), headings: vec![] }
}

fn files(text: &str, more: &[(&str, Numbers)]) -> Files {
    let of = |rows: &[[f64; 3]; 3]| numbers(&rows.each_ref().map(|row| &row[..]));
    let own = |path: &str| match path {
        "M" => of(&M),
        "K" => of(&K),
        "C" => of(&C),
        _ => more.iter().find(|(name, _)| *name == path).map(|(_, n)| n.clone()).expect("a file"),
    };
    named_files(text).into_iter().map(|file| (file.clone(), own(&file.path))).collect()
}

fn checked(text: &str, more: &[(&str, Numbers)]) -> Result<Case, Vec<Diagnostic>> {
    let (spec, _) = spec::read_in_memory(text, SourceId(0), &files(text, more))?;
    check(&spec, SourceId(0)).map(|(case, _)| case)
}

fn structure(fields: &str) -> String {
    format!(
        "(inputs: {{ \"F\": \"N\" }}, structure: (mass: \"M\", stiffness: \"K\", coordinates: \"q\", {fields}))"
    )
}

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    let entry = |row: &Vec<f64>, j: usize| row.iter().zip(b).map(|(x, other)| x * other[j]).sum();
    a.iter().map(|row| (0..b[0].len()).map(|j| entry(row, j)).collect()).collect()
}

/// `A` and `B` of `y' = A y + B F`.
fn linear(case: &Case) -> (Matrix, Matrix) {
    let system = &case.system;
    let nodes: Vec<_> = system.states.iter().map(|s| s.node).chain([system.inputs[0].node]).collect();
    let tape = Tape::compile(&system.graph, &nodes, &system.known).expect("a tape");
    let mut scratch = Scratch::<1>::new(&tape);
    let n = system.states.len();
    let column = |k: usize, scratch: &mut Scratch<1>| -> Vec<f64> {
        scratch.at((0..=n).map(|j| f64::from(u8::from(j == k))));
        (0..n).map(|i| scratch.output(i)[0]).collect()
    };
    let columns: Matrix = (0..=n).map(|k| column(k, &mut scratch)).collect();
    let rows = |range: std::ops::Range<usize>| -> Matrix {
        (0..n).map(|i| range.clone().map(|j| columns[j][i]).collect()).collect()
    };
    (rows(0..n), rows(n..n + 1))
}

/// The inverse of `M` by Cramer's rule.
fn inverse(m: &[[f64; 3]; 3]) -> Matrix {
    let minor = |i: usize, j: usize| {
        let [a, b] = [(i + 1) % 3, (i + 2) % 3];
        let [c, d] = [(j + 1) % 3, (j + 2) % 3];
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    };
    let all: f64 = (0..3).map(|j| m[0][j] * minor(0, j)).sum();
    (0..3).map(|i| (0..3).map(|j| minor(j, i) / all).collect()).collect()
}

/// Both have the same motion of each point under any force if all their Markov parameters `c A^k b` agree.
#[test]
fn points_move_as_the_matrices_say() {
    let text =
        structure("damping: \"C\", points: { \"a\": 1, \"mean\": (row: \"row\") }, forces: { \"F\": \"a\" }");
    let row = numbers(&[&[0.0, 0.5, 0.5]]);
    let case = checked(&text, &[("row", row)]).expect("a case");
    assert_eq!(
        case.system.states.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(),
        ["q_a", "q_a_speed", "q_mean", "q_mean_speed", "q_mode3", "q_mode3_speed"]
    );
    let (a, b) = linear(&case);
    // The matrices themselves: displacements, then speeds.
    let inverse = inverse(&M);
    let block = |of: &[[f64; 3]; 3]| times(&inverse, &of.iter().map(|row| row.to_vec()).collect());
    let (k, c) = (block(&K), block(&C));
    let plain: Matrix = (0..6)
        .map(|i| {
            (0..6)
                .map(|j| match (i < 3, j < 3) {
                    (true, _) => f64::from(u8::from(j == i + 3)),
                    (false, true) => -k[i - 3][j],
                    (false, false) => -c[i - 3][j - 3],
                })
                .collect()
        })
        .collect();
    let mut physical: Matrix = (0..6).map(|i| vec![if i < 3 { 0.0 } else { inverse[i - 3][0] }]).collect();
    let mut modal = b;
    for order in 0..12 {
        let (first, mean) = (physical[0][0], 0.5 * (physical[1][0] + physical[2][0]));
        assert_relative_eq!(modal[0][0], first, max_relative = 1e-9, epsilon = 1e-9);
        assert_relative_eq!(modal[2][0], mean, max_relative = 1e-9, epsilon = 1e-9);
        assert!(order == 0 || first != 0.0);
        (physical, modal) = (times(&plain, &physical), times(&a, &modal));
    }
    // What a force at the point feels at once: 1/(e' M^-1 e).
    let own = case.system.inertia[1].expect("an inertia");
    assert_relative_eq!(
        case.system.graph.value(own).expect("a number"),
        1.0 / inverse[0][0],
        max_relative = 1e-12
    );
}

/// Two equal masses between three equal springs: together they swing at `w^2 = 1`, against each other at 3.
#[test]
fn a_band_keeps_its_modes_and_says_so() {
    let text = structure("damping: 0.05, band: (0.0, 0.2), points: { \"a\": 1 }, forces: { \"F\": \"a\" }")
        .replace("\"M\"", "\"one\"")
        .replace("\"K\"", "\"springs\"");
    let more =
        [("one", numbers(&[&[1.0, 0.0], &[0.0, 1.0]])), ("springs", numbers(&[&[2.0, -1.0], &[-1.0, 2.0]]))];
    let (spec, _) = spec::read_in_memory(&text, SourceId(0), &files(&text, &more)).expect("a spec");
    let note = spec.structure.as_ref().and_then(spec::StructureSpec::note).expect("a note");
    assert!(note.contains("2 degrees of freedom") && note.contains("1 modes, up to 0.1592 Hz"), "{note}");
    let (a, b) = linear(&checked(&text, &more).expect("a case"));
    let due = [(a[1][0], -1.0), (a[1][1], -0.1), (b[1][0], 0.5)];
    due.into_iter().for_each(|(own, due)| assert_relative_eq!(own, due, max_relative = 1e-12));
}

#[test]
fn mistakes_of_a_structure_are_told_where_they_are() {
    let more = [
        ("skew", numbers(&[&[1.0, 2.0, 0.0], &[0.0, 1.0, 0.0], &[0.0, 0.0, 1.0]])),
        ("light", numbers(&[&[1.0, 0.0, 0.0], &[0.0, 0.0, 0.0], &[0.0, 0.0, 1.0]])),
        ("soft", numbers(&[&[1.0, 0.0, 0.0], &[0.0, -1.0, 0.0], &[0.0, 0.0, 1.0]])),
        ("flat", numbers(&[&[1.0, 0.0, 0.0]])),
        ("short", numbers(&[&[1.0, 0.0]])),
    ];
    let good = "points: { \"a\": 1 }";
    for (text, due, at) in [
        (structure(good).replace("\"K\"", "\"skew\""), "its entry (2, 1) is 0, and (1, 2) is 2", "skew"),
        (structure(good).replace("\"M\"", "\"light\""), "not positive definite: row 2", "light"),
        (structure(good).replace("\"K\"", "\"soft\""), "the stiffness matrix is not positive", "soft"),
        (structure(good).replace("\"K\"", "\"flat\""), "has 1 x 3 numbers", "flat"),
        (structure("points: { \"a\": 4 }"), "no degree of freedom 4 among 3", "4"),
        (structure("points: { \"a\": 0 }"), "no degree of freedom 0 among 3", "0"),
        (structure("points: { \"a\": (row: \"short\") }"), "has 2 numbers", "short"),
        (structure("points: { \"a\": 1, \"b\": (row: \"flat\") }"), "follows from the points before it", "b"),
        (structure("points: { \"a\": 1, \"b\": 2 }, modes: 1"), "follows from the points before it", "b"),
        (structure(&format!("{good}, band: (1e3, 1e4)")), "no mode lies in the band", "K"),
        (structure(&format!("{good}, forces: {{ \"F\": \"b\" }}")), "unknown point `b`", "b"),
        (
            structure(&format!("{good}, forces: {{ \"F\": \"2*F\" }}")),
            "is no point and no speed of points",
            "2*F",
        ),
        (structure(&format!("{good}, forces: {{ \"q_a\": \"a\" }}")), "a force at a point", "q_a"),
    ] {
        // Only stated units are checked against each other.
        let text = text.replacen('(', "(constants: { \"g\": (1.0, \"m/s^2\") }, ", 1);
        let found = checked(&text, &more).expect_err(&text);
        let d = found.iter().find(|d| d.message.contains(due)).unwrap_or_else(|| panic!("{text}\n{found:?}"));
        let span = d.labels.first().expect("a place").span;
        assert_eq!(&text[span.range()], at, "{d:?}");
    }
}

/// The argument has the unit of the first column, the value that of the second, whatever their scale.
#[test]
fn a_table_has_the_units_of_its_headings() {
    let text = |argument: &str| {
        format!(
            "(states: {{ \"x\": \"m\", \"v\": \"m/s\" }}, constants: {{ \"m\": (2.0, \"kg\") }},
              known: {{ \"x\": \"v\", \"v\": \"-table('spring.csv', {argument})/m\" }})"
        )
    };
    let heading = |name: &str, unit: &str| (name.to_owned(), Some(unit.to_owned()));
    let spring = Numbers {
        columns: 2,
        values: vec![-10.0, -1.0, 0.0, 0.0, 10.0, 3.0],
        headings: vec![heading("x", "mm"), heading("F", "kN")],
    };
    let more = [("spring.csv", spring)];
    let case = checked(&text("x"), &more).expect("a case");
    let system = &case.system;
    let tape = Tape::compile(&system.graph, &[system.states[0].node], &system.known[1..]).expect("a tape");
    let mut scratch = Scratch::<1>::new(&tape);
    for (x, due) in [(-0.005, 250.0), (0.002, -300.0), (0.02, -3000.0)] {
        assert_relative_eq!(scratch.at([x]).output(0)[0], due, max_relative = 1e-12);
    }
    let found = checked(&text("v"), &more).expect_err("a mistake");
    assert!(
        found[0].message.contains("the first column of this table is m, and its argument is m/s"),
        "{found:?}"
    );
    let backwards = [("spring.csv", numbers(&[&[0.0, 1.0], &[1.0, 2.0], &[0.5, 3.0]]))];
    let found = checked(&text("x"), &backwards).expect_err("a mistake");
    assert!(found[0].message.contains("row 3 has 0.5"), "{found:?}");
}
