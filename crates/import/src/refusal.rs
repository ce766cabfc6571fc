//! What is asked of a file of data, and why it is not given.

use crate::listing;
use phisindy_phys::spec::CsvSpec;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What is asked of a file.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Wanted<'r> {
    /// The columns of a record.
    Record(&'r CsvSpec),
    /// All columns, of a sheet if one is named.
    All { sheet: Option<&'r str> },
}

impl Wanted<'_> {
    /// The sheet, variable or group that is asked for.
    pub(crate) fn sheet(&self) -> Option<&str> {
        match self {
            Wanted::Record(csv) => csv.sheet.as_ref().map(|s| s.value.as_str()),
            Wanted::All { sheet } => *sheet,
        }
    }
}

/// Why a file of a known format gives no table.
#[derive(Clone, Debug)]
pub(crate) struct Refusal {
    /// What is wrong, as `the file: what`.
    pub(crate) message: String,
    /// What to do.
    pub(crate) help: Vec<String>,
    /// Whether the name of the sheet is to blame.
    pub(crate) of_sheet: bool,
    /// The format, where its first bytes do not tell it: an archive may be a workbook.
    pub(crate) format: Option<&'static str>,
}

impl Refusal {
    /// Something is wrong with the file.
    pub(crate) fn file(message: impl Into<String>, help: &str) -> Refusal {
        Refusal { message: message.into(), help: vec![help.to_owned()], of_sheet: false, format: None }
    }

    /// The file is encrypted.
    pub(crate) fn protected() -> Refusal {
        Refusal::file("it is protected by a password", "save it without one")
    }

    /// The same, of a file of this format.
    pub(crate) fn of(self, format: &'static str) -> Refusal {
        Refusal { format: Some(format), ..self }
    }

    /// The file ends early, or its bytes break the rules of the format.
    pub(crate) fn broken(format: &str, at: impl Into<String>) -> Refusal {
        let help = "the file was cut off or damaged: copy it again, or export it again";
        Refusal::file(format!("it is no whole {format} file: {}", at.into()), help)
    }

    /// There is no such sheet.
    pub(crate) fn missing_sheet(wanted: &str, all: &[String]) -> Refusal {
        let mut help = vec![];
        help.extend(
            phisindy_expr::nearest(wanted, all.iter().map(String::as_str))
                .map(|n| format!("did you mean `{}`?", listing::name(n))),
        );
        help.push(match all {
            [] => "the file has no parts with names: leave `sheet` out".to_owned(),
            all => format!("there is: {}", listing::listing(all)),
        });
        Refusal {
            message: format!("it has no sheet, variable or group `{wanted}`"),
            help,
            of_sheet: true,
            format: None,
        }
    }

    /// Text has no sheets.
    pub(crate) fn no_sheets(name: &str, wanted: &str) -> Refusal {
        let message = format!("`{name}` is text, which has no sheet `{wanted}`");
        Refusal { message, help: vec!["leave `sheet` out".to_owned()], of_sheet: true, format: None }
    }
}

/// Runs a reader that is not ours and trusts what it reads here and there: where it panics, the file is
/// broken.
pub(crate) fn guarded<T>(format: &str, read: impl FnOnce() -> Result<T, Refusal>) -> Result<T, Refusal> {
    // Nothing outlives a reader that gave up.
    let done = catch_unwind(AssertUnwindSafe(read));
    done.unwrap_or_else(|_| Err(Refusal::broken(format, "its inside contradicts itself")))
}

/// A file of MATLAB holds nothing but objects.
pub(crate) fn matlab_objects() -> Refusal {
    Refusal::file(
        "its data are objects (`table`, `timeseries`, ...) that MATLAB alone can read",
        "in MATLAB: s = table2struct(T, 'ToScalar', true); save('run.mat', '-struct', 's')",
    )
}
