use phisindy_expr::*;
use std::time::Instant;
fn program(text: &str, n: usize) -> Tape {
    let (mut g, mut names) = (Graph::default(), Names::default());
    let ast = parse(text).unwrap();
    let f = g.lower(&ast, |s| Some(names.intern(s))).unwrap();
    let x: Vec<Id> = ["x","y","a","b"].iter().map(|s| { let s = names.intern(s); g.symbol(s) }).collect();
    // iterate x <- f(x, y), y <- x
    let mut now = [x[0], x[1]];
    let mut outs = vec![];
    for _ in 0..n {
        let with = std::collections::HashMap::from([(x[0], now[0]), (x[1], now[1])]);
        let next = g.replace(&[f], &with)[0];
        outs.push(now[0]);
        now = [next, now[0]];
    }
    let grad = g.gradient(now[0], &x);
    Tape::compile(&g, &x, &grad).unwrap()
}
fn race<const N: usize>(name: &str, tape: &Tape) {
    let mut s = Scratch::<N>::new(tape);
    for k in 0..4 { *s.input(k) = [0.3 + 0.1 * k as f64; N]; }
    let rounds = 20_000_000 / tape.operations() / N;
    let mut best = f64::INFINITY;
    for _ in 0..20 {
        let t = Instant::now();
        for _ in 0..rounds { s.run(); }
        best = best.min(t.elapsed().as_secs_f64());
    }
    println!("{name} lanes {N}: {} ops {} slots {:.3} ns per op and 8 lanes", tape.operations(), tape.slots(), best * 1e9 / (rounds * tape.operations() * N) as f64 * 8.0);
}
fn main() {
    for (name, text, n) in [("poly", "a*x*y + b*x^2 - a*y*y*b - x", 10), ("logs", "ln(abs(x)+a)*b + ln(abs(y) + b)", 10)] {
        let t = program(text, n);
        race::<16>(name, &t); race::<32>(name, &t); race::<64>(name, &t); race::<128>(name, &t);
    }
}
