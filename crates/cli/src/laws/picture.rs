//! Pictures of laws: the force along the motion `x = sin t`, `v = cos t`, drawn over what the law depends on most.

use super::Entry;
use anyhow::{Result, anyhow};
use phisindy_expr::{Graph, Id, Names, Scratch, Tape, parse};
use phisindy_phys::Sketch;
use plotters::prelude::*;

/// Points along the two periods of the motion that are drawn.
const POINTS: usize = 1600;
/// Steps between two points, for states of a law's own.
const STEPS: usize = 8;
const SIZE: (u32, u32) = (360, 240);
const BLUE: RGBColor = RGBColor(0x1f, 0x5f, 0xa8);
const GREY: RGBColor = RGBColor(0x88, 0x88, 0x88);

/// The picture as SVG; `None` for a law that does not say how it is drawn.
pub(crate) fn picture(entry: &Entry) -> Result<Option<String>> {
    let Some(sketch) = &entry.law.sketch else { return Ok(None) };
    let curve = curve(entry, sketch)?;
    let reach = |f: fn(&(f64, f64)) -> f64| {
        let (a, b) =
            curve.iter().map(f).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        // A constant still needs a scale, and zero is always in the picture.
        let (a, b) = (a.min(0.0), b.max(0.0));
        let margin = 0.08 * (b - a).max(0.1);
        (a - margin)..(b + margin)
    };
    let (across, up) = (reach(|p| p.0), reach(|p| p.1));
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        let wrong = |e: &dyn std::fmt::Display| anyhow!("cannot draw `{}`: {e}", entry.id);
        let mut chart = ChartBuilder::on(&area)
            .margin(8)
            .x_label_area_size(34)
            .y_label_area_size(44)
            .build_cartesian_2d(across.clone(), up.clone())
            .map_err(|e| wrong(&e))?;
        let what = if entry.law.sensor.is_some() {
            "reading"
        } else if entry.law.push.is_some() {
            "push"
        } else {
            "force"
        };
        chart
            .configure_mesh()
            .disable_mesh()
            .axis_style(GREY)
            .x_labels(5)
            .y_labels(5)
            .x_desc(&sketch.over)
            .y_desc(what)
            .label_style(("sans-serif", 12, &GREY))
            .axis_desc_style(("sans-serif", 13, &GREY))
            .draw()
            .map_err(|e| wrong(&e))?;
        let zero = [vec![(across.start, 0.0), (across.end, 0.0)], vec![(0.0, up.start), (0.0, up.end)]];
        for line in zero {
            chart.draw_series([PathElement::new(line, GREY.mix(0.5))]).map_err(|e| wrong(&e))?;
        }
        if entry.law.sensor.is_some() {
            let truth = curve.iter().map(|(t, _)| (*t, t.sin()));
            chart.draw_series(LineSeries::new(truth, GREY.stroke_width(1))).map_err(|e| wrong(&e))?;
        }
        chart.draw_series(LineSeries::new(curve, BLUE.stroke_width(2))).map_err(|e| wrong(&e))?;
        area.present().map_err(|e| wrong(&e))?;
    }
    Ok(Some(svg))
}

/// The points of the picture.
fn curve(entry: &Entry, sketch: &Sketch) -> Result<Vec<(f64, f64)>> {
    let law = &entry.law;
    let (mut graph, mut names) = (Graph::default(), Names::default());
    let number = |name: &str| -> Option<f64> {
        let given = law.given.iter().find(|(n, _)| n == name).map(|(_, (value, _))| *value);
        given.or_else(|| sketch.with.iter().find(|(n, _)| n == name).map(|(_, value)| *value))
    };
    // A sensor shows the displacement: as it is, larger, higher, later.
    let force = match law.sensor.as_deref() {
        Some("gain") => "gain*x",
        Some("offset") => "x + offset",
        Some(_) => "sin(t - tau)",
        None => law.force.as_deref().or(law.push.as_deref()).unwrap_or("0"),
    };
    let motion: Vec<Id> = ["x", "v", "t"].iter().map(|name| graph.symbol(names.intern(name))).collect();
    let own: Vec<Id> = law.internal.iter().map(|(name, _)| graph.symbol(names.intern(name))).collect();
    let mut lower = |text: &str, graph: &mut Graph| -> Result<Id> {
        let ast = parse(text).map_err(|e| anyhow!("`{text}` in the law `{}`: {e:?}", entry.id))?;
        let root = graph
            .lower(&ast, |name| Some(names.intern(name)))
            .map_err(|e| anyhow!("`{text}` in the law `{}`: {e:?}", entry.id))?;
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
        outputs.push(lower(&internal.rate, &mut graph)?);
    }
    let inputs: Vec<Id> = motion.iter().chain(&own).copied().collect();
    let tape = Tape::compile(&graph, &inputs, &outputs)
        .map_err(|e| anyhow!("the sketch of the law `{}`: {}", entry.id, e.message(&names)))?;
    let mut scratch = Scratch::<1>::new(&tape);
    let mut at = |t: f64, z: &[f64]| -> Vec<f64> {
        [t.sin(), t.cos(), t].iter().chain(z).enumerate().for_each(|(k, v)| scratch.input(k)[0] = *v);
        scratch.run();
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
        // Small steps of the midpoint rule.
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
