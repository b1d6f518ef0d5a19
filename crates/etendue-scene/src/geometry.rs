//! Geometry that a scene file describes by a few numbers, and transforms.

use crate::{
    description::Step,
    positions::localise,
    read::{rotation, sin_cos_degrees},
};
use etendue::{
    math::{DAffine3, DMat3, DVec3},
    scene::Mesh,
};

/// A mesh of `positions` and `faces`, flat.
fn mesh(positions: &[[f64; 3]], faces: Vec<[u32; 3]>, uvs: Vec<[f32; 2]>) -> Mesh {
    let (origin, positions) = localise(positions.iter().map(|p| DVec3::from_array(*p)));
    Mesh {
        origin,
        positions,
        indices: faces.into(),
        normals: None,
        uvs: Some(uvs.into()),
        colors: None,
        face_materials: None,
    }
}

/// An axis-aligned box: twelve triangles with outward normals, texture coordinates (0, 0) to (1, 1) on every side.
pub fn cuboid(min: DVec3, max: DVec3) -> Mesh {
    // Each side by its lowest-numbered corner and the two axes that span it, in the order that points outward.
    const SIDES: [([usize; 3], usize, usize); 6] = [
        ([0, 0, 0], 2, 1),
        ([1, 0, 0], 1, 2),
        ([0, 0, 0], 0, 2),
        ([0, 1, 0], 2, 0),
        ([0, 0, 0], 1, 0),
        ([0, 0, 1], 0, 1),
    ];
    let ends = [min.to_array(), max.to_array()];
    let mut positions = Vec::with_capacity(24);
    let (mut faces, mut uvs) = (Vec::with_capacity(12), Vec::with_capacity(24));
    for (corner, u, v) in SIDES {
        let first = positions.len() as u32;
        for (a, b) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
            let mut end = corner;
            end[u] += a;
            end[v] += b;
            positions.push([0, 1, 2].map(|axis| ends[end[axis]][axis]));
            uvs.push([a as f32, b as f32]);
        }
        faces.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    mesh(&positions, faces, uvs)
}

/// A regular polygon of `segments` corners in the plane z = 0, facing +z, with exactly the area of the disk of `radius`:
/// a light keeps its power however few the corners. Texture coordinates span its bounding square.
pub fn disk(radius: f64, segments: u32) -> Mesh {
    let n = f64::from(segments);
    // Area of the polygon with circumradius R: n/2 R^2 sin(2 pi/n).
    let (sin, _) = sin_cos_degrees(360.0 / n);
    let circumradius = radius * (std::f64::consts::PI / (0.5 * n * sin)).sqrt();
    let rim = (0..segments).map(|i| {
        let (sin, cos) = sin_cos_degrees(360.0 * f64::from(i) / n);
        [circumradius * cos, circumradius * sin, 0.0]
    });
    let positions: Vec<_> = std::iter::once([0.0; 3]).chain(rim).collect();
    let uv = |p: &[f64; 3]| [p[0], p[1]].map(|c| (0.5 + 0.5 * c / circumradius) as f32);
    let uvs = positions.iter().map(uv).collect();
    let faces = (0..segments).map(|i| [0, 1 + i, 1 + (i + 1) % segments]).collect();
    mesh(&positions, faces, uvs)
}

/// One step as an affine map; `lowest` gives the lowest corner of the bounding box of what has been placed so far.
pub fn step(step: &Step, lowest: impl FnOnce() -> DVec3) -> DAffine3 {
    match *step {
        Step::Translate(by) => DAffine3::from_translation(by),
        Step::Scale(factors) => DAffine3::from_scale(factors),
        Step::Rotate { axis, angle } => {
            let [x, y, z] = rotation(axis, angle);
            DAffine3::from_mat3(DMat3::from_cols(x, y, z))
        }
        Step::Matrix(m) => DAffine3::from_cols(
            DVec3::new(m[0], m[4], m[8]),
            DVec3::new(m[1], m[5], m[9]),
            DVec3::new(m[2], m[6], m[10]),
            DVec3::new(m[3], m[7], m[11]),
        ),
        Step::LookAt { position, target, up } => {
            let z = (target - position).normalize();
            let x = up.cross(z).normalize();
            DAffine3::from_cols(x, z.cross(x), z, position)
        }
        Step::Relocate(to) => DAffine3::from_translation(to - lowest()),
    }
}

/// The lowest corner of the bounding box of a mesh after a transform; of vertices that no face uses too.
pub fn lowest_of_mesh(mesh: &Mesh, transform: &DAffine3) -> DVec3 {
    let corner = |p: &[f32; 3]| transform.transform_point3(mesh.origin + DVec3::from_array(p.map(f64::from)));
    mesh.positions.iter().map(corner).fold(DVec3::INFINITY, DVec3::min)
}

