//! The frame that a body moves in: an object's transform, cut into what is rigid and what is not.

use etendue::math::{DAffine3, DMat3, DQuat, DVec3};

/// How far from right angles axes may be and still count as such.
const SKEW: f64 = 1e-9;

/// `world = rotation * (stretch * (p - center)) + translation` for points `p` of the object.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// The body's rotation at the start.
    pub rotation: DQuat,
    /// The body's position at the start, metres.
    pub translation: DVec3,
    /// Of the object's own space; the body's shape is what comes of it.
    pub stretch: DMat3,
    /// Point of the object that is the origin of the body.
    pub center: DVec3,
    /// `stretch` only scales along the axes.
    pub is_diagonal: bool,
}

impl Frame {
    /// Of an object whose own space has its middle at `center`.
    pub fn new(transform: &DAffine3, center: DVec3) -> Self {
        let matrix = transform.matrix3;
        let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
        let lengths = axes.map(DVec3::length);
        let [x, y, z] = [0, 1, 2].map(|i| axes[i] / lengths[i]);
        let is_diagonal = [x.dot(y), y.dot(z), z.dot(x)].iter().all(|cos| cos.abs() <= SKEW);
        let translation = transform.transform_point3(center);
        if !is_diagonal {
            return Self { rotation: DQuat::IDENTITY, translation, stretch: matrix, center, is_diagonal };
        }
        // A reflection stays in the stretch.
        let sign = if x.cross(y).dot(z) < 0.0 { -1.0 } else { 1.0 };
        let rotation = DQuat::from_mat3(&DMat3::from_cols(x, y, z * sign)).normalize();
        let scale = DVec3::new(rounded(lengths[0]), rounded(lengths[1]), rounded(lengths[2]) * sign);
        Self { rotation, translation, stretch: DMat3::from_diagonal(scale), center, is_diagonal }
    }

    /// A point of the object in the body's space.
    pub fn local(&self, p: DVec3) -> DVec3 {
        self.stretch * (p - self.center)
    }

    /// The factor, if lengths are all stretched alike.
    pub fn uniform(&self) -> Option<f64> {
        let scale = [self.stretch.x_axis.x, self.stretch.y_axis.y, self.stretch.z_axis.z].map(f64::abs);
        (self.is_diagonal && scale.iter().all(|s| (s - scale[0]).abs() <= SKEW * scale[0])).then_some(scale[0])
    }
}

/// Without the last bits, in which turned copies of one thing differ.
fn rounded(x: f64) -> f64 {
    const KEPT: u64 = !0 << 12;
    f64::from_bits((x.to_bits() + (1 << 11)) & KEPT)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_put_points_where_the_transform_does() {
        let turned = DMat3::from_quat(DQuat::from_xyzw(0.5, -0.1, 0.3, 0.4).normalize());
        let skewed = DMat3::from_cols(DVec3::X, DVec3::new(0.3, 1.0, 0.0), DVec3::Z);
        for (linear, is_diagonal) in [
            (DMat3::IDENTITY, true),
            (turned, true),
            (turned * DMat3::from_diagonal(DVec3::new(2.0, 3.0, -0.5)), true),
            (turned * skewed, false),
        ] {
            let transform = DAffine3 { matrix3: linear, translation: DVec3::new(5.0, -7.0, 1e3) };
            let frame = Frame::new(&transform, DVec3::new(0.5, 1.0, 2.0));
            assert_eq!(frame.is_diagonal, is_diagonal);
            for p in [DVec3::ZERO, DVec3::new(1.0, 2.0, -3.0)] {
                let there = frame.rotation * frame.local(p) + frame.translation;
                assert!((there - transform.transform_point3(p)).length() < 1e-10);
            }
        }
    }

    #[test]
    fn copies_that_are_turned_have_one_shape() {
        let stretch = |tilt: f64| {
            let turn = DQuat::from_xyzw(0.3, tilt, -0.2, 1.0).normalize();
            let linear = DMat3::from_quat(turn) * DMat3::from_diagonal(DVec3::new(0.1, 0.7, 1.3));
            Frame::new(&DAffine3 { matrix3: linear, translation: DVec3::ZERO }, DVec3::ZERO).stretch
        };
        assert!((1..50).all(|k| stretch(0.02 * f64::from(k)) == stretch(0.0)));
    }
}
