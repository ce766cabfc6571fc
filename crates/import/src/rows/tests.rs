//! Files in, tables or messages out.

use super::*;
use phisindy_phys::spec::{self, DataSpec};

/// Reads `content` as the fields of `csv` ask for it; the message of the first mistake, or the table.
fn table(fields: &str, content: &[u8]) -> Result<Table, String> {
    let text = format!(
        "(states: {{ \"x\": \"m\" }}, known: {{ \"x\": \"1\" }}, data: [Csv(path: \"a.csv\", {fields})])"
    );
    let (spec, _) = spec::read(&text, SourceId(0)).expect("well formed");
    let DataSpec::Csv(csv) = &spec.data[0] else { panic!("a Csv record") };
    let mut sources = Sources::default();
    let id = sources.add("case.ron", text.clone());
    let unit = |c: &phisindy_phys::spec::ColumnSpec| {
        c.unit.as_ref().map_or(Unit::ONE, |u| Unit::parse(&u.value).expect("a unit"))
    };
    let units = Units { time: unit(&csv.time), columns: csv.columns.iter().map(|(_, c)| unit(c)).collect() };
    let read = record(csv, &units, DataFile::of_bytes("a.csv", content), id, &mut sources);
    read.map(|(table, _)| table).map_err(|all| {
        all.iter().map(|d| format!("{} | {}", d.message, d.help.join(" | "))).collect::<Vec<_>>().join("\n")
    })
}

const PLAIN: &str = "time: \"t\", columns: { \"x\": \"x\" }";

/// Twelve rows `t`, `x`, written by `row`.
fn rows(row: impl Fn(usize) -> String) -> String {
    (0..12).map(row).collect()
}

#[test]
fn utf_32_is_told() {
    let text = format!("t,x\n{}", rows(|k| format!("0.{k:02},{k}.5\n")));
    let bytes: Vec<u8> = text.chars().flat_map(|c| u32::from(c).to_le_bytes()).collect();
    let said = table(PLAIN, &bytes).unwrap_err();
    assert!(said.contains("UTF-32") && said.contains("UTF-8"), "{said}");
}

#[test]
fn separators_decimals_and_marks_are_found_out() {
    let files = [
        format!("t,x\n{}", rows(|k| format!("0.{k:02},{k}.5\n"))),
        format!("\u{feff}t;x\r\n{}", rows(|k| format!("0,{k:02};{k},5\r\n"))),
        format!("t,x\r{}", rows(|k| format!("0.{k:02},{k}.5\r"))),
        format!("# a comment\n\n% another\nt\tx\n{}", rows(|k| format!("0.{k:02}\t{k}.5\n"))),
        format!("t x\n{}", rows(|k| format!("  0,{k:02}   {k},5 \n"))),
        format!("\"t\",\"note, or two\",\"x\",\n{}", rows(|k| format!("0.{k:02},\"a, b\",{k}.5,\n"))),
        format!("x;other;t\n{}", rows(|k| format!("{k}.5;text;0.{k:02}\n"))),
    ];
    for file in files {
        let read = table(PLAIN, file.as_bytes()).unwrap_or_else(|e| panic!("{file}\n{e}"));
        assert_eq!((read.time[1], read.columns[0][11]), (0.01, 11.5), "{file}");
        assert_eq!(read.time.len(), 12);
    }
}

#[test]
fn without_a_heading_columns_are_numbered() {
    let file = rows(|k| format!("0.{k:02},{k}\n"));
    let numbered = "time: \"1\", columns: { \"x\": \"2\" }";
    for fields in [numbered.to_owned(), format!("{numbered}, header: false")] {
        assert_eq!(table(&fields, file.as_bytes()).expect("a table").columns[0][3], 3.0);
    }
    let message = table(PLAIN, file.as_bytes()).expect_err("no such column");
    assert!(message.contains("no column `t`") && message.contains("columns of the file: 1, 2"), "{message}");
}

