//! Is the drive at the frequency that the spec says? A rig that is driven a little faster or slower than its model lacks no force, and no law describes what that leaves.

use crate::draft::Draft;
use crate::drive::Drive;
use crate::effect::substitute;
use crate::fitted::Fitted;
use crate::held::numbers;
use crate::search::{Search, label};
use crate::whiteness::{lines, mean_step};
use crate::workflow::shortened;
use phisindy_learn::Effort;
use phisindy_phys::spec::{self, Role};
use phisindy_phys::{SourceId, splice};
use rayon::prelude::*;

/// The time of the drive may run so much slower or faster than that of the record.
const OFF: f64 = 0.1;
/// A frequency that lowers the gap to this part may be what the search went astray on.
const HELPS: f64 = 0.9;
/// A gap that falls to this part of what it was has found its cause, whatever else is missing.
const CAUSE: f64 = 1.0 / 3.0;
/// Two starts as near as this are one.
const ONE: f64 = 1e-3;

/// How far the workflow is by now.
const LATE: f64 = 0.97;

/// A drive at another frequency than the spec says.
pub(crate) struct Off {
    /// In words.
    pub(crate) text: String,
    /// Whether that explains the data, or does so with what is missing beside it.
    pub(crate) explains: bool,
}

/// The drive of a model at another frequency, if the model as it was follows the records then as it does not follow them now, or does so with the effects that are missing beside it.
pub(crate) fn clock(base: &Fitted, search: &mut Search<'_>) -> Option<Off> {
    let fits = starts(&base.draft).into_par_iter().filter_map(|start| {
        let (draft, name) = freed(&base.draft, start)?;
        Some((Fitted::new(draft, search.noise, Effort::Plain).ok()?, name))
    });
    let all: Vec<(Fitted, String)> = fits.collect();
    let (alone, name) = all.into_iter().min_by(|(a, _), (b, _)| a.fit.total_cmp(&b.fit))?;
    let gap = |of: &Fitted| of.carried.unwrap_or(of.fit);
    let cause = alone.fit < CAUSE * base.fit && gap(&alone) < CAUSE * gap(base);
    let mut best = alone;
    if !best.explains() && best.fit < HELPS * base.fit && shortened(&best.draft.records).is_none() {
        let mut hear = |_: f64, what: &str| (search.hear)(LATE, what);
        let mut beside = Search { hear: &mut hear, ..*search };
        let searched = best.settled().and_then(|draft| beside.run(draft));
        best = searched.ok().map(|s| s.last).filter(Fitted::explains).unwrap_or(best);
    }
    let explains = best.explains();
    if !explains && !cause {
        return None;
    }
    let (_, speed) = best.found(|p| p.name == name).pop()?;
    let beside: String =
        label(&best.draft, 0).iter().map(|(law, at)| format!(", with {law} at {at}")).collect();
    let what = if explains {
        "look at that frequency, and at the clock of the records"
    } else {
        "something else is missing, too, which may show when that is mended: free it, `(value: .., within: (.., ..))`, and look again"
    };
    let text = format!(
        "the drive may be off its frequency: at {speed:.5} times what the spec says{beside} the gap of the model as it is goes from {:.3} to {:.3}{}: {what}",
        gap(base),
        gap(&best),
        numbers(&best)
    );
    Some(Off { text, explains })
}

/// Where to begin: with what the spec says, and with the strongest line of each column beside the line of the drive that is next to it.
fn starts(draft: &Draft) -> Vec<f64> {
    let mut all = vec![1.0];
    for record in draft.records.iter().filter(|r| r.role == Role::Fit) {
        let step = mean_step(&record.time);
        let driven = Drive::new(&draft.case.system, record).map_or(vec![], |mut drive| drive.lines());
        for column in record.columns.iter().flatten() {
            let own = lines(column, step, 1, 0);
            let pairs = own.iter().flat_map(|own| driven.iter().map(move |line| own / line));
            all.extend(pairs.filter(|ratio| (ratio - 1.0).abs() < OFF));
        }
    }
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| (*a - *b).abs() < ONE);
    all
}

/// The model whose known rates run in a time of their own, and the constant that says how fast it goes; `None` where they do not know the time.
fn freed(base: &Draft, start: f64) -> Option<(Draft, String)> {
    let (spec, _) = spec::read(&base.text, SourceId(0)).ok()?;
    let name = (0..).map(|k| format!("clock{k}")).find(|name| !base.text.contains(name))?;
    let own_time = [("t".to_owned(), format!("({name}*t)"))];
    let constant = format!("(value: {start:?}, unit: \"1\", within: ({:?}, {:?}))", 1.0 - OFF, 1.0 + OFF);
    let mut text = splice::set(&base.text, &format!("constants.{name}"), &constant).ok()?;
    let mut timed = false;
    for (state, rate) in &spec.known {
        let other = substitute(&rate.value, &own_time);
        timed |= other != rate.value;
        text = splice::set(&text, &format!("known.{}", state.value), &format!("{other:?}")).ok()?;
    }
    if !timed {
        return None;
    }
    Some((base.rebuilt(text, vec![], vec![]).ok()?, name))
}
