//! The laws that come with the program. A test compares this table with the folder `specs/laws`.

/// Id and text of each law.
#[rustfmt::skip]
pub(super) const LAWS: &[(&str, &str)] = &[
    ("asymmetric-coulomb", include_str!("../../../../specs/laws/asymmetric-coulomb.ron")),
    ("coulomb", include_str!("../../../../specs/laws/coulomb.ron")),
    ("cubic-stiffness", include_str!("../../../../specs/laws/cubic-stiffness.ron")),
    ("dead-zone", include_str!("../../../../specs/laws/dead-zone.ron")),
    ("dieterich-ruina", include_str!("../../../../specs/laws/dieterich-ruina.ron")),
    ("harmonic-force", include_str!("../../../../specs/laws/harmonic-force.ron")),
    ("offset", include_str!("../../../../specs/laws/offset.ron")),
    ("one-sided-stop", include_str!("../../../../specs/laws/one-sided-stop.ron")),
    ("parametric-stiffness", include_str!("../../../../specs/laws/parametric-stiffness.ron")),
    ("position-dependent-friction", include_str!("../../../../specs/laws/position-dependent-friction.ron")),
    ("presliding", include_str!("../../../../specs/laws/presliding.ron")),
    ("quadratic-drag", include_str!("../../../../specs/laws/quadratic-drag.ron")),
    ("quadratic-stiffness", include_str!("../../../../specs/laws/quadratic-stiffness.ron")),
    ("sensor-delay", include_str!("../../../../specs/laws/sensor-delay.ron")),
    ("sensor-gain", include_str!("../../../../specs/laws/sensor-gain.ron")),
    ("sensor-offset", include_str!("../../../../specs/laws/sensor-offset.ron")),
    ("stiffness", include_str!("../../../../specs/laws/stiffness.ron")),
    ("stribeck", include_str!("../../../../specs/laws/stribeck.ron")),
    ("van-der-pol", include_str!("../../../../specs/laws/van-der-pol.ron")),
    ("viscous", include_str!("../../../../specs/laws/viscous.ron")),
];
