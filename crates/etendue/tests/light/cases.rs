//! Lights of all variants, seen from contexts of all kinds, at several scales and places.

use etendue::{
    light::{
        ConstantEnvironment, DirectionalLight, DiskLight, ImageEnvironment, Light, LightContext, PointLightSource,
        RadianceMap, RectangleLight, RoundOutline, SphereLight, SpotLight, SunSky, TriangleLight,
    },
    math::{DMat3, DVec3, Vec3, dvec3},
    spectrum::Spectrum,
};
use std::sync::Arc;

pub const RADIANCE: Spectrum = Spectrum([2.0, 3.0, 5.0]);

/// A light and a context.
pub struct Case {
    pub name: String,
    pub light: Light,
    pub ctx: LightContext,
}

/// A similarity: rotate, scale, translate.
#[derive(Clone, Copy)]
pub struct Placement {
    name: &'static str,
    rotation: DMat3,
    scale: f64,
    translation: DVec3,
}

impl Placement {
    fn vector(&self, v: DVec3) -> Vec3 {
        (self.rotation * v * self.scale).as_vec3()
    }

    fn point(&self, p: DVec3) -> Vec3 {
        (self.rotation * p * self.scale + self.translation).as_vec3()
    }
}

pub fn placements() -> Vec<Placement> {
    let turn = DMat3::from_axis_angle(dvec3(0.3, -0.7, 0.6).normalize(), 2.1);
    let (still, far) = (DVec3::ZERO, dvec3(1e4, -7e3, 4e3));
    vec![
        Placement { name: "unit", rotation: DMat3::IDENTITY, scale: 1.0, translation: still },
        Placement { name: "small", rotation: turn, scale: 1e-3, translation: still },
        Placement { name: "large", rotation: turn, scale: 1e4, translation: still },
        Placement { name: "moved", rotation: turn, scale: 10.0, translation: far },
    ]
}

fn triangle(at: &Placement, vertices: [DVec3; 3], two_sided: bool) -> Light {
    Light::Triangle(TriangleLight { vertices: vertices.map(|v| at.point(v)), radiance: RADIANCE, two_sided })
}

fn parallelogram(at: &Placement, u: DVec3, v: DVec3, two_sided: bool) -> Light {
    let (corner, u, v) = (at.point(DVec3::ZERO), at.vector(u), at.vector(v));
    Light::Rectangle(RectangleLight { corner, u, v, radiance: RADIANCE, two_sided })
}

/// So many corners that in no test a sample falls between the polygon and the circle.
fn disk(at: &Placement, two_sided: bool) -> Light {
    nearly_disk(at, 20_000, two_sided)
}

fn nearly_disk(at: &Placement, corners: u32, two_sided: bool) -> Light {
    let corner = |i: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(corners)).sin_cos();
        at.rotation * dvec3(0.5 + 0.5 * cos, 0.3 + 0.5 * sin, 0.0) * at.scale + at.translation
    };
    let rim: Vec<DVec3> = (0..corners).map(corner).collect();
    let outline = RoundOutline::new(&rim).expect("is round");
    Light::Disk(Arc::new(DiskLight { outline, radiance: RADIANCE, two_sided }))
}

fn ellipsoid(at: &Placement, axes: [DVec3; 3], two_sided: bool) -> Light {
    let axes = axes.map(|a| at.vector(a));
    Light::Sphere(SphereLight { center: at.point(DVec3::ZERO), axes, radiance: RADIANCE, two_sided })
}

/// Flat lights, with front towards +z and size about 1.
pub fn flat(at: &Placement) -> Vec<(&'static str, Light)> {
    let zero = DVec3::ZERO;
    vec![
        ("triangle", triangle(at, [zero, dvec3(1.0, 0.0, 0.0), dvec3(0.3, 0.8, 0.0)], false)),
        ("two-sided triangle", triangle(at, [zero, dvec3(1.0, 0.0, 0.0), dvec3(0.3, 0.8, 0.0)], true)),
        ("sliver", triangle(at, [zero, dvec3(1.0, 0.0, 0.0), dvec3(0.5, 0.01, 0.0)], false)),
        ("rectangle", parallelogram(at, dvec3(1.0, 0.0, 0.0), dvec3(0.0, 0.6, 0.0), false)),
        ("two-sided rectangle", parallelogram(at, dvec3(1.0, 0.0, 0.0), dvec3(0.0, 0.6, 0.0), true)),
        ("strip", parallelogram(at, dvec3(1.0, 0.0, 0.0), dvec3(0.0, 0.01, 0.0), false)),
        ("parallelogram", parallelogram(at, dvec3(1.0, 0.0, 0.0), dvec3(0.4, 0.7, 0.0), false)),
        ("disk", disk(at, false)),
        ("two-sided disk", disk(at, true)),
    ]
}

/// Spheres and ellipsoids about the origin, with a radius of about 0.5.
pub fn round(at: &Placement) -> Vec<(&'static str, Light)> {
    let ball = [dvec3(0.5, 0.0, 0.0), dvec3(0.0, 0.5, 0.0), dvec3(0.0, 0.0, 0.5)];
    let sheared = [dvec3(0.7, 0.1, 0.0), dvec3(0.0, 0.3, 0.2), dvec3(0.2, 0.0, -0.4)];
    vec![
        ("sphere", ellipsoid(at, ball, false)),
        ("two-sided sphere", ellipsoid(at, ball, true)),
        ("ellipsoid", ellipsoid(at, sheared, false)),
        ("two-sided ellipsoid", ellipsoid(at, sheared, true)),
    ]
}

