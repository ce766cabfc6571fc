//! HDF5, which is also the format of MATLAB 7.3 (`save -v7.3`), of PyTables and of netCDF 4.

use crate::bytes::{Bytes, Kind};
use crate::channel::{Channel, MOST_CHANNELS};
use crate::matrix;
use crate::refusal::{Refusal, guarded};
use hdf5_reader::group::Group;
use hdf5_reader::messages::datatype::CompoundField;
use hdf5_reader::{ByteOrder, Dataset, Datatype, Hdf5File, OpenOptions};
use std::collections::{HashMap, HashSet};

const FORMAT: &str = "HDF5";
/// Most bytes that a byte of a file unpacks to: the limit of deflate (zlib, technical details).
const MOST_PACKED: usize = 1032;
/// Most bytes of the data of a file.
const MOST_BYTES: usize = 2 << 30;
/// Groups within groups: more are no data of a record.
const DEEPEST: usize = 8;
/// Classes of MATLAB that are numbers.
const NUMBERS: &[&str] = &[
    "double", "single", "logical", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64",
];
/// Where MATLAB keeps what cells and arrays of structures refer to, and what it alone can read.
const REFERENCED: &str = "#refs#";
const SUBSYSTEM: &str = "#subsystem#";

/// The columns of a file: datasets with one side by their names, those with two sides and tables as groups of
/// columns; a group within another one is named after both, with a dot between them.
pub(super) fn channels(bytes: &[u8]) -> Result<Vec<Channel>, Refusal> {
    guarded(FORMAT, || read(bytes))
}

fn read(bytes: &[u8]) -> Result<Vec<Channel>, Refusal> {
    let most = bytes.len().saturating_mul(MOST_PACKED).min(MOST_BYTES);
    let plain = OpenOptions::default();
    let options =
        OpenOptions { max_read_bytes: most, max_chunk_bytes: plain.max_chunk_bytes.min(most), ..plain };
    let file = Hdf5File::from_vec_with_options(bytes.to_vec(), options).map_err(broken)?;
    let root = file.root_group().map_err(broken)?;
    let mut found = Found { channels: vec![], opaque: false, seen: HashSet::new(), left: most };
    let referenced = Referenced::of(&root)?;
    found.group(&root, "", &referenced, 0)?;
    if found.channels.is_empty() && found.opaque {
        return Err(crate::refusal::matlab_objects());
    }
    Ok(found.channels)
}

fn broken(error: impl std::fmt::Display) -> Refusal {
    Refusal::broken(FORMAT, error.to_string())
}

/// What references of a MATLAB file point to, by address.
#[derive(Default)]
struct Referenced(HashMap<u64, Dataset>);

impl Referenced {
    fn of(root: &Group) -> Result<Referenced, Refusal> {
        let (groups, _) = root.members().map_err(broken)?;
        let Some(group) = groups.iter().find(|g| g.name() == REFERENCED) else {
            return Ok(Referenced::default());
        };
        let (_, datasets) = group.members().map_err(broken)?;
        Ok(Referenced(datasets.into_iter().map(|d| (d.address(), d)).collect()))
    }
}

/// The columns found so far.
struct Found {
    channels: Vec<Channel>,
    /// Whether there was an object whose content is not documented.
    opaque: bool,
    /// Addresses of the groups that were read: links may go round in a circle.
    seen: HashSet<u64>,
    /// Bytes that may still be read.
    left: usize,
}

impl Found {
    fn group(
        &mut self,
        group: &Group,
        path: &str,
        referenced: &Referenced,
        depth: usize,
    ) -> Result<(), Refusal> {
        if depth > DEEPEST || !self.seen.insert(group.address()) {
            return Ok(());
        }
        let (mut groups, mut datasets) = group.members().map_err(broken)?;
        // Newer files keep their members in the order of a hash.
        groups.sort_by(|a, b| a.name().cmp(b.name()));
        datasets.sort_by(|a, b| a.name().cmp(b.name()));
        for dataset in &datasets {
            self.dataset(dataset, path, dataset.name(), referenced)?;
            if self.channels.len() > MOST_CHANNELS {
                return Ok(());
            }
        }
        for inner in groups.iter().filter(|g| !is_hidden(g)) {
            self.group(inner, &matrix::inner(path, inner.name()), referenced, depth + 1)?;
        }
        Ok(())
    }

