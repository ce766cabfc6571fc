//! Workbooks: XLSX, XLSB, XLS and ODS.

use crate::cell::Cell;
use crate::clock::stamp_text;
use crate::listing::listing;
use crate::refusal::{Refusal, Wanted, guarded};
use crate::sheet::{Rows, Sheet};
use calamine::{
    Data, DataRef, ExcelDateTime, Ods, OdsError, Reader, Sheet as Listed, SheetVisible, Xls, XlsError, Xlsb,
    Xlsx,
};
use std::fmt::Display;
use std::io::Cursor;

/// Most cells of a sheet: 300 MB in memory.
const MOST_CELLS: usize = 20_000_000;
/// Nanoseconds of a microsecond, as exact as a time in days is, and of a day.
const MICROSECOND: i128 = 1_000;
const DAY: f64 = 86_400e6;
/// From the end of 1899, where Excel counts days from, to 1970.
const EPOCH: i128 = 25_569;

/// The refusal that holds the words of a reader.
fn broken<E: Display>(format: &str) -> impl Fn(E) -> Refusal {
    move |e| Refusal::broken(format, e.to_string())
}

/// The wanted sheet of an XLSX file.
pub(super) fn xlsx(bytes: &[u8], wanted: &Wanted<'_>) -> Result<Sheet, Refusal> {
    guarded("XLSX", || read_xlsx(bytes, wanted))
}

fn read_xlsx(bytes: &[u8], wanted: &Wanted<'_>) -> Result<Sheet, Refusal> {
    let mut book = Xlsx::new(Cursor::new(bytes)).map_err(broken("XLSX"))?;
    let sheets = book.sheets_metadata().to_vec();
    chosen(&sheets, wanted, |name| {
        let mut cells = book.worksheet_cells_reader(name).map_err(broken("XLSX"))?;
        Grid::of(|| cells.next_cell().map_err(broken("XLSX")))
    })
}

/// The wanted sheet of an XLSB file.
pub(super) fn xlsb(bytes: &[u8], wanted: &Wanted<'_>) -> Result<Sheet, Refusal> {
    guarded("XLSB", || read_xlsb(bytes, wanted))
}

fn read_xlsb(bytes: &[u8], wanted: &Wanted<'_>) -> Result<Sheet, Refusal> {
    let mut book = Xlsb::new(Cursor::new(bytes)).map_err(broken("XLSB"))?;
    let sheets = book.sheets_metadata().to_vec();
    chosen(&sheets, wanted, |name| {
        let mut cells = book.worksheet_cells_reader(name).map_err(broken("XLSB"))?;
        Grid::of(|| cells.next_cell().map_err(broken("XLSB")))
    })
}

/// The wanted sheet of an XLS file.
pub(super) fn xls(bytes: &[u8], wanted: &Wanted<'_>) -> Result<Sheet, Refusal> {
    guarded("XLS", || read_xls(bytes, wanted))
}

fn read_xls(bytes: &[u8], wanted: &Wanted<'_>) -> Result<Sheet, Refusal> {
    if is_encrypted(bytes) {
        return Err(Refusal::protected().of("Excel"));
    }
    if let Some(rows) = too_large(bytes) {
        return Err(Refusal::broken("XLS", format!("a sheet should have {rows} rows or too many columns")));
    }
    let book: Xls<_> = Xls::new(Cursor::new(bytes)).map_err(|e| match e {
        XlsError::Password => Refusal::protected(),
        e => broken("XLS")(e),
    })?;
    whole(book, "XLS", wanted)
}

/// The wanted sheet of an ODS file.
pub(super) fn ods(bytes: &[u8], wanted: &Wanted<'_>) -> Result<Sheet, Refusal> {
    guarded("ODS", || read_ods(bytes, wanted))
}

fn read_ods(bytes: &[u8], wanted: &Wanted<'_>) -> Result<Sheet, Refusal> {
    let book: Ods<_> = Ods::new(Cursor::new(bytes)).map_err(|e| match e {
        OdsError::Password => Refusal::protected(),
        e => broken("ODS")(e),
    })?;
    whole(book, "ODS", wanted)
}

