//! The ray-sphere test that every accelerator calls, in f64 from the f32 inputs.

use crate::geometry::Sphere;
use crate::local_ray::LocalRay;

/// The parameters, near and far, at which the line of the ray crosses the sphere, each rounded once to f32; None if it
/// does not.
#[inline(never)]
pub(crate) fn intersect(ray: &LocalRay, sphere: &Sphere) -> Option<[f32; 2]> {
    let found = roots(ray.origin, ray.direction, sphere);
    (!found[0].is_nan()).then_some(found)
}

/// As [`intersect`], NaN for None.
///
/// The discriminant is radius^2 less the squared distance of the centre from the line, which is measured from the nearest
/// point of the line: precise also for a sphere that is small and far (Haines, Gunther, Akenine-Moller, "Precision
/// Improvements for Ray/Sphere Intersection", Ray Tracing Gems, 2019).
#[inline(always)]
pub(crate) fn roots(origin: [f32; 3], direction: [f32; 3], sphere: &Sphere) -> [f32; 2] {
    let d = direction.map(f64::from);
    let from_center: [f64; 3] = std::array::from_fn(|a| f64::from(origin[a]) - f64::from(sphere.center[a]));
    let radius = f64::from(sphere.radius);
    let dd = dot(d, d);
    let middle = -dot(from_center, d) / dd;
    let nearest: [f64; 3] = std::array::from_fn(|a| from_center[a] + middle * d[a]);
    let discriminant = radius * radius - dot(nearest, nearest);
    let half = (discriminant / dd).sqrt();
    [middle - half, middle + half].map(|t| if discriminant < 0.0 { f32::NAN } else { t as f32 + 0.0 })
}

/// True if the ray points to the inner side of the sphere at its origin.
#[inline(always)]
pub(crate) fn points_inward(origin: [f32; 3], direction: [f32; 3], sphere: &Sphere) -> bool {
    let from_center = std::array::from_fn(|a| f64::from(origin[a]) - f64::from(sphere.center[a]));
    dot(direction.map(f64::from), from_center) < 0.0
}

#[inline(always)]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crossed(origin: [f32; 3], direction: [f32; 3], center: [f32; 3], radius: f32) -> Option<[f32; 2]> {
        intersect(&LocalRay::new(origin, direction).unwrap(), &Sphere { center, radius })
    }

    #[test]
    fn both_roots() {
        assert_eq!(crossed([0.0, 0.0, 5.0], [0.0, 0.0, -2.0], [0.0; 3], 1.0), Some([2.0, 3.0]));
        assert_eq!(crossed([0.0; 3], [0.0, 0.5, 0.0], [0.0; 3], 1.0), Some([-2.0, 2.0]));
        assert_eq!(crossed([1.0, 0.0, 5.0], [0.0, 0.0, -1.0], [0.0; 3], 1.0), Some([5.0, 5.0]), "grazing");
        assert_eq!(crossed([1.001, 0.0, 5.0], [0.0, 0.0, -1.0], [0.0; 3], 1.0), None);
    }

    #[test]
    fn small_and_far_or_huge_and_near() {
        let [near, far] = crossed([1e7, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0; 3], 1e-3).unwrap();
        assert_eq!((near, far), (1e7, 1e7));
        assert!(crossed([1e7, 1.1e-3, 0.0], [-1.0, 0.0, 0.0], [0.0; 3], 1e-3).is_none());
        let [near, _] = crossed([0.0, 0.25, 0.0], [0.0, -1.0, 0.0], [0.0, -1e7, 0.0], 1e7).unwrap();
        assert!((near - 0.25).abs() < 1e-7, "{near}");
    }
}
