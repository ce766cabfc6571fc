use super::*;
use phisindy_signal::test_signals::gaussian;

/// The findings for a body on a spring to a moving base, driven by a force as well. `x` is measured, `v` is
/// not. Columns: x, u, F.
fn told(m: f64, c: f64, k: f64, order: [usize; 3], scale: [f64; 3]) -> String {
    let text = format!(
        r#"(constants: {{"m": ({m}, "kg"), "c": ({c}, "N*s/m"), "k": (value: {k}, unit: "N/m", within: (-1e9, 1e9))}}, states: {{"x": "m", "v": "m/s"}},
        inputs: {{"u": "m", "du": "m/s", "F": "N"}}, known: {{"x": "v", "v": "(-c*(v-du) - k*(x-u) + F)/m"}}, unknown: {{}},
        data: [Csv(path: "a.csv", name: "a", time: "t", columns: {{"x": "a", "u": "b", "F": "c"}}, derive: {{"du": Derivative("u")}})])"#
    );
    let mut sources = crate::text::diagnostic::Sources::default();
    let id = sources.add("spec", text.as_str());
    let (spec, _) = crate::text::spec::read(&text, id).unwrap();
    let (case, _) = crate::system::check::check(&spec, id).unwrap();
    let time: Vec<f64> = (0..2500).map(|i| 0.01 * f64::from(i)).collect();
    // 2 kg on 600 N/m, and friction of 0.5 N that the model lacks.
    let base = |t: f64| 4e-3 * (9.0 * t).sin() + 2e-3 * (23.0 * t + 1.0).sin();
    let slope = |t: f64| 36e-3 * (9.0 * t).cos() + 46e-3 * (23.0 * t + 1.0).cos();
    let force = |t: f64| 1.5 * (14.0 * t).cos();
    let (mut x, mut v, h) = (0.0_f64, 0.0_f64, 1e-4);
    let mut columns = [vec![], vec![], vec![]];
    let noise = gaussian(2500, 2);
    for (i, &start) in time.iter().enumerate() {
        columns[0].push(scale[0] * (x + 1e-4 * noise[i]));
        columns[1].push(scale[1] * base(start));
        columns[2].push(scale[2] * force(start));
        for s in 0..100 {
            let t = start + h * f64::from(s);
            let a =
                (-2.0 * (v - slope(t)) - 600.0 * (x - base(t)) + force(t) - 0.5 * (v / 1e-3).tanh()) / 2.0;
            v += h * a;
            x += h * v;
        }
    }
    let columns = order.map(|k| columns[k].clone()).to_vec();
    let table =
        crate::system::table::Table { time: time.clone(), columns, lines: vec![], ..Default::default() };
    let record = Record::from_table(&case.records[0], &table, &case.system, id).unwrap();
    let mut found = vec![];
    balance(&case.system, &record, &mut found);
    found.iter().map(Suspicion::to_string).collect::<Vec<_>>().join("; ")
}

const ORDER: [usize; 3] = [0, 1, 2];
const ONE: [f64; 3] = [1.0; 3];

#[test]
fn a_model_that_lacks_friction_or_is_a_little_off_is_not_told() {
    assert_eq!(told(2.0, 2.0, 600.0, ORDER, ONE), "");
    assert_eq!(told(2.5, 2.0, 500.0, ORDER, ONE), "");
    assert_eq!(told(2.0, 2.0, 1200.0, ORDER, ONE), "");
    assert_eq!(told(20.0, 2.0, 600.0, ORDER, ONE), "");
    // Too much by less than a thousand is no wrong unit, although leaving the part out would be better.
    assert_eq!(told(2.0, 30.0, 600.0, ORDER, ONE), "");
}

#[test]
fn a_unit_that_is_off_by_a_thousand_is_told() {
    let stiff = told(2.0, 2.0, 600e3, ORDER, ONE);
    assert!(stiff.contains("x - u") && stiff.contains("is 1/1000 times as"), "{stiff}");
    let soft = told(2.0, 2.0, 0.6, ORDER, ONE);
    assert!(soft.contains("x - u") && soft.contains("is 1000 times as"), "{soft}");
    let light = told(2e-3, 2.0, 600.0, ORDER, ONE);
    assert!(light.contains("its parts in") && light.contains("are 1/1000 times as"), "{light}");
    let force = told(2.0, 2.0, 600.0, ORDER, [1.0, 1.0, 1e6]);
    assert!(force.contains("in `F`") && force.contains("is 1/1000000 times as"), "{force}");
}

