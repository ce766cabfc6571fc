//! Robots of other programs: URDF and MJCF to a tree of joints, and that to a spec.
//!
//! ```text
//! text --roxmltree--> Element --urdf, mjcf--> Robot: segments, joints, motors --Energies--> draft
//! ```

mod body;
mod draft;
mod energy;
mod frame;
mod geom;
mod log;
mod mjcf;
mod sum;
mod tree;
mod urdf;
mod write_back;
mod xml;

pub use log::Log;
use phisindy_expr::Span;
use phisindy_phys::{Diagnostic, SourceId};
use roxmltree::{Document, ParsingOptions};
pub use tree::{Joint, Motion, Robot};
pub use write_back::Refitted;
use xml::{Element, Read};

/// Most elements of a file.
const MOST_NODES: u32 = 1_000_000;
/// Most joints: a spec has at most a hundred states.
const MOST_JOINTS: usize = 50;

impl Robot {
    /// Reads a robot: URDF where the file begins with `<robot>`, MJCF where it begins with `<mujoco>`.
    ///
    /// # Errors
    /// What is broken, not there, or not to be had as joints with one coordinate in a tree, with its place.
    pub fn read(text: &str, source: SourceId) -> Result<Robot, Box<Diagnostic>> {
        let document = parsed(text, source)?;
        let root = Element::new(document.root_element(), source);
        let robot = match document.root_element().tag_name().name() {
            "robot" => urdf::read(root),
            "mujoco" => mjcf::read(root),
            other => Err(root.wrong(
                format!("`<{}>` is no robot", xml::shortened(other)),
                "URDF begins with `<robot>`, MJCF with `<mujoco>`",
            )),
        }?;
        robot.checked(root)
    }

    fn checked(self, root: Element<'_>) -> Read<Robot> {
        let count = self.segments.len();
        if count == 0 {
            return Err(root
                .wrong("nothing moves: there are no joints", "a draft needs a joint that turns or slides"));
        }
        if count > MOST_JOINTS {
            return Err(
                root.wrong(format!("{count} joints are too many"), format!("at most {MOST_JOINTS} are read"))
            );
        }
        let Some(k) = self.massless() else { return Ok(self) };
        let name = &self.segments[k].joint.name;
        let at = root.descendants().find(|e| e.is("joint") && e.text("name") == Some(name)).unwrap_or(root);
        Err(at.wrong(
            format!("joint `{name}` moves nothing that has a mass"),
            match self.format {
                "URDF" => "give a link behind it `<inertial>` with mass and inertia",
                _ => "give a body behind it `<inertial>`, a geom with a mass, or the joint `armature`",
            },
        ))
    }
}

/// The elements of a file.
fn parsed(text: &str, source: SourceId) -> Result<Document<'_>, Box<Diagnostic>> {
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|e| broken(text, source, &e))
}

/// A file that is no XML.
fn broken(text: &str, source: SourceId, error: &roxmltree::Error) -> Box<Diagnostic> {
    let at = error.pos();
    let start: usize = text.split_inclusive('\n').take(at.row.saturating_sub(1) as usize).map(str::len).sum();
    let line = text[start..].lines().next().unwrap_or_default();
    let column = line.char_indices().nth(at.col.saturating_sub(1) as usize).map_or(line.len(), |(k, _)| k);
    let span = Span::new(start + column, start + line.len().max(column));
    let words = error.to_string();
    let words = words.rsplit_once(" at ").map_or(words.as_str(), |(words, _)| words);
    let words = words.replace(['\n', '\r'], " ");
    let help = "mend the file there: tags are closed, attributes stand in quotes, `&` is written `&amp;`";
    Box::new(Diagnostic::error(format!("this is no XML: {words}")).at(source, span, "").help(help))
}
