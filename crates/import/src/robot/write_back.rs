//! Friction of joints written into the file of a robot, which stays as it is otherwise.

use super::sum::decimal;
use super::tree::Robot;
use super::xml::{Element, Read};
use phisindy_phys::{Diagnostic, SourceId};
use std::ops::Range;

/// Elements in which a joint is one.
const CARRIERS: &[&str] = &["robot", "body", "frame"];

/// What a joint gets.
#[derive(Clone, Debug, PartialEq)]
pub struct Refitted {
    /// Name of the joint.
    pub joint: String,
    /// Dry friction (N or N m).
    pub dry: f64,
    /// Viscous friction (N s/m or N m s).
    pub viscous: f64,
    /// Inertia behind a gear (kg or kg m^2), where it is known.
    pub armature: Option<f64>,
}

impl Robot {
    /// The text of the robot with the friction of some joints in the place of its own; names the joints that it does not
    /// find.
    ///
    /// # Errors
    /// As [`Robot::read`].
    pub fn with_friction(
        text: &str,
        source: SourceId,
        joints: &[Refitted],
    ) -> Result<(String, Vec<String>), Box<Diagnostic>> {
        let robot = Robot::read(text, source)?;
        let document = super::parsed(text, source)?;
        let root = Element::new(document.root_element(), source);
        let (mut edits, mut lost) = (vec![], vec![]);
        for joint in joints {
            let named = |e: &Element<'_>| {
                // Motors and transmissions name joints, too.
                let carries = e.node.parent().is_some_and(|p| CARRIERS.contains(&p.tag_name().name()));
                e.is("joint") && carries && e.text("name") == Some(&joint.joint)
            };
            match root.descendants().find(named) {
                Some(element) if robot.format == "MJCF" => mjcf(element, joint, &mut edits),
                Some(element) => urdf(element, joint, &mut edits)?,
                None => lost.push(joint.joint.clone()),
            }
        }
        edits.sort_by_key(|(range, _)| range.start);
        let mut written = text.to_owned();
        for (range, words) in edits.into_iter().rev() {
            written.replace_range(range, &words);
        }
        Ok((written, lost))
    }
}

/// What is replaced by what.
type Edits = Vec<(Range<usize>, String)>;

fn mjcf(element: Element<'_>, joint: &Refitted, edits: &mut Edits) {
    // What a class says holds where the joint says nothing.
    set(element, "damping", joint.viscous, edits);
    set(element, "frictionloss", joint.dry, edits);
    if let Some(armature) = joint.armature {
        set(element, "armature", armature, edits);
    }
}

fn urdf(element: Element<'_>, joint: &Refitted, edits: &mut Edits) -> Read<()> {
    if let Some(dynamics) = element.child("dynamics") {
        set(dynamics, "damping", joint.viscous, edits);
        set(dynamics, "friction", joint.dry, edits);
        return Ok(());
    }
    let last = element
        .children()
        .last()
        .ok_or_else(|| element.wrong("this joint holds nothing", "add its links"))?;
    let end = last.node.range().end;
    let words = format!(
        "<dynamics damping=\"{}\" friction=\"{}\"/>",
        six_digits(joint.viscous),
        six_digits(joint.dry)
    );
    edits.push((end..end, words));
    Ok(())
}

/// No friction is known better.
fn six_digits(x: f64) -> String {
    decimal(format!("{x:.5e}").parse().unwrap_or(x))
}

/// Gives an attribute a number.
fn set(element: Element<'_>, attribute: &str, number: f64, edits: &mut Edits) {
    let number = six_digits(number);
    match element.node.attribute_node(attribute) {
        Some(own) => edits.push((own.range_value(), number)),
        None => {
            // Behind the last attribute, or else the name of the tag.
            let name = element.node.range().start + 1 + element.node.tag_name().name().len();
            let at = element.node.attributes().next_back().map_or(name, |a| a.range().end);
            edits.push((at..at, format!(" {attribute}=\"{number}\"")));
        }
    }
}
