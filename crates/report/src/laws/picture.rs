//! Pictures of laws: the force during the motion `x = sin t`, `v = cos t` against the main variable of the
//! law.

use crate::chart::{Axis, Chart, Mark, Panel, Place};
use crate::format::capital;
use phisindy_expr::{Graph, Id, Names, Scratch, Tape, parse, rename};
use phisindy_phys::{INPUT, LawEntry, LawRole, Sketch};

/// Points of the curve, over two periods of the motion.
const POINTS: usize = 1600;
/// Integration steps between two points, for internal states of a law.
const STEPS: usize = 8;
const SIZE: (f64, f64) = (380.0, 250.0);

/// The picture as SVG; `None` for a law without a sketch.
///
/// # Errors
/// In words: the expressions of the law, or of its sketch, cannot be evaluated.
pub fn picture(entry: &LawEntry) -> Result<Option<String>, String> {
    let Some(sketch) = &entry.law.sketch else { return Ok(None) };
    let curve = curve(entry, sketch)?;
    let sensor = entry.law.property().is_some();
    let what = if entry.law.input.is_some() {
        "input"
    } else if sensor {
        "reading"
    } else if entry.law.push.is_some() {
        "push"
    } else {
        "force"
    };
    // Both axes include zero.
    let across = Axis::around(&sketch.over, "", curve.iter().map(|p| p.0).chain([0.0]));
    let up = Axis::around(what, "", curve.iter().map(|p| p.1).chain([0.0]));
    let upright = [up.ends().0, up.ends().1].map(|y| (0.0, y)).to_vec();
    let mut marks =
        vec![Mark::Level { class: "zero", y: 0.0 }, Mark::Line { class: "zero", points: upright }];
    if sensor {
        marks.push(Mark::Line {
            class: "measured",
            points: curve.iter().map(|(t, _)| (*t, t.sin())).collect(),
        });
    }
    marks.push(Mark::Line { class: "model", points: curve });
    let panel = Panel { heading: String::new(), x: across, y: up, marks, labelled: true };
    let description = format!("{what} over {} along the motion x = sin t, v = cos t", sketch.over);
    let mut chart = Chart::new(&entry.id, &capital(&entry.law.name), &description, SIZE);
    chart.draw(panel.drawn(Place { x: 70.0, y: 14.0, width: SIZE.0 - 82.0, height: SIZE.1 - 62.0 }));
    Ok(Some(chart.file()))
}

/// The points of the picture.
fn curve(entry: &LawEntry, sketch: &Sketch) -> Result<Vec<(f64, f64)>, String> {
    let law = &entry.law;
    let (mut graph, mut names) = (Graph::default(), Names::default());
    let number = |name: &str| -> Option<f64> {
        // A load is as large as the motion.
        let load = (law.role(LawRole::Load) == Some(name)).then_some(1.0);
        let given = law.given.iter().find(|(n, _)| n == name).map(|(_, (value, _))| *value).or(load);
        given.or_else(|| sketch.with.iter().find(|(n, _)| n == name).map(|(_, value)| *value))
    };
    // A sensor law is shown as its reading of the displacement, and what acts as if that were the input.
    let of_input = |text: &str| rename(text, &[(INPUT.to_owned(), "x".to_owned())]).unwrap_or_default();
    let acts = law.acting().map(of_input);
    let force = match law.property() {
        Some(_) if acts.is_some() => acts.as_deref().unwrap_or_default(),
        Some("gain") => "gain*x",
        Some("offset") => "x + offset",
        Some("lag") => "sin(t - atan(tau))/sqrt(1 + tau^2)",
        Some(_) => "sin(t - tau)",
        None => law.force.as_deref().or(law.push.as_deref()).unwrap_or("0"),
    };
    let motion: Vec<Id> = ["x", "v", "t"].iter().map(|name| graph.symbol(names.intern(name))).collect();
    let own: Vec<Id> = law.internal.iter().map(|(name, _)| graph.symbol(names.intern(name))).collect();
    let mut lower = |text: &str, graph: &mut Graph| -> Result<Id, String> {
        let ast = parse(text).map_err(|e| format!("`{text}` in the law `{}`: {e:?}", entry.id))?;
        let root = graph
            .lower(&ast, |name| Some(names.intern(name)))
            .map_err(|e| format!("`{text}` in the law `{}`: {e:?}", entry.id))?;
        let known = graph
            .symbols(&[root])
            .into_iter()
            .filter_map(|symbol| Some((symbol, number(names.name(symbol))?)))
            .collect::<Vec<_>>();
        let with =
            known.into_iter().map(|(symbol, value)| (graph.symbol(symbol), graph.constant(value))).collect();
        Ok(graph.replace(&[root], &with)[0])
    };
    let mut outputs = vec![lower(force, &mut graph)?];
    for (_, internal) in &law.internal {
        let rate = if acts.is_some() { of_input(&internal.rate) } else { internal.rate.clone() };
        outputs.push(lower(&rate, &mut graph)?);
    }
    let inputs: Vec<Id> = motion.iter().chain(&own).copied().collect();
    let tape = Tape::compile(&graph, &inputs, &outputs)
        .map_err(|e| format!("the sketch of the law `{}`: {}", entry.id, e.message(&names)))?;
    let mut scratch = Scratch::<1>::new(&tape);
    let mut at = |t: f64, z: &[f64]| -> Vec<f64> {
        scratch.at([t.sin(), t.cos(), t].iter().chain(z).copied());
        (0..outputs.len()).map(|k| scratch.output(k)[0]).collect()
    };
    let mut z: Vec<f64> = law.internal.iter().map(|(_, i)| i.start).collect();
    let step = 4.0 * std::f64::consts::PI / POINTS as f64;
    let mut curve = Vec::with_capacity(POINTS + 1);
    for k in 0..=POINTS {
        let t = step * k as f64;
        let x = match sketch.over.as_str() {
            "v" => t.cos(),
            "t" => t,
            _ => t.sin(),
        };
        curve.push((x, at(t, &z)[0]));
        // Explicit midpoint rule with small steps.
        for j in 0..STEPS * usize::from(!z.is_empty()) {
            let h = step / STEPS as f64;
            let s = t + h * j as f64;
            let first = at(s, &z);
            let middle: Vec<f64> = z.iter().zip(&first[1..]).map(|(z, r)| z + 0.5 * h * r).collect();
            let second = at(s + 0.5 * h, &middle);
            z.iter_mut().zip(&second[1..]).for_each(|(z, r)| *z += h * r);
        }
    }
    Ok(curve)
}
