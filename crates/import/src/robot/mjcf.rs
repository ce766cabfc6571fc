//! MJCF (the format of MuJoCo, <https://mujoco.readthedocs.io/en/stable/XMLreference.html>).

mod classes;

use super::body::Body;
use super::frame::{
    Frame, Matrix, Vector, cross, direction, of_quaternion, product, times, transposed, turn,
    with_shortest_turn,
};
use super::geom;
use super::tree::{Joint, Motion, Motor, Robot};
use super::xml::{Element, Read, right_angle};
pub(super) use classes::Chain;
use classes::Defaults;

/// Deeper trees are refused.
const DEEPEST: usize = 200;

/// What is not read: an element, wherever it stands, what it is, and what to do.
const REFUSED: &[(&str, &str, &str)] = &[
    (
        "include",
        "other files are not read",
        "write all into one file: `mujoco.MjSpec.from_file(path).to_xml()` does it",
    ),
    (
        "freejoint",
        "a free joint is not read: a spec has joints with one coordinate",
        "fix the base: delete the joint",
    ),
    ("tendon", "tendons are not read", "delete `<tendon>` and what uses it, or write the spec by hand"),
    (
        "equality",
        "closed loops and coupled joints are not read",
        "delete `<equality>`, or write the spec by hand",
    ),
    ("replicate", "copies are not read", "write them out: `mujoco.MjSpec.from_file(path).to_xml()` does it"),
    (
        "attach",
        "attached models are not read",
        "write all into one file: `mujoco.MjSpec.from_file(path).to_xml()` does it",
    ),
    ("composite", "composite bodies are not read", "replace it by bodies and joints"),
    ("flexcomp", "flexible bodies are not read", "replace it by a rigid body"),
    ("deformable", "flexible bodies are not read", "replace it by a rigid body"),
];

/// How the numbers of a file are to be taken.
pub(super) struct Compiler {
    /// Radians for the unit of angles.
    angle: f64,
    /// The order of turns about axes.
    sequence: Vec<char>,
    /// Whether bodies are those that are drawn, also where they say otherwise; none: where they say nothing.
    from_geoms: Option<bool>,
}

impl Compiler {
    fn of(root: Element<'_>) -> Read<Compiler> {
        let mut own =
            Compiler { angle: 1.0_f64.to_radians(), sequence: vec!['x', 'y', 'z'], from_geoms: None };
        for compiler in root.children().filter(|e| e.is("compiler")) {
            if compiler.text("angle") == Some("radian") {
                own.angle = 1.0;
            }
            if let Some(sequence) = compiler.text("eulerseq") {
                own.sequence = sequence.chars().collect();
                if own.sequence.len() != 3 || own.sequence.iter().any(|c| !"xyzXYZ".contains(*c)) {
                    return Err(compiler.wrong("`eulerseq` is no order of axes", "as in \"xyz\" or \"ZYX\""));
                }
            }
            own.from_geoms = match compiler.text("inertiafromgeom") {
                Some("true") => Some(true),
                Some("false") => Some(false),
                _ => own.from_geoms,
            };
            for bound in ["boundmass", "boundinertia", "settotalmass"] {
                if compiler.number(bound)?.is_some_and(|x| x > 0.0) {
                    return Err(compiler.wrong(
                        format!("`{bound}` changes the masses, which is not read"),
                        "delete it, or give each body `<inertial>` with the mass that MuJoCo has (`model.body_mass`)",
                    ));
                }
            }
        }
        Ok(own)
    }

    /// Where an element stands.
    pub(super) fn frame(&self, of: &Chain<'_>) -> Read<Frame> {
        Ok(Frame { turn: self.turn(of)?, origin: of.exactly("pos")?.unwrap_or_default() })
    }

    fn turn(&self, of: &Chain<'_>) -> Read<Matrix> {
        let no_direction = || of.own().wrong("this orientation has no direction", "its numbers are all zero");
        let along = |axis: Vector| direction(axis).ok_or_else(no_direction);
        if let Some(own) = of.exactly("quat")? {
            return of_quaternion(own).ok_or_else(no_direction);
        }
        if let Some([x, y, z, angle]) = of.exactly("axisangle")? {
            return Ok(turn(along([x, y, z])?, self.radians(angle)));
        }
        if let Some(own) = of.exactly::<3>("euler")? {
            let axis = |c: char| match c.to_ascii_lowercase() {
                'x' => [1.0, 0.0, 0.0],
                'y' => [0.0, 1.0, 0.0],
                _ => [0.0, 0.0, 1.0],
            };
            return Ok(self.sequence.iter().zip(own).fold(Frame::SAME.turn, |all, (&c, angle)| {
                let next = turn(axis(c), self.radians(angle));
                // About an axis that has turned already, or about one that stands still.
                if c.is_lowercase() { product(&all, &next) } else { product(&next, &all) }
            }));
        }
        if let Some([a, b, c, x, y, z]) = of.exactly("xyaxes")? {
            let first = along([a, b, c])?;
            let third = along(cross(first, [x, y, z]))?;
            return Ok(transposed(&[first, cross(third, first), third]));
        }
        match of.exactly("zaxis")? {
            Some(axis) => Ok(with_shortest_turn(along(axis)?)),
            None => Ok(Frame::SAME.turn),
        }
    }

