//! URDF (the Unified Robot Description Format of ROS, <https://wiki.ros.org/urdf/XML>).

use super::body::Body;
use super::frame::{Frame, direction, product, turn};
use super::tree::{Joint, Motion, Motor, Robot};
use super::xml::{Element, Read, right_angle};
use std::collections::HashMap;

/// A joint of the file: the element, and the numbers of its links.
struct Connection<'a> {
    element: Element<'a>,
    name: &'a str,
    parent: usize,
    child: usize,
}

/// Reads the element `robot`.
pub(super) fn read(root: Element<'_>) -> Read<Robot> {
    let mut robot = Robot::new(root.text("name").unwrap_or("robot"), "URDF");
    let is_macro = |e: &Element<'_>| e.node.tag_name().namespace().is_some_and(|name| name.contains("xacro"));
    if let Some(element) = root.descendants().find(is_macro) {
        return Err(element.wrong(
            "this file has macros of xacro, which are not read",
            "write them out first: `xacro robot.urdf.xacro > robot.urdf`",
        ));
    }
    let links: Vec<Element<'_>> = root.children().filter(|e| e.is("link")).collect();
    let mut numbers = HashMap::new();
    for (k, link) in links.iter().enumerate() {
        let name = link.needed("name")?;
        if numbers.insert(name, k).is_some() {
            return Err(link.wrong(format!("two links are called `{name}`"), "give one of them another name"));
        }
    }
    let joints = connections(root, &numbers)?;
    let mut open = vec![(base(root, &links, &joints)?, (None, Frame::SAME))];
    // Outwards from the base. A tree ends, and the last is taken first: joints keep the order of the file.
    let mut reached = vec![false; links.len()];
    while let Some((link, at)) = open.pop() {
        reached[link] = true;
        robot.add_body(at, &body(links[link])?);
        let mut next = vec![];
        for joint in joints.iter().filter(|joint| joint.parent == link) {
            next.push((joint.child, moved(&mut robot, joint, at)?));
        }
        open.extend(next.into_iter().rev());
    }
    if let Some(joint) = joints.iter().find(|joint| !reached[joint.parent]) {
        return Err(joint.element.wrong(
            format!("joint `{}` is in a closed loop: its link hangs on itself", joint.name),
            "chains and trees are read: cut the loop at one joint, or write a spec by hand",
        ));
    }
    motors(root, &mut robot)?;
    Ok(robot)
}

fn connections<'a>(root: Element<'a>, links: &HashMap<&str, usize>) -> Read<Vec<Connection<'a>>> {
    let mut all: Vec<Connection<'a>> = vec![];
    for element in root.children().filter(|e| e.is("joint")) {
        let name = element.needed("name")?;
        if all.iter().any(|other| other.name == name) {
            return Err(
                element.wrong(format!("two joints are called `{name}`"), "give one of them another name")
            );
        }
        let end = |tag: &'static str| {
            let end = element.child(tag).ok_or_else(|| {
                element
                    .wrong(format!("joint `{name}` has no `<{tag}>`"), format!("add `<{tag} link=\"...\"/>`"))
            })?;
            let link = end.needed("link")?;
            links.get(link).copied().ok_or_else(|| {
                end.wrong(format!("there is no link `{link}`"), "look how it is spelled where it is declared")
            })
        };
        let (parent, child) = (end("parent")?, end("child")?);
        if let Some(other) = all.iter().find(|other| other.child == child) {
            return Err(element.wrong(
                format!("joints `{}` and `{name}` carry the same link: a closed loop", other.name),
                "chains and trees are read: cut the loop at one joint, or write a spec by hand",
            ));
        }
        all.push(Connection { element, name, parent, child });
    }
    Ok(all)
}

/// The link that stands still.
fn base(root: Element<'_>, links: &[Element<'_>], joints: &[Connection<'_>]) -> Read<usize> {
    let carried = |k: &usize| joints.iter().any(|joint| joint.child == *k);
    let mut free = (0..links.len()).filter(|k| !carried(k));
    let Some(base) = free.next() else {
        return Err(root.wrong(
            "no link stands still",
            "a robot has one link that is no joint's child: the others hang on it in a tree",
        ));
    };
    match free.next() {
        None => Ok(base),
        Some(other) => Err(links[other].wrong(
            format!(
                "`{}` hangs on nothing, and so does `{}`",
                links[other].needed("name")?,
                links[base].needed("name")?
            ),
            "connect it by a joint, of type `fixed` if it does not move",
        )),
    }
}