/// Contexts of flat lights: near, far, grazing, close to edges and corners, behind.
const BEFORE_FLAT: [[f64; 3]; 13] = [
    [0.4, 0.3, 0.05],
    [0.4, 0.3, 0.002],
    [0.5, 0.2, 1.0],
    [2.0, 1.0, 0.5],
    [-0.3, -0.4, 0.6],
    [30.0, -20.0, 100.0],
    [3e3, 6e3, 7e3],
    [3.0, 0.5, 0.02],
    [-1.5, 0.3, 0.001],
    [0.5, 0.002, 0.002],
    [0.002, 0.002, 0.004],
    [0.5, 0.2, -1.0],
    [40.0, 20.0, -3.0],
];

/// Contexts of round lights: near, far, inside.
const ABOUT_ROUND: [[f64; 3]; 8] = [
    [0.9, 0.1, 0.2],
    [0.0, 0.56, -0.3],
    [2.0, 1.0, -0.5],
    [30.0, -20.0, 100.0],
    [3e3, 6e3, 7e3],
    [0.0, 0.0, 0.0],
    [0.1, 0.2, -0.1],
    [-0.22, 0.05, 0.06],
];

/// How a context gathers: on one side, on both, in a medium, and on a side whose horizon cuts many lights.
fn gathers() -> [(Vec3, bool); 4] {
    let normal = Vec3::new(0.48, -0.6, -0.64);
    [(normal, false), (normal, true), (Vec3::ZERO, false), (Vec3::new(0.6, 0.64, 0.48), false)]
}

/// All pairs of a light and a context, the light with surface.
pub fn with_surface() -> Vec<Case> {
    let mut cases = Vec::new();
    for (turn, at) in placements().into_iter().enumerate() {
        let flat = flat(&at).into_iter().map(|l| (l, &BEFORE_FLAT[..]));
        let round = round(&at).into_iter().map(|l| (l, &ABOUT_ROUND[..]));
        for ((name, light), points) in flat.chain(round) {
            for (i, &[x, y, z]) in points.iter().enumerate() {
                let (normal, transmits) = gathers()[(i + turn) % 4];
                let ctx = LightContext { point: at.point(dvec3(x, y, z)), normal, transmits, time: 0.0 };
                let name = format!("{name} from ({x}, {y}, {z}), {}", at.name);
                cases.push(Case { name, light: light.clone(), ctx });
            }
        }
    }
    cases
}

/// Polygons that count as disks, of which a part of the circle about them is not lit.
pub fn coarse_disks() -> Vec<Case> {
    let mut cases = Vec::new();
    for (turn, at) in placements().into_iter().enumerate() {
        for (i, &[x, y, z]) in BEFORE_FLAT.iter().enumerate() {
            let (normal, transmits) = gathers()[(i + turn) % 4];
            let ctx = LightContext { point: at.point(dvec3(x, y, z)), normal, transmits, time: 0.0 };
            let corners = 8 + (i + turn) as u32 % 3;
            let name = format!("{corners} corners from ({x}, {y}, {z}), {}", at.name);
            cases.push(Case { name, light: nearly_disk(&at, corners, i % 2 == 0), ctx });
        }
    }
    cases
}

/// A map that is [`RADIANCE`] everywhere.
fn even_image(orientation: DMat3) -> ImageEnvironment {
    let map = RadianceMap::new(8, 4, vec![[1.0, 1.5, 2.5]; 32]).unwrap();
    ImageEnvironment::new(Arc::new(map), orientation, Spectrum::splat(2.0))
}

/// A map with a sun of 10 degrees radius beside it.
fn sun_and_sky(orientation: DMat3) -> SunSky {
    let (to_sun, up) = (orientation * dvec3(0.3, 0.6, 0.5), orientation * DVec3::Y);
    SunSky::new(even_image(orientation), to_sun, up, 10f64.to_radians(), RADIANCE)
}

/// Lights without surface, from everywhere.
pub fn without_surface() -> Vec<Case> {
    let mut cases = Vec::new();
    for at in placements() {
        let position = at.point(dvec3(0.1, 0.7, 1.9));
        let unit = |direction: DVec3| (at.rotation * direction).normalize().as_vec3();
        let spot = |cos_outer: f32, cos_inner: f32| {
            let axis = unit(dvec3(0.0, -0.1, -1.0));
            Light::Spot(SpotLight { position, axis, cos_outer, cos_inner, intensity: RADIANCE })
        };
        let irradiance = RADIANCE;
        let lights = [
            ("environment", Light::Environment(ConstantEnvironment { radiance: RADIANCE })),
            ("image", Light::Image(Arc::new(even_image(at.rotation)))),
            ("sun and sky", Light::SunSky(Arc::new(sun_and_sky(at.rotation)))),
            ("point", Light::Point(PointLightSource { position, intensity: RADIANCE })),
            ("spot", spot(0.5, 0.99)),
            ("spot of sharp edge", spot(0.5, 0.5)),
            (
                "directional",
                Light::Directional(DirectionalLight { direction: unit(dvec3(0.3, -0.5, -0.8)), irradiance }),
            ),
        ];
        for (name, light) in lights {
            for (i, (normal, transmits)) in gathers().into_iter().enumerate() {
                let ctx = LightContext { point: at.point(dvec3(0.4, 0.3, -0.5)), normal, transmits, time: 0.0 };
                cases.push(Case { name: format!("{name}, gathering {i}, {}", at.name), light: light.clone(), ctx });
            }
        }
    }
    cases
}

pub fn all() -> Vec<Case> {
    let mut cases = with_surface();
    cases.extend(without_surface());
    cases
}
