//! Geometry that the scene file describes by numbers, as meshes.

use etendue::math::DVec3;

/// Splits positions into an origin and `f32` offsets. The origin is zero unless the mesh lies so far from its own zero,
/// compared with its size, that `f32` would lose detail.
pub fn split_origin(positions: &[[f64; 3]]) -> (DVec3, Vec<[f32; 3]>) {
    let points = || positions.iter().map(|p| DVec3::from_array(*p));
    let (min, max) = points().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)));
    let (center, extent) = ((min + max) * 0.5, max - min);
    const FAR: f64 = 16.0;
    let is_far = !positions.is_empty() && center.abs().max_element() > FAR * extent.max_element();
    let origin = if is_far { center } else { DVec3::ZERO };
    (origin, points().map(|p| (p - origin).as_vec3().to_array()).collect())
}
