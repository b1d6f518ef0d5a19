//! Lamps that are cut into triangles: what is a parallelogram or a disk together is one light, and nothing else changes.

mod common;

use common::*;
use etendue::{
    bsdf::Density,
    camera::CameraSettings,
    light::{Light, LightContext},
    math::{DAffine3, DVec3, Vec3, dvec3, vec3},
    scene::{Scene, Shape},
};
use etendue_accel::{Hit, PrimitiveId, Ray};
use etendue_testkit::{
    Rng,
    tiles::{Demands, Replicates, compare},
};

/// A sheet of 1 x 1 in squares of two triangles, in the plane z = 0, with the rows askew and no two vertices shared by
/// squares; some squares may be left out.
fn sheet(sides: [usize; 2], is_there: impl Fn(usize, usize) -> bool) -> Shape {
    let [columns, rows] = sides;
    let at = |x: usize, y: usize| {
        let inner = 0 < x && x < columns && 0 < y && y < rows;
        let shift = if inner { 0.02 * ((x * 7 + y * 5) % 11) as f32 - 0.1 } else { 0.0 };
        [(x as f32 + shift) / columns as f32, (y as f32 - shift) / rows as f32, 0.0]
    };
    let squares = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
    let squares: Vec<_> = squares.filter(|&(x, y)| is_there(x, y)).collect();
    let corners = squares.iter().flat_map(|&(x, y)| [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]);
    let faces = (0..squares.len() as u32).flat_map(|i| [[0, 1, 2], [0, 2, 3]].map(|face| face.map(|k| 4 * i + k)));
    mesh(corners.collect(), faces.collect())
}

/// A floor under a mirrored and turned lamp of 40 triangles, a slanted one of 2 that shines to both sides, one of 16 with a hole, an
/// open box of 10, a round one overhead, and one of 9 corners that is stuck into the floor.
fn lamps() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    let white = parts.diffuse([0.6; 3]);
    parts.rectangle(dvec3(-3.0, 0.0, -3.0), dvec3(0.0, 0.0, 6.0), dvec3(6.0, 0.0, 0.0), white);
    parts.rectangle(dvec3(-3.0, 0.0, -1.5), dvec3(6.0, 0.0, 0.0), dvec3(0.0, 3.0, 0.0), white);
    let bright = parts.emitter([6.0, 5.0, 4.0], false);
    let both = parts.emitter([2.0, 3.0, 4.0], true);
    let turn = DAffine3::from_rotation_x(1.2) * DAffine3::from_rotation_z(0.3);
    let cut = parts.shape(sheet([5, 4], |_, _| true));
    let mirror = DAffine3::from_scale(dvec3(-1.2, 0.7, 1.0));
    parts.place(cut, DAffine3::from_translation(dvec3(0.9, 1.9, -0.6)) * turn * mirror, bright);
    let skew =
        mesh(vec![[0.0, 0.0, 0.0], [0.6, 0.1, 0.0], [0.9, 0.7, 0.1], [0.3, 0.6, 0.1]], vec![[0, 1, 2], [0, 2, 3]]);
    let skew = parts.shape(skew);
    parts.place(skew, DAffine3::from_translation(dvec3(-1.5, 0.3, 0.2)), both);
    let holed = parts.shape(sheet([3, 3], |x, y| (x, y) != (1, 1)));
    parts.place(holed, DAffine3::from_translation(dvec3(-0.4, 1.6, 0.4)) * DAffine3::from_rotation_x(1.6), bright);
    let corner = |i: u16| [f32::from(i & 1), f32::from(i >> 1 & 1), f32::from(i >> 2)];
    let sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4]];
    let faces = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let open = parts.shape(mesh((0..8).map(corner).collect(), faces));
    let small = DAffine3::from_scale(dvec3(0.3, 0.4, 0.3));
    parts.place(open, DAffine3::from_translation(dvec3(1.4, 0.1, 0.6)) * small, both);
    let (round, coarse) = (parts.shape(round_sheet(64)), parts.shape(round_sheet(9)));
    let down = DAffine3::from_rotation_x(1.7) * DAffine3::from_scale(dvec3(0.4, -0.4, 1.0));
    parts.place(round, DAffine3::from_translation(dvec3(0.2, 1.4, 0.9)) * down, bright);
    let upright = DAffine3::from_rotation_y(0.9) * DAffine3::from_scale(DVec3::splat(0.35));
    parts.place(coarse, DAffine3::from_translation(dvec3(-0.7, 0.1, 1.2)) * upright, both);
    (parts.build(), camera(dvec3(0.3, 2.2, 4.0), dvec3(0.0, 0.6, 0.0)))
}

