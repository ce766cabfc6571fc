//! Tests whether the drive has another frequency than the spec says. A rig that is driven slightly faster or
//! slower than its model lacks no force, and no law describes the residual.

use crate::alternative_constant::numbers;
use crate::decisions::{CLOCK_CAUSE, CLOCK_HELPS, CLOCK_OFF, SAME_RATIO, SURE};
use crate::drive::Drive;
use crate::model::{Fitted, Measure, TrialModel, shortened};
use crate::result::{Activity, DriveFrequency, RoundStart};
use crate::search::{Observe, Search, placed};
use crate::whiteness::{lines, mean_step};
use phisindy_learn::Effort;
use phisindy_phys::spec::Role;
use rayon::prelude::*;
use std::collections::HashMap;

/// Progress of the workflow at this stage.
const LATE: f64 = 0.97;

/// The drive at another frequency, if that explains the records or removes most of the gap, alone or with the
/// effects that are missing beside it.
pub(crate) fn drive_frequency(base: &Fitted, search: &mut Search<'_>) -> Option<DriveFrequency> {
    let fits = starts(&base.model).into_par_iter().filter_map(|start| {
        let (model, name) = with_free_clock(&base.model, start)?;
        Some((Fitted::new(model, search.noise, Effort::Plain).ok()?, name))
    });
    let all: Vec<(Fitted, String)> = fits.collect();
    let (alone, name) = all.into_iter().min_by(|(a, _), (b, _)| a.score.fit.total_cmp(&b.score.fit))?;
    let gap = |of: &Fitted| of.score.gap();
    let cause = alone.score.fit < CLOCK_CAUSE * base.score.fit && gap(&alone) < CLOCK_CAUSE * gap(base);
    let mut best = alone;
    let helps = !best.score.explains() && best.score.fit < CLOCK_HELPS * base.score.fit;
    if helps && shortened(&best.model.records).is_none() {
        let late = Late(search.observer);
        let mut beside = Search { observer: &late, ..*search };
        let searched = beside.run(best.settled());
        best = searched.ok().map(|s| s.last).filter(|f| f.score.explains()).unwrap_or(best);
    }
    // A rate of the clock is worth its price, or chance alone brings the last step down to the noise.
    let by = Measure::of([&base.score, &best.score], 1);
    let gain = by.criterion(&base.score) - by.criterion(&best.score) - (base.score.samples as f64).ln();
    let explains = best.score.explains() && gain > 2.0 * (SURE / (1.0 - SURE)).ln();
    if !explains && !cause {
        return None;
    }
    let (_, ratio) = best.estimates(|p| p.name == name).pop()?;
    Some(DriveFrequency {
        ratio,
        beside: placed(&best.model),
        gap: (gap(base), gap(&best)),
        numbers: numbers(&best),
        explains,
    })
}

/// Start values of the frequency ratio: 1, and the ratio of each column's strongest line to every nearby line
/// of the drive.
fn starts(model: &TrialModel) -> Vec<f64> {
    let mut all = vec![1.0];
    for record in model.records.iter().filter(|r| r.role == Role::Fit) {
        let driven = Drive::new(&model.system, record).map_or(vec![], |mut drive| drive.lines());
        for (time, column) in (0..record.columns.len()).filter_map(|k| record.own_column(k)) {
            let own = lines(&column, mean_step(&time), 1, 0);
            let pairs = own.iter().flat_map(|own| driven.iter().map(move |line| own / line));
            all.extend(pairs.filter(|ratio| (ratio - 1.0).abs() < CLOCK_OFF));
        }
    }
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| (*a - *b).abs() < SAME_RATIO);
    all
}

/// The model with a free clock rate in its known rates, and the name of that parameter. `None` where the
/// known rates do not depend on time.
fn with_free_clock(base: &TrialModel, start: f64) -> Option<(TrialModel, String)> {
    let mut model = base.without_effects();
    let system = &mut model.system;
    if !system.graph.uses(&system.known, &[system.time]) {
        return None;
    }
    // The space in the name avoids collisions with names of a spec.
    let name = "speed of the clock".to_owned();
    let k = system.add_parameter(&name, "1", start, (1.0 - CLOCK_OFF, 1.0 + CLOCK_OFF), false);
    let own_time = system.graph.mul(system.parameters[k].node, system.time);
    let known = system.known.clone();
    system.known = system.graph.replace(&known, &HashMap::from([(system.time, own_time)]));
    Some((model, name))
}

/// The progress of a search near the end of the work.
struct Late<'a>(&'a dyn Observe);

impl Observe for Late<'_> {
    fn tell(&self, _: f64, what: Activity) -> bool {
        self.0.tell(LATE, what)
    }

    fn stopped(&self) -> bool {
        self.0.stopped()
    }

    fn round(&self) -> RoundStart {
        self.0.round()
    }
}
