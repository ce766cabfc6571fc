//! A robot as a tree of joints, the common form of all formats.

use super::body::Body;
use super::frame::{Frame, Vector, direction, dot, with_third_axis};

/// What a joint lets its bodies do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// They turn about its axis.
    Turn,
    /// They slide along its axis.
    Slide,
}

/// A joint with one coordinate. Numbers are in SI and act on the coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// As in the file.
    pub name: String,
    /// What it lets its bodies do.
    pub motion: Motion,
    /// The coordinate where the bodies stand as the file draws them.
    pub(super) reference: f64,
    /// Viscous friction.
    pub damping: f64,
    /// Dry friction.
    pub friction: f64,
    /// Inertia of what turns faster behind a gear, as the joint feels it.
    pub armature: f64,
    /// Stiffness of a spring, and the coordinate where it rests.
    pub(super) spring: (f64, f64),
    /// Least and greatest coordinate.
    pub(super) range: Option<(f64, f64)>,
    /// Greatest force or torque.
    pub(super) effort: Option<f64>,
}

/// A motor in the file, for a log that holds what it was commanded.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Motor {
    pub(super) name: String,
    /// Number of its joint.
    pub(super) joint: usize,
    /// Force or torque of the joint for each unit of the command.
    pub(super) gear: f64,
}

/// A joint in its place: all that it moves stands in its frame, whose origin lies on its axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Segment {
    /// Number of the segment that carries it; none for what stands still.
    pub(super) parent: Option<usize>,
    /// Where its frame stands in that of the parent, at the reference.
    pub(super) frame: Frame,
    pub(super) joint: Joint,
    /// The coordinate axis along which the joint's axis points, and whether it points back.
    pub(super) axis: (usize, bool),
    /// Everything that is fixed to the frame.
    pub(super) body: Body,
}

/// A robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// As in the file.
    pub name: String,
    /// Name of the format.
    pub format: &'static str,
    pub(super) gravity: Vector,
    /// Each behind its parent.
    pub(super) segments: Vec<Segment>,
    pub(super) motors: Vec<Motor>,
    /// What a reader left out or took for granted.
    pub remarks: Vec<String>,
}

impl Robot {
    pub(super) fn new(name: &str, format: &'static str) -> Robot {
        let gravity = [0.0, 0.0, -9.81];
        Robot { name: name.to_owned(), format, gravity, segments: vec![], motors: vec![], remarks: vec![] }
    }

    /// The joints, in the order of their coordinates `q1`, `q2`, ...
    pub fn joints(&self) -> impl Iterator<Item = &Joint> {
        self.segments.iter().map(|segment| &segment.joint)
    }

    /// Adds a joint to what carries it: its axis and a point of that in the `frame` of a link, which stands so in what
    /// carries it. Returns what carries the link now.
    pub(super) fn add_joint(
        &mut self,
        (carrier, link): (Option<usize>, Frame),
        joint: Joint,
        (axis, point): (Vector, Vector),
    ) -> (Option<usize>, Frame) {
        let along = (0..3).find(|&k| (axis[k].abs() - 1.0).abs() == 0.0);
        let (turn, axis) = match along {
            Some(k) => (Frame::SAME.turn, (k, axis[k] < 0.0)),
            None => (with_third_axis(axis), (2, false)),
        };
        let own = Frame { turn, origin: point };
        let body = Body::default();
        self.segments.push(Segment { parent: carrier, frame: link.frame(&own), joint, axis, body });
        (Some(self.segments.len() - 1), own.inverse())
    }

    /// Fixes a body to what carries its link.
    pub(super) fn add_body(&mut self, (carrier, link): (Option<usize>, Frame), body: &Body) {
        if let Some(k) = carrier {
            self.segments[k].body = self.segments[k].body.with(&body.seen_from(&link));
        }
    }

    /// The first joint that moves nothing that has an inertia along it.
    pub(super) fn massless(&self) -> Option<usize> {
        let mut moves: Vec<bool> =
            self.segments.iter().map(|s| s.body.mass > 0.0 || s.joint.armature > 0.0).collect();
        let alone = |k: usize| {
            // A point of mass on the axis of a hinge does not resist.
            let Segment { body, axis: (axis, _), joint, .. } = &self.segments[k];
            let away: Vector = std::array::from_fn(|i| if i == *axis { 0.0 } else { body.centre[i] });
            let turns = body.inertia[*axis][*axis] + body.mass * dot(away, away);
            joint.armature > 0.0 || (joint.motion == Motion::Slide && body.mass > 0.0) || turns > 0.0
        };
        for k in (0..self.segments.len()).rev() {
            let carries = self.segments.iter().enumerate().any(|(j, s)| s.parent == Some(k) && moves[j]);
            moves[k] = carries || alone(k);
        }
        moves.iter().position(|moves| !moves)
    }

    /// The direction against gravity, and how strong that is.
    pub(super) fn up(&self) -> Option<(Vector, f64)> {
        let strength = dot(self.gravity, self.gravity).sqrt();
        direction(self.gravity).map(|down| (down.map(|x| 0.0 - x), strength))
    }
}
