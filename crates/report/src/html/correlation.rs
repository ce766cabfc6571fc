//! Correlations of the estimates.

use crate::chart::{Chart, Sheet, digits, heatmap};
use phisindy_learn::Identified;
use phisindy_phys::System;

/// The matrix as a chart; none with fewer than two estimates.
pub(crate) fn chart(system: &System, found: &Identified, sheet: Sheet) -> Option<(Chart, String)> {
    let terms = found.terms.iter().map(|f| {
        let term = &system.terms[f.term];
        format!("{} in {}'", term.candidate, system.states[term.state].name)
    });
    let names: Vec<String> = terms.chain(found.parameters.iter().map(|p| p.id.to_string())).collect();
    if names.len() < 2 || found.covariance.len() != names.len() {
        return None;
    }
    let c = &found.covariance;
    let r = |i: usize, j: usize| if i == j { 1.0 } else { c[i][j] / (c[i][i] * c[j][j]).sqrt() };
    let values: Vec<Vec<f64>> =
        (0..names.len()).map(|i| (0..names.len()).map(|j| r(i, j)).collect()).collect();
    let pairs = (0..names.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let strongest = pairs.filter(|&(i, j)| values[i][j].is_finite());
    let (i, j) = strongest.max_by(|a, b| values[a.0][a.1].abs().total_cmp(&values[b.0][b.1].abs()))?;
    let said = format!(
        "The strongest correlation is {} between {} and {}.",
        digits(values[i][j], 2),
        names[j],
        names[i]
    );
    let title = "Correlations of the estimates";
    let chart = heatmap("correlation", title, &said, &names, &values, sheet);
    let list: Vec<String> = names.iter().enumerate().map(|(k, name)| format!("{} {name}", k + 1)).collect();
    let caption = format!(
        "{title}: near ±1 two numbers cannot be told apart. {said} The numbers: {}.",
        list.join(", ")
    );
    Some((chart, caption))
}
