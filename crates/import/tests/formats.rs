//! Every format gives the bits of the text file with the same numbers. Other programs made the files:
//! `fixtures/make.py`.
#![allow(missing_docs)]

use phisindy_expr::Span;
use phisindy_import::{DataFile, Draft, record, spec_text, table};
use phisindy_phys::spec::{self, DataSpec};
use phisindy_phys::unit::Unit;
use phisindy_phys::{SourceId, Sources, Table, Units};

fn fixture(name: &str) -> Vec<u8> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures").join(name);
    std::fs::read(&path).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// Reads columns `x` and `F`; or all messages.
fn read(file: &str, bytes: &[u8], record_text: &str) -> Result<(Table, Vec<String>), String> {
    let text = format!(
        "(states: {{ \"x\": \"m\" }}, inputs: {{ \"F\": \"N\" }}, known: {{ \"x\": \"F\" }}, data: [{}])",
        record_text.replace("FILE", file)
    );
    let mut sources = Sources::default();
    let source = sources.add("case.ron", text.clone());
    let (spec, _) = spec::read(&text, source).map_err(|e| format!("{e:?}"))?;
    let DataSpec::Csv(csv) = &spec.data[0] else { panic!("a record of a file") };
    let unit =
        |c: &spec::ColumnSpec| c.unit.as_ref().map_or(Unit::ONE, |u| Unit::parse(&u.value).expect("a unit"));
    let units = Units { time: unit(&csv.time), columns: csv.columns.iter().map(|(_, c)| unit(c)).collect() };
    let read = record(csv, &units, DataFile::of_bytes(file, bytes), source, &mut sources);
    let words = |d: &phisindy_phys::Diagnostic| format!("{} | {}", d.message, d.help.join(" | "));
    match read {
        Ok((table, said)) => Ok((table, said.iter().map(words).collect())),
        Err(said) => Err(said.iter().map(words).collect::<Vec<_>>().join("\n")),
    }
}

fn bits(column: &[f64]) -> Vec<u64> {
    column.iter().map(|x| x.to_bits()).collect()
}

const PLAIN: &str = "time: \"t\", columns: { \"x\": (\"x\", \"mm\"), \"F\": \"F\" }";

fn reference() -> Table {
    read("run.csv", &fixture("run.csv"), &format!("Csv(path: \"FILE\", {PLAIN})")).expect("the text").0
}

