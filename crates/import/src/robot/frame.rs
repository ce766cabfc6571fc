//! Vectors and frames of three dimensions.

/// A vector.
pub(super) type Vector = [f64; 3];
/// Rows of a matrix.
pub(super) type Matrix = [Vector; 3];

/// Beside one, what the last digits of a rotation leave of a zero.
const ROUNDING: f64 = 1e-12;

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn add(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|k| a[k] + b[k])
}

pub(super) fn scaled(a: Vector, by: f64) -> Vector {
    a.map(|x| x * by)
}

/// A vector of length one; none of what has no direction.
pub(super) fn direction(a: Vector) -> Option<Vector> {
    let length = dot(a, a).sqrt();
    (length.is_normal() && length > ROUNDING).then(|| scaled(a, 1.0 / length).map(without_rounding))
}

/// Entries of rotations that are zero or one but for rounding are so.
fn without_rounding(x: f64) -> f64 {
    if (x - x.round()).abs() < ROUNDING { x.round() + 0.0 } else { x }
}

pub(super) fn times(a: &Matrix, b: Vector) -> Vector {
    a.map(|row| dot(row, b))
}

pub(super) fn transposed(a: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}

pub(super) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let columns = transposed(b);
    a.map(|row| columns.map(|column| dot(row, column)))
}

/// The turn about an axis of length one (Rodrigues).
pub(super) fn turn(axis: Vector, angle: f64) -> Matrix {
    let (sin, cos) = angle.sin_cos();
    let across: Matrix = [[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]];
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let unit = f64::from(u8::from(i == j));
            without_rounding(unit * cos + across[i][j] * sin + axis[i] * axis[j] * (1.0 - cos))
        })
    })
}

/// The turn that a quaternion of any length is, its real part first.
pub(super) fn of_quaternion([w, x, y, z]: [f64; 4]) -> Option<Matrix> {
    let size = w * w + x * x + y * y + z * z;
    let entries = [
        [w * w + x * x - y * y - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ];
    size.is_normal().then(|| entries.map(|row| row.map(|entry| without_rounding(entry / size))))
}

/// The turn that brings the third axis to this direction by the shortest way.
pub(super) fn with_shortest_turn(axis: Vector) -> Matrix {
    let across = [-axis[1], axis[0], 0.0];
    let angle = dot(across, across).sqrt().atan2(axis[2]);
    turn(direction(across).unwrap_or([1.0, 0.0, 0.0]), angle)
}

/// A turn whose third axis is this direction, of the others one along a coordinate axis where that is possible.
pub(super) fn with_third_axis(axis: Vector) -> Matrix {
    let least = (0..3).min_by(|&i, &j| axis[i].abs().total_cmp(&axis[j].abs())).unwrap_or(0);
    let along: Vector = std::array::from_fn(|k| f64::from(u8::from(k == least)));
    // Perpendicular to a direction is at least one coordinate axis' part.
    let first = direction(cross(cross(axis, along), axis)).unwrap_or([1.0, 0.0, 0.0]);
    transposed(&[first, cross(axis, first).map(without_rounding), axis])
}

/// Where a frame stands in another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    /// Its axes, as columns.
    pub(super) turn: Matrix,
    /// Its origin.
    pub(super) origin: Vector,
}

impl Frame {
    pub(super) const SAME: Frame =
        Frame { turn: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], origin: [0.0; 3] };

    /// The point of this frame in the other one.
    pub(super) fn point(&self, of: Vector) -> Vector {
        add(self.origin, times(&self.turn, of))
    }

    /// A frame that stands in this one, in the other one.
    pub(super) fn frame(&self, of: &Frame) -> Frame {
        let turn = product(&self.turn, &of.turn).map(|row| row.map(without_rounding));
        Frame { turn, origin: self.point(of.origin) }
    }

    /// The other frame in this one.
    pub(super) fn inverse(&self) -> Frame {
        let turn = transposed(&self.turn);
        Frame { turn, origin: scaled(times(&turn, self.origin), -1.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_agree_however_they_are_said() {
        let axis = direction([1.0, -2.0, 0.5]).expect("a direction");
        let (sin, cos) = 0.35_f64.sin_cos();
        let by_quaternion =
            of_quaternion([cos, axis[0] * sin, axis[1] * sin, axis[2] * sin]).expect("a turn");
        let by_axis = turn(axis, 0.7);
        for (a, b) in by_quaternion.iter().flatten().zip(by_axis.iter().flatten()) {
            assert!((a - b).abs() < 1e-14, "{by_quaternion:?} {by_axis:?}");
        }
        let upright = with_third_axis(axis);
        let back = product(&transposed(&upright), &upright);
        assert!(
            back.iter().flatten().zip(Frame::SAME.turn.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-14)
        );
        assert_eq!(times(&upright, [0.0, 0.0, 1.0]), axis);
    }
}
