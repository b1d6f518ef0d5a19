//! Textures that are computed: their range, their bits, and that a filtered value is the mean over the footprint.
#![allow(clippy::disallowed_methods, reason = "references are computed with the platform's functions")]

use etendue::{
    math::{Vec2, Vec3, vec2, vec3},
    spectrum::Spectrum,
    texture::{
        Channel, Coordinates, Footprint, Gradient, Lookup, Mapping, Marble, Noise, Pattern, Procedure, Stop, Texture,
        UvTransform, Wood,
    },
};
use etendue_testkit::Rng;

const COORDINATES: [Coordinates; 2] =
    [Coordinates::Uv, Coordinates::Object { scale: Vec3::new(1.0, 1.3, 0.7), offset: Vec3::new(0.2, 0.0, -4.0) }];

/// From black to white.
fn grey(procedure: Procedure, coordinates: Coordinates) -> Texture {
    let colors = [Spectrum::BLACK.into(), Spectrum::ONE.into()];
    Texture::of(Pattern::Procedure { procedure, coordinates, colors })
}

/// Every procedure with its defaults, and some with others.
fn procedures() -> Vec<Procedure> {
    let mut all = Procedure::ALL.to_vec();
    all.push(Procedure::Noise(Noise { octaves: 16, roughness: 1.0, turbulence: true, seed: 7 }));
    all.push(Procedure::Noise(Noise { octaves: 1, roughness: 0.0, turbulence: false, seed: u32::MAX }));
    all.push(Procedure::Wood(Wood { axis: Vec3::X, distortion: 100.0, seed: 3 }));
    all.push(Procedure::Marble(Marble { axis: vec3(0.6, 0.0, 0.8), distortion: 0.0, seed: 3 }));
    all
}

/// A point of both kinds of coordinates.
fn at(x: f32, y: f32, z: f32) -> Lookup {
    Lookup::new(vec2(x, y), vec3(x, y, z))
}

#[test]
fn values_are_in_range_whatever_the_point() {
    let mut rng = Rng::new(1);
    let extremes = [0.0, -0.0, f32::MAX, f32::MIN, f32::INFINITY, f32::NAN, 1e-40, 16_777_217.0, -1e9, 1e20, 0.5];
    for procedure in procedures() {
        for coordinates in COORDINATES {
            let texture = grey(procedure, coordinates);
            assert_eq!(texture.range(), [0.0, 1.0]);
            let (mut low, mut high) = (1.0f32, 0.0f32);
            for i in 0..6000 {
                let mut number = || match rng.f32() {
                    x if i % 3 == 0 => extremes[(x * 11.0) as usize],
                    x => (x - 0.5) * 40.0,
                };
                let mut lookup = at(number(), number(), number());
                if i % 2 == 0 {
                    lookup.footprint = Footprint {
                        uv: [vec2(number(), number()), vec2(number(), number())],
                        position: [vec3(number(), number(), number()), vec3(number(), number(), number())],
                    };
                }
                let value = texture.number(&lookup);
                assert!((0.0..=1.0).contains(&value), "{procedure:?} {coordinates:?} at {lookup:?}: {value}");
                (low, high) = (low.min(value), high.max(value));
            }
            assert!(high - low > 0.4, "{procedure:?} {coordinates:?}: only from {low} to {high}");
        }
    }
}

