//! MATLAB files of version 5 to 7: `save` without `-v7.3`.

use crate::bytes::{Bytes, Kind};
use crate::channel::{Channel, MOST_CHANNELS};
use crate::matrix;
use crate::refusal::Refusal;
use flate2::read::ZlibDecoder;
use std::io::Read;

const FORMAT: &str = "MATLAB";
/// Bytes before the first element.
const HEAD: usize = 128;
/// Most bytes of an element that is packed: as much as a file may have.
const MOST_BYTES: u64 = 2 << 30;
/// Structures within structures: more are no data of a record.
const DEEPEST: usize = 8;

/// Types of elements.
const MATRIX: u32 = 14;
const PACKED: u32 = 15;

/// The columns of a file: vectors by their names, matrices and structures as groups of columns.
pub(super) fn channels(bytes: &[u8]) -> Result<Vec<Channel>, Refusal> {
    let Some(head) = bytes.get(..HEAD) else { return Err(Refusal::broken(FORMAT, "its head is cut off")) };
    let mut rest = Bytes::new(&bytes[HEAD..], head[126..] == *b"MI");
    let mut found = Found::default();
    while !rest.rest().is_empty() {
        let at = bytes.len() - rest.rest().len();
        let cut = || Refusal::broken(FORMAT, format!("it ends inside the variable that begins at byte {at}"));
        let (kind, data) = element(&mut rest, false).ok_or_else(cut)?;
        if kind == PACKED {
            let mut plain = Vec::new();
            let read = ZlibDecoder::new(data).take(MOST_BYTES).read_to_end(&mut plain);
            read.map_err(|e| {
                Refusal::broken(FORMAT, format!("the variable at byte {at} cannot be unpacked ({e})"))
            })?;
            let (kind, data) = element(&mut Bytes::new(&plain, rest.big), true).ok_or_else(cut)?;
            if kind == MATRIX {
                found.matrix(Bytes::new(data, rest.big), None, 0).ok_or_else(cut)?;
            }
        } else if kind == MATRIX {
            found.matrix(Bytes::new(data, rest.big), None, 0).ok_or_else(cut)?;
        }
        if found.channels.len() > MOST_CHANNELS {
            break;
        }
    }
    match found {
        Found { channels, opaque } if channels.is_empty() && opaque => Err(crate::refusal::matlab_objects()),
        Found { channels, .. } => Ok(channels),
    }
}

/// The next element: its type and its bytes; none at the end. Those of a variable begin at multiples of 8.
fn element<'a>(bytes: &mut Bytes<'a>, padded: bool) -> Option<(u32, &'a [u8])> {
    let tag = bytes.u32()?;
    if tag >> 16 != 0 {
        // Up to four bytes stand in the tag itself.
        let data = bytes.take(4)?.get(..(tag >> 16) as usize)?;
        return Some((tag & 0xFFFF, data));
    }
    let size = bytes.u32()? as usize;
    let data = bytes.take(size)?;
    if padded {
        // The last one may end without padding.
        let padding = (8 - size % 8) % 8;
        bytes.take(padding.min(bytes.rest().len()))?;
    }
    Some((tag, data))
}

/// Numbers of a type of elements.
fn storage(kind: u32) -> Option<Kind> {
    Some(match kind {
        1 => Kind::I8,
        2 => Kind::U8,
        3 => Kind::I16,
        4 => Kind::U16,
        5 => Kind::I32,
        6 => Kind::U32,
        7 => Kind::F32,
        9 => Kind::F64,
        12 => Kind::I64,
        13 => Kind::U64,
        _ => return None,
    })
}

/// The columns found so far.
#[derive(Default)]
struct Found {
    channels: Vec<Channel>,
    /// Whether there was an object whose content is not documented.
    opaque: bool,
}

impl Found {
    /// A variable, or a member of a structure that is called `within` and then `name`; none if it is cut off.
    fn matrix(&mut self, mut bytes: Bytes<'_>, name: Option<(&str, &str)>, depth: usize) -> Option<()> {
        let big = bytes.big;
        if bytes.rest().is_empty() {
            // An empty cell or member.
            return Some(());
        }
        let flags = Bytes::new(element(&mut bytes, true)?.1, big).u32()?;
        let class = flags & 0xFF;
        // Objects whose content is not documented have a head of their own.
        if class == 17 || class == 16 || class == 3 {
            self.opaque = true;
            return Some(());
        }
        let mut sides = Bytes::new(element(&mut bytes, true)?.1, big);
        let sides: Vec<usize> =
            std::iter::from_fn(|| sides.i32()).map(|n| usize::try_from(n).unwrap_or(0)).collect();
        let own = String::from_utf8_lossy(element(&mut bytes, true)?.1).into_owned();
        let (group, name) = name.unwrap_or(("", &own));
        match class {
            2 => self.structure(bytes, group, name, &sides, depth),
            6..=15 => self.numbers(bytes, group, name, &sides, flags & 0x800 != 0),
            // Cells, texts, sparse matrices, functions.
            _ => Some(()),
        }
    }

    fn numbers(
        &mut self,
        mut bytes: Bytes<'_>,
        group: &str,
        name: &str,
        sides: &[usize],
        complex: bool,
    ) -> Option<()> {
        let &[rows, columns] = sides else { return Some(()) };
        if rows.max(columns) < 2 || rows.min(columns) == 0 || complex {
            return Some(());
        }
        let big = bytes.big;
        let (kind, data) = element(&mut bytes, true)?;
        let count = rows.checked_mul(columns)?;
        let all = storage(kind)?.read_many(&mut Bytes::new(data, big), count)?;
        self.channels.extend(matrix::channels(group, name, (rows, columns), false, all));
        Some(())
    }

    /// The members of a structure; those of the k-th of several begin with its number.
    fn structure(
        &mut self,
        mut bytes: Bytes<'_>,
        group: &str,
        name: &str,
        sides: &[usize],
        depth: usize,
    ) -> Option<()> {
        let big = bytes.big;
        let width = Bytes::new(element(&mut bytes, true)?.1, big).u32()? as usize;
        let names = element(&mut bytes, true)?.1;
        if width == 0 || depth == DEEPEST {
            return Some(());
        }
        let text = |name: &[u8]| String::from_utf8_lossy(name).trim_end_matches('\0').to_owned();
        let names: Vec<String> = names.chunks_exact(width).map(text).collect();
        let count = sides.iter().try_fold(1_usize, |all, side| all.checked_mul(*side))?;
        let inner = matrix::inner(group, name);
        if names.is_empty() {
            return Some(());
        }
        for k in 0..count {
            let inner = if count == 1 { inner.clone() } else { format!("{inner}({})", k + 1) };
            for member in &names {
                let (_, data) = element(&mut bytes, true)?;
                self.matrix(Bytes::new(data, big), Some((&inner, member)), depth + 1)?;
                if self.channels.len() > MOST_CHANNELS {
                    return Some(());
                }
            }
        }
        Some(())
    }
}