#[test]
fn a_column_without_a_heading_has_its_number_as_its_name() {
    let file = format!("t,,y\n{}", rows(|k| format!("0.{k:02},{k},7\n")));
    let read = table("time: \"t\", columns: { \"x\": \"2\" }", file.as_bytes()).expect("a table");
    assert_eq!(read.columns[0][3], 3.0);
}

#[test]
fn rows_with_a_number_that_is_not_finite_are_left_out_as_those_without_one() {
    let file = format!("t,x\n{}12,inf\n13,-1e999\n14,NaN\n15,\n16,1\n", rows(|k| format!("{k},{k}\n")));
    let read = table(&format!("{PLAIN}, missing: Omit"), file.as_bytes()).expect("a table");
    assert_eq!((read.time.len(), read.omitted), (13, 4));
    // A finite number that is too large in SI is none of these.
    let large = format!("t,x\n{}12,1e308\n", rows(|k| format!("{k},{k}\n")));
    let kilometres = "time: \"t\", columns: { \"x\": (\"x\", \"km\") }, missing: Omit";
    assert!(
        table(kilometres, large.as_bytes()).expect_err("too large").contains("`x` is `1e308` in line 14")
    );
}

#[test]
fn a_comma_between_fields_and_in_numbers_is_refused() {
    let file = format!("t,x\n{}", rows(|k| format!("0,{k:02},{k},5\n")));
    let said = table(PLAIN, file.as_bytes()).expect_err("no fields");
    assert!(said.contains("line 2 of `a.csv` has 4 fields, the heading has 2"), "{said}");
    assert!(said.contains("the decimal mark too") && said.contains("export them with `;`"), "{said}");
}

#[test]
fn rows_select_and_the_rest_is_not_looked_at() {
    let file = format!("trial,t,x\n1,0.00,bad\n{}1,0.5,NaN\n", rows(|k| format!("0,{}.5,{k}\n", k)));
    let fields = format!("{PLAIN}, rows: {{ \"trial\": 0.0 }}");
    let read = table(&fields, file.as_bytes()).expect("a table");
    assert_eq!((read.time.len(), read.lines[0]), (12, 3));
    let none = table(&format!("{PLAIN}, rows: {{ \"trial\": 7.0 }}"), file.as_bytes())
        .expect_err("nothing selected");
    assert!(none.contains("no row of `a.csv` is selected") && none.contains("at least 10"), "{none}");
}

#[test]
fn outside_of_the_window_anything_may_stand() {
    let file = format!("t,x\n{}12,overload\n", rows(|k| format!("{k},{k}\n")));
    assert!(table(PLAIN, file.as_bytes()).is_err());
    let read = table(&format!("{PLAIN}, window: (0.0, 11.0)"), file.as_bytes()).expect("a table");
    // Nor is it kept: of a file of any length only the window is in memory.
    assert_eq!((read.time.len(), read.extent), (12, Some((0.0, 12.0))));
}

#[test]
fn a_window_is_in_seconds_whatever_the_unit_of_the_column() {
    let file = format!("t,x\n{}", rows(|k| format!("{},{k}\n", 100 * k)));
    let record = PLAIN.replace("time: \"t\"", "time: (\"t\", \"ms\")");
    let read = table(&format!("{record}, window: (0.1, 1.0)"), file.as_bytes()).expect("a table");
    assert_eq!((read.time.len(), read.time[0], read.extent), (10, 0.1, Some((0.0, 1.1))));
}

#[test]
fn a_second_line_of_units_is_no_row() {
    let file = format!("t;x\n[s];mm\n{}", rows(|k| format!("{k};{k},5\n")));
    assert_eq!(table(PLAIN, file.as_bytes()).expect("a table").columns[0][11], 11.5);
    let words = format!("t;x\nsoon;late\n{}", rows(|k| format!("{k};{k},5\n")));
    assert!(table(PLAIN, words.as_bytes()).expect_err("words").contains("holds the text `soon`"));
}

#[test]
fn decimation_streams() {
    let file = format!("t,x\n{}", (0..40).map(|k| format!("{k},{k}\n")).collect::<String>());
    let read = table(&format!("{PLAIN}, decimate: 4"), file.as_bytes()).expect("a table");
    assert_eq!((read.time.len(), read.time[0], read.columns[0][9], read.lines[0]), (10, 1.5, 37.5, 5));
}

