//! Expressions as Python and C, run by a Python and a C compiler, against our own values.

use crate::common::*;
use phisindy_expr::ops::{BINARY, UNARY};
use phisindy_expr::{Id, Language, Naming};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use std::fmt::Write;
use std::path::PathBuf;
use std::process::Command;

/// How many random expressions are looked at, and at how many points each.
const EXPRESSIONS: usize = 400;
const POINTS: [[f64; 3]; 4] = [[0.3, 1.7, -2.6], [-0.4, 2.2, 0.9], [0.0, -1.3, 4.1], [1e-6, 0.0, -0.5]];

/// Everything of every sign and size that an operation may treat in its own way.
const SPECIAL: [f64; 19] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    -0.5,
    2.0,
    -2.0,
    3.0,
    -7.25,
    65.0,
    1e-6,
    1e300,
    -1e300,
    1e-300,
    5e-324,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
];

/// The program that prints the bits of every root at every point.
fn program(bench: &Bench, roots: &[Id], points: &[[f64; 3]], language: Language) -> String {
    let naming = Naming {
        symbol: &|s| bench.names.name(s).to_owned(),
        temporary: &|k| format!("q{k}"),
        moving: &bench.xyz,
    };
    let code = bench.graph.code(roots, language, &naming);
    let number = |x: &f64| match (language, x.is_nan(), x.is_infinite()) {
        (Language::C, true, _) => "NAN".to_owned(),
        (Language::C, _, true) => format!("{}INFINITY", if *x < 0.0 { "-" } else { "" }),
        (_, true, _) => "math.nan".to_owned(),
        (_, _, true) => format!("{}math.inf", if *x < 0.0 { "-" } else { "" }),
        _ => format!("{x:?}"),
    };
    let mut out = String::new();
    if language == Language::Python {
        out += "import math\nimport struct\n\n";
        out += language.helpers();
        out += "\ndef f(x, y, z):\n";
        code.temporaries.iter().for_each(|(name, value)| writeln!(out, "    {name} = {value}").unwrap());
        out += "    return [\n";
        code.roots.iter().for_each(|root| writeln!(out, "        {root},").unwrap());
        out += "    ]\n";
        for p in points {
            let at = p.each_ref().map(number).join(", ");
            writeln!(out, "for r in f({at}):\n    print(struct.unpack('<Q', struct.pack('<d', r))[0])")
                .unwrap();
        }
    } else {
        out += "#include <math.h>\n#include <stdio.h>\n#include <string.h>\n#include <stdint.h>\n";
        out += language.helpers();
        out += "static void f(double x, double y, double z, double *out)\n{\n";
        code.temporaries
            .iter()
            .for_each(|(name, value)| writeln!(out, "    double {name} = {value};").unwrap());
        code.roots.iter().enumerate().for_each(|(k, root)| writeln!(out, "    out[{k}] = {root};").unwrap());
        writeln!(out, "}}\nint main(void)\n{{\n    static double out[{}];\n    uint64_t bits;", roots.len())
            .unwrap();
        for p in points {
            let at = p.each_ref().map(number).join(", ");
            writeln!(out, "    f({at}, out);").unwrap();
            writeln!(out, "    for (int k = 0; k < {}; k++) {{ memcpy(&bits, &out[k], 8); printf(\"%llu\\n\", (unsigned long long)bits); }}", roots.len())
                .unwrap();
        }
        out += "    return 0;\n}\n";
    }
    out
}