    fn radians(&self, angle: f64) -> f64 {
        if self.angle == 1.0 { right_angle(angle) } else { angle * self.angle }
    }
}

/// An element of a body: where the frames around it stand in the body, and the class that holds there.
struct Part<'a> {
    element: Element<'a>,
    frame: Frame,
    class: Option<&'a str>,
}

/// What the walk through the bodies knows.
struct Walk<'a> {
    compiler: Compiler,
    defaults: Defaults<'a>,
    robot: Robot,
}

/// Reads the element `mujoco`.
pub(super) fn read(root: Element<'_>) -> Read<Robot> {
    let active = |e: &Element<'_>| {
        let children: Vec<Element<'_>> = e.children().collect();
        match e.is("equality") {
            true => children.iter().any(|child| child.text("active") != Some("false")),
            false => !e.is("tendon") || !children.is_empty(),
        }
    };
    for element in root.descendants() {
        if let Some((_, message, help)) = REFUSED.iter().find(|(tag, ..)| element.is(tag) && active(&element))
        {
            return Err(element.wrong(*message, *help));
        }
    }
    let mut robot = Robot::new(root.text("model").unwrap_or("robot"), "MJCF");
    for option in root.children().filter(|e| e.is("option")) {
        robot.gravity = option.exactly("gravity")?.unwrap_or(robot.gravity);
        let flag = option.child("flag").and_then(|flag| flag.text("gravity"));
        if flag == Some("disable") {
            robot.gravity = [0.0; 3];
        }
        if option.number("density")?.unwrap_or(0.0) + option.number("viscosity")?.unwrap_or(0.0) > 0.0 {
            robot.remarks.push("the drag of a medium (`density`, `viscosity`) is left out".to_owned());
        }
    }
    let mut walk = Walk { compiler: Compiler::of(root)?, defaults: Defaults::of(root)?, robot };
    for world in root.children().filter(|e| e.is("worldbody")) {
        let parts = walk.parts(world, (Frame::SAME, None), 0)?;
        walk.bodies(&parts, (None, Frame::SAME), 0)?;
    }
    for actuators in root.children().filter(|e| e.is("actuator")) {
        actuators.children().try_for_each(|own| walk.motor(own))?;
    }
    Ok(walk.robot)
}

impl<'a> Walk<'a> {
    /// What stands in a body, with the frames around it there written out.
    fn parts(
        &self,
        element: Element<'a>,
        around: (Frame, Option<&'a str>),
        depth: usize,
    ) -> Read<Vec<Part<'a>>> {
        if depth > DEEPEST {
            return Err(element.wrong("bodies and frames are nested too deep", "no robot needs that"));
        }
        let mut all = vec![];
        for child in element.children() {
            let (frame, class) = (around.0, child.text("childclass").or(around.1));
            if child.is("frame") {
                let own = self.compiler.frame(&Chain::alone(child))?;
                all.extend(self.parts(child, (frame.frame(&own), class), depth + 1)?);
            } else {
                all.push(Part { element: child, frame, class });
            }
        }
        Ok(all)
    }

