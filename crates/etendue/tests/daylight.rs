#![allow(clippy::disallowed_methods)]
use etendue::light::atmosphere::{Atmosphere, EFFICACY};
use etendue::spectrum::Spectrum;
fn lum(c: Spectrum) -> f64 {
    EFFICACY * (0.2126 * f64::from(c[0]) + 0.7152 * f64::from(c[1]) + 0.0722 * f64::from(c[2]))
}
fn xy(c: Spectrum) -> [f64; 2] {
    let [r, g, b] = c.0.map(f64::from);
    let x = 0.4124564 * r + 0.3575761 * g + 0.1804375 * b;
    let y = 0.2126729 * r + 0.7151522 * g + 0.0721750 * b;
    let z = 0.0193339 * r + 0.1191920 * g + 0.9503041 * b;
    [x / (x + y + z), y / (x + y + z)]
}
#[test]
fn explore() {
    for turbidity in [1.0, 2.0, 3.0, 6.0, 10.0] {
        for e in [90.0f64, 60.0, 30.0, 10.0, 3.0, 0.0, -3.0, -6.0, -12.0, -18.0, -30.0] {
            let t = std::time::Instant::now();
            let d = Atmosphere { turbidity, ground: Spectrum::splat(0.2) }.daylight(e.to_radians());
            let dt = t.elapsed();
            let [w, h] = d.map.size();
            let mut dif = 0.0;
            for row in 0..h / 2 {
                for col in 0..w {
                    let el = std::f64::consts::FRAC_PI_2 - std::f64::consts::PI * (f64::from(row) + 0.5) / f64::from(h);
                    dif += lum(d.map.lookup((col as f32 + 0.5) / w as f32, (row as f32 + 0.5) / h as f32))
                        * el.sin()
                        * el.cos()
                        * 2.0
                        * std::f64::consts::PI
                        / f64::from(w)
                        * std::f64::consts::PI
                        / f64::from(h);
                }
            }
            let zen = d.map.lookup(0.5, 0.0);
            let hor = d.map.lookup(0.0, 0.495);
            let anti = d.map.lookup(0.5, 0.48);
            println!(
                "T {turbidity} e {e:5} sun {:8.0} lx {:?} dif {:7.1} lx zenith {:8.3} {:?} hor opp {:8.2} {:?} hor sun {:8.2} {:?} {dt:?}",
                lum(d.sun),
                xy(d.sun).map(|v| (v * 1e3).round() / 1e3),
                dif,
                lum(zen),
                xy(zen).map(|v| (v * 1e3).round() / 1e3),
                lum(hor),
                xy(hor).map(|v| (v * 1e3).round() / 1e3),
                lum(anti),
                xy(anti).map(|v| (v * 1e3).round() / 1e3)
            );
        }
    }
}
