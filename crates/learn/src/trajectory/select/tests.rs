//! On models that are linear in all that is unknown the quadratic model of the cost is the cost: what it
//! promises is what a fit of those terms has.

use super::*;
use crate::line_models::{STEP, fitted_terms, records, scatter};
use approx::assert_relative_eq;
use phisindy_phys::spec::{Role, SegmentsSpec};
use phisindy_phys::{Case, Record};
use phisindy_sim::Stop;

const SIGMA: f64 = 0.1;
const SAMPLES: usize = 80;

/// Four terms of one equation and two of another one, of which the data hold `1` and `2*t` of the first, and
/// `1` of the second; a little of the others is noise.
fn two_equations(within: &str) -> (Case, Vec<Record>) {
    let noise = scatter(2 * SAMPLES);
    let time = |i: usize| STEP * i as f64;
    let x: Vec<f64> =
        (0..SAMPLES).map(|i| 0.3 + 0.5 * time(i) - 0.2 * time(i).powi(2) + SIGMA * noise[i]).collect();
    let (case, mut records) = records(
        &format!(
            r#"states: {{"x": "", "z": ""}}, known: {{"x": "0", "z": "0"}},
               unknown: {{"x": (factor: "1", candidates: ["1", "2*t", "3*t^2", "4*t^3"], within: {{{within}}}), "z": (factor: "1", candidates: ["1", "2*t"])}}"#
        ),
        &[(Role::Fit, x)],
    );
    records[0].columns[1] = Some((0..SAMPLES).map(|i| -0.4 * time(i) + SIGMA * noise[SAMPLES + i]).collect());
    (case, records)
}

fn context<'a>(case: &'a Case, records: &'a [Record]) -> Context<'a> {
    Context {
        system: &case.system,
        records: vec![&records[0]],
        smooth: records.to_vec(),
        segments: SegmentsSpec::Count(1),
        stop: Stop::default(),
    }
}

fn cost(case: &Case, records: &[Record], terms: &[usize]) -> f64 {
    fitted_terms(case, records, SIGMA, terms).normal.cost
}

#[test]
fn the_price_counts_the_search() {
    // Two of five: ten ways.
    assert_relative_eq!(price(2, 5, 100.0), 2.0 * 100.0_f64.ln() + 2.0 * 10.0_f64.ln(), max_relative = 1e-12);
    assert_relative_eq!(price(3, 18, 50.0), 3.0 * 50.0_f64.ln() + 2.0 * 816.0_f64.ln(), max_relative = 1e-12);
    assert_eq!(price(0, 7, 1000.0), 0.0);
    // However few samples, a term costs as much as Akaike's half.
    assert_relative_eq!(price(1, 1, 0.5), 1.0, max_relative = 1e-12);
}

#[test]
fn terms_leave_in_the_order_of_what_they_cost() {
    let (case, records) = two_equations("");
    let all: Vec<usize> = (0..6).collect();
    let fit = fitted_terms(&case, &records, SIGMA, &all);
    let (mut left, mut before) = (all, fit.normal.cost);
    for (gone, rise) in elimination(&fit) {
        let without = |t: usize| left.iter().copied().filter(|&u| u != t).collect::<Vec<_>>();
        let costs: Vec<f64> = left.iter().map(|&t| cost(&case, &records, &without(t))).collect();
        let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
        let here = cost(&case, &records, &without(gone));
        assert_relative_eq!(here, least, max_relative = 1e-6);
        assert_relative_eq!(rise, here - before, max_relative = 1e-4, epsilon = 1e-6);
        (before, left) = (here, without(gone));
    }
    assert!(left.is_empty());
}

/// Alone, or in pairs of one equation: every one that there is, once, at the cost that its fit has.
#[test]
fn what_enters_lowers_the_cost_by_what_it_promises() {
    let (case, records) = two_equations("");
    let all: Vec<usize> = (0..6).collect();
    let now = fitted_terms(&case, &records, SIGMA, &[0]);
    let found = scores(&context(&case, &records), &now, &all);
    let mut added: Vec<Vec<usize>> = found.iter().map(|(added, _)| added.clone()).collect();
    added.sort();
    let due = [vec![1], vec![1, 2], vec![1, 3], vec![2], vec![2, 3], vec![3], vec![4], vec![4, 5], vec![5]];
    assert_eq!(added, due);
    for (added, fall) in found {
        let mut with = [vec![0], added.clone()].concat();
        with.sort();
        let due = now.normal.cost - cost(&case, &records, &with);
        assert_relative_eq!(fall, due, max_relative = 1e-4, epsilon = 1e-3);
    }
    let full = fitted_terms(&case, &records, SIGMA, &all);
    assert!(scores(&context(&case, &records), &full, &all).is_empty());
}

