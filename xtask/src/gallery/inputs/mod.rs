//! What the scenes of the gallery need and the project makes itself.

mod balloons;
mod canvas;
mod curve;
mod dragon;
mod gate;
mod hand;
mod jigsaw;
mod mesh;
mod painting;
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
    Input { name: "balloons.png", make: balloons::png },
    Input { name: "jigsaw.png", make: jigsaw::png },
    Input { name: "painting.png", make: painting::png },
    Input { name: "dragon.ply.gz", make: dragon::ply_gz },
    Input { name: "gate.ply.gz", make: gate::ply_gz },
];
