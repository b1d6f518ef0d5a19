//! Worlds whose instances move are what a fresh build would make of them, for rays to the bit.
#![allow(clippy::disallowed_methods)]

mod common;

use common::*;
use etendue_accel::{
    Accelerator, AcceleratorKind, BuildError, Geometry, Hit, Instance, Isa, Motion, Place, Ray, RigidKey, Sphere,
    Transform, World,
};

/// Some still triangles and balls, and as many moving things.
fn world(rng: &mut Rng, still: usize, moving: usize) -> World {
    let corners: Vec<[f32; 3]> = (0..3 * still).map(|_| rng.point(2.0)).collect();
    let faces = (0..still as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let geometries = vec![
        triangles(&mesh(corners, faces)),
        triangles(&subdivided_box(2)),
        spheres(vec![Sphere { center: [0.5; 3], radius: 0.5 }]),
        Geometry::Spheres([].into()),
        // The ground, which covers all the rest.
        triangles(&mapped(&subdivided_box(1), |[x, y, z]| [300.0 * x, 300.0 * y, 0.1 * z])),
    ];
    let mut instances = vec![plain(0), plain(2)];
    instances.extend((0..moving).map(|i| Instance { mask: [1, 3][i % 2], ..placed(1 + i as u32 % 3, UNIT, [0.0; 3]) }));
    instances.push(plain(4));
    World { geometries, instances }
}

const UNIT: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// New places within a distance; far ones make a tree built for near ones useless.
fn move_all(rng: &mut Rng, world: &mut World, size: f32, reach: f32) -> Vec<Place> {
    for instance in world.instances.iter_mut().filter(|instance| instance.place.is_transformed()) {
        let (linear, shift) = (rng.linear().map(|row| scale(row, size)), rng.point(reach));
        let next = match rng.chance(0.5) {
            true => placed(0, linear, shift),
            false => moving(rng, 0, linear, shift, 3, 0.1 * reach),
        };
        instance.place = next.place;
    }
    places_of(world)
}

fn places_of(world: &World) -> Vec<Place> {
    world.instances.iter().map(|instance| instance.place.clone()).collect()
}

/// Half of the rays go anywhere, half to where instances are.
fn same_hits(rng: &mut Rng, world: &World, moved: &Accelerator, fresh: &Accelerator, reach: f32) -> usize {
    let places: Vec<&Place> = world.instances.iter().map(|i| &i.place).filter(|place| place.is_transformed()).collect();
    let random = |rng: &mut Rng| {
        let (origin, time) = (rng.point(reach), rng.unit() as f32);
        let there = rng.pick(&places).at(time).expect("a transform").point_to_world([0.2; 3]);
        let direction = if rng.chance(0.5) { sub(there, origin) } else { rng.direction() };
        Ray { mask: *rng.pick(&[1, 2, u32::MAX]), time, ..ray(origin, direction) }
    };
    let rays: Vec<Ray> = (0..2000).map(|_| random(rng)).collect();
    let (mut hits, mut expected) = (vec![Hit::MISS; rays.len()], vec![Hit::MISS; rays.len()]);
    moved.closest_hits(&rays, &mut hits);
    fresh.closest_hits(&rays, &mut expected);
    assert_eq!(hits, expected);
    let mut any = vec![false; rays.len()];
    moved.any_hits(&rays, &mut any);
    assert!(hits.iter().zip(&any).all(|(hit, &any)| hit.is_hit() == any));
    assert_eq!(moved.bounds(), fresh.bounds());
    hits.iter().filter(|hit| hit.is_hit()).count()
}

#[test]
fn moved_worlds_are_as_if_fresh() {
    for (still, moving) in [(50, 60), (0, 1), (300, 5000), (6000, 40)] {
        let mut rng = Rng(77);
        let mut world = world(&mut rng, still, moving);
        let size = 2.0 / (moving as f32).cbrt();
        move_all(&mut rng, &mut world, size, 2.0);
        for kind in AcceleratorKind::ALL {
            if kind == AcceleratorKind::Brute && still + moving > 1000 {
                continue;
            }
            let mut moved = Accelerator::build(&world, kind, Isa::detect(), 1).unwrap();
            for reach in [2.1, 40.0, 2.0] {
                let mut next = world.clone();
                let places = move_all(&mut rng, &mut next, size, reach);
                moved = moved.with_places(places, 2).unwrap();
                let fresh = Accelerator::build(&next, kind, Isa::detect(), 1).unwrap();
                let found = same_hits(&mut rng, &next, &moved, &fresh, 1.2 * reach);
                assert!(found > 200, "{kind} {still} {moving} {reach}: {found} hits say little");
            }
        }
    }
}

#[test]
fn what_moves_for_the_first_time_is_built() {
    let mut rng = Rng(5);
    let mut still = world(&mut rng, 500, 3);
    move_all(&mut rng, &mut still, 1.0, 1.0);
    for kind in AcceleratorKind::ALL {
        let mut next = still.clone();
        next.instances[0].place = placed(0, UNIT, [0.1, 0.2, 0.3]).place;
        let built = Accelerator::build(&still, kind, Isa::detect(), 1).unwrap();
        let moved = built.with_places(places_of(&next), 1).unwrap();
        let fresh = Accelerator::build(&next, kind, Isa::detect(), 1).unwrap();
        assert!(same_hits(&mut rng, &next, &moved, &fresh, 2.0) > 50);
    }
}

#[test]
fn bad_transforms_are_refused() {
    let mut rng = Rng(6);
    let still = world(&mut rng, 5000, 3);
    let good = places_of(&still);
    for kind in AcceleratorKind::ALL {
        let build = || Accelerator::build(&still, kind, Isa::detect(), 1).unwrap();
        let error = build().with_places(good[1..].to_vec(), 1).unwrap_err();
        assert_eq!(error, BuildError::Places { places: 5, instances: 6 });
        let mut nan = good.clone();
        nan[2] = Place::Fixed(Transform { to_world: [[f32::NAN; 4]; 3], ..Transform::IDENTITY });
        let mut far = good.clone();
        let rows = [[1e11, 0.0, 0.0, 1.125_899_8e15], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        far[2] = Place::Fixed(Transform::new(rows).unwrap());
        let key = |time, x| RigidKey { time, rotation: [0.0, 0.0, 0.0, 1.0], translation: [x, 0.0, 0.0] };
        let unit = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let mut gone = good.clone();
        gone[2] = Place::Moving(Motion::new(unit, &[key(0.0, 0.0), key(1.0, 2e15)]).unwrap().into());
        for bad in [nan, far, gone] {
            let error = build().with_places(bad, 1).unwrap_err();
            assert!(matches!(error, BuildError::Transform { instance: 2, .. }), "{error:?}");
        }
    }
}