/// Whether the container of an XLS file holds an encrypted workbook of another format, in two streams with
/// these names.
fn is_encrypted(bytes: &[u8]) -> bool {
    ["EncryptionInfo", "EncryptedPackage"].iter().all(|name| {
        let name: Vec<u8> = name.encode_utf16().flat_map(u16::to_le_bytes).collect();
        bytes.windows(name.len()).any(|window| window == name)
    })
}

/// The rows of a sheet that is declared larger than the format allows (65 536 rows of 256 cells): the reader
/// would ask for memory for all of them.
fn too_large(bytes: &[u8]) -> Option<u32> {
    // The record of the dimensions: its type, its length; rows and columns from, to; two bytes of nothing.
    bytes.windows(18).filter(|w| matches!(w[..4], [0, 2, 14 | 16, 0])).find_map(|w| {
        let rows = u32::from_le_bytes([w[8], w[9], w[10], w[11]]);
        let first = u32::from_le_bytes([w[4], w[5], w[6], w[7]]);
        let columns = u16::from_le_bytes([w[14], w[15]]);
        (rows > 65_536 || first > rows || columns > 256).then_some(rows)
    })
}

fn whole<'b, R: Reader<Cursor<&'b [u8]>>>(
    mut book: R,
    format: &str,
    wanted: &Wanted<'_>,
) -> Result<Sheet, Refusal>
where
    R::Error: Display,
{
    let sheets = book.sheets_metadata().to_vec();
    chosen(&sheets, wanted, |name| {
        let range = book.worksheet_range(name).map_err(broken(format))?;
        let (top, left) = range.start().unwrap_or((0, 0));
        let mut grid = Grid::default();
        for (row, column, value) in range.used_cells() {
            // Rows and columns of a sheet are fewer than 2^32.
            grid.put(top + row as u32, left + column as u32, of(value))?;
        }
        Ok(grid)
    })
}

/// The wanted sheet; without a name the one with numbers, or for `new` the one with most of them. Of hidden
/// sheets one is taken only where no other sheet has numbers.
fn chosen(
    sheets: &[Listed],
    wanted: &Wanted<'_>,
    mut read: impl FnMut(&str) -> Result<Grid, Refusal>,
) -> Result<Sheet, Refusal> {
    if let Some(name) = wanted.sheet() {
        if !sheets.iter().any(|sheet| sheet.name == name) {
            let names: Vec<String> = sheets.iter().map(|sheet| sheet.name.clone()).collect();
            return Err(Refusal::missing_sheet(name, &names));
        }
        return Ok(read(name)?.sheet(Some(name.to_owned()), vec![]));
    }
    let mut found: Vec<(&Listed, Grid)> = vec![];
    let mut first_mistake = None;
    for sheet in sheets {
        match read(&sheet.name) {
            Ok(grid) if grid.rows_of_numbers() > 1 => found.push((sheet, grid)),
            Ok(_) => {}
            // A sheet of charts is none of cells.
            Err(mistake) => first_mistake = first_mistake.or(Some(mistake)),
        }
    }
    let of = |visible: bool| {
        let own = found.iter().filter(|(sheet, _)| (sheet.visible == SheetVisible::Visible) == visible);
        own.map(|(sheet, _)| sheet.name.clone()).collect::<Vec<String>>()
    };
    let (seen, hidden) = (of(true), of(false));
    let candidates = if seen.is_empty() { &hidden } else { &seen };
    if let (Wanted::Record(_), [_, _, ..]) = (wanted, candidates.as_slice()) {
        let help = format!("say which: `sheet: \"...\"`; there is: {}", listing(candidates));
        return Err(Refusal::file("several sheets hold numbers", &help));
    }
    let several = found.len() > 1;
    let usable = found.into_iter().filter(|(sheet, _)| candidates.contains(&sheet.name));
    let most = |a: (_, Grid), b: (_, Grid)| if b.1.rows_of_numbers() > a.1.rows_of_numbers() { b } else { a };
    let Some((sheet, grid)) = usable.reduce(most) else {
        let empty = || {
            Refusal::file(
                "none of its sheets holds rows of numbers",
                "give a sheet with a heading and rows of numbers",
            )
        };
        return Err(first_mistake.unwrap_or_else(empty));
    };
    let others = candidates.iter().filter(|name| **name != sheet.name).cloned().collect();
    let table = grid.sheet(several.then(|| sheet.name.clone()), others);
    let notes = match wanted {
        Wanted::Record(_) => vec![],
        Wanted::All { .. } => hidden.iter().map(|name| told(name, &sheet.name)).collect(),
    };
    Ok(Sheet { notes, ..table })
}

