//! Rigid motion while the shutter is open.
//!
//! # The box around a moving box
//!
//! On a segment between two keys a point of the object is at f(s) = T + s D + R(s a) q, with a rotation R about a fixed axis
//! by the angle s a, s in [0, 1], and q fixed. Over a part of it whose angle is h, f differs from the straight line between its
//! values at the part's ends by at most max |f''| / 8 with respect to the part, coordinate by coordinate: the shift is
//! straight, and a coordinate of the rest is a constant plus a sinusoid of amplitude r, so that is r h^2 / 8. On axis i of
//! space, r is the distance of q from the axis of rotation times the sine of the angle between that axis and i. So all of
//! the object's box stays in the boxes at both ends of the part, joined and grown by the largest r h^2 / 8 of its points.
//! Transforms are rounded to f32, which moves points by at most u (||M|| E' + |T|), in the terms of `padding.rs`: boxes are
//! grown by that too.

use crate::bounds::Bounds;
use crate::geometry::Transform;
use crate::padding::Stretch;

/// Where something rigid is at a time: rotated about the origin of the world, then shifted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidKey {
    /// Shutter time in [0, 1].
    pub time: f64,
    /// A quaternion (x, y, z, w) of any length but 0.
    pub rotation: [f64; 4],
    /// Metres.
    pub translation: [f64; 3],
}

/// Where an object is while the shutter is open: `world = pose(time) * base`, the poses between two keys joined by a straight
/// shift and a rotation at constant speed about one axis, the shorter way (Shoemake, "Animating rotation with quaternion
/// curves", 1985), all in f64 and rounded to f32 once.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    base: Base,
    segments: Box<[Segment]>,
    /// The largest distance of keys from the origin.
    farthest: f64,
}

/// The map that poses are applied to.
#[derive(Clone, Debug, PartialEq)]
struct Base {
    linear: [[f64; 3]; 3],
    shift: [f64; 3],
    inverse: [[f64; 3]; 3],
    /// Largest row sum of what the product of `linear` and `inverse` lacks of the identity.
    residual: f64,
    /// Bounds of the spectral norms of `linear` and `inverse`.
    norms: [f64; 2],
}

/// Between two keys.
#[derive(Clone, Debug, PartialEq)]
struct Segment {
    start: f64,
    /// One over the duration; 0 for the only key.
    rate: f64,
    /// Unit quaternion at the start.
    rotation: [f64; 4],
    /// Unit vector.
    axis: [f64; 3],
    /// Half of the angle about the axis, up to a quarter turn.
    half_angle: f64,
    shift: [f64; 3],
    drift: [f64; 3],
}

/// Rotation (rows) and shift.
type Pose = ([[f64; 3]; 3], [f64; 3]);

/// Parts that a box is followed over turn by at most this, radians.
const COARSEST: f64 = 0.2;

/// Most parts of a segment that a box is followed over.
const MOST_PARTS: f64 = 64.0;

/// Boxes are followed so finely that they grow by no more than this share of their size, if that takes no more parts.
const GROWTH: f64 = 0.02;

impl Motion {
    /// Prepares a motion. Rows of `base` are those of a 3x4 matrix. Times have to be strictly ascending; before the first and
    /// after the last the object rests. `None` if they are not, a number is not finite, a rotation is 0, there is no key, or
    /// `base` has no inverse.
    pub fn new(base: [[f64; 4]; 3], keys: &[RigidKey]) -> Option<Self> {
        let in_order = keys.windows(2).all(|pair| pair[0].time < pair[1].time);
        let finite = |key: &RigidKey| {
            let numbers = key.rotation.iter().chain(&key.translation);
            key.time.is_finite() && numbers.into_iter().all(|x| x.is_finite())
        };
        if !in_order || !keys.iter().all(finite) {
            return None;
        }
        let units = keys.iter().map(|key| unit(key.rotation)).collect::<Option<Vec<_>>>()?;
        let segments: Vec<Segment> = match keys {
            [] => return None,
            [only] => vec![Segment::resting(only, units[0])],
            _ => keys
                .windows(2)
                .zip(units.windows(2))
                .map(|(keys, units)| Segment::between(&keys[0], &keys[1], [units[0], units[1]]))
                .collect(),
        };
        let farthest = keys.iter().map(|key| length(key.translation)).fold(0.0, f64::max);
        Some(Self { base: Base::new(base)?, segments: segments.into(), farthest })
    }

