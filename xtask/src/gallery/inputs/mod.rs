//! What the scenes of the gallery need and the project makes itself.

mod canvas;
mod dragon;
mod hand;
mod mesh;
mod paper;
mod polygonise;
mod random;
mod shapes;

/// An input: its name in `gallery/inputs`, and what makes its bytes.
pub struct Input {
    pub name: &'static str,
    pub make: fn() -> Vec<u8>,
}

/// All of them.
pub const INPUTS: &[Input] =
    &[Input { name: "paper.png", make: paper::png }, Input { name: "dragon.ply.gz", make: dragon::ply_gz }];
