//! A data file with the record that asks for it.

use crate::told_well;
use phisindy_expr::Span;
use phisindy_import::DataFile;
use phisindy_phys::spec::{DataSpec, read};
use phisindy_phys::unit::Unit;
use phisindy_phys::{Sources, Units};

/// Fields of a `Csv` record, a zero, the file: a table has as many numbers in each column, all finite, times that grow; a mistake has its place.
pub fn csv(input: &[u8]) {
    let zero = input.iter().position(|&b| b == 0).unwrap_or(0);
    let (fields, file) = input.split_at(zero);
    let Ok(fields) = std::str::from_utf8(fields) else { return };
    let fields = if fields.is_empty() { "time: \"t\", columns: { \"x\": \"x\" }" } else { fields };
    let file = file.strip_prefix(b"\0").unwrap_or(file);
    let text = format!(
        "(states: {{ \"x\": \"m\" }}, known: {{ \"x\": \"1\" }}, data: [Csv(path: \"a.csv\", {fields})])"
    );
    let mut sources = Sources::default();
    let source = sources.add("case.ron", text.clone());
    let Ok((spec, _)) = read(&text, source) else { return };
    let [DataSpec::Csv(csv)] = spec.data.as_slice() else { return };
    let units = Units { time: Unit::ONE, columns: vec![Unit::ONE; csv.columns.len()] };
    let file = DataFile::of_bytes("a.csv", file);
    match phisindy_import::record(csv, &units, file, source, &mut sources) {
        Ok((table, said)) => {
            said.iter().for_each(|d| told_well(d, &sources));
            assert_eq!(table.lines.len(), table.time.len());
            assert!(table.time.windows(2).all(|w| w[0] < w[1]), "time does not grow");
            for column in &table.columns {
                assert_eq!(column.len(), table.time.len());
                assert!(column.iter().all(|x| x.is_finite()));
            }
        }
        Err(said) => {
            assert!(!said.is_empty(), "refused without a reason");
            said.iter().for_each(|d| told_well(d, &sources));
        }
    }
}

/// A file of any format but workbooks, whose reader is not ours: the table of `new`, and a record that asks for its second column.
pub fn format(input: &[u8]) {
    if input.starts_with(b"\xD0\xCF\x11\xE0")
        || [&b"xl/workbook"[..], b"content.xml"]
            .iter()
            .any(|name| input.windows(name.len()).any(|w| w == *name))
    {
        return;
    }
    let mut sources = Sources::default();
    let text = "(states: { \"x\": \"m\" }, known: { \"x\": \"1\" }, data: [Table(path: \"a\", time: Rate(100.0), columns: { \"x\": \"NAME\" })])";
    let at = (sources.add("command line", "a"), Span::new(0, 1));
    let named = match phisindy_import::table(DataFile::of_bytes("a", input), None, at, &mut sources) {
        Ok(table) => {
            assert!(table.columns.iter().all(|c| c.values.len() == table.rows()));
            table.columns.get(1).map_or("2".to_owned(), |c| c.heading.raw.clone())
        }
        Err(said) => {
            told_well(&said, &sources);
            "2".to_owned()
        }
    };
    if named.contains(['"', '\\']) || named.chars().any(char::is_control) {
        return;
    }
    let text = text.replace("NAME", &named);
    let source = sources.add("case.ron", text.clone());
    let Ok((spec, _)) = read(&text, source) else { return };
    let [DataSpec::Csv(csv)] = spec.data.as_slice() else { return };
    let units = Units { time: Unit::ONE, columns: vec![Unit::ONE] };
    match phisindy_import::record(csv, &units, DataFile::of_bytes("a", input), source, &mut sources) {
        Ok((table, _)) => assert!(
            table.columns.iter().all(|c| c.len() == table.time.len() && c.iter().all(|x| x.is_finite()))
        ),
        Err(said) => {
            assert!(!said.is_empty(), "refused without a reason");
            said.iter().for_each(|d| told_well(d, &sources));
        }
    }
}
