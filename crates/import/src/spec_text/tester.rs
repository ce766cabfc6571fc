//! A friction tester: a prescribed motion is the input, and the force that it meets an output.

use super::literals::three_digits;
use crate::draft::Draft;
use crate::roles::Input;
use crate::start_values::Drive;
use std::fmt::Write;

/// The bounds are this factor from a spring or damper that had all of the force.
const WIDE: f64 = 10.0;

/// What the data say of a tester.
#[derive(Clone, Copy)]
pub(super) struct Tester {
    stiffness: f64,
    damping: Option<f64>,
    mean: f64,
    /// Stiffness and damping of a spring and a damper that had all of the force.
    most: [f64; 2],
}

/// The tester that a draft is of, if it is.
pub(super) fn of(draft: &Draft) -> Option<Tester> {
    let (Input::Reaction(force), Drive::Tester { stiffness, damping, mean }) =
        (draft.roles.input, draft.drive)
    else {
        return None;
    };
    let size = |column: usize| draft.statistics[column].std * draft.factor(column).abs();
    let spring = size(force) / size(draft.moving());
    let time = &draft.motion.time;
    let span = time.last().zip(time.first()).map(|(last, first)| last - first);
    let pace = std::f64::consts::TAU * draft.motion.frequency.or(span.map(|span| 1.0 / span))?;
    Some(Tester { stiffness, damping, mean, most: [spring, spring / pace].map(|most| WIDE * most) })
}

impl Tester {
    /// Writes everything before `data`.
    pub(super) fn write(self, text: &mut String) {
        let constant = |name: &str, value: f64, unit: &str, most: f64, what: &str| {
            let (value, most) = (three_digits(value), three_digits(most.max(WIDE * value)));
            format!(
                "        \"{name}\": (value: {value:?}, unit: \"{unit}\", within: (0.0, {most:?})), // EDIT: the {what} part of the force; 0 if there is none\n"
            )
        };
        text.push_str("    constants: {\n");
        text.push_str(&constant("k", self.stiffness, "N/m", self.most[0], "elastic"));
        if let Some(damping) = self.damping {
            text.push_str(&constant("c", damping, "N*s/m", self.most[1], "viscous"));
        }
        let damper = if self.damping.is_some() { " + c*dx" } else { "" };
        let _ = write!(
            text,
            r#"    }},
    // The force jumps with the direction of the motion and shows no inertia: the motion is prescribed, as in a friction tester.
    // EDIT: if F drives a body instead, x and its speed v are states, F an input, and the known rate of v is
    // "(F - c*v - k*x)/m".
    states: {{}},
    inputs: {{ "x": "m", "dx": "m/s" }},
    outputs: {{ "F": (unit: "N", reads: "k*x{damper}") }}, // EDIT: the part of the force that you are sure of
    known: {{}},
    unknown: {{}},
    // `phisindy gap` names the friction that the force lacks.
"#
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
