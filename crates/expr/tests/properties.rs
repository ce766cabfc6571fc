//! What is told of an expression without its numbers, against its values.

use crate::common::*;
use phisindy_expr::Parity;
use proptest::prelude::*;

/// Of both signs, some of them whole.
fn place() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(prop_oneof![-3.0..3.0_f64, plain_number()])
}

proptest! {
    #![proptest_config(cases(3000))]

    #[test]
    fn parity_is_what_a_change_of_signs_does(steps in steps(any_step(true, plain_number()), 12), at in place()) {
        let mut bench = Bench::new();
        let [x, y, _] = bench.xyz;
        for id in bench.build(&steps) {
            let parity = bench.graph.parity(id, &[x, y]);
            let value = bench.at(&[id], at)[0];
            let turned = bench.at(&[id], [-at[0], -at[1], at[2]])[0];
            // One over zero is infinite with a sign that is nobody's.
            if !(value.is_finite() && turned.is_finite()) {
                break;
            }
            let Some(parity) = parity else { continue };
            let expected = if parity == Parity::Odd { -value } else { value };
            // Each operation treats both signs alike, to the last bit; the library's own but nearly.
            let near = (turned - expected).abs() <= 1e-9 * value.abs();
            prop_assert!(turned == expected || near,
                "{}: {value} and {turned}", bench.text(id));
        }
    }

    #[test]
    fn values_lie_within_their_range(steps in steps(any_step(true, plain_number()), 12), at in place(), room in place()) {
        let mut bench = Bench::new();
        let bounds = |k: usize| (at[k].min(at[k] + room[k]), at[k].max(at[k] + room[k]));
        let within: Vec<_> = bench.xyz.iter().enumerate().map(|(k, &id)| (id, bounds(k))).collect();
        for id in bench.build(&steps) {
            let (low, high) = bench.graph.range(id, &within);
            let value = bench.at(&[id], at)[0];
            let slack = 1e-9 * (1.0 + value.abs());
            let inside = low - slack <= value && value <= high + slack;
            if !value.is_finite() {
                break;
            }
            prop_assert!(inside, "{}: {value} not in {low}..{high}", bench.text(id));
        }
    }
}
