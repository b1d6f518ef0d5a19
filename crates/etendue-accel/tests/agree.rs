//! All accelerators on all instruction sets give the same hits, bit for bit, on rays and worlds chosen to hurt.
#![allow(clippy::disallowed_methods)]

mod common;

use common::*;
use etendue_accel::{
    Accelerator, AcceleratorKind, Geometry, Hit, Instance, Isa, Motion, Place, PrimitiveId, Ray, RigidKey, Sphere,
    World,
};

/// Rays are compared in slices of this length; odd, so that slices end anywhere.
const SLICE: usize = 997;

/// Points that rays are aimed at or start from, in world space.
struct Targets {
    /// Corners of triangles.
    faces: Vec<[[f32; 3]; 3]>,
    centers: Vec<([f32; 3], f32)>,
    ids: Vec<PrimitiveId>,
    reach: f32,
}

impl Targets {
    fn of(world: &World) -> Self {
        let mut targets = Self { faces: Vec::new(), centers: Vec::new(), ids: Vec::new(), reach: 0.0 };
        for (index, instance) in world.instances.iter().enumerate() {
            let geometry = &world.geometries[instance.geometry as usize];
            let times: &[f32] = if let Place::Moving(_) = instance.place { &[0.0, 0.3, 1.0] } else { &[0.0] };
            for &time in times {
                let place = instance.place.at(time);
                let map = |p: [f32; 3]| place.map_or(p, |transform| transform.point_to_world(p));
                match geometry {
                    Geometry::Triangles(mesh) => {
                        let faces = mesh.indices.iter().map(|face| face.map(|i| map(mesh.positions[i as usize])));
                        targets.faces.extend(faces);
                    }
                    Geometry::Spheres(list) => {
                        targets.centers.extend(list.iter().map(|sphere| (map(sphere.center), sphere.radius)));
                    }
                }
            }
            let id = |primitive| PrimitiveId { instance: index as u32, primitive };
            targets.ids.extend((0..geometry.len() as u32).map(id));
        }
        let points = targets.faces.iter().flatten().chain(targets.centers.iter().map(|(center, _)| center));
        targets.reach = points.flatten().fold(1e-30, |reach, x| reach.max(x.abs()));
        targets
    }

    /// A corner, a point of an edge, inside a face or on a sphere.
    fn point(&self, rng: &mut Rng) -> [f32; 3] {
        if self.faces.is_empty() || (!self.centers.is_empty() && rng.chance(0.3)) {
            let Some(&(center, radius)) = (!self.centers.is_empty()).then(|| rng.pick(&self.centers)) else {
                return rng.point(self.reach);
            };
            let factor = *rng.pick(&[0.0, 0.5, 0.999_999, 1.0, 1.000_001]);
            return add(center, scale(rng.direction(), radius * factor));
        }
        let [a, b, c] = *rng.pick(&self.faces);
        let along = |p: [f32; 3], q: [f32; 3], s: f32| add(p, scale(sub(q, p), s));
        match rng.below(4) {
            0 => a,
            1 => along(a, b, 0.5),
            2 => along(a, b, rng.range(0.0, 1.0)),
            _ => along(along(a, b, rng.range(0.0, 1.0)), c, rng.range(0.0, 1.0)),
        }
    }

