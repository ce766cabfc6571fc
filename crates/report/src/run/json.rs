//! The result of `run` as JSON: the keys are a contract with users. Numbers that are not
//! finite become null.

use super::adapted::{AdaptedOut, Part};
use super::contribution::{Contribution, contribution};
use super::fixed::FixedValue;
use super::report::RunReport;
use crate::equation::ImpactLine;
use crate::format::role_name as role;
use crate::horizon::HorizonOut;
use phisindy_learn::{Estimate, Remainder};
use phisindy_phys::System;
use serde::Serialize;
use serde_json::{Map, Value, json};

#[derive(Serialize)]
struct Outcome<'a> {
    spec: &'a str,
    title: &'a str,
    method: &'a str,
    verdict: &'a str,
    reason: Option<String>,
    /// The forces that are left.
    remainder: Vec<RemainderOut<'a>>,
    /// The error of predictions against how far they look ahead.
    horizon: Vec<HorizonOut<'a>>,
    /// The free runs that the verdict rests on.
    basis: String,
    equations: Vec<EquationOut<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    impacts: Vec<ImpactOut<'a>>,
    parameters: Vec<ParameterOut<'a>>,
    #[serde(rename = "held")]
    fixed: &'a [FixedValue],
    records: Vec<RecordOut<'a>>,
    noise_model: String,
    selection: Vec<PointOut>,
    warnings: Vec<&'a String>,
    doubts: &'a [String],
    #[serde(skip_serializing_if = "Option::is_none")]
    planned: Option<&'a serde_json::Value>,
    stopped: bool,
    seconds: f64,
    version: &'a str,
}

#[derive(Serialize)]
struct RemainderOut<'a> {
    at: &'a str,
    record: &'a str,
    rms: f64,
    unit: String,
    share: f64,
    /// Of this share what follows the motion.
    of_motion: f64,
    /// Seconds between which it is strongest.
    #[serde(rename = "where")]
    strongest: [f64; 2],
}

impl<'a> RemainderOut<'a> {
    fn new(system: &'a System) -> impl Fn((&'a Remainder, f64, String)) -> RemainderOut<'a> {
        |(left, rms, unit)| RemainderOut {
            at: &system.states[left.state].name,
            record: &left.record,
            rms,
            unit,
            share: left.share,
            of_motion: left.of_motion,
            strongest: left.strongest.into(),
        }
    }
}

#[derive(Serialize)]
struct EquationOut<'a> {
    state: &'a str,
    latex: &'a str,
    text: &'a str,
    terms: Vec<TermOut<'a>>,
}

/// What happens where a gap closes.
#[derive(Serialize)]
pub(crate) struct ImpactOut<'a> {
    name: &'a str,
    when: &'a str,
    restitution: Option<f64>,
    latex: &'a str,
    text: &'a str,
}

impl<'a> ImpactOut<'a> {
    pub(crate) fn new(line: &'a ImpactLine) -> ImpactOut<'a> {
        let ImpactLine { name, when, restitution, latex, text } = line;
        ImpactOut { name, when, restitution: *restitution, latex, text }
    }
}

#[derive(Serialize)]
struct TermOut<'a> {
    candidate: &'a str,
    coefficient: f64,
    /// SI; `1` for a plain number, empty if the spec does not determine it.
    unit: String,
    std_error: f64,
    ci95: [f64; 2],
    /// Bounds of the spec; null for none.
    bounds: [f64; 2],
    at_bound: bool,
    /// The coefficient times the inertia of the state.
    force: Option<ForceOut>,
    /// Its contribution to the motion.
    contribution: Option<Contribution>,
}

#[derive(Serialize)]
struct ForceOut {
    value: f64,
    unit: String,
}

#[derive(Serialize)]
struct ParameterOut<'a> {
    name: String,
    value: f64,
    unit: &'a str,
    std_error: f64,
    ci95: [f64; 2],
    bounds: [f64; 2],
    at_bound: bool,
}

