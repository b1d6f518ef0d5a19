//! Ground and light of an automatic scene: a pale ground that runs into the horizon, a soft sky, a large lamp from the upper
//! left.

use super::{survey::Survey, view::Stand};
use crate::write_toml::{number, numbers, rounded, rounded_vector, vector};
use etendue::image::Image;
use glam::DVec3;
use std::f64::consts::PI;

/// Albedo of the ground.
const GROUND: f64 = 0.5;
/// How far the ground reaches, and how far below the model it lies, in diagonals of the model.
const GROUND_REACH: f64 = 300.0;
const GROUND_GAP: f64 = 1e-4;
/// Radiance of the sky above.
const SKY: [f64; 3] = [0.44, 0.45, 0.47];
/// The lamp: its side and its distance in diagonals of the model, its irradiance at the model's middle.
const LAMP_SIDE: f64 = 1.2;
const LAMP_DISTANCE: f64 = 2.6;
const LAMP: [f64; 3] = [3.1, 3.0, 2.85];

/// Radiance at the horizon such that the ground far away, which only the sky lights, has the same: a seam that cannot be seen.
///
/// A sky that is linear in the sine of the elevation, from h at the horizon to t above, gives the ground the irradiance
/// pi (h + 2 t) / 3, of which it sends back h = a (h + 2 t) / 3.
fn horizon(top: f64) -> f64 {
    2.0 * GROUND * top / (3.0 - GROUND)
}

/// `[environment]`.
pub fn sky(ground: bool) -> String {
    let digits = |x: f64| libm::round(x * 1e4) / 1e4;
    let horizon = SKY.map(|t| digits(horizon(t)));
    // Without a ground, what lies below the model is darker, so that its lower side shows its shape.
    let bottom = if ground { horizon } else { horizon.map(|c| digits(0.45 * c)) };
    let why = match ground {
        true => "# Soft light from all round; at the horizon as bright as the ground there, so that no edge shows.\n",
        false => "# Soft light from all round.\n",
    };
    let [top, horizon, bottom] = [SKY, horizon, bottom].map(numbers);
    format!("{why}[environment]\ntype = \"gradient\"\ntop = {top}\nhorizon = {horizon}\nbottom = {bottom}\n")
}

/// The ground's material and object.
pub fn ground(survey: &Survey) -> String {
    let size = survey.size().length();
    let center = survey.center();
    let y = survey.bounds[0].y - GROUND_GAP * size;
    let reach = GROUND_REACH * size;
    let corner = rounded_vector(DVec3::new(center.x - reach, 0.0, center.z - reach), size);
    let corner = DVec3::new(corner.x, rounded(y, GROUND_GAP * size), corner.z);
    let side = rounded(2.0 * reach, reach);
    let [u, v] = [DVec3::Z * side, DVec3::X * side].map(vector);
    format!(
        "[materials.ground]\ntype = \"diffuse\"\nreflectance = {}\n\n# Just below the lowest point of the model.\n\
         [[objects]]\nname = \"ground\"\nshape = \"rectangle\"\ncorner = {}\nu = {u}\nv = {v}\nmaterial = \"ground\"\n",
        number(GROUND),
        vector(corner)
    )
}

/// The lamp's material and object.
pub fn lamp(survey: &Survey, stand: &Stand) -> String {
    let size = survey.size().length();
    let right = stand.up.cross(stand.back).normalize();
    let above = stand.back.cross(right);
    let toward = (stand.back * 0.55 - right * 0.8 + above * 0.75).normalize();
    let center = survey.center();
    let position = rounded_vector(center + toward * (LAMP_DISTANCE * size), size);
    let target = rounded_vector(center, size);
    let side = rounded(LAMP_SIDE * size, size);
    let radiance = LAMP.map(|e| rounded(e / rectangle_solid_angle(), 10.0));
    let side = numbers([side, side]);
    format!(
        "[materials.lamp]\ntype = \"black\"\nemission = {}\n\n# A large soft lamp from the upper left.\n[[objects]]\n\
         name = \"lamp\"\nshape = \"rectangle\"\nsize = {side}\ntransform = [{{ look_at = {{ position = {}, target = {}, up = {} }} }}]\n\
         material = \"lamp\"\n",
        numbers(radiance),
        vector(position),
        vector(target),
        vector(stand.up),
    )
}

/// Solid angle of the lamp from the model's middle, as if it were small.
fn rectangle_solid_angle() -> f64 {
    (LAMP_SIDE / LAMP_DISTANCE) * (LAMP_SIDE / LAMP_DISTANCE)
}

/// Stops that bring the mean radiance in a room of grey walls, lit by the model's own emission, to what suits the eye.
pub fn own_exposure(survey: &Survey) -> f64 {
    const ALBEDO: f64 = 0.5;
    const WANTED: f64 = 0.13;
    let size = survey.size();
    let walls = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
    // The flux pi L A, spread over the walls and reflected again and again, leaves them as radiance: over pi.
    let radiance = survey.emitted / walls * ALBEDO / (1.0 - ALBEDO);
    stops(WANTED / radiance)
}

/// The exposure that multiplies by a factor, in tenths of stops.
pub fn stops(factor: f64) -> f64 {
    let stops = libm::round(10.0 * libm::log2(factor)) / 10.0;
    if stops.is_finite() { stops.clamp(-40.0, 40.0) + 0.0 } else { 0.0 }
}

/// How bright an equirectangular picture is: the irradiance of a level ground under it, divided by pi. `None` without colour.
pub fn brightness(image: &Image) -> Option<f64> {
    let channels: Vec<&[f32]> = ["R", "G", "B", "Y"].iter().filter_map(|name| image.f32_channel(name)).collect();
    if channels.is_empty() {
        return None;
    }
    let (width, height) = (image.width as usize, f64::from(image.height));
    // The cosine to the zenith, integrated over the upper half of the sphere down to a row's edge, over pi.
    let down_to = |edge: f64| libm::pow(libm::sin((edge / height * PI).min(0.5 * PI)), 2.0);
    let rows = (0..image.height as usize).map(|y| {
        let share = down_to(y as f64 + 1.0) - down_to(y as f64);
        let samples = channels.iter().flat_map(|c| &c[y * width..(y + 1) * width]);
        let sum: f64 = samples.filter(|s| s.is_finite() && **s > 0.0).map(|s| f64::from(*s)).sum();
        share * sum / (width * channels.len()) as f64
    });
    Some(rows.sum())
}