    fn ray(&self, rng: &mut Rng) -> Ray {
        let target = self.point(rng);
        let (origin, mut direction) = match rng.below(7) {
            // Along an axis through a point of the world, from outside or from the point itself.
            0 => {
                let axis = rng.below(3);
                let mut direction = [*rng.pick(&[0.0, -0.0]), *rng.pick(&[0.0, -0.0]), *rng.pick(&[0.0, -0.0])];
                direction[axis] = *rng.pick(&[1.0, -1.0, 3.0, -0.1]);
                let back = *rng.pick(&[0.0, 0.5, 2.0, 4.0]) * self.reach;
                (sub(target, scale(direction, back)), direction)
            }
            // In a plane of the axes.
            1 => {
                let mut direction = rng.direction();
                direction[rng.below(3)] = *rng.pick(&[0.0, -0.0, 1e-30, -1e-39]);
                (sub(target, scale(direction, self.reach)), direction)
            }
            // From one point of the world to another: along faces and edges, and through corners.
            2 | 3 => {
                let origin = self.point(rng);
                (origin, sub(target, origin))
            }
            // From far away.
            4 => {
                // The pads of the farthest hold the whole world, so that everything is tested.
                let far = *rng.pick(&[3.0, 10.0, 30.0, 100.0, 300.0, 1e3, 3e3, 1e4, 1e4, 1e5, 1e6, 1e7]) * self.reach;
                let origin = scale(rng.direction(), far);
                (origin, scale(sub(target, origin), *rng.pick(&[1.0, 1e-3, 1e-6])))
            }
            // Grazing: almost along a side of the box.
            5 => {
                let mut direction = scale(rng.direction(), *rng.pick(&[1e-7, 1e-5, 1e-3]));
                direction[rng.below(3)] = *rng.pick(&[1.0, -1.0]);
                (sub(target, scale(direction, self.reach * rng.range(0.0, 3.0))), direction)
            }
            _ => (rng.point(self.reach * 1.5), rng.direction()),
        };
        if rng.chance(0.01) {
            let bad = *rng.pick(&[0.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e-42, f32::MAX]);
            direction = [bad, *rng.pick(&[0.0, bad]), *rng.pick(&[-0.0, bad])];
        }
        let mut ray = ray(origin, direction);
        if rng.chance(0.01) {
            ray.origin[rng.below(3)] = *rng.pick(&[f32::NAN, f32::INFINITY, f32::MAX, -1e20]);
        }
        if rng.chance(0.3) {
            let length = self.reach / dot(direction, direction).sqrt().max(1e-30);
            (ray.t_min, ray.t_max) = *rng.pick(&[
                (0.0, length),
                (0.0, 1.0),
                (0.5 * length, 2.0 * length),
                (1.0, f32::INFINITY),
                (1.0, 1.0),
                (2.0, 1.0),
                (-5.0, 1.0),
                (f32::NAN, 1.0),
                (0.0, f32::NAN),
            ]);
        }
        if rng.chance(0.3) {
            ray.mask = *rng.pick(&[0, 1, 2, 3, 0x8000_0000]);
        }
        let at_random = rng.unit() as f32;
        ray.time = *rng.pick(&[0.0, 1.0, 0.3, at_random, at_random, -1.0, 2.0, f32::NAN]);
        if rng.chance(0.4) && !self.ids.is_empty() {
            ray.skip = *rng.pick(&self.ids);
        }
        ray
    }
}

impl Targets {
    /// A ray a little beside another: from the same point or from near it.
    fn beside(&self, mut ray: Ray, rng: &mut Rng) -> Ray {
        let length = dot(ray.direction, ray.direction).sqrt();
        ray.direction = add(ray.direction, scale(rng.direction(), length * *rng.pick(&[0.0, 1e-4, 0.03])));
        ray.origin = add(ray.origin, scale(rng.direction(), self.reach * *rng.pick(&[0.0, 0.0, 1e-3])));
        ray.time = if rng.chance(0.5) { rng.unit() as f32 } else { ray.time };
        if rng.chance(0.2) {
            ray.t_max = *rng.pick(&[f32::INFINITY, self.reach / length, 0.5]);
            ray.mask = *rng.pick(&[!0, 1, 2]);
            ray.skip = if self.ids.is_empty() { PrimitiveId::NONE } else { *rng.pick(&self.ids) };
        }
        ray
    }
}

fn bits(hit: &Hit) -> [u32; 5] {
    [hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.id.instance, hit.id.primitive]
}

/// What [`Accelerator::closest_facets`] is to give beside a hit.
fn facet(world: &World, hit: &Hit) -> [[f32; 3]; 3] {
    let instance = world.instances.get(hit.id.instance as usize);
    match instance.map(|instance| &world.geometries[instance.geometry as usize]) {
        Some(Geometry::Triangles(mesh)) => {
            mesh.indices[hit.id.primitive as usize].map(|corner| mesh.positions[corner as usize])
        }
        _ => [[0.0; 3]; 3],
    }
}

