//! Triangles of a body, in its own space.

use etendue::math::DVec3;

/// Vertices that differ, and faces of them.
#[derive(Clone, Debug, Default)]
pub struct Triangles {
    /// Metres, in the body's space; each once, and each used.
    pub vertices: Vec<DVec3>,
    /// Three different vertices each.
    pub faces: Vec<[u32; 3]>,
}

impl Triangles {
    /// From corners of faces, three each; vertices in the same place become one, faces without area to the bit are left out.
    pub fn weld(corners: &[DVec3]) -> Self {
        let bits = |i: u32| corners[i as usize].to_array().map(|x| (x + 0.0).to_bits());
        let mut order: Vec<u32> = (0..corners.len() as u32).collect();
        order.sort_unstable_by_key(|&i| (bits(i), i));
        let mut numbers = vec![0; corners.len()];
        let mut vertices = Vec::new();
        for group in order.chunk_by(|&a, &b| bits(a) == bits(b)) {
            group.iter().for_each(|&i| numbers[i as usize] = vertices.len() as u32);
            vertices.push(corners[group[0] as usize]);
        }
        let faces = numbers.chunks_exact(3).map(|face| [face[0], face[1], face[2]]);
        let faces = faces.filter(|[a, b, c]| a != b && b != c && c != a).collect();
        Self { vertices, faces }
    }

    /// Every edge is gone along as often one way as the other.
    pub fn is_closed(&self) -> bool {
        let mut edges: Vec<(u32, u32, i8)> = Vec::with_capacity(self.faces.len() * 3);
        for &[a, b, c] in &self.faces {
            edges.extend([(a, b), (b, c), (c, a)].map(|(a, b)| if a < b { (a, b, 1) } else { (b, a, -1) }));
        }
        edges.sort_unstable();
        let mut groups = edges.chunk_by(|first, second| (first.0, first.1) == (second.0, second.1));
        !self.faces.is_empty() && groups.all(|group| group.iter().map(|edge| i64::from(edge.2)).sum::<i64>() == 0)
    }

    /// Of a closed surface, m³; negative if its faces look inward.
    pub fn volume(&self) -> f64 {
        let middle = self.vertices.first().copied().unwrap_or_default();
        let corner = |i: u32| self.vertices[i as usize] - middle;
        self.faces.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c))) / 6.0).sum()
    }

    /// Lowest and highest corner of the bounding box.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let points = self.vertices.iter().copied();
        points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
    }
}

/// Points of a sphere about the origin, of radius 1: an octahedron whose faces are cut into `n`² each.
pub fn sphere_points(n: i32) -> Vec<DVec3> {
    let mut points = Vec::new();
    for x in -n..=n {
        let rest = n - x.abs();
        for y in -rest..=rest {
            let z = rest - y.abs();
            let p = |z| DVec3::new(f64::from(x), f64::from(y), f64::from(z)).normalize();
            points.push(p(z));
            if z > 0 {
                points.push(p(-z));
            }
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> Triangles {
        let mesh = etendue_scene::geometry::cuboid(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0));
        let corner = |&i: &u32| mesh.origin + DVec3::from_array(mesh.positions[i as usize].map(f64::from));
        Triangles::weld(&mesh.indices.iter().flatten().map(corner).collect::<Vec<_>>())
    }

    #[test]
    fn boxes_are_closed_and_have_their_volume() {
        let mut cube = cube();
        assert_eq!((cube.vertices.len(), cube.faces.len()), (8, 12));
        assert!(cube.is_closed() && (cube.volume() - 6.0).abs() < 1e-12);
        cube.faces.iter_mut().for_each(|face| face.swap(0, 1));
        assert!(cube.is_closed() && (cube.volume() + 6.0).abs() < 1e-12);
        cube.faces[3].swap(0, 1);
        assert!(!cube.is_closed());
        cube.faces.remove(3);
        assert!(!cube.is_closed());
        assert!(!Triangles::default().is_closed());
    }

    #[test]
    fn sphere_points_are_many_and_different() {
        let points = sphere_points(6);
        assert_eq!(points.len(), 4 * 36 + 2);
        assert!(points.iter().all(|p| (p.length() - 1.0).abs() < 1e-15));
        let closest = |i: usize| (0..i).map(|j| (points[i] - points[j]).length()).fold(9.0, f64::min);
        assert!((1..points.len()).all(|i| closest(i) > 0.1));
    }
}
