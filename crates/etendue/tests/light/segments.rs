//! Shadow rays to targets, traced through the geometry that the light belongs to.

use super::{
    cases::{self, Case},
    directions::margin,
    samples,
};
use etendue::{
    light::{Light, LightSample},
    math::Vec3,
};
use etendue_accel::{
    Accelerator, AcceleratorKind, Geometry, Instance, Isa, Place, PrimitiveId, Ray, Sphere, Transform, TriangleMesh,
    World,
};
use etendue_testkit::Rng;

fn triangles(positions: &[[f32; 3]], indices: &[[u32; 3]]) -> Geometry {
    Geometry::Triangles(TriangleMesh { positions: positions.into(), indices: indices.into() })
}

/// The light's surface alone, as a scene has it.
fn geometry(light: &Light) -> Option<(Geometry, Option<Transform>)> {
    match light {
        Light::Triangle(t) => Some((triangles(&t.vertices.map(|v| v.to_array()), &[[0, 1, 2]]), None)),
        Light::Rectangle(r) => {
            let corners = [r.corner, r.corner + r.u, r.corner + r.u + r.v, r.corner + r.v];
            Some((triangles(&corners.map(|v| v.to_array()), &[[0, 1, 2], [0, 2, 3]]), None))
        }
        Light::Disk(d) => {
            let positions: Vec<[f32; 3]> =
                d.outline.rim().step_by(250).map(|corner| corner.as_vec3().to_array()).collect();
            let faces: Vec<[u32; 3]> = (2..positions.len() as u32).map(|i| [0, i - 1, i]).collect();
            Some((triangles(&positions, &faces), None))
        }
        Light::Sphere(s) => {
            let [x, y, z] = s.axes;
            let row = |i: usize| [x[i], y[i], z[i], s.center[i]];
            let unit = Sphere { center: [0.0; 3], radius: 1.0 };
            Some((Geometry::Spheres([unit].into()), Transform::new([row(0), row(1), row(2)])))
        }
        _ => None,
    }
}

fn accelerator(geometry: Geometry, transform: Option<Transform>) -> Accelerator {
    let place = transform.map_or(Place::World, Place::Fixed);
    let instances = vec![Instance { geometry: 0, place, mask: u32::MAX }];
    let world = World { geometries: vec![geometry], instances };
    Accelerator::build(&world, AcceleratorKind::Brute, Isa::Portable, 1).unwrap()
}

fn shadow_ray(case: &Case, sample: &LightSample) -> Ray {
    Ray {
        origin: case.ctx.point.to_array(),
        t_min: 0.0,
        direction: (sample.target.unwrap() - case.ctx.point).to_array(),
        t_max: 1.0,
        time: 0.0,
        mask: u32::MAX,
        skip: PrimitiveId::NONE,
    }
}

/// The least width of the light, roughly.
fn width(light: &Light) -> f32 {
    let across = |u: Vec3, v: Vec3| u.cross(v).length() / u.length().max(v.length()).max((u - v).length());
    match light {
        Light::Triangle(t) => across(t.vertices[1] - t.vertices[0], t.vertices[2] - t.vertices[0]),
        Light::Rectangle(r) => across(r.u, r.v),
        Light::Sphere(s) => 0.5 * s.axes[0].length().min(s.axes[1].length()).min(s.axes[2].length()),
        _ => 0.0,
    }
}

/// The segment to a target never meets the light itself; beyond the target it does.
#[test]
fn targets_are_reached_without_touching_the_light() {
    let n = samples(300, 30_000);
    let mut aimed = 0;
    for case in cases::with_surface() {
        let Some((geometry, transform)) = geometry(&case.light) else { continue };
        let accelerator = accelerator(geometry, transform);
        let mut rng = Rng::new(11);
        let rays: Vec<Ray> = (0..n)
            .filter_map(|_| case.light.sample(&case.ctx, rng.f32x2()).map(|sample| shadow_ray(&case, &sample)))
            .collect();
        let mut occluded = vec![true; rays.len()];
        accelerator.any_hits(&rays, &mut occluded);
        let stopped = occluded.iter().filter(|&&o| o).count();
        assert_eq!(stopped, 0, "{}: of {} segments", case.name, rays.len());
        if margin(&case) > 1e-3 * f64::from(width(&case.light)) {
            continue; // the lift may show the light's rim
        }
        let beyond: Vec<Ray> = rays.iter().map(|ray| Ray { t_max: f32::INFINITY, ..*ray }).collect();
        accelerator.any_hits(&beyond, &mut occluded);
        let reached = occluded.iter().filter(|&&o| o).count();
        let (name, all) = (&case.name, rays.len());
        // Grazing rays to lifted targets pass over the rim.
        assert!(10 * reached >= 7 * all, "{name}: only {reached} of {all} point at the light");
        aimed += usize::from(all > 0);
    }
    assert!(aimed > 100, "only {aimed} cases were aimed");
}
