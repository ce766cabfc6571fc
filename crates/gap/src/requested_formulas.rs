//! Formulas that a spec asks for in `unknown`: found by the search of formulas, and written into the spec as
//! laws are.

use crate::formula::{Scope, response_noise};
use crate::model::{Fitted, TrialModel, current, noise_of, shortened, text_with};
use crate::place::{Effect, Place, Quantity, Site, places};
use crate::requested_laws::{text_without, without};
use crate::result::{Activity, ModelError};
use crate::search::{Observer, Search};
use phisindy_learn::Effort;
use phisindy_phys::spec::{Role, Text};
use phisindy_phys::{Case, Diagnostic, Record, SourceId, spec};
use std::ops::ControlFlow;

/// A formula that a case asks for: where, and in which quantities.
#[derive(Clone, Debug)]
pub struct RequestedFormula {
    scope: Scope,
    /// The quantities, as the case has them.
    names: Vec<String>,
}

impl RequestedFormula {
    /// `x and v at v`.
    fn words(&self) -> String {
        format!("{} at {}", self.names.join(" and "), self.scope.place.at)
    }
}

/// The formulas that a case asks for.
///
/// # Errors
/// Diagnostics with their location in the spec: no force on the state depends on a quantity.
pub fn requested_formulas(case: &Case, source: SourceId) -> Result<Vec<RequestedFormula>, Vec<Diagnostic>> {
    let all = places(&mut case.system.clone(), &case.records);
    let (mut found, mut mistakes) = (Vec::new(), Vec::new());
    for (state, wanted) in &case.searches {
        let here: Vec<&Place> = all.iter().filter(|p| acts_on(p, *state)).collect();
        match here.iter().find_map(|place| scope(place, wanted)) {
            Some(scope) => {
                let names = wanted.iter().map(|w| w.value.clone()).collect();
                found.push(RequestedFormula { scope, names });
            }
            None => mistakes.push(refusal(case, *state, wanted, &here, source)),
        }
    }
    if mistakes.is_empty() { Ok(found) } else { Err(mistakes) }
}

/// Whether a force at a place enters the rate of a state.
fn acts_on(place: &Place, state: usize) -> bool {
    matches!(&place.site, Site::Force { acts, .. } if acts.iter().any(|a| a.0 == state))
}

/// The text of a quantity without spaces and outer brackets.
fn bare(text: &str) -> String {
    let text: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    let inside = text.strip_prefix('(').and_then(|t| t.strip_suffix(')'));
    inside.map_or(text.clone(), str::to_owned)
}

/// The scope of a search at a place in these quantities, if they are its displacement or velocity.
fn scope(place: &Place, wanted: &[Text]) -> Option<Scope> {
    let Site::Force { displacement, velocity, .. } = &place.site else { return None };
    let is = |wanted: &Text, of: &Quantity| bare(&wanted.value) == bare(&of.text);
    let of_x = |w: &Text| displacement.as_ref().is_some_and(|x| is(w, x));
    let of_v = |w: &Text| is(w, velocity);
    wanted.iter().all(|w| of_x(w) || of_v(w)).then(|| Scope {
        place: place.clone(),
        displacement: wanted.iter().any(of_x),
        velocity: wanted.iter().any(of_v),
        linear: false,
    })
}

fn refusal(case: &Case, state: usize, wanted: &[Text], here: &[&Place], source: SourceId) -> Diagnostic {
    let own = &case.system.states[state].name;
    let span = wanted.first().map_or_else(Default::default, |w| w.span);
    if here.is_empty() {
        return Diagnostic::error(format!(
            "`{own}` is no velocity: a formula is looked for as a force on a body"
        ))
        .at(source, span, "")
        .help("list `candidates`, or put the search into the entry of a velocity");
    }
    let of = |place: &&Place| match &place.site {
        Site::Force { displacement, velocity, .. } => {
            let names = displacement.iter().chain([velocity]).map(|q| format!("\"{}\"", bare(&q.text)));
            Some(format!("[{}]", names.collect::<Vec<_>>().join(", ")))
        }
        _ => None,
    };
    let all: Vec<String> = here.iter().filter_map(of).collect();
    let names: Vec<&str> = wanted.iter().map(|w| w.value.as_str()).collect();
    Diagnostic::error(format!("no force on `{own}` depends on {} alone", names.join(" and ")))
        .at(source, span, "")
        .help(format!("a formula may be searched in all or some of: {}", all.join(" or of ")))
}

/// A spec with the formulas that it asks for.
#[derive(Clone, Debug)]
pub struct WithFormulas {
    /// Its text.
    pub text: String,
    /// Its records.
    pub records: Vec<Record>,
    /// What no formula was found in: quantities and place, as `x and v at v`.
    pub without: Vec<String>,
}

/// Finds the formulas and writes them into the known rates of a spec, in place of the request. `observe`
/// receives the progress as a fraction and an activity, and may stop the search.
///
/// # Errors
/// The model without the formulas cannot be fitted, or the spec cannot hold one.
pub fn with_formulas(
    text: &str,
    case: Case,
    records: Vec<Record>,
    requested: &[RequestedFormula],
    observe: &mut (dyn FnMut(f64, Activity) -> ControlFlow<()> + Send),
) -> Result<WithFormulas, ModelError> {
    let (spec, _) =
        spec::read_with_files(text, SourceId(0), &case.system.files).map_err(|_| ModelError::Spec)?;
    let whole = TrialModel::base(spec.clone(), case, records);
    let kept = without(spec.clone(), |u| u.search.clear());
    let plain = whole.variant(kept).ok_or(ModelError::Spec)?;
    let mut effects = Vec::new();
    let mut missing: Vec<String> = requested.iter().map(RequestedFormula::words).collect();
    if whole.records.iter().any(|r| r.role == Role::Fit) {
        let model = whole.variant(spec::Spec { unknown: vec![], ..spec.clone() }).ok_or(ModelError::Spec)?;
        let model = match shortened(&model.records) {
            Some(short) => model.for_records(short),
            None => model,
        };
        // Of clean data a formula that is right to the error of the response is asked for. What it leaves is
        // not white.
        let measured = noise_of(&model.records);
        let noise = response_noise(&model, &measured);
        let floor = if noise == measured { 0.0 } else { 1.0 };
        let mut tell = |part: f64, what: Activity| observe(part, what).is_break();
        effects = Observer::during(&mut tell, |observer| -> Result<Vec<Effect>, ModelError> {
            let model = model.stopped_by(observer.stop());
            let mut search = Search { catalogue: &[], noise: &noise, floor, observer };
            let mut now = Fitted::new(model, &noise, Effort::Plain)?;
            for one in requested {
                if let Some(found) = search.formula_at(&now, &one.scope) {
                    now = found;
                    missing.retain(|words| *words != one.words());
                }
            }
            Ok(current(&now))
        })?;
    }
    let full = plain.with_all(&effects)?;
    let text = text_with(&text_without(text, &spec, "search")?, &full, None)?;
    Ok(WithFormulas { text, records: full.records.to_vec(), without: missing })
}