/// Adds a joint to what carries its parent; returns what carries its child.
fn moved(
    robot: &mut Robot,
    Connection { element, name, .. }: &Connection<'_>,
    (carrier, at): (Option<usize>, Frame),
) -> Read<(Option<usize>, Frame)> {
    let link = at.frame(&origin(*element)?);
    let motion = match element.needed("type")? {
        "revolute" | "continuous" => Motion::Turn,
        "prismatic" => Motion::Slide,
        "fixed" => return Ok((carrier, link)),
        other => {
            return Err(element.wrong(
                format!("joint `{name}` is `{other}`: a spec has joints with one coordinate"),
                "make it `fixed`, `revolute`, `continuous` or `prismatic`, or write several joints in a row",
            ));
        }
    };
    if let Some(mimic) = element.child("mimic") {
        return Err(mimic.wrong(
            format!("joint `{name}` follows another one, which is not read"),
            "make it `fixed`, or delete `<mimic>` if a motor of its own moves it",
        ));
    }
    let axis = match element.child("axis") {
        Some(own) => {
            let axis = own.exactly("xyz")?.unwrap_or([1.0, 0.0, 0.0]);
            direction(axis).ok_or_else(|| own.wrong("this axis has no direction", "as in xyz=\"0 0 1\""))?
        }
        None => [1.0, 0.0, 0.0],
    };
    let of = |tag: &'static str, attribute: &str| match element.child(tag) {
        Some(own) => own.size(attribute),
        None => Ok(0.0),
    };
    let limit = |attribute: &str| match element.child("limit") {
        Some(own) => own.number(attribute),
        None => Ok(None),
    };
    let joint = Joint {
        name: (*name).to_owned(),
        motion,
        reference: 0.0,
        damping: of("dynamics", "damping")?,
        friction: of("dynamics", "friction")?,
        armature: 0.0,
        spring: (0.0, 0.0),
        range: limit("lower")?.zip(limit("upper")?).filter(|(low, high)| low < high),
        effort: limit("effort")?.filter(|effort| *effort > 0.0),
    };
    Ok(robot.add_joint((carrier, link), joint, (axis, [0.0; 3])))
}

/// Where an element stands: `<origin xyz="..." rpy="..."/>`.
fn origin(of: Element<'_>) -> Read<Frame> {
    let Some(own) = of.child("origin") else { return Ok(Frame::SAME) };
    let [roll, pitch, yaw] = own.exactly("rpy")?.unwrap_or_default().map(right_angle);
    let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let turn = product(&product(&turn(z, yaw), &turn(y, pitch)), &turn(x, roll));
    Ok(Frame { turn, origin: own.exactly("xyz")?.unwrap_or_default() })
}

/// The body of a link: nothing where the file has no inertia.
fn body(link: Element<'_>) -> Read<Body> {
    let Some(inertial) = link.child("inertial") else { return Ok(Body::default()) };
    let part = |tag: &'static str| {
        inertial.child(tag).ok_or_else(|| {
            inertial.wrong(
                format!("`<inertial>` has no `<{tag}>`"),
                "give mass and inertia, or leave `<inertial>` out",
            )
        })
    };
    let mass = part("mass")?.number("value")?.unwrap_or(0.0);
    let tensor = part("inertia")?;
    let entry = |name: &str| -> Read<f64> { Ok(tensor.number(name)?.unwrap_or(0.0)) };
    let [xx, xy, xz] = [entry("ixx")?, entry("ixy")?, entry("ixz")?];
    let [yy, yz, zz] = [entry("iyy")?, entry("iyz")?, entry("izz")?];
    let body = Body { mass, centre: [0.0; 3], inertia: [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]] };
    body.checked(inertial)?;
    Ok(body.seen_from(&origin(inertial)?))
}

/// What stands between motors and joints: `<transmission>`.
fn motors(root: Element<'_>, robot: &mut Robot) -> Read<()> {
    for transmission in root.children().filter(|e| e.is("transmission")) {
        let name = transmission.child("joint").and_then(|joint| joint.text("name"));
        let Some(joint) = robot.joints().position(|own| Some(own.name.as_str()) == name) else { continue };
        for motor in transmission.children().filter(|e| e.is("actuator")) {
            let ratio = motor.child("mechanicalReduction").and_then(|e| e.node.text());
            let gear = ratio.and_then(|text| text.trim().parse().ok()).filter(|gear: &f64| gear.is_normal());
            let name = motor.text("name").unwrap_or_default().to_owned();
            robot.motors.push(Motor { name, joint, gear: gear.unwrap_or(1.0) });
        }
    }
    Ok(())
}
