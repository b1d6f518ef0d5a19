//! Milliseconds to compute a sky, and a sum over its bits, for suns of several heights.
//!
//! `cargo run --release -p etendue --example sky_speed [ROUNDS]`
//!
//! The median and the fastest of so many rounds (default 20), on all processors.
#![allow(clippy::disallowed_methods)]

use etendue::{light::atmosphere::Atmosphere, spectrum::Spectrum};
use std::{hint::black_box, time::Instant};

fn main() {
    let rounds = std::env::args().nth(1).map_or(20, |text| text.parse::<usize>().expect("a number")).max(1);
    let atmosphere = Atmosphere { turbidity: 2.5, ground: Spectrum([0.2, 0.18, 0.14]) };
    for degrees in [60.0_f64, 10.0, 0.1, -5.0] {
        let mut times = Vec::new();
        let mut bits = 0_u64;
        for _ in 0..rounds {
            let clock = Instant::now();
            let daylight = black_box(atmosphere.daylight(black_box(degrees.to_radians())));
            times.push(clock.elapsed().as_secs_f64() * 1e3);
            bits = sum(daylight.sun, 0);
            let places = (0..128).flat_map(|row| (0..256).map(move |column| [row, column].map(|i| i as f32)));
            for [row, column] in places {
                bits = sum(daylight.map.lookup((column + 0.5) / 256.0, (row + 0.5) / 128.0), bits);
            }
        }
        times.sort_by(f64::total_cmp);
        println!("{degrees:5} degrees: {:.2} ms, at best {:.2}; bits {bits:016x}", times[rounds / 2], times[0]);
    }
}

/// Another number of the bits of a colour and a number.
fn sum(colour: Spectrum, start: u64) -> u64 {
    let mix = |sum: u64, c: f32| (sum ^ u64::from(c.to_bits())).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(23);
    colour.0.into_iter().fold(start, mix)
}
