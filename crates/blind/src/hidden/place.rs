//! Places where an effect can act: on a mass, between two masses, or between a mass and the moving wall.

use super::rig::{Drive, Rig};

/// A velocity with its displacement.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Place {
    /// As `gap` writes it.
    pub(super) at: String,
    /// Displacement and velocity as text.
    pub(super) x: String,
    pub(super) v: String,
    /// The same as a sum: masses with factors, and the factor of the wall.
    pub(super) parts: Vec<(usize, f64)>,
    pub(super) wall: f64,
    /// The spring of the model that acts exactly here.
    pub(super) spring: Option<f64>,
}

/// All places of a rig.
pub(super) fn places(rig: &Rig) -> Vec<Place> {
    let base = matches!(rig.drive, Drive::Base { .. });
    let count = rig.count();
    let wall_spring = |mass: usize| match mass {
        0 => Some(rig.spring[0]),
        _ => rig.spring.get(2).copied(),
    };
    let mut all = Vec::new();
    for mass in 0..count {
        let (x, v) = (&rig.x[mass], &rig.v[mass]);
        all.push(Place {
            at: v.clone(),
            x: x.clone(),
            v: v.clone(),
            parts: vec![(mass, 1.0)],
            wall: 0.0,
            spring: wall_spring(mass).filter(|_| !base),
        });
        if base {
            all.push(Place {
                at: format!("{v}-du"),
                x: format!("({x}-u)"),
                v: format!("({v}-du)"),
                parts: vec![(mass, 1.0)],
                wall: -1.0,
                spring: wall_spring(mass),
            });
        }
    }
    if count == 2 {
        let (x, v) = (&rig.x, &rig.v);
        all.push(Place {
            at: format!("{}-{}", v[0], v[1]),
            x: format!("({}-{})", x[0], x[1]),
            v: format!("({}-{})", v[0], v[1]),
            parts: vec![(0, 1.0), (1, -1.0)],
            wall: 0.0,
            spring: Some(rig.spring[1]),
        });
    }
    all
}

/// The canonical form of a place: `v2-v1` and `v1-v2` are the same.
pub(super) fn same_place(at: &str) -> String {
    let mut parts: Vec<&str> = at.split('-').map(str::trim).collect();
    parts.sort_unstable();
    parts.join("-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_a_difference_does_not_matter() {
        assert_eq!(same_place("v2 - v1"), same_place("v1-v2"));
        assert_ne!(same_place("v1"), same_place("v1-v2"));
    }
}
