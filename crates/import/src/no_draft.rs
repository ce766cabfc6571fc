//! Why there is no draft for a table, and what to do.

use crate::headings::Quantity;
use crate::roles::NoMotion;
use crate::statistics::Statistics;
use crate::table::{Column, Table};
use crate::time_column::{NoTime, TimeColumn};
use phisindy_expr::Span;
use phisindy_phys::{Diagnostic, SourceId};

/// Why there is no draft for a table.
#[derive(Debug)]
pub enum NoDraft {
    /// No column can be the time.
    Time(NoTime),
    /// No column can be the motion.
    Motion(NoMotion),
    /// A column that a model may need holds text.
    Text(Box<Diagnostic>),
    /// Each row holds a value of another channel, whose name stands in a column.
    ChannelOfEachRow {
        /// The heading of that column.
        heading: String,
        /// The first names.
        names: Vec<String>,
    },
    /// No column is the place or the speed of one of these joints.
    Joints(Vec<String>),
    /// So many names are said for so many columns.
    Columns((usize, usize)),
}

impl NoDraft {
    /// As a diagnostic for the file `name`; the last argument is where the user named it.
    pub fn diagnostic(self, name: &str, (source, at): (SourceId, Span)) -> Box<Diagnostic> {
        let (message, help) = match self {
            NoDraft::Time(NoTime::Text { heading, mistake }) => {
                return Box::new(mistake.help(format!(
                    "`{heading}` should be time: write it as a number of seconds, or say how many rows there are in a second: `--rate HZ`"
                )));
            }
            NoDraft::Time(why @ NoTime::NotGrowing { falls: true, .. }) => {
                (why.to_string(), "turn the order of the rows round, so that the first sample stands first")
            }
            NoDraft::Time(why @ NoTime::NoRate { .. }) => {
                (why.to_string(), "say it: `--rate 1000Hz`, or write `# fs = 1000 Hz` above the heading")
            }
            NoDraft::Time(why) => (
                why.to_string(),
                "add a column `time_s`, in seconds from the start, that grows from row to row; if the rows are even, say how many there are in a \
                 second: `--rate HZ`",
            ),
            NoDraft::ChannelOfEachRow { heading, names } => (
                format!(
                    "`{heading}` says whose value a row holds ({}): each row is a sample of another channel",
                    names.iter().take(4).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
                ),
                "write a column for each channel, empty where it has no sample: in pandas \
                 `log.pivot_table(index=time, columns=name, values=value)`",
            ),
            NoDraft::Motion(why @ NoMotion::Lacks { .. }) => (
                why.to_string(),
                "say what the columns are, as in `--columns time_s,x_mm,F_N`, or another rig",
            ),
            NoDraft::Motion(why) => (
                why.to_string(),
                "a record needs a column of displacement or velocity; say which one in the heading, as in `x_mm` or `v [m/s]`",
            ),
            NoDraft::Text(mistake) => return mistake,
            NoDraft::Joints(names) => (
                format!(
                    "no column is the place or the speed of a joint: {}",
                    names.iter().take(8).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
                ),
                "call them `NAME_position`, `NAME_velocity`, `NAME_effort` by the names of the joints, or number them as in \
                 `q1`, `dq1`, `tau1`; or say so by `--columns t_s,q1_rad,tau1_Nm`, and `-` for one that is not used",
            ),
            NoDraft::Columns((names, columns)) => (
                format!("{names} names are said for {columns} columns"),
                "give `--columns` a name for each column in order, as in `time_s,x_mm,F_N`, and `-` for one \
                 that is not used",
            ),
        };
        Box::new(Diagnostic::error(format!("`{name}`: {message}")).at(source, at, "this file").help(help))
    }
}

/// The heading of a column whose words say whose value each row holds, and the words, if one column holds all values.
pub(crate) fn channel_of_each_row(table: &Table, time: &TimeColumn) -> Option<(String, Vec<String>)> {
    let holds = |k: usize, c: &Column| k != time.column && c.values.iter().any(|x| x.is_finite());
    let values = table.columns.iter().enumerate().filter(|(k, c)| holds(*k, c)).count();
    let names = |c: &Column| Some((c.heading.raw.clone(), c.words.taking_turns(table.rows())?.to_vec()));
    if values == 1 { table.columns.iter().find_map(names) } else { None }
}

/// The first text in a column that a model may need and that otherwise holds numbers: a run would stop there.
pub(crate) fn blocking(table: &Table, statistics: &[Statistics]) -> Option<Diagnostic> {
    let good = |c: usize| table.rows() - statistics[c].missing;
    let needed = |c: usize| {
        let quantity = table.columns[c].heading.quantity;
        !matches!(quantity, Quantity::Electric | Quantity::Acceleration | Quantity::Other)
    };
    let mixed = |c: usize| table.columns[c].text_cells > 0 && good(c) > 9 * table.columns[c].text_cells;
    let column = (0..table.columns.len()).find(|&c| needed(c) && mixed(c))?;
    let mistake = table.columns[column].first_text.clone()?;
    let more = table.columns[column].text_cells - 1;
    Some(if more > 0 {
        mistake.help(format!("{more} more cells of this column hold words"))
    } else {
        mistake
    })
}
