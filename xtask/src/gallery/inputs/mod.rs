//! What the scenes of the gallery need and the project makes itself.

mod canvas;
mod hand;
mod paper;
mod random;

/// An input: its name in `gallery/inputs`, and what makes its bytes.
pub struct Input {
    pub name: &'static str,
    pub make: fn() -> Vec<u8>,
}

/// All of them.
pub const INPUTS: &[Input] = &[Input { name: "paper.png", make: paper::png }];