/// Compares everything on random rays; gives how many hit.
fn compare(name: &str, world: &World, count: usize, seed: u64) -> usize {
    let targets = Targets::of(world);
    let accelerators = all_accelerators(world);
    let (_, reference) = &accelerators[0];
    let mut rng = Rng(seed);
    let mut found = 0;
    let mut rays: Vec<Ray> = Vec::new();
    let (mut expected, mut hits, mut occluded) = (Vec::new(), Vec::new(), Vec::new());
    let mut facets = Vec::new();
    let mut left = count;
    while left > 0 {
        let slice = left.min(SLICE);
        left -= slice;
        rays.clear();
        // In every second slice most rays go beside the one before them, as those of a camera do.
        let together = (left / SLICE).is_multiple_of(2);
        // Some of the rays leave hits of the rays before them, skipping what they left, as paths do.
        for _ in 0..slice {
            if let Some(&last) = rays.last()
                && together
                && !rng.chance(0.02)
            {
                rays.push(targets.beside(last, &mut rng));
                continue;
            }
            let mut next = targets.ray(&mut rng);
            if rng.chance(0.3) && !expected.is_empty() {
                let (previous, hit): &(Ray, Hit) = rng.pick(&expected);
                if hit.is_hit() {
                    next.origin = add(previous.origin, scale(previous.direction, hit.t));
                    next.skip = hit.id;
                }
            }
            rays.push(next);
        }
        hits.clear();
        hits.resize(slice, Hit::MISS);
        reference.closest_hits(&rays, &mut hits);
        expected.clear();
        expected.extend(rays.iter().copied().zip(hits.iter().copied()));
        found += hits.iter().filter(|hit| hit.is_hit()).count();
        for (kind, accelerator) in &accelerators {
            hits.fill(Hit { t: -1.0, ..Hit::MISS });
            accelerator.closest_hits(&rays, &mut hits);
            for ((ray, expected), hit) in expected.iter().zip(&hits) {
                assert_eq!(bits(expected), bits(hit), "{name}, {kind}: {expected:?} {hit:?} {ray:?}");
            }
            hits.fill(Hit { t: -1.0, ..Hit::MISS });
            facets.clear();
            facets.resize(slice, [[f32::NAN; 3]; 3]);
            accelerator.closest_facets(&rays, &mut hits, &mut facets);
            for (((ray, expected), hit), corners) in expected.iter().zip(&hits).zip(&facets) {
                assert_eq!(bits(expected), bits(hit), "{name}, {kind}, with facets: {expected:?} {hit:?} {ray:?}");
                assert_eq!(facet(world, hit), *corners, "{name}, {kind}: facet of {hit:?} {ray:?}");
            }
            occluded.clear();
            occluded.resize(slice, false);
            accelerator.any_hits(&rays, &mut occluded);
            for ((ray, expected), &any) in expected.iter().zip(&occluded) {
                assert_eq!(expected.is_hit(), any, "{name}, {kind}, any hit: {expected:?} {ray:?}");
            }
            if kind.starts_with("bvh") {
                compare_few(&format!("{name}, {kind}"), (world, accelerator), &rays, &expected);
            }
        }
    }
    found
}

/// The same rays, few a call.
fn compare_few(name: &str, (world, accelerator): (&World, &Accelerator), rays: &[Ray], expected: &[(Ray, Hit)]) {
    let (mut start, mut sizes) = (0, [1, 2, 3, 7, 8, 15, 16].into_iter().cycle());
    while let Some(size) = sizes.next().filter(|_| start < rays.len()) {
        let end = rays.len().min(start + size);
        let (mut hits, mut occluded) = ([Hit { t: -1.0, ..Hit::MISS }; 16], [false; 16]);
        let mut facets = [[[f32::NAN; 3]; 3]; 16];
        accelerator.closest_facets(&rays[start..end], &mut hits[..end - start], &mut facets[..end - start]);
        for (hit, corners) in hits[..end - start].iter().zip(&facets) {
            assert_eq!(facet(world, hit), *corners, "{name}, {size} a call: {hit:?}");
        }
        accelerator.closest_hits(&rays[start..end], &mut hits[..end - start]);
        accelerator.any_hits(&rays[start..end], &mut occluded[..end - start]);
        for (((ray, expected), hit), any) in expected[start..end].iter().zip(&hits).zip(occluded) {
            assert_eq!(bits(expected), bits(hit), "{name}, {size} a call: {expected:?} {hit:?} {ray:?}");
            assert_eq!(expected.is_hit(), any, "{name}, {size} a call, any hit: {expected:?} {ray:?}");
        }
        start = end;
    }
}

fn check(name: &str, world: &World) {
    // Ten worlds share the rays of the whole test.
    let count = ray_count() / 10;
    let found = compare(name, world, count, 0x5EED ^ name.len() as u64);
    let share = found as f64 / count as f64;
    assert!(share > 0.12 && share < 0.99, "{name}: {share} of the rays hit, so the test says little");
}

