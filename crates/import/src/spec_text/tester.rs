//! A friction tester: a prescribed motion is the input, and the force that it meets an output.

use super::literals::three_digits;
use crate::draft::Draft;
use crate::roles::Input;
use crate::start_values::Drive;
use std::fmt::Write;

/// The bounds of the stiffness are this factor from the estimate.
const WIDE: f64 = 100.0;

/// What the data say of a tester.
#[derive(Clone, Copy)]
pub(super) struct Tester {
    stiffness: f64,
    mean: f64,
}

/// The tester that a draft is of, if it is.
pub(super) fn of(draft: &Draft) -> Option<Tester> {
    match (draft.roles.input, draft.drive) {
        (Input::Reaction(_), Drive::Tester { stiffness, mean }) => Some(Tester { stiffness, mean }),
        _ => None,
    }
}

impl Tester {
    /// Writes everything before `data`.
    pub(super) fn write(self, text: &mut String) {
        let (value, most) = (three_digits(self.stiffness), three_digits(WIDE * self.stiffness.max(1.0)));
        let _ = writeln!(
            text,
            "    constants: {{\n        \"k\": (value: {value:?}, unit: \"N/m\", within: (0.0, {most:?})), // EDIT: the elastic part of the force; 0 if there is none\n    }},"
        );
        text.push_str(
            "    // The force jumps with the direction of the motion and shows no inertia: the motion is prescribed, as in a friction tester.\n    \
             // EDIT: if F drives a body instead, x and its speed v are states, F an input, and \"v\": \"(F -
             // c*v - k*x)/m\" is known.\n    \
             states: {},\n    inputs: { \"x\": \"m\", \"dx\": \"m/s\" },\n    \
             outputs: { \"F\": (unit: \"N\", reads: \"k*x\") }, // EDIT: the part of the force that you are sure of\n    \
             known: {},\n    unknown: {},\n    // `phisindy gap` names the friction that the force lacks.\n",
        );
    }

    /// The fields of a record: the speed, and the zero of the force cell.
    pub(super) fn fields(self, draft: &Draft) -> [String; 2] {
        let Input::Reaction(c) = draft.roles.input else { return Default::default() };
        let (numbers, factor) = (&draft.statistics[c], draft.factor(c));
        let half = 0.5 * (numbers.max - numbers.min).abs() * factor.abs();
        let [start, low, high] = [self.mean, self.mean - half, self.mean + half].map(three_digits);
        [
            "derive: { \"dx\": Derivative(\"x\") }".to_owned(),
            format!(
                "sensors: {{ \"F\": (offset: Find(start: {start:?}, unit: \"N\", within: ({low:?}, {high:?}))) }}"
            ),
        ]
    }
}