#[derive(Serialize)]
struct RecordOut<'a> {
    name: &'a str,
    role: &'a str,
    samples: usize,
    /// What a Validate record was given of its own, beside `start`, and the part of it that this took.
    adapted: Option<AdaptedOut<'a>>,
    /// The part that `nrmse` is of; null without a run.
    scored: Option<Part>,
    nrmse: Map<String, Value>,
    noise: Map<String, Value>,
    start: Map<String, Value>,
    failure: Option<String>,
}

#[derive(Serialize)]
struct PointOut {
    terms: usize,
    criterion: f64,
    nrmse: Option<f64>,
}

/// The result on one line.
pub(crate) fn line(report: &RunReport<'_>) -> String {
    let (system, found) = (&report.input.case.system, report.identified);
    let equations = report.equations.iter().map(|equation| {
        let here = found.terms.iter().filter(|f| system.terms[f.term].state == equation.state);
        let terms = here.map(|f| {
            let Estimate { value, std_error, ci95 } = f.coefficient;
            TermOut {
                candidate: &system.terms[f.term].candidate,
                coefficient: value,
                unit: system.terms[f.term].unit.map_or(String::new(), |unit| unit.to_string()),
                std_error,
                ci95: [ci95.0, ci95.1],
                bounds: system.terms[f.term].within.into(),
                at_bound: f.at_bound,
                force: report.force(f).map(|(value, unit)| ForceOut { value, unit: unit.to_string() }),
                contribution: contribution(system, f),
            }
        });
        let state = &system.states[equation.state].name;
        EquationOut { state, latex: &equation.latex, text: &equation.text, terms: terms.collect() }
    });
    let parameters = found.parameters.iter().map(|p| ParameterOut {
        name: p.id.to_string(),
        value: p.estimate.value / p.factor,
        unit: &p.unit,
        std_error: p.estimate.std_error / p.factor,
        ci95: [p.estimate.ci95.0 / p.factor, p.estimate.ci95.1 / p.factor],
        bounds: [p.bounds.0 / p.factor, p.bounds.1 / p.factor],
        at_bound: p.at_bound,
    });
    let numbers = |list: &[(String, f64)]| list.iter().map(|(name, x)| (name.clone(), json!(x))).collect();
    let records = found.records.iter().zip(report.input.records).map(|(r, record)| RecordOut {
        name: &r.name,
        role: role(r.role),
        samples: r.samples,
        adapted: r.adapted.as_ref().map(AdaptedOut::new),
        scored: r.run.as_ref().map(|_| Part::scored(r, record)),
        nrmse: numbers(&r.nrmse),
        noise: numbers(&r.noise),
        start: system.states.iter().zip(&r.start).map(|(s, x)| (s.name.clone(), json!(x))).collect(),
        failure: r.failure.as_ref().map(ToString::to_string),
    });
    let selection =
        found.selection.iter().map(|p| PointOut { terms: p.terms, criterion: p.criterion, nrmse: p.nrmse });
    let outcome = Outcome {
        spec: report.input.name,
        title: &system.title,
        method: found.method.name(),
        verdict: found.verdict.word(),
        reason: found.verdict.reason(),
        remainder: report.remainder().into_iter().map(RemainderOut::new(system)).collect(),
        horizon: found.horizon.iter().map(HorizonOut::new).collect(),
        basis: report.basis(),
        equations: equations.collect(),
        impacts: report.impacts.iter().map(ImpactOut::new).collect(),
        parameters: parameters.collect(),
        fixed: &report.fixed,
        records: records.collect(),
        noise_model: found.noise_model.to_string(),
        selection: selection.collect(),
        warnings: report.notes.iter().chain(&report.warnings).collect(),
        doubts: report.input.doubts,
        planned: report.planned.as_ref().map(|planned| &planned.json),
        stopped: found.interrupted(),
        seconds: report.ending.seconds,
        version: env!("CARGO_PKG_VERSION"),
    };
    // This cannot fail: all keys are strings, and numbers that are not finite become null.
    serde_json::to_string(&outcome).unwrap_or_default()
}
