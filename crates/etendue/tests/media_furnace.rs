//! Furnaces with media: where nothing absorbs, radiance 1 from everywhere stays 1, whatever scatters on the way.

mod common;

use common::*;
use etendue::{
    camera::CameraSettings,
    integrator::Integrator,
    material::Scattering,
    math::{DAffine3, DVec3, dvec3},
    medium::Medium,
    scene::{Scene, Shape},
    spectrum::Spectrum,
};

/// What a body's surface is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Surface {
    /// Only bounds.
    Boundary,
    /// Smooth glass of an index of refraction.
    Glass(f32),
}

impl Surface {
    fn scattering(self) -> Scattering {
        let white = Spectrum::ONE;
        match self {
            Self::Boundary => Scattering::Black,
            Self::Glass(ior) => {
                Scattering::Glass { ior, reflection_tint: white, transmission_tint: white, thin: false }
            }
        }
    }
}

fn medium(name: &str, absorption: [f32; 3], scattering: [f32; 3]) -> Medium {
    Medium {
        name: name.to_owned(),
        absorption: Spectrum(absorption),
        scattering: Spectrum(scattering),
        emission: Spectrum::BLACK,
        phase: Default::default(),
        density: None,
    }
}

/// Scenes under a sky of radiance 1 (or in a room that emits 1), `scale` times as large as written.
struct Furnace {
    parts: Parts,
    scale: f64,
}

impl Furnace {
    fn new(scale: f64) -> Self {
        let mut parts = Parts::default();
        let per_metre = (1.0 / scale) as f32;
        for (name, absorption, scattering) in
            [("milk", [0.0; 3], [8.0, 4.0, 2.0]), ("fog", [0.0; 3], [0.5, 0.4, 0.3]), ("ink", [50.0; 3], [0.0; 3])]
        {
            parts.0.media.push(medium(name, absorption.map(|k| k * per_metre), scattering.map(|k| k * per_metre)));
        }
        Self { parts, scale }
    }

    fn material(&mut self, surface: Surface, interior: Option<&str>, priority: Option<i32>) -> usize {
        let index = self.parts.material(surface.scattering());
        let material = &mut self.parts.0.materials[index];
        if surface == Surface::Boundary {
            material.opacity = 0.0.into();
        }
        material.interior = interior.map(str::to_owned);
        material.priority = priority;
        index
    }

    fn place(&mut self, shape: Shape, at: DVec3, size: f64, material: usize) {
        let shape = self.parts.shape(shape);
        let to = DAffine3::from_scale(DVec3::splat(self.scale))
            * DAffine3::from_translation(at)
            * DAffine3::from_scale(DVec3::splat(size));
        self.parts.place(shape, to, material);
    }

    /// A room about everything that emits 1, so that radiance is 1 everywhere.
    fn room(&mut self, size: f64) {
        let wall = self.parts.diffuse([0.5; 3]);
        let wall = self.parts.emitting(wall, [0.5; 3], false);
        self.place(cube(true), DVec3::ZERO, size, wall);
    }

    fn sky(&mut self) {
        self.parts.0.environment = Some(Spectrum::ONE.into());
    }

    fn build(self, eye: DVec3, target: DVec3) -> (Scene, CameraSettings) {
        (self.parts.build(), camera(eye * self.scale, target * self.scale))
    }
}

/// The mean of a picture is 1 within three standard errors, of at most 0.2 %: by one integrator, or all in a long proof.
fn check(what: &str, (scene, view): &(Scene, CameraSettings), number: usize, spp: u32) {
    let spp = if proving() { 8 * spp } else { spp };
    for (i, integrator) in SOLVERS.into_iter().enumerate() {
        if proving() || i == number % SOLVERS.len() {
            let moments = means(scene, view, [10, 10], &statistics(integrator, spp), 16);
            assert_mean(&format!("{what}, {integrator}"), &moments, 1.0, 0.002);
        }
    }
}

const SCALES: [f64; 2] = [1.0, 1e4];

fn sphere() -> Shape {
    Shape::Sphere { center: DVec3::ZERO, radius: 1.0 }
}

