//! The list of parameter sets that the generic tests run over.

use etendue::{
    bsdf::{Bsdf, GrooveForm, PhongLobes, PrincipledParameters, metals},
    material::{Material, Scattering},
    math::{Vec3, vec3},
    spectrum::Spectrum,
};
use etendue_testkit::Rng;

/// Names every kind of BSDF. The match has no wildcard: a new kind does not compile until it is listed here, and then
/// `every_kind_has_a_case` asks for a case of it.
macro_rules! kinds {
    ($($kind:pat),* $(,)?) => {
        const KINDS: &[&str] = &[$(stringify!($kind)),*];
        fn kind(bsdf: &Bsdf) -> &'static str {
            match bsdf {
                $($kind => stringify!($kind),)*
            }
        }
    };
}
kinds!(
    Bsdf::Diffuse(_),
    Bsdf::Mirror(_),
    Bsdf::Glass(_),
    Bsdf::RoughMetal(_),
    Bsdf::RoughGlass(_),
    Bsdf::BrushedMetal(_),
    Bsdf::Mtl(_),
    Bsdf::Phong(_),
    Bsdf::Principled(_),
    Bsdf::Black,
);

/// A parameter set, and what is known about it.
pub struct Case {
    pub name: String,
    pub scattering: Scattering,
    pub bsdf: Bsdf,
    /// Index of refraction behind the surface over that before it, where light is refracted.
    pub index: f32,
    /// All light is scattered, whatever the angle.
    pub lossless: bool,
}

impl Case {
    fn new(name: impl Into<String>, scattering: Scattering, lossless: bool) -> Self {
        let index = match scattering {
            Scattering::Glass { ior, thin: false, .. } | Scattering::RoughGlass { ior, .. } => ior,
            Scattering::Mtl { ior, .. } => ior,
            Scattering::Phong(PhongLobes { ior, .. }) => ior,
            Scattering::Principled(PrincipledParameters { ior, .. }) => ior,
            _ => 1.0,
        };
        let name = name.into();
        let material: Material = Material::new(name.as_str(), scattering);
        material.validate().unwrap();
        Self { bsdf: scattering.bsdf(), name, scattering, index, lossless }
    }

    /// The same surface seen from behind: its index of refraction inverted.
    pub fn turned(&self) -> Bsdf {
        let mut scattering = self.scattering;
        match &mut scattering {
            Scattering::Glass { ior, thin: false, .. }
            | Scattering::RoughGlass { ior, .. }
            | Scattering::Mtl { ior, .. }
            | Scattering::Phong(PhongLobes { ior, .. })
            | Scattering::Principled(PrincipledParameters { ior, .. }) => *ior = 1.0 / *ior,
            _ => {}
        }
        scattering.bsdf()
    }

    /// Index of refraction on the side of `w`.
    pub fn index_at(&self, w: Vec3) -> f32 {
        if w.z > 0.0 { 1.0 } else { self.index }
    }
}

fn rgb(r: f32, g: f32, b: f32) -> Spectrum {
    Spectrum([r, g, b])
}

