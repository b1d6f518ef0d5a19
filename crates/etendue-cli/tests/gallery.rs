//! The scenes of the gallery show what the paper's figures show where those show it: points of the world that were measured in the
//! paper's pictures, edges and highlights of rendered ones.
#![allow(clippy::disallowed_methods, reason = "tests are not compared bit by bit")]

mod common;

use common::Folder;
use etendue::{
    camera::Camera,
    image::{ChannelData, Image},
    math::DVec3,
};
use etendue_scene::{Limits, SourceMap, build, read_scene};
use std::path::{Path, PathBuf};

/// Pictures may differ by this share of their width.
const TOLERANCE: f64 = 0.01;

fn scene(figure: u32) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../gallery/figure-{figure}.toml"))
}

/// Where `point` is in the picture of a figure, as shares of width and height from the upper left corner: the place whose ray
/// through the middle of the lens meets the point.
fn seen(camera: &Camera, origin: DVec3, point: DVec3) -> [f64; 2] {
    let direction = |x: f64, y: f64| camera.ray(x as f32, y as f32, [0.5, 0.5]).direction.as_dvec3();
    // Directions of the corners span the window: solve for the point's place in it.
    let (a, right, down) = (direction(0.0, 0.0), direction(SIDE, 0.0), direction(0.0, SIDE));
    let forward = direction(0.5 * SIDE, 0.5 * SIDE);
    let window = |d: DVec3| d / d.dot(forward);
    let (a, right, down) = (window(a), window(right) - window(a), window(down) - window(a));
    let d = window(point - origin) - a;
    [d.dot(right) / right.length_squared(), d.dot(down) / down.length_squared()]
}

/// Pixels along the pictures' sides, any number.
const SIDE: f64 = 1000.0;

fn camera(figure: u32) -> (Camera, DVec3) {
    let mut sources = SourceMap::new();
    let (description, found) = read_scene(&scene(figure), &mut sources, &Limits::default()).unwrap();
    let description = description.unwrap_or_else(|| panic!("figure {figure}: {found:?}"));
    let input =
        build(&description, &mut sources, &Limits::default()).unwrap_or_else(|e| panic!("figure {figure}: {e:?}"));
    assert_eq!(input.film.resolution[0], input.film.resolution[1], "the paper's pictures are square");
    let settings = input.camera;
    (Camera::new(&settings, [SIDE as u32; 2], DVec3::ZERO).unwrap(), settings.position)
}

/// Points and the pixels of the paper's picture of that size where they are seen.
fn check(figure: u32, size: f64, points: &[([f64; 3], [f64; 2])]) {
    let (camera, origin) = camera(figure);
    for (point, pixel) in points {
        let place = seen(&camera, origin, DVec3::from_array(*point));
        let off = [0, 1].map(|i| (place[i] - pixel[i] / size).abs());
        let is = place.map(|x| x * size);
        assert!(off.iter().all(|off| *off <= TOLERANCE), "figure {figure}: {point:?} is seen at {is:?}, not {pixel:?}");
    }
}

/// The box's corners at the back, of the open front, and of the lamp.
fn check_box(figure: u32) {
    let (near, far) = (142.2, 497.8);
    check(
        figure,
        640.0,
        &[
            ([-1.0, -1.0, 1.0], [near, near]),
            ([-1.0, 1.0, -1.0], [far, far]),
            ([1.0, -1.0, -1.0], [0.0, 640.0]),
            ([1.0, 1.0, 1.0], [640.0, 0.0]),
            ([0.3, -0.25, 0.999], [257.0, 70.0]),
            ([-0.3, 0.25, 0.999], [373.0, 110.0]),
        ],
    );
}

#[test]
fn figure_1_stands_where_the_papers_does() {
    let points = [
        // The letters in focus, the paper's far edge, circles of the sketch.
        ([-1.45, -0.88, 0.0], [230.0, 645.0]),
        ([15.8, 3.2, 0.0], [625.0, 0.0]),
        ([16.2, -0.4, 0.0], [799.0, 50.0]),
        ([-0.48, -2.09, 0.0], [460.0, 645.0]),
        ([1.52, -3.82, 0.0], [777.0, 594.0]),
    ];
    check(1, 800.0, &points);
}

