//! Numbers that look random and are the same on every machine.

/// The SplitMix64 sequence (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        mix(self.0)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform in [-1, 1).
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }
}

fn mix(z: u64) -> u64 {
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// In [-1, 1], a function of a lattice point.
fn lattice(p: [i64; 3], seed: u64) -> f64 {
    let key = p.iter().fold(seed, |h, &i| mix(h.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ i as u64));
    (key >> 11) as f64 * (2.0 / (1u64 << 53) as f64) - 1.0
}

/// Smooth value noise, in [-1, 1], features of size 1.
pub fn noise(p: [f64; 3], seed: u64) -> f64 {
    let cell = p.map(f64::floor);
    let t = [0, 1, 2].map(|i| {
        let t = p[i] - cell[i];
        t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
    });
    let corner =
        |dx: i64, dy: i64, dz: i64| lattice([cell[0] as i64 + dx, cell[1] as i64 + dy, cell[2] as i64 + dz], seed);
    let lerp = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let along_x = |dy, dz| lerp(corner(0, dy, dz), corner(1, dy, dz), t[0]);
    let plane = |dz| lerp(along_x(0, dz), along_x(1, dz), t[1]);
    lerp(plane(0), plane(1), t[2])
}

/// Sum of `octaves` noises, each twice as fine and half as strong.
pub fn fractal(p: [f64; 3], octaves: u32, seed: u64) -> f64 {
    (0..octaves)
        .map(|i| {
            let scale = f64::from(1 << i);
            noise(p.map(|x| x * scale), seed.wrapping_add(u64::from(i))) / scale
        })
        .sum()
}