/// How each file is asked for.
const FILES: &[(&str, &str)] = &[
    ("run.csv", PLAIN),
    ("run_1252.csv", "time: \"t\", columns: { \"x\": (\"x\", \"mm\"), \"F\": \"Kraft µN\" }"),
    ("run_utf16.csv", "time: \"t\", columns: { \"x\": (\"x\", \"mm\"), \"F\": \"Kraft µN\" }"),
    (
        "run.xlsx",
        "sheet: \"Messung\", skip: 2, time: \"t\", columns: { \"x\": (\"x\", \"mm\"), \"F\": \"F\" }",
    ),
    ("run.ods", "sheet: \"Messung\", time: \"t\", columns: { \"x\": (\"x\", \"mm\"), \"F\": \"F\" }"),
    ("run.xls", PLAIN),
    ("run.mat", PLAIN),
    ("parts.mat", "sheet: \"run\", time: \"t\", columns: { \"x\": (\"x\", \"mm\"), \"F\": \"F\" }"),
    ("parts.mat", "sheet: \"table\", time: \"1\", columns: { \"x\": (\"2\", \"mm\"), \"F\": \"3\" }"),
    ("parts.mat", "time: \"run.t\", columns: { \"x\": (\"run.x\", \"mm\"), \"F\": \"table.3\" }"),
    ("run.npz", PLAIN),
    ("packed.npz", PLAIN),
    ("run.npy", PLAIN),
    ("matrix.npy", "time: \"1\", columns: { \"x\": (\"2\", \"mm\"), \"F\": \"3\" }"),
    (
        "run.uff",
        "time: (\"time\", \"s\"), columns: { \"x\": (\"displacement 1Z+\", \"mm\"), \"F\": (\"force 2Z+\", \"N\") }",
    ),
    (
        "binary.uff",
        "time: (\"time\", \"s\"), columns: { \"x\": (\"displacement 1Z+\", \"mm\"), \"F\": (\"force 2Z+\", \"N\") }",
    ),
    ("run.tdms", "time: (\"time\", \"s\"), columns: { \"x\": (\"x\", \"mm\"), \"F\": (\"F\", \"N\") }"),
    #[cfg(feature = "hdf5")]
    ("run.h5", PLAIN),
    #[cfg(feature = "hdf5")]
    ("parts.h5", "sheet: \"a.run\", time: \"t\", columns: { \"x\": (\"x\", \"mm\"), \"F\": \"F\" }"),
    #[cfg(feature = "hdf5")]
    ("parts.h5", "sheet: \"table\", time: \"1\", columns: { \"x\": (\"2\", \"mm\"), \"F\": \"3\" }"),
    #[cfg(feature = "hdf5")]
    ("parts.h5", "time: \"records.t\", columns: { \"x\": (\"many.c11\", \"mm\"), \"F\": \"rows.3\" }"),
    #[cfg(feature = "hdf5")]
    ("pandas.h5", PLAIN),
    #[cfg(feature = "hdf5")]
    (
        "fixed.h5",
        "sheet: \"run.block0_values\", time: \"1\", columns: { \"x\": (\"2\", \"mm\"), \"F\": \"3\" }",
    ),
    #[cfg(feature = "hdf5")]
    ("run73.mat", PLAIN),
    #[cfg(feature = "hdf5")]
    (
        "run73.mat",
        "time: \"scope.time\", columns: { \"x\": (\"many(1).values\", \"mm\"), \"F\": \"scope.signals.values.2\" }",
    ),
    #[cfg(feature = "hdf5")]
    ("run73.mat", "time: \"t\", columns: { \"x\": (\"table.2\", \"mm\"), \"F\": \"many(2).values\" }"),
    #[cfg(feature = "parquet")]
    ("run.parquet", PLAIN),
    #[cfg(feature = "parquet")]
    ("packed.parquet", PLAIN),
];

#[test]
fn every_format_gives_the_bits_of_the_text() {
    let text = reference();
    assert_eq!(text.time.len(), 60);
    for (file, fields) in FILES {
        let record = format!("Table(path: \"FILE\", {fields})");
        let (table, said) = read(file, &fixture(file), &record).unwrap_or_else(|e| panic!("{file}: {e}"));
        assert_eq!(said, Vec::<String>::new(), "{file}");
        assert_eq!(bits(&table.time), bits(&text.time), "{file}, time");
        for k in 0..2 {
            assert_eq!(bits(&table.columns[k]), bits(&text.columns[k]), "{file}, column {k}");
        }
    }
}

#[test]
fn a_window_and_a_mean_of_rows_are_those_of_the_text() {
    let more = "window: (0.1, 0.5), decimate: 2";
    let text = read("run.csv", &fixture("run.csv"), &format!("Csv(path: \"FILE\", {PLAIN}, {more})"))
        .expect("text")
        .0;
    for file in ["run.xls", "run.mat", "run.npz"] {
        let table =
            read(file, &fixture(file), &format!("Table(path: \"FILE\", {PLAIN}, {more})")).expect(file).0;
        assert_eq!(
            (bits(&table.time), bits(&table.columns[0])),
            (bits(&text.time), bits(&text.columns[0])),
            "{file}"
        );
    }
}

