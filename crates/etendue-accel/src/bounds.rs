//! Axis-aligned boxes.

use bytemuck::Zeroable;

/// An axis-aligned box, both ends inclusive.
#[derive(Clone, Copy, Debug, PartialEq, Zeroable)]
pub struct Bounds {
    /// Smallest coordinates.
    pub min: [f32; 3],
    /// Largest coordinates.
    pub max: [f32; 3],
}

impl Bounds {
    /// The box of no points: joined with another it gives the other.
    pub(crate) const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    /// The smallest box around points; empty for none.
    pub(crate) fn of_points(points: impl IntoIterator<Item = [f32; 3]>) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, p| bounds.join(&Self { min: p, max: p }))
    }

    /// The smallest box of f32 around one of f64.
    pub(crate) fn around(min: [f64; 3], max: [f64; 3]) -> Self {
        Self { min: min.map(round_down), max: max.map(round_up) }
    }

    #[inline(always)]
    pub(crate) fn join(&self, other: &Self) -> Self {
        Self {
            min: std::array::from_fn(|a| least(self.min[a], other.min[a])),
            max: std::array::from_fn(|a| greatest(self.max[a], other.max[a])),
        }
    }

    /// What both hold.
    #[inline(always)]
    pub(crate) fn meet(&self, other: &Self) -> Self {
        Self {
            min: std::array::from_fn(|a| greatest(self.min[a], other.min[a])),
            max: std::array::from_fn(|a| least(self.max[a], other.max[a])),
        }
    }

    /// True if it holds no point.
    pub(crate) fn is_empty(&self) -> bool {
        (0..3).any(|a| self.min[a] > self.max[a])
    }

    /// Twice the middle.
    #[inline(always)]
    pub(crate) fn middle(&self) -> [f32; 3] {
        std::array::from_fn(|a| self.min[a] + self.max[a])
    }

    /// Half the surface area; 0 if empty.
    #[inline(always)]
    pub(crate) fn half_area(&self) -> f32 {
        let [x, y, z] = std::array::from_fn(|a| greatest(self.max[a] - self.min[a], 0.0));
        x * y + y * z + z * x
    }

    /// The axis of the longest side.
    pub(crate) fn longest_axis(&self) -> usize {
        let [x, y, z] = std::array::from_fn(|a| self.max[a] - self.min[a]);
        if x >= y && x >= z {
            0
        } else if y >= z {
            1
        } else {
            2
        }
    }

    /// The largest magnitude of a coordinate; 0 if empty.
    pub(crate) fn reach(&self) -> f32 {
        if self.is_empty() {
            return 0.0;
        }
        self.min.iter().chain(&self.max).fold(0.0, |reach, x| greatest(reach, x.abs()))
    }
}

/// The smaller, as one instruction.
#[inline(always)]
pub(crate) fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger, as one instruction.
#[inline(always)]
pub(crate) fn greatest(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The largest f32 not above `x`.
pub(crate) fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

/// The smallest f32 not below `x`.
pub(crate) fn round_up(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}
