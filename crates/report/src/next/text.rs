//! The runs as lines of text.

use super::{HALF_WIDTH_95, NextReport, chance, rounded};
use crate::table::{aligned, short};
use phisindy_design::{Aim, Range, Run};

pub(super) fn lines(report: &NextReport) -> Vec<String> {
    let mut out = vec![format!("measure next: {}", report.sentence()), String::new()];
    if report.aim == Aim::Separate {
        let mut rows = vec![["model", "probability"].map(str::to_owned).to_vec()];
        rows.extend(report.rivals.iter().map(|r| vec![r.name.clone(), chance(r.probability)]));
        out.extend(aligned(&rows));
        if let Some(none) = report.none.filter(|none| *none > 0.005) {
            out.push(format!(
                "that none of these is right: {}; no run is looked for that would show this",
                chance(none)
            ));
        }
        out.push(String::new());
    }
    let asked: Vec<usize> = report.asked().collect();
    let mut head = vec!["run".to_owned()];
    match report.aim {
        Aim::Separate => head.extend(["decides", "left to wrong ones"].map(str::to_owned)),
        _ => head.extend(asked.iter().map(|&k| {
            let (shown, _) = report.shown(k);
            format!(
                "± {} {}",
                shown.name,
                if shown.unit.is_empty() { String::new() } else { format!("/ {}", shown.unit) }
            )
            .trim_end()
            .to_owned()
        })),
    }
    let row = |name: String, run: Option<&Run>| {
        let mut row = vec![name];
        match (&report.aim, run) {
            (Aim::Separate, Some(run)) => {
                let left = run.separation.wrong;
                let left = if left < 1e-9 { "below 1e-9".to_owned() } else { format!("{left:.1e}") };
                row.extend([chance(run.separation.decides), left]);
            }
            (Aim::Separate, None) => row.extend(["0", "0"].map(str::to_owned)),
            (_, run) => row.extend(asked.iter().map(|&k| {
                let (shown, now) = report.shown(k);
                let width = run.map_or(now, |run| HALF_WIDTH_95 * run.narrowed.std_errors[k]);
                short(rounded(width / shown.factor))
            })),
        }
        row
    };
    let mut rows = vec![head];
    rows.extend(report.design.runs.iter().map(|run| row(report.described(run), Some(run))));
    rows.extend(report.controls().map(|(name, run)| row(name.to_owned(), Some(run))));
    if report.aim != Aim::Separate {
        rows.push(row("now".to_owned(), None));
    }
    out.extend(aligned(&rows));
    out.push(String::new());
    out.push(within(report));
    let sure = |run: &&Run| run.steady < 0.995;
    if let Some(run) = report.design.runs.first().filter(sure) {
        out.push(format!(
            "within the errors of the numbers the contacts stop another number of times in {:.0} % of the motions: the promise is less sure",
            100.0 * (1.0 - run.steady)
        ));
    }
    out.extend(report.doubts.iter().cloned());
    if report.design.stopped {
        out.push("stopped before the end: the best so far".to_owned());
    }
    out
}

/// Within what the runs stay, and what of that the spec says.
fn within(report: &NextReport) -> String {
    let limits = &report.limits;
    let of = |range: &Range| {
        let [low, high] = [range.within.0, range.within.1].map(|x| short(rounded(x / range.factor)));
        format!("{} {low} to {high} {}", range.name, range.unit).trim_end().to_owned()
    };
    let all: Vec<&Range> = limits
        .inputs
        .iter()
        .chain(&limits.columns)
        .map(|(_, range)| range)
        .chain(&limits.constants)
        .collect();
    let words = |stated: bool| all.iter().filter(|r| r.stated == stated).map(|r| of(r)).collect::<Vec<_>>();
    let (mut stated, mut shown) = (words(true), words(false));
    let mut more = |text: String, said: bool| if said { stated.push(text) } else { shown.push(text) };
    more(format!("{} s", short(rounded(limits.duration.0))), limits.duration.1);
    more(format!("{} to {} Hz", short(rounded(limits.band.0)), short(rounded(limits.band.1))), limits.band.2);
    match (stated.is_empty(), shown.is_empty()) {
        (false, true) => format!("within the limits of the spec: {}", stated.join(", ")),
        (true, _) => format!(
            "within what the records have shown: {}; `limits: {{ ... }}` in the spec says what the rig can do",
            shown.join(", ")
        ),
        (false, false) => format!(
            "within the limits of the spec: {}; and within what the records have shown: {}",
            stated.join(", "),
            shown.join(", ")
        ),
    }
}