fn soup(rng: &mut Rng, count: usize, size: f32) -> Geometry {
    let mut positions = Vec::new();
    for _ in 0..count {
        let center = rng.point(1.0);
        positions.extend((0..3).map(|_| add(center, rng.point(size))));
    }
    triangles(&mesh(positions, (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()))
}

#[test]
fn closed_meshes() {
    let boxes = triangles(&mapped(&subdivided_box(4), |p| scale(p, 0.75)));
    let world = World { geometries: vec![boxes, triangles(&ball(2))], instances: vec![plain(0), plain(1)] };
    check("closed meshes", &world);
}

/// All triangles are of one instance, so that what a ray left is told by its number alone.
#[test]
fn one_mesh() {
    check("one mesh", &world_of(&torus(40, 20)));
}

/// What a ray left has a number and an instance: the same number elsewhere is something else.
#[test]
fn a_face_of_another_instance_is_not_skipped() {
    let ball = ball(3);
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let geometries = || vec![triangles(&ball)];
    let alone = World { geometries: geometries(), instances: vec![plain(0)] };
    let pair = vec![placed(0, identity, [-5.0, 0.0, 0.0]), placed(0, identity, [0.0; 3])];
    for (world, instance) in [(alone, 0), (World { geometries: geometries(), instances: pair }, 1)] {
        for (kind, accelerator) in all_accelerators(&world) {
            for (primitive, face) in ball.indices.iter().enumerate() {
                let [a, b, c] = face.map(|corner| ball.positions[corner as usize]);
                let middle = scale(add(add(a, b), c), 1.0 / 3.0);
                let id = PrimitiveId { instance, primitive: primitive as u32 };
                let outside = ray(scale(middle, 2.0), scale(middle, -1.0));
                for (skip, is_seen) in [(PrimitiveId { instance: 1 - instance, ..id }, true), (id, false)] {
                    let mut hit = [Hit::MISS];
                    accelerator.closest_hits(&[Ray { skip, ..outside }], &mut hit);
                    assert!(hit[0].is_hit());
                    assert_eq!(hit[0].id == id, is_seen, "{kind}: {primitive} {hit:?}");
                }
            }
        }
    }
}

#[test]
fn coincident_faces() {
    // The same faces in one geometry twice, in two instances, and as a shifted neighbour in the same planes.
    let grid = subdivided_box(3);
    let twice = mesh(grid.positions.to_vec(), grid.indices.iter().chain(grid.indices.iter()).copied().collect());
    let shifted = mapped(&grid, |p| [p[0] + 2.0 / 3.0, p[1], p[2]]);
    let world = World {
        geometries: vec![triangles(&twice), triangles(&grid), triangles(&shifted)],
        instances: vec![
            plain(2),
            Instance { mask: 2, ..plain(1) },
            plain(0),
            placed(1, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [0.0; 3]),
            placed(0, [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]], [0.0; 3]),
            placed(0, [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [0.0; 3]),
        ],
    };
    check("coincident faces", &world);
}

#[test]
fn slivers() {
    let mut rng = Rng(11);
    let mut positions = Vec::new();
    for i in 0..300 {
        let a = rng.point(1.0);
        let b = if i % 3 == 0 { rng.point(1.0) } else { add(a, scale([1.0, 1.0, 1.0], rng.range(0.1, 1.0))) };
        // Thin by a few bits, of no width, or of no length.
        let c = match i % 5 {
            0 => add(add(a, scale(sub(b, a), 0.5)), rng.point(1e-7)),
            1 => add(add(a, scale(sub(b, a), rng.range(-1.0, 2.0))), rng.point(1e-6)),
            2 => add(b, rng.point(1e-7)),
            3 => b,
            _ => add(add(a, scale(sub(b, a), 0.25)), rng.point(1e-4)),
        };
        positions.extend([a, b, c]);
    }
    let indices = (0..300).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let wide = soup(&mut rng, 60, 0.2);
    let world = World {
        geometries: vec![triangles(&mesh(positions, indices)), wide],
        instances: vec![plain(0), plain(1), placed(0, rng.linear(), [0.1, 0.2, 0.3])],
    };
    check("slivers", &world);
}

/// Long triangles any way round, which the tree holds in pieces: at rest, in instances, moving, twice, without area, beside even ones
/// and far from the origin.
#[test]
fn triangles_in_pieces() {
    for (index, shift) in [[0.0; 3], [300.0, -2000.0, 1000.0]].into_iter().enumerate() {
        let mut rng = Rng(24);
        let (mut positions, mut indices) = (Vec::new(), Vec::new());
        for i in 0..400_u32 {
            let (a, along) = (rng.point(1.0), scale(rng.direction(), rng.range(0.3, 1.5)));
            let b = add(a, along);
            let c = match i % 8 {
                0 => b,
                1 => add(a, scale(along, 0.5)),
                2 => add(a, scale(along, 0.3)).map(|x| x + 1e-7),
                3 => add(a, rng.point(1.0)),
                _ => add(a, rng.point(0.02)),
            };
            positions.extend([a, b, c].map(|p| add(p, shift)));
            indices.push([3 * i, 3 * i + 1, 3 * i + 2]);
            if i % 5 == 0 {
                indices.push([3 * i + 1, 3 * i, 3 * i + 2]);
            }
        }
        let geometries = vec![triangles(&mesh(positions, indices)), soup(&mut rng, 60, 0.2)];
        let linear = rng.linear();
        let middle = [0, 1, 2].map(|r| dot(linear[r], shift));
        let seen = Instance { mask: 2, ..plain(0) };
        let on_its_way = moving(&mut rng, 0, linear, sub(shift, middle), 3, 0.5);
        let instances = vec![plain(0), seen, placed(0, linear, sub(shift, middle)), on_its_way, plain(1)];
        let found = compare("pieces", &World { geometries, instances }, ray_count() / 32, index as u64);
        assert!(found > ray_count() / 320, "{index}: {found}");
    }
}

#[test]
fn nested_spheres() {
    let mut rng = Rng(12);
    let mut list: Vec<Sphere> = (1..12).map(|i| Sphere { center: [0.0, 0.1, 0.0], radius: 0.1 * i as f32 }).collect();
    list.push(list[3]);
    list.extend((0..60).map(|_| Sphere { center: rng.point(1.5), radius: 0.2 * rng.unit() as f32 + 1e-6 }));
    list.push(Sphere { center: [0.0, -1000.0, 0.0], radius: 999.0 });
    let world = World {
        geometries: vec![spheres(list), triangles(&subdivided_box(2))],
        instances: vec![
            plain(0),
            plain(1),
            placed(0, rng.linear(), [1.0, 0.0, 0.0]),
            placed(1, rng.linear(), [0.0; 3]),
        ],
    };
    check("nested spheres", &world);
}

#[test]
fn instances() {
    let mut rng = Rng(13);
    let geometries = vec![
        soup(&mut rng, 40, 0.4),
        triangles(&subdivided_box(2)),
        spheres(vec![Sphere { center: [0.5; 3], radius: 0.5 }]),
    ];
    let mut instances = vec![plain(0)];
    for i in 0..40 {
        let mut linear = rng.linear();
        match i % 4 {
            0 => linear = linear.map(|row| scale(row, 0.1)),
            1 => linear[0] = scale(linear[0], -1e-3),
            2 => linear = [[0.0, -0.5, 0.0], [0.5, 0.0, 0.0], [0.0, 0.0, if i % 8 == 2 { 0.5 } else { -0.5 }]],
            _ => linear[1] = scale(linear[1], 20.0),
        }
        let instance = placed(i % 3, linear, rng.point(2.0));
        instances.push(Instance { mask: *rng.pick(&[u32::MAX, 1, 2, 5, 0]), ..instance });
    }
    check("instances", &World { geometries, instances });
}

/// Things that turn and fly while the shutter is open, among things that rest.
#[test]
fn moving_instances() {
    let mut rng = Rng(20);
    let geometries = vec![
        soup(&mut rng, 30, 0.4),
        triangles(&subdivided_box(2)),
        spheres(vec![Sphere { center: [0.5; 3], radius: 0.5 }, Sphere { center: [-0.5; 3], radius: 0.1 }]),
    ];
    let mut instances = vec![plain(0), placed(1, rng.linear(), rng.point(2.0))];
    for i in 0..24 {
        let mut linear = rng.linear();
        match i % 4 {
            0 => linear = linear.map(|row| scale(row, 0.1)),
            1 => linear[0] = scale(linear[0], -1e-3),
            2 => linear = [[0.0, -0.5, 0.0], [0.5, 0.0, 0.0], [0.0, 0.0, if i % 8 == 2 { 0.5 } else { -0.5 }]],
            _ => linear[1] = scale(linear[1], 5.0),
        }
        let (shift, keys, reach) = (rng.point(1.5), [1, 2, 3, 17][i % 4], [0.0, 0.5, 2.0][i % 3]);
        let instance = moving(&mut rng, i as u32 % 3, linear, shift, keys, reach);
        instances.push(Instance { mask: *rng.pick(&[u32::MAX, u32::MAX, 1, 2, 5, 0]), ..instance });
    }
    check("moving instances", &World { geometries, instances });
}

/// Far from the origin that poses turn about, and from their objects' own.
#[test]
fn moving_far_away() {
    let mut rng = Rng(21);
    let shift = [3e4, -1e4, 2e4];
    let geometries =
        vec![triangles(&ball(2)), soup(&mut rng, 50, 0.5), triangles(&mapped(&ball(1), |p| add(p, shift)))];
    let mut instances = vec![placed(0, [[30.0, 0.0, 0.0], [0.0, 30.0, 0.0], [0.0, 0.0, 30.0]], shift)];
    for i in 0..12 {
        let linear = rng.linear().map(|row| scale(row, 10.0));
        let offset = add(shift, rng.point(30.0));
        let mut instance = moving(&mut rng, i % 3, linear, offset, 3, 20.0);
        if i % 4 > 0 {
            // Only so little about the far origin.
            let base = std::array::from_fn(|r| [linear[r][0], linear[r][1], linear[r][2], offset[r]].map(f64::from));
            let key = |time: f64| {
                let rotation = [2e-4 * time, -1e-4 * time, 1e-4, 1.0];
                RigidKey { time, rotation, translation: [5.0 * time, -3.0 * time, 1.0] }
            };
            let motion = Motion::new(base, &[key(0.0), key(0.4), key(1.0)]).expect("a motion");
            instance.place = Place::Moving(motion.into());
        }
        instances.push(instance);
    }
    check("moving far away", &World { geometries, instances });
}

#[test]
fn far_from_the_origin() {
    let mut rng = Rng(14);
    let shift = [1e5, -3e4, 7e4];
    let far = mapped(&ball(2), |p| add(scale(p, 30.0), shift));
    let mut instances = vec![plain(0)];
    for i in 0..12 {
        let linear = rng.linear().map(|row| scale(row, 10.0));
        let offset = rng.point(60.0);
        instances.push(placed(1 + i % 2, linear, add(shift, offset)));
        // An object that is itself far from its own origin.
        let linear = rng.linear();
        let center = [0, 1, 2].map(|r| dot(linear[r], shift));
        let offset = rng.point(40.0);
        instances.push(placed(0, linear, add(sub(shift, center), offset)));
    }
    let geometries = vec![triangles(&far), triangles(&subdivided_box(2)), soup(&mut rng, 50, 0.5)];
    check("far from the origin", &World { geometries, instances });
}

#[test]
fn huge_and_tiny() {
    let mut rng = Rng(15);
    let thing = |factor: f32| triangles(&mapped(&subdivided_box(2), |p| scale(p, factor)));
    let mut geometries = vec![thing(1e-20), thing(1e-6), thing(1.0), thing(1e7), soup(&mut rng, 50, 0.5)];
    geometries.push(spheres(vec![
        Sphere { center: [0.0; 3], radius: 1e-12 },
        Sphere { center: [1e-3; 3], radius: 1e-4 },
        Sphere { center: [2e6, 0.0, 0.0], radius: 1e6 },
    ]));
    let big = [[1e9, 0.0, 0.0], [0.0, 1e9, 0.0], [0.0, 0.0, 1e9]];
    let small = big.map(|row| scale(row, 1e-18));
    let instances =
        (0..6).map(plain).chain([placed(1, big, [0.0; 3]), placed(4, big, [0.0; 3]), placed(3, small, [0.5; 3])]);
    let world = World { instances: instances.collect(), geometries };
    check("huge and tiny", &world);
}

#[test]
fn dense_soup() {
    let mut rng = Rng(16);
    let world = World {
        geometries: vec![soup(&mut rng, 600, 0.15), soup(&mut rng, 200, 0.01)],
        instances: vec![plain(0), plain(1), Instance { mask: 1, ..plain(1) }, placed(1, rng.linear(), [0.3, 0.0, 0.0])],
    };
    check("dense soup", &world);
}

/// Walls that are tested apart from what is in the room: in meshes of their own, some of them seen by some rays only, twice at the
/// same place, among the faces of others, and beside instances and spheres.
#[test]
fn rooms() {
    let mut rng = Rng(21);
    let walls = mapped(&subdivided_box(1), |p| [2.0 * p[0], p[1], 3.0 * p[2]]);
    let things = mapped(&ball(3), |p| add(scale(p, 0.3), [0.2, -0.3, 0.4]));
    // Every seventh face is one of the walls.
    let mut positions = things.positions.to_vec();
    let first = positions.len() as u32;
    positions.extend_from_slice(&walls.positions);
    let mut indices = things.indices.to_vec();
    for (place, face) in walls.indices.iter().enumerate() {
        indices.insert(7 * place + 3, face.map(|i| first + i));
    }
    let mixed = triangles(&mesh(positions, indices));
    let masked = |geometry| Instance { mask: 2, ..plain(geometry) };
    let balls = spheres((0..20).map(|_| Sphere { center: rng.point(0.8), radius: 0.1 }).collect());
    let (walls, things) = (triangles(&walls), triangles(&things));
    let turned = placed(1, rng.linear().map(|row| scale(row, 0.3)), [-0.5, 0.2, 1.0]);
    for (index, (geometries, instances)) in [
        (vec![walls.clone(), things.clone()], vec![plain(0), plain(1)]),
        (vec![walls.clone(), things.clone()], vec![plain(1), masked(0), plain(0)]),
        (vec![mixed], vec![plain(0)]),
        (vec![walls.clone(), things.clone(), balls], vec![plain(2), turned, plain(1), plain(0)]),
        (
            vec![walls, things],
            vec![plain(1), placed(0, [[0.9, 0.0, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 0.9]], [0.0; 3]), plain(0)],
        ),
    ]
    .into_iter()
    .enumerate()
    {
        let found = compare("rooms", &World { geometries, instances }, ray_count() / 4, index as u64);
        assert!(found > ray_count() / 40, "{index}: {found}");
    }
}

/// So few that there is no tree: every kind of primitive, masks, coincident and degenerate faces.
#[test]
fn few_primitives() {
    let mut rng = Rng(18);
    let grid = subdivided_box(1);
    let twice = mesh(grid.positions.to_vec(), grid.indices.iter().chain(grid.indices.iter()).copied().collect());
    let (a, b) = (rng.point(1.0), rng.point(1.0));
    let degenerate = mesh(
        vec![a, b, scale(add(a, b), 0.5), add(scale(add(a, b), 0.5), rng.point(1e-7))],
        vec![[0, 1, 2], [0, 1, 3], [1, 1, 0], [2, 2, 2]],
    );
    let masked = |geometry| Instance { mask: 2, ..plain(geometry) };
    let balls = spheres(vec![Sphere { center: b, radius: 0.5 }, Sphere { center: scale(b, 0.5), radius: 0.4 }]);
    let flat = [
        World { geometries: vec![triangles(&grid)], instances: vec![plain(0)] },
        World { geometries: vec![balls, triangles(&grid)], instances: vec![masked(0), plain(1), plain(0)] },
        World { geometries: vec![triangles(&subdivided_box(3))], instances: vec![plain(0)] },
        World {
            geometries: vec![triangles(&grid), triangles(&twice), soup(&mut rng, 12, 0.4)],
            instances: vec![masked(0), plain(1), plain(2), masked(2)],
        },
        World {
            geometries: vec![triangles(&degenerate), soup(&mut rng, 7, 1e-3)],
            instances: vec![plain(1), plain(0)],
        },
        World {
            geometries: vec![
                spheres(vec![Sphere { center: a, radius: 0.3 }, Sphere { center: a, radius: 0.3 }]),
                triangles(&grid),
                triangles(&mesh(vec![], vec![])),
                spheres(vec![Sphere { center: b, radius: 0.2 }, Sphere { center: [0.0; 3], radius: 0.999_9 }]),
            ],
            instances: vec![masked(3), plain(2), plain(1), masked(0), plain(0), plain(3)],
        },
    ];
    for (index, world) in flat.iter().enumerate() {
        let tree = Accelerator::build(world, AcceleratorKind::Bvh, Isa::Avx512, 1).unwrap();
        assert!(!Isa::Avx512.is_available() || tree.stats().nodes == 0, "{index}: a tree");
        let found = compare("few primitives", world, ray_count() / 8, index as u64);
        assert!(found > ray_count() / 80, "{index}: {found}");
    }
}

/// Two triangles that share an edge: in one plane or bent, convex or not, wide and narrow, near and far.
#[test]
fn quadrilaterals() {
    let mut rng = Rng(23);
    for (index, (size, far, bend)) in [
        (1.0, 0.0, 0.0),
        (1.0, 0.0, 1e-7),
        (1.0, 0.0, 1e-6),
        (1.0, 0.0, 1e-3),
        (1e-3, 1.0, 1e-7),
        (1.0, 1e4, 1e-4),
        (1e-6, 0.0, 0.0),
        (1e12, 0.0, 1e-7),
    ]
    .into_iter()
    .enumerate()
    {
        let (mut positions, mut indices) = (Vec::new(), Vec::new());
        for quadrilateral in 0..20_u32 {
            let middle = scale(rng.direction(), far);
            let (u, v) = (rng.direction(), rng.direction());
            let v = scale(v, *rng.pick(&[1.0, 0.3, 1e-3, 1e-6]));
            let corner = |rng: &mut Rng, a: f32, b: f32| {
                let place = add(scale(u, a), scale(v, b));
                add(middle, scale(add(place, scale(rng.direction(), bend)), size))
            };
            // A parallelogram, a trapezoid, a kite, an arrow, and one with three corners in line.
            let [a, b] = *rng.pick(&[[1.0, 1.0], [0.4, 1.0], [0.8, 0.7], [0.3, 0.2], [0.5, 0.5]]);
            let places = [[0.0, 0.0], [1.0, 0.0], [a, b], [0.0, 1.0]];
            positions.extend(places.map(|[a, b]| corner(&mut rng, a, b)));
            let [p, q, r, s] = [0, 1, 2, 3].map(|i| 4 * quadrilateral + i);
            // Divided either way, and turned either way.
            indices.extend(*rng.pick(&[
                [[p, q, r], [p, r, s]],
                [[r, p, q], [p, s, r]],
                [[p, q, s], [q, r, s]],
                [[s, q, p], [s, q, r]],
            ]));
        }
        let seen = |geometry, mask| Instance { mask, ..plain(geometry) };
        // Halves of the last ones are seen by other rays.
        let (most, rest) = indices.split_at(indices.len() - 5);
        let geometries =
            vec![triangles(&mesh(positions.clone(), most.to_vec())), triangles(&mesh(positions, rest.to_vec()))];
        let world = World { geometries, instances: vec![seen(0, !0), seen(1, 2)] };
        let found = compare("quadrilaterals", &world, ray_count() / 8, index as u64);
        assert!(found > ray_count() / 200, "{index}: {found}");
    }
}

/// At the limits of what goes without a tree, and slices of any length.
#[test]
fn limits_and_lengths() {
    let mut rng = Rng(19);
    for count in [1, 47, 48, 49, 127, 128, 129, 191, 192, 193] {
        let world = World { geometries: vec![soup(&mut rng, count, 0.5)], instances: vec![plain(0)] };
        compare("limits", &world, 2000, count as u64);
        let accelerators = all_accelerators(&world);
        let rays: Vec<Ray> = (0..600).map(|_| ray(rng.point(2.0), rng.direction())).collect();
        let mut expected = vec![Hit::MISS; rays.len()];
        accelerators[0].1.closest_hits(&rays, &mut expected);
        for (kind, accelerator) in &accelerators {
            for length in [0, 1, 2, 15, 16, 17, 33, 511, 512, 513] {
                let mut hits = vec![Hit { t: -1.0, ..Hit::MISS }; length];
                accelerator.closest_hits(&rays[..length], &mut hits);
                assert!(hits.iter().zip(&expected).all(|(a, b)| bits(a) == bits(b)), "{kind}, {length} rays");
            }
        }
    }
}

#[test]
fn nothing_to_hit() {
    let worlds = [
        World::default(),
        World {
            geometries: vec![spheres(vec![]), triangles(&mesh(vec![], vec![]))],
            instances: vec![plain(0), plain(1)],
        },
        World {
            geometries: vec![triangles(&mesh(vec![[0.0; 3]], vec![]))],
            instances: vec![placed(0, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [1.0; 3])],
        },
    ];
    for world in worlds {
        assert_eq!(compare("nothing", &world, 2000, 3), 0);
        assert!(all_accelerators(&world).iter().all(|(_, accelerator)| accelerator.bounds().is_none()));
    }
}

/// Leaves with triangles, spheres and instances at once, more instances than fit a stack, some of them moving.
#[test]
fn many_instances_among_other_things() {
    let mut rng = Rng(27);
    let balls = (0..80).map(|_| Sphere { center: rng.point(1.0), radius: 0.3 * rng.unit() as f32 + 0.01 }).collect();
    let small =
        vec![Sphere { center: [0.1, 0.0, 0.0], radius: 0.1 }, Sphere { center: [-0.1, 0.05, 0.0], radius: 0.08 }];
    let geometries =
        vec![soup(&mut rng, 80, 0.3), spheres(balls), soup(&mut rng, 6, 0.15), spheres(small), soup(&mut rng, 1, 0.2)];
    let mut instances = vec![plain(0), plain(1), Instance { mask: 2, ..plain(0) }];
    for i in 0..600 {
        let shift = if i % 3 == 0 { [0.3, 0.2, 0.1] } else { rng.point(1.0) };
        let geometry = 2 + i % 3;
        let linear = rng.linear();
        let instance = match i % 4 {
            0 => moving(&mut rng, geometry, linear, shift, 2, 0.3),
            _ => placed(geometry, linear, shift),
        };
        instances.push(Instance { mask: *rng.pick(&[!0, 1, 2]), ..instance });
    }
    let found = compare("many instances", &World { geometries, instances }, ray_count() / 50, 27);
    assert!(found > ray_count() / 200, "{found}");
}

/// Large enough that the wide tree keeps several rays in flight.
#[test]
fn larger_than_the_cache() {
    let world = World {
        geometries: vec![triangles(&ball(7)), triangles(&subdivided_box(3))],
        instances: vec![plain(0), placed(1, [[0.3, 0.0, 0.0], [0.0, 0.2, 0.2], [0.0, -0.2, 0.2]], [0.2; 3])],
    };
    let targets = Targets::of(&world);
    let mut rng = Rng(17);
    let rays: Vec<Ray> = (0..ray_count() / 40).map(|_| targets.ray(&mut rng)).collect();
    let tree = AcceleratorKind::KdTree(etendue_accel::KdTreeSplit::SurfaceArea);
    let reference = Accelerator::build(&world, tree, Isa::Portable, 2).unwrap();
    let mut expected = vec![Hit::MISS; rays.len()];
    reference.closest_hits(&rays, &mut expected);
    assert!(expected.iter().filter(|hit| hit.is_hit()).count() > rays.len() / 4);
    for isa in Isa::available() {
        let bvh = Accelerator::build(&world, AcceleratorKind::Bvh, isa, 2).unwrap();
        assert!(bvh.stats().bytes > 4 << 20, "{:?}", bvh.stats());
        let mut hits = vec![Hit::MISS; rays.len()];
        bvh.closest_hits(&rays, &mut hits);
        for ((ray, expected), hit) in rays.iter().zip(&expected).zip(&hits) {
            assert_eq!(bits(expected), bits(hit), "{isa}: {expected:?} {hit:?} {ray:?}");
        }
        let mut occluded = vec![false; rays.len()];
        bvh.any_hits(&rays, &mut occluded);
        assert!(expected.iter().zip(&occluded).all(|(hit, &any)| hit.is_hit() == any), "{isa}");
    }
}
