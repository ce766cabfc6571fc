//! The comparison as JSON: the keys are a contract with users. Numbers are in the units that stand beside them.

use super::{CompareReport, Number, number};
use phisindy_compare::{Cause, Comparison, Fleet, Unit};
use serde_json::{Value, json};

pub(super) fn object(report: &CompareReport) -> Value {
    let mut object = match report {
        CompareReport::Pair(pair) => of_pair(pair),
        CompareReport::Fleet(fleet) => of_fleet(fleet),
    };
    object["sentence"] = report.sentence().into();
    object["version"] = env!("CARGO_PKG_VERSION").into();
    object
}

fn of_pair(pair: &Comparison) -> Value {
    let numbers = pair.changes.differences.iter().map(|difference| {
        let Number { before, by, std_error, unit } = number(pair, difference);
        json!({
            "name": difference.name, "unit": unit, "before": before, "by": by, "std_error": std_error,
            "changed": difference.changed,
        })
    });
    json!({
        "verdict": pair.verdict(), "old": unit(&pair.old), "new": unit(&pair.new),
        "changed": pair.changes.changed().map(|d| d.name.clone()).collect::<Vec<_>>(),
        "causes": pair.new.causes.iter().map(cause).collect::<Vec<_>>(),
        "numbers": numbers.collect::<Vec<_>>(), "by_chance": pair.changes.by_chance, "or": pair.changes.or,
    })
}

fn of_fleet(fleet: &Fleet) -> Value {
    let population = &fleet.population;
    let spreads = population.spreads.iter().map(|s| {
        json!({
            "name": s.name, "unit": s.unit, "mean": s.mean / s.factor, "std_error": s.mean_error / s.factor,
            "spread": s.between / s.factor, "machines": s.machines,
        })
    });
    let machines = fleet.by_care().into_iter().map(|k| {
        let mut out = unit(&fleet.units[k]);
        let numbers = population.members[k].numbers.iter().map(|n| {
            let spread = &population.spreads[n.spread];
            json!({
                "name": spread.name, "unit": spread.unit, "value": n.value / spread.factor,
                "std_error": n.std_error / spread.factor, "deviation": n.deviation, "stands_out": n.stands_out,
                "among_all": { "value": n.among_all.0 / spread.factor, "std_error": n.among_all.1 / spread.factor },
            })
        });
        out["numbers"] = numbers.collect();
        out["needs_care"] = fleet.needs_care(k).into();
        out["odd_causes"] = fleet.odd_causes(k).map(cause).collect();
        out
    });
    json!({ "spreads": spreads.collect::<Vec<_>>(), "machines": machines.collect::<Vec<_>>() })
}

fn unit(unit: &Unit) -> Value {
    let causes: Vec<Value> = unit.causes.iter().map(cause).collect();
    json!({ "name": unit.name, "status": unit.status, "holds": unit.holds, "causes": causes })
}

fn cause(cause: &Cause) -> Value {
    let number = |(name, value, (low, high), unit): &(String, f64, (f64, f64), String)| json!({ "name": name, "value": value, "ci95": [low, high], "unit": unit });
    let numbers: Vec<Value> = cause.numbers.iter().map(number).collect();
    json!({ "law": cause.law, "at": cause.at, "stated": cause.stated, "numbers": numbers })
}