/// One in the place of another one of its equation.
#[test]
fn what_changes_places_costs_what_it_promises() {
    let (case, records) = two_equations("");
    let all: Vec<usize> = (0..6).collect();
    let now = fitted_terms(&case, &records, SIGMA, &[0, 1, 4]);
    let found = swaps(&context(&case, &records), &now, &all);
    let mut places: Vec<Vec<usize>> = found.iter().map(|swap| swap.terms.clone()).collect();
    places.sort();
    assert_eq!(places, [vec![0, 1, 5], vec![0, 2, 4], vec![0, 3, 4], vec![1, 2, 4], vec![1, 3, 4]]);
    for Change { terms, cost: promised, .. } in found {
        assert_relative_eq!(promised, cost(&case, &records, &terms), max_relative = 1e-4, epsilon = 1e-3);
    }
    // The nearest of them is no rival: the data tell.
    assert!(rivals(&context(&case, &records), &now, &all).is_empty());
}

/// A term that may not have the coefficient at which it would help is not offered: not alone, not in a pair,
/// not in a place.
#[test]
fn what_may_not_have_its_coefficient_is_not_offered() {
    // 2*t helps with -0.2.
    for (within, offered) in [
        (r#""2*t": Positive"#, false),
        (r#""2*t": Negative"#, true),
        (r#""2*t": (-0.3, -0.05)"#, true),
        (r#""2*t": (-0.05, 1.0)"#, false),
    ] {
        let (case, records) = two_equations(within);
        let all: Vec<usize> = (0..6).collect();
        let now = fitted_terms(&case, &records, SIGMA, &[0, 4]);
        let alone = |found: &[(Vec<usize>, f64)]| found.iter().any(|(terms, _)| *terms == [1]);
        assert_eq!(alone(&scores(&context(&case, &records), &now, &all)), offered);
        let found = scores(&context(&case, &records), &now, &all);
        assert_eq!(found.iter().any(|(terms, _)| *terms == [1, 2]), offered);
        let placed = swaps(&context(&case, &records), &now, &all);
        assert_eq!(placed.iter().any(|swap| swap.terms == [1, 4]), offered, "{placed:?}");
    }
}

/// The second of a pair, too, enters only with a coefficient that it may have: that of the fit with both.
#[test]
fn neither_of_a_pair_may_miss_its_bounds() {
    let (case, records) = two_equations("");
    let due = fitted_terms(&case, &records, SIGMA, &[0, 1, 2, 4]).x[2];
    for (low, high, offered) in [(-1e-4, 1e-4, true), (1e-4, 1.0, false), (-1.0, -1e-4, false)] {
        let (case, records) = two_equations(&format!(r#""3*t^2": ({:?}, {:?})"#, due + low, due + high));
        let now = fitted_terms(&case, &records, SIGMA, &[0, 4]);
        let found = scores(&context(&case, &records), &now, &[0, 1, 2, 3, 4, 5]);
        assert_eq!(found.iter().any(|(terms, _)| *terms == [1, 2]), offered, "{low}");
    }
}

/// One equation after the other: each term of it alone, then each pair less, the rest of the model as it is.
/// What fits ten times as badly is not looked at again.
#[test]
fn simpler_models_are_looked_at_equation_by_equation() {
    let (case, records) = two_equations("");
    let of = |terms: &[usize], hopeless: &mut Vec<Vec<usize>>| {
        let now = fitted_terms(&case, &records, SIGMA, terms);
        let criterion = |cost: f64, k: usize| cost + price(k, 6, 2.0 * SAMPLES as f64);
        pruned(&context(&case, &records), now, &criterion, hopeless)
    };
    // All that is too much goes: two of the first equation together, one of the second one.
    let mut hopeless = vec![];
    let found = of(&[0, 1, 2, 3, 4, 5], &mut hopeless);
    assert_eq!(found.problem.terms, [0, 1, 4]);
    assert_relative_eq!(found.normal.cost, cost(&case, &records, &[0, 1, 4]), max_relative = 1e-6);
    // Nothing goes from what is due, and all that is less is hopeless.
    let mut hopeless = vec![];
    assert_eq!(of(&[0, 1, 4], &mut hopeless).problem.terms, [0, 1, 4]);
    let here = cost(&case, &records, &[0, 1, 4]);
    for less in [vec![0, 4], vec![1, 4]] {
        assert_eq!(hopeless.contains(&less), cost(&case, &records, &less) > HOPELESS * here, "{less:?}");
    }
    assert!(!hopeless.is_empty());
    // What is known to be hopeless is not looked at, however good it is.
    let mut told = vec![vec![0, 1, 4]];
    assert_eq!(of(&[0, 1, 4, 5], &mut told).problem.terms, [0, 1, 4, 5]);
}

/// Of all 64 subsets the one whose criterion is least, from the whole dictionary and from too little of it.
#[test]
fn what_is_selected_is_the_best_of_all_subsets() {
    let (case, records) = two_equations("");
    let all: Vec<usize> = (0..6).collect();
    let subsets =
        (0..64_usize).map(|bits| all.iter().copied().filter(|k| bits >> k & 1 == 1).collect::<Vec<_>>());
    let samples = 2.0 * SAMPLES as f64;
    let value = |terms: &Vec<usize>| cost(&case, &records, terms) + price(terms.len(), 6, samples);
    let best = subsets.min_by(|a, b| value(a).total_cmp(&value(b))).unwrap();
    assert_eq!(best, [0, 1, 4]);
    for first in [&all[..], &[2, 5], &[0, 1, 4]] {
        let fit = fitted_terms(&case, &records, SIGMA, first);
        let found = select(&context(&case, &records), fit, &all, &mut vec![]);
        assert_eq!(found.fit.problem.terms, best, "from {first:?}");
        let start = &found.path[0];
        assert_eq!(start.terms, first.len());
        assert_relative_eq!(start.criterion, value(&first.to_vec()), max_relative = 1e-6);
        let least = found.path.iter().map(|p| p.criterion).fold(f64::INFINITY, f64::min);
        assert_relative_eq!(least, value(&best), max_relative = 1e-4);
    }
}

/// Below a hundredth of the rate of its equation a term goes, unless the cost without it would rise by sixty.
#[test]
fn what_hardly_matters_goes_unless_the_data_insist() {
    let spec =
        r#"states: {"x": ""}, known: {"x": "0"}, unknown: {"x": (factor: "1", candidates: ["1", "2*t"])}"#;
    let time = |i: usize| STEP * i as f64;
    // The rms of 2 t is 9.2, that of the constant rate a half: 0.7 and 1.5 per cent.
    for (bend, small) in [(4e-4, true), (8e-4, false)] {
        let x = (0..SAMPLES).map(|i| 0.5 * time(i) + bend * time(i).powi(2)).collect();
        let (case, records) = records(spec, &[(Role::Fit, x)]);
        let fitted = |sigma: f64| fitted_terms(&case, &records, sigma, &[0, 1]);
        let one = fitted(1.0);
        let rise = one.x[1].powi(2) / covariance(&one.normal.matrix)[(1, 1)];
        assert_eq!(negligible(&fitted((rise / 55.0).sqrt())), small.then_some(1));
        assert_eq!(negligible(&fitted((rise / 65.0).sqrt())), None);
        // The search keeps it, whose price is less; the last look does not.
        let found = select(&context(&case, &records), fitted((rise / 55.0).sqrt()), &[0, 1], &mut vec![]);
        assert_eq!(found.fit.problem.terms, if small { vec![0] } else { vec![0, 1] });
        let mut correlated = fitted((rise / 65.0).sqrt());
        correlated.effective /= 2.0;
        assert_eq!(negligible(&correlated), small.then_some(1));
        // The only term of a model stays.
        assert_eq!(negligible(&fitted_terms(&case, &records, 1e9, &[0])), None);
    }
}

/// A rate that hardly changes is as good as one that does not; a rate that grows from nothing is not.
#[test]
fn a_choice_that_does_nearly_as_well_is_a_rival() {
    let spec = r#"states: {"x": ""}, known: {"x": "0"}, unknown: {"x": (factor: "1", candidates: ["1", "1 + 0.01*t", "2*t"])}"#;
    let noise = scatter(SAMPLES);
    let x = (0..SAMPLES).map(|i| 0.5 * STEP * i as f64 + SIGMA * noise[i]).collect();
    let (case, records) = records(spec, &[(Role::Fit, x)]);
    let now = fitted_terms(&case, &records, SIGMA, &[0]);
    let near = rivals(&context(&case, &records), &now, &[0, 1, 2]);
    assert_eq!(near.iter().map(|(terms, _)| terms.clone()).collect::<Vec<_>>(), [[1]]);
    let due = cost(&case, &records, &[1]) - now.normal.cost;
    assert!(due.abs() < RIVAL, "{due}");
    assert_relative_eq!(near[0].1, due.max(0.0), epsilon = 1e-3);
}

/// Residuals that are not independent count as fewer, in the cost and in the price.
#[test]
fn correlated_samples_count_as_few() {
    let (case, records) = two_equations("");
    let mut fit = fitted_terms(&case, &records, SIGMA, &[0, 1, 4]);
    let (samples, cost) = (fit.samples as f64, fit.normal.cost);
    fit.effective = samples / 4.0;
    let found = select(&context(&case, &records), fit, &[0, 1, 2, 3, 4, 5], &mut vec![]);
    assert_relative_eq!(
        found.path[0].criterion,
        cost / 4.0 + price(3, 6, samples / 4.0),
        max_relative = 1e-9
    );
}