#[test]
fn a_column_in_the_wrong_unit_is_told_and_not_called_swapped() {
    let base = told(2.0, 2.0, 600.0, ORDER, [1e-3, 1.0, 1.0]);
    assert!(base.contains("the column `x` is 1000 times as large") && !base.contains("swapped"), "{base}");
    let far = told(2.0, 2.0, 600.0, ORDER, [1e3, 1.0, 1.0]);
    assert!(far.contains("the column `x` is 1/1000 times as large"), "{far}");
}

#[test]
fn a_sign_that_is_wrong_is_told() {
    let force = told(2.0, 2.0, 600.0, ORDER, [1.0, 1.0, -1.0]);
    assert!(force.contains("in `F`") && force.contains("changes its sign"), "{force}");
    let spring = told(2.0, 2.0, -600.0, ORDER, ONE);
    assert!(spring.contains("changes its sign"), "{spring}");
    // With two drives no single part can take the place of the sign of the motion.
    let motion = told(2.0, 2.0, 600.0, ORDER, [-1.0, 1.0, 1.0]);
    assert!(motion.contains("the column `x` changes its sign"), "{motion}");
}

#[test]
fn a_state_and_an_input_that_are_swapped_are_told() {
    let swapped = told(2.0, 2.0, 600.0, [1, 0, 2], ONE);
    assert!(swapped.contains("with `x` and `u` exchanged"), "{swapped}");
}

/// The findings for a pendulum that swings about the angle `hangs`, its sensor as the spec says.
fn swing(hangs: f64, sensor: &str) -> String {
    let text = format!(
        r#"(constants: {{"k": (30.0, "1/s^2")}}, states: {{"theta": "rad", "w": "rad/s"}}, known: {{"theta": "w", "w": "-k*sin(theta)"}},
        unknown: {{}}, data: [Csv(path: "a.csv", name: "a", time: "t", columns: {{"theta": "a"}}{sensor})])"#
    );
    let mut sources = crate::text::diagnostic::Sources::default();
    let id = sources.add("spec", text.as_str());
    let (spec, _) = crate::text::spec::read(&text, id).unwrap();
    let (case, _) = crate::system::check::check(&spec, id).unwrap();
    let time: Vec<f64> = (0..2000).map(|i| 0.01 * f64::from(i)).collect();
    let (mut theta, mut w) = (1.2_f64, 0.0_f64);
    let mut column = vec![];
    for _ in &time {
        column.push(hangs + theta);
        for _ in 0..10 {
            w += 1e-3 * (-30.0 * theta.sin() - 0.05 * w);
            theta += 1e-3 * w;
        }
    }
    let table =
        crate::system::table::Table { time, columns: vec![column], lines: vec![], ..Default::default() };
    let record = Record::from_table(&case.records[0], &table, &case.system, id).unwrap();
    let mut found = vec![];
    balance(&case.system, &record, &mut found);
    found.iter().map(Suspicion::to_string).collect::<Vec<_>>().join("; ")
}

#[test]
fn a_pendulum_that_hangs_at_pi_has_the_right_sign() {
    let offset = |start: f64, reach: f64| {
        let (low, high) = (start - reach, start + reach);
        format!(
            ", sensors: {{\"theta\": (offset: Find(start: {start:?}, unit: \"rad\", within: ({low:?}, {high:?})))}}"
        )
    };
    assert_eq!(swing(0.0, ""), "");
    assert_eq!(swing(PI, &offset(3.0, 0.5)), "");
    assert_eq!(swing(PI, &offset(0.0, 4.0)), "");
    // Nothing says that the angle is counted from the upright.
    let said = swing(PI, "");
    assert!(said.contains("sin(theta)` changes its sign") && said.contains("the zero"), "{said}");
    assert!(swing(PI, &offset(0.0, 0.5)).contains("changes its sign"));
}

#[test]
fn sums_come_apart() {
    let model = crate::system::model::Model::build(
        &["x", "v"],
        &["u"],
        &["k", "m"],
        &["v", "(-2*v - k*(x-u) + 3*(u + 4*x))/m + 1"],
    )
    .unwrap();
    let mut graph = model.graph.clone();
    let all = parts(&mut graph, model.rates[1]);
    assert_eq!(all.len(), 4);
}