    fn dataset(
        &mut self,
        dataset: &Dataset,
        path: &str,
        name: &str,
        referenced: &Referenced,
    ) -> Result<(), Refusal> {
        if dataset.attribute("MATLAB_object_decode").is_ok() {
            self.opaque = true;
            return Ok(());
        }
        let class = attribute(dataset, "MATLAB_class");
        if class.is_some_and(|c| !NUMBERS.contains(&c.as_str())) || dataset.attribute("MATLAB_empty").is_ok()
        {
            return Ok(());
        }
        // A side of one sample is none.
        let side = |n: &u64| usize::try_from(*n).map_err(broken);
        let sides: Vec<usize> =
            dataset.shape().iter().filter(|n| **n != 1).map(side).collect::<Result<_, _>>()?;
        match (dataset.dtype(), sides.as_slice()) {
            // The members of an array of structures.
            (Datatype::Reference { .. }, _) if !referenced.0.is_empty() => {
                self.members(dataset, path, name, referenced)
            }
            (Datatype::Compound { size, fields }, &[rows]) => {
                let raw = self.raw(dataset)?;
                let group = matrix::inner(path, name);
                let more = table(&raw, *size as usize, fields, rows, &group);
                self.channels.extend(more.ok_or_else(|| broken(format!("`{group}` ends early")))?);
                Ok(())
            }
            (dtype, &[_] | &[_, _]) => {
                let Some((kind, big)) = number(dtype) else { return Ok(()) };
                let sides = (sides[0], sides.get(1).copied().unwrap_or(1));
                let raw = self.raw(dataset)?;
                let all = kind.read_many(&mut Bytes::new(&raw, big), raw.len() / kind.size());
                let all = all.ok_or_else(|| broken(format!("`{name}` ends early")))?;
                let mut more = matrix::channels(path, name, sides, true, all);
                let unit = attribute(dataset, "units").or_else(|| attribute(dataset, "unit"));
                more.iter_mut().for_each(|c| c.unit.clone_from(&unit));
                self.channels.extend(more);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// What the member `name` of each structure of an array refers to.
    fn members(
        &mut self,
        dataset: &Dataset,
        path: &str,
        name: &str,
        referenced: &Referenced,
    ) -> Result<(), Refusal> {
        let raw = self.raw(dataset)?;
        let mut bytes = Bytes::new(&raw, false);
        let addresses: Vec<u64> = std::iter::from_fn(|| bytes.u64()).collect();
        for (k, address) in addresses.iter().enumerate() {
            let group = if addresses.len() == 1 { path.to_owned() } else { format!("{path}({})", k + 1) };
            if let Some(own) = referenced.0.get(address) {
                // References to references are cells.
                self.dataset(own, &group, name, &Referenced::default())?;
            }
            if self.channels.len() > MOST_CHANNELS {
                break;
            }
        }
        Ok(())
    }

    /// The bytes of a dataset, unpacked.
    fn raw(&mut self, dataset: &Dataset) -> Result<Vec<u8>, Refusal> {
        let named = |e: &dyn std::fmt::Display| broken(format!("the dataset `{}`: {e}", dataset.name()));
        let size = dataset.raw_byte_len().map_err(|e| named(&e))?;
        let too_large = || {
            Refusal::file(
                format!(
                    "with `{}` its data unpack to more than 2 GB, or than a file of this size can hold",
                    dataset.name()
                ),
                "write the time, the motion and the inputs to a file of their own; if it is small, copy or export it again",
            )
        };
        self.left = self.left.checked_sub(size).ok_or_else(too_large)?;
        dataset.read_raw_bytes().map_err(|e| match e.to_string() {
            words if words.to_lowercase().contains("unsupported") => Refusal::file(
                format!("the dataset `{}` is packed in a way that is not read ({words})", dataset.name()),
                "write it plainly: h5repack -f NONE FILE plain.h5",
            ),
            words => named(&words),
        })
    }
}

/// Groups that hold no data of the user: of MATLAB, of the indices of PyTables (natural naming), and sparse
/// matrices.
fn is_hidden(group: &Group) -> bool {
    let name = group.name();
    [REFERENCED, SUBSYSTEM].contains(&name)
        || name.starts_with("_i_")
        || name.starts_with("_p_")
        || group.attribute("MATLAB_sparse").is_ok()
}

/// The text of an attribute.
fn attribute(dataset: &Dataset, name: &str) -> Option<String> {
    let text = dataset.attribute(name).ok()?.read_string().ok()?;
    Some(text.trim_end_matches('\0').to_owned())
}

/// How the numbers of a type are stored, and whether the first byte is the highest; none of other types.
fn number(dtype: &Datatype) -> Option<(Kind, bool)> {
    let (kind, order) = match dtype {
        Datatype::FixedPoint { size, signed, byte_order } => {
            let kind = match (size, signed) {
                (1, true) => Kind::I8,
                (1, false) => Kind::U8,
                (2, true) => Kind::I16,
                (2, false) => Kind::U16,
                (4, true) => Kind::I32,
                (4, false) => Kind::U32,
                (8, true) => Kind::I64,
                (8, false) => Kind::U64,
                _ => return None,
            };
            (kind, byte_order)
        }
        Datatype::FloatingPoint { size, byte_order } => {
            let kind = match size {
                2 => Kind::F16,
                4 => Kind::F32,
                8 => Kind::F64,
                _ => return None,
            };
            (kind, byte_order)
        }
        // Truth values of PyTables, and of h5py.
        Datatype::Bitfield { size: 1, byte_order } => (Kind::U8, byte_order),
        Datatype::Enum { base, .. } => return number(base),
        _ => return None,
    };
    Some((kind, *order == ByteOrder::BigEndian))
}

/// The columns of a table of `rows` rows of `size` bytes; none if bytes are missing.
fn table(
    bytes: &[u8],
    size: usize,
    fields: &[CompoundField],
    rows: usize,
    group: &str,
) -> Option<Vec<Channel>> {
    let mut all = vec![];
    for field in fields {
        // A member may be a short array itself.
        let (dtype, width) = match &field.datatype {
            Datatype::Array { base, dims } => {
                (&**base, dims.iter().try_fold(1_u64, |n, d| n.checked_mul(*d))?)
            }
            dtype => (dtype, 1),
        };
        let Some((kind, big)) = number(dtype) else { continue };
        let (start, width) = (field.byte_offset as usize, usize::try_from(width).ok()?);
        if all.len() + width > MOST_CHANNELS {
            return Some(all);
        }
        for k in 0..width {
            let at = start.checked_add(k.checked_mul(kind.size())?)?;
            let cell = |row: usize| kind.read(&mut Bytes::new(bytes.get(row * size + at..)?, big));
            let name = if width == 1 { field.name.clone() } else { format!("{}.{}", field.name, k + 1) };
            all.push(matrix::channel(group, &name, (0..rows).map(cell).collect::<Option<_>>()?));
        }
    }
    Some(all)
}
