#![allow(missing_docs, clippy::print_stdout)]
mod common;
use std::ops::ControlFlow;
#[test]
fn show() {
    for name in std::env::var("CASES").unwrap_or("case1a".into()).split(',') {
        let sets: Vec<(String,String)> = std::env::var("SETS").unwrap_or_default().split(';').filter(|s| !s.is_empty()).map(|s| { let (a,b)=s.split_once('=').unwrap(); (a.into(), b.into()) }).collect();
        let refs: Vec<(&str,&str)> = sets.iter().map(|(a,b)| (a.as_str(), b.as_str())).collect();
        let t0 = std::time::Instant::now();
        let (case, records) = common::load(name, &refs);
        let t1 = t0.elapsed();
        let _ = &records;
        let found = phisindy_learn::identify(&case, &records, &Default::default(), &mut |_| ControlFlow::Continue(()));
        let t2 = t0.elapsed();
        match found {
            Ok(f) => {
                println!("{name}: load {t1:?} total {t2:?} {:?} {:?}", f.verdict, f.selection);
                for t in &f.terms { println!("   {}: {} = {:.5} +- {:.2e}", case.system.states[case.system.terms[t.term].state].name, case.system.terms[t.term].candidate, t.coefficient.value, t.coefficient.std_error); }
                for p in &f.parameters { println!("   {} = {:.5} +- {:.2e}", p.name, p.estimate.value, p.estimate.std_error); }
                for r in &f.records { println!("   {} nrmse {:?} start {:?} {:?} steps {:?}", r.name, r.nrmse, r.start, r.failure, r.run.as_ref().map(|r| (r.steps, r.rejected, r.events.len()))); }
                for w in &f.warnings { println!("   ! {w}"); }
            }
            Err(e) => println!("{name}: {e} {t2:?}"),
        }
    }
}
#[test]
fn seeds() {
    use rayon::prelude::*;
    let n: u64 = std::env::var("N").ok().and_then(|s| s.parse().ok()).unwrap_or(0);
    if n == 0 { return; }
    for name in std::env::var("CASES").unwrap_or("case1a".into()).split(',') {
        let sets: Vec<(String,String)> = std::env::var("SETS").unwrap_or_default().split(';').filter(|s| !s.is_empty()).map(|s| { let (a,b)=s.split_once('=').unwrap(); (a.into(), b.into()) }).collect();
        let t0 = std::time::Instant::now();
        let refs: Vec<(&str,&str)> = sets.iter().map(|(a,b)| (a.as_str(), b.as_str())).collect();
        let (case, records) = common::load(name, &refs);
        let truth = phisindy_learn::project(&case, &records).unwrap();
        let bound = phisindy_learn::bound(&case, &records, &vec![None; records.len()], &truth).unwrap();
        let runs: Vec<_> = (0..n).into_par_iter().map(|seed| {
            let t = std::time::Instant::now();
            let s = seed.to_string();
            let mut refs = refs.clone(); refs.push(("data.0.seed", &s));
            let (case, records) = common::load(name, &refs);
            let run = phisindy_learn::sweep_one(&case, &records, &truth, &Default::default());
            (seed, run, t.elapsed())
        }).collect();
        let exact = runs.iter().filter(|r| r.1.exact).count();
        println!("{name}: exact {exact}/{n} in {:?}, slowest {:?}", t0.elapsed(), runs.iter().map(|r| r.2).max());
        for (k, &t) in truth.terms.iter().enumerate() {
            let c = truth.coefficients[k];
            let est: Vec<_> = runs.iter().filter(|r| r.1.exact).filter_map(|r| r.1.found[k]).collect();
            let m = est.len() as f64;
            let rmse = (est.iter().map(|e| (e.value - c).powi(2)).sum::<f64>()/m).sqrt();
            let mut v: Vec<f64> = est.iter().map(|e| e.value).collect(); v.sort_by(f64::total_cmp);
            let cover = est.iter().filter(|e| e.ci95.0 <= c && c <= e.ci95.1).count();
            println!("    {} truth {c:.4} median {:.5} rmse {rmse:.2e} bound {:.2e} ratio {:.2} coverage {:.0}%", case.system.terms[t].candidate, v.get(v.len()/2).copied().unwrap_or(f64::NAN), bound[k], rmse/bound[k], 100.0*cover as f64/m);
        }
        for (seed, r, t) in runs.iter().filter(|r| !r.1.exact) {
            let o = match &r.outcome { Ok(i) => format!("{:?} {:?}", i.verdict, i.terms.iter().map(|t| (t.term, t.coefficient.value, t.coefficient.std_error)).collect::<Vec<_>>()), Err(e) => e.to_string() };
            println!("    seed {seed} {t:?}: spurious {:?} {o}", r.spurious);
        }
    }
}
