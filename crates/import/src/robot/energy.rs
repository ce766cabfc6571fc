//! The energies of a robot as the text of a spec.
//!
//! From joint to joint go the angular velocity, the velocity of the origin, the direction against gravity and the height
//! of the origin, all along the axes of the segment's own frame (R. Featherstone, Rigid Body Dynamics Algorithms, 2008,
//! 4.1): what is fixed in a frame has numbers there. Whatever is longer than a name gets one in `let`.

use super::frame::{Vector, transposed};
use super::sum::{Sum, Sums, along, both, crossed, decimal, through};
use super::tree::{Motion, Robot, Segment};

use std::fmt::Write;

/// The energies of a robot.
pub(super) struct Energies {
    /// Names with what they stand for, a list for each joint.
    pub(super) names: Vec<Vec<(String, String)>>,
    /// One summand for each body, armature and spring.
    pub(super) kinetic: Vec<String>,
    /// The same; empty without gravity and springs.
    pub(super) potential: Vec<String>,
    /// The same; empty without friction.
    pub(super) dissipation: Vec<String>,
}

/// What a segment knows of its motion, along the axes of its frame.
#[derive(Clone, Default)]
struct Moving {
    /// Angular velocity.
    turn: Sums,
    /// Velocity of the origin.
    origin: Sums,
    /// Direction against gravity.
    up: Sums,
    /// Height of the origin.
    height: Sum,
}

impl Energies {
    pub(super) fn of(robot: &Robot) -> Energies {
        let mut all = Energies { names: vec![], kinetic: vec![], potential: vec![], dissipation: vec![] };
        let ground = Moving {
            up: robot.up().map_or_else(Sums::default, |(up, _)| up.map(Sum::number)),
            ..Moving::default()
        };
        let mut motions: Vec<Moving> = vec![];
        let mut heights = vec![];
        for (k, segment) in robot.segments.iter().enumerate() {
            all.names.push(vec![]);
            let carrier = segment.parent.map_or(&ground, |parent| &motions[parent]);
            let own = all.moved(k, segment, carrier);
            heights.extend(all.body(k, segment, &own));
            all.joint(k, segment);
            motions.push(own);
        }
        match heights.as_slice() {
            [] => {}
            [one] => all.potential.insert(0, format!("g*{one}")),
            several => all.potential.insert(0, format!("g*({})", several.join(" + "))),
        }
        all
    }

    /// The motion of a segment by that of its carrier.
    fn moved(&mut self, k: usize, segment: &Segment, carrier: &Moving) -> Moving {
        let number = k + 1;
        let Segment { frame, axis: (axis, back), joint, .. } = segment;
        let sign = if *back { -1.0 } else { 1.0 };
        let inward = transposed(&frame.turn);
        let at_origin = both(&carrier.origin, &crossed(&carrier.turn, frame.origin));
        let mut turn = through(&inward, &carrier.turn);
        let mut origin = through(&inward, &at_origin);
        let mut up = through(&inward, &carrier.up);
        let mut height = carrier.height.clone().plus(&along(frame.origin, &carrier.up));
        let speed = Sum::name(&format!("dq{number}")).times_number(sign);
        match joint.motion {
            Motion::Turn => {
                for vector in [&mut turn, &mut origin, &mut up] {
                    self.turned(k, segment, vector);
                }
                turn[*axis] = turn[*axis].clone().plus(&speed);
            }
            Motion::Slide => {
                let way = Sum::name(&format!("q{number}")).plus(&Sum::number(-joint.reference));
                let way = way.times_number(sign);
                let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
                // The vector product of the angular velocity with the way along the axis.
                origin[i] = origin[i].clone().plus(&turn[j].times(&way));
                origin[j] = origin[j].clone().plus(&turn[i].times(&way).times_number(-1.0));
                origin[*axis] = origin[*axis].clone().plus(&speed);
                height = height.plus(&up[*axis].times(&way));
            }
        }
        Moving {
            turn: self.named(k, "w", turn),
            origin: self.named(k, "v", origin),
            up: self.named(k, "u", up),
            // A constant height changes no force.
            height: self.name(k, &format!("h{number}"), height.without_number()),
        }
    }