#[test]
fn a_long_field_or_name_does_not_come_back_as_a_message() {
    let (long, numbers) = ("ä".repeat(3000), rows(|k| format!("{k},{k}\n")));
    let asked = PLAIN.replace(": \"x\"", &format!(": \"{long}\""));
    for (record, file, words) in [
        (PLAIN, format!("t,x\n{numbers}12,{long}\n"), "holds the text `ää"),
        (PLAIN, format!("t,{long}\n{numbers}"), "has no column `x`"),
        (&asked, format!("t,x\n{numbers}"), "has no column `ää"),
        (&asked, format!("t,{long},{long}\n{}", rows(|k| format!("{k},{k},{k}\n"))), "has two columns `ää"),
    ] {
        let message = table(record, file.as_bytes()).expect_err("words");
        assert!(message.contains(words) && message.contains("..."), "{message}");
        assert!(message.len() < 1000, "{} bytes", message.len());
    }
}

#[test]
fn mistakes_name_the_line_and_say_what_to_do() {
    let good = rows(|k| format!("{k},{k}\n"));
    let cases: &[(&str, Vec<u8>, &[&str])] = &[
        ("", b"".to_vec(), &["is empty"]),
        ("", b"# only a comment\n".to_vec(), &["is empty"]),
        ("", b"t,x\n1,2\n".to_vec(), &["one row", "at least 10"]),
        ("", format!("t,x\n{good}12,NaN\n").into(), &["`x` is `NaN` in line 14"]),
        ("", format!("t,x\n{good}12,-inf\n").into(), &["`x` is `-inf` in line 14"]),
        ("", format!("t,x\n{good}12,\n").into(), &["column `x` has no value in line 14"]),
        (
            "",
            format!("t,x,z\n{}12,,1\n", rows(|k| format!("{k},{k},1\n"))).into(),
            &["column `x` has no value in line 14"],
        ),
        ("", format!("t,x\n{good}12,1,2\n").into(), &["line 14", "has 3 fields", "the heading has 2"]),
        ("", format!("t,x\n{good}12").into(), &["ends in the middle of line 14", "cut off"]),
        ("", format!("t,x\n{good}11,1\n").into(), &["the time 11 stands twice", "lines 13 and 14"]),
        ("", format!("t,x\n{good}5,1\n").into(), &["goes back from 11 to 5 in line 14", "rows:"]),
        ("", format!("t,x,x\n{}", rows(|k| format!("{k},{k},1\n"))).into(), &["two columns `x`"]),
        ("", format!("time,x_mm\n{good}").into(), &["no column `t`", "no column `x`"]),
        (
            "",
            [b"t,x\n".as_slice(), good.as_bytes(), b"12,\xff\n"].concat(),
            &["holds the text `ÿ`", "line 14"],
        ),
        ("", b"\xff\xfet\0,\0x\0".to_vec(), &["no row of numbers"]),
        ("", b"t,x\n1,2\0\n".to_vec(), &["neither text nor a format that is known"]),
        ("", b"\x1f\x8b\x08\0\0".to_vec(), &["gzip", "gunzip -k a.csv"]),
        ("", b"\x93NUMPY\x01\0".to_vec(), &["NumPy", "write `Table(` in the place of `Csv(`"]),
        (
            ", separator: ';'",
            format!("t;x\n{}1.5;0\n", rows(|k| format!("{k};{k},5\n"))).into(),
            &["with a point (`1.5`)", "decimal"],
        ),
        (
            ", decimal: '.', separator: ';'",
            format!("t;x\n{}", rows(|k| format!("{k};{k},5\n"))).into(),
            &["holds the text `0,5`", "decimal: ','"],
        ),
    ];
    for (fields, file, expected) in cases {
        let message = table(&format!("{PLAIN}{fields}"), file).expect_err(&String::from_utf8_lossy(file));
        for part in *expected {
            assert!(message.contains(part), "expected {part:?} in {message:?}");
        }
    }
}