/// Several parameter sets of every kind.
pub fn cases() -> Vec<Case> {
    let (one, black) = (Spectrum::ONE, Spectrum::BLACK);
    let mut cases = Vec::new();
    for (name, reflectance, transmittance, lossless) in [
        ("diffuse white", one, black, true),
        ("diffuse brown", rgb(0.6, 0.4, 0.1), black, false),
        ("diffuse leaf", rgb(0.1, 0.5, 0.2), rgb(0.3, 0.4, 0.0), false),
        ("diffuse both", rgb(0.25, 0.5, 0.75), rgb(0.75, 0.5, 0.25), true),
        ("diffuse transmission", black, one, true),
        ("diffuse black", black, black, false),
    ] {
        cases.push(Case::new(name, Scattering::Diffuse { reflectance, transmittance }, lossless));
    }
    for (name, reflectance, lossless) in
        [("mirror", one, true), ("mirror tinted", rgb(0.9, 0.5, 0.0), false), ("mirror black", black, false)]
    {
        cases.push(Case::new(name, Scattering::Mirror { reflectance }, lossless));
    }
    for ior in [1.5, 1.0, 0.75, 2.4] {
        for thin in [false, true] {
            for (what, reflection_tint, transmission_tint) in
                [("clear", one, one), ("tinted", rgb(0.9, 0.5, 1.0), rgb(0.2, 0.9, 0.4)), ("half black", black, one)]
            {
                let name = format!("glass ior {ior} thin {thin} {what}");
                let scattering = Scattering::Glass { ior, reflection_tint, transmission_tint, thin };
                cases.push(Case::new(name, scattering, what == "clear"));
            }
        }
    }
    for (name, alpha) in [
        ("gold", [0.3, 0.3]),
        ("silver", [0.05, 0.05]),
        ("chromium", [1.0, 1.0]),
        ("copper", [0.01, 0.01]),
        ("iron", [0.6, 0.2]),
        ("nickel", [0.0, 0.4]),
        ("aluminium", [0.0, 0.0]),
    ] {
        let metal = metals::find(name).unwrap();
        let scattering = Scattering::RoughMetal { eta: metal.eta, k: metal.k, alpha, tint: rgb(1.0, 0.9, 0.8) };
        cases.push(Case::new(format!("rough metal {name} {alpha:?}"), scattering, false));
    }
    let lossless_metal = Scattering::RoughMetal { eta: black, k: Spectrum::splat(2.0), alpha: [0.0; 2], tint: one };
    cases.push(Case::new("rough metal without loss", lossless_metal, true));
    for (ior, alpha) in [(1.5, 0.2), (1.5, 0.6), (1.33, 0.02), (0.6, 0.3), (2.0, 1.0), (1.1, 0.3)] {
        for (what, reflection_tint, transmission_tint) in
            [("clear", one, one), ("tinted", rgb(0.9, 0.5, 1.0), rgb(0.2, 0.9, 0.4))]
        {
            let scattering = Scattering::RoughGlass { ior, alpha, reflection_tint, transmission_tint };
            cases.push(Case::new(format!("rough glass ior {ior} alpha {alpha} {what}"), scattering, false));
        }
    }
    let smooth = Scattering::RoughGlass { ior: 1.5, alpha: 0.0, reflection_tint: one, transmission_tint: one };
    cases.push(Case::new("rough glass that is smooth", smooth, true));
    let mtl =
        |diffuse, specular, alpha, transmission, ior| Scattering::Mtl { diffuse, specular, alpha, transmission, ior };
    let (some, blue) = (rgb(0.3, 0.2, 0.1), rgb(0.1, 0.1, 0.6));
    for (name, scattering, lossless) in [
        ("diffuse", mtl(one, black, 0.0, black, 1.0), true),
        ("mirror", mtl(black, one, 0.0, black, 1.0), true),
        ("plastic", mtl(some, Spectrum::splat(0.3), 0.1, black, 1.0), false),
        ("polished", mtl(some, Spectrum::splat(0.3), 0.0, black, 1.5), false),
        ("glass", mtl(black, black, 0.0, one, 1.5), true),
        ("all, glossy", mtl(some, blue, 0.4, rgb(0.2, 0.3, 0.1), 1.3), false),
        ("all, mirror", mtl(some, blue, 0.0, rgb(0.2, 0.3, 0.1), 1.3), false),
        ("too much", mtl(Spectrum::splat(0.9), one, 0.0, rgb(1.0, 0.5, 0.2), 1.7), true),
        ("black", mtl(black, black, 0.3, black, 1.0), false),
    ] {
        cases.push(Case::new(format!("mtl {name}"), scattering, lossless));
    }
    for (exponent, form, lossless) in [
        (20.0, GrooveForm::Reciprocal, false),
        (0.0, GrooveForm::Reciprocal, false),
        (3.0, GrooveForm::Normalised, true),
        (1e9, GrooveForm::Normalised, true),
    ] {
        let scattering = Scattering::BrushedMetal { reflectance: one, exponent, form };
        cases.push(Case::new(format!("brushed metal {exponent} {}", form.name()), scattering, lossless));
    }
    phong_cases(&mut cases);
    principled_cases(&mut cases);
    cases.push(Case::new("black", Scattering::Black, false));
    cases
}

