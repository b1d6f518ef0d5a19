//! Mass, centre of mass and inertia of solids.

use crate::{
    convert::{matrix, rotation, vector},
    solid::{Solid, thickened},
};
use etendue::math::{DMat3, DVec3};
use rapier3d_f64::prelude::{Cuboid, MassProperties, Pose, Shape};

/// For a density of 1 kg/m³; `None` for a surface that bounds no volume.
pub fn properties(solid: &Solid) -> Option<MassProperties> {
    Some(match solid {
        Solid::Ball { center, radius } => ellipsoid(*center, DMat3::from_diagonal(DVec3::splat(*radius))),
        Solid::Ellipsoid { center, map } => ellipsoid(*center, *map),
        Solid::Box { center, rotation: turn, half } => {
            let half = thickened(*half);
            let pose = Pose::from_parts(vector(*center), rotation(*turn));
            Cuboid::new(vector(half)).mass_properties(1.0).transform_by(&pose)
        }
        Solid::Mesh { triangles, is_closed: true } => {
            let vertices: Vec<_> = triangles.vertices.iter().map(|p| vector(*p)).collect();
            MassProperties::from_trimesh(1.0, &vertices, &triangles.faces)
        }
        Solid::Mesh { is_closed: false, .. } => return None,
    })
}

/// The second moments of the unit ball are m/5 along each axis; a linear map takes them along.
fn ellipsoid(center: DVec3, map: DMat3) -> MassProperties {
    let mass = 4.0 / 3.0 * std::f64::consts::PI * map.determinant().abs();
    let moments = map * map.transpose() * (mass / 5.0);
    let trace = moments.x_axis.x + moments.y_axis.y + moments.z_axis.z;
    let inertia = DMat3::from_diagonal(DVec3::splat(trace)) - moments;
    MassProperties::with_inertia_matrix(vector(center), mass, matrix(inertia))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Triangles, sphere_points};
    use rapier3d_f64::parry::transformation::convex_hull;

    /// The hull of a stretched sphere's points, against the closed form.
    #[test]
    fn ellipsoids_agree_with_meshes_of_them() {
        let map = DMat3::from_cols(DVec3::new(1.0, 0.2, 0.0), DVec3::new(0.0, 2.0, -0.4), DVec3::new(0.1, 0.0, 0.5));
        let center = DVec3::new(3.0, 4.0, 5.0);
        let points: Vec<_> = sphere_points(24).iter().map(|p| vector(center + map * *p)).collect();
        let (vertices, faces) = convex_hull(&points);
        let vertices = vertices.iter().map(|p| crate::convert::from_vector(*p)).collect();
        let mesh = Solid::Mesh { triangles: Triangles { vertices, faces }, is_closed: true };
        let (a, b) = (properties(&Solid::Ellipsoid { center, map }).unwrap(), properties(&mesh).unwrap());
        assert!((b.mass() / a.mass() - 1.0).abs() < 0.01, "{} {}", a.mass(), b.mass());
        assert!((a.local_com - b.local_com).length() < 1e-3);
        let (a, b) = (a.reconstruct_inertia_matrix(), b.reconstruct_inertia_matrix());
        let differences = (a - b).to_cols_array();
        assert!(differences.iter().all(|d| d.abs() < 0.02 * a.x_axis.x), "{a} {b}");
    }

    #[test]
    fn balls_and_boxes() {
        let ball = properties(&Solid::Ball { center: DVec3::X, radius: 2.0 }).unwrap();
        let mass = 4.0 / 3.0 * std::f64::consts::PI * 8.0;
        assert!((ball.mass() / mass - 1.0).abs() < 1e-14);
        assert!((ball.principal_inertia() / mass - vector(DVec3::splat(0.4 * 4.0))).length() < 1e-12);
        let half = DVec3::new(1.0, 2.0, 3.0);
        let cube = properties(&Solid::Box { center: DVec3::ZERO, rotation: Default::default(), half }).unwrap();
        assert!((cube.mass() - 48.0).abs() < 1e-12);
        let inertia = cube.reconstruct_inertia_matrix() / 48.0 * 3.0;
        assert!((inertia.x_axis.x - 13.0).abs() < 1e-12 && (inertia.z_axis.z - 5.0).abs() < 1e-12);
    }
}
