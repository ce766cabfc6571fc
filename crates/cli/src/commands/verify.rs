//! `phisindy verify`.

use crate::args::{Format, Options};
use crate::interrupt;
use crate::progress::watched;
use crate::terminal::{INPUT, REJECTED, complain, print};
use anyhow::Result;
use phisindy::files::{Difference, verify as made_again};
use serde_json::json;
use std::path::Path;

/// Most values that are listed.
const SHOWN: usize = 12;

/// Makes a result again and says what differs; returns the exit code.
pub(crate) fn verify(folder: &Path, options: &Options) -> Result<u8> {
    interrupt::keeps_nothing();
    let verified = watched(&folder.display().to_string(), options.quiet, |work| {
        made_again(folder, options.data.as_deref(), work)
    });
    let verified = match verified {
        Ok(verified) => verified,
        Err(why) => {
            complain(&why);
            return Ok(INPUT);
        }
    };
    if interrupt::requested() {
        interrupt::tell();
        return Ok(interrupt::code());
    }
    let all = &verified.differences;
    let text = if options.format == Format::Json {
        let entry = |d: &Difference| json!({ "code": d.code(), "of": d.subject(), "words": d.to_string() });
        let entries: Vec<_> = all.iter().map(entry).collect();
        json!({ "same": all.is_empty(), "same_values": verified.same_values, "differences": entries })
            .to_string()
            + "\n"
    } else {
        let (values, rest): (Vec<_>, Vec<_>) = all.iter().partition(|d| matches!(d, Difference::Value(..)));
        let shown = folder.display();
        let end = match (all.is_empty(), verified.same_values) {
            (true, _) => format!("{shown}: the same bits\n"),
            (false, true) => format!("{shown}: all values of the result come out again, to the bit\n"),
            (false, false) => format!("{shown}: the result does not come out again\n"),
        };
        let lines = rest.into_iter().chain(values.iter().take(SHOWN).copied()).map(|d| format!("{d}\n"));
        let more = values.len().saturating_sub(SHOWN);
        let more = if more > 0 { format!("and {more} more values\n") } else { String::new() };
        lines.collect::<String>() + &more + &end
    };
    print(&text)?;
    Ok(if all.is_empty() { 0 } else { REJECTED })
}
