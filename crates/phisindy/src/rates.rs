//! The rates of a model at given states.

use crate::case::Case;
use crate::error::Error;
use crate::record::RecordError;
use phisindy_expr::{Scratch, Tape};
use phisindy_phys::Value;

impl Case {
    /// The rates of the states of a model without unknown part, at rows of time (`t`, zero if absent), states
    /// and inputs, in the units of the spec per second. Movable constants have their start values, constants
    /// of the records those of the first one; friction of a contact at rest is zero.
    ///
    /// ```
    /// use phisindy::Case;
    /// let case = Case::read(r#"(states: { "x": "mm", "v": "mm/s" }, known: { "x": "v", "v": "-4*x" })"#)?;
    /// let rates = case.rates(&[("x", &[1.0, 2.0][..]), ("v", &[0.0, 3.0])])?;
    /// assert_eq!(rates[1], ("v".to_owned(), vec![-4.0, -8.0]));
    /// # Ok::<(), phisindy::Error>(())
    /// ```
    ///
    /// # Errors
    /// The model has an unknown part, a state or an input has no column, or columns differ in length.
    pub fn rates(&self, columns: &[(&str, &[f64])]) -> Result<Vec<(String, Vec<f64>)>, Error> {
        if self.checked.is_open() {
            return Err(Error::Open);
        }
        let system = &self.checked.system;
        let moving = system.states.iter().map(|s| (&s.name, s.factor));
        let moving: Vec<(&String, f64)> =
            moving.chain(system.inputs.iter().map(|u| (&u.name, u.factor))).collect();
        let rows = columns.first().map_or(0, |(_, values)| values.len());
        let mut given: Vec<Option<(&[f64], f64)>> = vec![None; 1 + moving.len()];
        for (name, values) in columns {
            if values.len() != rows {
                let column = (*name).to_owned();
                return Err(RecordError::Length { column, rows: values.len(), times: rows }.into());
            }
            let k = moving.iter().position(|(n, _)| n == name);
            match (*name, k) {
                ("t", None) => given[0] = Some((values, 1.0)),
                (_, Some(k)) => given[1 + k] = Some((values, moving[k].1)),
                _ => {
                    let names: Vec<&str> = moving.iter().map(|(n, _)| n.as_str()).collect();
                    return Err(RecordError::unknown(name, &names).into());
                }
            }
        }
        if let Some(k) = (0..moving.len()).find(|&k| given[1 + k].is_none()) {
            return Err(RecordError::Missing(moving[k].0.clone()).into());
        }
        let model = system.model(&[]);
        let tape = Tape::compile(&model.graph, &model.arguments(), &model.rates)
            .map_err(|e| Error::Completed(e.message(&model.names)))?;
        let of_record = self.checked.records.first().map_or(&[][..], |plan| &plan.constants);
        let number = |value: &Value| if let Value::Number(x) = value { *x } else { f64::NAN };
        let numbers = system.parameters.iter().map(|p| p.start).chain(of_record.iter().map(number));
        let numbers: Vec<f64> = numbers.collect();
        let mut scratch = Scratch::<1>::new(&tape);
        let mut rates: Vec<(String, Vec<f64>)> =
            system.states.iter().map(|s| (s.name.clone(), Vec::with_capacity(rows))).collect();
        for row in 0..rows {
            let moving = given.iter().map(|c| c.map_or(0.0, |(values, factor)| values[row] * factor));
            scratch.at(moving.chain(numbers.iter().copied()));
            for (k, (state, (_, out))) in system.states.iter().zip(&mut rates).enumerate() {
                out.push(scratch.output(k)[0] / state.factor);
            }
        }
        Ok(rates)
    }
}