#[test]
fn panels_are_one_light_each() {
    let (scene, _) = lamps();
    let count = |is: fn(&Light) -> bool| scene.lights().lights().iter().filter(|light| is(light)).count();
    assert_eq!(count(|light| matches!(light, Light::Rectangle(_))), 1 + 1 + 5);
    assert_eq!(count(|light| matches!(light, Light::Disk(_))), 2);
    assert_eq!(count(|light| matches!(light, Light::Triangle(_))), 16);
}

#[test]
fn solvers_agree_under_lamps_that_are_cut() {
    let (scene, view) = lamps();
    let replicates = |integrator: usize, spp: u32| {
        let mut all = Replicates::new([24, 24], 3, 8);
        for replicate in 0..32 {
            let mut settings = statistics(SOLVERS[integrator], spp);
            settings.seed = 2000 * (integrator as u64 + 1) + replicate;
            settings.max_depth = Some(3);
            all.push(&interleaved(&picture(&scene, &view, [24, 24], &settings)));
        }
        all
    };
    let path = replicates(0, 128);
    let demands = Demands { level: etendue_testkit::sidak(0.01, 2), ..Demands::default() };
    for (other, spp) in [(1, 128), (2, 512)] {
        compare(&path, &replicates(other, spp)).assert(demands, &format!("path against {}", SOLVERS[other]));
    }
}

/// A ray towards each sample meets the light that was drawn, with the density that it was drawn with. Where panels meet it may be
/// the other one.
#[test]
fn samples_of_panels_are_what_rays_find() {
    let (scene, _) = lamps();
    let mut rng = Rng::new(9);
    let (mut compared, mut differ) = (0, 0);
    for _ in 0..20_000 {
        let point = vec3(rng.f32() * 4.0 - 2.0, rng.f32() * 2.0, rng.f32() * 4.0 - 2.0);
        let ctx = LightContext { point, normal: Vec3::ZERO, transmits: true, time: 0.0 };
        let Some(sample) = scene.sample_light(&ctx, rng.f64(), rng.f32x2()) else { continue };
        let target = sample.target.expect("all lights are near");
        let distance = (target - point).length();
        // Past the target by more than its lift, and not beyond the light.
        let origin = (point + sample.wi * (distance - 1e-4)).into();
        let (direction, skip) = (sample.wi.into(), PrimitiveId::NONE);
        let ray = Ray { origin, t_min: 0.0, direction, t_max: 2e-3, time: 0.0, mask: u32::MAX, skip };
        let mut hits = [Hit::MISS];
        scene.accelerator().closest_hits(&[ray], &mut hits);
        if !hits[0].is_hit() {
            continue;
        }
        let surface = scene.surface_point(&ray, &hits[0]);
        if surface.geometric_normal.dot(sample.wi).abs() < 0.05 {
            continue;
        }
        let Density::SolidAngle(density) = sample.density else { panic!("no light is discrete") };
        let pdf = scene.lights().pdf_hit(&ctx, surface.light, sample.wi, distance);
        compared += 1;
        differ += u32::from((density - pdf).abs() > 2e-2 * density.max(pdf));
    }
    assert!(compared > 8_000, "only {compared} compared");
    assert!(differ * 200 < compared, "{differ} of {compared} differ");
}
