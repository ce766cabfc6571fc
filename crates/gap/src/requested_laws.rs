//! Laws that a spec names in `unknown`: written into the spec as terms whose parameters start from fits to
//! the motion.

use crate::decisions::STARTS_WITH_MEMORY;
use crate::model::{
    Applied, Fitted, SpecTextError, TrialModel, current, noise_of, shortened, text_with, values,
};
use crate::place::{Effect, Site, fits, places};
use crate::result::ModelError;
use crate::screen::{Target, screen, sibling_starts};
use crate::search::neutral;
use phisindy_learn::Effort;
use phisindy_phys::spec::{Role, Spec, Text, UnknownSpec};
use phisindy_phys::{Case, Diagnostic, LawEntry, Record, SourceId, spec, splice};
use rayon::prelude::*;

/// The laws that a case requests, each at the velocity of its equation.
///
/// # Errors
/// Diagnostics with their location in the spec: a law is not in the catalogue, or cannot act there.
pub fn requested_laws(
    case: &Case,
    catalogue: &[LawEntry],
    source: SourceId,
) -> Result<Vec<Effect>, Vec<Diagnostic>> {
    let (mut effects, mut mistakes) = (Vec::new(), Vec::new());
    for (state, name) in &case.laws {
        match effect(case, *state, name, catalogue) {
            Ok(effect) => effects.push(effect),
            Err((what, help)) => mistakes.push(Diagnostic::error(what).at(source, name.span, "").help(help)),
        }
    }
    if mistakes.is_empty() { Ok(effects) } else { Err(mistakes) }
}

/// A law at a state's velocity; otherwise the error and its help text.
fn effect(
    case: &Case,
    state: usize,
    name: &Text,
    catalogue: &[LawEntry],
) -> Result<Effect, (String, String)> {
    let ids = || catalogue.iter().map(|e| e.id.as_str());
    let (law, own) = (&name.value, &case.system.states[state].name);
    let Some(entry) = catalogue.iter().find(|e| e.id == *law) else {
        let help = match phisindy_expr::nearest(law, ids()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("there is: {}", ids().collect::<Vec<_>>().join(", ")),
        };
        return Err((format!("there is no law `{law}` in the catalogue"), help));
    };
    if let Some(which) = &entry.law.sensor {
        return Err((
            format!("`{law}` is no force: it acts on a column, not on a rate"),
            format!("write it into the record: `sensors: {{ COLUMN: ({which}: Find(...)) }}`"),
        ));
    }
    if let Some(acts) = entry.law.acting() {
        return Err((
            format!("`{law}` is no force: it acts on an input, not on a rate"),
            format!("write what acts, `{acts}`, in the place of the input in `known`"),
        ));
    }
    if let Some(which) = &entry.law.input {
        return Err((
            format!("`{law}` is no force: it acts on an input, not on a rate"),
            format!("write it into the record: `sensors: {{ INPUT: ({which}: Find(...)) }}`"),
        ));
    }
    let at = |p: &crate::Place| p.at == *own && matches!(p.site, Site::Force { .. });
    let Some(place) = places(&mut case.system.clone(), &case.records).into_iter().find(at) else {
        return Err((
            format!("`{own}` is a displacement: a force acts on the rate of its velocity"),
            "put the law into the entry of the velocity".into(),
        ));
    };
    if !fits(&entry.law, &place) {
        return Err((
            format!("`{law}` needs the displacement of `{own}`, and no state is"),
            format!("a displacement is a state whose known rate is \"{own}\" and nothing else"),
        ));
    }
    let start = entry.law.parameters.iter().map(|(_, p)| default_start(p.within)).collect();
    Ok(Effect::new(entry.clone(), place, start))
}

/// Start of a parameter without any estimate: 0 where it may have either sign, otherwise 1 (SI), clamped to
/// the bounds.
fn default_start((low, high): (f64, f64)) -> f64 {
    if low < 0.0 { 0.0_f64.min(high) } else { 1.0_f64.clamp(low, high) }
}

/// A spec with its requested laws written out.
#[derive(Clone, Debug)]
pub struct WrittenOut {
    /// Its text.
    pub text: String,
    /// Its records, with a column for each internal state of a law.
    pub records: Vec<Record>,
    /// The laws, in their order.
    pub laws: Vec<WrittenLaw>,
}

/// A law that was written out.
#[derive(Clone, Debug)]
pub struct WrittenLaw {
    /// The law.
    pub entry: LawEntry,
    /// For each of its parameters its name in the law's file and in the spec.
    pub names: Vec<(String, String)>,
}