    /// The map to the world at a time, with its inverse; times outside of [0, 1] and NaN count as the nearest or 0.
    // Kept out of loops over rays, few of which come to moving things.
    #[inline(never)]
    pub fn at(&self, time: f32) -> Transform {
        let pose = self.pose(time);
        Transform { to_world: self.to_world(&pose).map(|row| row.map(|x| x as f32)), to_object: self.to_object(&pose) }
    }

    /// The map to the world at a time, rows in f64; see [`Self::at`].
    pub fn rows_at(&self, time: f32) -> [[f64; 4]; 3] {
        self.to_world(&self.pose(time))
    }

    /// The inverse of the map at a time alone: the same bits as [`Self::at`] gives.
    #[inline(never)]
    pub(crate) fn to_object_at(&self, time: f32) -> [[f32; 4]; 3] {
        self.to_object(&self.pose(time))
    }

    #[inline(always)]
    fn pose(&self, time: f32) -> Pose {
        // NaN is not above 0.
        let time = if time > 0.0 { f64::from(if time < 1.0 { time } else { 1.0 }) } else { 0.0 };
        let after = self.segments.partition_point(|segment| segment.start <= time);
        let segment = &self.segments[after.saturating_sub(1)];
        let share = (time - segment.start) * segment.rate;
        segment.pose(if share > 0.0 { if share < 1.0 { share } else { 1.0 } } else { 0.0 })
    }

    #[inline(always)]
    fn to_world(&self, (rotation, shift): &Pose) -> [[f64; 4]; 3] {
        let linear = product(rotation, &self.base.linear);
        let base_shift = image(rotation, self.base.shift);
        std::array::from_fn(|r| [linear[r][0], linear[r][1], linear[r][2], base_shift[r] + shift[r]])
    }

    #[inline(always)]
    fn to_object(&self, (rotation, shift): &Pose) -> [[f32; 4]; 3] {
        let back: [[f64; 3]; 3] = std::array::from_fn(|r| std::array::from_fn(|c| rotation[c][r]));
        let linear = product(&self.base.inverse, &back);
        let base_shift = image(rotation, self.base.shift);
        let shift = image(&linear, std::array::from_fn(|r| base_shift[r] + shift[r]));
        std::array::from_fn(|r| [linear[r][0] as f32, linear[r][1] as f32, linear[r][2] as f32, -shift[r] as f32])
    }

    /// What the world box of an object box is at all times together.
    pub(crate) fn bounds_to_world(&self, bounds: &Bounds) -> Bounds {
        if bounds.is_empty() {
            return Bounds::EMPTY;
        }
        let object = MovingBox::of(bounds);
        let mut around = Around { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };
        self.segments.iter().for_each(|segment| self.grow(segment, &object, &mut around));
        let Stretch { forth, .. } = self.stretch();
        let rounding = f64::from(f32::EPSILON) * (forth * f64::from(bounds.reach()) + self.reach());
        Bounds::around(around.min.map(|x| x - rounding), around.max.map(|x| x + rounding))
    }

