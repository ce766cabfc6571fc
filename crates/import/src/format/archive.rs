//! ZIP archives: workbooks and NumPy's `.npz`, told apart by the names of their members.

use super::{numpy, workbook};
use crate::channel::{Channel, MOST_CHANNELS};
use crate::channels;
use crate::refusal::{Refusal, Wanted};
use crate::sheet::Sheet;
use std::io::{Cursor, Read};
use zip::ZipArchive;

const FORMAT: &str = "ZIP";
/// Most bytes of all members: as much as a file may have that is not packed.
const MOST_BYTES: u64 = 2 << 30;

/// Reads the wanted sheet of a workbook.
type ReadWorkbook = fn(&[u8], &Wanted<'_>) -> Result<Sheet, Refusal>;

/// The table in an archive.
pub(super) fn sheet(bytes: &[u8], wanted: &Wanted<'_>) -> Result<Sheet, Refusal> {
    let mut archive =
        ZipArchive::new(Cursor::new(bytes)).map_err(|e| Refusal::broken(FORMAT, e.to_string()))?;
    let has = |name: &str| archive.index_for_name(name).is_some();
    let workbooks: [(&str, &str, ReadWorkbook); 4] = [
        ("xl/workbook.xml", "Excel (XLSX)", workbook::xlsx),
        ("xl/workbook.bin", "Excel (XLSB)", workbook::xlsb),
        ("content.xml", "OpenDocument (ODS)", workbook::ods),
        ("encrypted-package", "OpenDocument (ODS)", |_, _| Err(Refusal::protected())),
    ];
    if let Some((_, format, read)) = workbooks.into_iter().find(|(member, ..)| has(member)) {
        let read = checked(&mut archive).and_then(|()| read(bytes, wanted));
        return read.map_err(|refusal| refusal.of(format));
    }
    checked(&mut archive)?;
    let arrays: Vec<String> = archive
        .file_names()
        .filter_map(|name| Some(name.ok()?.into_owned()))
        .filter(|name| name.ends_with(".npy"))
        .collect();
    if arrays.is_empty() {
        return Err(Refusal::file(
            "it holds neither a workbook nor arrays of NumPy",
            "unpack it: unzip, then name the file in it",
        ));
    }
    npz(archive, &arrays).and_then(|all| channels::sheet(all, wanted))
}

/// Reads every member once: its sum must be right, and all together must not be too large.
/// Readers of workbooks rely on both.
fn checked(archive: &mut ZipArchive<Cursor<&[u8]>>) -> Result<(), Refusal> {
    let mut left = MOST_BYTES;
    for k in 0..archive.len() {
        let broken = |e: String| Refusal::broken(FORMAT, format!("its member {}: {e}", k + 1));
        if archive.by_index_raw(k).is_ok_and(|member| member.encrypted()) {
            return Err(Refusal::protected());
        }
        let member = archive.by_index(k).map_err(|e| broken(e.to_string()))?;
        let read = std::io::copy(&mut member.take(left + 1), &mut std::io::sink())
            .map_err(|e| broken(e.to_string()))?;
        left = left.checked_sub(read).ok_or_else(|| {
            Refusal::file(
                "it unpacks to more than 2 GB",
                "write the time, the motion and the inputs to a file of their own",
            )
        })?;
    }
    Ok(())
}

/// The arrays of a `.npz`.
fn npz(mut archive: ZipArchive<Cursor<&[u8]>>, names: &[String]) -> Result<Vec<Channel>, Refusal> {
    let mut all = vec![];
    let mut left = MOST_BYTES;
    for name in names {
        let broken = |e: String| Refusal::broken(FORMAT, format!("its member `{name}`: {e}"));
        let mut bytes = vec![];
        let member = archive.by_name(name).map_err(|e| broken(e.to_string()))?;
        let most = left;
        member.take(most).read_to_end(&mut bytes).map_err(|e| broken(e.to_string()))?;
        left -= bytes.len() as u64;
        if !bytes.starts_with(b"\x93NUMPY") {
            return Err(broken("no array".to_owned()));
        }
        all.extend(numpy::array(&bytes, name.trim_end_matches(".npy"))?);
        if all.len() > MOST_CHANNELS {
            break;
        }
    }
    Ok(all)
}
