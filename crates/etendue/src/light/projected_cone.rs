//! Elliptic cones, as those of disks, by projected solid angle.
//!
//! On the ellipse of an [`EllipticCone`], with the surface's normal n in the cone's frame, what a direction (x, y, z) brings is
//! (n . d) dx dy / z = (n.z + (n.x x + n.y y) / z) dx dy. The second term is odd about the middle. So of a cone that is all above
//! the horizon every two opposite points bring 2 n.z together: its projected solid angle is pi a b n.z, and the square s of the
//! distance from the middle, over the half axes, is even in [0, 1]. Along the angle there, both terms have elementary integrals: of
//! cos / z an arc sine, of sin / z an area sine, since z^2 is a constant plus a multiple of sin^2 or of cos^2. Their sum is
//! inverted by Newton's method.
//!
//! Where the horizon cuts the cone, it meets the ellipse at s in two angles, symmetric about one that is the same for all s: n . d = 0
//! is where a quadratic form of (cos, sin) has the value n.z^2 / s. Between them the integral is as before, and over s it is
//! fitted by a constant and a power of the distance from where the cut begins.

use super::{between, elliptic_cone::EllipticCone, larger};
use crate::math::{DVec3, atan2_wide, exp_wide, ln_normal, sin_cos_wide};
use std::f64::consts::{PI, TAU};

/// A cosine that no difference of directions in f32 can tell from 0.
const GRAZING: f64 = 1e-8;
/// Least half axis of a cone that is cut: of narrower ones directions in f32 tell badly which part is cut.
const LEAST_HALF: f64 = 1e-3;
/// Least range of s in which a cone whose middle is below the horizon is seen: differences of integrals lose too much.
const LEAST_RANGE: f64 = 1e-4;

/// Least square root of what z^2 varies by along the angle: below, z is the same to 12 digits.
const LEAST_ROOT: f64 = 1e-6;

/// What of a cone is above a horizon.
#[derive(Debug)]
pub(super) struct ProjectedCone<'a> {
    cone: &'a EllipticCone,
    normal: DVec3,
    /// The normal's z in the cone's frame, and its x and y times the half axes.
    up: f64,
    slope: [f64; 2],
    /// Of s, where the cut begins; 1 if nothing is cut.
    from: f64,
    /// The angle, radians, that most is brought about.
    middle: f64,
    /// The quadratic form's greatest value, over twice the half of what it varies by.
    swing: f64,
    fit: Fit,
}

/// Density of s in [0, 1] in proportion to `even` plus, from `from` on, `more` times a power of the distance from there over all that
/// there is.
#[derive(Clone, Copy, Debug)]
struct Fit {
    from: f64,
    even: f64,
    more: f64,
    exponent: f64,
    /// Integral of the above.
    total: f64,
}

impl<'a> ProjectedCone<'a> {
    /// `None` where directions by solid angle serve as well, or none is above the horizon of the unit vector `normal`.
    pub fn new(cone: &'a EllipticCone, normal: DVec3) -> Option<Self> {
        let [a, b] = cone.half;
        let up = cone.axis.dot(normal);
        let slope = [a * normal.dot(cone.across[0]), b * normal.dot(cone.across[1])];
        let form = [slope[0] * slope[0] + up * up * a * a, slope[1] * slope[1] + up * up * b * b];
        let (mean, lean) = (0.5 * (form[0] + form[1]), [0.5 * (form[0] - form[1]), slope[0] * slope[1]]);
        let half = (lean[0] * lean[0] + lean[1] * lean[1]).sqrt();
        let greatest = mean + half;
        let is_whole = up * up >= greatest;
        let from = if is_whole { 1.0 } else { up * up / greatest };
        let angle = 0.5 * atan2_wide(lean[1], lean[0]);
        let (sin, cos) = sin_cos_wide(angle);
        let middle = if slope[0] * cos + slope[1] * sin < 0.0 { angle + PI } else { angle };
        let even = TAU * larger(up, 0.0);
        let fit = Fit { from, even, more: 0.0, exponent: 1.0, total: even };
        let swing = if half > 0.0 { greatest / (2.0 * half) } else { 1.0 };
        let whole = Self { cone, normal, up, slope, from, middle, swing, fit };
        if is_whole {
            return (up > 0.0).then_some(whole);
        }
        let is_accurate = a >= LEAST_HALF && (1.0 - from >= LEAST_RANGE || up > 0.0);
        let cut = Self { fit: whole.fit_of_cut(), ..whole };
        (is_accurate && cut.fit.total > 0.0 && cut.fit.total.is_finite()).then_some(cut)
    }

    /// By one value of the integral: the power is a half where the horizon goes through the middle, and one and a half where only
    /// the rim is cut.
    fn fit_of_cut(&self) -> Fit {
        let Fit { from, even, .. } = self.fit;
        let (at, exponent) = (0.7, 0.5 + from);
        let more = larger(self.brought(from + (1.0 - from) * at) - even, 0.0) / power(at, exponent);
        Fit { from, even, more, exponent, total: even + more * (1.0 - from) / (1.0 + exponent) }
    }