    /// Adds where a box comes on a segment.
    fn grow(&self, segment: &Segment, object: &MovingBox, around: &mut Around) {
        let linear = product(&matrix(segment.rotation), &self.base.linear);
        let base_shift = image(&matrix(segment.rotation), self.base.shift);
        // The largest distance of a point of the box from the axis.
        let center = image(&linear, object.center);
        let mut radius = length(cross(segment.axis, std::array::from_fn(|a| center[a] + base_shift[a])));
        let mut size = 0.0;
        for (column, half) in transposed(&linear).into_iter().zip(object.half) {
            radius += half * length(cross(segment.axis, column));
            size += 2.0 * half * length(column);
        }
        let angle = 2.0 * segment.half_angle;
        let finest = (angle * (radius / (8.0 * GROWTH * size)).sqrt()).min(MOST_PARTS);
        let parts = (angle / COARSEST).max(finest).ceil().max(1.0);
        let step = angle / parts;
        // A little more than the proof needs, for what f64 rounds.
        let bulge = 1.001 * radius * step * step / 8.0;
        let slack: [f64; 3] = segment.axis.map(|x| bulge * (1.0 - x * x).max(0.0).sqrt());
        let slack = slack.map(|x| x + 1e-12 * (radius + self.reach()));
        for part in 0..=parts as u32 {
            let to_world = self.to_world(&segment.pose(f64::from(part) / parts));
            around.add(&to_world, object, slack);
        }
    }

    /// How far shifts reach, to the world.
    fn reach(&self) -> f64 {
        length(self.base.shift) + self.farthest
    }

    /// Bounds at all times, for padding. A rotation changes the largest row sum of a matrix by at most the root of 3 over its
    /// spectral norm, which it leaves alone; `to_world` and `to_object` are rounded each on its own.
    pub(crate) fn stretch(&self) -> Stretch {
        const ROOT_3: f64 = 1.732_050_8;
        const U: f64 = 1.0 / (1 << 24) as f64;
        let [forth, back] = self.base.norms.map(|norm| ROOT_3 * norm * (1.0 + 2.0 * U));
        let (reach, lacking) = (self.reach(), 3.0 * self.base.residual);
        let back_shift = back * reach;
        Stretch {
            forth,
            back,
            back_shift,
            residual: 2.1 * U * forth * back + lacking,
            residual_shift: 2.1 * U * forth * back_shift + (U + lacking) * reach,
        }
    }

    /// True if points farther from the origin than a bound, or scales beyond another or its reciprocal, may come up.
    pub(crate) fn exceeds(&self, farthest: f64, scale: f64) -> bool {
        let Stretch { forth, back, back_shift, .. } = self.stretch();
        !(forth <= scale && back <= scale && back_shift <= farthest && self.reach() <= farthest)
    }
}

/// An object box in f64.
struct MovingBox {
    center: [f64; 3],
    half: [f64; 3],
}

impl MovingBox {
    fn of(bounds: &Bounds) -> Self {
        let ends = |a: usize| (f64::from(bounds.min[a]), f64::from(bounds.max[a]));
        let middle = |(low, high): (f64, f64)| 0.5 * (low + high);
        let half = |(low, high): (f64, f64)| 0.5 * (high - low);
        Self { center: [0, 1, 2].map(|a| middle(ends(a))), half: [0, 1, 2].map(|a| half(ends(a))) }
    }
}

/// A world box that grows.
struct Around {
    min: [f64; 3],
    max: [f64; 3],
}

impl Around {
    fn add(&mut self, to_world: &[[f64; 4]; 3], object: &MovingBox, slack: [f64; 3]) {
        for (axis, row) in to_world.iter().enumerate() {
            let (mut middle, mut half) = (row[3], slack[axis]);
            for (x, (center, reach)) in row.iter().zip(object.center.iter().zip(object.half)) {
                middle += x * center;
                half += x.abs() * reach;
            }
            self.min[axis] = self.min[axis].min(middle - half);
            self.max[axis] = self.max[axis].max(middle + half);
        }
    }
}