/// Writes these laws into the known rates of a spec in place of their names, and returns the text and its
/// records. The parameters of each law start at the best of several fits. Without a Fit record, or where no
/// fit converges, they start within their bounds.
///
/// # Errors
/// The spec cannot hold a law.
pub fn written_out(
    text: &str,
    case: Case,
    records: Vec<Record>,
    effects: &[Effect],
    catalogue: &[LawEntry],
) -> Result<WrittenOut, ModelError> {
    let (spec, _) =
        spec::read_with_files(text, SourceId(0), &case.system.files).map_err(|_| ModelError::Spec)?;
    let whole = TrialModel::base(spec.clone(), case, records);
    let plain = whole.variant(without(spec.clone(), |u| u.laws.clear())).ok_or(ModelError::Spec)?;
    let effects =
        with_fitted_starts(&whole, spec.clone(), effects, catalogue).unwrap_or_else(|| effects.to_vec());
    let full = plain.with_all(&effects)?;
    let text = text_with(&text_without(text, &spec, "laws")?, &full, None)?;
    let written = |a: &Applied| {
        let names = a.effect.entry.law.parameters.iter().map(|(name, _)| name.clone());
        WrittenLaw { entry: a.effect.entry.clone(), names: names.zip(a.names.clone()).collect() }
    };
    let laws = full.effects.iter().map(written).collect();
    Ok(WrittenOut { text, records: full.records.to_vec(), laws })
}

/// The effects with fitted start values; `None` where no fit is possible.
fn with_fitted_starts(
    whole: &TrialModel,
    spec: Spec,
    effects: &[Effect],
    catalogue: &[LawEntry],
) -> Option<Vec<Effect>> {
    whole.records.iter().find(|r| r.role == Role::Fit)?;
    let bare = whole.variant(Spec { unknown: vec![], ..spec })?;
    let bare = match shortened(&bare.records) {
        Some(short) => bare.for_records(short),
        None => bare,
    };
    let noise = noise_of(&bare.records);
    let mut now = Fitted::new(bare, &noise, Effort::Plain).ok()?;
    for effect in effects {
        let simpler = catalogue.iter().filter(|e| effect.entry.law.simpler.contains(&e.id));
        let entries: Vec<LawEntry> = [&effect.entry].into_iter().chain(simpler).cloned().collect();
        now = best(&now, effect, &entries, &noise)?;
    }
    Some(current(&now))
}

/// The best fit of a model with one more effect, from the starts that the screening proposes.
fn best(now: &Fitted, wanted: &Effect, entries: &[LawEntry], noise: &[Vec<f64>]) -> Option<Fitted> {
    let model = now.settled();
    let here = |e: &Effect| e.place.is(&wanted.place) && !e.mirror && e.load.is_none();
    let proposed: Vec<Effect> = match screen(&model, &now.cal, entries, noise, Target::AlongData) {
        Some(screening) => {
            let all = screening.candidates.into_iter().flat_map(|c| [c.effect].into_iter().chain(c.others));
            all.filter(here).collect()
        }
        None => vec![],
    };
    let (own, simpler): (Vec<Effect>, Vec<Effect>) =
        proposed.into_iter().partition(|e| e.entry.id == wanted.entry.id);
    // Parameters of a narrow curve are hard to find by a regression, and easy from a fitted simpler law.
    let relatives = simpler.iter().filter_map(|e| {
        let fitted = Fitted::new(model.with(e).ok()?, noise, Effort::Plain).ok()?;
        let last = fitted.model.effects.last()?;
        let sibling = Effect {
            start: values(&fitted, &last.names, &last.effect.start),
            beside: fitted.estimates(|p| !p.each && !last.names.contains(&p.name)),
            ..last.effect.clone()
        };
        sibling_starts(&fitted.model, &fitted.cal, &sibling, &wanted.entry)
    });
    let mut starts: Vec<Effect> = relatives.flatten().collect();
    // The linear response does not describe stops, and friction that starts too strong never lets the body
    // move.
    starts.extend(own.iter().map(neutral));
    starts.extend(own);
    starts.push(wanted.clone());
    let mut costed: Vec<(f64, TrialModel)> = starts
        .into_par_iter()
        .filter_map(|e| {
            let d = model.with(&e).ok()?;
            let cost = d.segment_cost(noise, 1)?;
            Some((cost, d))
        })
        .collect();
    costed.sort_by(|a, b| a.0.total_cmp(&b.0));
    costed.truncate(STARTS_WITH_MEMORY);
    let fitted: Vec<Fitted> =
        costed.into_par_iter().filter_map(|(_, d)| Fitted::new(d, noise, Effort::Plain).ok()).collect();
    fitted.into_iter().min_by(|a, b| a.cal.chi2.total_cmp(&b.cal.chi2))
}

/// The spec without what `clear` takes out of its unknown parts, and without those that then hold nothing.
pub(crate) fn without(mut spec: Spec, clear: impl Fn(&mut UnknownSpec)) -> Spec {
    spec.unknown.iter_mut().for_each(|(_, u)| clear(u));
    spec.unknown.retain(|(_, u)| asks(u));
    spec
}

/// Whether an unknown part asks for anything.
fn asks(u: &UnknownSpec) -> bool {
    !(u.candidates.is_empty() && u.laws.is_empty() && u.search.is_empty())
}

