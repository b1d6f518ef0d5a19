//! The table of metals against the measurements that it is interpolated from.

#![allow(clippy::approx_constant)] // measured values that happen to look like pi

use etendue::{
    bsdf::{fresnel, metals},
    spectrum::Spectrum,
};

/// Rows of the source tables on both sides of 450, 550 and 650 nm: wavelength in micrometres, n, k.
type Rows = [[f64; 3]; 6];

const MEASURED: [(&str, Rows); 10] = [
    (
        "silver",
        [
            [0.4305, 0.04, 2.462],
            [0.4509, 0.04, 2.657],
            [0.5486, 0.06, 3.586],
            [0.5821, 0.05, 3.858],
            [0.6168, 0.06, 4.152],
            [0.6595, 0.05, 4.483],
        ],
    ),
    (
        "gold",
        [
            [0.4305, 1.45, 1.948],
            [0.4509, 1.38, 1.914],
            [0.5486, 0.43, 2.455],
            [0.5821, 0.29, 2.863],
            [0.6168, 0.21, 3.272],
            [0.6595, 0.14, 3.697],
        ],
    ),
    (
        "copper",
        [
            [0.4305, 1.25, 2.305],
            [0.4509, 1.24, 2.397],
            [0.5486, 1.02, 2.577],
            [0.5821, 0.7, 2.704],
            [0.6168, 0.3, 3.205],
            [0.6595, 0.22, 3.747],
        ],
    ),
    (
        "aluminium",
        [
            [0.4428, 0.6079, 5.3676],
            [0.47687, 0.7278, 5.7781],
            [0.5166, 0.8734, 6.2418],
            [0.56357, 1.0728, 6.7839],
            [0.61993, 1.366, 7.4052],
            [0.65225, 1.5724, 7.7354],
        ],
    ),
    (
        "iron",
        [
            [0.431, 2.48, 2.71],
            [0.451, 2.59, 2.77],
            [0.549, 2.95, 2.93],
            [0.582, 2.94, 2.99],
            [0.617, 2.88, 3.05],
            [0.659, 2.92, 3.1],
        ],
    ),
    (
        "chromium",
        [
            [0.431, 2.19, 3.04],
            [0.451, 2.33, 3.14],
            [0.549, 3.18, 3.33],
            [0.582, 3.22, 3.3],
            [0.617, 3.17, 3.3],
            [0.659, 3.09, 3.34],
        ],
    ),
    (
        "titanium",
        [
            [0.431, 2.21, 3.01],
            [0.451, 2.27, 3.04],
            [0.549, 2.54, 3.43],
            [0.582, 2.6, 3.58],
            [0.617, 2.67, 3.72],
            [0.659, 2.76, 3.84],
        ],
    ),
    (
        "nickel",
        [
            [0.431, 1.71, 2.82],
            [0.451, 1.73, 2.95],
            [0.549, 1.92, 3.61],
            [0.582, 1.96, 3.8],
            [0.617, 1.99, 4.02],
            [0.659, 1.99, 4.26],
        ],
    ),
    (
        "cobalt",
        [
            [0.431, 1.67, 3.17],
            [0.451, 1.74, 3.28],
            [0.549, 2.05, 3.82],
            [0.582, 2.13, 3.96],
            [0.617, 2.19, 4.11],
            [0.659, 2.25, 4.27],
        ],
    ),
    (
        "palladium",
        [
            [0.431, 1.37, 3.14],
            [0.451, 1.41, 3.26],
            [0.549, 1.64, 3.84],
            [0.582, 1.68, 4.02],
            [0.617, 1.75, 4.21],
            [0.659, 1.8, 4.42],
        ],
    ),
];

fn interpolated(rows: &Rows, channel: usize, column: usize) -> f64 {
    let wavelength = [0.65, 0.55, 0.45][channel];
    let [a, b] = [rows[4 - 2 * channel], rows[5 - 2 * channel]];
    assert!(a[0] <= wavelength && wavelength <= b[0]);
    a[column] + (b[column] - a[column]) * (wavelength - a[0]) / (b[0] - a[0])
}

#[test]
fn the_table_is_what_was_measured() {
    assert_eq!(metals::names().collect::<Vec<_>>(), MEASURED.map(|(name, _)| name));
    for (name, rows) in MEASURED {
        let metal = metals::find(name).unwrap();
        for channel in 0..3 {
            assert!((f64::from(metal.eta[channel]) - interpolated(&rows, channel, 1)).abs() < 1e-4, "{name} n");
            assert!((f64::from(metal.k[channel]) - interpolated(&rows, channel, 2)).abs() < 1e-4, "{name} k");
        }
    }
}

#[test]
fn names_are_found_in_any_spelling() {
    assert_eq!(metals::find("Gold"), metals::find("Au"));
    assert_eq!(metals::find("aluminum").unwrap().name, "aluminium");
    assert_eq!(metals::find("unobtainium"), None);
    for name in metals::names() {
        assert_eq!(metals::find(name).unwrap().name, name);
    }
}

/// The colours that everybody knows: gold and copper are warm, silver and aluminium bright and neutral.
#[test]
fn the_metals_have_their_colours() {
    let seen = |name: &str| -> Spectrum {
        let metal = metals::find(name).unwrap();
        fresnel::conductor(1.0, metal.eta, metal.k)
    };
    for name in ["gold", "copper"] {
        let [r, g, b] = seen(name).0;
        assert!(r > 0.9 && r > g + 0.1 && g > b + 0.05, "{name} {r} {g} {b}");
    }
    for name in ["silver", "aluminium"] {
        let color = seen(name);
        assert!(
            color.min_component() > 0.88 && color.max_component() - color.min_component() < 0.05,
            "{name} {color:?}"
        );
    }
}
