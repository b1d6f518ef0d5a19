//! Scenes and renders for the tests of this crate.
#![allow(dead_code, reason = "each test binary uses its own part")]

use etendue::{
    camera::{Aperture, CameraSettings, FovAxis, Projection},
    film::{Film, FilmSettings},
    image::Image,
    integrator::Integrator,
    material::{Emission, Material, Scattering},
    math::{DAffine3, DVec3, dvec3},
    render::{RenderControl, RenderSettings, render},
    sampling::{Filter, Sampler},
    scene::{AcceleratorSettings, Mesh, Object, Scene, SceneParts, Shape},
    spectrum::Spectrum,
};
use etendue_accel::{AcceleratorKind, Isa};
use etendue_testkit::Moments;

/// Collects the parts of a scene.
#[derive(Default)]
pub struct Parts(pub SceneParts);

impl Parts {
    pub fn material(&mut self, scattering: Scattering) -> usize {
        self.0.materials.push(Material::new(format!("m{}", self.0.materials.len()), scattering));
        self.0.materials.len() - 1
    }

    pub fn diffuse(&mut self, rgb: [f32; 3]) -> usize {
        self.material(Scattering::Diffuse { reflectance: Spectrum(rgb), transmittance: Spectrum::BLACK })
    }

    pub fn emitting(&mut self, material: usize, radiance: [f32; 3], two_sided: bool) -> usize {
        self.0.materials[material].emission = Some(Emission { radiance: Spectrum(radiance).into(), two_sided });
        material
    }

    pub fn emitter(&mut self, radiance: [f32; 3], two_sided: bool) -> usize {
        let black = self.material(Scattering::Black);
        self.emitting(black, radiance, two_sided)
    }

    pub fn shape(&mut self, shape: Shape) -> usize {
        self.0.shapes.push(shape);
        self.0.shapes.len() - 1
    }

    pub fn place(&mut self, shape: usize, transform: DAffine3, material: usize) {
        let name = format!("o{}", self.0.objects.len());
        self.0.objects.push(Object { name, shape, transform, materials: vec![material], motion: None });
    }

    pub fn sphere(&mut self, center: DVec3, radius: f64, material: usize) {
        let shape = self.shape(Shape::Sphere { center, radius });
        self.place(shape, DAffine3::IDENTITY, material);
    }

    pub fn rectangle(&mut self, corner: DVec3, u: DVec3, v: DVec3, material: usize) {
        let shape = self.shape(Shape::Rectangle { corner, u, v });
        self.place(shape, DAffine3::IDENTITY, material);
    }

    pub fn build(self) -> Scene {
        self.build_with(AcceleratorKind::Bvh)
    }

    pub fn build_with(self, kind: AcceleratorKind) -> Scene {
        Scene::build(self.0, &AcceleratorSettings { kind, isa: Isa::detect(), threads: 2 }).expect("the scene is valid")
    }
}

/// The cube [-1, 1]^3 as a mesh with outward winding; `inward` turns it inside out.
pub fn cube(inward: bool) -> Shape {
    let positions: Vec<[f32; 3]> =
        (0..8).map(|i: u32| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 })).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let faces = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    let indices = faces.map(|[a, b, c]| if inward { [a, c, b] } else { [a, b, c] }).collect();
    mesh(positions, indices)
}

/// A unit sphere of triangles: an octahedron, each face divided `levels` times into four. Flat shading.
pub fn ball(levels: u32) -> Shape {
    let mut positions: Vec<DVec3> =
        [[1., 0., 0.], [-1., 0., 0.], [0., 1., 0.], [0., -1., 0.], [0., 0., 1.], [0., 0., -1.]].map(DVec3::from).into();
    let mut faces: Vec<[u32; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..levels {
        let mut middles = std::collections::BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                (positions.len() - 1) as u32
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    mesh(positions.iter().map(|p| p.as_vec3().to_array()).collect(), faces)
}

/// A polygon of `corners` in the plane z = 0, facing +z: triangles about its middle, with a rim of radius 1.
pub fn round_sheet(corners: u32) -> Shape {
    let rim = |i: u32| {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(i) / f64::from(corners));
        [cos as f32, sin as f32, 0.0]
    };
    let positions = std::iter::once([0.0; 3]).chain((0..corners).map(rim)).collect();
    mesh(positions, (0..corners).map(|i| [0, 1 + i, 1 + (i + 1) % corners]).collect())
}

/// A prism of `sides` about the z axis with round ends at -1 and 1, its inside being its front.
pub fn drum(sides: u32) -> Shape {
    let corner = |i: u32| {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(i / 2) / f64::from(sides));
        [cos as f32, sin as f32, if i.is_multiple_of(2) { -1.0 } else { 1.0 }]
    };
    let positions = [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]].into_iter().chain((0..2 * sides).map(corner)).collect();
    let faces = (0..sides).flat_map(|i| {
        let [low, high] = [2 + 2 * i, 3 + 2 * i];
        let [next_low, next_high] = [low, high].map(|corner| if i + 1 == sides { corner - 2 * i } else { corner + 2 });
        [[0, low, next_low], [1, next_high, high], [low, high, next_high], [low, next_high, next_low]]
    });
    mesh(positions, faces.collect())
}

