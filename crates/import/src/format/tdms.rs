//! TDMS, the measurement files of LabVIEW.

use crate::bytes::{Bytes, Kind};
use crate::channel::{Channel, Clock, Values};
use crate::clock::stamp_text;
use crate::refusal::Refusal;
use std::collections::HashMap;

const FORMAT: &str = "TDMS";
/// Bytes of the head of a segment.
const HEAD: usize = 28;
/// What a segment holds.
const NEW_LIST: u32 = 1 << 2;
const METADATA: u32 = 1 << 1;
const RAW: u32 = 1 << 3;
const INTERLEAVED: u32 = 1 << 5;
const BIG: u32 = 1 << 6;
/// From 1904, where times begin, to 1970.
const EPOCH: i128 = 2_082_844_800;

/// The type of the samples of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Type {
    Number(Kind),
    Text,
    Time,
    /// No samples of a record: complex numbers and the like.
    Other(usize),
}

impl Type {
    fn of(code: u32) -> Option<Type> {
        use Type::{Number, Other, Text, Time};
        Some(match code {
            0 => Other(0),
            1 => Number(Kind::I8),
            2 => Number(Kind::I16),
            3 => Number(Kind::I32),
            4 => Number(Kind::I64),
            5 | 0x21 => Number(Kind::U8),
            6 => Number(Kind::U16),
            7 => Number(Kind::U32),
            8 => Number(Kind::U64),
            9 | 0x19 => Number(Kind::F32),
            10 | 0x1A => Number(Kind::F64),
            11 | 0x1B => Other(16),
            0x20 => Text,
            0x44 => Time,
            0x08_000C => Other(8),
            0x10_000D => Other(16),
            _ => return None,
        })
    }

    /// Bytes of a sample; 0 for texts.
    fn size(self) -> usize {
        match self {
            Type::Number(kind) => kind.size(),
            Type::Text => 0,
            Type::Time => 16,
            Type::Other(size) => size,
        }
    }
}

/// A piece of a channel in a segment.
#[derive(Clone, Copy, Debug)]
struct Piece {
    kind: Type,
    count: usize,
    bytes: usize,
}

/// A channel as far as it was read.
#[derive(Debug, Default)]
struct Object {
    path: String,
    piece: Option<Piece>,
    numbers: Vec<f64>,
    words: Vec<String>,
    unit: Option<String>,
    increment: Option<f64>,
    offset: f64,
}

/// The channels of all groups.
pub(super) fn channels(bytes: &[u8]) -> Result<Vec<Channel>, Refusal> {
    let mut file = File::default();
    let mut at = 0;
    while at < bytes.len() {
        at = file.segment(bytes, at)?;
    }
    Ok(file.objects.into_iter().filter_map(Object::channel).collect())
}

#[derive(Default)]
struct File {
    objects: Vec<Object>,
    by_path: HashMap<String, usize>,
    /// Objects of the last segment, in its order.
    list: Vec<usize>,
}

impl File {
    /// Reads the segment at a byte; returns where the next one begins.
    fn segment(&mut self, all: &[u8], at: usize) -> Result<usize, Refusal> {
        let broken = |what: &str| Refusal::broken(FORMAT, format!("the segment at byte {at} {what}"));
        let cut = || broken("is cut off");
        let head = all.get(at..).and_then(|rest| rest.get(..HEAD)).ok_or_else(cut)?;
        if !head.starts_with(b"TDSm") {
            return Err(broken("does not begin as one"));
        }
        let mut head = Bytes::new(&head[4..], false);
        let contents = head.u32().ok_or_else(cut)?;
        head.big = contents & BIG != 0;
        let (_, next, raw) = (head.u32(), head.u64().ok_or_else(cut)?, head.u64().ok_or_else(cut)?);
        let start = at + HEAD;
        // A program that was stopped leaves the length open.
        let end = if next == u64::MAX {
            Some(all.len())
        } else {
            place(start, next).filter(|end| *end <= all.len())
        };
        let end = end.ok_or_else(cut)?;
        let raw = place(start, raw).filter(|raw| *raw <= end).ok_or_else(cut)?;
        if contents & METADATA != 0 {
            if contents & NEW_LIST != 0 {
                self.list.clear();
            }
            self.metadata(Bytes::new(&all[start..raw], contents & BIG != 0)).map_err(|e| broken(&e))?;
        }
        if contents & RAW != 0 {
            self.raw(&all[raw..end], contents).ok_or_else(|| broken("ends inside a sample"))?;
        }
        Ok(end)
    }

    fn metadata(&mut self, mut bytes: Bytes<'_>) -> Result<(), String> {
        let cut = || "has a head that is cut off".to_owned();
        let count = bytes.u32().ok_or_else(cut)?;
        for _ in 0..count {
            let path = text(&mut bytes).ok_or_else(cut)?;
            let index = bytes.u32().ok_or_else(cut)?;
            let place = match self.by_path.get(&path) {
                Some(place) => *place,
                None => {
                    self.objects.push(Object { path: path.clone(), ..Object::default() });
                    self.by_path.insert(path.clone(), self.objects.len() - 1);
                    self.objects.len() - 1
                }
            };
            match index {
                u32::MAX => self.list.retain(|k| *k != place),
                0x0000_1269 | 0x0000_1369 | 0x6912_0000 | 0x6913_0000 => {
                    return Err(
                        "holds raw values of a device (DAQmx): convert it with npTDMS, `tdmsinfo` and `as_dataframe`".to_owned()
                    );
                }
                index => {
                    if index != 0 {
                        let code = bytes.u32().ok_or_else(cut)?;
                        let kind = Type::of(code)
                            .ok_or_else(|| format!("has samples of the unknown type {code}"))?;
                        let (_, count) = (bytes.u32(), bytes.u64().ok_or_else(cut)?);
                        let count = usize::try_from(count).map_err(|_| cut())?;
                        let size = if kind == Type::Text {
                            bytes.u64().and_then(|n| usize::try_from(n).ok())
                        } else {
                            count.checked_mul(kind.size())
                        };
                        let bytes = size.ok_or_else(cut)?;
                        self.objects[place].piece = Some(Piece { kind, count, bytes });
                    }
                    if !self.list.contains(&place) {
                        self.list.push(place);
                    }
                }
            }
            let count = bytes.u32().ok_or_else(cut)?;
            for _ in 0..count {
                self.objects[place].property(&mut bytes).ok_or_else(cut)?;
            }
        }
        Ok(())
    }

