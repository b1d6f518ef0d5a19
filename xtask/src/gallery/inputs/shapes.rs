//! Bodies as signed distances, joined softly.

use glam::DVec3;

/// A cone with round ends of two radii, flattened if wished.
#[derive(Clone, Copy)]
pub struct Cone {
    a: DVec3,
    b: DVec3,
    ra: f64,
    rb: f64,
    /// Width of the joint with what was there before.
    pub blend: f64,
    middle: DVec3,
    reach: f64,
}

impl Cone {
    pub fn new((a, ra): (DVec3, f64), (b, rb): (DVec3, f64), blend: f64) -> Self {
        let reach = 0.5 * a.distance(b) + ra.max(rb);
        Self { a, b, ra, rb, blend, middle: 0.5 * (a + b), reach }
    }

    /// The point of the axis that is so far along, from 0 to 1.
    pub fn on_axis(&self, t: f64) -> DVec3 {
        self.a.lerp(self.b, t)
    }

    /// A lower bound of the distance.
    pub fn at_least(&self, p: DVec3) -> f64 {
        p.distance(self.middle) - self.reach
    }

    /// Distance, and how far along the axis the nearest point is, from 0 to 1.
    pub fn distance(&self, p: DVec3) -> (f64, f64) {
        let axis = self.b - self.a;
        let length2 = axis.length_squared().max(1e-12);
        let q = p - self.a;
        let slope = self.ra - self.rb;
        let along = q.dot(axis) / length2;
        let off = (q - axis * along).length();
        // The tangent of both ends leans by as much as the radii differ.
        let lean = slope / (length2 - slope * slope).max(1e-12).sqrt();
        let t = (along - off * lean / length2.sqrt()).clamp(0.0, 1.0);
        (p.distance(self.a + axis * t) - (self.ra - slope * t), t)
    }
}

/// A ball stretched along its own axes.
#[derive(Clone, Copy)]
pub struct Ellipsoid {
    pub middle: DVec3,
    pub axes: [DVec3; 3],
    pub radii: DVec3,
    pub blend: f64,
}

impl Ellipsoid {
    pub fn at_least(&self, p: DVec3) -> f64 {
        p.distance(self.middle) - self.radii.max_element()
    }

    /// Near the surface a good estimate of the distance.
    pub fn distance(&self, p: DVec3) -> f64 {
        let q = p - self.middle;
        let local = DVec3::from_array(self.axes.map(|axis| q.dot(axis)));
        let (k0, k1) = ((local / self.radii).length(), (local / (self.radii * self.radii)).length());
        if k1 < 1e-9 { -self.radii.min_element() } else { k0 * (k0 - 1.0) / k1 }
    }
}

/// Smaller of two distances with a joint of width `k` rounded: a polynomial that is exact where they differ by more.
pub fn union(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0);
    a.min(b) - h * h / (4.0 * k.max(1e-9))
}

/// `a` without `b`.
pub fn cut(a: f64, b: f64, k: f64) -> f64 {
    -union(-a, b, k)
}