#[test]
fn figures_of_the_box_stand_where_the_papers_do() {
    for figure in [3, 4, 6] {
        check_box(figure);
    }
    let (left, neck) = (([0.1, -0.5, -0.7], [201.5, 485.5]), ([0.0, 0.0, -1.0], [320.0, 548.0]));
    check(3, 640.0, &[left, neck, ([-0.25, 0.5, -0.7], [426.0, 468.5])]);
    check(4, 640.0, &[left, ([-0.37, 0.6, -0.7], [443.5, 464.5])]);
    check(6, 400.0, &[([-0.25, 0.5, -0.7], [265.5, 293.0])]);
}

#[test]
fn figures_7_and_8_stand_where_the_papers_do() {
    let rims = [([16.0, 3.08, 0.0], [505.0, 0.0]), ([16.0, -0.42, 0.0], [640.0, 42.0]), ([5.26, 9.0, 0.0], [0.0, 8.0])];
    check(7, 640.0, &rims);
    check(7, 640.0, &[([0.3, 0.3, 0.0], [205.0, 350.0])]);
    check(8, 640.0, &[([0.3, 0.3, 0.0], [333.0, 385.0])]);
}

/// Renders part of a figure at 320 pixels.
fn render(figure: u32, crop: [u32; 4], spp: u32) -> Image {
    let folder = Folder::new();
    let crop = crop.map(|x| x.to_string()).join(",");
    let words =
        format!("render {} --size 320x320 --crop {crop} --spp {spp} --quiet -o crop.pfm", scene(figure).display());
    folder.run(&words).with_code(0);
    folder.image("crop.pfm")
}

fn pixel(image: &Image, x: u32, y: u32) -> [f64; 3] {
    ["R", "G", "B"].map(|name| {
        let channel = image.channels.iter().find(|c| c.name == name).unwrap();
        let ChannelData::F32(values) = &channel.data else { panic!("PFM files are of f32") };
        f64::from(values[(y * image.width + x) as usize])
    })
}

#[test]
fn the_corner_of_the_room_is_seen_where_the_papers_is() {
    // A few rows across the left wall and the back wall: green on the one, pale on the other.
    let image = render(4, [40, 150, 104, 158], 16);
    let green = |x: u32| {
        let sum = (0..image.height).map(|y| pixel(&image, x, y)).fold([0.0; 2], |s, p| [s[0] + p[0], s[1] + p[1]]);
        sum[1] / sum[0]
    };
    let steepest =
        (1..image.width - 1).max_by(|&a, &b| (green(a - 1) - green(a + 1)).total_cmp(&(green(b - 1) - green(b + 1))));
    let edge = (f64::from(40 + steepest.unwrap()) + 0.5) / 320.0;
    assert!((edge - 0.222).abs() <= TOLERANCE, "the corner is at {edge} of the width");
}

#[test]
fn the_hourglass_of_figure_3_has_its_neck_where_the_papers_has() {
    const TOP: u32 = 256;
    let image = render(3, [130, TOP, 190, 312], 24);
    // Pixels of each three rows that shine brighter than the floor beside the hourglass.
    let bright = |y: u32| (0..image.width).filter(|&x| pixel(&image, x, y)[1] > 0.05).count();
    let widths: Vec<usize> = (1..image.height - 1).map(|y| (y - 1..=y + 1).map(bright).sum()).collect();
    let neck = (0..widths.len()).min_by_key(|&i| widths[i]).unwrap();
    let row = f64::from(TOP + 1 + neck as u32) + 0.5;
    assert!((row / 320.0 - 548.0 / 640.0).abs() <= TOLERANCE, "the neck is in row {row} of 320: {widths:?}");
    let [far, near] = [widths[0], widths[widths.len() - 1]];
    assert!(far > 2 * widths[neck] && near > 3 * widths[neck], "{widths:?}");
}
