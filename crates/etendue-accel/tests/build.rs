//! What the builder refuses, what it makes of awkward worlds, and how precise hits are.
#![allow(clippy::disallowed_methods)]

mod common;

use common::*;
use etendue_accel::{
    Accelerator, AcceleratorKind, BuildError, Geometry, Hit, Instance, Isa, Place, PrimitiveId, Ray, Sphere, Transform,
    World,
};

const UNIT: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn refused(world: &World) -> BuildError {
    let errors = AcceleratorKind::ALL.map(|kind| Accelerator::build(world, kind, Isa::detect(), 1).unwrap_err());
    assert!(errors.iter().all(|error| *error == errors[0] || format!("{error:?}") == format!("{:?}", errors[0])));
    errors[0].clone()
}

#[test]
fn bad_worlds_are_refused_with_the_place() {
    let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let bad_index = world_of(&mesh(corners.clone(), vec![[0, 1, 2], [0, 3, 2]]));
    assert_eq!(refused(&bad_index), BuildError::Index { geometry: 0, face: 1, index: 3, vertices: 3 });
    for bad in [f32::NAN, f32::INFINITY, 1e16, -1e16] {
        let world = world_of(&mesh(vec![[0.0; 3], [0.0, bad, 0.0], [1.0; 3]], vec![[0, 1, 2]]));
        assert!(matches!(refused(&world), BuildError::Position { geometry: 0, vertex: 1, .. }), "{bad}");
        let sphere = Sphere { center: [0.0, bad, 0.0], radius: 1.0 };
        let world = World { geometries: vec![spheres(vec![sphere])], instances: vec![] };
        assert!(matches!(refused(&world), BuildError::Sphere { geometry: 0, sphere: 0, .. }), "{bad}");
    }
    for radius in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e16] {
        let world = World { geometries: vec![spheres(vec![Sphere { center: [0.0; 3], radius }])], instances: vec![] };
        assert!(matches!(refused(&world), BuildError::Sphere { .. }), "{radius}");
    }
    let missing = World { geometries: vec![], instances: vec![plain(0)] };
    assert_eq!(refused(&missing), BuildError::Geometry { instance: 0, index: 0, geometries: 0 });
}

#[test]
fn bad_transforms_are_refused() {
    let object = triangles(&subdivided_box(1));
    let good = Transform::new([[2.0, 0.0, 0.0, 1.0], [0.0, 2.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]]).unwrap();
    let mut not_inverse = good;
    not_inverse.to_object[0][0] = 0.25;
    let mut singular = good;
    singular.to_world[1] = [0.0; 4];
    let mut nan = good;
    nan.to_world[2][3] = f32::NAN;
    let huge = Transform::new([[1e12, 0.0, 0.0, 0.0], [0.0, 1e12, 0.0, 0.0], [0.0, 0.0, 1e12, 0.0]]).unwrap();
    let far = Transform::new([[1.0, 0.0, 0.0, 2e15], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]).unwrap();
    for transform in [not_inverse, singular, nan, huge, far] {
        let instances = vec![plain(0), Instance { geometry: 0, place: Place::Fixed(transform), mask: 1 }];
        let world = World { geometries: vec![object.clone()], instances };
        assert!(matches!(refused(&world), BuildError::Transform { instance: 1, .. }), "{transform:?}");
    }
}

#[test]
fn identical_triangles_in_great_number() {
    let count = 100_000;
    let same = mesh(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]; count]);
    let points = mesh(vec![[0.25, 0.25, 0.5]], vec![[0, 0, 0]; count]);
    let one = mesh(same.positions.to_vec(), vec![[0, 1, 2]]);
    let mut instances = vec![plain(1), plain(0), placed(0, UNIT, [0.0; 3])];
    instances.extend((0..10_000).map(|_| placed(2, UNIT, [0.0; 3])));
    let world = World { geometries: vec![triangles(&same), triangles(&points), triangles(&one)], instances };
    for kind in AcceleratorKind::ALL {
        let accelerator = Accelerator::build(&world, kind, Isa::detect(), 2).unwrap();
        if kind == AcceleratorKind::Brute {
            continue;
        }
        let mut hits = [Hit::MISS];
        let skip = PrimitiveId { instance: 1, primitive: 0 };
        let down = ray([0.25, 0.25, 1.0], [0.0, 0.0, -1.0]);
        accelerator.closest_hits(&[down], &mut hits);
        assert_eq!((hits[0].t, hits[0].id), (1.0, skip), "{kind}");
        accelerator.closest_hits(&[Ray { skip, ..down }], &mut hits);
        assert_eq!(hits[0].id, PrimitiveId { instance: 1, primitive: 1 }, "{kind}");
        assert!(accelerator.stats().depth < 100, "{kind} {:?}", accelerator.stats());
    }
}