    /// A vector of a frame before its hinge turns it, along the axes of the frame that turns.
    fn turned(&mut self, k: usize, segment: &Segment, vector: &mut Sums) {
        let (axis, back) = segment.axis;
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        if vector[i].is_zero() && vector[j].is_zero() {
            return;
        }
        let number = k + 1;
        let [cos, sin] = ["c", "s"].map(|letter| Sum::name(&format!("{letter}{number}")));
        if self.names[k].is_empty() {
            let angle = match segment.joint.reference {
                0.0 => format!("q{number}"),
                reference => Sum::name(&format!("q{number}")).plus(&Sum::number(-reference)).to_string(),
            };
            for (letter, function) in [("c", "cos"), ("s", "sin")] {
                self.names[k].push((format!("{letter}{number}"), format!("{function}({angle})")));
            }
        }
        let sin = if back { sin.times_number(-1.0) } else { sin };
        let (a, b) = (vector[i].clone(), vector[j].clone());
        vector[i] = a.times(&cos).plus(&b.times(&sin));
        vector[j] = b.times(&cos).plus(&a.times(&sin).times_number(-1.0));
    }

    fn named(&mut self, k: usize, letter: &str, sums: Sums) -> Sums {
        let mut axes = ["x", "y", "z"].into_iter();
        sums.map(|sum| self.name(k, &format!("{letter}{}{}", k + 1, axes.next().unwrap_or_default()), sum))
    }

    /// A name for a sum, where that is shorter.
    fn name(&mut self, k: usize, name: &str, sum: Sum) -> Sum {
        if sum.is_short() {
            return sum;
        }
        self.names[k].push((name.to_owned(), sum.to_string()));
        Sum::name(name)
    }

    /// The kinetic energy of the body of a segment; returns its mass times its height.
    fn body(&mut self, k: usize, segment: &Segment, moving: &Moving) -> Option<String> {
        let body = &segment.body;
        if body.mass == 0.0 {
            return None;
        }
        let mass = format!("m{}", k + 1);
        let centre = both(&moving.origin, &crossed(&moving.turn, body.centre));
        let squares: Vec<String> = centre.iter().filter(|v| !v.is_zero()).map(Sum::square).collect();
        let mut parts = vec![];
        match squares.as_slice() {
            [] => {}
            [one] => parts.push(format!("{mass}*{one}/2")),
            several => parts.push(format!("{mass}*({})/2", several.join(" + "))),
        }
        let (mut text, mut count) = (String::new(), 0);
        for (i, j) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
            let (a, b) = (&moving.turn[i], &moving.turn[j]);
            let value = if i == j { body.inertia[i][i] } else { 2.0 * body.inertia[i][j] };
            if value.abs() < 1e-13 * trace(&body.inertia) || a.is_zero() || b.is_zero() {
                continue;
            }
            let product = if i == j { a.square() } else { format!("{}*{}", a.factor(), b.factor()) };
            let sign = match (text.is_empty(), value < 0.0) {
                (true, false) => "",
                (true, true) => "-",
                (false, false) => " + ",
                (false, true) => " - ",
            };
            let _ = write!(text, "{sign}{}*{product}", decimal(value.abs()));
            count += 1;
        }
        match count {
            0 => {}
            1 => parts.push(format!("{text}/2")),
            _ => parts.push(format!("({text})/2")),
        }
        if !parts.is_empty() {
            self.kinetic.push(parts.join(" + "));
        }
        let height = moving.height.clone().plus(&along(body.centre, &moving.up)).without_number();
        (!height.is_zero()).then(|| format!("{mass}*{}", height.factor()))
    }

    /// What the joint itself stores and loses.
    fn joint(&mut self, k: usize, segment: &Segment) {
        let (number, joint) = (k + 1, &segment.joint);
        if joint.armature > 0.0 {
            self.kinetic.push(format!("J{number}*dq{number}^2/2"));
        }
        if joint.spring.0 > 0.0 {
            let way = Sum::name(&format!("q{number}")).plus(&Sum::number(-joint.spring.1));
            self.potential.push(format!("k{number}*{}/2", way.square()));
        }
        let mut lost = vec![];
        if joint.damping > 0.0 {
            lost.push(format!("b{number}*dq{number}^2/2"));
        }
        if joint.friction > 0.0 {
            lost.push(format!("Fc{number}*|dq{number}|"));
        }
        if !lost.is_empty() {
            self.dissipation.push(lost.join(" + "));
        }
    }
}

fn trace(inertia: &[Vector; 3]) -> f64 {
    inertia[0][0] + inertia[1][1] + inertia[2][2]
}