/// What the program prints, as rows of numbers for each point.
fn values(bench: &Bench, name: &str, roots: &[Id], points: &[[f64; 3]], language: Language) -> Vec<Vec<f64>> {
    let folder: PathBuf = std::env::temp_dir().join(format!("phisindy-code-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    let text = program(bench, roots, points, language);
    let output = if language == Language::Python {
        let file = folder.join("f.py");
        std::fs::write(&file, text).expect("written");
        Command::new("python3").arg(&file).output().expect("python3 runs")
    } else {
        let (file, made) = (folder.join("f.c"), folder.join("f"));
        std::fs::write(&file, text).expect("written");
        // Products must not be fused into sums: that rounds once where we round twice.
        let flags = [
            "-std=c99",
            "-O1",
            "-ffp-contract=off",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-Wno-unused-parameter",
            "-Wno-div-by-zero",
        ];
        let built = Command::new("cc")
            .args(flags)
            .arg(&file)
            .arg("-o")
            .arg(&made)
            .arg("-lm")
            .output()
            .expect("cc runs");
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
        Command::new(made).output().expect("the program runs")
    };
    let _ = std::fs::remove_dir_all(&folder);
    assert!(output.status.success(), "{language:?}: {}", String::from_utf8_lossy(&output.stderr));
    let out = String::from_utf8(output.stdout).expect("numbers");
    let all: Vec<f64> = out.lines().map(|l| f64::from_bits(l.parse().expect("bits"))).collect();
    all.chunks(roots.len()).map(<[f64]>::to_vec).collect()
}

/// Equal in kind, and in value to what two mathematical libraries agree on.
fn agree(ours: f64, theirs: f64, relative: f64) -> bool {
    same(ours, theirs) || ours == theirs || close(ours, theirs, relative, 1e-300)
}

/// The name of an operation and its value.
type Row = (String, Box<dyn Fn(f64, f64) -> f64>);

fn every_operation_is_the_same(language: Language) {
    let mut bench = Bench::new();
    let [x, y, _] = bench.xyz;
    let mut roots = Vec::new();
    let mut rows: Vec<Row> = Vec::new();
    for row in UNARY {
        roots.push(bench.graph.unary(row.op, x));
        rows.push((format!("{:?}", row.op), Box::new(|x, _| (row.value)(x))));
    }
    for row in BINARY {
        roots.push(bench.graph.binary(row.op, x, y));
        rows.push((format!("{:?}", row.op), Box::new(|x, y| (row.value)(x, y))));
    }
    let points: Vec<[f64; 3]> = SPECIAL.iter().flat_map(|&x| SPECIAL.map(|y| [x, y, 0.0])).collect();
    let found = values(&bench, &format!("rows-{language:?}"), &roots, &points, language);
    assert_eq!(found.len(), points.len());
    for (row, [x, y, _]) in found.iter().zip(&points) {
        for (&theirs, (name, value)) in row.iter().zip(&rows) {
            let ours = value(*x, *y);
            // Whole powers by repeated multiplication lose up to 64 roundings, and beyond the smallest normal
            // number all digits.
            assert!(
                agree(ours, theirs, 2e-14),
                "{language:?} {name}({x:?}, {y:?}): {theirs:?}, ours {ours:?}"
            );
        }
    }
}

#[test]
fn every_operation_is_the_same_in_python() {
    every_operation_is_the_same(Language::Python);
}

#[test]
fn every_operation_is_the_same_in_c() {
    every_operation_is_the_same(Language::C);
}

fn random_expressions_are_the_same(language: Language) {
    let mut bench = Bench::new();
    let mut runner = TestRunner::new(cases(1));
    let strategy = steps(any_step(true, plain_number()), 24);
    let roots: Vec<Id> = (0..EXPRESSIONS)
        .map(|_| {
            let steps = strategy.new_tree(&mut runner).expect("a list of steps").current();
            *bench.build(&steps).last().expect("three symbols at least")
        })
        .collect();
    let found = values(&bench, &format!("random-{language:?}"), &roots, &POINTS, language);
    let mut looked = 0;
    for (row, point) in found.iter().zip(POINTS) {
        let ours = bench.at(&roots, point);
        // Where a tiny change of the arguments changes the value, libraries may differ: such points say
        // nothing.
        let [x, y, z] = point;
        let near =
            bench.at(&roots, [x * (1.0 + 3e-13) + 1e-16, y * (1.0 - 2e-13) - 2e-16, z * (1.0 + 5e-13)]);
        for k in (0..roots.len()).filter(|&k| agree(ours[k], near[k], 1e-10)) {
            looked += 1;
            assert!(
                agree(ours[k], row[k], 1e-11),
                "{language:?} {} at {point:?}: {:?}, ours {:?}",
                bench.text(roots[k]),
                row[k],
                ours[k]
            );
        }
    }
    assert!(looked > EXPRESSIONS * POINTS.len() * 3 / 4, "only {looked} values could be compared");
}

#[test]
fn random_expressions_are_the_same_in_python() {
    random_expressions_are_the_same(Language::Python);
}

#[test]
fn random_expressions_are_the_same_in_c() {
    random_expressions_are_the_same(Language::C);
}

#[test]
fn what_is_deep_is_cut_so_that_any_compiler_takes_it() {
    let mut bench = Bench::new();
    let [x, y, _] = bench.xyz;
    // x/(1 + y/(1 + x/(...))), three hundred deep.
    let one = bench.graph.constant(1.0);
    let mut deep = one;
    for k in 0..300 {
        let below = bench.graph.add(one, deep);
        deep = bench.graph.div(if k % 2 == 0 { x } else { y }, below);
    }
    let point = [1.2, 0.7, 0.0];
    let ours = bench.at(&[deep], point)[0];
    for language in [Language::Python, Language::C] {
        let theirs = values(&bench, &format!("deep-{language:?}"), &[deep], &[point], language)[0][0];
        assert!(agree(ours, theirs, 1e-13), "{language:?}: {theirs}, ours {ours}");
    }
}

#[test]
fn modelica_writes_what_its_grammar_takes() {
    let mut bench = Bench::new();
    let texts = [
        ("-x*y + z", "-x*y + z"),
        ("x - (-y)*2", "x + 2.0*y"),
        ("(x^y)^z", "(x^y)^z"),
        ("x^(-2)", "x^(-2.0)"),
        ("x/(y/z)", "x/(y/z)"),
        ("min(ln(x), y)*exp(-z)", "smaller(log(x), y)*exp(-z)"),
    ];
    for (ours, modelica) in texts {
        let root = bench.read(ours);
        let names = &bench.names;
        let naming = Naming {
            symbol: &|s| names.name(s).to_owned(),
            temporary: &|k| format!("q{k}"),
            moving: &bench.xyz,
        };
        assert_eq!(bench.graph.code(&[root], Language::Modelica, &naming).roots, [modelica], "{ours}");
    }
}