/// What is said of a hidden sheet with numbers.
fn told(hidden: &str, taken: &str) -> String {
    if hidden == taken {
        format!("the sheet `{hidden}` is hidden, and taken because no other sheet holds numbers")
    } else {
        format!("the sheet `{hidden}` holds numbers too, and is hidden (take it with `phisindy new --sheet`)")
    }
}

/// The cells of a sheet that hold something, row by row.
#[derive(Default)]
struct Grid {
    rows: Vec<(u32, Vec<(u32, Cell)>)>,
    cells: usize,
}

impl Grid {
    /// The cells that a reader gives one after the other.
    fn of<'c>(
        mut next: impl FnMut() -> Result<Option<calamine::Cell<DataRef<'c>>>, Refusal>,
    ) -> Result<Grid, Refusal> {
        let mut grid = Grid::default();
        while let Some(cell) = next()? {
            let (row, column) = cell.get_position();
            grid.put(row, column, of_ref(cell.get_value()))?;
        }
        Ok(grid)
    }

    fn put(&mut self, row: u32, column: u32, cell: Cell) -> Result<(), Refusal> {
        if cell == Cell::Empty {
            return Ok(());
        }
        self.cells += 1;
        if self.cells > MOST_CELLS {
            return Err(Refusal::file(
                "a sheet holds more than 20 million cells",
                "write the time, the motion and the inputs to a sheet of their own, or export text",
            ));
        }
        match self.rows.last_mut() {
            Some((last, cells)) if *last == row => cells.push((column, cell)),
            _ => self.rows.push((row, vec![(column, cell)])),
        }
        Ok(())
    }

    fn is_of_numbers(row: &(u32, Vec<(u32, Cell)>)) -> bool {
        row.1.iter().filter(|(_, cell)| matches!(cell, Cell::Number(_))).count() > 1
    }

    fn rows_of_numbers(&self) -> usize {
        self.rows.iter().filter(|row| Grid::is_of_numbers(row)).count()
    }

    /// The columns of the rows that hold numbers, of all rows.
    fn sheet(mut self, name: Option<String>, others: Vec<String>) -> Sheet {
        // Files of some programs are not in order.
        self.rows.sort_by_key(|row| row.0);
        let columns =
            || self.rows.iter().filter(|row| Grid::is_of_numbers(row)).flat_map(|row| &row.1).map(|c| c.0);
        let (left, right) = (columns().min().unwrap_or(0), columns().max().unwrap_or(0));
        // Cells far apart are no table: the columns between them are left out.
        let mut used: Vec<u32> =
            self.rows.iter().flat_map(|r| &r.1).map(|c| c.0).filter(|c| (left..=right).contains(c)).collect();
        used.sort_unstable();
        used.dedup();
        let width = used.len();
        let rows = self.rows.into_iter().filter_map(|(row, cells)| {
            let mut line = vec![Cell::Empty; width];
            for (column, cell) in cells {
                if let Ok(k) = used.binary_search(&column) {
                    line[k] = cell;
                }
            }
            line.iter().any(|cell| *cell != Cell::Empty).then_some((row as usize + 1, line))
        });
        let rows = rows.collect();
        Sheet { name, others, notes: vec![], own: vec![], rows: Rows::Cells(rows) }
    }
}

fn of(value: &Data) -> Cell {
    match value {
        Data::Int(x) => Cell::Number(*x as f64),
        Data::Float(x) => Cell::Number(*x),
        Data::Bool(x) => Cell::Number(f64::from(u8::from(*x))),
        Data::String(text) => word(text),
        Data::DateTime(time) => moment(*time),
        Data::DateTimeIso(text) => word(text),
        Data::DurationIso(text) => duration(text),
        Data::Error(error) => Cell::Word(error.to_string().into()),
        Data::Empty => Cell::Empty,
    }
}

