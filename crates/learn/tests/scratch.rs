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
