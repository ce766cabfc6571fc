//! NumPy arrays: `.npy`, and each member of an `.npz`.

use crate::bytes::{Bytes, Kind};
use crate::channel::{Channel, MOST_CHANNELS, Values};
use crate::clock::stamp_text;
use crate::listing;
use crate::refusal::Refusal;

const FORMAT: &str = "NumPy";

/// The columns of a file with one array.
pub(super) fn channels(bytes: &[u8]) -> Result<Vec<Channel>, Refusal> {
    array(bytes, "")
}

/// The columns of an array: a vector is one column with the name of the array, a matrix or an array of
/// structures is a group of them.
pub(super) fn array(bytes: &[u8], name: &str) -> Result<Vec<Channel>, Refusal> {
    let broken = |at: &str| Refusal::broken(FORMAT, at);
    let mut rest = Bytes::new(bytes, false);
    let major = rest.take(8).map(|head| head[6]).ok_or_else(|| broken("its head is cut off"))?;
    let length = if major == 1 { rest.u16().map(usize::from) } else { rest.u32().map(|n| n as usize) };
    let head = length.and_then(|n| rest.take(n)).ok_or_else(|| broken("its head is cut off"))?;
    let head = String::from_utf8_lossy(head);
    let (Some(types), Some(shape)) = (value(&head, "descr"), value(&head, "shape")) else {
        return Err(broken("its head names no type and shape"));
    };
    let fortran = value(&head, "fortran_order").is_some_and(|v| v.starts_with("True"));
    let shape: Option<Vec<usize>> = inside(shape, '(', ')')
        .split(',')
        .map(str::trim)
        .filter(|n| !n.is_empty())
        .map(|n| n.trim_end_matches('L').parse().ok())
        .collect();
    let shape = shape.ok_or_else(|| broken("its shape is no list of numbers"))?;
    let cut = || broken(&format!("`{name}` ends before its last number"));
    if types.starts_with('[') {
        let [count] = *shape.as_slice() else {
            return Err(Refusal::file(
                format!("`{name}` is a matrix of structures"),
                "save its columns as arrays",
            ));
        };
        let fields =
            types.split("'fortran_order'").next().and_then(|t| t.split("'shape'").next()).unwrap_or(types);
        let Some(fields) = members(fields) else {
            let help =
                "save its columns as arrays: numpy.savez(path, **{n: data[n] for n in data.dtype.names})";
            return Err(Refusal::file(format!("`{name}` has members that are no numbers"), help));
        };
        return if count > 1 {
            structures(rest.rest(), &fields, count, name).ok_or_else(cut)
        } else {
            Ok(vec![])
        };
    }
    let types = inside(types, '\'', '\'');
    let Some(element) = Element::of(types) else {
        let help = "save numbers: numpy.save(path, numpy.asarray(data, float))";
        return Err(Refusal::file(
            format!("the array `{name}` is of the type `{types}`, which is no number"),
            help,
        ));
    };
    match *shape.as_slice() {
        [n] if n > 1 => {
            let plain = if name.is_empty() { "1" } else { name };
            Ok(vec![channel("", plain, element.column(rest.rest(), 0, element.size, n).ok_or_else(cut)?)])
        }
        [rows, columns] if rows.max(columns) > 1 => {
            matrix(rest.rest(), &element, (rows, columns, fortran), name)
        }
        [_, _, _, ..] if name.is_empty() => {
            let help = "save one record of it: numpy.save(path, data[0]), with time as a column";
            Err(Refusal::file(format!("its array has {} dimensions; a table has two", shape.len()), help))
        }
        // A number alone is a constant, not a column; more than two sides are no table.
        _ => Ok(vec![]),
    }
}

/// One column of numbers.
fn channel(group: &str, name: &str, values: Values) -> Channel {
    Channel { group: group.to_owned(), name: name.to_owned(), unit: None, values, clock: None }
}

/// The columns of a matrix: rows, columns, and whether columns stand one after the other.
fn matrix(
    bytes: &[u8],
    element: &Element,
    (rows, columns, fortran): (usize, usize, bool),
    name: &str,
) -> Result<Vec<Channel>, Refusal> {
    let cut = || Refusal::broken(FORMAT, format!("`{name}` ends before its last number"));
    let size = element.size;
    let whole = rows.checked_mul(columns).and_then(|n| n.checked_mul(size)).ok_or_else(cut)?;
    if bytes.len() < whole {
        return Err(cut());
    }
    // The longer side counts the samples.
    let (samples, count, by_rows) =
        if rows >= columns { (rows, columns, !fortran) } else { (columns, rows, fortran) };
    let (step, stride) = if by_rows { (size, count * size) } else { (samples * size, size) };
    if count > MOST_CHANNELS {
        return Err(Refusal::file(
            format!("`{}` has {rows} x {columns} numbers", listing::name(name)),
            "that is no table: save its columns",
        ));
    }
    let column = |k: usize| element.column(bytes, k * step, stride, samples);
    let all: Option<Vec<Values>> = (0..count).map(column).collect();
    let all = all.ok_or_else(cut)?.into_iter().enumerate();
    Ok(all.map(|(k, values)| channel(name, &(k + 1).to_string(), values)).collect())
}