impl Base {
    fn new(rows: [[f64; 4]; 3]) -> Option<Self> {
        let linear = rows.map(|[x, y, z, _]| [x, y, z]);
        let [a, b, c]: [[f64; 3]; 3] = [0, 1, 2].map(|column| linear.map(|row| row[column]));
        let rows_of_inverse = [cross(b, c), cross(c, a), cross(a, b)];
        let det = dot(a, rows_of_inverse[0]);
        let inverse = rows_of_inverse.map(|row| row.map(|x| x / det));
        let shift = rows.map(|row| row[3]);
        let numbers = linear.iter().chain(&inverse).chain([&shift]).flatten();
        if det == 0.0 || !numbers.into_iter().all(|x| x.is_finite()) {
            return None;
        }
        let mut lacking = product(&linear, &inverse);
        (0..3).for_each(|i| lacking[i][i] -= 1.0);
        let norms = [&linear, &inverse].map(|m| (row_sum(m) * row_sum(&transposed(m))).sqrt());
        Some(Self { linear, shift, inverse, residual: row_sum(&lacking), norms })
    }
}

impl Segment {
    fn resting(key: &RigidKey, rotation: [f64; 4]) -> Self {
        let (start, shift) = (key.time, key.translation);
        Self { start, rate: 0.0, rotation, axis: [0.0, 0.0, 1.0], half_angle: 0.0, shift, drift: [0.0; 3] }
    }

    fn between(from: &RigidKey, to: &RigidKey, [a, b]: [[f64; 4]; 2]) -> Self {
        let [x, y, z, w] = times(b, [-a[0], -a[1], -a[2], a[3]]);
        let sign = if w < 0.0 { -1.0 } else { 1.0 };
        let turn = [x, y, z].map(|v| v * sign);
        let sine = length(turn);
        let resting = Self::resting(from, a);
        Self {
            rate: 1.0 / (to.time - from.time),
            axis: if sine > 0.0 { turn.map(|v| v / sine) } else { resting.axis },
            half_angle: libm::atan2(sine, w.abs()),
            drift: std::array::from_fn(|i| to.translation[i] - from.translation[i]),
            ..resting
        }
    }

    #[inline(always)]
    fn pose(&self, share: f64) -> Pose {
        let [sine, cosine] = sine_and_cosine(self.half_angle * share);
        let [x, y, z] = self.axis;
        let rotation = times([x * sine, y * sine, z * sine, cosine], self.rotation);
        (matrix(rotation), std::array::from_fn(|i| self.shift[i] + self.drift[i] * share))
    }
}

/// Of an angle in [0, pi/2], from Taylor polynomials of its half, to 2^-52: the same bits everywhere, without branches.
#[inline(always)]
fn sine_and_cosine(angle: f64) -> [f64; 2] {
    const SINE: [f64; 8] = [
        1.0,
        -1.0 / 6.0,
        1.0 / 120.0,
        -1.0 / 5_040.0,
        1.0 / 362_880.0,
        -1.0 / 39_916_800.0,
        1.0 / 6_227_020_800.0,
        -1.0 / 1_307_674_368_000.0,
    ];
    const COSINE: [f64; 8] = [
        0.5,
        -1.0 / 24.0,
        1.0 / 720.0,
        -1.0 / 40_320.0,
        1.0 / 3_628_800.0,
        -1.0 / 479_001_600.0,
        1.0 / 87_178_291_200.0,
        -1.0 / 20_922_789_888_000.0,
    ];
    let half = 0.5 * angle;
    let square = half * half;
    let polynomial = |of: &[f64; 8]| of.iter().rev().fold(0.0, |sum, c| sum * square + c);
    let (sine, versine) = (half * polynomial(&SINE), square * polynomial(&COSINE));
    [2.0 * sine * (1.0 - versine), 1.0 - 2.0 * sine * sine]
}

fn unit(q: [f64; 4]) -> Option<[f64; 4]> {
    let largest = q.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    if largest == 0.0 {
        return None;
    }
    let q = q.map(|x| x / largest);
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    Some(q.map(|x| x / length))
}

/// The product of quaternions: `b` first.
#[inline(always)]
fn times(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    let ([ax, ay, az, aw], [bx, by, bz, bw]) = (a, b);
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}