fn phong_cases(cases: &mut Vec<Case>) {
    let black = Spectrum::BLACK;
    let lobes = |kd, ks, k, td, ts, kt, ior| {
        Scattering::Phong(PhongLobes {
            diffuse: kd,
            specular: ks,
            exponent: k,
            diffuse_transmission: td,
            transmission: ts,
            transmission_exponent: kt,
            ior,
        })
    };
    let (some, blue, green) = (rgb(0.3, 0.2, 0.1), rgb(0.1, 0.1, 0.6), rgb(0.2, 0.3, 0.1));
    let (one, half) = (Spectrum::ONE, Spectrum::splat(0.5));
    for (name, scattering, lossless) in [
        ("diffuse", lobes(half, black, 20.0, half, black, 20.0, 1.0), true),
        ("glossy 20", lobes(black, one, 20.0, black, black, 20.0, 1.0), false),
        ("glossy 0", lobes(some, blue, 0.0, black, black, 0.0, 1.0), false),
        ("glossy 900", lobes(some, blue, 900.0, black, black, 0.0, 1.0), false),
        ("mirror", lobes(some, rgb(0.7, 0.8, 0.9), 1000.0, black, black, 0.0, 1.0), true),
        ("clear", lobes(black, black, 0.0, black, one, 1e9, 1.5), true),
        ("dragon", lobes(Spectrum::splat(0.1), black, 0.0, black, Spectrum::splat(0.9), 1000.0, 1.5), true),
        ("straight", lobes(black, black, 0.0, black, one, 30.0, 1.0), false),
        ("frosted 40", lobes(black, black, 0.0, black, one, 40.0, 1.5), false),
        ("frosted 5, inverse", lobes(black, black, 0.0, green, blue, 5.0, 0.7), false),
        ("all", lobes(some, blue, 15.0, green, rgb(0.3, 0.1, 0.2), 60.0, 1.3), false),
        ("all, specular", lobes(some, blue, 2000.0, green, rgb(0.3, 0.1, 0.2), 2000.0, 1.3), false),
        ("too much", lobes(one, half, 1000.0, black, half, 1000.0, 2.0), true),
        ("black", lobes(black, black, 10.0, black, black, 10.0, 1.5), false),
    ] {
        cases.push(Case::new(format!("phong {name}"), scattering, lossless));
    }
}

/// White plastic of middle roughness.
pub const PLASTIC: PrincipledParameters = PrincipledParameters {
    base_color: Spectrum::ONE,
    metallic: 0.0,
    roughness: 0.5,
    anisotropic: 0.0,
    rotation: 0.0,
    ior: 1.5,
    specular: 1.0,
    transmission: 0.0,
    coat: 0.0,
    coat_roughness: 0.4,
    sheen: Spectrum::BLACK,
    sheen_roughness: 0.5,
};