#[test]
fn channels_with_rates_of_their_own_come_to_the_time_that_is_named() {
    let text = reference();
    let fields = |time: &str| {
        format!(
            "Table(path: \"FILE\", time: (\"{time}\", \"s\"), columns: {{ \"x\": (\"x\", \"mm\"), \"F\": (\"F\", \"N\") }})"
        )
    };
    // The slow one as it is, the fast one at its times.
    let (slow, said) = read("rates.tdms", &fixture("rates.tdms"), &fields("time of x")).expect("a record");
    assert_eq!((slow.time.len(), said.len()), (30, 0));
    for (k, column) in text.columns.iter().enumerate() {
        assert_eq!(bits(&slow.columns[k]), bits(&column.iter().copied().step_by(2).collect::<Vec<_>>()));
    }
    // As an input the fast one acts with all its samples.
    let own = slow.own[1].as_ref().expect("samples of its own");
    assert_eq!((bits(&own.values), own.time.len()), (bits(&text.columns[1]), text.time.len()));
    assert!(slow.own[0].is_none());
    // The other way round as well.
    let (fast, said) = read("rates.tdms", &fixture("rates.tdms"), &fields("time of F")).expect("a record");
    assert!(said.is_empty(), "{said:?}");
    assert_eq!(fast.own[0].as_ref().map(|own| own.time.len()), Some(30));
    // The slow one ends a sample earlier.
    assert_eq!((fast.time.len(), bits(&fast.columns[1])), (59, bits(&text.columns[1][..59])));
    assert!((fast.columns[0][1] - 0.5 * (text.columns[0][0] + text.columns[0][2])).abs() < 1e-15);
    // Variables of one file, by the times that stand beside them.
    let fields = "time: \"t2\", columns: { \"x\": (\"run.x\", \"mm\"), \"F\": \"slow\" }";
    let (own, said) = read("parts.mat", &fixture("parts.mat"), &format!("Table(path: \"FILE\", {fields})"))
        .expect("a record");
    assert_eq!(
        (bits(&own.columns[0]), bits(&own.columns[1]), said.len()),
        (bits(&slow.columns[0]), bits(&slow.columns[1]), 0)
    );
}

#[test]
fn a_draft_is_accepted_and_reads_its_file() {
    for (file, parts) in [
        ("run.xlsx", &["Table(path: \"run.xlsx\"", "sheet: \"Messung", "time: \"t\""][..]),
        ("run.ods", &["Table(", "sheet: \"Messung"]),
        ("run.xls", &["Table(", "time: \"t\""]),
        ("run.mat", &["Table(", "time: \"t\""]),
        ("run.npz", &["Table(", "time: \"t\""]),
        ("run.npy", &["Table(", "time: \"t\""]),
        (
            "run.uff",
            &["Table(", "time: (\"time\", \"s\")", "\"displacement 1Z+\", \"mm\"", "\"force 2Z+\", \"N\""],
        ),
        ("run.tdms", &["Table(", "time: (\"time\", \"s\")", "(\"x\", \"mm\")", "(\"F\", \"N\")"]),
        ("rates.tdms", &["Table(", "time: (\"time of x\", \"s\")", "(\"F\", \"N\")", "has times of its own"]),
        #[cfg(feature = "hdf5")]
        ("run.h5", &["Table(", "time: \"t\"", "(\"x\", \"mm\")", "(\"F\", \"N\")"]),
        #[cfg(feature = "hdf5")]
        ("pandas.h5", &["Table(", "time: \"t\""]),
        #[cfg(feature = "hdf5")]
        ("run73.mat", &["Table(", "time: \"t\""]),
        #[cfg(feature = "parquet")]
        ("run.parquet", &["Table(", "time: \"t\""]),
        ("run_utf16.csv", &["Csv(", "separator: ';'", "decimal: ','"]),
    ] {
        let mut sources = Sources::default();
        let at = (sources.add("command line", file), Span::new(0, file.len()));
        let bytes = fixture(file);
        let table = table(DataFile::of_bytes(file, &bytes), None, at, &mut sources)
            .unwrap_or_else(|d| panic!("{file}: {d:?}"));
        let draft = Draft::of(table).unwrap_or_else(|e| panic!("{file}: {e:?}"));
        let text = spec_text(&draft, file, "rig.ron");
        parts.iter().for_each(|part| assert!(text.contains(part), "{file}: expected {part:?} in\n{text}"));
        phisindy_import::accepted(&text).unwrap_or_else(|e| panic!("{file}: {e}\n{text}"));
        let (spec, _) = spec::read(&text, SourceId(0)).expect("accepted");
        let DataSpec::Csv(csv) = &spec.data[0] else { panic!("a record of a file") };
        let units = Units { time: Unit::ONE, columns: vec![Unit::ONE; csv.columns.len()] };
        let read = record(csv, &units, DataFile::of_bytes(file, &bytes), SourceId(0), &mut sources);
        assert!(read.is_ok(), "{file}: {:?}\n{text}", read.err());
    }
}

