//! From a data file to a spec: what each column is, and the draft that `phisindy new` writes.
//!
//! ```text
//! cargo run --release -p phisindy-import --example draft
//! ```
#![allow(clippy::print_stdout)]

use phisindy_expr::Span;
use phisindy_import::{DataFile, Draft, spec_text, table};
use phisindy_phys::{Diagnostic, Sources};
use std::fmt::Write;

/// A mass on a spring that comes to rest: time, displacement in millimetres, temperature.
fn file() -> String {
    let mut text = "time_s;Weg [mm];temperature_C\n".to_owned();
    for k in 0..600 {
        let t = 0.01 * f64::from(k);
        let x = 10.0 * (-0.4 * t).exp() * (7.0 * t).cos() + 25.0;
        let _ = writeln!(text, "{}", format!("{t:.2};{x:.3};21,5").replace('.', ","));
    }
    text
}

fn main() -> Result<(), Box<Diagnostic>> {
    let (name, text) = ("rig.csv", file());
    // Diagnostics point to the place where the user named the file.
    let mut sources = Sources::default();
    let at = (sources.add("command line", name), Span::new(0, name.len()));
    let table = table(DataFile::of_bytes(name, text.as_bytes()), None, at, &mut sources)?;
    println!("{} rows, {}", table.rows(), table.record_fields.join(", "));
    for column in &table.columns {
        let heading = &column.heading;
        println!(
            "  {:14} name {}, unit {:?}, {:?}",
            heading.raw, heading.name, heading.unit, heading.quantity
        );
    }

    let draft = Draft::of(table).map_err(|why| why.diagnostic(name, at))?;
    for (column, usage) in draft.table.columns.iter().zip(&draft.usages) {
        println!("  {:14} {usage}", column.heading.raw);
    }
    println!("\n{}", spec_text(&draft, name, "rig.ron"));
    Ok(())
}
