//! What the scenes of the gallery need and the project makes itself.

mod canvas;
mod dragon;
mod gate;
mod hand;
mod mesh;
mod paper;
mod polygonise;
mod random;
mod shapes;
mod solids;

/// An input: its name in `gallery/inputs`, and what makes its bytes.
pub struct Input {
    pub name: &'static str,
    pub make: fn() -> Vec<u8>,
}

/// All of them.
pub const INPUTS: &[Input] = &[
    Input { name: "paper.png", make: paper::png },
    Input { name: "dragon.ply.gz", make: dragon::ply_gz },
    Input { name: "gate.ply.gz", make: gate::ply_gz },
];