#[test]
fn what_is_wrong_is_told_with_what_to_do() {
    let cases: &[(&str, &str, &[&str])] = &[
        ("run.xlsx", PLAIN, &["several sheets hold numbers", "sheet: \"...\"", "Messung, Messung 2"]),
        (
            "run.xlsx",
            "sheet: \"Mesung\", time: \"t\", columns: { \"x\": \"x\" }",
            &["no sheet, variable or group `Mesung`", "did you mean `Messung`?"],
        ),
        ("run.mat", "sheet: \"s\", time: \"t\", columns: { \"x\": \"x\" }", &["`s`", "leave `sheet` out"]),
        (
            "run.csv",
            "sheet: \"s\", time: \"t\", columns: { \"x\": \"x\" }",
            &["is text, which has no sheet `s`"],
        ),
        (
            "run.npz",
            "time: \"time\", columns: { \"x\": \"x\" }",
            &["no column `time`", "columns of the file: t, x, F"],
        ),
        ("parts.mat", "time: \"run.t\", columns: { \"x\": \"text\" }", &["no column `text`"]),
        #[cfg(feature = "hdf5")]
        (
            "parts.h5",
            "sheet: \"run\", time: \"t\", columns: { \"x\": \"x\" }",
            &["no sheet, variable or group `run`", "there is: records, rows, table, a.run"],
        ),
        #[cfg(feature = "hdf5")]
        ("blosc.h5", PLAIN, &["is packed in a way that is not read", "h5repack -f NONE"]),
        #[cfg(feature = "hdf5")]
        ("parts.h5", "time: \"records.t\", columns: { \"x\": \"label\" }", &["no column `label`"]),
        #[cfg(feature = "hdf5")]
        ("run73.mat", "time: \"t\", columns: { \"x\": \"title\" }", &["no column `title`"]),
        #[cfg(feature = "parquet")]
        ("gaps.parquet", PLAIN, &["column `x` is `NaN` in row 4"]),
        #[cfg(feature = "parquet")]
        (
            "zstd.parquet",
            PLAIN,
            &["the column `t` is packed in a way that is not read", "compression='snappy'"],
        ),
    ];
    for (file, fields, parts) in cases {
        let said = read(file, &fixture(file), &format!("Table(path: \"FILE\", {fields})")).expect_err(file);
        parts.iter().for_each(|part| assert!(said.contains(part), "{file}: expected {part:?} in {said:?}"));
    }
    let converted: &[(&[u8], &str)] = &[
        #[cfg(not(feature = "hdf5"))]
        (b"\x89HDF\r\n\x1a\n.......", "h5py"),
        #[cfg(not(feature = "hdf5"))]
        (b"MATLAB 7.3 MAT-file, Platform", "--features hdf5"),
        #[cfg(not(feature = "parquet"))]
        (b"PAR1....", "read_parquet('a.bin')"),
        #[cfg(not(feature = "parquet"))]
        (b"PAR1....", "--features parquet"),
        (b"ARROW1..", "read_feather"),
        (b"MDF     4.10", "asammdf"),
        (b"\x1f\x8b\x08\0", "gunzip -k a.bin"),
        (b"7z\xBC\xAF\x27\x1C", "7z x"),
    ];
    for (bytes, part) in converted {
        let said = read("a.bin", bytes, &format!("Table(path: \"FILE\", {PLAIN})")).expect_err(part);
        assert!(said.contains("not read") && said.contains(part), "{said}");
    }
}