pub fn mesh(positions: Vec<[f32; 3]>, indices: Vec<[u32; 3]>) -> Shape {
    Shape::Mesh(Mesh {
        origin: DVec3::ZERO,
        positions: positions.into(),
        indices: indices.into(),
        normals: None,
        uvs: None,
        colors: None,
        face_materials: None,
    })
}

/// A pinhole camera with 40 degrees across the width.
pub fn camera(position: DVec3, target: DVec3) -> CameraSettings {
    let projection = Projection::Perspective {
        fov: 40f64.to_radians(),
        axis: FovAxis::X,
        lens_radius: 0.0,
        aperture: Aperture::Round,
        focus_distance: 1.0,
    };
    let direction = target - position;
    let up = if direction.normalize().y.abs() > 0.9 { dvec3(0.0, 0.0, 1.0) } else { dvec3(0.0, 1.0, 0.0) };
    CameraSettings { position, direction, up, projection, near_clip: 0.0 }
}

/// Renders the whole image of `size` pixels.
pub fn picture(scene: &Scene, camera: &CameraSettings, size: [u32; 2], settings: &RenderSettings) -> Image {
    let film = Film::new(&FilmSettings { resolution: size, crop: None, aovs: vec![], transparent: false })
        .expect("a valid film");
    render(scene, camera, settings, &film, &RenderControl::default()).expect("valid settings");
    assert_eq!(film.left_out().count, 0, "samples were left out");
    film.develop()
}

/// The colour of an image, three interleaved numbers a pixel.
pub fn interleaved(image: &Image) -> Vec<f32> {
    let [r, g, b] = ["R", "G", "B"].map(|c| image.f32_channel(c).expect("colour"));
    r.iter().zip(g).zip(b).flat_map(|((r, g), b)| [*r, *g, *b]).collect()
}

/// Means of a picture over `replicates` seeds.
pub fn means(
    scene: &Scene,
    camera: &CameraSettings,
    size: [u32; 2],
    settings: &RenderSettings,
    replicates: u64,
) -> Moments {
    (0..replicates)
        .map(|seed| {
            let image =
                picture(scene, camera, size, &RenderSettings { seed: settings.seed + seed, ..settings.clone() });
            let values = interleaved(&image);
            values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64
        })
        .collect()
}

/// Asserts that a mean is `exact` within 3 standard errors, and the standard error at most `precision` of it.
#[track_caller]
pub fn assert_mean(what: &str, moments: &Moments, exact: f64, precision: f64) {
    let (mean, error) = (moments.mean(), moments.standard_error());
    assert!(error <= precision * exact, "{what}: standard error {error:.2e} of {exact}: more samples needed");
    let sigma = (mean - exact) / error.max(1e-7 * exact);
    assert!(sigma.abs() <= 3.0, "{what}: mean {mean:.6}, not {exact:.6}: {sigma:+.1} sigma of {error:.2e}");
}

/// Settings for statistics: independent numbers, so that samples of one picture are independent too.
pub fn statistics(integrator: Integrator, spp: u32) -> RenderSettings {
    RenderSettings {
        spp,
        threads: 2,
        integrator,
        sampler: Sampler::Independent,
        filter: Filter::Box { radius: 0.5 },
        ..RenderSettings::default()
    }
}

/// True in a long proof (`cargo xtask prove`): tests take their full size.
pub fn proving() -> bool {
    std::env::var_os("ETENDUE_PROVE").is_some_and(|v| v == "1")
}

/// The integrators that solve the rendering equation.
pub const SOLVERS: [Integrator; 3] = [Integrator::Path, Integrator::LightSplit, Integrator::Brute];
