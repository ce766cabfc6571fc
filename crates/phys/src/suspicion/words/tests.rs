use super::*;

#[test]
fn sentences_count_what_they_tell_of() {
    let gap = |count| Suspicion::MissingSamples { from: 1.0, to: 2.5, steps: 150.0, count }.to_string();
    assert!(gap(1).starts_with("no samples from 1.000000 s to 2.500000 s, 150 times the usual step: "));
    assert!(gap(3).contains("the usual step (3 such holes): inputs are interpolated across it"));
    let spike = |count| Suspicion::Spike { column: "x".into(), value: 3.0, time: 0.5, count }.to_string();
    assert!(spike(1).starts_with("`x` jumps to 3.000000 and back in the sample at 0.500000 s: a spike"));
    assert!(spike(4).contains("at 0.500000 s (and in 3 more): a spike"));
    let frozen = |count| {
        let (column, from_to) = ("x".to_owned(), (1.0, 2.0));
        Suspicion::Frozen { column, value: 0.5, samples: 9, from_to, count }.to_string()
    };
    assert!(frozen(1).contains("to 2.000000 s, and moves"));
    assert!(frozen(2).contains("to 2.000000 s (and in 1 more such stretches), and moves"));
}

#[test]
fn factors_near_powers_of_ten_are_told_as_such() {
    let told = |factor| {
        let (displacement, velocity) = ("x".to_owned(), "v".to_owned());
        Suspicion::RateScaled { displacement, velocity, factor }.to_string()
    };
    assert!(told(1040.0).starts_with("`x` moves at 1000 times the rate that `v` gives"));
    assert!(told(0.00098).starts_with("`x` moves at 1/1000 of the rate that `v` gives"));
    assert!(told(4.2).starts_with("`x` moves at 4.200 times the rate that `v` gives"));
}

#[test]
fn parts_of_a_rate_are_named_in_the_right_number() {
    let told = |parts: &[&str], factor, clock| {
        let parts = parts.iter().map(|p| (*p).to_owned()).collect();
        Suspicion::PartScaled { velocity: "v".into(), parts, factor, clock }.to_string()
    };
    assert!(told(&["k*x"], 1e3, false).contains("its part in `k*x` is 1000 times as large"));
    let both = told(&["k*x", "F"], 1e-6, true);
    assert!(both.contains("its parts in `k*x`, `F` are 1/1000000 times as large"), "{both}");
    assert!(both.ends_with("measured motion, or of the time column"), "{both}");
    assert!(told(&["F"], -1.0, false).contains("its part in `F` changes its sign"));
}

#[test]
fn a_large_number_is_short() {
    let (column, value) = ("x".to_owned(), 1e299);
    let said = Suspicion::Spike { column, value, time: 1.2, count: 1 }.to_string();
    assert!(said.starts_with("`x` jumps to 1.000000e299 and back in the sample at 1.200000 s"), "{said}");
}