    /// The samples of a segment: the list of its channels again and again until it ends.
    fn raw(&mut self, all: &[u8], contents: u32) -> Option<()> {
        let pieces: Vec<(usize, Piece)> =
            self.list.iter().filter_map(|&k| self.objects[k].piece.map(|piece| (k, piece))).collect();
        let size = pieces.iter().try_fold(0_usize, |sum, (_, p)| sum.checked_add(p.bytes))?;
        if size == 0 {
            return Some(());
        }
        let big = contents & BIG != 0;
        for chunk in all.chunks(size) {
            let mut bytes = Bytes::new(chunk, big);
            if contents & INTERLEAVED != 0 {
                let rows = pieces.iter().map(|(_, p)| p.count).max().unwrap_or(0);
                'rows: for _ in 0..rows {
                    for (k, piece) in &pieces {
                        // A program that was stopped leaves the last row unfinished.
                        if self.objects[*k].sample(piece.kind, &mut bytes).is_none() {
                            break 'rows;
                        }
                    }
                }
                continue;
            }
            for (k, piece) in &pieces {
                if piece.kind == Type::Text {
                    self.objects[*k].texts(Bytes::new(bytes.take(piece.bytes)?, big), piece.count)?;
                    continue;
                }
                let whole = piece.bytes <= bytes.rest().len();
                for _ in 0..piece.count.min(chunk.len()) {
                    if self.objects[*k].sample(piece.kind, &mut bytes).is_none() {
                        // Only the last chunk of a file may be shorter.
                        return if whole { None } else { Some(()) };
                    }
                }
            }
        }
        Some(())
    }
}

impl Object {
    fn sample(&mut self, kind: Type, bytes: &mut Bytes<'_>) -> Option<()> {
        match kind {
            Type::Number(kind) => self.numbers.push(kind.read(bytes)?),
            Type::Time => {
                let (fraction, seconds) = if bytes.big {
                    let seconds = bytes.i64()?;
                    (bytes.u64()?, seconds)
                } else {
                    (bytes.u64()?, bytes.i64()?)
                };
                // The fraction counts parts of 2^64.
                let nanoseconds = (i128::from(fraction) * 1_000_000_000) >> 64;
                self.words.push(stamp_text((i128::from(seconds) - EPOCH) * 1_000_000_000 + nanoseconds));
            }
            Type::Other(size) if size > 0 => {
                bytes.take(size)?;
            }
            Type::Text | Type::Other(_) => {}
        }
        Some(())
    }

    /// Texts: where each one ends, then all of them.
    fn texts(&mut self, mut bytes: Bytes<'_>, count: usize) -> Option<()> {
        let ends = bytes.take(count.checked_mul(4)?)?;
        let mut ends = Bytes::new(ends, bytes.big);
        let mut start = 0;
        while let Some(end) = ends.u32() {
            let end = end as usize;
            self.words.push(String::from_utf8_lossy(bytes.rest().get(start..end)?).into_owned());
            start = end;
        }
        Some(())
    }

    fn property(&mut self, bytes: &mut Bytes<'_>) -> Option<()> {
        let name = text(bytes)?;
        let code = bytes.u32()?;
        match Type::of(code)? {
            Type::Text => {
                let value = text(bytes)?;
                if name == "unit_string" || name == "NI_UnitDescription" {
                    self.unit = Some(value);
                }
            }
            Type::Number(kind) => {
                let value = kind.read(bytes)?;
                match name.as_str() {
                    "wf_increment" if value > 0.0 && value.is_finite() => self.increment = Some(value),
                    "wf_start_offset" if value.is_finite() => self.offset = value,
                    _ => {}
                }
            }
            other => {
                bytes.take(other.size())?;
            }
        }
        Some(())
    }

    /// The channel; none for a group, or a channel without two samples.
    fn channel(self) -> Option<Channel> {
        // `/'group'/'channel'`, with quotes doubled inside.
        let parts: Vec<&str> = self.path.strip_prefix("/'")?.strip_suffix('\'')?.split("'/'").collect();
        let [group, name] = parts.as_slice() else { return None };
        let values =
            if self.words.is_empty() { Values::Numbers(self.numbers) } else { Values::Words(self.words) };
        let plain = |text: &str| text.replace("''", "'");
        let clock = self.increment.map(|step| Clock::Even(self.offset, step));
        let channel = Channel { group: plain(group), name: plain(name), unit: self.unit, values, clock };
        (channel.values.len() > 1).then_some(channel)
    }
}

/// A text after its length.
fn text(bytes: &mut Bytes<'_>) -> Option<String> {
    let length = bytes.u32()? as usize;
    Some(String::from_utf8_lossy(bytes.take(length)?).into_owned())
}

/// A place so many bytes after a start.
fn place(start: usize, bytes: u64) -> Option<usize> {
    start.checked_add(usize::try_from(bytes).ok()?)
}