/// The lowest corner of the bounding box of a sphere after a transform: it reaches as far along an axis as that row of the
/// matrix is long.
pub fn lowest_of_sphere(center: DVec3, radius: f64, transform: &DAffine3) -> DVec3 {
    let rows = transform.matrix3.transpose();
    let reach = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length()) * radius;
    transform.transform_point3(center) - reach
}

/// The lowest corner of the bounding box of a parallelogram after a transform.
pub fn lowest_of_rectangle(corner: DVec3, u: DVec3, v: DVec3, transform: &DAffine3) -> DVec3 {
    let corners = [corner, corner + u, corner + v, corner + u + v];
    corners.map(|p| transform.transform_point3(p)).into_iter().fold(DVec3::INFINITY, DVec3::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faces(mesh: &Mesh) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        let point = |i: u32| mesh.origin + DVec3::from_array(mesh.positions[i as usize].map(f64::from));
        mesh.indices.iter().map(move |f| f.map(point))
    }

    #[test]
    fn boxes_are_closed_and_face_outward() {
        let (min, max) = (DVec3::new(-1.0, 0.0, 2.0), DVec3::new(1.0, 4.0, 2.5));
        let mesh = cuboid(min, max);
        let (mut area, mut volume) = (0.0, 0.0);
        for [a, b, c] in faces(&mesh) {
            let n = (b - a).cross(c - a);
            assert!(n.dot(a - (min + max) * 0.5) > 0.0);
            area += 0.5 * n.length();
            volume += a.dot(b.cross(c)) / 6.0;
        }
        assert!((area - 2.0 * (8.0 + 1.0 + 2.0)).abs() < 1e-12 && (volume - 4.0).abs() < 1e-12);
    }

    #[test]
    fn disks_have_the_area_of_the_disk() {
        for segments in [3, 4, 7, 64, 1000] {
            let mesh = disk(2.0, segments);
            let area: f64 = faces(&mesh)
                .map(|[a, b, c]| {
                    let n = (b - a).cross(c - a);
                    assert!(n.z > 0.0);
                    0.5 * n.length()
                })
                .sum();
            assert!((area / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-6, "{segments}: {area}");
        }
    }

    #[test]
    fn lowest_corners_agree_with_samples() {
        let [x, y, z] = rotation(DVec3::new(1.0, 2.0, 3.0).normalize(), 40.0);
        let m = DAffine3::from_cols(x * 2.0, y * 0.5, z * 3.0, DVec3::new(5.0, 6.0, 7.0));
        let (center, radius) = (DVec3::new(0.1, 0.2, 0.3), 1.5);
        let lowest = lowest_of_sphere(center, radius, &m);
        let mut sampled = DVec3::INFINITY;
        for i in 0..200 {
            for j in 0..400 {
                let (st, ct) = sin_cos_degrees(180.0 * f64::from(i) / 200.0);
                let (sp, cp) = sin_cos_degrees(360.0 * f64::from(j) / 400.0);
                sampled = sampled.min(m.transform_point3(center + radius * DVec3::new(st * cp, st * sp, ct)));
            }
        }
        assert!((sampled - lowest).min_element() >= 0.0 && (sampled - lowest).max_element() < 2e-3);
        let mesh = cuboid(-DVec3::ONE, DVec3::ONE);
        let reach = x.abs() * 2.0 + y.abs() * 0.5 + z.abs() * 3.0;
        assert!((lowest_of_mesh(&mesh, &m) - (m.translation - reach)).abs().max_element() < 1e-12);
        let flat = lowest_of_rectangle(-DVec3::X - DVec3::Y, DVec3::X * 2.0, DVec3::Y * 2.0, &m);
        assert!((flat - (m.translation - (x.abs() * 2.0 + y.abs() * 0.5))).abs().max_element() < 1e-12);
    }

    #[test]
    fn look_at_turns_z_to_the_target() {
        let s = Step::LookAt { position: DVec3::new(1.0, 2.0, 3.0), target: DVec3::new(4.0, 2.0, 7.0), up: DVec3::Y };
        let m = step(&s, || DVec3::ZERO);
        assert!((m.transform_vector3(DVec3::Z) - DVec3::new(0.6, 0.0, 0.8)).length() < 1e-15);
        assert!((m.transform_vector3(DVec3::Y) - DVec3::Y).length() < 1e-15);
        assert!((m.matrix3.determinant() - 1.0).abs() < 1e-15);
        assert_eq!(m.transform_point3(DVec3::ZERO), DVec3::new(1.0, 2.0, 3.0));
    }
}
