//! The result of `gap` as JSON: the keys are a contract with users.
//!
//! Keys are in alphabetical order, which is the order of the fields here. Numbers that are not finite become
//! null.

use super::discovered_force::nearest;
use super::report::GapReport;
use crate::format::capital;
use crate::format::role_name;
use crate::horizon::HorizonOut;
use phisindy_gap::{Alternative, ForcePoint, Gap, MissingForce, Push, Region, Step, Tried};
use serde::Serialize;
use std::collections::BTreeMap;

#[derive(Serialize)]
struct Outcome<'a> {
    doubts: &'a [String],
    #[serde(rename = "final")]
    last: FinalGap,
    /// The error of predictions against how far they look ahead.
    horizon: Vec<HorizonOut<'a>>,
    initial: InitialGap,
    left: Vec<RegionOut<'a>>,
    /// The missing force without a formula, SI.
    missing_force: Option<MissingForceOut<'a>>,
    /// Standard deviation of the noise of each column, SI.
    noise: BTreeMap<&'a str, f64>,
    /// The probability of a force without a form beside or in place of what was found.
    none: Option<f64>,
    not_tried: Vec<NotTriedOut<'a>>,
    parameters: Vec<ParameterOut<'a>>,
    partial: Vec<StepOut<'a>>,
    /// What became of a planned run.
    #[serde(skip_serializing_if = "Option::is_none")]
    planned: Option<&'a serde_json::Value>,
    /// A force that nobody measured, where the model leaves nothing between its pushes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pushes: Vec<PushOut<'a>>,
    records: Vec<RecordOut<'a>>,
    repeatability: Vec<RepeatOut<'a>>,
    seconds: f64,
    spec: &'a str,
    status: &'a str,
    steps: Vec<StepOut<'a>>,
    /// Whether it ended early: what it says then is what was found so far.
    stopped: bool,
    title: &'a str,
    tried: Vec<TriedOut<'a>>,
    version: &'a str,
    warnings: Vec<String>,
    #[serde(rename = "where")]
    located: Vec<RegionOut<'a>>,
    whiteness: Change,
}

/// A number before and after the effects were added.
#[derive(Serialize)]
struct Change {
    after: f64,
    before: f64,
}

#[derive(Serialize)]
struct InitialGap {
    fit: f64,
    validate: Option<f64>,
}

#[derive(Serialize)]
struct FinalGap {
    fit: f64,
    validate: Option<f64>,
    /// The gap on Validate records with the numbers of the model moved within their errors.
    within_errors: Option<f64>,
}

#[derive(Serialize)]
struct PushOut<'a> {
    at: &'a str,
    /// By how much it changes the speed, in `unit`.
    changes: f64,
    from: f64,
    record: &'a str,
    to: f64,
    unit: &'a str,
}

#[derive(Serialize)]
struct MissingForceOut<'a> {
    at: &'a str,
    depends_on: &'a str,
    left: f64,
    points: Vec<ForcePointOut>,
}

/// A point of its curve; the band is half the 95 % interval.
#[derive(Serialize)]
struct ForcePointOut {
    band: f64,
    displacement: Option<f64>,
    force: f64,
    velocity: Option<f64>,
}

#[derive(Serialize)]
struct RegionOut<'a> {
    column: &'a str,
    region: String,
    share: f64,
}

/// A law that was tried beside the model as it is.
#[derive(Serialize)]
struct TriedOut<'a> {
    at: &'a str,
    gap: Option<f64>,
    law: &'a str,
    probability: Option<f64>,
    score: f64,
    vetoed: Option<String>,
}

#[derive(Serialize)]
struct NotTriedOut<'a> {
    law: &'a str,
    why: String,
}