#[test]
fn a_file_with_a_password_is_told_as_such() {
    // The headers of all members say that they are encrypted.
    let locked = |name: &str| {
        let mut bytes = fixture(name);
        for at in 0..bytes.len() - 8 {
            match &bytes[at..at + 4] {
                b"PK\x03\x04" => bytes[at + 6] |= 1,
                b"PK\x01\x02" => bytes[at + 8] |= 1,
                _ => {}
            }
        }
        bytes
    };
    // A container of two streams, as Excel writes it for a workbook with a password.
    let mut container = b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1".to_vec();
    let names = "EncryptionInfo\0EncryptedPackage\0".encode_utf16();
    container.extend(names.flat_map(u16::to_le_bytes).chain([0; 1024]));
    for (bytes, format) in [
        (locked("run.xlsx"), "Excel (XLSX)"),
        (locked("run.ods"), "OpenDocument (ODS)"),
        (locked("run.npz"), "ZIP"),
        (container, "Excel"),
    ] {
        let said = read("a.bin", &bytes, &format!("Table(path: \"FILE\", {PLAIN})")).expect_err(format);
        let due = format!("is a file of {format}: it is protected by a password | save it without one");
        assert!(said.contains(&due), "{said}");
    }
}

#[test]
fn a_cell_without_a_number_is_told_with_its_row() {
    let mut bytes = fixture("run.npz");
    // The last number of F, in the last bytes before the directory of the archive, is made no number; its sum
    // is not looked at in a member that is stored: so the array alone is taken.
    let at = bytes.windows(6).rposition(|w| w == b"\x93NUMPY").expect("an array");
    let end = bytes[at..].windows(4).position(|w| w == b"PK\x01\x02" || w == b"PK\x03\x04").expect("an end");
    bytes = bytes[at..at + end].to_vec();
    let last = bytes.len() - 8;
    bytes[last..].copy_from_slice(&f64::NAN.to_le_bytes());
    let record = "Table(path: \"FILE\", time: Rate(100.0), columns: { \"x\": \"1\" })";
    let said = read("a.npy", &bytes, record).expect_err("no number");
    assert!(said.contains("column `1` is `NaN` in row 60"), "{said}");
}

/// Found by the fuzz target `format`: the name of a member was cut out of the text a byte behind the bracket.
#[test]
fn a_structure_whose_names_do_not_begin_behind_the_bracket_is_no_panic() {
    let mut bytes = fixture("run.npy");
    let at = bytes.windows(5).position(|w| w == b"('t',").expect("the first member");
    // Three bytes of one character, which is no mark.
    bytes[at + 1..at + 4].copy_from_slice("\u{fffd}".as_bytes());
    let said = read("run.npy", &bytes, &format!("Table(path: \"FILE\", {PLAIN})")).expect_err("no name");
    assert!(said.len() > 20, "{said}");
}

/// No damage makes a reader panic, hang or ask for absurd memory; what is refused is refused with a reason.
/// `PHISINDY_MUTATIONS=100000` makes it long.
#[test]
fn damaged_files_are_refused_or_read() {
    let mutations = std::env::var("PHISINDY_MUTATIONS").ok().and_then(|n| n.parse().ok()).unwrap_or(300);
    for (file, fields) in FILES {
        let (good, record) = (fixture(file), format!("Table(path: \"FILE\", {fields})"));
        let step = (good.len() / 150).max(1);
        for cut in (0..good.len()).step_by(step) {
            if let Err(said) = read(file, &good[..cut], &record) {
                assert!(said.len() > 20, "{file} cut at {cut}: {said}");
            }
        }
        let mut state = 12345_u64;
        for _ in 0..mutations {
            let mut bad = good.clone();
            for _ in 0..3 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let at = (state >> 33) as usize % bad.len();
                bad[at] = [0, 0xFF, 0x7F, (state >> 20) as u8][(state >> 60) as usize % 4];
            }
            let _ = read(file, &bad, &record);
        }
    }
}
