//! Files of a table in several formats, each with the very same numbers.

use super::question::Sheet;
use anyhow::{Context, Result};
use std::io::{Cursor, Write};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    /// Text: the character between fields, and the decimal mark.
    Text(char, char),
    Xlsx,
    Npz,
    /// Version 5, not packed.
    Matlab,
}

impl Format {
    pub(super) fn extension(self) -> &'static str {
        match self {
            Format::Text('\t', _) => "tsv",
            Format::Text(..) => "csv",
            Format::Xlsx => "xlsx",
            Format::Npz => "npz",
            Format::Matlab => "mat",
        }
    }

    /// The bytes of a file.
    ///
    /// # Errors
    /// A cell is no number, or an archive cannot be packed.
    pub(super) fn written(self, sheet: &Sheet) -> Result<Vec<u8>> {
        match self {
            Format::Text(separator, decimal) => {
                let line = |cells: Vec<String>| cells.join(&separator.to_string()) + "\n";
                let cells =
                    |row: &Vec<String>| row.iter().map(|c| c.replace('.', &decimal.to_string())).collect();
                let rows: String = sheet.rows.iter().map(|row| line(cells(row))).collect();
                Ok((line(sheet.heads.clone()) + &rows).into_bytes())
            }
            Format::Xlsx => packed(&workbook(sheet)),
            Format::Npz => {
                let arrays = columns(sheet)?.into_iter().map(|(name, x)| (format!("{name}.npy"), array(&x)));
                packed(&arrays.collect::<Vec<_>>())
            }
            Format::Matlab => {
                let mut out = format!("{:<124}", "MATLAB 5.0 MAT-file").into_bytes();
                out.extend([0x00, 0x01, b'I', b'M']);
                columns(sheet)?.iter().for_each(|(name, x)| out.extend(variable(name, x)));
                Ok(out)
            }
        }
    }
}

fn columns(sheet: &Sheet) -> Result<Vec<(&str, Vec<f64>)>> {
    let number = |cell: &String| cell.parse::<f64>().with_context(|| format!("`{cell}` is no number"));
    let column = |k: usize| sheet.rows.iter().map(|row| number(&row[k])).collect::<Result<_>>();
    sheet.heads.iter().enumerate().map(|(k, head)| Ok((head.as_str(), column(k)?))).collect()
}

fn packed(files: &[(String, Vec<u8>)]) -> Result<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (path, content) in files {
        zip.start_file(path, SimpleFileOptions::default())?;
        zip.write_all(content)?;
    }
    Ok(zip.finish()?.into_inner())
}

/// A NumPy array of double precision (NEP 1, version 1.0).
fn array(x: &[f64]) -> Vec<u8> {
    let head = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}", x.len());
    // Length of the head, with magic and length, is a multiple of 64; it ends with the end of a line.
    let width = (head.len() + 11).next_multiple_of(64) - 11;
    let mut out = b"\x93NUMPY\x01\x00".to_vec();
    out.extend((width as u16 + 1).to_le_bytes());
    out.extend(format!("{head:<width$}\n").bytes());
    out.extend(x.iter().flat_map(|x| x.to_le_bytes()));
    out
}

/// A column vector as a variable of a MATLAB file.
fn variable(name: &str, x: &[f64]) -> Vec<u8> {
    let element = |kind: u32, data: Vec<u8>| {
        let mut out = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
        out.extend(&data);
        out.resize(out.len().next_multiple_of(8), 0);
        out
    };
    let words = |all: [u32; 2]| all.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    // Flags (class double), dimensions, name, numbers.
    let parts = [
        element(6, words([6, 0])),
        element(5, words([x.len() as u32, 1])),
        element(1, name.as_bytes().to_vec()),
        element(9, x.iter().flat_map(|x| x.to_le_bytes()).collect()),
    ];
    element(14, parts.concat())
}

/// The parts of a workbook with one sheet (ECMA-376).
fn workbook(sheet: &Sheet) -> Vec<(String, Vec<u8>)> {
    const HEAD: &str = r#"<?xml version="1.0" encoding="UTF-8"?>"#;
    const MAIN: &str = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
    const OFFICE: &str = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
    const PACKAGE: &str = "http://schemas.openxmlformats.org/package/2006";
    const TYPE: &str = "application/vnd.openxmlformats-officedocument.spreadsheetml";
    let row = |cells: String| format!("<row>{cells}</row>");
    let heads = sheet.heads.iter().map(|h| format!(r#"<c t="inlineStr"><is><t>{h}</t></is></c>"#)).collect();
    let numbers = |r: &Vec<String>| row(r.iter().map(|c| format!("<c><v>{c}</v></c>")).collect());
    let rows: String = std::iter::once(row(heads)).chain(sheet.rows.iter().map(numbers)).collect();
    let relation = |kind: &str, target: &str| {
        format!(
            r#"<Relationships xmlns="{PACKAGE}/relationships"><Relationship Id="r1" Type="{OFFICE}/{kind}" Target="{target}"/></Relationships>"#
        )
    };
    let part = |name: &str, kind: &str| {
        format!(r#"<Override PartName="/xl/{name}.xml" ContentType="{TYPE}.{kind}+xml"/>"#)
    };
    let types = format!(
        r#"<Types xmlns="{PACKAGE}/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>{}{}</Types>"#,
        part("workbook", "sheet.main"),
        part("sheet1", "worksheet"),
    );
    let book = format!(
        r#"<workbook xmlns="{MAIN}" xmlns:r="{OFFICE}"><sheets><sheet name="run" sheetId="1" r:id="r1"/></sheets></workbook>"#
    );
    [
        ("[Content_Types].xml", types),
        ("_rels/.rels", relation("officeDocument", "xl/workbook.xml")),
        ("xl/workbook.xml", book),
        ("xl/_rels/workbook.xml.rels", relation("worksheet", "sheet1.xml")),
        ("xl/sheet1.xml", format!(r#"<worksheet xmlns="{MAIN}"><sheetData>{rows}</sheetData></worksheet>"#)),
    ]
    .map(|(path, text)| (path.to_owned(), format!("{HEAD}{text}").into_bytes()))
    .to_vec()
}
