//! What a plane across an axis leaves of a triangle on either side, and boxes around that.
//!
//! # Why no point of a triangle is lost
//!
//! Corners are kept in f64. Where an edge meets a plane, its new corner has the plane's coordinate exactly and is elsewhere within
//! e = 2^-49 R of that place, R being the largest magnitude of a coordinate: four differences and a quotient, which have their bits
//! right as the numbers under them have different signs, a product and a sum, 14 times 2^-53 R together. Seen in the triangle's
//! plane, the outlines of the two parts add up to the outline of the whole but for e, whatever order rounding leaves corners in
//! along a line: so what the whole winds around, one of the parts winds around or passes within e, and both parts lie in the boxes
//! of their corners. After at most [`Polygon::CUTS`] cuts in succession every point of the triangle is within 2^6 e = 2^-43 R of
//! such a box. Boxes grow by [`MARGIN`] R, which leaves room for that sum's own rounding.

use crate::bounds::Bounds;

/// Boxes grow by this share of the largest magnitude of a coordinate: 2^-42.
const MARGIN: f64 = 1.0 / (1_u64 << 42) as f64;

/// A part of a triangle: the corners of a convex polygon, as far as rounding lets it be one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polygon {
    corners: [[f64; 3]; 2 * Self::CORNERS],
    len: usize,
    low: [f64; 3],
    high: [f64; 3],
}

impl Polygon {
    /// Polygons of more corners are not cut: a triangle within a box has no more, but rounding may add some.
    const CORNERS: usize = 9;

    /// A triangle may be cut so many times in succession.
    pub const CUTS: usize = 64;

    const EMPTY: Self =
        Self { corners: [[0.0; 3]; 2 * Self::CORNERS], len: 0, low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };

    /// A triangle.
    #[inline(always)]
    pub fn of(corners: &[[f32; 3]; 3]) -> Self {
        let mut whole = Self::EMPTY;
        for corner in corners {
            whole.push(corner.map(f64::from));
        }
        whole
    }

    #[inline(always)]
    fn push(&mut self, corner: [f64; 3]) {
        self.corners[self.len] = corner;
        self.len += 1;
        for (axis, at) in corner.into_iter().enumerate() {
            self.low[axis] = if at < self.low[axis] { at } else { self.low[axis] };
            self.high[axis] = if at > self.high[axis] { at } else { self.high[axis] };
        }
    }

    /// The sides of its box.
    #[inline(always)]
    pub fn sides(&self) -> [f64; 3] {
        std::array::from_fn(|axis| self.high[axis] - self.low[axis])
    }

    /// The middle of its box on an axis.
    #[inline(always)]
    pub fn middle(&self, axis: usize) -> f64 {
        0.5 * (self.low[axis] + self.high[axis])
    }

    /// The parts below and above a plane; `None` if there are not two, or it has too many corners.
    #[inline(always)]
    pub fn cut(&self, axis: usize, at: f64) -> Option<[Self; 2]> {
        if self.len > Self::CORNERS || !(self.low[axis] < at && at < self.high[axis]) {
            return None;
        }
        let mut parts = [Self::EMPTY; 2];
        let mut from = self.corners[self.len - 1];
        for &to in &self.corners[..self.len] {
            let (a, b) = (from[axis] - at, to[axis] - at);
            if (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0) {
                let share = a / (a - b);
                let mut met: [f64; 3] = std::array::from_fn(|i| from[i] + (to[i] - from[i]) * share);
                met[axis] = at;
                parts[0].push(met);
                parts[1].push(met);
            }
            if b <= 0.0 {
                parts[0].push(to);
            }
            if b >= 0.0 {
                parts[1].push(to);
            }
            from = to;
        }
        Some(parts)
    }

    /// A box around what it stands for, within that of the triangle.
    #[inline(always)]
    pub fn bounds(&self, whole: &Bounds) -> Bounds {
        let margin = f64::from(whole.reach()) * MARGIN;
        let around = Bounds::around(self.low.map(|x| x - margin), self.high.map(|x| x + margin));
        around.meet(whole)
    }
}
