//! The journal of a sweep.

use serde_json::Value;

/// Journals with zeros between them, as `sweep --merge` reads them: each is refused with a reason, or every run of the table stands in one of them
/// as it was counted, and the table can be printed.
pub fn journal(input: &[u8]) {
    let journals: Vec<&[u8]> = input.split(|&b| b == 0).collect();
    match phisindy_cli::merged_journals(&journals) {
        Ok((runs, table)) => {
            assert!(!table.is_empty());
            let read = |line: &[u8]| serde_json::from_slice::<Value>(line).ok();
            let told: Vec<Value> = input.split(|&b| b == 0 || b == b'\n').filter_map(read).collect();
            for run in runs {
                let run: Value = serde_json::from_str(&run).expect("a line that was written here");
                assert!(told.iter().any(|told| same(told, &run)), "nobody told of {run}");
            }
        }
        Err(why) => assert!(!why.is_empty(), "refused without a reason"),
    }
}

/// Whether two values say the same; a number may be written in many ways.
fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b)),
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len() && a.iter().all(|(key, a)| b.get(key).is_some_and(|b| same(a, b)))
        }
        (Value::Number(x), Value::Number(y)) => x == y || x.as_f64() == y.as_f64(),
        _ => a == b,
    }
}
