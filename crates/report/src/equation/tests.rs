//! Specs in, equations out.

use super::*;
use phisindy_learn::{Estimate, ParameterId, ParameterOf};
use phisindy_phys::{SourceId, check, spec};

fn case(known: &str, unknown: &str, constants: &str) -> Case {
    let text = format!(
        "(constants: {{ {constants} }}, states: {{ \"x\": \"\", \"y\": \"\" }}, known: {{ \"x\": \"y\", \"y\": \"{known}\" }},
          unknown: {{ \"y\": {unknown} }},
          data: [Csv(path: \"a.csv\", time: \"t\", columns: {{ \"x\": \"x\" }})])"
    );
    let (spec, _) = spec::read(&text, SourceId(0)).expect("well formed");
    check(&spec, SourceId(0)).expect("a good case").0
}

fn found(coefficients: &[(usize, f64)]) -> Vec<FoundTerm> {
    coefficients.iter().map(|&(term, value)| FoundTerm::new(term, Estimate::normal(value, 0.01))).collect()
}

fn of(case: &Case, coefficients: &[(usize, f64)], parameters: &[FoundParameter]) -> Equation {
    let mut all = equations(case, &found(coefficients), parameters);
    assert_eq!(all.len(), 1);
    all.remove(0)
}

#[test]
fn one_term_is_one_product() {
    let case = case(
        "-c*y - k*x + cos(0.3*t)",
        "(factor: \"-sgn(y)\", candidates: [\"1\", \"x\"])",
        "\"c\": 0.1, \"k\": 1.0",
    );
    let e = of(&case, &[(0, 0.5019983)], &[]);
    assert_eq!(e.latex, r"\dot{y} = -0.1\,y - x + \cos\left(0.3\,t\right) - 0.502\,\operatorname{sgn}(y)");
    assert_eq!(e.text, "-0.1*y - x + cos(0.3*t) - 0.5019983*sgn(y)");
}

/// Of a mechanism the line is the balance of a momentum: no mass matrix is inverted in it.
#[test]
fn a_speed_of_a_mechanism_has_the_balance_of_its_momentum() {
    let text = r#"(inputs: { "F": "N" }, energy: (coordinates: { "x": ("v", "m"), "th": ("w", "rad") },
        kinetic: "3*v^2/2 + v*w*cos(th)/2 + w^2/6", potential: "20*x^2/2 - 5*cos(th)", dissipation: "v^2", forces: { "F": "v" }),
        unknown: { "v": (factor: "-sgn(v)", candidates: ["1"]) }, data: [])"#;
    let (spec, _) = spec::read_without_data(text, SourceId(0)).expect("well formed");
    let (case, _) = check(&spec, SourceId(0)).expect("a good case");
    let e = of(&case, &[(0, 2.5)], &[]);
    let left = r"\frac{d}{dt}\left(0.5\,\cos(\mathrm{th})\,w + 3\,v\right)";
    assert_eq!(e.latex, format!(r"{left} = -20\,x - 2\,v + F - 2.5\,\operatorname{{sgn}}(v)"));
}

#[test]
fn several_terms_stand_in_brackets_behind_their_factor() {
    let case = case(
        "-x",
        "(factor: \"-sgn(y)\", candidates: [\"1\", \"ln((|y|+eps)/V)\"])",
        "\"eps\": 1e-6, \"V\": 0.003",
    );
    let e = of(&case, &[(0, 0.5), (1, 0.07)], &[]);
    let logarithm = r"\ln\left(\frac{\left|y\right| + 10^{-6}}{0.003}\right)";
    assert_eq!(
        e.latex,
        format!(r"\dot{{y}} = -x - \operatorname{{sgn}}(y)\left[0.5 + 0.07\,{logarithm}\right]")
    );
    assert_eq!(e.text, "-x - sgn(y)*(0.5 + 0.07*ln((abs(y) + 1e-6)/0.003))");
}

#[test]
fn numbers_of_the_factor_go_into_the_coefficient() {
    let case = case("0", "(factor: \"-sgn(y)/m\", candidates: [\"1\"])", "\"m\": 4.0");
    assert_eq!(of(&case, &[(0, 2.0)], &[]).latex, r"\dot{y} = -0.5\,\operatorname{sgn}(y)");
}

#[test]
fn without_a_factor_the_terms_continue_the_sum() {
    let case = case(
        "t/M",
        "(factor: \"-1/M\", candidates: [\"y\", \"sgn(y)\", \"1\"])",
        "\"M\": (value: 90.0, within: (50.0, 150.0))",
    );
    let mass = FoundParameter {
        id: ParameterId { of: ParameterOf::Constant { index: 0, name: "M".into() }, owner: None },
        unit: "kg".into(),
        factor: 1.0,
        estimate: Estimate::normal(100.0, 1.0),
        bounds: (50.0, 150.0),
        at_bound: false,
    };
    let e = of(&case, &[(0, 200.0), (1, 20.0), (2, -3.0)], &[mass]);
    assert_eq!(e.latex, r"\dot{y} = 0.01\,t - 2\,y - 0.2\,\operatorname{sgn}(y) + 0.03");
    assert_eq!(e.text, "0.01*t - 2*y - 0.2*sgn(y) + 0.03");
}

#[test]
fn without_a_surviving_term_the_known_part_stands_alone() {
    let case = case("-x", "(candidates: [\"1\"])", "");
    assert_eq!(of(&case, &[], &[]).latex, r"\dot{y} = -x");
}

/// The LaTeX of `beta1` ends in that of `a1`, and was patched.
#[test]
fn a_derived_input_has_a_dot_and_no_other_name_changes() {
    let text = r#"(constants: { "beta1": (value: 0.7, within: (0.0, 2.0), each: true) },
        states: { "x": "", "y": "" }, inputs: { "v1": "", "a1": "", "r": "", "s": "" },
        known: { "x": "y", "y": "beta1*a1 - r*sqrt(s)" }, unknown: { "y": (candidates: ["1"]) },
        data: [Csv(path: "a.csv", time: "t", columns: { "x": "x", "v1": "v1", "s": "s" },
                   derive: { "a1": Derivative("v1"), "r": Derivative("s") })])"#;
    let (spec, _) = spec::read(text, SourceId(0)).expect("well formed");
    let case = check(&spec, SourceId(0)).expect("a good case").0;
    assert_eq!(of(&case, &[], &[]).latex, r"\dot{y} = \beta_{1}\,\dot{v}_{1} - \dot{s}\,\sqrt{s}");
}