    /// The bodies among these parts of what is carried so.
    fn bodies(
        &mut self,
        parts: &[Part<'a>],
        (carrier, at): (Option<usize>, Frame),
        depth: usize,
    ) -> Read<()> {
        for part in parts.iter().filter(|part| part.element.is("body")) {
            self.body(part, (carrier, at.frame(&part.frame)), depth + 1)?;
        }
        Ok(())
    }

    fn body(&mut self, part: &Part<'a>, (carrier, parent): (Option<usize>, Frame), depth: usize) -> Read<()> {
        let body = part.element;
        if body.number("gravcomp")?.is_some_and(|x| x != 0.0) {
            return Err(body.wrong(
                "`gravcomp` is not read",
                "delete it; a force that carries the body is one of the motors",
            ));
        }
        let own = self.compiler.frame(&Chain::alone(body))?;
        let mut at = (carrier, parent.frame(&own));
        let parts = self.parts(body, (Frame::SAME, part.class), depth)?;
        for Part { element, frame, class } in parts.iter().filter(|part| part.element.is("joint")) {
            let chain = self.defaults.chain(*element, *class)?;
            at = self.joint(&chain, frame, at)?;
        }
        let matter = self.matter(body, &parts)?;
        self.robot.add_body(at, &matter);
        self.bodies(&parts, at, depth)
    }

    /// Adds a joint that stands so in its body, which is carried so; returns what carries the body then.
    fn joint(
        &mut self,
        of: &Chain<'_>,
        frame: &Frame,
        at: (Option<usize>, Frame),
    ) -> Read<(Option<usize>, Frame)> {
        let number = self.robot.segments.len() + 1;
        let name = of.own().text("name").map_or_else(|| format!("joint {number}"), str::to_owned);
        if of.own().text("name").is_none() {
            self.robot.remarks.push(format!("joint {number} has no name in the file: give it one"));
        }
        let motion = match of.text("type").unwrap_or("hinge") {
            "hinge" => Motion::Turn,
            "slide" => Motion::Slide,
            other => {
                return Err(of.own().wrong(
                    format!("`{name}` is a {other} joint, which is not read: a spec has joints with one coordinate"),
                    "replace it by hinges and slides in a row, or delete it to fix the body",
                ));
            }
        };
        let unit = if motion == Motion::Turn { self.compiler.angle } else { 1.0 };
        let axis = of.exactly("axis")?.unwrap_or([0.0, 0.0, 1.0]);
        let axis = direction(axis)
            .ok_or_else(|| of.own().wrong("this axis has no direction", "as in axis=\"0 0 1\""))?;
        let scaled = |x: Option<f64>| x.unwrap_or(0.0) * unit;
        let limited = of.text("limited") != Some("false");
        let range = of.exactly::<2>("range")?.filter(|[low, high]| limited && low < high);
        let joint = Joint {
            name,
            motion,
            reference: scaled(of.number("ref")?),
            damping: of.size("damping")?,
            friction: of.size("frictionloss")?,
            armature: of.size("armature")?,
            spring: (of.size("stiffness")?, scaled(of.number("springref")?)),
            range: range.map(|[low, high]| (low * unit, high * unit)),
            effort: None,
        };
        let point = of.exactly("pos")?.unwrap_or_default();
        Ok(self.robot.add_joint(at, joint, (times(&frame.turn, axis), frame.point(point))))
    }

    /// The body of an element: what it says, or what it draws.
    fn matter(&self, body: Element<'a>, parts: &[Part<'a>]) -> Read<Body> {
        let said = body.child("inertial").filter(|_| self.compiler.from_geoms != Some(true));
        if let Some(inertial) = said {
            let mass = inertial
                .number("mass")?
                .ok_or_else(|| inertial.wrong("`<inertial>` has no `mass`", "in kg"))?;
            let frame = self.compiler.frame(&Chain::alone(inertial))?;
            let inertia = match (inertial.exactly("fullinertia")?, inertial.exactly("diaginertia")?) {
                (Some([xx, yy, zz, xy, xz, yz]), _) => [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]],
                (None, Some([xx, yy, zz])) => [[xx, 0.0, 0.0], [0.0, yy, 0.0], [0.0, 0.0, zz]],
                (None, None) => {
                    return Err(
                        inertial.wrong("`<inertial>` has no inertia", "add `diaginertia` or `fullinertia`")
                    );
                }
            };
            let own = Body { mass, centre: [0.0; 3], inertia };
            own.checked(inertial)?;
            return Ok(own.seen_from(&frame));
        }
        let mut all = Body::default();
        if self.compiler.from_geoms != Some(false) {
            for Part { element, frame, class } in parts.iter().filter(|part| part.element.is("geom")) {
                let own = geom::body(&self.defaults.chain(*element, *class)?, &self.compiler)?;
                all = own.map_or(all, |own| all.with(&own.seen_from(frame)));
            }
        }
        Ok(all)
    }

    /// A motor; of what has a law of its own only the torque of its joint is in the model.
    fn motor(&mut self, own: Element<'a>) -> Read<()> {
        let chain = self.defaults.chain(own, None)?;
        let Some(joint) = own.text("joint").or(own.text("jointinparent")) else { return Ok(()) };
        let Some(joint) = self.robot.joints().position(|other| other.name == joint) else {
            return Err(own.wrong(
                format!("there is no joint `{joint}`"),
                "look how it is spelled where it is declared",
            ));
        };
        let name = own.text("name").unwrap_or_default().to_owned();
        if !own.is("motor") {
            self.robot.remarks.push(format!(
                "the actuator `{name}` of joint `{}` has a law of its own: the joint is driven by its torque here",
                self.robot.segments[joint].joint.name
            ));
            return Ok(());
        }
        let gear = chain.numbers("gear")?.and_then(|all| all.first().copied()).unwrap_or(1.0);
        self.robot.motors.push(Motor { name, joint, gear });
        Ok(())
    }
}
