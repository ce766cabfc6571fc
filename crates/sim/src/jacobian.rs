//! The derivatives of rates and surfaces as sparse matrices of expressions: a chain of bodies couples
//! neighbours, and what is zero whatever the point is neither evaluated nor read.

use crate::switched::Switched;
use phisindy_expr::{Graph, Id, Tape, Unbound};
use phisindy_phys::Model;

/// A matrix whose entries are outputs of a tape.
#[derive(Clone, Debug)]
pub(crate) struct Sparse {
    /// Where the entries of each row begin, and where the last ones end.
    starts: Vec<usize>,
    /// The column of each entry.
    columns: Vec<usize>,
    /// The output that is the first entry.
    first: usize,
}

impl Sparse {
    /// The derivatives of some nodes by others; their entries join the `outputs`.
    pub(crate) fn new(graph: &mut Graph, of: &[Id], by: &[Id], outputs: &mut Vec<Id>) -> Sparse {
        let (first, mut starts, mut columns) = (outputs.len(), vec![0], vec![]);
        for &f in of {
            for (column, slope) in graph.gradient(f, by).into_iter().enumerate() {
                if graph.value(slope) != Some(0.0) {
                    columns.push(column);
                    outputs.push(slope);
                }
            }
            starts.push(columns.len());
        }
        Sparse { starts, columns, first }
    }

    /// The entries of a row: their columns, and which outputs they are.
    pub(crate) fn row(&self, i: usize) -> impl Iterator<Item = (usize, usize)> {
        let entries = self.starts[i]..self.starts[i + 1];
        entries.map(|k| (self.columns[k], self.first + k))
    }
}

/// All derivatives that the variational equation needs.
#[derive(Clone, Debug)]
pub(crate) struct Jacobian {
    pub(crate) tape: Tape,
    pub(crate) rates_by_state: Sparse,
    pub(crate) rates_by_parameter: Sparse,
    pub(crate) rates_by_mode: Sparse,
    /// Of `dw/dt`.
    pub(crate) surface_rates_by_state: Sparse,
    pub(crate) surface_rates_by_parameter: Sparse,
    /// Of `w`; then of the gaps of impacts.
    pub(crate) surfaces_by_parameter: Sparse,
}

impl Jacobian {
    /// Of a model with modes; the tape has these inputs.
    pub(crate) fn new(model: &Model, of: &mut Switched, inputs: &[Id]) -> Result<Jacobian, Unbound> {
        let mut outputs = Vec::new();
        let Switched { graph, rates, surface_rates, surfaces, modes, .. } = of;
        let mut slopes = |of: &[Id], by: &[Id]| Sparse::new(graph, of, by, &mut outputs);
        let (states, parameters) = (&model.states, &model.parameters);
        let rates_by_state = slopes(rates, states);
        let rates_by_parameter = slopes(rates, parameters);
        let rates_by_mode = slopes(rates, modes);
        let surface_rates_by_state = slopes(surface_rates, states);
        let surface_rates_by_parameter = slopes(surface_rates, parameters);
        let gaps = model.impacts.iter().map(|impact| impact.gap);
        let located: Vec<Id> = surfaces.iter().copied().chain(gaps).collect();
        let surfaces_by_parameter = slopes(&located, parameters);
        Ok(Jacobian {
            tape: Tape::compile(graph, inputs, &outputs)?,
            rates_by_state,
            rates_by_parameter,
            rates_by_mode,
            surface_rates_by_state,
            surface_rates_by_parameter,
            surfaces_by_parameter,
        })
    }
}