fn principled_cases(cases: &mut Vec<Case>) {
    let (one, gold) = (Spectrum::ONE, rgb(1.0, 0.8, 0.3));
    for (name, parameters) in [
        ("plastic", PLASTIC),
        ("rough plastic", PrincipledParameters { roughness: 1.0, ..PLASTIC }),
        ("polished plastic", PrincipledParameters { roughness: 0.0, base_color: gold, ..PLASTIC }),
        ("without specular", PrincipledParameters { specular: 0.0, ..PLASTIC }),
        ("metal", PrincipledParameters { metallic: 1.0, base_color: gold, ..PLASTIC }),
        ("mirror", PrincipledParameters { metallic: 1.0, roughness: 0.0, ..PLASTIC }),
        ("half metal", PrincipledParameters { metallic: 0.5, roughness: 0.3, base_color: gold, ..PLASTIC }),
        (
            "brushed metal",
            PrincipledParameters { metallic: 1.0, roughness: 0.4, anisotropic: 0.9, rotation: 0.7, ..PLASTIC },
        ),
        ("brushed plastic", PrincipledParameters { roughness: 0.6, anisotropic: 1.0, rotation: -2.0, ..PLASTIC }),
        ("coat", PrincipledParameters { coat: 1.0, coat_roughness: 0.3, base_color: gold, ..PLASTIC }),
        ("polished coat", PrincipledParameters { coat: 0.7, coat_roughness: 0.0, ..PLASTIC }),
        ("polished twice", PrincipledParameters { coat: 1.0, coat_roughness: 0.0, roughness: 0.0, ..PLASTIC }),
        ("cloth", PrincipledParameters { sheen: one, sheen_roughness: 0.3, base_color: gold, ..PLASTIC }),
        ("coated cloth", PrincipledParameters { sheen: gold, sheen_roughness: 1.0, coat: 0.5, ..PLASTIC }),
        ("clear", PrincipledParameters { transmission: 1.0, roughness: 0.0, ..PLASTIC }),
        ("frosted", PrincipledParameters { transmission: 1.0, roughness: 0.4, base_color: gold, ior: 1.3, ..PLASTIC }),
        ("inverse", PrincipledParameters { transmission: 0.8, roughness: 0.5, ior: 0.7, ..PLASTIC }),
        ("no change of index", PrincipledParameters { transmission: 0.5, ior: 1.0, roughness: 0.3, ..PLASTIC }),
        (
            "all",
            PrincipledParameters {
                base_color: gold,
                metallic: 0.3,
                roughness: 0.5,
                anisotropic: 0.5,
                rotation: 1.0,
                ior: 1.7,
                specular: 0.8,
                transmission: 0.4,
                coat: 0.6,
                coat_roughness: 0.5,
                sheen: rgb(0.1, 0.4, 0.8),
                sheen_roughness: 0.6,
            },
        ),
        (
            "all, polished",
            PrincipledParameters {
                metallic: 0.3,
                roughness: 0.0,
                transmission: 0.4,
                coat: 0.6,
                coat_roughness: 0.0,
                sheen: Spectrum::splat(0.5),
                ..PLASTIC
            },
        ),
        ("nothing", PrincipledParameters { base_color: Spectrum::BLACK, specular: 0.0, ..PLASTIC }),
    ] {
        let lossless = ["mirror", "clear", "without specular"].contains(&name);
        cases.push(Case::new(format!("principled {name}"), Scattering::Principled(parameters), lossless));
    }
}

/// Directions from the normal to grazing, on both sides.
pub fn outgoing() -> Vec<Vec3> {
    let mut directions = Vec::new();
    for (theta, phi) in [(0.0f64, 0.0), (35.0, 20.0), (62.0, 130.0), (80.0, 260.0), (88.5, 300.0)] {
        for side in [1.0, -1.0] {
            directions.push(direction(theta, phi, side));
        }
    }
    directions
}

/// A unit vector `theta` degrees from the normal, at azimuth `phi` degrees, z multiplied by `side`.
pub fn direction(theta: f64, phi: f64, side: f64) -> Vec3 {
    let ((sin, cos), (sin_phi, cos_phi)) = (theta.to_radians().sin_cos(), phi.to_radians().sin_cos());
    vec3((sin * cos_phi) as f32, (sin * sin_phi) as f32, (side * cos) as f32)
}

/// A uniform direction.
pub fn random_direction(rng: &mut Rng) -> Vec3 {
    let [x, y, z] = rng.direction();
    vec3(x as f32, y as f32, z as f32)
}

/// A direction for `bsdf`, from the generator.
pub fn draw(bsdf: &Bsdf, wo: Vec3, rng: &mut Rng) -> Option<etendue::bsdf::BsdfSample> {
    let u_lobe = rng.f32();
    bsdf.sample(wo, u_lobe, rng.f32x2())
}

#[test]
fn every_kind_has_a_case() {
    let cases = cases();
    for name in KINDS {
        assert!(cases.iter().any(|case| kind(&case.bsdf) == *name), "no case of {name}");
    }
}

#[test]
fn a_bsdf_is_small() {
    assert!(size_of::<Bsdf>() <= 128, "{} bytes", size_of::<Bsdf>());
}