#[derive(Serialize)]
struct StepOut<'a> {
    at: &'a str,
    delta_bic: f64,
    /// Its terms about zero, to third order, where it is a smooth formula and no polynomial.
    expansion: Option<&'a str>,
    expression: &'a str,
    fit: Change,
    /// The force that is subtracted, with its numbers, in SI.
    force: Option<&'a str>,
    law: &'a str,
    mirror: bool,
    name: String,
    /// Of a discovered force: the laws of the catalogue that come nearest.
    nearest: Vec<NearestOut<'a>>,
    parameters: BTreeMap<&'a str, StepParameterOut<'a>>,
    probability: Option<f64>,
    /// Least and largest value (SI) of each quantity that a force without memory depends on: where it is
    /// known.
    region: BTreeMap<&'a str, [f64; 2]>,
    rivals: Vec<RivalOut>,
    scales_with: Option<&'a str>,
    validate: Option<Change>,
    vetoed: Vec<VetoOut<'a>>,
}

/// A law of the catalogue beside a discovered one.
#[derive(Serialize)]
struct NearestOut<'a> {
    at: &'a str,
    gap: Option<f64>,
    law: &'a str,
}

#[derive(Serialize)]
struct StepParameterOut<'a> {
    ci95: [f64; 2],
    constant: &'a str,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    each: BTreeMap<&'a str, ValueOut>,
    unit: &'a str,
    value: f64,
}

#[derive(Serialize)]
struct ValueOut {
    ci95: [f64; 2],
    value: f64,
}

#[derive(Serialize)]
struct RivalOut {
    at: String,
    delta_bic: f64,
    law: String,
    /// Whether no record tells it from the answer.
    same: bool,
}

#[derive(Serialize)]
struct VetoOut<'a> {
    law: &'a str,
    why: String,
}

#[derive(Serialize)]
struct RecordOut<'a> {
    column: &'a str,
    nrmse: Change,
    record: &'a str,
    role: &'a str,
}

#[derive(Serialize)]
struct RepeatOut<'a> {
    column: &'a str,
    nrmse: f64,
    period: f64,
    record: &'a str,
    rms: f64,
}

/// A number of the final model, in its unit.
#[derive(Serialize)]
struct ParameterOut<'a> {
    at_bound: bool,
    bounds: [f64; 2],
    ci95: [f64; 2],
    name: String,
    std_error: f64,
    unit: &'a str,
    value: f64,
}

/// The result on one line.
pub(crate) fn line(report: &GapReport<'_>) -> String {
    // This cannot fail: all keys are strings, and numbers that are not finite become null.
    serde_json::to_string(&outcome(report)).unwrap_or_default()
}

/// The same on lines of its own, indented.
pub(crate) fn lines(report: &GapReport<'_>) -> String {
    serde_json::to_string_pretty(&outcome(report)).unwrap_or_default()
}

fn outcome<'a>(report: &GapReport<'a>) -> Outcome<'a> {
    let GapReport { input, gap: found, ending, .. } = *report;
    Outcome {
        doubts: input.doubts,
        last: FinalGap { fit: found.after.0, validate: found.after.1, within_errors: found.predictive },
        horizon: found.horizon.iter().map(HorizonOut::new).collect(),
        initial: InitialGap { fit: found.before.0, validate: found.before.1 },
        left: found.left.iter().map(region).collect(),
        missing_force: found.force.as_ref().map(missing_force),
        noise: found.noise.iter().map(|(name, sigma)| (name.as_str(), *sigma)).collect(),
        none: found.none,
        not_tried: found
            .not_tried
            .iter()
            .map(|n| NotTriedOut { law: &n.law, why: n.why.to_string() })
            .collect(),
        parameters: parameters(found),
        partial: found.partial.iter().map(|s| step(found, s)).collect(),
        planned: report.planned.map(|planned| &planned.json),
        pushes: match &found.alternative {
            Some(Alternative::Pushes(pushes)) => pushes.iter().map(push).collect(),
            _ => vec![],
        },
        records: records(found),
        repeatability: repeatability(found),
        seconds: ending.seconds,
        spec: input.name,
        status: found.status.name(),
        steps: found.steps.iter().map(|s| step(found, s)).collect(),
        stopped: ending.stopped.is_some(),
        title: &input.case.system.title,
        tried: found.tried.iter().map(tried).collect(),
        version: env!("CARGO_PKG_VERSION"),
        warnings: found.warnings.iter().map(ToString::to_string).collect(),
        located: found.located.iter().map(region).collect(),
        whiteness: change(found.whiteness),
    }
}