type Body = (&'static str, fn() -> Shape);
const BODIES: [Body; 3] = [("sphere", sphere), ("box", || cube(false)), ("ball", || ball(2))];

#[test]
fn a_room_full_of_fog_is_as_bright_as_its_walls() {
    for scale in SCALES {
        for number in 0..SOLVERS.len() {
            let mut furnace = Furnace::new(scale);
            furnace.room(1.0);
            furnace.parts.0.world_medium = Some("fog".to_owned());
            let scene = furnace.build(dvec3(0.1, -0.2, 0.3), dvec3(1.0, 0.3, 0.2));
            check(&format!("fog, scale {scale}"), &scene, number, 128);
        }
    }
}

#[test]
fn bodies_of_milk_vanish_under_a_white_sky() {
    let surfaces = [Surface::Boundary, Surface::Glass(1.3), Surface::Glass(1.0)];
    let mut number = 0;
    for scale in SCALES {
        for (name, body) in BODIES {
            for surface in surfaces {
                let mut furnace = Furnace::new(scale);
                let milk = furnace.material(surface, Some("milk"), None);
                furnace.place(body(), DVec3::ZERO, 1.0, milk);
                furnace.sky();
                let scene = furnace.build(dvec3(2.0, 2.5, 3.0), DVec3::ZERO);
                check(&format!("{name} of milk, {surface:?}, scale {scale}"), &scene, number, 64);
                number += 1;
            }
            number += 1;
        }
    }
}

#[test]
fn milk_is_as_bright_from_inside() {
    for scale in SCALES {
        for (number, (name, body)) in BODIES.into_iter().enumerate() {
            let mut furnace = Furnace::new(scale);
            let milk = furnace.material(Surface::Boundary, Some("milk"), None);
            furnace.place(body(), DVec3::ZERO, 1.0, milk);
            furnace.sky();
            let scene = furnace.build(dvec3(0.2, 0.1, -0.3), dvec3(0.0, 0.3, 1.0));
            check(&format!("inside a {name} of milk, scale {scale}"), &scene, 2 * (number % 2), 128);
        }
    }
}

/// A cube with a cavity: one closed surface in two pieces.
fn shell(cavity: f32) -> Shape {
    let (Shape::Mesh(outer), Shape::Mesh(inner)) = (cube(false), cube(true)) else { unreachable!() };
    let count = outer.positions.len() as u32;
    let positions = outer.positions.iter().copied().chain(inner.positions.iter().map(|p| p.map(|c| c * cavity)));
    let indices = outer.indices.iter().copied().chain(inner.indices.iter().map(|f| f.map(|i| i + count)));
    mesh(positions.collect(), indices.collect())
}

/// How a liquid meets its glass.
const FITS: [(&str, f64); 3] = [("a gap of 1e-4", 0.8 - 1e-4), ("an overlap of 1e-4", 0.8 + 1e-4), ("an overlap", 0.9)];

/// A box of glass with a box of milk in its cavity.
fn glass_of_milk(scale: f64, size: f64) -> Furnace {
    let mut furnace = Furnace::new(scale);
    let glass = furnace.material(Surface::Glass(1.5), None, Some(2));
    let milk = furnace.material(Surface::Glass(1.34), Some("milk"), Some(1));
    furnace.place(shell(0.8), DVec3::ZERO, 1.0, glass);
    furnace.place(cube(false), DVec3::ZERO, size, milk);
    furnace.sky();
    furnace
}

#[test]
fn a_glass_of_milk_vanishes_however_the_milk_fits() {
    let mut number = 0;
    for scale in SCALES {
        for (fit, size) in FITS {
            let scene = glass_of_milk(scale, size).build(dvec3(2.0, 2.5, 3.0), DVec3::ZERO);
            check(&format!("a glass of milk with {fit}, scale {scale}"), &scene, number, 128);
            number += 1;
        }
    }
}

/// Milk with ink in it that a higher priority leaves no room for; the ink reaches into a second body of milk.
fn hidden_ink(scale: f64, ink: i32) -> Furnace {
    let mut furnace = Furnace::new(scale);
    let milk = furnace.material(Surface::Boundary, Some("milk"), Some(1));
    let glass = furnace.material(Surface::Glass(1.5), Some("milk"), Some(2));
    let ink = furnace.material(Surface::Glass(1.7), Some("ink"), Some(ink));
    furnace.place(cube(false), DVec3::ZERO, 1.0, milk);
    furnace.place(sphere(), dvec3(1.3, 0.0, 0.0), 0.6, glass);
    furnace.place(ball(2), dvec3(0.6, 0.1, 0.0), 0.35, ink);
    furnace.place(sphere(), dvec3(1.1, 0.1, 0.1), 0.3, ink);
    furnace.sky();
    furnace
}

#[test]
fn nothing_is_seen_of_bodies_of_lower_priority() {
    for (number, scale) in SCALES.into_iter().enumerate() {
        let scene = hidden_ink(scale, 0).build(dvec3(2.0, 2.5, 3.0), DVec3::ZERO);
        check(&format!("ink in milk, scale {scale}"), &scene, number, 96);
        // From inside of the ink: the camera's own bodies count by priority too.
        let scene = hidden_ink(scale, 0).build(dvec3(0.5, 0.15, 0.05), dvec3(-1.0, 0.3, 0.2));
        check(&format!("from inside of ink in milk, scale {scale}"), &scene, 2 * (number % 2), 128);
    }
    let (scene, view) = hidden_ink(1.0, 3).build(dvec3(2.0, 2.5, 3.0), DVec3::ZERO);
    let seen = means(&scene, &view, [10, 10], &statistics(Integrator::Path, 16), 16);
    assert!(seen.mean() < 0.95, "ink of the highest priority is seen: {}", seen.mean());
}

#[test]
fn a_camera_in_a_glass_sees_its_bodies() {
    // Inside of glass radiance is squeezed by the square of the index.
    let mut furnace = Furnace::new(1.0);
    let glass = furnace.material(Surface::Glass(1.5), None, Some(1));
    let milk = furnace.material(Surface::Boundary, Some("milk"), Some(2));
    furnace.place(ball(3), DVec3::ZERO, 1.0, glass);
    furnace.place(cube(false), DVec3::ZERO, 0.4, milk);
    furnace.sky();
    for (number, eye) in [dvec3(0.0, 0.0, 0.7), dvec3(0.1, 0.2, 0.1)].into_iter().enumerate() {
        let view = camera(eye, dvec3(-0.1, 0.05, -0.3));
        let scene = Furnace { parts: Parts(furnace.parts.0.clone()), scale: 1.0 }.parts.build();
        let moments = means(&scene, &view, [10, 10], &statistics(SOLVERS[2 * number], 256), 16);
        assert_mean("inside of glass", &moments, 1.5 * 1.5, 0.002);
    }
}