/// Names and types of the members of a structure, such as `[('t', '<f8'), ('x', '<f4')]`; none if one of them
/// is no number.
fn members(text: &str) -> Option<Vec<(&str, Element)>> {
    fn member(text: &str) -> Option<(&str, Element)> {
        let mut words = text.split('\'').skip(1).step_by(2);
        Some((words.next()?, Element::of(words.next()?)?))
    }
    text.split('(').skip(1).map(member).collect()
}

/// The columns of an array of structures; none if the file is too short.
fn structures(bytes: &[u8], members: &[(&str, Element)], count: usize, name: &str) -> Option<Vec<Channel>> {
    let stride = members.iter().map(|(_, element)| element.size).sum();
    let mut start = 0;
    let column = |(label, element): &(&str, Element)| {
        let values = element.column(bytes, start, stride, count)?;
        start += element.size;
        Some(Channel { group: name.to_owned(), name: (*label).to_owned(), unit: None, values, clock: None })
    };
    members.iter().map(column).collect()
}

/// The type of the elements of an array.
#[derive(Clone, Copy)]
struct Element {
    kind: Option<Kind>,
    size: usize,
    big: bool,
    /// Of a date, nanoseconds of its unit.
    date: Option<i128>,
}

impl Element {
    /// `<f8`, `>i2`, `|b1`, `<M8[us]`; also texts, which become words.
    fn of(text: &str) -> Option<Element> {
        let big = text.starts_with('>');
        let text = text.trim_start_matches(['<', '>', '|', '=']);
        let plain = |kind: Kind| Some(Element { kind: Some(kind), size: kind.size(), big, date: None });
        match text {
            "f2" => plain(Kind::F16),
            "f4" => plain(Kind::F32),
            "f8" => plain(Kind::F64),
            "i1" => plain(Kind::I8),
            "i2" => plain(Kind::I16),
            "i4" => plain(Kind::I32),
            "i8" => plain(Kind::I64),
            "u1" | "b1" => plain(Kind::U8),
            "u2" => plain(Kind::U16),
            "u4" => plain(Kind::U32),
            "u8" => plain(Kind::U64),
            _ => {
                let unit = text.strip_prefix("M8[")?.strip_suffix(']')?;
                let nanoseconds = match unit {
                    "ns" => 1,
                    "us" => 1_000,
                    "ms" => 1_000_000,
                    "s" => 1_000_000_000,
                    _ => return None,
                };
                Some(Element { kind: None, size: 8, big, date: Some(nanoseconds) })
            }
        }
    }

    /// `count` elements, the first at `start`, one every `stride` bytes.
    fn column(self, bytes: &[u8], start: usize, stride: usize, count: usize) -> Option<Values> {
        let end = stride.checked_mul(count.checked_sub(1)?)?.checked_add(start)?.checked_add(self.size)?;
        if end > bytes.len() {
            return None;
        }
        let at = |k: usize| Bytes::new(&bytes[start + k * stride..], self.big);
        Some(match (self.kind, self.date) {
            (Some(kind), _) => {
                Values::Numbers((0..count).map(|k| kind.read(&mut at(k))).collect::<Option<_>>()?)
            }
            (None, unit) => {
                let text = |k: usize| {
                    Some(at(k).i64()?).map(|x| match x {
                        // "Not a time".
                        i64::MIN => String::new(),
                        x => stamp_text(i128::from(x) * unit.unwrap_or(1)),
                    })
                };
                Values::Words((0..count).map(text).collect::<Option<_>>()?)
            }
        })
    }
}

/// What follows `'key':` in the text of a dictionary.
fn value<'t>(head: &'t str, key: &str) -> Option<&'t str> {
    let at = head.find(&format!("'{key}'"))?;
    Some(head[at + key.len() + 2..].split_once(':')?.1.trim_start())
}

/// What stands between the first opening and its closing character.
fn inside(text: &str, open: char, close: char) -> &str {
    let text = text.split_once(open).map_or("", |(_, rest)| rest);
    text.split_once(close).map_or(text, |(inside, _)| inside)
}