    /// Half of the range of angles about the middle that are above the horizon at `s`.
    fn width(&self, s: f64) -> f64 {
        if s <= self.from {
            return if self.up > 0.0 { PI } else { 0.0 };
        }
        let square = between(self.swing * (s - self.from) / s, 0.0, 1.0);
        let cut = atan2_wide(square.sqrt(), (1.0 - square).sqrt());
        if self.up > 0.0 { PI - cut } else { cut }
    }

    /// Integral of what directions bring over the angles at `s`, over half the product of the half axes.
    fn brought(&self, s: f64) -> f64 {
        if s <= self.from {
            return TAU * larger(self.up, 0.0);
        }
        let (ring, width) = (Ring::new(self, s), self.width(s));
        ring.value(self.middle + width)[1] - ring.value(self.middle - width)[1]
    }

    /// Density per solid angle with which [`Self::sample`] draws a direction of the cone, above 0 also for one on the horizon.
    pub fn density(&self, direction: DVec3) -> f64 {
        let [a, b] = self.cone.half;
        let cosine = larger(direction.dot(self.normal), GRAZING);
        if self.from >= 1.0 {
            return cosine / (PI * a * b * self.up);
        }
        let [x, y] = self.cone.locate(direction);
        let s = between(x * x + y * y, 0.0, 1.0);
        2.0 * cosine / (a * b) * self.fit.density(s) / self.brought(s)
    }

    /// A direction, unit, for `u` in [0, 1)^2.
    pub fn sample(&self, u: [f64; 2]) -> DVec3 {
        let s = self.fit.sample(u[0]);
        let ring = Ring::new(self, s);
        let width = self.width(s);
        let phi = ring.angle(self.middle, width, u[1]);
        let ([a, b], (sin, cos)) = (self.cone.half, sin_cos_wide(phi));
        self.cone.direction(a * ring.r * cos, b * ring.r * sin, ring.z(sin))
    }
}

impl Fit {
    /// Distance from where the cut begins, in [0, 1].
    fn beyond(&self, s: f64) -> f64 {
        if s > self.from { (s - self.from) / (1.0 - self.from) } else { 0.0 }
    }

    fn density(&self, s: f64) -> f64 {
        if self.more == 0.0 {
            return self.even / self.total;
        }
        (self.even + self.more * power(self.beyond(s), self.exponent)) / self.total
    }

    fn sample(&self, u: f64) -> f64 {
        let reached = u * self.total;
        if reached < self.even || self.more == 0.0 {
            return reached / self.even;
        }
        let share = between((reached - self.even) / (self.total - self.even), 0.0, 1.0);
        self.from + (1.0 - self.from) * power(share, 1.0 / (1.0 + self.exponent))
    }
}

/// What directions at one s bring, by their angle.
struct Ring {
    /// Square root of s.
    r: f64,
    up: f64,
    /// Factors of cos / z and sin / z.
    slope: [f64; 2],
    /// z^2 where the sine is 0, and what it is less by where the cosine is.
    end: f64,
    vary: f64,
    /// The square root of the latter.
    root: f64,
}

impl Ring {
    fn new(cone: &ProjectedCone, s: f64) -> Self {
        let [a, b] = cone.cone.half;
        let r = s.sqrt();
        let vary = s * (b - a) * (b + a);
        let end = (1.0 - r * a) * (1.0 + r * a);
        Self { r, up: cone.up, slope: cone.slope.map(|slope| slope * r), end, vary, root: vary.sqrt() }
    }

    fn z(&self, sin: f64) -> f64 {
        larger(self.end - self.vary * sin * sin, 1e-30).sqrt()
    }

    /// What directions bring at an angle, and an integral of it.
    fn value(&self, phi: f64) -> [f64; 2] {
        let (sin, cos) = sin_cos_wide(phi);
        let (z, root) = (self.z(sin), self.root);
        let [of_cos, of_sin] = if root > LEAST_ROOT {
            // The area tangent of root cos / z.
            let area = 0.5 * ln_normal((z + root * cos) / larger(z - root * cos, 1e-30));
            [atan2_wide(root * sin, z) / root, -area / root]
        } else {
            [sin / z, -cos / z]
        };
        let value = self.up + (self.slope[0] * cos + self.slope[1] * sin) / z;
        [value, self.up * phi + self.slope[0] * of_cos + self.slope[1] * of_sin]
    }

    /// The angle at most `width` from `middle` below which there is the share `u` of the integral.
    fn angle(&self, middle: f64, width: f64, u: f64) -> f64 {
        let (mut low, mut high) = (middle - width, middle + width);
        let from = self.value(low)[1];
        let total = if width < PI { self.value(high)[1] - from } else { TAU * self.up };
        let share = from + u * total;
        let mut phi = low + u * (high - low);
        // Newton's method, halving the interval where that leaves it.
        for _ in 0..60 {
            let [value, integral] = self.value(phi);
            if integral > share {
                high = phi
            } else {
                low = phi
            }
            let next = phi - (integral - share) / value;
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            let step = (next - phi).abs();
            phi = next;
            // The next step would be of the size of its square.
            if step <= 1e-5 {
                break;
            }
        }
        phi
    }
}

/// `base`, in [0, 1], to a power above 0.
fn power(base: f64, exponent: f64) -> f64 {
    exp_wide(ln_normal(larger(base, 1e-30)) * exponent)
}