/// Items at ever smaller distances make splits by cost peel off one at a time.
#[test]
fn chains_do_not_get_deep() {
    let mut list = Vec::new();
    for i in 0..3000 {
        let x = 1e15 * 0.97_f64.powi(i);
        list.push(Sphere { center: [x as f32 * 0.5, 0.0, 0.0], radius: (x * 1e-3) as f32 + 1e-30 });
    }
    let world = World { geometries: vec![spheres(list)], instances: vec![plain(0)] };
    for kind in AcceleratorKind::ALL {
        let accelerator = Accelerator::build(&world, kind, Isa::detect(), 2).unwrap();
        assert!(accelerator.stats().depth <= 64, "{kind}: {:?}", accelerator.stats());
    }
}

#[test]
fn parameters_and_weights_are_precise() {
    let mut rng = Rng(31);
    let shape = mapped(&ball(4), |p| add(scale(p, 3.0), [10.0, -5.0, 2.0]));
    let accelerator = Accelerator::build(&world_of(&shape), AcceleratorKind::Bvh, Isa::detect(), 2).unwrap();
    let mut found = 0;
    for _ in 0..ray_count() / 20 {
        let origin = add([10.0, -5.0, 2.0], rng.point(8.0));
        let target = add([10.0, -5.0, 2.0], rng.point(2.0));
        let ray = ray(origin, sub(target, origin));
        let mut hits = [Hit::MISS];
        accelerator.closest_hits(&[ray], &mut hits);
        let [hit] = hits;
        if !hit.is_hit() {
            continue;
        }
        found += 1;
        let corners = shape.indices[hit.id.primitive as usize].map(|i| shape.positions[i as usize].map(f64::from));
        let weights = [1.0 - f64::from(hit.u) - f64::from(hit.v), f64::from(hit.u), f64::from(hit.v)];
        assert!(weights.iter().all(|&w| (-1e-7..=1.0).contains(&w)), "{hit:?}");
        let length = f64::from(dot(ray.direction, ray.direction)).sqrt();
        for (axis, (origin, direction)) in ray.origin.into_iter().zip(ray.direction).enumerate() {
            let by_weights: f64 = weights.iter().zip(&corners).map(|(weight, corner)| weight * corner[axis]).sum();
            let by_ray = f64::from(origin) + f64::from(hit.t) * f64::from(direction);
            assert!((by_weights - by_ray).abs() < 1e-5, "{by_weights} {by_ray} {hit:?} {ray:?}");
        }
        let expected = plane_parameter(&ray, corners);
        // Grazing rays amplify what the corners lose when they are sheared.
        let [e, f] = [1, 2].map(|i| [0, 1, 2].map(|a| (corners[i][a] - corners[0][a]) as f32));
        let normal = cross(e, f);
        let cosine = f64::from(dot(normal, ray.direction).abs() / dot(normal, normal).sqrt()) / length;
        let error = (f64::from(hit.t) - expected).abs() * length;
        assert!(error * cosine < 4e-6, "{error} {cosine} {hit:?} {ray:?}");
    }
    assert!(found > 1000);
}

fn plane_parameter(ray: &Ray, corners: [[f64; 3]; 3]) -> f64 {
    let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let (e, f) = (minus(corners[1], corners[0]), minus(corners[2], corners[0]));
    let normal = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
    let along = |v: [f64; 3]| (0..3).map(|i| normal[i] * v[i]).sum::<f64>();
    along(minus(corners[0], ray.origin.map(f64::from))) / along(ray.direction.map(f64::from))
}

#[test]
fn masks_and_skips_count_per_instance() {
    let shape = triangles(&ball(1));
    let instances = vec![
        Instance { mask: 1, ..plain(0) },
        Instance { mask: 2, ..placed(0, UNIT, [0.0; 3]) },
        Instance { mask: 4, ..placed(0, UNIT, [0.0, 0.0, -4.0]) },
    ];
    let world = World { geometries: vec![shape], instances };
    for (name, accelerator) in all_accelerators(&world) {
        let hit_of = |ray: Ray| {
            let mut hits = [Hit::MISS];
            accelerator.closest_hits(&[ray], &mut hits);
            hits[0]
        };
        let base = ray([0.1, 0.2, 5.0], [0.0, 0.0, -1.0]);
        for (mask, instance) in [(u32::MAX, 0), (6, 1), (4, 2), (8, u32::MAX), (0, u32::MAX)] {
            assert_eq!(hit_of(Ray { mask, ..base }).id.instance, instance, "{name}, mask {mask}");
        }
        let first = hit_of(base);
        let second = hit_of(Ray { skip: first.id, ..base });
        assert_eq!((second.t, second.id.instance, second.id.primitive), (first.t, 1, first.id.primitive), "{name}");
    }
}

#[test]
fn bounds_hold_the_world() {
    let world = World {
        geometries: vec![triangles(&ball(2)), Geometry::Spheres([Sphere { center: [0.0; 3], radius: 2.0 }].into())],
        instances: vec![plain(1), placed(0, [[0.0, -3.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], [10.0, 0.0, 0.0])],
    };
    for (name, accelerator) in all_accelerators(&world) {
        let bounds = accelerator.bounds().unwrap();
        assert_eq!((bounds.min, bounds.max), ([-2.0, -2.0, -2.0], [13.0, 2.0, 2.0]), "{name}");
        assert_eq!(accelerator.stats().primitives, 129, "{name}");
    }
}