fn of_ref(value: &DataRef<'_>) -> Cell {
    match value {
        DataRef::Int(x) => Cell::Number(*x as f64),
        DataRef::Float(x) => Cell::Number(*x),
        DataRef::Bool(x) => Cell::Number(f64::from(u8::from(*x))),
        DataRef::String(text) => word(text),
        DataRef::SharedString(text) => word(text),
        DataRef::DateTime(time) => moment(*time),
        DataRef::DateTimeIso(text) => word(text),
        DataRef::DurationIso(text) => duration(text),
        DataRef::Error(error) => Cell::Word(error.to_string().into()),
        DataRef::Empty => Cell::Empty,
    }
}

/// Words; a number that another program wrote as text is one.
fn word(text: &str) -> Cell {
    let text = text.trim();
    if text.is_empty() {
        return Cell::Empty;
    }
    // Of numbers the workbook knows the mark itself; a comma can only be a decimal mark that it did not know.
    let number = if text.contains('.') { text.parse() } else { text.replacen(',', ".", 1).parse::<f64>() };
    match number {
        Ok(x) if x.is_finite() => Cell::Number(x),
        _ => Cell::Word(text.into()),
    }
}

/// A time of day, with its date. Days are stored as a double, to less than a microsecond.
fn moment(time: ExcelDateTime) -> Cell {
    let days = time.as_f64();
    // Beyond the year 9999 there are no dates.
    if !(0.0..2_958_466.0).contains(&days) {
        return Cell::Number(days);
    }
    let microseconds = (days * DAY).round() as i128;
    Cell::Word(stamp_text(microseconds * MICROSECOND - EPOCH * 86_400_000_000_000).into())
}

/// `PT10H32M07.125S` as `10:32:07.125`.
fn duration(text: &str) -> Cell {
    let parts = || {
        let (hours, rest) = text.strip_prefix("PT")?.split_once('H')?;
        let (minutes, seconds) = rest.split_once('M')?;
        Some(format!("{hours}:{minutes}:{}", seconds.strip_suffix('S')?))
    };
    parts().map_or_else(|| word(text), |time| Cell::Word(time.into()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use calamine::SheetType;

    /// What is taken of a workbook whose sheets have so many rows of numbers; hidden ones begin with `h`.
    fn taken(sheets: &[(&str, u32)]) -> Sheet {
        let visible = |name: &str| match name.starts_with('h') {
            true => SheetVisible::Hidden,
            false => SheetVisible::Visible,
        };
        let listed = |&(name, _): &(&str, u32)| Listed {
            name: name.to_owned(),
            typ: SheetType::WorkSheet,
            visible: visible(name),
        };
        let all: Vec<Listed> = sheets.iter().map(listed).collect();
        let read = |name: &str| {
            let rows = sheets.iter().find(|s| s.0 == name).map_or(0, |s| s.1);
            let mut grid = Grid::default();
            for k in 0..2 * rows {
                grid.put(k / 2, k % 2, Cell::Number(f64::from(k)))?;
            }
            Ok(grid)
        };
        chosen(&all, &Wanted::All { sheet: None }, read).expect("a sheet")
    }

    #[test]
    fn a_hidden_sheet_is_taken_where_no_other_has_numbers_and_told() {
        let sheet = taken(&[("hidden", 50), ("seen", 20), ("small", 10)]);
        assert_eq!((sheet.name.as_deref(), sheet.lines()), (Some("seen"), 20));
        assert_eq!(sheet.others, ["small"]);
        assert!(sheet.notes[0].starts_with("the sheet `hidden` holds numbers too, and is hidden"));
        let sheet = taken(&[("hidden", 50), ("empty", 0)]);
        assert_eq!((sheet.lines(), sheet.notes.len()), (50, 1));
        assert!(sheet.notes[0].contains("`hidden` is hidden, and taken because"), "{:?}", sheet.notes);
        assert_eq!(taken(&[("seen", 20)]).notes.len(), 0);
    }
}
