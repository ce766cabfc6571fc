//! Inertia of the bodies that MJCF draws: <https://mujoco.readthedocs.io/en/stable/XMLreference.html#body-geom>.

use super::body::Body;
use super::frame::{Frame, Vector, add, direction, dot, scaled, with_shortest_turn};
use super::mjcf::{Chain, Compiler};
use super::xml::Read;
use std::f64::consts::PI;

/// What fills a body, if the file does not say it (kg/m^3).
const WATER: f64 = 1000.0;

/// The body that a geom draws, in the frame of its link; `None` where it has no mass.
pub(super) fn body(geom: &Chain<'_>, compiler: &Compiler) -> Read<Option<Body>> {
    let mass = geom.number("mass")?;
    let density = geom.number("density")?.unwrap_or(WATER);
    let kind = geom.text("type").unwrap_or("sphere");
    let weightless = mass.map_or(density == 0.0, |mass| mass == 0.0);
    if weightless || kind == "plane" {
        return Ok(None);
    }
    let is_mesh = matches!(kind, "mesh" | "sdf" | "hfield") || geom.text("mesh").is_some();
    if is_mesh {
        return Err(geom.own().wrong(
            "the inertia of a mesh is not read",
            "give the body `<inertial pos=\"...\" quat=\"...\" mass=\"...\" diaginertia=\"...\"/>`; MuJoCo knows them: \
             `model.body_ipos`, `body_iquat`, `body_mass`, `body_inertia`",
        ));
    }
    if geom.text("shellinertia") == Some("true") {
        return Err(geom
            .own()
            .wrong("the inertia of a shell is not read", "give the body `<inertial .../>`"));
    }
    let size = geom.numbers("size")?.unwrap_or_default();
    let ends: Option<[f64; 6]> = geom.exactly("fromto")?;
    let (frame, half) = match ends {
        Some([a, b, c, x, y, z]) => {
            let (from, to) = ([a, b, c], [x, y, z]);
            let way = add(from, scaled(to, -1.0));
            let middle = scaled(add(from, to), 0.5);
            let along = direction(way)
                .ok_or_else(|| geom.own().wrong("`fromto` is of no length", "give two points that differ"))?;
            (Frame { turn: with_shortest_turn(along), origin: middle }, Some(0.5 * dot(way, way).sqrt()))
        }
        None => (compiler.frame(geom)?, None),
    };
    let radius = |k: usize| size.get(k).copied().filter(|x| *x > 0.0);
    // Two points say the last length; across them MuJoCo takes the first size alone.
    let across_them = |k: usize| radius(if half.is_some() { 0 } else { k });
    let length = |k: usize| half.or_else(|| radius(k));
    let shape = match kind {
        "sphere" => radius(0).map(|r| (4.0 / 3.0 * PI * r.powi(3), [0.4 * r * r; 3])),
        "ellipsoid" => sides(radius(0), across_them(1), length(2))
            .map(|[a, b, c]| (4.0 / 3.0 * PI * a * b * c, across([a, b, c], 0.2))),
        "box" => sides(radius(0), across_them(1), length(2))
            .map(|[a, b, c]| (8.0 * a * b * c, across([a, b, c], 1.0 / 3.0))),
        "cylinder" => radius(0).zip(length(1)).map(|(r, h)| {
            let flat = (3.0 * r * r + 4.0 * h * h) / 12.0;
            (2.0 * PI * r * r * h, [flat, flat, 0.5 * r * r])
        }),
        "capsule" => radius(0).zip(length(1)).map(|(r, h)| {
            // A ball cut in two, and what is between the halves.
            let ball = 2.0 * r / (2.0 * r + 3.0 * h);
            let flat = (1.0 - ball) * (3.0 * r * r + 4.0 * h * h) / 12.0
                + ball * (0.4 * r * r + 0.25 * h * (3.0 * r + 4.0 * h));
            let long = (1.0 - ball) * 0.5 * r * r + ball * 0.4 * r * r;
            (PI * r * r * (4.0 / 3.0 * r + 2.0 * h), [flat, flat, long])
        }),
        other => {
            return Err(geom.own().wrong(
                format!("`{other}` is no geom whose inertia is known"),
                "there are sphere, capsule, ellipsoid, cylinder and box; else give the body `<inertial .../>`",
            ));
        }
    };
    let Some((volume, per_mass)) = shape else {
        return Err(geom.own().wrong(
            format!("this {kind} has not all of its sizes"),
            "`size` has the radius or the half sides, and the half length, all positive; or `fromto` two points",
        ));
    };
    let mass = mass.unwrap_or(density * volume);
    let inertia =
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { mass * per_mass[i] } else { 0.0 }));
    let body = Body { mass, centre: [0.0; 3], inertia };
    body.checked(geom.own())?;
    Ok(Some(body.seen_from(&frame)))
}

fn sides(a: Option<f64>, b: Option<f64>, c: Option<f64>) -> Option<Vector> {
    Some([a?, b?, c?])
}

/// Moments of inertia for each kilogram, of half sides.
fn across([a, b, c]: Vector, share: f64) -> Vector {
    [b * b + c * c, a * a + c * c, a * a + b * b].map(|square| share * square)
}