fn push(of: &Push) -> PushOut<'_> {
    PushOut { at: &of.at, changes: of.changes, from: of.from, record: &of.record, to: of.to, unit: &of.unit }
}

fn missing_force(of: &MissingForce) -> MissingForceOut<'_> {
    let point = |p: &ForcePoint| ForcePointOut {
        band: p.band,
        displacement: p.displacement,
        force: p.force,
        velocity: p.velocity,
    };
    MissingForceOut {
        at: &of.at,
        depends_on: of.on.name(),
        left: of.left,
        points: of.points.iter().map(point).collect(),
    }
}

fn tried(t: &Tried) -> TriedOut<'_> {
    TriedOut {
        at: &t.at.at,
        gap: t.gap,
        law: &t.at.law,
        probability: t.probability,
        score: t.score,
        vetoed: t.vetoed.as_ref().map(ToString::to_string),
    }
}

fn change((before, after): (f64, f64)) -> Change {
    Change { after, before }
}

fn region(r: &Region) -> RegionOut<'_> {
    RegionOut { column: &r.column, region: r.to_string(), share: r.share }
}

fn step<'a>(found: &'a Gap, s: &'a Step) -> StepOut<'a> {
    let parameters = s.parameters.iter().map(|p| {
        let each =
            p.each.iter().map(|r| (r.record.as_str(), ValueOut { ci95: r.ci95.into(), value: r.value }));
        let out = StepParameterOut {
            ci95: p.ci95.into(),
            constant: &p.constant,
            each: each.collect(),
            unit: &p.unit,
            value: p.value,
        };
        (p.name.as_str(), out)
    });
    let rivals = s.rivals.iter();
    let rivals = rivals.map(|r| RivalOut { at: r.at(), delta_bic: r.delta_bic, law: r.law(), same: r.same });
    let nearest = nearest(found, s).map(|t| NearestOut { at: &t.at.at, gap: t.gap, law: &t.at.law });
    StepOut {
        at: &s.effect.place.at,
        delta_bic: s.delta_bic,
        expansion: s.expansion.as_deref(),
        expression: &s.expression,
        fit: change(s.fit),
        force: s.formula.as_deref(),
        law: &s.effect.entry.id,
        mirror: s.effect.mirror,
        name: capital(&s.effect.entry.law.name),
        nearest: nearest.collect(),
        parameters: parameters.collect(),
        probability: s.probability,
        region: s.observed.iter().map(|range| (range.quantity.as_str(), [range.low, range.high])).collect(),
        rivals: rivals.collect(),
        scales_with: s.effect.load.as_deref(),
        validate: s.validate.map(change),
        vetoed: s.vetoed.iter().map(|v| VetoOut { law: &v.law.law, why: v.why.to_string() }).collect(),
    }
}

fn records(found: &Gap) -> Vec<RecordOut<'_>> {
    let all = found.nrmse.iter();
    let one = all.map(|c| RecordOut {
        column: &c.column,
        nrmse: change((c.before, c.after)),
        record: &c.record,
        role: role_name(c.role),
    });
    one.collect()
}

fn repeatability(found: &Gap) -> Vec<RepeatOut<'_>> {
    let all = found.repeat.iter();
    let one = all.map(|c| RepeatOut {
        column: &c.column,
        nrmse: c.repeat.nrmse,
        period: c.repeat.period,
        record: &c.record,
        rms: c.repeat.rms,
    });
    one.collect()
}

fn parameters(found: &Gap) -> Vec<ParameterOut<'_>> {
    let one = found.parameters.iter().map(|p| {
        let own = |x: f64| x / p.factor;
        ParameterOut {
            at_bound: p.at_bound,
            bounds: [own(p.bounds.0), own(p.bounds.1)],
            ci95: [own(p.estimate.ci95.0), own(p.estimate.ci95.1)],
            name: p.id.to_string(),
            std_error: own(p.estimate.std_error),
            unit: &p.unit,
            value: own(p.estimate.value),
        }
    });
    one.collect()
}
