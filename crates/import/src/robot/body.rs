//! A rigid body: its mass, where that is, and how it resists a turn.

use super::frame::{Frame, Matrix, Vector, add, dot, product, scaled, transposed};
use super::xml::{Element, Read};

/// How far below zero what is zero may come by the digits of a file.
const ROUNDING: f64 = 1e-6;

/// A rigid body in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Body {
    /// In kg.
    pub(super) mass: f64,
    /// Centre of mass.
    pub(super) centre: Vector,
    /// Moments and products of inertia about the centre of mass, along the axes of the frame.
    pub(super) inertia: Matrix,
}

impl Body {
    /// The same body in the frame in which its own frame stands.
    pub(super) fn seen_from(&self, own: &Frame) -> Body {
        let inertia = product(&product(&own.turn, &self.inertia), &transposed(&own.turn));
        Body { mass: self.mass, centre: own.point(self.centre), inertia }
    }

    /// The two as one body (the theorem of parallel axes; H. Goldstein, Classical Mechanics, 3rd ed., 5.3).
    pub(super) fn with(&self, other: &Body) -> Body {
        let mass = self.mass + other.mass;
        if mass == 0.0 {
            return *self;
        }
        let centre =
            scaled(add(scaled(self.centre, self.mass), scaled(other.centre, other.mass)), 1.0 / mass);
        let [own, others] = [self, other].map(|body| {
            let away = add(body.centre, scaled(centre, -1.0));
            let square = dot(away, away);
            let shifted: Matrix = std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    let unit = if i == j { square } else { 0.0 };
                    body.inertia[i][j] + body.mass * (unit - away[i] * away[j])
                })
            });
            shifted
        });
        Body { mass, centre, inertia: std::array::from_fn(|i| add(own[i], others[i])) }
    }

    /// Whether matter may have such an inertia: no axis is one about which it does not resist.
    pub(super) fn checked(&self, at: Element<'_>) -> Read<()> {
        let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = self.inertia;
        let det = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
        let minors = [
            (xx, 1),
            (yy, 1),
            (zz, 1),
            (xx * yy - xy * xy, 2),
            (xx * zz - xz * xz, 2),
            (yy * zz - yz * yz, 2),
            (det, 3),
        ];
        let size = (xx + yy + zz).abs();
        if self.mass < 0.0 || !self.mass.is_finite() {
            return Err(
                at.wrong(format!("a mass is not negative, and this is {}", self.mass), "look at its sign")
            );
        }
        if minors.iter().any(|&(minor, power)| minor < -ROUNDING * size.powi(power)) {
            return Err(at.wrong(
                "no body has such an inertia: about some axis it would not resist",
                "the moments are positive, and the products are smaller: look at signs, units and the order of the entries",
            ));
        }
        Ok(())
    }
}