/// Rows of a unit quaternion's rotation.
#[inline(always)]
fn matrix([x, y, z, w]: [f64; 4]) -> [[f64; 3]; 3] {
    let (x2, y2, z2) = (x + x, y + y, z + z);
    [
        [1.0 - (y * y2 + z * z2), x * y2 - w * z2, x * z2 + w * y2],
        [x * y2 + w * z2, 1.0 - (x * x2 + z * z2), y * z2 - w * x2],
        [x * z2 - w * y2, y * z2 + w * x2, 1.0 - (x * x2 + y * y2)],
    ]
}

#[inline(always)]
fn product(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|r| std::array::from_fn(|c| a[r][0] * b[0][c] + a[r][1] * b[1][c] + a[r][2] * b[2][c]))
}

#[inline(always)]
fn image(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|r| dot(m[r], v))
}

#[inline(always)]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(v: [f64; 3]) -> f64 {
    dot(v, v).sqrt()
}

fn transposed(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|r| std::array::from_fn(|c| m[c][r]))
}

fn row_sum(m: &[[f64; 3]; 3]) -> f64 {
    m.iter().map(|row| row.iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max)
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)]
mod tests {
    use super::*;

    const UNIT: [[f64; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

    fn random() -> impl FnMut(f64) -> f64 {
        let mut state = 9_u64;
        move |reach| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            reach * ((state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0)
        }
    }

    fn about(axis: [f64; 3], angle: f64) -> [f64; 4] {
        let sine = (0.5 * angle).sin() / length(axis);
        [axis[0] * sine, axis[1] * sine, axis[2] * sine, (0.5 * angle).cos()]
    }

    #[test]
    fn turns_and_shifts_at_constant_speed() {
        for angle in [0.0_f64, 1e-9, 0.3, 2.0, 3.0, std::f64::consts::PI] {
            let keys = [
                RigidKey { time: 0.25, rotation: about([0.0, 0.0, 1.0], 0.5), translation: [0.0; 3] },
                RigidKey { time: 0.75, rotation: about([0.0, 0.0, 1.0], 0.5 + angle), translation: [2.0, 0.0, 4.0] },
            ];
            let motion = Motion::new([[2.0, 0.0, 0.0, 1.0], UNIT[1], UNIT[2]], &keys).unwrap();
            for (time, share) in [(0.0, 0.0), (0.25, 0.0), (0.35, 0.2), (0.5, 0.5), (0.7, 0.9), (0.75, 1.0), (1.0, 1.0)]
            {
                let at = 0.5 + share * angle;
                let found = motion.at(time as f32);
                let expected = [3.0 * at.cos() + 2.0 * share, 3.0 * at.sin(), 4.0 * share + 1.0];
                let p = found.point_to_world([1.0, 0.0, 1.0]);
                assert!(
                    (0..3).all(|a| (f64::from(p[a]) - expected[a]).abs() < 1e-6),
                    "{angle} {time} {p:?} {expected:?}"
                );
                let back = found.point_to_object(p);
                assert!((0..3).all(|a| (back[a] - [1.0, 0.0, 1.0][a]).abs() < 1e-5), "{back:?}");
                assert_eq!(found.to_object, motion.to_object_at(time as f32));
            }
        }
    }

    #[test]
    fn sines_are_right() {
        for i in 0..=1000 {
            let angle = f64::from(i) * 1e-3 * std::f64::consts::FRAC_PI_2;
            let [sine, cosine] = sine_and_cosine(angle);
            assert!((sine - angle.sin()).abs() < 4e-16 && (cosine - angle.cos()).abs() < 4e-16, "{angle}");
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let key = |time: f64, w: f64| RigidKey { time, rotation: [0.0, 0.0, 0.0, w], translation: [0.0; 3] };
        assert!(Motion::new(UNIT, &[key(0.0, 1.0)]).is_some());
        assert!(Motion::new(UNIT, &[key(0.0, 1.0), key(1.0, 1e-200)]).is_some());
        let flat = [UNIT[0], UNIT[1], [0.0; 4]];
        let far = RigidKey { translation: [f64::INFINITY; 3], ..key(1.0, 1.0) };
        for (base, keys) in [
            (UNIT, vec![]),
            (UNIT, vec![key(0.0, 0.0)]),
            (UNIT, vec![key(0.0, 1.0), key(0.0, 1.0)]),
            (UNIT, vec![key(1.0, 1.0), key(0.0, 1.0)]),
            (UNIT, vec![key(0.0, f64::NAN)]),
            (UNIT, vec![key(f64::NAN, 1.0)]),
            (UNIT, vec![key(0.0, 1.0), far]),
            (flat, vec![key(0.0, 1.0)]),
        ] {
            assert_eq!(Motion::new(base, &keys), None, "{keys:?}");
        }
    }

    /// Spinning fast about the origin, near it and far from it; and boxes are not much too large.
    #[test]
    fn moving_points_stay_in_their_box() {
        let mut random = random();
        for round in 0..300 {
            let size = [1.0, 1e-3, 100.0][round % 3];
            let away = [0.0, 0.3, 50.0][round / 3 % 3];
            let mut base = UNIT.map(|row| row.map(|x| x * size + random(0.3 * size)));
            base.iter_mut().for_each(|row| row[3] = random(away));
            let keys: Vec<RigidKey> = (0..2 + round % 4)
                .map(|i| RigidKey {
                    time: i as f64 / (1 + round % 4) as f64,
                    rotation: about([random(1.0), random(1.0), random(1.0)], random(3.2)),
                    translation: [random(away), random(away), random(away)],
                })
                .collect();
            let Some(motion) = Motion::new(base, &keys) else { continue };
            let object = Bounds { min: [-1.0, 0.1, 2.0], max: [1.0, 0.3, 2.5] };
            let bounds = motion.bounds_to_world(&object);
            let mut seen = Bounds::EMPTY;
            for step in 0..=4000 {
                let transform = motion.at(step as f32 / 4000.0);
                for corner in 0..8 {
                    let p: [f32; 3] =
                        std::array::from_fn(|a| if corner >> a & 1 == 0 { object.min[a] } else { object.max[a] });
                    // As rounded as the transform is, but not more.
                    let p = transform.to_world.map(|row| {
                        (0..3).map(|a| f64::from(row[a]) * f64::from(p[a])).sum::<f64>() + f64::from(row[3])
                    });
                    let inside = (0..3).all(|a| f64::from(bounds.min[a]) <= p[a] && p[a] <= f64::from(bounds.max[a]));
                    assert!(inside, "round {round}, step {step}: {p:?} {bounds:?}");
                    seen = seen.join(&Bounds::around(p, p));
                }
            }
            let extent = |b: &Bounds| (0..3).map(|a| b.max[a] - b.min[a]).sum::<f32>();
            assert!(extent(&bounds) < 1.15 * extent(&seen), "round {round}: {bounds:?} {seen:?}");
        }
    }

    /// The product of both maps is as near to the identity as padding takes it to be.
    #[test]
    fn rounding_stays_within_the_pad() {
        let mut random = random();
        for round in 0..500 {
            let mut base = UNIT.map(|row| row.map(|x| x + random(0.8)));
            base[0] = base[0].map(|x| x * [1.0, 1e-4, 1e3][round % 3]);
            let keys = [0.0, 1.0].map(|time| RigidKey {
                time,
                rotation: about([random(1.0), random(1.0), random(1.0)], random(3.2)),
                translation: [random(10.0), random(10.0), random(10.0)],
            });
            let Some(motion) = Motion::new(base, &keys) else { continue };
            let bound = motion.stretch();
            for step in 0..50 {
                let found = Stretch::of(&motion.at(step as f32 / 49.0));
                assert!(found.forth <= bound.forth && found.back <= bound.back && found.back_shift <= bound.back_shift);
                assert!(found.residual <= bound.residual && found.residual_shift <= bound.residual_shift);
            }
        }
    }
}