/// The bits are those of every machine: a hash of a grid of values.
#[test]
fn values_have_the_same_bits_everywhere() {
    let mut found = Vec::new();
    for procedure in Procedure::ALL {
        let mut hash = 0xcbf2_9ce4_8422_2325u64;
        for coordinates in COORDINATES {
            let texture = grey(procedure, coordinates);
            for i in 0..4096 {
                let [x, y, z] = [i % 16, i / 16 % 16, i / 256].map(|c| c as f32 * 0.37 - 2.0);
                let mut lookup = at(x, y, z);
                if i % 3 == 0 {
                    let width = 0.1 + 0.05 * (i % 7) as f32;
                    lookup.footprint = Footprint {
                        uv: [vec2(width, 0.02), vec2(0.0, 0.5 * width)],
                        position: [vec3(width, 0.0, 0.01), vec3(0.0, 0.3, width)],
                    };
                }
                for byte in texture.number(&lookup).to_bits().to_le_bytes() {
                    hash = (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
                }
            }
        }
        found.push((procedure.name(), hash));
    }
    assert_eq!(found, EXPECTED);
}

const EXPECTED: [(&str, u64); 5] = [
    ("checker", 11_289_610_451_594_347_648),
    ("grid", 1_194_872_999_328_335_674),
    ("noise", 12_311_052_763_163_900_802),
    ("wood", 14_253_458_136_162_954_150),
    ("marble", 12_205_598_332_345_081_208),
];

/// Means over boxes of texture coordinates or space, and what a filtered lookup gives.
struct Comparison {
    /// Root mean square of the difference.
    error: f64,
    /// Root mean square of the difference of an unfiltered lookup.
    unfiltered: f64,
}

/// Boxes of these sides along x and y (and z of space) about random points.
fn compare(texture: &Texture, sides: [f32; 3], boxes: usize) -> Comparison {
    let mut rng = Rng::new(11);
    let (mut error, mut unfiltered) = (0.0, 0.0);
    for _ in 0..boxes {
        let middle = [rng.f32(), rng.f32(), rng.f32()].map(|x| x * 20.0 - 10.0);
        let mut sum = 0.0;
        let mut count = 0.0;
        let (n, depth) = if sides[2] > 0.0 { (12, 12) } else { (40, 1) };
        for i in 0..n * n * depth {
            let place = [i % n, i / n % n, i / n / n];
            let [x, y, z] = [0, 1, 2].map(|c| {
                let offset = if c == 2 && depth == 1 { 0.0 } else { (place[c] as f32 + rng.f32()) / n as f32 - 0.5 };
                middle[c] + offset * sides[c]
            });
            sum += f64::from(texture.number(&at(x, y, z)));
            count += 1.0;
        }
        let [x, y, z] = middle;
        let point = at(x, y, z);
        let footprint = Footprint {
            uv: [vec2(sides[0], 0.0), vec2(0.0, sides[1])],
            position: [vec3(sides[0], 0.0, 0.0), vec3(0.0, sides[1], sides[2])],
        };
        let filtered = f64::from(texture.number(&Lookup { footprint, ..point }));
        error += (filtered - sum / count).powi(2);
        unfiltered += (f64::from(texture.number(&point)) - sum / count).powi(2);
    }
    let root = |sum: f64| (sum / boxes as f64).sqrt();
    Comparison { error: root(error), unfiltered: root(unfiltered) }
}

/// Checker and grid are exact means over axis-aligned boxes, up to the noise of the reference.
#[test]
fn cells_are_means_over_boxes() {
    for (procedure, tolerance) in [(Procedure::ALL[0], 0.02), (Procedure::ALL[1], 0.02)] {
        let texture = grey(procedure, Coordinates::Uv);
        for sides in [[0.3, 0.3, 0.0], [1.7, 0.2, 0.0], [3.1, 5.3, 0.0]] {
            let Comparison { error, unfiltered } = compare(&texture, sides, 300);
            assert!(error < tolerance, "{procedure:?} {sides:?}: {error}");
            assert!(unfiltered > 4.0 * error, "{procedure:?} {sides:?}: {error}, unfiltered {unfiltered}");
        }
        let solid = grey(procedure, Coordinates::Object { scale: Vec3::ONE, offset: Vec3::ZERO });
        let Comparison { error, .. } = compare(&solid, [0.6, 0.0, 0.0], 300);
        assert!(error < 0.03, "solid {procedure:?}: {error}");
    }
}

/// What is left of the rest is nearer to the mean than the value at a point is: by how much.
#[test]
fn the_rest_is_near_its_mean() {
    for (procedure, ratios) in [
        (Procedure::Noise(Noise { octaves: 1, ..Noise::DEFAULT }), [0.65, 0.55, 0.4]),
        (Procedure::Noise(Noise::DEFAULT), [0.65, 0.55, 0.4]),
        (Procedure::Noise(Noise { turbulence: true, ..Noise::DEFAULT }), [0.65, 0.55, 0.4]),
        (Procedure::Wood(Wood::DEFAULT), [0.65, 0.55, 0.4]),
        (Procedure::Marble(Marble::DEFAULT), [0.65, 0.55, 0.4]),
    ] {
        let texture = grey(procedure, Coordinates::Object { scale: Vec3::ONE, offset: Vec3::splat(0.5) });
        for (side, ratio) in [0.5, 1.0, 3.0].into_iter().zip(ratios) {
            let Comparison { error, unfiltered } = compare(&texture, [side, side, 0.0], 120);
            println!("{procedure:?} {side}: {error:.4} of {unfiltered:.4}, {:.2}", error / unfiltered);
            assert!(error < ratio * unfiltered, "{procedure:?} {side}: {error} of {unfiltered}");
        }
    }
}

fn gradient(radial: bool) -> Gradient {
    let stop = |at, grey| Stop { at, color: Spectrum::splat(grey) };
    Gradient {
        coordinates: Coordinates::Uv,
        from: vec3(1.0, 2.0, 0.0),
        to: vec3(4.0, 6.0, 0.0),
        radial,
        stops: [stop(0.1, 0.2), stop(0.5, 1.0), stop(0.5, 0.0), stop(0.9, 0.7)].into(),
    }
}

#[test]
fn gradients_go_through_their_stops() {
    let linear = Texture::of(Pattern::Gradient(gradient(false)));
    assert_eq!(linear.range(), [0.0, 1.0]);
    // Along (3, 4) / 5, whatever the distance from the line.
    let along = |t: f32| vec2(1.0, 2.0) + vec2(3.0, 4.0) * t + vec2(-4.0, 3.0) * 0.7;
    let about = |t: f32| vec2(1.0, 2.0) + vec2(-4.0, 3.0) * t;
    let radial = Texture::of(Pattern::Gradient(gradient(true)));
    for (t, value) in [(-3.0, 0.2), (0.1, 0.2), (0.3, 0.6), (0.51, 0.0175), (0.7, 0.35), (0.9, 0.7), (55.0, 0.7)] {
        assert!((linear.number(&along(t).into()) - value).abs() < 1e-3, "{t}");
        if t > 0.0 {
            assert!((radial.number(&about(t).into()) - value).abs() < 1e-3, "radial {t}");
        }
    }
    // The mean over the whole is that of trapezia: 0.1 * 0.2 + 0.4 * 0.6 + 0.4 * 0.35 + 0.1 * 0.7.
    let whole = Footprint { uv: [vec2(3.0, 4.0), Vec2::ZERO], ..Footprint::default() };
    let mean = linear.number(&Lookup { footprint: whole, ..along(0.5).into() });
    assert!((mean - 0.47).abs() < 1e-4, "{mean}");
    for texture in [linear, radial] {
        let Comparison { error, unfiltered } = compare(&texture, [2.0, 1.5, 0.0], 300);
        assert!(error < 0.06 && error < 0.7 * unfiltered, "{error} of {unfiltered}");
    }
}

#[test]
fn mixtures_and_products() {
    let checker = std::sync::Arc::new(grey(Procedure::ALL[0], Coordinates::Uv));
    let of = |texture: &std::sync::Arc<Texture>, factor: f32| etendue::material::Color {
        factor: Spectrum::splat(factor),
        texture: Some(texture.clone()),
    };
    let (black, white): (Vec2, Vec2) = (vec2(0.5, 0.5), vec2(1.5, 0.5));
    let weight = etendue::material::Number { factor: 3.0, texture: Some(checker.clone()) };
    let mix = Texture::of(Pattern::Mix { colors: [Spectrum([0.1, 0.2, 0.3]).into(), of(&checker, 2.0)], weight });
    assert_eq!(mix.color(&black.into()), Spectrum([0.1, 0.2, 0.3]));
    assert_eq!(mix.color(&white.into()), Spectrum::splat(2.0), "a weight beyond 1 is 1");
    assert_eq!(mix.range(), [0.0, 2.0]);
    let product = Texture::of(Pattern::Multiply([of(&checker, 2.0), Spectrum([0.5, 1.0, 0.0]).into()]));
    assert_eq!(product.color(&white.into()), Spectrum([1.0, 2.0, 0.0]));
    assert_eq!((product.color(&black.into()), product.range()), (Spectrum::BLACK, [0.0, 2.0]));
    let own = Texture::of(Pattern::VertexColor);
    let coloured = Lookup { color: [0.1, 0.2, 0.3, 0.4], ..black.into() };
    assert_eq!(own.color(&coloured), Spectrum([0.1, 0.2, 0.3]));
    let opacity = Texture { mapping: Mapping { channel: Channel::Alpha, ..own.mapping }, ..own };
    assert_eq!(opacity.number(&coloured), 0.4);
    // Transforms of texture coordinates count for procedures as for images.
    let turned = Mapping { transform: UvTransform::new([2.0, 1.0], 0.0, [1.0, 0.0]), ..Mapping::default() };
    let turned = Texture { mapping: turned, ..(*checker).clone() };
    assert_eq!([turned.number(&vec2(0.2, 0.5).into()), turned.number(&vec2(0.7, 0.5).into())], [1.0, 0.0]);
}
