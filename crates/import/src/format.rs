//! The formats of data files, recognised by their first bytes. What none of them knows is text.
//!
//! ```text
//! bytes --recognized--> Format --Cells or Channels--> Sheet: rows, which go the way of lines of text
//!                          +-----Convert------------> Refusal with the command that converts the file
//! ```

mod archive;
#[cfg(feature = "hdf5")]
mod hdf5;
mod matlab;
mod numpy;
#[cfg(feature = "parquet")]
mod parquet;
mod tdms;
mod universal;
mod workbook;

use crate::channel::Channel;
use crate::channels::sheet;
use crate::data_file::DataFile;
use crate::refusal::{Refusal, Wanted};
use crate::rows::LineError;
use crate::sheet::Sheet;

/// What is done with a format.
#[derive(Clone, Copy)]
enum Read {
    /// Read as rows of cells.
    Cells(fn(&[u8], &Wanted<'_>) -> Result<Sheet, Refusal>),
    /// Read as channels.
    Channels(fn(&[u8]) -> Result<Vec<Channel>, Refusal>),
    /// Not read: the command that converts `FILE`.
    Convert(&'static str),
    /// Read by a program that is built with this feature; the command that converts `FILE` for others.
    #[cfg_attr(all(feature = "hdf5", feature = "parquet"), allow(dead_code))]
    Feature(&'static str, &'static str),
}

/// A format that is no text.
pub(crate) struct Format {
    /// What a message calls it.
    name: &'static str,
    /// Whether a file begins as its files do.
    begins: fn(&[u8]) -> bool,
    read: Read,
}

#[cfg(not(feature = "hdf5"))]
const HDF5: &str = "python3 -c \"import h5py, numpy; f = h5py.File('FILE'); numpy.savez('FILE.npz', **{k: numpy.squeeze(v[()]) for k, v in f.items() \
    if isinstance(v, h5py.Dataset)})\"";
#[cfg(not(feature = "parquet"))]
const PARQUET: &str =
    "python3 -c \"import pandas; pandas.read_parquet('FILE').to_csv('FILE.csv', index=False)\"";

// Their readers cost more build time than all other formats together, so they are features.
#[cfg(feature = "hdf5")]
const READ_HDF5: Read = Read::Channels(hdf5::channels);
#[cfg(not(feature = "hdf5"))]
const READ_HDF5: Read = Read::Feature("hdf5", HDF5);
#[cfg(feature = "parquet")]
const READ_PARQUET: Read = Read::Channels(parquet::channels);
#[cfg(not(feature = "parquet"))]
const READ_PARQUET: Read = Read::Feature("parquet", PARQUET);

/// All formats; the first that fits is taken.
const FORMATS: &[Format] = &[
    Format {
        name: "Excel (XLS)",
        begins: |b| b.starts_with(b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1"),
        read: Read::Cells(workbook::xls),
    },
    Format { name: "ZIP", begins: |b| b.starts_with(b"PK\x03\x04"), read: Read::Cells(archive::sheet) },
    Format { name: "MATLAB 7.3 (HDF5)", begins: |b| b.starts_with(b"MATLAB 7.3 MAT-file"), read: READ_HDF5 },
    Format {
        name: "HDF5",
        begins: |b| {
            [0, 512].iter().any(|&at| b.get(at..).is_some_and(|b| b.starts_with(b"\x89HDF\r\n\x1a\n")))
        },
        read: READ_HDF5,
    },
    Format {
        name: "MATLAB 5",
        begins: |b| {
            b.starts_with(b"MATLAB 5.0 MAT-file")
                || matches!(b.get(124..128), Some(b"\0\x01IM" | b"\x01\0MI"))
        },
        read: Read::Channels(matlab::channels),
    },
    Format { name: "NumPy", begins: |b| b.starts_with(b"\x93NUMPY"), read: Read::Channels(numpy::channels) },
    Format { name: "TDMS", begins: |b| b.starts_with(b"TDSm"), read: Read::Channels(tdms::channels) },
    Format {
        name: "universal file (UFF)",
        begins: universal::begins,
        read: Read::Channels(universal::channels),
    },
    Format { name: "Parquet", begins: |b| b.starts_with(b"PAR1"), read: READ_PARQUET },
    Format {
        name: "Arrow (Feather)",
        begins: |b| b.starts_with(b"ARROW1") || b.starts_with(b"FEA1"),
        read: Read::Convert(
            "python3 -c \"import pandas; pandas.read_feather('FILE').to_csv('FILE.csv', index=False)\"",
        ),
    },
    Format {
        name: "MATLAB 4",
        begins: |b| {
            matches!(b, [0..=52, 0 | 4, 0, 0, _, _, _, 0, _, _, _, 0, 0 | 1, 0, 0, 0, 1..=255, 0, 0, 0, ..])
        },
        read: Read::Convert(
            "python3 -c \"import scipy.io as s; s.savemat('FILE.5.mat', {k: v for k, v in s.loadmat('FILE').items() if k[0] != '_'})\"",
        ),
    },
    Format {
        name: "MDF",
        begins: |b| b.starts_with(b"MDF     ") || b.starts_with(b"UnFinMF "),
        read: Read::Convert("python3 -c \"import asammdf; asammdf.MDF('FILE').export('csv', 'FILE.csv')\""),
    },
    Format {
        name: "WAV",
        begins: |b| b.starts_with(b"RIFF") && b.get(8..12) == Some(b"WAVE"),
        read: Read::Convert(
            "python3 -c \"import numpy, scipy.io.wavfile as w; r, x = w.read('FILE'); numpy.savez('FILE.npz', time=numpy.arange(len(x))/r, x=x)\"",
        ),
    },
    Format {
        name: "SQLite",
        begins: |b| b.starts_with(b"SQLite format 3\0"),
        read: Read::Convert("sqlite3 -header -csv FILE 'select * from TABLE' > FILE.csv"),
    },
    Format {
        name: "pickle",
        begins: |b| matches!(b, [0x80, 2..=5, ..]) && !b.starts_with(b"\x80\x02PK"),
        read: Read::Convert(
            "python3 -c \"import pandas; pandas.read_pickle('FILE').to_csv('FILE.csv', index=False)\"",
        ),
    },
    Format { name: "gzip", begins: |b| b.starts_with(b"\x1F\x8B"), read: Read::Convert("gunzip -k FILE") },
    Format { name: "bzip2", begins: |b| b.starts_with(b"BZh"), read: Read::Convert("bunzip2 -k FILE") },
    Format { name: "xz", begins: |b| b.starts_with(b"\xFD7zXZ\0"), read: Read::Convert("unxz -k FILE") },
    Format {
        name: "zstd",
        begins: |b| b.starts_with(b"\x28\xB5\x2F\xFD"),
        read: Read::Convert("unzstd FILE"),
    },
    Format { name: "7z", begins: |b| b.starts_with(b"7z\xBC\xAF\x27\x1C"), read: Read::Convert("7z x FILE") },
    Format {
        name: "PDF",
        begins: |b| b.starts_with(b"%PDF-"),
        read: Read::Convert("pdftotext -layout FILE"),
    },
];

/// The format of a file that begins with these bytes; none of text.
pub(crate) fn recognized(start: &[u8]) -> Option<&'static Format> {
    FORMATS.iter().find(|format| (format.begins)(start))
}

impl Format {
    /// The table in a file.
    ///
    /// # Errors
    /// The file cannot be read, is not of this format, or not to be read; or a record asks for text.
    pub(crate) fn sheet(&self, mut file: DataFile<'_>, wanted: &Wanted<'_>) -> Result<Sheet, LineError> {
        let name = file.name;
        let refused = |refusal: Refusal| {
            LineError::Format(Refusal {
                message: format!(
                    "`{name}` is a file of {}: {}",
                    refusal.format.unwrap_or(self.name),
                    refusal.message
                ),
                ..refusal
            })
        };
        let convert = |command: &str| format!("convert it: {}", command.replace("FILE", name));
        match self.read {
            Read::Convert(command) => {
                return Err(refused(Refusal::file("that format is not read", &convert(command))));
            }
            Read::Feature(feature, command) => {
                let message = "that format is not read by this build of the program";
                let mut refusal = Refusal::file(message, &convert(command));
                refusal.help.push(format!(
                    "or build a program that reads it: cargo build --release --features {feature}"
                ));
                return Err(refused(refusal));
            }
            Read::Cells(_) | Read::Channels(_) => {}
        }
        if let Wanted::Record(csv) = wanted
            && !csv.any_format
        {
            return Err(refused(Refusal::file("no text", "write `Table(` in the place of `Csv(`")));
        }
        let Some(bytes) = file.whole().map_err(LineError::Io)? else {
            return Err(refused(Refusal::file(
                "it has more than 2 GB, and would be held in memory",
                "write the time, the motion and the inputs to a file of their own, or export text",
            )));
        };
        if bytes.len() as u64 != file.size {
            return Err(LineError::Changed);
        }
        match self.read {
            Read::Cells(read) => read(&bytes, wanted),
            Read::Channels(read) => read(&bytes).and_then(|channels| sheet(channels, wanted)),
            Read::Convert(_) | Read::Feature(..) => Err(Refusal::broken(self.name, "not read")),
        }
        .map_err(refused)
    }
}
