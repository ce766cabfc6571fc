//! `modelDescription.xml` and `buildDescription.xml`.

use super::variables::{Kind, Variable, Variables};
use crate::export::head::RULE;
use crate::export::subject::Subject;
use crate::markup::escaped;
use phisindy_phys::unit::Unit;
use std::fmt::Write;

/// Local error that an importer's steps should keep, relative to the nominal size of a state.
const TOLERANCE: f64 = 1e-9;

/// The same where friction has a shape near rest, which such steps must resolve.
const FINE_TOLERANCE: f64 = 1e-11;

/// Attributes of an element; the value is escaped where it is written.
type Attributes = Vec<(&'static str, String)>;

/// A line with an empty element.
fn line(out: &mut String, depth: usize, name: &str, attributes: &[(&'static str, String)]) {
    let list: String = attributes.iter().map(|(n, v)| format!(" {n}=\"{}\"", escaped(v))).collect();
    let _ = writeln!(out, "{:1$}<{name}{list}/>", "", 2 * depth);
}

/// The description of a model with its variables.
pub(super) fn description(subject: &Subject, variables: &Variables, identifier: &str, token: &str) -> String {
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    // Importers show the title on one line.
    let title = subject.title.replace(['\n', '\r'], " ");
    let _ = writeln!(
        out,
        "<fmiModelDescription fmiVersion=\"3.0\" modelName=\"{identifier}\" instantiationToken=\"{token}\" description=\"{}\" \
         generationTool=\"phisindy {}\" variableNamingConvention=\"flat\">",
        escaped(&title),
        env!("CARGO_PKG_VERSION")
    );
    let both = |more: &[&'static str]| -> Attributes {
        let names = more.iter().chain(&["canGetAndSetFMUState", "canSerializeFMUState"]);
        let flags = names.map(|&name| (name, "true".to_owned()));
        [("modelIdentifier", identifier.to_owned())].into_iter().chain(flags).collect()
    };
    line(&mut out, 1, "ModelExchange", &both(&["needsCompletedIntegratorStep"]));
    line(&mut out, 1, "CoSimulation", &both(&["canHandleVariableCommunicationStepSize"]));
    units(&mut out, variables);
    out += "  <LogCategories>\n";
    line(
        &mut out,
        2,
        "Category",
        &[("name", "logStatusError".to_owned()), ("description", "Why a call failed".to_owned())],
    );
    out += "  </LogCategories>\n";
    experiment(&mut out, subject);
    let _ = writeln!(out, "  <!--");
    for sentence in RULE {
        // Two hyphens would end the comment.
        let _ = writeln!(out, "  {}", sentence.replace("--", "- -"));
    }
    out += "  -->\n  <ModelVariables>\n";
    for (reference, variable) in variables.all.iter().enumerate() {
        declare(&mut out, reference, variable);
    }
    out += "  </ModelVariables>\n";
    structure(&mut out, variables);
    out + "</fmiModelDescription>\n"
}

/// Every unit that a variable has, with its powers of the base units where these are whole.
fn units(out: &mut String, variables: &Variables) {
    let mut names: Vec<&str> =
        variables.all.iter().map(|v| v.unit.as_str()).filter(|u| !u.is_empty()).collect();
    names.sort_unstable();
    names.dedup();
    out.push_str("  <UnitDefinitions>\n");
    for name in names {
        let _ = writeln!(out, "    <Unit name=\"{}\">", escaped(name));
        if let Ok(unit) = Unit::parse(name) {
            let powers = unit.dimension.powers();
            if powers.iter().all(|p| p.fract() == 0.0) {
                let base = ["kg", "m", "s", "A", "K"].into_iter().zip(powers).filter(|(_, p)| *p != 0.0);
                let mut attributes: Attributes = base.map(|(n, p)| (n, format!("{p}"))).collect();
                if unit.factor != 1.0 {
                    attributes.push(("factor", format!("{:?}", unit.factor)));
                }
                line(out, 3, "BaseUnit", &attributes);
            }
        }
        out.push_str("    </Unit>\n");
    }
    out.push_str("  </UnitDefinitions>\n");
}

fn experiment(out: &mut String, subject: &Subject) {
    let mut attributes: Attributes = Vec::new();
    if let Some(known) = &subject.experiment {
        attributes.push(("startTime", format!("{:?}", known.from)));
        attributes.push(("stopTime", format!("{:?}", known.to)));
        if known.step > 0.0 {
            attributes.push(("stepSize", format!("{:?}", known.step)));
        }
    }
    let shaped = subject.switched.switches.iter().any(|s| s.shaped);
    attributes.push(("tolerance", format!("{:?}", if shaped { FINE_TOLERANCE } else { TOLERANCE })));
    line(out, 1, "DefaultExperiment", &attributes);
}

fn declare(out: &mut String, reference: usize, variable: &Variable) {
    let (causality, variability) = match variable.kind {
        Kind::Time => ("independent", "continuous"),
        Kind::State | Kind::Output => ("output", "continuous"),
        Kind::Rate(_) | Kind::Indicator => ("local", "continuous"),
        Kind::Input | Kind::Slope => ("input", "continuous"),
        Kind::Parameter => ("parameter", "tunable"),
        Kind::Mode => ("output", "discrete"),
    };
    let mut attributes: Attributes = vec![
        ("name", variable.name.clone()),
        ("valueReference", reference.to_string()),
        ("description", variable.about.clone()),
        ("causality", causality.to_owned()),
        ("variability", variability.to_owned()),
    ];
    if variable.kind == Kind::State {
        attributes.push(("initial", "exact".to_owned()));
    }
    if let Kind::Rate(state) = variable.kind {
        attributes.push(("derivative", (1 + state).to_string()));
    }
    if !variable.unit.is_empty() {
        attributes.push(("unit", variable.unit.clone()));
    }
    if let Some(start) = variable.start {
        attributes.push(("start", format!("{start:?}")));
    }
    if let Some(nominal) = variable.nominal {
        attributes.push(("nominal", format!("{nominal:?}")));
    }
    let kind = if variable.kind == Kind::Mode { "Int32" } else { "Float64" };
    line(out, 2, kind, &attributes);
}

fn structure(out: &mut String, variables: &Variables) {
    let all = |out: &mut String, name: &str, wanted: fn(Kind) -> bool| {
        for (reference, _) in variables.of(wanted) {
            line(out, 2, name, &[("valueReference", reference.to_string())]);
        }
    };
    out.push_str("  <ModelStructure>\n");
    all(out, "Output", |k| matches!(k, Kind::State | Kind::Output | Kind::Mode));
    all(out, "ContinuousStateDerivative", |k| matches!(k, Kind::Rate(_)));
    all(out, "InitialUnknown", |k| matches!(k, Kind::Rate(_) | Kind::Output | Kind::Mode));
    all(out, "EventIndicator", |k| k == Kind::Indicator);
    out.push_str("  </ModelStructure>\n");
}

/// How the sources are compiled.
pub(super) fn build_description(identifier: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>
<fmiBuildDescription fmiVersion=\"3.0\">
  <BuildConfiguration modelIdentifier=\"{identifier}\">
    <SourceFileSet language=\"C99\">
      <SourceFile name=\"{identifier}.c\"/>
    </SourceFileSet>
  </BuildConfiguration>
</fmiBuildDescription>
"
    )
}
