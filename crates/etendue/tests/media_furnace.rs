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
    /// Rough glass.
    Frosted(f32),
}

impl Surface {
    fn scattering(self) -> Scattering {
        let white = Spectrum::ONE;
        match self {
            Self::Boundary => Scattering::Black,
            Self::Glass(ior) => {
                Scattering::Glass { ior, reflection_tint: white, transmission_tint: white, thin: false }
            }
            Self::Frosted(ior) => {
                Scattering::RoughGlass { ior, alpha: 0.2, reflection_tint: white, transmission_tint: white }
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

fn check(what: &str, (scene, view): &(Scene, CameraSettings), integrators: &[Integrator], spp: u32) {
    let spp = if proving() { 8 * spp } else { spp };
    for integrator in integrators {
        let moments = means(scene, view, [12, 12], &statistics(*integrator, spp), 16);
        assert_mean(&format!("{what}, {integrator}"), &moments, 1.0, 0.002);
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
        let mut furnace = Furnace::new(scale);
        furnace.room(1.0);
        furnace.parts.0.world_medium = Some("fog".to_owned());
        let scene = furnace.build(dvec3(0.1, -0.2, 0.3), dvec3(1.0, 0.3, 0.2));
        check(&format!("fog, scale {scale}"), &scene, &SOLVERS, 96);
    }
}

#[test]
fn bodies_of_milk_vanish_under_a_white_sky() {
    for scale in SCALES {
        for (name, body) in BODIES {
            for surface in [Surface::Boundary, Surface::Glass(1.3), Surface::Glass(1.0)] {
                let mut furnace = Furnace::new(scale);
                let milk = furnace.material(surface, Some("milk"), None);
                furnace.place(body(), DVec3::ZERO, 1.0, milk);
                furnace.sky();
                let scene = furnace.build(dvec3(2.0, 2.5, 3.0), DVec3::ZERO);
                check(&format!("{name} of milk, {surface:?}, scale {scale}"), &scene, &SOLVERS, 64);
            }
        }
    }
}

#[test]
fn milk_is_as_bright_from_inside() {
    for scale in SCALES {
        for (name, body) in BODIES {
            let mut furnace = Furnace::new(scale);
            let milk = furnace.material(Surface::Boundary, Some("milk"), None);
            furnace.place(body(), DVec3::ZERO, 1.0, milk);
            furnace.sky();
            let scene = furnace.build(dvec3(0.2, 0.1, -0.3), dvec3(0.0, 0.3, 1.0));
            check(&format!("inside a {name} of milk, scale {scale}"), &scene, &SOLVERS, 64);
        }
    }
}