/// The text of a spec with this list taken out of its unknown parts, and without parts that hold nothing
/// else.
pub(crate) fn text_without(text: &str, spec: &Spec, list: &str) -> Result<String, ModelError> {
    let set = |text: &str, path: &str, value: &str| {
        let wrong = |why: splice::SetError| SpecTextError { path: path.to_owned(), why: why.to_string() };
        splice::set(text, path, value).map_err(wrong)
    };
    let has = |u: &UnknownSpec, this: bool| {
        let lists = [("candidates", u.candidates.len()), ("laws", u.laws.len()), ("search", u.search.len())];
        lists.iter().any(|(name, count)| (*name == list) == this && *count > 0)
    };
    let others = |u: &UnknownSpec| has(u, false);
    let mut out = text.to_owned();
    if spec.unknown.iter().any(|(_, u)| !others(u)) {
        let kept = spec.unknown.iter().filter(|(_, u)| others(u));
        let entries = kept.map(|(name, u)| format!("\"{}\": {}", name.value, &text[u.span.range()]));
        let entries = format!("{{ {} }}", entries.collect::<Vec<_>>().join(", "));
        out = set(&out, "unknown", &entries)?;
    }
    for (name, _) in spec.unknown.iter().filter(|(_, u)| others(u) && has(u, true)) {
        out = set(&out, &format!("unknown.{}.{list}", name.value), "[]")?;
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_phys::check;

    #[test]
    fn laws_leave_the_text_and_candidates_stay() {
        let text = |unknown: &str| {
            format!(
                "(states: {{ \"x\": \"\", \"v\": \"\" }}, known: {{ \"x\": \"v\", \"v\": \"-x\" }}, unknown: {{ {unknown} }}, data: [Synthetic(truth: {{}}, \
                 start: {{ \"x\": 1.0, \"v\": 0.0 }}, duration: 1.0, step: 0.1, noise: None)])"
            )
        };
        let left = |unknown: &str| {
            let (read, _) = spec::read(&text(unknown), SourceId(0)).unwrap();
            text_without(&text(unknown), &read, "laws").unwrap()
        };
        assert_eq!(left("\"v\": (laws: [\"coulomb\"])"), text(""));
        assert_eq!(
            left("\"v\": (candidates: [\"x\"], laws: [\"coulomb\"])"),
            text("\"v\": (candidates: [\"x\"], laws: [])")
        );
        assert_eq!(
            left("\"x\": (candidates: [\"x\"]), \"v\": (laws: [\"coulomb\"])"),
            text("\"x\": (candidates: [\"x\"])")
        );
    }

    /// Messages and help for laws that are requested where they cannot act.
    #[test]
    fn a_law_that_cannot_act_there_is_told() {
        let laws = [
            ("coulomb", include_str!("../../phys/laws/coulomb.ron")),
            ("stiffness", include_str!("../../phys/laws/stiffness.ron")),
            ("sensor-delay", include_str!("../../phys/laws/sensor-delay.ron")),
        ];
        let catalogue = laws.map(|(id, text)| LawEntry::read(id, text).unwrap());
        let said = |states: &str, known: &str, unknown: &str| {
            let text = format!(
                r#"(states: {{{states}}}, known: {{{known}}}, unknown: {{{unknown}}},
                    data: [Synthetic(truth: {{}}, start: {{}}, duration: 10.0, step: 0.01, noise: Additive(0.01))])"#
            );
            let (spec, _) = spec::read(&text, SourceId(0)).unwrap();
            let (case, _) = check(&spec, SourceId(0)).unwrap();
            let mistakes = requested_laws(&case, &catalogue, SourceId(0)).err().unwrap_or_default();
            mistakes.iter().map(|d| format!("{}: {}", d.message, d.help.join(" "))).collect::<Vec<_>>()
        };
        let mass = |unknown: &str| said(r#""x": "m", "y": "m/s""#, r#""x": "y", "y": "-x""#, unknown);
        assert_eq!(mass(r#""y": (laws: ["coulomb", "stiffness"])"#), [""; 0]);
        assert_eq!(
            mass(r#""y": (laws: ["coulom", "sensor-delay", "qqqqqqqqqqqqqqqq"]), "x": (laws: ["coulomb"])"#),
            [
                "there is no law `coulom` in the catalogue: did you mean `coulomb`?",
                "`sensor-delay` is no force: it acts on a column, not on a rate: write it into the record: `sensors: { COLUMN: (delay: Find(...)) }`",
                "there is no law `qqqqqqqqqqqqqqqq` in the catalogue: there is: coulomb, stiffness, sensor-delay",
                "`x` is a displacement: a force acts on the rate of its velocity: put the law into the entry of the velocity",
            ]
        );
        assert_eq!(
            said(r#""y": "m/s""#, r#""y": "-y""#, r#""y": (laws: ["stiffness"])"#),
            [
                "`stiffness` needs the displacement of `y`, and no state is: a displacement is a state whose known rate is \"y\" and nothing else"
            ]
        );
    }
}
